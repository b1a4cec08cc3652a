"""Where a measure of a measured loop is least: between lines, never on the edge of the lines."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .loop_grid import LoopGrid
from .rational_fits import Complex, Real

_POINTS = 33
_ROUNDS = 5

Measure = Callable[[Complex], Real]


class Extreme(NamedTuple):
    """The least value of a measure, its frequency, and L and σ there."""

    least: float
    frequency_hz: float
    value: complex
    sigma: float


def distance(value: Complex) -> Real:
    """Return |1 + L|."""
    return np.asarray(abs(1.0 + value))


def complementary_inverse(value: Complex) -> Real:
    """Return |1/T|."""
    return np.asarray(abs(1.0 + value) / np.maximum(abs(value), 1e-300))


def disk(value: Complex) -> Real:
    """Return the symmetric disk margin at each frequency, 2·|(1 + L)/(1 − L)|."""
    return np.asarray(2.0 * abs(1.0 + value) / np.maximum(abs(1.0 - value), 1e-300))


def least_of(grid: LoopGrid, measure: Measure) -> Extreme | None:
    """Return the minimum of a measure over what was measured; None where it is at an end."""
    at = int(np.argmin(measure(grid.value)))
    if at in (0, len(grid.frequency_hz) - 1) or not grid.joined[at - 1 : at + 1].all():
        return None
    low, high = grid.frequency_hz[at - 1], grid.frequency_hz[at + 1]
    for _ in range(_ROUNDS):
        frequency = np.linspace(low, high, _POINTS)
        values = measure(grid.loop.value(frequency))
        at = int(np.argmin(values))
        low, high = frequency[max(at - 1, 0)], frequency[min(at + 1, _POINTS - 1)]
    found = grid.loop.at(frequency[at : at + 1])
    return Extreme(
        float(values[at]), float(frequency[at]), complex(found.value[0]), float(found.sigma[0])
    )
