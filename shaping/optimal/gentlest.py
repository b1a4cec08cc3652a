"""Moves from rest to rest of a given duration with the smallest share of the highest bound."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import exp, log

from ..closed_moves import fastest, planned
from ..endings import slowed_to
from ..limits import Limits
from ..trajectory import Trajectory, within_range
from .minimum_time import improved
from .quick_bounds import spline_durations

_STEPS = 8
_SAME_TIME = 2e-6  # relative
_SAME_SHARE = 1e-5
_ROUNDING = 1e-12


def gentlest_move(
    move: Trajectory,
    limits: Limits,
    duration: float,
    fastest_within: Callable[[Limits], Trajectory] | None = None,
) -> Trajectory:
    """Return the move of a duration T above the least with the smallest share of its highest bound.

    The minimum time T*(s) with s·L_n in the place of the highest bound L_n falls as s rises: what
    is sought is the s at which T*(s) = T. It lies between that of the perfect spline, which no
    other bound holds back, and (T*(1)/T)^n, that of the fastest move slowed down as a whole.

    Parameters
    ----------
    move : Trajectory
        The fastest.
    limits : Limits
        Of order n ≥ 4; bounds on even derivatives the same in both directions and positions free
        unless `fastest_within` is given.
    duration : float
    fastest_within : callable, optional
        From limits to the fastest move; by the half horizon where it is left out.
    """
    n, start = limits.order, float(move.start_state[0])
    distance = float(move.end_state[0]) - start
    plan = fastest_within or partial(_fastest, distance, start)
    forward = limits if distance > 0.0 else limits.mirror()
    spline = float(spline_durations(abs(distance), forward)[n])
    low, high = n * log(spline / duration) + n * _ROUNDING, n * log(move.duration / duration)
    best, least = move, high

    def late(at: float) -> float:
        """Return log(T*(s)/T); keep the move if, stretched to T, it needs the least."""
        nonlocal best, least
        found = plan(with_share(exp(at), limits))
        after = log(found.duration / duration)
        if after <= 0.0 and at + n * after < least:
            best, least = found, at + n * after
        return after

    last, before = 0.0, -log(duration / move.duration)
    at, after = high, late(high) if late(low) > 0.0 else 0.0
    for _ in range(_STEPS):
        if -_SAME_TIME <= after <= 0.0 or high - low <= _SAME_SHARE:
            break
        ahead = at - after * (at - last) / (after - before) if after != before else low
        last, before = at, after
        at = ahead if low < ahead < high else 0.5 * (low + high)
        after = late(at)
        low, high = (at, high) if after > 0.0 else (low, at)
    return slowed_to(best, duration)


def with_share(share: float, limits: Limits) -> Limits:
    """Return the limits with a share of the highest bound."""
    *lower, (least, most) = zip(limits.lower, limits.upper, strict=True)
    position = limits.position if limits.bounds_position else None
    return Limits.from_bounds([*lower, (share * least, share * most)], position=position)


def _fastest(distance: float, start: float, limits: Limits) -> Trajectory:
    """Return the fastest move by the half horizon."""

    def plan(length: float, forward: Limits) -> Trajectory:
        closed = within_range(lambda: fastest(length, forward))
        return improved(closed, forward) or closed

    return planned(distance, limits, start, plan)
