"""Thompson's longer moves on arrays: the formulas of `closed_form.swing_form`, moves as lanes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..closed_form import crossing_gains
from ..pieces import FloatArray
from .chains import span_terms, spline_spans

_SECANT_STEPS = 40

Terms = list[tuple[FloatArray, float]]


@dataclass(frozen=True, eq=False)
class Swings:
    """Acceleration up, held, across to its opposite in one spline, held, and back to zero.

    `up` and `across` are the span of each spline and the bound of its highest derivative. All
    arrays are (K,), one entry per move.
    """

    order: int
    acceleration: FloatArray
    up: tuple[FloatArray, FloatArray]
    across: tuple[FloatArray, FloatArray]
    hold: FloatArray
    duration: FloatArray


def swings(distance: FloatArray, bounds: Sequence[FloatArray]) -> Swings:
    """Plan longer moves without cruise; their duration is infinite where they break a bound.

    Parameters
    ----------
    distance : (K,) array
        Positive.
    bounds : sequence of (K,) or 0-d arrays
        Symmetric bounds on derivatives 1…n, n ≥ 3, velocity first; the last one finite.
    """
    velocity, acceleration, *inner = bounds
    velocity_gain, position_gain = crossing_gains(len(inner))
    terms = span_terms(inner)
    acceleration = np.array(np.broadcast_to(acceleration, distance.shape))
    excess = distance - _distance(acceleration, terms, position_gain)
    excess *= 0.5 / acceleration
    [short] = np.nonzero((excess < 0.0) & np.isfinite(acceleration))
    if short.size:
        some = [(_lanes(slope, short), power) for slope, power in terms]
        acceleration[short] = _solve_acceleration(
            distance[short], acceleration[short], some, position_gain
        )
        excess[short] = 0.0
    up, across = spline_spans(acceleration, inner), spline_spans(2.0 * acceleration, inner)
    # R/2 = a·(h²/2 + b·h) + R(h = 0)/2, the position at the middle
    b = 0.5 * (up[0] + across[0])
    hold = 2.0 * excess / (b + np.sqrt(b * b + 2.0 * excess))
    peak = acceleration * (0.5 * up[0] + hold + velocity_gain * across[0])
    duration = 2.0 * (up[0] + hold) + across[0]
    # not a number where acceleration is unbounded
    duration = np.where(peak <= velocity, duration, np.inf)
    return Swings(len(inner), acceleration, up, across, hold, duration)


def _lanes(values: FloatArray, some: np.typing.NDArray[np.intp]) -> FloatArray:
    return values if values.ndim == 0 else values[some]


def _distance(acceleration: FloatArray, terms: Terms, gain: float) -> FloatArray:
    """Return the distance of swings without hold."""
    up: FloatArray | float = 0.0
    across: FloatArray | float = 0.0
    for slope, power in terms:
        span = (slope * acceleration) ** power
        up, across = np.maximum(up, span), np.maximum(across, span * 2.0**power)
    product = (0.25 - gain) * up * up + 0.25 * up * across + gain * across * across
    return np.asarray(2.0 * acceleration * product)


def _solve_acceleration(
    distance: FloatArray, acceleration: FloatArray, terms: Terms, gain: float
) -> FloatArray:
    """Return the accelerations, below those given, whose swings without hold cover distances.

    Secant steps in logarithms, of those lanes that are not there yet.
    """
    found = acceleration
    lanes = np.arange(len(distance))
    excess = np.log(_distance(acceleration, terms, gain) / distance)
    step = excess * (-1.0 / 3.0)
    for _ in range(_SECANT_STEPS):
        acceleration = acceleration * np.exp(step)
        found[lanes] = acceleration
        before, excess = excess, np.log(_distance(acceleration, terms, gain) / distance)
        [left] = np.nonzero((np.abs(excess) >= 1e-15) & (excess != before))
        if not left.size:
            break
        lanes, distance, acceleration = lanes[left], distance[left], acceleration[left]
        before, excess, step = before[left], excess[left], step[left]
        terms = [(_lanes(slope, left), power) for slope, power in terms]
        step = step * excess / (before - excess)
    return found
