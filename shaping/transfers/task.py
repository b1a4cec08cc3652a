"""A transfer between two states as plain numbers, in its own units of time and distance."""

from __future__ import annotations

from collections.abc import Sequence
from math import frexp, inf, ldexp
from typing import NamedTuple

ROUNDING = 16.0 * 2.0**-52
"""Relative size below which a difference is taken for rounding."""

Piece = tuple[float, tuple[float, ...]]
"""Duration, and position with derivatives at the start."""


class Task(NamedTuple):
    """From velocity v0 and acceleration a0 to v1 and a1 over a signed distance, within bounds.

    Order 2 has a0 = a1 = 0 and infinite jerks. All of them in consistent units.
    """

    distance: float
    v0: float
    a0: float
    v1: float
    a1: float
    v_min: float
    v_max: float
    a_min: float
    a_max: float
    fall: float
    """Largest rate of falling acceleration, positive."""
    rise: float
    """Largest rate of rising acceleration."""
    resolution: float = 0.0
    """What rounding of the two positions leaves of the distance."""

    def mirror(self) -> Task:
        """Return the same task seen in the opposite direction."""
        return Task(
            -self.distance,
            -self.v0,
            -self.a0,
            -self.v1,
            -self.a1,
            -self.v_max,
            -self.v_min,
            -self.a_max,
            -self.a_min,
            self.rise,
            self.fall,
            self.resolution,
        )

    def within_bounds(self) -> bool:
        """Tell whether the start keeps its bounds, for the moment."""
        return self.v_min <= self.v0 <= self.v_max and self.a_min <= self.a0 <= self.a_max

    def in_units(self, time: float, distance: float) -> Task:
        """Return the task in a unit of time and one of distance, powers of two."""
        v = distance / time
        a = v / time
        return Task(
            self.distance / distance,
            self.v0 / v,
            self.a0 / a,
            self.v1 / v,
            self.a1 / a,
            self.v_min / v,
            self.v_max / v,
            self.a_min / a,
            self.a_max / a,
            self.fall / (a / time),
            self.rise / (a / time),
            self.resolution / distance,
        )


def taylor(row: Sequence[float], time: float) -> tuple[float, ...]:
    """Return position and derivatives a time after a piece's start."""
    later = []
    for k in range(len(row)):
        value = row[-1]
        for j in range(len(row) - 2, k - 1, -1):
            value = value * time / (j + 1 - k) + row[j]
        later.append(value)
    return tuple(later)


def in_own_units(task: Task) -> tuple[Task, float, float]:
    """Return a task in its own units, and those of time and distance."""
    time, length = own_units(task)
    if not length / time / time / time:
        raise OverflowError
    scaled = task.in_units(time, length)
    if not (scaled.a_min and scaled.a_max and scaled.fall and scaled.rise):
        raise OverflowError
    return scaled, time, length


def own_units(task: Task) -> tuple[float, float]:
    """Return units of time and distance in which the task's numbers are of order one.

    Powers of two, so that changing to them and back rounds nothing: time unit T, about the
    longest of the times that speeds, accelerations and the distance take alone; distance unit
    J·T³, or A·T² for order 2. Found from exponents alone, so that tasks that differ by powers of
    two become one and the same.
    """
    n = 2 if task.rise == inf else 3
    power = min(task.rise, task.fall) if n == 3 else min(task.a_max, -task.a_min)
    spans = [
        -(-_exponent(size / power) // order)  # rounded up
        for order, size in (
            (n, abs(task.distance)),
            (n - 1, max(abs(task.v0), abs(task.v1))),
            (n - 2, max(abs(task.a0), abs(task.a1))),
        )
        if size > 0.0
    ]
    span = max(spans, default=0)
    time, length = ldexp(1.0, span), ldexp(1.0, _exponent(power) + n * span if spans else 0)
    if not (time**n and length):
        raise OverflowError
    return time, length


def _exponent(value: float) -> int:
    """Return the exponent of two of a positive number."""
    if not 0.0 < value < inf:
        raise OverflowError
    return frexp(value)[1]
