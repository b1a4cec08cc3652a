"""Lower bounds on a move's duration that cost no program: each bound alone, and order 3."""

from __future__ import annotations

from math import comb, factorial, inf, isfinite

import numpy as np

from ..closed_moves import closed_form_move
from ..limits import Limits
from ..pieces import FloatArray
from ..rise import spline_divisor
from .proof import CostateLink
from .smoothing import truncated


def least_duration(distance: float, limits: Limits) -> float:
    """Return a time that no move over a distance takes less than; 0 where nothing bounds it.

    The longest perfect spline of one bound alone, or the exact minimum under those up to jerk.
    """
    limits = plain_limits(limits)
    ahead = limits if distance > 0.0 else limits.mirror()
    alone = float(spline_durations(abs(distance), ahead).max())
    for order in (3, 2, 1):
        if all(map(isfinite, limits.bounds(order))):
            low = closed_form_move(distance, truncated(limits, order))
            return max(alone, low.duration)
    return alone


def plain_limits(limits: Limits) -> Limits:
    """Return limits without the bounds that a move from rest to rest of low order never meets."""
    if limits.plain:
        return limits
    pairs = [
        (low if low < 0.0 else -high, high if high > 0.0 else -low)
        for low, high in zip(limits.lower, limits.upper, strict=True)
    ]
    return Limits.from_bounds(pairs)


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
