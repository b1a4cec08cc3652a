"""Moves in closed form: checked, planned in one direction, mirrored for the other."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from sys import float_info

import numpy as np

from .. import core
from .checks import finite, range_error
from .closed_form import fastest_form
from .derivatives import derivative_name
from .limits import Limits, check_both_sides, check_plain, of_one, one_sided
from .move_units import are_ordinary, in_own_units
from .pieces import MAX_MOVE_ORDER
from .rise import to_trajectory
from .trajectory import Trajectory, point, within_range

SPOILT = 1e-11  # an excess over a bound that is more than rounding


def check_kept(move: Trajectory, limits: Limits) -> None:
    """Refuse a move spoilt by rounding, which takes bounds some 15 decades apart."""
    low, high = move.states[:, 1:].min(axis=0), move.states[:, 1:].max(axis=0)
    for k, (lower, upper) in enumerate(zip(limits.lower, limits.upper, strict=True)):
        if low[k] < lower * (1.0 + SPOILT) or high[k] > upper * (1.0 + SPOILT):
            raise not_kept(k + 1)


def not_kept(derivative: int, move: str = "") -> ValueError:
    """Return the error about a limit that rounding does not let a move keep."""
    return ValueError(
        f"the {derivative_name(derivative)} limit{move} cannot be kept in double precision: the "
        "limits are too many decades apart; leave out those that never bind"
    )


def check_move_limits(limits: Limits) -> None:
    """Refuse limits under which no move from rest to rest is planned, of one or of many."""
    if limits.order > MAX_MOVE_ORDER:
        raise ValueError(
            f"limits of order {limits.order}: expected at most {MAX_MOVE_ORDER} for a move; "
            "drop the highest bounds or use perfect_spline"
        )
    check_both_sides(limits)
    check_plain(limits)


def planned(
    distance: float,
    limits: Limits,
    start: float,
    plan: Callable[[float, Limits], Trajectory],
) -> Trajectory:
    """Return a move in either direction, planned in the positive one, after checks."""
    distance, start = finite("distance", distance), finite("start", start)
    check_move_limits(of_one(limits))
    if distance == 0.0:
        return point(start, limits.order)
    forward = limits if distance > 0.0 else limits.mirror()
    _check_bounded_ahead(forward)
    move = _in_own_units(plan, abs(distance), forward)
    if distance < 0.0:
        move = move.mirror()
    return move.shift(start) if start else move


def _in_own_units(
    plan: Callable[[float, Limits], Trajectory], distance: float, limits: Limits
) -> Trajectory:
    """Return a move planned in units of its own, powers of two, where those given are extreme."""
    pairs = [(-low, high) for low, high in zip(limits.lower, limits.upper, strict=True)]
    least = [distance, *(min(pair) for pair in pairs)]
    *wide, highest = (max(pair) for pair in pairs)
    most = [distance, *(one if one < inf else 0.0 for one in wide), highest]
    if are_ordinary(least, most):
        return plan(distance, limits)
    sides = [
        (np.array(low), np.array(high))
        for low, high in zip(limits.lower, limits.upper, strict=True)
    ]
    units, own, bounds = in_own_units(np.array(distance), sides)
    within = Limits.from_bounds([(float(low), float(high)) for low, high in bounds])
    move = plan(float(own), within)
    return within_range(lambda: units.trajectory(move))


def fastest(distance: float, limits: Limits) -> Trajectory:
    """Return the fastest closed form in positive direction."""
    if limits.order <= 3:
        found = core.move(distance, limits.flat, 0.0, Trajectory, None)
        if isinstance(found, int):
            raise range_error()
        return found
    bounds = magnitudes(limits)
    if not float_info.min <= distance / bounds[-1] < inf:
        raise OverflowError
    return to_trajectory(fastest_form(distance, bounds).build())


def magnitudes(limits: Limits) -> list[float]:
    """Return one bound per derivative: velocity's forward, the smaller one of the others."""
    smaller = [min(-low, high) for low, high in zip(limits.lower, limits.upper, strict=True)]
    return [limits.upper[0], *smaller[1:]]


def _check_bounded_ahead(limits: Limits) -> None:
    """Refuse a velocity, the only one bounded, that is so in the other direction only."""
    if limits.order == 1 and not isfinite(limits.upper[0]):
        raise one_sided(limits, False, "a bound in the direction of the move")


def closed_form_move(distance: float, limits: Limits) -> Trajectory:
    """Return the fastest closed form from rest at 0 to rest, as `min_time_move` tells of it."""

    def plan(length: float, forward: Limits) -> Trajectory:
        move = within_range(lambda: fastest(length, forward))
        check_kept(move, forward)
        return move

    return planned(distance, limits, 0.0, plan)
