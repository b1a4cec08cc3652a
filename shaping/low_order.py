"""Rest-to-rest moves of order 1 to 3 in minimum time, bounds equal or not in both directions.

The velocity rises to its peak and falls again, with zero acceleration at the peak: the move is a
ramp up, perhaps a cruise, and a ramp down. Each ramp has a jerk up, a hold and a jerk down.
Scalars throughout: at seven pieces they are several times faster than arrays.
"""

from __future__ import annotations

from itertools import accumulate
from math import cbrt, isinf, sqrt
from typing import NamedTuple

import numpy as np

from .limits import Limits
from .trajectory import Trajectory

Piece = tuple[float, tuple[float, ...]]
"""Duration, and position with derivatives at the start."""


class _Ramp(NamedTuple):
    """The fastest ramp from rest to a velocity, acceleration zero at both ends."""

    velocity: float
    acceleration: float  # the peak
    rise: float  # time of rising acceleration; zero for order 2
    hold: float
    fall: float

    def after_rise(self) -> tuple[float, float]:
        """Return position and velocity where the hold begins."""
        return self.acceleration * self.rise**2 / 6.0, 0.5 * self.acceleration * self.rise

    def after_hold(self) -> tuple[float, float]:
        """Return position and velocity where the hold ends."""
        x, v = self.after_rise()
        v_end = self.velocity - 0.5 * self.acceleration * self.fall
        return x + 0.5 * (v + v_end) * self.hold, v_end

    def distance(self) -> float:
        """Return the distance covered."""
        x, v = self.after_hold()
        return x + (v + self.acceleration * self.fall / 3.0) * self.fall


def low_order_move(distance: float, limits: Limits) -> Trajectory:
    """Return the minimum-time move of order n ≤ 3 over a positive distance from position 0.

    Closed form (Thompson II and III) for equal bounds in both directions; otherwise the peak
    velocity is bisected to the last bit.
    """
    top = limits.upper[0]
    end = (distance, *[0.0] * limits.order)
    if limits.order == 1:
        return _assemble([(distance / top, (0.0, top))], end)
    velocity = min(top, _free_velocity(distance, limits))
    up, down = _ramps(velocity, limits)
    cruise = 0.0
    if velocity == top:
        cruise = max(distance - up.distance() - down.distance(), 0.0) / velocity
    build = _order_2 if limits.order == 2 else _order_3
    return _assemble(build(distance, up, cruise, down), end)


def _order_2(distance: float, up: _Ramp, cruise: float, down: _Ramp) -> list[Piece]:
    v = up.velocity
    pieces: list[Piece] = [(up.hold, (0.0, 0.0, up.acceleration))]
    if cruise > 0.0:
        pieces.append((cruise, (up.distance(), v, 0.0)))
    pieces.append((down.hold, (distance - down.distance(), v, -down.acceleration)))
    return pieces


def _order_3(distance: float, up: _Ramp, cruise: float, down: _Ramp) -> list[Piece]:
    v, a, d = up.velocity, up.acceleration, down.acceleration
    x1, v1 = up.after_rise()
    x2, v2 = up.after_hold()
    if not (up.rise and up.fall):
        raise OverflowError
    rising, falling = a / up.rise, -a / up.fall
    pieces: list[Piece] = [(up.rise, (0.0, 0.0, 0.0, rising))]
    if up.hold > 0.0:
        pieces.append((up.hold, (x1, v1, a, 0.0)))
    if cruise == 0.0 and down is up:
        pieces.append((2.0 * up.fall, (x2, v2, a, falling)))
    else:  # unequal ramps meet at zero acceleration, or rounding of the larger spoils the smaller
        pieces.append((up.fall, (x2, v2, a, falling)))
        if cruise > 0.0:
            pieces.append((cruise, (up.distance(), v, 0.0, 0.0)))
        pieces.append((down.fall, (distance - down.distance(), v, 0.0, falling)))
    y1, w1 = down.after_rise()
    y2, w2 = down.after_hold()
    if down.hold > 0.0:
        pieces.append((down.hold, (distance - y2, w2, -d, 0.0)))
    pieces.append((down.rise, (distance - y1, w1, -d, rising)))
    return pieces


def _assemble(pieces: list[Piece], end: tuple[float, ...]) -> Trajectory:
    durations, states = zip(*pieces, strict=True)
    breaks = np.array([0.0, *accumulate(durations)])
    return Trajectory.from_arrays(breaks, np.array(states), np.array(durations), np.array(end))


def _ramps(velocity: float, limits: Limits) -> tuple[_Ramp, _Ramp]:
    """Return the way up to a velocity and, run backwards, the way down from it."""
    up, down = limits.upper[1], -limits.lower[1]
    if limits.order == 2:
        return (
            _Ramp(velocity, up, 0.0, velocity / up, 0.0),
            _Ramp(velocity, down, 0.0, velocity / down, 0.0),
        )
    rising, falling = limits.upper[2], -limits.lower[2]
    first = _jerk_ramp(velocity, up, rising, falling)
    return first, (first if down == up else _jerk_ramp(velocity, down, rising, falling))


def _jerk_ramp(velocity: float, acceleration: float, rising: float, falling: float) -> _Ramp:
    peak = sqrt(2.0 * velocity / (1.0 / rising + 1.0 / falling))
    if peak <= acceleration:
        return _Ramp(velocity, peak, peak / rising, 0.0, peak / falling)
    rise, fall = acceleration / rising, acceleration / falling
    hold = velocity / acceleration - 0.5 * (rise + fall)
    return _Ramp(velocity, acceleration, rise, max(hold, 0.0), fall)


def _free_velocity(distance: float, limits: Limits) -> float:
    """Return the velocity that the move would reach without a bound on velocity."""
    up, down = limits.upper[1], -limits.lower[1]
    if limits.order == 2:
        return sqrt(2.0 * distance / (1.0 / up + 1.0 / down))
    rising, falling = limits.upper[2], -limits.lower[2]
    if up == down and rising == falling:
        return _symmetric_velocity(distance, up, rising)
    return _bisected_velocity(distance, limits)


def _symmetric_velocity(distance: float, acceleration: float, jerk: float) -> float:
    """Return the peak velocity of Thompson's cases 1 and 2 (Section III)."""
    quarter = cbrt(0.5 * distance / jerk)
    if jerk * quarter <= acceleration or isinf(acceleration):
        return jerk * quarter**2
    ramp = acceleration / jerk
    # T/2 − t_w with T = t_w + sqrt(t_w² + 4R/A)
    return acceleration * 0.5 * (sqrt(ramp * ramp + 4.0 * distance / acceleration) - ramp)


def _bisected_velocity(distance: float, limits: Limits) -> float:
    """Return the peak velocity at which the two ramps cover the distance."""

    def fits(velocity: float) -> bool:
        up, down = _ramps(velocity, limits)
        return up.distance() + down.distance() <= distance

    gentlest = min(limits.upper[2], -limits.lower[2])
    low = high = gentlest * cbrt(0.5 * distance / gentlest) ** 2
    while not fits(low):
        low *= 0.5
    while fits(high):
        high *= 2.0
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
