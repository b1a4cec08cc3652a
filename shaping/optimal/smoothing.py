"""A move of higher order from one of lower order: its input run through moving averages."""

from __future__ import annotations

from itertools import pairwise
from math import comb

import numpy as np

from ..limits import Limits
from ..pieces import RealArray
from ..trajectory import Trajectory
from .half_motion import Half

_SAME_TIME = 1e-14  # of the shortest piece or average: breaks nearer than that are one
_ROUNDING = 1e-15


def lower_order(limits: Limits) -> int:
    """Return the order below n from which the shortest averages lead to n, or 0."""
    bounded = np.isfinite(limits.lower[:-1]) & np.isfinite(limits.upper[:-1])
    orders = (np.flatnonzero(bounded)[::-1] + 1).tolist()
    return int(min(orders, key=lambda order: relative_width(limits, order, 1.0), default=0))


def averaging_width(limits: Limits, order: int) -> float:
    """Return the width of each of n − m moving averages that make order m into order n.

    w = max_k 2·(L_m / L_k)^(1/(k−m)), k = m + 1 … n:   |x^(k)| ≤ 2^(k−m)·L_m / w^(k−m)
    """
    below, above = -np.array(limits.lower), np.array(limits.upper)
    size, bounds = max(below[order - 1], above[order - 1]), np.minimum(below, above)[order:]
    with np.errstate(divide="ignore"):  # no average is long enough for a bound of zero
        ratios = size / bounds
    return float((2.0 * ratios ** (1.0 / np.arange(1, len(bounds) + 1))).max())


def averaged_half(move: Trajectory, order: int, width: float) -> Half:
    """Return the first half of a symmetric move after moving averages, see `averaged`."""
    lengths, inputs = averaged(move, order, width)
    half = (len(lengths) + 1) // 2
    lengths = lengths[:half] * np.where(np.arange(half) == len(lengths) // 2, 0.5, 1.0)
    return Half(lengths, inputs[:half], order, _ROUNDING)


def averaged(move: Trajectory, order: int, width: float) -> tuple[RealArray, RealArray]:
    """Return lengths and inputs of a move's pieces after q = n − m moving averages, of order n.

        x^(n)(t) = Σ_j (−1)^j·C(q, j)·x^(m)(t − j·w) / w^q

    An average of x^(m) over the last w keeps every bound and takes w longer; its derivative is
    (x^(m)(t) − x^(m)(t − w)) / w, constant between breaks again.
    """
    count, w = order - move.order, np.longdouble(width)
    durations: RealArray = move.durations.astype(np.longdouble)
    inputs = np.concatenate([[0.0], move.states[:, -1], [0.0]]).astype(np.longdouble)
    shifts, signs = np.arange(count + 1), [(-1) ** j * comb(count, j) for j in range(count + 1)]
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    times = edges + shifts[:, None] * w
    shift, edge = np.divmod(np.argsort(times, axis=None, kind="stable"), len(edges))
    begun = np.maximum.accumulate(np.where(shift == shifts[:, None], edge + 1, 0), axis=1)
    lengths = np.diff(shift) * w + [
        durations[i:j].sum() - durations[j:i].sum() for i, j in pairwise(edge)
    ]
    kept = lengths > _SAME_TIME * min(durations.min(), w)
    return lengths[kept], (signs @ inputs[begun])[:-1][kept] / w**count


def relative_width(limits: Limits, order: int, duration: float) -> float:
    """Return how much longer, relative to a duration, the moving averages make a move."""
    return (limits.order - order) * averaging_width(limits, order) / duration


def truncated(limits: Limits, order: int) -> Limits:
    """Return the limits without the derivatives above `order`."""
    pairs = zip(limits.lower[:order], limits.upper[:order], strict=True)
    return Limits.from_bounds(pairs)


def even_are_symmetric(limits: Limits) -> bool:
    """Tell whether bounds on even derivatives are the same in both directions."""
    return all(limits.lower[k] == -limits.upper[k] for k in range(1, limits.order, 2))
