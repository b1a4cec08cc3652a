"""Minimum-time moves of order 1 to 3 on arrays: the formulas of `low_order`, bisection apart.

All functions take distances ≥ 0 and bounds as moves in the positive direction see them.

The way up to a velocity v, acceleration zero at both ends, peaks at p = min(sqrt(v/κ), A),
κ = (1/W₊ + 1/W₋)/2, and takes p·κ + v/p; free of A it covers p³·γ with
γ = 1/(6W₊²) + 1/(2W₊W₋) + 1/(3W₋²), and the way down, run backwards, is of the same kind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray
from .many_limits import ManyLimits

Mask = NDArray[np.bool_]

_NEWTON_STEPS = 60  # six are enough


def durations(distance: FloatArray, limits: ManyLimits) -> FloatArray:
    """Return the durations of moves of order n ≤ 3, shape (K,); NaN for distance zero."""
    top = limits.rising[0]
    if limits.order == 1:
        return np.asarray(distance / top)
    velocity = _free_velocity(distance, limits)
    np.minimum(velocity, top, out=velocity)
    if limits.order == 2:
        up, down = limits.rising[1], limits.falling[1]
        return np.asarray(distance / velocity + velocity * (0.5 / up + 0.5 / down))
    if limits.symmetric:
        acceleration, jerk = limits.rising[1], limits.rising[2]
        peak = velocity * jerk
        np.sqrt(peak, out=peak)
        np.minimum(peak, acceleration, out=peak)
        total = distance / velocity  # cruise and one ramp
        total += peak / jerk
        total += np.divide(velocity, peak, out=velocity)
        return np.asarray(total)
    lengths, _ = pieces(distance, limits)
    return np.asarray(lengths.sum(axis=0))


def pieces(distance: FloatArray, limits: ManyLimits) -> tuple[FloatArray, FloatArray]:
    """Return durations (m, K) and states (n + 1, m, K) of the pieces, m = 1, 3 or 7.

    Pieces that a move does not need have duration zero. Positions of the second half are
    counted from the end.
    """
    if limits.order == 1:
        top = np.broadcast_to(limits.rising[0], distance.shape)
        return (distance / top)[None], np.array([np.zeros((1, len(top))), top[None]])
    top = limits.rising[0]
    free = _free_velocity(distance, limits)
    velocity = np.minimum(free, top)
    way = _order_2 if limits.order == 2 else _order_3
    return way(distance, velocity, free >= top, limits)


def _order_2(
    distance: FloatArray, v: FloatArray, cruises: Mask, limits: ManyLimits
) -> tuple[FloatArray, FloatArray]:
    up, down = limits.rising[1], limits.falling[1]
    lengths, states = np.empty((3, len(v))), np.zeros((3, 3, len(v)))
    np.divide(v, up, out=lengths[0])
    np.divide(v, down, out=lengths[2])
    states[0, 1], states[0, 2] = 0.5 * v * lengths[0], distance - 0.5 * v * lengths[2]
    lengths[1] = np.where(cruises, np.maximum(states[0, 2] - states[0, 1], 0.0) / v, 0.0)
    states[1, 1:] = v
    states[2, 0], states[2, 2] = up, -down
    return lengths, states


def _order_3(
    distance: FloatArray, v: FloatArray, cruises: Mask, limits: ManyLimits
) -> tuple[FloatArray, FloatArray]:
    (_, up, rising), (_, down, falling) = limits.rising, limits.falling
    count = len(v)
    lengths, states = np.empty((7, count)), np.zeros((4, 7, count))
    before = _ramp(v, up, rising, falling, lengths[:3], states[:, :4])
    if limits.symmetric:
        lengths[6:3:-1] = lengths[:3]
        after, peak = before, states[2, 1]
        x, w = states[0, 1:3], states[1, 1:3]
    else:
        backwards, of_way = np.empty((3, count)), np.zeros((4, 4, count))
        after = _ramp(v, down, rising, falling, backwards, of_way)
        lengths[6:3:-1] = backwards
        x, w, peak = of_way[0, 1:3], of_way[1, 1:3], of_way[2, 1]
    start_of_fall = distance - after
    np.subtract(distance, x, out=states[0, 6:4:-1])
    states[1, 6:4:-1] = w
    np.negative(peak, out=states[2, 5])
    states[2, 6] = states[2, 5]
    states[0, 3], states[0, 4] = before, start_of_fall
    states[1, 3:5] = v
    lengths[3] = np.where(cruises, np.maximum(start_of_fall - before, 0.0) / v, 0.0)
    states[3, 0], states[3, 6] = rising, rising
    states[3, 2], states[3, 4] = -falling, -falling
    return lengths, states


def _ramp(
    v: FloatArray,
    acceleration: FloatArray,
    rising: FloatArray,
    falling: FloatArray,
    lengths: FloatArray,
    states: FloatArray,
) -> FloatArray:
    """Put rise, hold and fall (3, K) and the states where hold and fall begin in place.

    `states` (4, ≥ 3, K) is zero before. Returns the distance covered.
    """
    kappa = 0.5 / rising + 0.5 / falling
    root = np.sqrt(v / kappa)
    p = np.minimum(root, acceleration)
    rise, hold, fall = lengths
    np.divide(p, rising, out=rise)
    np.divide(p, falling, out=fall)
    hold[:] = np.where(root > acceleration, np.maximum(v / p - p * kappa, 0.0), 0.0)
    x, speed = states[0, 1:3], states[1, 1:3]
    speed[0] = 0.5 * p * rise
    x[0] = speed[0] * rise * (1.0 / 3.0)
    speed[1] = v - 0.5 * p * fall
    x[1] = x[0] + 0.5 * (speed[0] + speed[1]) * hold
    states[2, 1:3] = p
    return np.asarray(x[1] + (speed[1] + p * fall * (1.0 / 3.0)) * fall)


def _free_velocity(distance: FloatArray, limits: ManyLimits) -> FloatArray:
    """Return the peak velocity without a bound on velocity."""
    up, down = limits.rising[1], limits.falling[1]
    if limits.order == 2:
        return np.asarray(np.sqrt(distance / (0.5 / up + 0.5 / down)))
    if not (up is down and limits.rising[2] is limits.falling[2]):
        return _uneven_velocity(distance, limits)
    jerk = limits.rising[2]
    # v·(v/p + p/W) = R, the peak p being A or, where that is not reached, W·(R/(2W))^(1/3)
    ramp = np.cbrt(distance * (0.5 / jerk))
    peak = np.minimum(ramp * jerk, up)
    np.divide(peak, jerk, out=ramp)
    velocity = np.divide(distance, peak, out=peak)
    velocity *= 4.0
    velocity += ramp * ramp
    np.sqrt(velocity, out=velocity)
    velocity += ramp
    np.divide(distance, velocity, out=velocity)
    velocity *= 2.0
    return np.asarray(velocity)


def _uneven_velocity(distance: FloatArray, limits: ManyLimits) -> FloatArray:
    """Return the same where bounds differ between the directions.

    With s = sqrt(v) a ramp covers c·s³, or once A is reached s⁴/(2A) + s²·A/(2W₋) + e with
    e = (1/W₊² − 1/W₋²)·A³/24. Which of them reach A the distance tells.
    """
    (_, up, rising), (_, down, falling) = limits.rising, limits.falling
    lower, higher = np.minimum(up, down), np.maximum(up, down)
    kappa = 0.5 / rising + 0.5 / falling
    skew = rising / falling
    gamma = 1.0 / 6.0 + skew * (0.5 + skew * (1.0 / 3.0))  # times W₊²
    root = np.sqrt(kappa)
    cubic = gamma * root / (kappa * rising) ** 2  # γ / κ^(3/2)
    speed = np.asarray(np.cbrt(distance / (2.0 * cubic)))
    reached = np.asarray(speed > lower * root)
    if reached.any():
        numbers = (distance, lower, higher, root, falling, cubic, skew, rising)
        lanes = [np.broadcast_to(x, speed.shape)[reached] for x in numbers]
        speed[reached] = _reached_speed(*lanes)
    return np.asarray(speed * speed)


def _reached_speed(
    distance: FloatArray,
    lower: FloatArray,
    higher: FloatArray,
    root: FloatArray,
    falling: FloatArray,
    cubic: FloatArray,
    skew: FloatArray,
    rising: FloatArray,
) -> FloatArray:
    """Return sqrt(v) where one of the accelerations is reached, or both are."""

    def offset(a: FloatArray) -> FloatArray:
        step = a / rising
        return np.asarray(a * step * step * ((1.0 - skew) * (1.0 + skew) / 24.0))

    # both: v²·h + v·b = R − e
    left = distance - offset(lower) - offset(higher)
    b, h = 0.5 * (lower + higher) / falling, 0.5 / lower + 0.5 / higher
    both = np.sqrt(2.0 * left / (b + np.sqrt(b * b + 4.0 * h * left)))
    speed = _mixed_speed(distance - offset(lower), 0.5 / lower, cubic, 0.5 * lower / falling)
    return np.where(speed > higher * root, both, speed)


def _mixed_speed(
    left: FloatArray, fourth: FloatArray, third: FloatArray, second: FloatArray
) -> FloatArray:
    """Solve fourth·s⁴ + third·s³ + second·s² = left for s > 0 by Newton's method from above."""
    s = np.minimum(np.cbrt(left / third), np.sqrt(left / second))
    s = np.minimum(s, np.sqrt(np.sqrt(left / fourth)))
    for _ in range(_NEWTON_STEPS):
        value = ((fourth * s + third) * s + second) * s * s - left
        slope = ((4.0 * fourth * s + 3.0 * third) * s + 2.0 * second) * s
        before, s = s, np.minimum(s, s - value / slope)
        if (before - s <= 2.0**-50 * s).all():
            break
    return s
