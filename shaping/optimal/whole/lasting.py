"""Motions of a given duration: by the smallest share of the highest bound, or the proof of none."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, floor, inf, ldexp, log10

import numpy as np
from numpy.typing import NDArray

from ...checks import in_range, positive
from ...limits import Limits
from ...pieces import FloatArray
from ...trajectory import Trajectory
from ...transfers.infeasible import InfeasibleError
from .maps import node_states
from .outcome import found_plan, impossible
from .planner import DEFAULT_RTOL, Numbers, Plan, planned
from .problem import WholeProblem
from .refining import refined
from .repair import Repaired, repaired
from .restriction import MARGIN, hull_rows
from .sampled import Sampled
from .search import Search
from .warm_program import Effort, WarmProgram

_SAMPLES = 20  # multiples of a sample time that are tried
_AT = 1e-12  # relative: a duration that is another
_CLEAR = 2e-4  # relative: beyond what ends a blocked interval
_ROUNDS = 5
_HARDLY = 5e-4  # of the share
_SAME = 1e-6  # of the largest input: inputs that are one


def lasting(
    start: Numbers,
    end: Numbers,
    limits: Limits,
    duration: float | None,
    round_to: float | None,
    *,
    rtol: float,
) -> Trajectory:
    """Return a motion of a duration, or of the first whole number of samples that is possible.

    Raises
    ------
    InfeasibleError
        Where there is none.
    """
    dt = None if round_to is None else positive("round_to", round_to)
    if duration is not None:
        wanted = positive("duration", duration)
        wanted = wanted if dt is None else _samples(wanted, dt) * dt
        return _lasting(planned(start, end, limits, rtol), wanted)
    plan = found_plan(start, end, limits, rtol=rtol)
    assert dt is not None
    return _next_multiple(plan, dt)


def next_duration(start: Numbers, end: Numbers, limits: Limits, duration: float) -> float:
    """Return the shortest duration found that is no less than one given; infinite where none is."""
    plan = planned(start, end, limits)
    best, time = plan.search.best, ldexp(duration, -plan.time)
    if best is None or best.time < time * (1.0 - _AT):
        best = None if plan.impossible else _next(plan, time).best
    return inf if best is None else max(duration, ldexp(best.time, plan.time))


def _next_multiple(plan: Plan, dt: float) -> Trajectory:
    """Return a motion that takes the first whole number of samples that is possible."""
    count = _samples(plan.lower_bound, dt)
    for _ in range(_SAMPLES):
        try:
            return _lasting(plan, count * dt)
        except InfeasibleError:
            later = _next(plan, ldexp(count * dt, -plan.time)).lower
            count = max(count + 1, _samples(ldexp(later, plan.time), dt) if later < inf else 0)
    raise InfeasibleError(
        f"round_to = {dt!r}: no multiple of it was found that is a duration of this motion; use a "
        "shorter sample time",
        "",
        None,
    )


def _samples(duration: float, dt: float) -> int:
    return in_range(lambda: ceil(duration / dt * (1.0 - 1e-14)))


def _lasting(plan: Plan, duration: float) -> Trajectory:
    if plan.impossible:
        raise impossible(plan)
    time = ldexp(duration, -plan.time)
    best = plan.search.best
    if best is not None and abs(best.time / time - 1.0) <= _AT:
        found: Repaired | None = best
    else:
        if time < plan.search.lower:
            raise _none(duration, f"every one below {plan.lower_bound:.10g} is proven impossible")
        found = _of_duration(plan, time, duration)
    assert found is not None
    return plan.told(found)


def _of_duration(plan: Plan, time: float, duration: float) -> Repaired:
    problem, best = plan.search.problem, plan.search.best
    if problem.at_rest and best is not None and best.time < time:
        with np.errstate(all="ignore"):
            return _gentlest(problem, plan.search.nodes, time, _slowed(best, time))
    search = _from(plan, time)
    if search.lower > time * (1.0 + _AT):
        raise _none(duration, "it is proven that there is none of this one" + _later(plan, time))
    if search.best is None or search.best.time > time * (1.0 + _AT):
        raise _none(duration, "none was found, which is no proof that there is none")
    with np.errstate(all="ignore"):
        return _gentlest(plan.search.problem, search.nodes, time, search.best)


def _next(plan: Plan, time: float) -> Search:
    """Return a search for the first motion that takes no less than a time."""
    search = _from(plan, time)
    with np.errstate(all="ignore"):
        search.run(DEFAULT_RTOL)
    return search


def _from(plan: Plan, time: float) -> Search:
    """Return a search that tells whether a motion takes a time; if none, for the next that does."""
    for known in plan.search.later:
        excluded = known.after == time or known.after <= time < known.lower
        if excluded or _away(known, time) <= _AT:
            return known
    nearest = min([plan.search, *plan.search.later], key=lambda known: _away(known, time))
    nodes = np.union1d(np.linspace(0.0, 1.0, 17), nearest.nodes)
    nodes = nodes[np.concatenate([[True], np.diff(nodes) > 1e-9])]
    search = Search(plan.search.problem, nodes, after=time)
    plan.search.later.append(search)
    effort = Effort()
    with np.errstate(all="ignore"):
        while search.gap > _AT and search.lower <= time * (1.0 + _AT) and not search.ended:
            search.run(_AT, search.rounds + 1, effort)
    return search


def _later(plan: Plan, time: float) -> str:
    """Tell of the next duration that is possible, if one is found, rounded up to clear ground."""
    best = _next(plan, time).best
    if best is None:
        return ""
    later = ldexp(best.time, plan.time) * (1.0 + _CLEAR)
    digits = 10.0 ** (3 - floor(log10(later)))
    return f", the next that was found is {ceil(later * digits) / digits:.6g}"


def _away(search: Search, time: float) -> float:
    """Return how far from a time the motion is that a search has found."""
    return inf if search.best is None else abs(search.best.time / time - 1.0)


def _none(duration: float, reason: str) -> InfeasibleError:
    return InfeasibleError(
        f"duration = {duration!r} is none that a motion within these limits takes: {reason}; give "
        "another, or raise the limits",
        "",
        None,
    )


def _gentlest(problem: WholeProblem, nodes: FloatArray, time: float, motion: Repaired) -> Repaired:
    """Return the motion with the smallest share of the highest bound; as it came if none.

    On grids refined where the input switches, until the share hardly falls.
    """
    problem = _narrowed(problem, motion)
    last = inf
    for _ in range(_ROUNDS):
        found = _with_least_share(problem, nodes, time, motion)
        if found is None:
            break
        share, inputs = found
        gentle = repaired(problem, Sampled(nodes, inputs, time))
        if gentle is None:
            break
        motion = gentle
        if share > last * (1.0 - _HARDLY):
            break
        last = share
        nodes = refined(
            nodes, _switching(problem, inputs, share * time**problem.order), None, inputs
        )
    return motion


def _slowed(motion: Repaired, time: float) -> Repaired:
    """Return a motion between rests slowed down as a whole."""
    slower = time / motion.time
    powers = slower ** np.arange(len(motion.states))
    return Repaired(motion.durations * slower, motion.states / powers[:, None], time)


def _narrowed(problem: WholeProblem, motion: Repaired) -> WholeProblem:
    """Return the problem with no more of the highest bound than a motion needs."""
    inputs = np.asarray(motion.states[-1], float)
    share = min(max(inputs.max() / problem.upper[-1], inputs.min() / problem.lower[-1]), 1.0)
    factors = np.append(np.ones(problem.order), share)
    return replace(problem, lower=problem.lower * factors, upper=problem.upper * factors)


def _switching(problem: WholeProblem, inputs: FloatArray, unit: float) -> NDArray[np.intp]:
    """Return the cells whose input is on no bound, and another than beside them."""
    same = _SAME * float(np.abs(inputs).max())
    lower, upper = problem.lower[-1] * unit, problem.upper[-1] * unit
    free = np.minimum(np.abs(inputs - lower), np.abs(inputs - upper)) > same
    apart = np.abs(np.diff(inputs)) > same
    beside = np.append(apart, False) | np.append(False, apart)
    return np.flatnonzero(free & beside)


def _with_least_share(
    problem: WholeProblem, nodes: FloatArray, time: float, motion: Repaired
) -> tuple[float, FloatArray] | None:
    """Return the smallest share of the highest bound that a motion on a grid needs, and its inputs.

    minimise s   subject to   s·lo_n ≤ x^(n) ≤ s·hi_n, all other bounds, both states
    """
    n = problem.order
    powers = time ** np.arange(n + 1)
    sizes = np.abs(np.asarray(motion.states, float)).max(axis=1) * powers
    sizes = np.maximum(sizes, 1e-9 * sizes.max())
    maps = node_states(nodes, n, 1)
    rows = hull_rows(problem, maps, nodes, sizes, MARGIN)
    of = np.concatenate([np.arange(n), rows.derivative])
    stacked = np.vstack([maps[:, -1], rows.matrix]) / sizes[of][:, None]
    count = len(nodes) - 1
    free = stacked[:, count:] @ (problem.start * powers[:n])
    lower, upper = (
        (side * powers)[of] / sizes[of] - free for side in (problem.lower, problem.upper)
    )
    tight = rows.margin / sizes[rows.derivative]
    lower[n:] += tight
    upper[n:] -= tight
    lower[:n] = upper[:n] = problem.end * powers[:n] / sizes[:n] - free[:n]
    matrix = np.hstack([stacked[:, :count] * sizes[n], np.zeros((len(of), 1))])
    shares = [
        np.hstack([sign * np.eye(count), np.full((count, 1), sign * -side * powers[n] / sizes[n])])
        for sign, side in ((1.0, problem.upper[n]), (-1.0, problem.lower[n]))
    ]
    far = np.full(count, np.inf)
    program = WarmProgram(
        np.vstack([matrix, *shares]),
        np.append(np.zeros(count), 1.0),
        np.concatenate([np.arange(len(of)) < n, np.ones(2 * count, dtype=bool)]),
    )
    optimum = program.solve(
        np.concatenate([lower, -far, -far]),
        np.concatenate([upper, np.zeros(2 * count)]),
        np.append(-far, 0.0),
        np.append(far, 1.0 - MARGIN),
    )
    if optimum is None:
        return None
    return optimum.value, optimum.columns[:count] * sizes[n]
