"""Motions of a given duration: by the smallest share of the highest bound, or the proof of none."""

from __future__ import annotations

from math import ceil, floor, inf, ldexp, log10

import numpy as np

from ...checks import in_range, positive
from ...limits import Limits
from ...trajectory import Trajectory, point
from ...transfers.infeasible import InfeasibleError
from ..long_lasting import long_lasting, no_duration
from ..long_plan import nearer_long_plan
from ..mesh import apart
from .least_share import gentlest, needed_share
from .outcome import found_plan, impossible
from .planner import DEFAULT_RTOL, Numbers, Plan, planned
from .problem import WholeProblem
from .repair import Repaired
from .resting import resting
from .search import Search
from .short_ramps import begun, with_less
from .warm_program import EFFORT, Effort

_SAMPLES = 20  # multiples of a sample time that are tried
_DOUBTFUL = 3  # of them below the motion found, not excluded: with more it is rounded up itself
_MUCH_LONGER = 4.0  # times the least duration: then there may be time to rest in between
_RESTING = 40.0  # times the least: gentle ramps onto rest and off it take no longer
_LITTLE = 0.05  # of the effort, within little of the highest bound
_AT = 1e-12  # relative: a duration that is another
_CLEAR = 2e-4  # relative: beyond what ends a blocked interval


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
    wanted = None if duration is None else positive("duration", duration)
    if start == end and not any(start[1:]):
        wanted = wanted or 0.0
        return point(start[0], len(start)).until(
            wanted if dt is None else _samples(wanted, dt) * dt
        )
    long = nearer_long_plan(start, end, limits, rtol=rtol)
    if long is not None:
        least = long.trajectory.duration if wanted is None else wanted
        last = least if dt is None else _samples(least, dt) * dt
        return long_lasting(long, (start, end, limits), last)
    if wanted is not None:
        wanted = wanted if dt is None else _samples(wanted, dt) * dt
        return _lasting(planned(start, end, limits, rtol), wanted, Effort.of(limits.order))
    plan = found_plan(start, end, limits, rtol=rtol)
    assert dt is not None
    return _next_multiple(plan, dt)


def next_duration(
    start: Numbers, end: Numbers, limits: Limits, duration: float, effort: Effort
) -> float:
    """Return the shortest duration found that is no less than one given; infinite where none is."""
    plan = planned(start, end, limits)
    best, time = plan.search.best, ldexp(duration, -plan.time)
    if best is None or best.time < time * (1.0 - _AT):
        best = None if plan.impossible else _next(plan, time, effort).best
    return inf if best is None else max(duration, ldexp(best.time, plan.time))


def _next_multiple(plan: Plan, dt: float) -> Trajectory:
    """Return a motion that takes the first whole number of samples that is possible."""
    assert plan.search.best is not None
    count, effort = _samples(plan.lower_bound, dt), Effort.of(plan.problem.order)
    known = _samples(ldexp(plan.search.best.time, plan.time), dt)
    count = known if known - count > _DOUBTFUL else count
    for _ in range(_SAMPLES):
        try:
            return _lasting(plan, count * dt, effort)
        except InfeasibleError:
            if effort.left <= 0.0:
                break
            later = _next(plan, ldexp(count * dt, -plan.time), effort).lower
            count = max(count + 1, _samples(ldexp(later, plan.time), dt) if later < inf else 0)
    raise InfeasibleError(
        f"round_to = {dt!r}: no multiple of it was found that is a duration of this motion; use a "
        "shorter sample time",
        "",
        None,
    )


def _samples(duration: float, dt: float) -> int:
    return in_range(lambda: ceil(duration / dt * (1.0 - 1e-14)))


def _lasting(plan: Plan, duration: float, effort: Effort) -> Trajectory:
    if plan.impossible:
        raise impossible(plan)
    time = ldexp(duration, -plan.time)
    best = plan.search.best
    if best is not None and abs(best.time / time - 1.0) <= _AT:
        found: Repaired | None = best
    else:
        if time < plan.search.lower:
            raise no_duration(
                duration, f"every one below {plan.lower_bound:.10g} is proven impossible"
            )
        found = _of_duration(plan, time, duration, effort)
    assert found is not None
    return plan.told(found)


def _of_duration(plan: Plan, time: float, duration: float, effort: Effort) -> Repaired:
    problem, best = plan.search.problem, plan.search.best
    least = plan.search.lower if best is None else best.time
    long = not problem.at_rest and (best is None or time > _MUCH_LONGER * least)
    at_most = min(time, _RESTING * least) if long else time
    with np.errstate(all="ignore"):
        tried = (_within_less(less, time, long) for less in with_less(problem, at_most))
        found = next((motion for motion in tried if motion is not None), None)
        if long:
            motions = [each for each in (found, resting(problem, time)) if each is not None]
            found = min(motions, key=lambda each: needed_share(problem, each), default=None)
    if found is not None:
        return found
    if problem.at_rest and best is not None and best.time < time:
        with np.errstate(all="ignore"):
            return gentlest(problem, plan.search.nodes, time, _slowed(best, time))
    search = _from(plan, time, effort)
    if search.lower > time * (1.0 + _AT):
        raise no_duration(
            duration, "it is proven that there is none of this one" + _later(plan, time, effort)
        )
    if search.best is None or search.best.time > time * (1.0 + _AT):
        raise no_duration(duration, "none was found, which is no proof that there is none")
    with np.errstate(all="ignore"):
        return gentlest(plan.search.problem, search.nodes, time, search.best)


def _within_less(problem: WholeProblem, time: float, long: bool) -> Repaired | None:
    """Return a gentle motion of a duration within little of the highest bound; None for none."""
    found = resting(problem, time) if long else None
    if found is not None:
        return found
    search = Search(problem, after=time)
    _look_at(search, time, Effort(_LITTLE * EFFORT))
    if search.best is None or search.best.time > time * (1.0 + _AT):
        return None
    return gentlest(problem, search.nodes, time, search.best)


def _look_at(search: Search, time: float, effort: Effort) -> None:
    """Search until it is known whether a motion takes a time, or nothing more comes of it."""
    with np.errstate(all="ignore"):
        while search.gap > _AT and search.lower <= time * (1.0 + _AT) and not search.ended:
            search.run(_AT, search.rounds + 1, effort)


def _next(plan: Plan, time: float, effort: Effort) -> Search:
    """Return a search for the first motion that takes no less than a time."""
    search = _from(plan, time, effort)
    if not search.ended:  # a round more would make its grid finer than any allowed
        with np.errstate(all="ignore"):
            search.run(DEFAULT_RTOL, effort=effort)
    return search


def _from(plan: Plan, time: float, effort: Effort) -> Search:
    """Return a search that tells whether a motion takes a time; if none, for the next that does."""
    for known in plan.search.later:
        excluded = known.after == time or known.after <= time < known.lower
        if excluded or _away(known, time) <= _AT:
            return known
    nearest = min([plan.search, *plan.search.later], key=lambda known: _away(known, time))
    nodes = np.union1d(np.linspace(0.0, 1.0, 17), nearest.nodes)
    nodes = nodes[apart(nodes, 1e-9)]
    with np.errstate(all="ignore"):
        search = begun(Search(plan.search.problem, nodes, after=time), DEFAULT_RTOL, effort)
    plan.search.later.append(search)
    _look_at(search, time, effort)
    return search


def _later(plan: Plan, time: float, effort: Effort) -> str:
    """Tell of the next duration that is possible, if one is found, rounded up to clear ground."""
    best = _next(plan, time, effort).best
    if best is None:
        return ""
    later = ldexp(best.time, plan.time) * (1.0 + _CLEAR)
    digits = 10.0 ** (3 - floor(log10(later)))
    return f", the next that was found is {ceil(later * digits) / digits:.6g}"


def _away(search: Search, time: float) -> float:
    """Return how far from a time the motion is that a search has found."""
    return inf if search.best is None else abs(search.best.time / time - 1.0)


def _slowed(motion: Repaired, time: float) -> Repaired:
    """Return a motion between rests slowed down as a whole."""
    slower = time / motion.time
    powers = slower ** np.arange(len(motion.states))
    return Repaired(motion.durations * slower, motion.states / powers[:, None], time)
