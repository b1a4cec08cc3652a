"""What an S-curve is planned with: its rates, and units in which its times are of order one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign, frexp, inf, ldexp, sqrt
from typing import NamedTuple

Piece = tuple[float, tuple[float, ...]]
"""Duration, and position with derivatives at the start."""

Pieces = list[Piece]

Motion = tuple[float, float, float]
"""Position, velocity, acceleration."""


@dataclass(frozen=True)
class Rates:
    """How fast a motion may speed up and slow down.

    With a jerk percent p the jerks are not used: every ramp lasts as long as at constant
    acceleration A, and its jerk acts in p/2 of it at either end; so its peak acceleration is
    A/(1 − p/2); or, `percent_keeps_peak`, ramps last 1/(1 − p/2) times as long, and A is the peak.
    """

    velocity: float
    acceleration: float
    deceleration: float
    acceleration_jerk: float
    deceleration_jerk: float
    jerk_percent: float | None = None
    percent_keeps_peak: bool = False


_FAR = 2.0**20
"""In a problem's own units no velocity gets that far: a bound beyond is none."""
_STEEPEST = 2.0**200
"""A jerk with which the acceleration jumps."""


class Units(NamedTuple):
    """A unit of time 2^time and one of distance 2^length."""

    time: int
    length: int

    def into(self, value: float, derivative: int) -> float:
        """Return a position or derivative in these units."""
        return _scaled(value, derivative * self.time - self.length)

    def back(self, value: float, derivative: int) -> float:
        """Return a position or derivative that is given in these units."""
        return _scaled(value, self.length - derivative * self.time)

    def motion(self, state: Motion) -> Motion:
        """Return a state in these units."""
        x, v, a = (self.into(value, k) for k, value in enumerate(state))
        return x, v, a

    def rates(self, rates: Rates) -> Rates:
        """Return rates in these units, those that can never bind brought near."""
        jerks = [
            min(self.into(jerk, 3), _STEEPEST) if jerk < inf else inf
            for jerk in (rates.acceleration_jerk, rates.deceleration_jerk)
        ]
        far = [_FAR * (1.0 + sqrt(min(jerk, _STEEPEST))) for jerk in jerks]
        return replace(
            rates,
            velocity=min(self.into(rates.velocity, 1), _FAR),
            acceleration=min(self.into(rates.acceleration, 2), far[0]),
            deceleration=min(self.into(rates.deceleration, 2), far[1]),
            acceleration_jerk=jerks[0],
            deceleration_jerk=jerks[1],
        )

    def pieces(self, pieces: Pieces, origin: float) -> Pieces:
        """Return pieces that are given in these units from an origin."""
        return [
            (
                _scaled(duration, self.time),
                (origin + self.back(row[0], 0), *(self.back(row[k], k) for k in (1, 2, 3))),
            )
            for duration, row in pieces
        ]


def in_own_units(
    begin: Motion, target: float, final_velocity: float, rates: Rates
) -> tuple[Units, Rates]:
    """Return the units of a problem, found from exponents alone, and the rates in them.

    The unit of time is about the longest of the times that distance, speeds and acceleration take
    alone within each bound, that of distance the largest of what they are worth in that time, as
    the core has it. Rates that can never bind in such a problem are brought near, to one value.
    """
    speed = max(abs(begin[1]), abs(final_velocity))
    units = _own_units((abs(target - begin[0]), speed, abs(begin[2])), rates)
    return units, units.rates(rates)


def _own_units(quantities: Motion, rates: Rates) -> Units:
    bounds = (
        rates.velocity,
        min(rates.acceleration, rates.deceleration),
        min(rates.acceleration_jerk, rates.deceleration_jerk),
    )
    times = [
        -((_exponent(bound) - _exponent(quantity)) // (n - k))
        for k, quantity in enumerate(quantities)
        for n, bound in enumerate(bounds, start=1)
        if n > k and quantity and bound < inf
    ]
    if not times:
        return Units(0, _exponent(bounds[1]))
    time = max(times)
    return Units(time, max(_exponent(q) + k * time for k, q in enumerate(quantities) if q))


def _exponent(value: float) -> int:
    return frexp(value)[1]


def _scaled(value: float, exponent: int) -> float:
    try:
        return ldexp(value, exponent)
    except OverflowError:
        return copysign(inf, value)
