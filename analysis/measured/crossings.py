"""Where a measured loop crosses a level: once for each cluster of points that noise puts on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .loop_grid import LoopGrid
from .rational_fits import Complex, Real

_SURE = 1.5  # standard deviations off the level
_LEAST_GAIN = 0.01
_MATTERS = 0.1  # |L| of a place that is told as unsure
_MOST_SPREAD = 0.5  # of |L|: more is noise
_DIVISIONS = 6
_SHARES = np.linspace(0.0, 1.0, 41)

Excess = Callable[[Complex], Real]


class Crossings(NamedTuple):
    """Where L crosses a level, ascending, L and its standard deviation there, and the slopes.

    `slope` is d ln L/d ln f. `unsure` are places where L comes so near that noise hides whether
    it crosses.
    """

    frequency_hz: Real
    value: Complex
    sigma: Real
    slope: Complex
    unsure: Real


def gain_crossings(grid: LoopGrid) -> Crossings:
    """Return where |L| = 1."""
    return _crossings(grid, lambda value: np.log(np.maximum(abs(value), 1e-300)), np.inf)


def phase_crossings(grid: LoopGrid) -> Crossings:
    """Return where L is real and negative, but where |L| < −40 dB or is mostly noise."""
    found = _crossings(grid, lambda value: np.angle(-value), 0.5 * np.pi)
    size = abs(found.value)
    kept = (size > _LEAST_GAIN) & (found.sigma < _MOST_SPREAD * size)
    places, value, sigma, slope, unsure = found
    near = grid.loop.at(unsure)
    loud = (abs(near.value) > _MATTERS) & (near.sigma < _MOST_SPREAD * abs(near.value))
    return Crossings(places[kept], value[kept], sigma[kept], slope[kept], unsure[loud])


def _crossings(grid: LoopGrid, excess: Excess, most: float) -> Crossings:
    """Return the crossings of excess = 0 among points where it is below `most` in size."""
    off = excess(grid.value)
    spread = grid.sigma / (np.sqrt(2.0) * np.maximum(abs(grid.value), 1e-300))
    near = abs(off) <= np.minimum(_SURE * spread, most)
    changes = (off[:-1] >= 0.0) != (off[1:] >= 0.0)
    changes &= (abs(off[:-1]) < most) & (abs(off[1:]) < most) & grid.joined
    before = np.flatnonzero(changes)
    kept, unsure = [], []
    for cluster in _clusters(before, near):
        middle = int(cluster[len(cluster) // 2])
        if len(cluster) % 2:
            kept.append(middle)
        else:
            unsure.append(grid.frequency_hz[middle])
    places = _solved(grid, excess, np.array(kept, dtype=np.intp))
    value, sigma, _ = grid.loop.at(places)
    slope = grid.loop.logarithmic_slope(places)
    return Crossings(places, value, sigma, slope, np.array(unsure))


def _clusters(before: NDArray[np.intp], near: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Return changes of sign in groups between whose members no point is surely off the level."""
    if not before.size:
        return []
    sure = np.concatenate([[0], np.cumsum(~near)])
    parted = sure[before[1:] + 1] - sure[before[:-1] + 1] > 0
    return np.split(before, np.flatnonzero(parted) + 1)


def _solved(grid: LoopGrid, excess: Excess, before: NDArray[np.intp]) -> Real:
    """Return where excess first vanishes between a point and the next, by division in many."""
    low, high = grid.frequency_hz[before], grid.frequency_hz[before + 1]
    positive = (excess(grid.value[before]) >= 0.0)[:, None]
    every = np.arange(len(before))
    for _ in range(_DIVISIONS if len(before) else 0):
        places = low[:, None] + (high - low)[:, None] * _SHARES
        inner = excess(grid.loop.value(places[:, 1:-1].ravel())).reshape(len(before), -1)
        beyond = np.argmax(np.pad((inner >= 0.0) != positive, ((0, 0), (0, 1))), axis=1)
        none = ((inner >= 0.0) == positive).all(axis=1)
        after = np.where(none, inner.shape[1], beyond)
        low, high = places[every, after], places[every, after + 1]
    return np.asarray(0.5 * (low + high))
