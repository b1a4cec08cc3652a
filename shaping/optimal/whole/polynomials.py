"""Polynomials in the duration: their first root, and the proof that they are positive before."""

from __future__ import annotations

from functools import lru_cache
from math import comb, inf

import numpy as np

from ...pieces import FloatArray

_HALVINGS = 60
_ROUNDING = 1e-13  # of the sum of sizes of a polynomial's terms: taken off before it counts


def value(coefficients: FloatArray, time: float) -> float:
    """Return Σ c_k·T^k."""
    total = 0.0
    for coefficient in reversed(coefficients.tolist()):
        total = total * time + coefficient
    return float(total)


def first_root(coefficients: FloatArray, after: float, until: float = inf) -> float:
    """Return the first T > after up to which a polynomial is proven positive from `after` on.

    `after` itself where it is not positive there, and `until` where there is no root before.
    """
    if not value(coefficients, after) > 0.0:
        return after
    scaled = coefficients * max(after, 1e-300) ** np.arange(len(coefficients))
    roots = np.polynomial.polynomial.polyroots(np.trim_zeros(scaled, "b"))
    real = roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots)] * after
    later = np.sort(real[real > after])
    for root in [*later.tolist(), until]:
        if root > until:
            root = until
        if root == inf:
            return inf if _positive_for_ever(coefficients, after) else after
        for backward in (1e-14, 1e-11, 1e-8, 1e-5):
            at = max(root * (1.0 - backward), after)
            if is_positive(coefficients, after, at):
                return float(at)
    return after


def last_root(coefficients: FloatArray, before: float) -> float:
    """Return the last T < before at which a polynomial is zero, by its roots; 0 where none is."""
    roots = np.polynomial.polynomial.polyroots(np.trim_zeros(coefficients, "b"))
    real = roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots)]
    return float(max(real[(real > 0.0) & (real < before)], default=0.0))


def is_positive(coefficients: FloatArray, low: float, high: float) -> bool:
    """Tell whether a polynomial is proven positive on [low, high], rounding allowed for.

    Bernstein coefficients on halves of halves: where all are positive so is the polynomial.
    """
    pending = [(low, high, 0)]
    while pending:
        left, right, depth = pending.pop()
        bernstein, size = bernstein_on(coefficients, left, right)
        if bernstein.min() > _ROUNDING * size:
            continue
        if min(bernstein[0], bernstein[-1]) <= _ROUNDING * size or depth == _HALVINGS:
            return False
        middle = 0.5 * (left + right)
        pending += [(left, middle, depth + 1), (middle, right, depth + 1)]
    return True


def bernstein_on(coefficients: FloatArray, low: float, high: float) -> tuple[FloatArray, float]:
    """Return the Bernstein coefficients on [low, high], and the size of the terms they sum."""
    d = len(coefficients) - 1
    basis, shifts, lags = _bases(d)
    powers = np.arange(d + 1)
    taylor = (shifts * low**lags) @ coefficients * (high - low) ** powers
    return basis @ taylor, float(np.sum(np.abs(coefficients) * high**powers))


@lru_cache(maxsize=32)
def _bases(d: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the matrix from powers to Bernstein's, and C(k, i) and k − i of a Taylor shift."""
    basis = np.array([[comb(j, i) / comb(d, i) for i in range(d + 1)] for j in range(d + 1)])
    shifts = np.array([[float(comb(k, i)) for k in range(d + 1)] for i in range(d + 1)])
    lags = np.array([[float(max(k - i, 0)) for k in range(d + 1)] for i in range(d + 1)])
    return basis, shifts, lags


def _positive_for_ever(coefficients: FloatArray, after: float) -> bool:
    """Tell whether a polynomial stays positive: in 1/T on (0, 1/after]."""
    trimmed = np.trim_zeros(coefficients, "b")
    if after <= 0.0:
        return bool((trimmed >= 0.0).all() and trimmed.any())
    return trimmed[-1] > 0.0 and is_positive(trimmed[::-1], 0.0, 1.0 / after)
