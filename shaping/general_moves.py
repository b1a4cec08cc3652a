"""Moves from rest to rest that the half horizon or the core does not know the minimum time of."""

from __future__ import annotations

from .batches.averages import averaged_move
from .checks import finite, positive
from .closed_moves import check_move_limits
from .limits import Limits, of_one
from .optimal.long_plan import LongPlan, nearer_long_plan
from .optimal.quick_bounds import least_duration, plain_limits
from .optimal.smoothing import even_are_symmetric
from .optimal.whole.lasting import lasting
from .optimal.whole.outcome import found_plan, inside_bounds, warn_if_far
from .optimal.whole.planner import HIGHEST_ORDER, Plan, planned
from .plain_moves import Method, plain_move
from .trajectory import Trajectory, point
from .transfers.infeasible import InfeasibleError

Lasts = tuple[float | None, float | None]

_KEPT = 1e-12  # excess over a bound: rounding


def general_move(
    distance: float, limits: Limits, start: float, lasts: Lasts, method: str, rtol: float
) -> Trajectory | None:
    """Return the move of `min_time_move`; None where the half horizon or the core has it.

    Those are asked first, without the bounds that they do not know: what keeps all of them is the
    fastest. `lasts` is (duration, round_to).
    """
    distance, start = finite("distance", distance), finite("start", start)
    rtol = positive("rtol", rtol)
    n = of_one(limits).order
    states = tuple((x, *[0.0] * (n - 1)) for x in (start, start + distance))
    begin, end = (
        inside_bounds(name, state, limits)
        for name, state in zip(("start", "end"), states, strict=True)
    )
    simpler = plain_limits(limits)
    check_move_limits(simpler)
    if distance == 0.0:
        return None if limits.plain else point(start, n)
    halved = n < 4 or even_are_symmetric(simpler)
    if halved and limits.plain and method == "optimal":
        return None
    if lasts != (None, None):
        return None if n > HIGHEST_ORDER else lasting(begin, end, limits, *lasts, rtol=rtol)
    best = halved and method == "optimal"
    closed = _closed(distance, simpler, start, "optimal" if best else "closed-form")
    kept = closed.violation(limits) <= _KEPT
    if kept and (halved or method == "closed-form"):
        return closed
    if n > HIGHEST_ORDER:
        return closed if kept and limits.plain else None
    return _whole_move(begin, end, limits, rtol, closed if kept else None)


def _closed(distance: float, limits: Limits, start: float, method: Method) -> Trajectory:
    """Return the faster one of the closed form and of averages of lower orders."""
    move = plain_move(distance, limits, start, method)
    if method == "optimal" or limits.order < 4:
        return move
    other = averaged_move(distance, limits)
    if other is None or other.duration >= move.duration or other.violation(limits) > _KEPT:
        return move
    return other.shift(start)


def _whole_move(
    begin: tuple[float, ...],
    end: tuple[float, ...],
    limits: Limits,
    rtol: float,
    closed: Trajectory | None,
) -> Trajectory:
    """Return the move of the whole horizon, or the closed form where that is faster."""
    least = least_duration(end[0] - begin[0], limits)
    if closed is not None and closed.duration <= least * (1.0 + rtol):
        return closed
    try:
        plan: LongPlan | Plan | None = nearer_long_plan(begin, end, limits, rtol=rtol)
        plan = plan or found_plan(begin, end, limits, rtol=rtol)
    except InfeasibleError:
        if closed is None:
            raise
        plan = planned(begin, end, limits, rtol)
    move = plan.trajectory
    if move is None or (closed is not None and closed.duration < move.duration):
        move = closed
    assert move is not None
    warn_if_far(plan, rtol, move.duration)
    return move
