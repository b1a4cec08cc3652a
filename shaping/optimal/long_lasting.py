"""Motions of a given duration that are long against their ramps."""

from __future__ import annotations

import numpy as np

from ..limits import Limits
from ..rise import spline_divisor, spline_rise, to_trajectory
from ..trajectory import Trajectory
from ..transfers.infeasible import InfeasibleError
from .gentlest import gentlest_move, with_share
from .long_plan import LongPlan, long_plan, nearer_long_plan
from .proof import Numbers
from .whole.outcome import found_plan

_AT = 1e-12  # relative: a duration that is another
_RTOL = 1e-4
_NEARLY = 1e-5  # of the duration: what is left to cruise a little slower
_QUARTERS = 12
_BISECTIONS = 6
_STEPS = 30

_Problem = tuple[Numbers, Numbers, Limits]


def long_lasting(plan: LongPlan, problem: _Problem, duration: float) -> Trajectory:
    """Return a motion of a duration with about the smallest share of the highest bound.

    Raises
    ------
    InfeasibleError
        Where there is none, or none is found.
    """
    start, end, limits = problem
    fastest = plan.trajectory.duration
    if duration < plan.lower_bound:
        raise no_duration(duration, f"every one below {plan.lower_bound:.10g} is proven impossible")
    if duration < fastest * (1.0 - _AT):
        raise no_duration(duration, f"the fastest that was found takes {fastest:.10g}")
    if duration <= fastest * (1.0 + _AT):
        return plan.trajectory
    if not any((*start[1:], *end[1:])):
        return gentlest_move(
            plan.trajectory, limits, duration, lambda less: _fastest(problem, less)
        )
    return _cruising(_gentle(problem, duration), start, end, duration)


def no_duration(duration: float, reason: str) -> InfeasibleError:
    """Return the error for a duration that no motion is found of."""
    return InfeasibleError(
        f"duration = {duration!r} is none that a motion within these limits takes: {reason}; give "
        "another, or raise the limits",
        "",
        None,
    )


def _fastest(problem: _Problem, less: Limits) -> Trajectory:
    start, end, _ = problem
    found = nearer_long_plan(start, end, less, rtol=_RTOL) or found_plan(start, end, less)
    assert found.trajectory is not None
    return found.trajectory


def _gentle(problem: _Problem, duration: float) -> Limits:
    """Return the limits with the smallest share with which ramps and a cruise are quick enough."""
    low, high = 0.0, 0.0  # exponents of four
    while high > -_QUARTERS and _is_quick(problem, 4.0 ** (high - 1.0), duration):
        high -= 1.0
    low = high - 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        quick = _is_quick(problem, 4.0**middle, duration)
        low, high = (low, middle) if quick else (middle, high)
    return with_share(4.0**high, problem[2])


def _is_quick(problem: _Problem, share: float, duration: float) -> bool:
    start, end, limits = problem
    try:
        plan = long_plan(start, end, with_share(share, limits), rtol=_RTOL)
    except InfeasibleError:
        return False
    return plan is not None and plan.trajectory.duration <= duration


def _cruising(limits: Limits, start: Numbers, end: Numbers, duration: float) -> Trajectory:
    """Return ramps and a cruise at the speed that makes them last as long."""
    bound = abs(limits.bounds(1)[end[0] > start[0]])
    low, high, best = abs(end[0] - start[0]) / duration * 0.5, bound, None
    for _ in range(_STEPS):
        plan = long_plan(start, end, limits, rtol=_RTOL, speed=high)
        if plan is None or plan.trajectory.duration > duration:
            break
        best = plan.trajectory
        high = max(low, high * (best.duration / duration))
        if best.duration >= duration * (1.0 - _NEARLY):
            break
    if best is None:
        raise no_duration(duration, "none was found, which is no proof that there is none")
    return _slower(best, duration)


def _slower(motion: Trajectory, duration: float) -> Trajectory:
    """Return a motion with its cruise a little slower, so that it takes a little longer."""
    at = int(np.argmax(motion.durations))
    x, velocity = motion.states[at, :2].tolist()
    began, lasts = float(motion.breaks[at]), float(motion.durations[at])
    time, n = lasts + duration - motion.duration, motion.order
    behind = abs(velocity) * (time - lasts)
    if behind <= 0.0:
        return motion
    lag = to_trajectory(spline_rise(n, time, behind, behind * spline_divisor(n) / time**n))
    lag = lag.mirror() if velocity > 0.0 else lag
    states, end = lag.states.copy(), lag.end_state.copy()
    states[:, 0] += x + velocity * lag.breaks[:-1]
    end[0] += x + velocity * time
    states[:, 1] += velocity
    end[1] += velocity
    breaks = np.concatenate(
        [motion.breaks[:at], began + lag.breaks, motion.breaks[at + 2 :] + (time - lasts)]
    )
    breaks[-1] = duration
    return Trajectory.from_arrays(
        breaks,
        np.vstack([motion.states[:at], states, motion.states[at + 1 :]]),
        np.concatenate([motion.durations[:at], lag.durations, motion.durations[at + 1 :]]),
        motion.end_state,
        motion.coasting,
    )
