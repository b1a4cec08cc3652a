"""A move of higher order from one of lower order: its input run through moving averages."""

from __future__ import annotations

import numpy as np

from ..limits import Limits
from ..pieces import RealArray
from ..trajectory import Trajectory
from .half_motion import Half

_SAME_TIME = 1e-15  # of the duration: breaks nearer than that are one


def lower_order(limits: Limits) -> int:
    """Return the highest bounded derivative below n, or 0."""
    bounded = np.isfinite(limits.lower[:-1]) | np.isfinite(limits.upper[:-1])
    return int(np.flatnonzero(bounded)[-1]) + 1 if bounded.any() else 0


def averaging_width(limits: Limits, order: int) -> float:
    """Return the width of each of n − m moving averages that make order m into order n.

    w = 2·(L_m / L_n)^(1/(n−m)):   |x^(n)| ≤ 2^(n−m)·L_m / w^(n−m)
    """
    (low, high), (lowest, highest) = limits.bounds(order), limits.bounds(limits.order)
    steps = limits.order - order
    return float(2.0 * (max(-low, high) / min(-lowest, highest)) ** (1.0 / steps))


def averaged_half(move: Trajectory, order: int, width: float) -> Half:
    """Return the first half of a symmetric move after n − m moving averages, of order n.

    An average of x^(m) over the last w keeps every bound and takes w longer; its derivative is
    (x^(m)(t) − x^(m)(t − w)) / w, constant between breaks again.
    """
    durations: RealArray = move.durations.astype(np.longdouble)
    inputs = np.asarray(move.states[:, -1], dtype=np.longdouble)
    for _ in range(order - move.order):
        durations, inputs = _averaged(durations, inputs, width)
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    middle = 0.5 * edges[-1]
    first = edges[:-1] < middle * (1.0 - 1e-15)
    durations = np.minimum(edges[1:], middle)[first] - edges[:-1][first]
    return Half(durations, np.asarray(inputs[first], dtype=float), order)


def _averaged(durations: RealArray, inputs: RealArray, width: float) -> tuple[RealArray, RealArray]:
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    later = edges + np.longdouble(width)
    every = np.sort(np.concatenate([edges, later]))
    apart = np.diff(every) > _SAME_TIME * every[-1]
    every = np.concatenate([[0.0], every[1:][apart]])
    middles = 0.5 * (every[1:] + every[:-1])
    change = _at(edges, inputs, middles) - _at(later, inputs, middles)
    return np.diff(every), change / np.longdouble(width)


def _at(edges: RealArray, inputs: RealArray, times: RealArray) -> RealArray:
    """Evaluate the pieces, zero outside."""
    index = np.searchsorted(edges, times) - 1
    inside = (index >= 0) & (index < len(inputs))
    return np.where(inside, inputs[np.clip(index, 0, len(inputs) - 1)], 0.0)


def relative_width(limits: Limits, order: int, duration: float) -> float:
    """Return how much longer, relative to a duration, the moving averages make a move."""
    return (limits.order - order) * averaging_width(limits, order) / duration


def truncated(limits: Limits, order: int) -> Limits:
    """Return the limits without the derivatives above `order`."""
    pairs = zip(limits.lower[:order], limits.upper[:order], strict=True)
    return Limits.from_bounds(pairs)
