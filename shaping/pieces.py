"""Polynomial pieces in Taylor form: evaluation, integration, exact extrema."""

from __future__ import annotations

from functools import lru_cache
from math import comb, factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
RealArray = NDArray[np.floating[Any]]
"""Of any precision: the unit splines are made in extended precision."""

MAX_ORDER = 40
"""Highest polynomial order handled: beyond it (order)! leaves the useful range of a double."""

MAX_MOVE_ORDER = 14
"""Highest order of `min_time_move`: the recursion of order n has up to 2ⁿ − 1 pieces."""

MAX_SAMPLES = 10**9
"""Longest time grid."""

INVERSE_FACTORIALS = np.array([1.0 / factorial(j) for j in range(MAX_ORDER + 2)])

_BISECTIONS = 40  # locates a stationary point to 1e-12 of its piece, its value to 1e-24
_ROUNDING = 1e-15  # of the largest magnitude


def integral(durations: RealArray, rows: RealArray) -> RealArray:
    """Return the change of the integral over each piece, shape (m,).

    Parameters
    ----------
    durations : (m,) array
    rows : (q + 1, m) array
        Value and derivatives 1…q at each piece's start.
    """
    total = rows[-1] * INVERSE_FACTORIALS[len(rows)]
    for j in range(len(rows) - 1, 0, -1):
        total = total * durations + rows[j - 1] * INVERSE_FACTORIALS[j]
    return np.asarray(total * durations)


def advance(state: RealArray, tau: float) -> FloatArray:
    """Return the Taylor state `tau` later, shape (n + 1,)."""
    later: FloatArray = evaluate(state[:, None], np.array([tau]), range(len(state)))
    return later[:, 0]


def evaluate(rows: RealArray, tau: RealArray, derivatives: range) -> FloatArray:
    """Evaluate one piece per point.

    Parameters
    ----------
    rows : (n + 1, N) array
        Taylor state of the piece that each point lies in.
    tau : (N,) array
        Time since that piece's start.
    derivatives : range
        Consecutive derivatives wanted, within 0…n.

    Returns
    -------
    (len(derivatives), N) array
    """
    highest, *lower = _factors(len(rows) - 1, derivatives.start, len(derivatives))
    out: FloatArray = rows[-1] * highest
    for row, factors in zip(rows[-2::-1], lower, strict=False):
        active = out[: len(factors)]
        active *= tau
        active += row * factors
    return out


@lru_cache(maxsize=256)
def _factors(n: int, first: int, count: int) -> tuple[FloatArray, ...]:
    """Return 1/(j − k)! for j = n, n − 1, …, `first`, a column over k = first … min(j, last)."""
    columns = []
    for j in range(n, first - 1, -1):
        k = np.arange(first, min(j + 1, first + count))
        columns.append(INVERSE_FACTORIALS[j - k][:, None])
    return tuple(columns)


def extrema(durations: RealArray, rows: RealArray) -> tuple[FloatArray, FloatArray]:
    """Return the exact minimum and maximum of each piece, two arrays of shape (m,).

    Parameters
    ----------
    durations : (m,) array
    rows : (q + 1, m) array
        Value and derivatives 1…q at each piece's start.
    """
    unit = _on_unit(durations, rows)
    ends = np.array([unit[0], unit[::-1].sum(axis=0)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    turning = _may_turn(unit)
    if turning.any():
        inner = unit[:, turning]
        values = _horner(inner, _stationary_points(inner))
        low[turning] = np.minimum(low[turning], values.min(axis=0))
        high[turning] = np.maximum(high[turning], values.max(axis=0))
    return low, high


def extremes(durations: RealArray, rows: RealArray) -> tuple[float, float]:
    """Return the exact minimum and maximum of all pieces, given as for `extrema`.

    Only those pieces are looked into that may go beyond what all have at their ends, by more than
    its rounding.
    """
    unit = _on_unit(durations, rows)
    ends = np.array([unit[0], unit[::-1].sum(axis=0)])
    low, high = float(ends.min()), float(ends.max())
    hull = _bernstein(unit)
    doubt = _ROUNDING * max(-low, high)
    beyond = (hull.min(axis=0) < low - doubt) | (hull.max(axis=0) > high + doubt)
    if beyond.any():
        least, most = extrema(durations[beyond], rows[:, beyond])
        low, high = min(low, float(least.min())), max(high, float(most.max()))
    return low, high


def _on_unit(durations: RealArray, rows: RealArray) -> FloatArray:
    """Return the power coefficients (q + 1, m) of each piece on [0, 1]."""
    powers = durations ** np.arange(len(rows))[:, None]
    return np.asarray(rows * powers * INVERSE_FACTORIALS[: len(rows), None])


def _bernstein(unit: FloatArray) -> FloatArray:
    """Return Bernstein coefficients: i is the sum over j of C(i, j) / C(q, j) times power j."""
    q = len(unit) - 1
    basis = np.array([[comb(i, j) / comb(q, j) for j in range(q + 1)] for i in range(q + 1)])
    return np.asarray(basis @ unit)


def _may_turn(unit: FloatArray) -> NDArray[np.bool_]:
    """Tell which polynomials on [0, 1] are not proven monotone by their Bernstein form."""
    if len(unit) < 3:
        return np.zeros(unit.shape[1], dtype=bool)
    bernstein = _bernstein(_slope(unit))
    return np.asarray((bernstein.min(axis=0) < 0.0) & (bernstein.max(axis=0) > 0.0))


def _slope(unit: FloatArray) -> FloatArray:
    """Return the power coefficients of the derivative."""
    return np.asarray(unit[1:] * np.arange(1, len(unit))[:, None])


def _horner(unit: FloatArray, points: FloatArray) -> FloatArray:
    """Evaluate polynomials (q + 1, m) at points (p, m)."""
    total = np.broadcast_to(unit[-1], points.shape)
    for coefficient in unit[-2::-1]:
        total = total * points + coefficient
    return np.asarray(total)


def _stationary_points(unit: FloatArray) -> FloatArray:
    """Return points in [0, 1], shape (p, m), among which are all where the slope changes sign.

    Between neighbouring stationary points of the slope the slope is monotone, so that a
    bisection finds the one sign change that may lie there; an interval without one gives its
    right end, which is harmless to a minimum or maximum over the points.
    """
    slope = _slope(unit)
    m = unit.shape[1]
    edges = np.zeros((1, m))
    if len(slope) > 2:
        edges = np.vstack([edges, np.sort(_stationary_points(slope), axis=0)])
    left, right = edges, np.vstack([edges[1:], np.ones((1, m))])
    rising = _horner(slope, left) < 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (left + right)
        before = (_horner(slope, middle) < 0.0) == rising
        left = np.where(before, middle, left)
        right = np.where(before, right, middle)
    return right
