"""Chains of pulses on arrays: the formulas of `closed_form.chain_form`, every move a lane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..closed_form import spline_peaks
from ..pieces import FloatArray
from ..rise import spline_divisor

_NEWTON_STEPS = 100  # ten are enough

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Chains:
    """Plans of one level: spline rises of some order and the pulses around them, innermost first.

    All arrays are (K,), one entry per move.
    """

    order: int
    span: FloatArray
    peak: FloatArray
    highest: FloatArray
    holds: tuple[FloatArray, ...]
    peaks: tuple[FloatArray, ...]
    duration: FloatArray


def chains(distance: FloatArray, bounds: Sequence[FloatArray], level: int) -> Chains:
    """Plan moves whose innermost rise is the perfect spline of derivative `level`.

    Parameters
    ----------
    distance : (K,) array
        Positive.
    bounds : sequence of (K,) or 0-d arrays
        Symmetric bounds on derivatives 1…n, velocity first; the last one finite.
    level : int
        0 ≤ level < n.
    """
    limit = (distance, *bounds)
    inner = limit[level + 1 :]
    peak, binding = _core_peaks(limit, level)
    span, highest = spline_spans(peak, inner)
    core = (len(inner), span, peak, highest)
    holds, peaks = [], []
    for k in range(level, 0, -1):
        grows = binding >= k
        width, stop = _pulse_widths(limit, k, span, peak)
        binding = np.where(grows, stop, binding)
        hold = np.where(grows, np.maximum(width - span, 0.0), 0.0)
        peak = np.where(binding == k - 1, limit[k - 1], peak * (span + hold))
        span = 2.0 * span + hold
        holds.append(hold)
        peaks.append(peak)
    return Chains(*core, tuple(holds), tuple(peaks), span)


def span_terms(inner: Sequence[FloatArray]) -> list[tuple[FloatArray, float]]:
    """Return (s, 1/i) such that a spline rise to a peak p takes max (s·p)^(1/i), slowest last.

    Only where the last one is the largest does the highest derivative bind.
    """
    m = len(inner)
    divisor = spline_divisor(m)
    factors = [*(c * divisor for c in spline_peaks(m)), divisor]
    return [
        (np.asarray(factor / bound), 1.0 / i)
        for i, (factor, bound) in enumerate(zip(factors, inner, strict=True), start=1)
        if i == m or not _unbounded(bound)
    ]


def spline_spans(peak: FloatArray, inner: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the shortest span of each spline rise within bounds, and its highest derivative."""
    m = len(inner)
    *others, (slope, power) = span_terms(inner)
    full = np.asarray((peak * slope) ** power)
    span = full
    for slope, power in others:
        span = np.maximum(span, (peak * slope) ** power)
    return span, np.where(span == full, inner[-1], peak * spline_divisor(m) / span**m)


def _core_peaks(limit: Sequence[FloatArray], level: int) -> tuple[FloatArray, Indices]:
    """Return the peaks of the innermost splines and the derivatives whose bounds stop them."""
    terms = span_terms(limit[level + 1 :])
    peak = np.array(np.broadcast_to(limit[level], limit[0].shape))
    binding = np.full(peak.shape, level)
    for q in range(1, level + 1):
        if _unbounded(limit[level - q]):
            continue
        # Outer widths that just follow: peak_{level−q} = p·span^q·2^(q(q−1)/2) for each
        # span = (slope·p)^power.
        target = limit[level - q] * 0.5 ** (q * (q - 1) // 2)
        widest: FloatArray = np.full(peak.shape, np.inf)
        for slope, power in terms:
            share = 1.0 / (1.0 + q * power)
            np.minimum(widest, target**share * slope ** (share - 1.0), out=widest)
        stops = widest <= peak
        stops &= np.isfinite(target)
        peak = np.where(stops, widest, peak)
        binding[stops] = level - q
    return peak, binding


def _pulse_widths(
    limit: Sequence[FloatArray], k: int, span: FloatArray, peak: FloatArray
) -> tuple[FloatArray, Indices]:
    """Return the widest pulses of derivative k, and the derivatives whose bounds stop them."""
    width = np.asarray(limit[k - 1] / peak)
    binding = np.full(width.shape, k - 1)
    for q in range(1, k):
        bound = limit[k - 1 - q]
        if _unbounded(bound):
            continue
        # With outer widths that just follow: peak_{k−1−q} = peak·w·(span + w)^q·2^(q(q−1)/2).
        target = bound / peak * 0.5 ** (q * (q - 1) // 2)
        stops = np.isfinite(target) & (width * int_power(span + width, q) >= target)
        [lanes] = np.nonzero(stops)
        if lanes.size:
            width[lanes] = _solve_width(target[lanes], span[lanes], q)
            binding[lanes] = k - 1 - q
    return width, binding


def _unbounded(bound: FloatArray) -> bool:
    """Tell whether a bound is one infinite number for all."""
    return bound.ndim == 0 and bool(np.isinf(bound))


def int_power(base: FloatArray, power: int) -> FloatArray:
    """Return base^power for a power ≥ 1 by multiplication, which is quicker than `**`."""
    result = base
    for _ in range(power - 1):
        result = result * base
    return result


def _solve_width(target: FloatArray, span: FloatArray, q: int) -> FloatArray:
    """Solve w·(span + w)^q = target for w > 0, q ≥ 1, by Newton's method from above."""
    if q == 1:
        return np.asarray(2.0 * target / (span + np.sqrt(span * span + 4.0 * target)))
    width = np.minimum(target ** (1.0 / (q + 1)), target / int_power(span, q))
    for _ in range(_NEWTON_STEPS):
        outer = span + width
        excess = width * outer - target / int_power(outer, q - 1)
        before, width = width, np.minimum(width, width - excess / (outer + q * width))
        if (before - width <= 2.0**-50 * width).all():
            break
    return width
