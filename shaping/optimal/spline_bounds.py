"""What the bound on one derivative alone says of a move: no less time than a perfect spline."""

from __future__ import annotations

from math import comb, factorial, inf

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from ..rise import spline_divisor
from .proof import CostateLink


def spline_durations(distance: float, limits: Limits) -> FloatArray:
    """Return how long a move takes at least by the bound on each derivative alone, index k.

        (R/D_k·(k − 1)!·4^(k−1))^(1/k),   D_k = hi_k·∫p⁺ − lo_k·∫p⁻

    with p = U_(k−1), a Chebyshev polynomial, see `spline_link`. Zero where there is no bound.
    """
    durations = np.zeros(limits.order + 1)
    for k in range(1, limits.order + 1):
        bound = sum(spline_terms(k, limits))
        if bound < inf:
            durations[k] = (distance / bound * spline_divisor(k)) ** (1.0 / k)
    return durations


def spline_terms(k: int, limits: Limits) -> tuple[float, float]:
    """Return −lo_k·∫p⁻ and hi_k·∫p⁺: the integral of p is 1/k for odd k, else 0; that of |p| 1."""
    low, high = limits.bounds(k)
    share = 0.5 / k if k % 2 else 0.0
    return 0.0 if k == 1 else -low * (0.5 - share), high * (0.5 + share)


def spline_link(k: int) -> CostateLink:
    """Return the multipliers: p(1 − s) = U_(k−1)(2s − 1) = Σ_j λ_(k−1−j)·s^j/j!, no measures."""
    ends = [
        (-1) ** (k - 1 - j) * comb(k + j, 2 * j + 1) * 4**j * factorial(j)
        for j in range(k - 1, -1, -1)
    ]
    return CostateLink(0.0, 0.0, (1.0,), tuple(map(float, ends)), (), ())
