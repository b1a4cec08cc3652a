"""Several axes on the straight line from start to end: one motion along it, scaled to each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import hypot, inf

from ..derivatives import derivative_name
from ..limits import Limits, check_plain
from ..moves import min_time_move
from ..real_numbers import shown
from ..trajectory import Motion, Trajectory, as_trajectory
from .axes import Axis, Pair, axis_of, planned_motion
from .transfer import min_time_transfer

ALIKE = 1e-9  # relative difference of two axes' speeds along the line that is rounding
_NEAR = 5e-4  # gap asked for of the motion along the line, whose bounds are nearly even
_SLOWEST = 1e-12  # relative difference of durations that is rounding


def straight_line(
    axes: Sequence[Axis], resultant: Limits | Motion | None = None
) -> tuple[list[Motion], Trajectory | None]:
    """Return the motions along the line, and that of the resultant, None where nothing moves.

    One profile from 0 to 1 is scaled to each axis: derivative k of axis i is R_i·s^(k), that of
    the resultant L·s^(k) with L² = Σ R_i², so that the bounds of s^(k) are the tightest of their
    bounds over R_i and L. The resultant is one more axis, from 0 to L.
    """
    for axis in axes:
        if axis.limits is not None:
            check_plain(axis.limits)
    length = hypot(*(axis.span for axis in axes))
    if isinstance(resultant, Motion):
        profile = _along(axes, as_trajectory(resultant), length)
    elif resultant is not None:
        profile = _fastest([*axes, _resultant_axis(axes, resultant, length)])
    else:
        profile = _fastest(axes)
    if profile is None:
        return [axis.motion for axis in axes], None
    motions: list[Motion] = [
        profile.scale(axis.span).shift(float(axis.motion.start_state[0])) for axis in axes
    ]
    return motions, profile.scale(length)


def _fastest(axes: Sequence[Axis]) -> Trajectory | None:
    """Return the fastest profile that is known, None where nothing moves."""
    moving = [axis for axis in axes if axis.span]
    leader = max(axes, key=lambda axis: abs(axis.span))
    alike = len({axis.order for axis in axes}) == 1
    if alike and leader.order in (2, 3) and all(axis.limits is not None for axis in axes):
        for axis in axes:
            _check_on_line(axis, leader)
        return _fastest_transfer(moving, leader) if moving else None
    _check_at_rest(axes)
    return _fastest_move(moving) if moving else None


def _resultant_axis(axes: Sequence[Axis], limits: Limits, length: float) -> Axis:
    """Return the resultant as an axis from 0 to L, as fast at either end as the axes are."""
    ends = []
    for place, name in ((0.0, "start"), (length, "end")):
        states = [getattr(axis.motion, f"{name}_state") for axis in axes]
        shares = [axis.span / length if length else 0.0 for axis in axes]
        kept = range(1, limits.order)
        rates = [
            sum(u * state[k] for u, state in zip(shares, states, strict=True) if k < len(state))
            for k in kept
        ]
        ends.append((place, *map(float, rates)))
    motion = planned_motion("the resultant", ends[0], ends[1], limits)
    return axis_of(len(axes), motion, limits)


def _along(axes: Sequence[Axis], path: Trajectory, length: float) -> Trajectory | None:
    """Return the profile of a motion of the resultant, slowed down to the bounds of the axes."""
    path = path.delay(-path.start_time) if path.start_time else path
    distance = float(path.end_state[0] - path.start_state[0])
    if abs(distance - length) > ALIKE * length:
        raise ValueError(
            f"resultant = {shown(path)} goes {distance!r}: expected {length!r}, the distance "
            "between start and end"
        )
    if not length:
        return None
    profile = path.shift(-float(path.start_state[0])).scale(1.0 / distance)
    bounded = [axis for axis in axes if axis.span and axis.limits is not None]
    slowed = _slowed(profile, bounded)
    ends = path.start_state[1:-1], path.end_state[1:-1]
    if slowed is not profile and any(end.any() for end in ends):
        raise ValueError(
            f"resultant = {shown(path)} breaks the bounds of an axis and cannot be slowed down, "
            "as it moves at its start or end: lower its rates"
        )
    return slowed


def _fastest_transfer(moving: Sequence[Axis], leader: Axis) -> Trajectory:
    """Return the profile from one state to another within limits that are known."""
    begin, finish = (
        [fraction, *(state[1 : leader.order] / leader.span).tolist()]
        for fraction, state in (
            (0.0, leader.motion.start_state),
            (1.0, leader.motion.end_state),
        )
    )
    return min_time_transfer(begin, finish, Limits.from_bounds(_tightest_of(moving))).trajectory


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
    bounds = [(low if low < 0.0 else -high, high) for low, high in _tightest_of(moving)]
    planned = _slowed(min_time_move(1.0, Limits.from_bounds(bounds), rtol=_NEAR), moving)
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


def _tightest_of(moving: Sequence[Axis]) -> list[Pair]:
    order = max(axis.order for axis in moving)
    return tightest(((axis.span, axis.bounds()) for axis in moving), order)


def tightest(shares: Iterable[tuple[float, Iterator[Pair]]], order: int) -> list[Pair]:
    """Return the bounds of a profile's derivatives 1…order, from (R_i, bounds of the axis)."""
    bounds: list[Pair] = [(-inf, inf)] * order
    for share, pairs in shares:
        for k, pair in enumerate(pairs):
            low, high = sorted(side / share for side in pair)
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
            if abs(own[k] - expected) > ALIKE * max(abs(own[k]), abs(expected)):
                raise ValueError(
                    f"axis {axis.number}: {name} {derivative_name(k)} = {float(own[k])!r} leads "
                    f"off the straight line: expected {float(expected)!r}, in proportion to its "
                    "distance; use mode='both', or start and end at rest"
                )
