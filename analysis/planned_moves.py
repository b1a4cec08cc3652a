"""The command of a move: the fastest within its limits or of minimum jerk, behind its shapers."""

from __future__ import annotations

from functools import lru_cache
from math import ceil, inf, sqrt
from typing import Any

from ..shaping import Limits, Trajectory, min_jerk_move, min_time_move
from ..shaping.derivatives import derivative_name
from ..shaping.real_numbers import shown
from .specification import Move

_QUINTIC = (1.875, 10.0 / sqrt(3.0), 60.0)  # peaks of velocity, acceleration, jerk, R = T = 1
_ROUNDING = 1e-12


def planned(move: Move) -> Trajectory:
    """Return the command of a move, behind its shapers.

    Raises
    ------
    ValueError
        For a duration that its limits do not allow, or a move of minimum jerk, whose jerk jumps,
        under a bound on snap or more.
    """
    limits = Limits.from_bounds(move.bounds)
    trajectory = _minimum_jerk(move, limits) if move.minimum_jerk else _fastest(move, limits)
    for shaper in move.shapers:
        trajectory = shaper.shape(trajectory)
    return trajectory


def _fastest(move: Move, limits: Limits) -> Trajectory:
    return _planned(move.distance, limits, move.duration, move.round_to)


@lru_cache(maxsize=1024)
def _planned(
    distance: float, limits: Limits, duration: float | None, round_to: float | None
) -> Trajectory:
    """Return a move, planned once for all the loops that are asked to make it."""
    timing: dict[str, Any] = {"duration": duration, "round_to": round_to}
    asked = {name: value for name, value in timing.items() if value is not None}
    return min_time_move(distance, limits, **asked)


def _minimum_jerk(move: Move, limits: Limits) -> Trajectory:
    """Return R·(10 s³ − 15 s⁴ + 6 s⁵), T = max over k of (c_k·|R|/bound)^(1/k), or that given."""
    least = max(_least_duration(move.distance, limits, k) for k in range(1, limits.order + 1))
    duration = least if move.duration is None else move.duration
    if duration < least * (1.0 - _ROUNDING):
        raise ValueError(
            f"duration = {shown(duration)}: a move of minimum jerk takes {least:.6g} s within its "
            "limits; give that or more"
        )
    if move.round_to is not None:
        duration = move.round_to * ceil(duration / move.round_to * (1.0 - _ROUNDING))
    return min_jerk_move(move.distance, duration=duration)


def _least_duration(distance: float, limits: Limits, k: int) -> float:
    """Return the shortest duration for the bound on the derivative k, the tighter of two sides."""
    low, high = limits.bounds(k)
    bound = min(-low, high) if k > 1 else high if distance > 0.0 else -low
    if bound == inf:
        return 0.0
    if k > len(_QUINTIC):
        raise ValueError(
            f"a move of minimum jerk with a bound on {derivative_name(k)}: its jerk jumps; leave "
            "out the bounds above jerk, or minimum_jerk"
        )
    return float((_QUINTIC[k - 1] * abs(distance) / bound) ** (1.0 / k))
