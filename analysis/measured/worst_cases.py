"""The worst margins that circles around L allow: of probability 95 %, for each point alone.

With radius r around each point,

    |1 + L| ≥ min(|1 + L| − r),   PM ≥ min(|arg(−L)| − 2·asin(r/2)) where ||L| − 1| ≤ r,
    upper GM ≥ min −20·log₁₀(−Re L + √(r² − Im²)) where |Im L| ≤ r and Re L < 0.
"""

from __future__ import annotations

from math import inf, nan

import numpy as np

from .crossings import Crossings
from .loop_grid import RADIUS, LoopGrid
from .rational_fits import Complex, Real


def worst_distance(grid: LoopGrid) -> float:
    """Return the least |1 + L| within the circles, 0 where one holds −1."""
    return max(0.0, float((abs(1.0 + grid.value) - grid.radius).min()))


def worst_complementary(grid: LoopGrid) -> float:
    """Return the largest |T| within the circles, by |dT| = |S|²·r; inf where one holds −1."""
    around = abs(1.0 + grid.value)
    if (around <= grid.radius).any():
        return inf
    return float((abs(grid.value) / around + grid.radius / around**2).max())


def worst_disk(grid: LoopGrid) -> float:
    """Return the least disk margin within the circles, by its slope 4·|1/(1 − L)²|."""
    beside = np.maximum(abs(1.0 - grid.value), 1e-300)
    alpha = 2.0 * abs(1.0 + grid.value) / beside
    return max(0.0, float((alpha - 4.0 / beside**2 * grid.radius).min()))


def worst_phase(grid: LoopGrid, found: Crossings) -> tuple[float, float]:
    """Return the least phase margin in degrees and the least delay margin in seconds."""
    frequency, value, radius = _with(grid, found)
    near = abs(abs(value) - 1.0) <= radius
    if not near.any():
        return nan, nan
    turn = 2.0 * np.arcsin(np.minimum(0.5 * radius[near], 1.0))
    left = np.maximum(abs(np.angle(-value[near])) - turn, 0.0)
    lag = np.maximum(np.angle(-value[near]) % (2.0 * np.pi) - turn, 0.0)
    delay = lag / (2.0 * np.pi * frequency[near])
    return float(np.degrees(left.min())), float(delay.min())


def worst_gains(grid: LoopGrid, found: Crossings) -> tuple[float, float]:
    """Return the least lower and upper gain margins in dB; nan where no circle allows one."""
    _, value, radius = _with(grid, found)
    near = (abs(value.imag) <= radius) & (value.real < 0.0) & (radius < 0.5 * abs(value))
    chord = np.sqrt(np.maximum(radius[near] ** 2 - value.imag[near] ** 2, 0.0))
    largest, least = chord - value.real[near], -value.real[near] - chord
    crossing = -value.real[near]
    upper = -20.0 * np.log10(largest[crossing < 1.0])
    lower = 20.0 * np.log10(np.maximum(least[crossing > 1.0], 1e-300))
    return _least(lower), _least(upper)


def _with(grid: LoopGrid, found: Crossings) -> tuple[Real, Complex, Real]:
    """Return the points of a grid and the crossings that were solved for between them."""
    return (
        np.concatenate([grid.frequency_hz, found.frequency_hz]),
        np.concatenate([grid.value, found.value]),
        np.concatenate([grid.radius, np.maximum(RADIUS * found.sigma, 1e-9)]),
    )


def _least(margins: Real) -> float:
    return max(0.0, float(margins.min())) if margins.size else nan
