"""Several axes on the straight line from start to end: one motion along it, scaled to each."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from ..derivatives import derivative_name
from ..limits import Limits
from ..moves import min_time_move
from ..trajectory import Motion, Trajectory, as_trajectory
from .axes import Axis, Pair
from .transfer import min_time_transfer

_ALIKE = 1e-9  # relative difference of two axes' speeds along the line that is rounding
_SLOWEST = 1e-12  # relative difference of durations that is rounding


def straight_line(axes: Sequence[Axis]) -> tuple[Motion, ...]:
    """Return the motion along the line, as one profile from 0 to 1 scaled to each axis.

    Derivative k of axis i is R_i·s^(k), so that the bounds of s^(k) are the tightest of the
    axes' bounds over R_i.
    """
    moving = [axis for axis in axes if axis.span]
    leader = max(axes, key=lambda axis: abs(axis.span))
    alike = len({axis.order for axis in axes}) == 1
    if alike and leader.order in (2, 3) and all(axis.limits is not None for axis in axes):
        for axis in axes:
            _check_on_line(axis, leader)
        profile = _fastest_transfer(moving, leader) if moving else None
    else:
        _check_at_rest(axes)
        profile = _fastest_move(moving) if moving else None
    if profile is None:
        return tuple(axis.motion for axis in axes)
    return tuple(profile.scale(axis.span).shift(float(axis.motion.start_state[0])) for axis in axes)


def _fastest_transfer(moving: Sequence[Axis], leader: Axis) -> Trajectory:
    """Return the profile from one state to another within limits that are known."""
    begin, finish = (
        [fraction, *(state[1 : leader.order] / leader.span).tolist()]
        for fraction, state in (
            (0.0, leader.motion.start_state),
            (1.0, leader.motion.end_state),
        )
    )
    return min_time_transfer(begin, finish, Limits.from_bounds(_tightest(moving))).trajectory


def _fastest_move(moving: Sequence[Axis]) -> Trajectory:
    """Return the fastest profile from rest to rest that is known.

    It is the motion of one of the axes, slowed down as far as the others' bounds ask, or one
    planned within all bounds.
    """
    order = max(axis.order for axis in moving)
    candidates = [
        _slowed(_profile(axis), [other for other in moving if other is not axis])
        for axis in moving
        if axis.order == order
    ]
    best = min(candidates, key=lambda profile: profile.duration)
    slowest = max(axis.motion.duration for axis in moving)
    if best.duration <= slowest * (1.0 + _SLOWEST):
        return best
    bounds = [(low if low < 0.0 else -high, high) for low, high in _tightest(moving)]
    planned = _slowed(min_time_move(1.0, Limits.from_bounds(bounds)), moving)
    return min(best, planned, key=lambda profile: profile.duration)


def _profile(axis: Axis) -> Trajectory:
    """Return the motion of an axis as one from 0 to 1."""
    start = float(axis.motion.start_state[0])
    return as_trajectory(axis.motion).shift(-start).scale(1.0 / axis.span)


def _slowed(profile: Trajectory, axes: Sequence[Axis]) -> Trajectory:
    """Return a profile slowed down until it keeps the bounds of all axes."""
    factor = 1.0
    for axis in axes:
        for k, (low, high) in enumerate(axis.bounds(), start=1):
            least, most = sorted(axis.span * side for side in profile.extremes(k))
            for used, bound in ((most, high), (-least, -low)):
                if used > 0.0 and bound > 0.0:
                    factor = max(factor, (used / bound) ** (1.0 / k))
    return profile.stretch(factor) if factor > 1.0 else profile


def _tightest(moving: Sequence[Axis]) -> list[Pair]:
    """Return the bounds of the profile's derivatives."""
    bounds: list[Pair] = [(-inf, inf)] * max(axis.order for axis in moving)
    for axis in moving:
        for k, pair in enumerate(axis.bounds()):
            low, high = sorted(side / axis.span for side in pair)
            bounds[k] = max(bounds[k][0], low), min(bounds[k][1], high)
    return bounds


def _check_at_rest(axes: Sequence[Axis]) -> None:
    for axis in axes:
        if not axis.rests:
            raise ValueError(
                f"axis {axis.number} moves at its start or end: a straight line of axes whose "
                "limits are unknown, or of different orders, takes moves from rest to rest; use "
                "mode='start', or (start, end, limits) of one order, 2 or 3, for every axis"
            )


def _check_on_line(axis: Axis, leader: Axis) -> None:
    """Refuse an axis whose velocity or acceleration at an end leads off the line."""
    share = axis.span / leader.span if leader.span else 0.0
    for name in ("start", "end"):
        own, leading = (getattr(one.motion, f"{name}_state") for one in (axis, leader))
        for k in range(1, axis.order):
            expected = share * leading[k]
            if abs(own[k] - expected) > _ALIKE * max(abs(own[k]), abs(expected)):
                raise ValueError(
                    f"axis {axis.number}: {name} {derivative_name(k)} = {float(own[k])!r} leads "
                    f"off the straight line: expected {float(expected)!r}, in proportion to its "
                    "distance; use mode='both', or start and end at rest"
                )
