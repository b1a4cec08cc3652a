"""Moves of any order in their own units, without the bounds that make no difference; on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .frozen import Frozen
from .pieces import FloatArray
from .rise import spline_divisor
from .trajectory import Trajectory

_EXTREME = 200  # a power of two of a unit that is left as it is
_FAR = 20.0  # a bound 2²⁰ times what can be reached never binds
_STEEP = 60.0  # a ramp that takes 2⁻⁶⁰ of the duration is none

_LEAST = 5e-324

Sides = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class MoveUnits(Frozen):
    """Exponents of powers of two, which times and lengths in these units are multiplied by."""

    time: NDArray[np.int64]
    length: NDArray[np.int64]

    def select(self, some: Any) -> MoveUnits:
        """Return those of some problems."""
        return MoveUnits(self.time[some], self.length[some])

    def trajectory(self, own: Trajectory) -> Trajectory:
        """Return one motion in the caller's units."""
        rows = [self.derivative(own.states[:, k], k) for k in range(own.order + 1)]
        end = [float(self.derivative(value, k)) for k, value in enumerate(own.end_state)]
        breaks, durations = self.times(own.breaks), self.times(own.durations)
        return Trajectory.from_arrays(breaks, np.stack(rows, axis=1), durations, np.array(end))

    def times(self, own: FloatArray) -> FloatArray:
        """Return times in the caller's units."""
        with np.errstate(over="ignore", under="ignore"):
            times: FloatArray = np.ldexp(own, self.time)
        return times

    def derivative(self, own: FloatArray, k: int) -> FloatArray:
        """Return positions or a derivative k in the caller's units."""
        with np.errstate(over="ignore", under="ignore"):
            values: FloatArray = np.ldexp(own, self.length - k * self.time)
        return values


def in_own_units(
    distance: FloatArray, sides: Sequence[Sides]
) -> tuple[MoveUnits, FloatArray, list[Sides]]:
    """Return units, and distances ≥ 0 and bounds on derivatives 1…n in them.

    With R the distance, L_m the bound on derivative m and D that on the highest one, no derivative
    k of a move gets far beyond R^(1−k/n)·D^(k/n) or, for any m < k,

        L_m^((n−k)/(n−m)) · D^((k−m)/(n−m)),

    so that a bound beyond is none. The move takes T ≥ (R/L_k)^(1/k); the ramp of derivative m
    takes (L_m/L_k)^(1/(k−m)), which may as well be 2⁻⁶⁰·T where it is less.
    """
    with np.errstate(all="ignore"):
        size = np.log2(np.where(distance > 0.0, distance, 1.0))
        wide = [np.log2(np.maximum(-low, high)) for low, high in sides]
        reach = _reach(size, wide)
        ahead, *others = sides
        narrow = [np.log2(side) for side in (ahead[1], *(np.minimum(-a, b) for a, b in others))]
        narrow, wide = (
            [np.where(log <= most, log, np.inf) for log, most in zip(logs, reach, strict=True)]
            for logs in (narrow, wide)
        )
        time = np.maximum.reduce([(size - log) / k for k, log in enumerate(narrow, start=1)])
        units = _units(size, time)
        both = [
            np.where(np.isfinite(one), one, other) for one, other in zip(wide, narrow, strict=True)
        ]
        caps = _gentle(size, both, time)
        powers = [k * units.time - units.length for k in range(1, len(sides) + 1)]
        bounds = [
            (-_own(-low, most, cap, power), _own(high, most, cap, power))
            for (low, high), most, cap, power in zip(sides, reach, caps, powers, strict=True)
        ]
        return units, np.ldexp(distance, -units.length), bounds


def _reach(size: FloatArray, logs: list[FloatArray]) -> list[FloatArray]:
    """Return logarithms of what the derivatives 1…n stay below."""
    n, top = len(logs), logs[-1]
    lower, reach = [size + np.log2(spline_divisor(n))], []
    for k, log in enumerate(logs[:-1], start=1):
        ways = [((n - k) * below + (k - m) * top) / (n - m) for m, below in enumerate(lower)]
        reach.append(np.minimum.reduce(ways) + _FAR)
        lower.append(np.where(log <= reach[-1], log, np.inf))
    return [*reach, np.full_like(size, np.inf)]


def _gentle(size: FloatArray, logs: list[FloatArray], time: FloatArray) -> list[FloatArray]:
    """Return logarithms of what each bound need not exceed for its ramp to take no time."""
    before, order, caps = size, np.zeros_like(size), []
    for k, log in enumerate(logs, start=1):
        caps.append(before + (k - order) * (_STEEP - time))
        finite = np.isfinite(log)
        before = np.where(finite, np.minimum(log, caps[-1]), before)
        order = np.where(finite, k, order)
    return caps


def _units(size: FloatArray, time: FloatArray) -> MoveUnits:
    """Return units, those given where they are not extreme."""
    length, own = np.rint(size).astype(np.int64), np.rint(time).astype(np.int64)
    extreme = (np.abs(length) > _EXTREME) | (np.abs(own) > _EXTREME)
    return MoveUnits(np.where(extreme, own, 0), np.where(extreme, length, 0))


def _own(
    side: FloatArray, reach: FloatArray, cap: FloatArray, power: NDArray[np.int64]
) -> FloatArray:
    """Return a positive side of a bound in units; infinite where it never binds."""
    log = np.log2(side)
    own = np.where(log > cap, np.exp2(cap + power), np.ldexp(side, power))
    own = np.where(log <= reach, own, np.inf)
    return np.maximum(own, _LEAST)
