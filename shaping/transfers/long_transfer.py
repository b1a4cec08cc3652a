"""Transfers much longer than their ramps: onto the velocity bound, a cruise, and to the end."""

from __future__ import annotations

import warnings
from math import inf, isfinite

from ..limits import Limits
from ..optimal.whole.outcome import found_plan
from ..trajectory import Trajectory

_Numbers = tuple[float, ...]

_RAMPS = 30.0  # times the longest ramp: the way in which the program goes onto the bound, or off
_LONG = 2.0  # times both ways: a transfer that is planned as these and a cruise


def long_transfer(
    start: _Numbers, end: _Numbers, limits: Limits, *, rtol: float
) -> Trajectory | None:
    """Return a transfer that cruises for most of its way; None for one that is not as long.

    Programs over the whole horizon need cells as short as its ramps. The ramps are planned by
    themselves, in the least time to a place far beyond them, and nothing changes in between. No
    motion takes less than |distance|/bound: a warning says so where that proves less than `rtol`.

    Raises
    ------
    InfeasibleError
        For a start or an end that is a dead end.
    """
    distance = end[0] - start[0]
    low, high = limits.bounds(1)
    bound = high if distance > 0.0 else low
    if limits.bounds_position or not 0.0 < abs(bound) < inf:
        return None
    way = _RAMPS * abs(bound) * _ramp_time(bound, limits)
    if not isfinite(way) or abs(distance) <= 2.0 * _LONG * way:
        return None
    way = way if distance > 0.0 else -way
    cruising = (bound, *[0.0] * (limits.order - 2))
    onto = _motion((0.0, *start[1:]), (way, *cruising), limits, rtol)
    off = _motion((0.0, *cruising), (way, *end[1:]), limits, rtol)
    whole = onto.shift(start[0]).then(off, dwell=(distance - 2.0 * way) / bound)
    _warn_if_far(whole.duration * bound / distance - 1.0, distance / bound, rtol)
    return whole


def _ramp_time(velocity: float, limits: Limits) -> float:
    """Return about how long a change by the velocity bound takes: Σ (v/L_k)^(1/(k−1))."""
    times = []
    for k in range(2, limits.order + 1):
        least = min(abs(side) for side in limits.bounds(k))
        if 0.0 < least < inf:
            times.append((abs(velocity) / least) ** (1.0 / (k - 1)))
    return sum(times) if times else inf


def _motion(start: _Numbers, end: _Numbers, limits: Limits, rtol: float) -> Trajectory:
    motion = found_plan(start, end, limits, rtol=rtol).trajectory
    assert motion is not None  # of a plan that is found
    return motion


def _warn_if_far(gap: float, least: float, rtol: float) -> None:
    if gap > rtol:
        warnings.warn(
            f"this motion takes at most {100.0 * gap:.2g} % more than the minimum time, which is "
            f"proven to be at least {least:.10g}: ramps at both ends, planned apart, and a cruise",
            RuntimeWarning,
            stacklevel=5,
        )
