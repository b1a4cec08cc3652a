"""Closed-form plans of rest-to-rest moves: which bounds are reached, and for how long.

A plan starts with a perfect spline as the rise of some derivative k and works outwards: each
lower derivative is the integral of a pulse (up, hold, down). `chain_plan` grows every width,
innermost first, until the first bound or the distance stops it. With k = n − 1 that is the
recursive S-curve (Pourkavoos; Lambrechts; Biagiotti & Melchiorri); with k = n − 2 and so on, the
ramps are Thompson's perfect splines; with k = 0 the whole move is one. `swing_plan` is Thompson's
"longer move" without cruise, where acceleration crosses over from A to −A in a single spline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, sqrt

from .pieces import RealArray, advance, extrema
from .rise import (
    Rise,
    prepend_integral,
    pulse_rise,
    spline_divisor,
    spline_rise,
    swing_rise,
    unit_spline,
)


@dataclass(frozen=True)
class ChainPlan:
    """A spline rise of some order and the pulses around it, innermost first."""

    order: int
    span: float
    peak: float
    highest: float
    holds: tuple[float, ...]
    peaks: tuple[float, ...]
    duration: float

    def build(self) -> Rise:
        """Return the position rise of this plan."""
        rise = spline_rise(self.order, self.span, self.peak, self.highest)
        for hold, peak in zip(self.holds, self.peaks, strict=True):
            rise = pulse_rise(rise, hold, peak)
        return rise


@dataclass(frozen=True)
class SwingPlan:
    """Acceleration up to A, held, across to −A in one spline, held, and back to zero."""

    order: int
    acceleration: float
    distance: float
    span: float
    crossing: float
    hold: float
    highest: float
    duration: float

    def build(self) -> Rise:
        """Return the position rise of this plan."""
        a, u = self.acceleration, self.highest
        up = spline_rise(self.order, self.span, a, u)
        across = spline_rise(self.order, self.crossing, 2.0 * a, u)
        return swing_rise(up, self.hold, across, self.distance)


def chain_plan(distance: float, bounds: Sequence[float], level: int) -> ChainPlan | None:
    """Plan a move whose innermost rise is the perfect spline of derivative `level`.

    None where a bound stops the spline of level 0 short of the distance.

    Parameters
    ----------
    distance : float
        Positive.
    bounds : sequence of float
        Symmetric bounds on derivatives 1…n, velocity first; the last one finite.
    level : int
        0 ≤ level < n.
    """
    limit = (distance, *bounds)
    highest, order = limit[-1], len(bounds) - level
    span, binding = _core_span(limit, level)
    if binding > level == 0:
        return None
    peak = limit[level] if binding == level else highest / spline_divisor(order) * span**order
    core = (order, span, peak)
    holds, peaks = [], []
    for k in range(level, 0, -1):
        hold = 0.0
        if binding >= k:
            width, binding = _pulse_width(limit, k, span, peak)
            hold = max(width - span, 0.0)
        peak = limit[k - 1] if binding == k - 1 else peak * (span + hold)
        span = 2.0 * span + hold
        holds.append(hold)
        peaks.append(peak)
    return ChainPlan(*core, highest, tuple(holds), tuple(peaks), span)


def swing_plan(distance: float, bounds: Sequence[float]) -> SwingPlan | None:
    """Plan Thompson's longer move without cruise (Section IV); None where it breaks a bound.

    Where the distance is too short to hold A, A is lowered until the hold vanishes.
    """
    order = len(bounds) - 2
    highest, velocity = bounds[-1], bounds[0]
    if order < 1 or not isfinite(bounds[1]):
        return None
    velocity_gain, position_gain = _crossing_gains(order)
    ratio = 2.0 ** (1.0 / order)
    a = bounds[1]
    span = (a / highest * spline_divisor(order)) ** (1.0 / order)
    # R/2 = a·(h²/2 + b·h + c): position at the middle, as a function of the hold h.
    b = 0.5 * (1.0 + ratio) * span
    c = (0.25 * (1.0 + ratio) + position_gain * (ratio**2 - 1.0)) * span**2
    excess = 0.5 * distance / a - c
    if excess < 0.0:
        shrink = (0.5 * distance / (a * c)) ** (1.0 / (order + 2))
        span *= shrink
        a *= shrink**order
        hold = 0.0
    else:
        hold = 2.0 * excess / (b + sqrt(b * b + 2.0 * excess))
    crossing = ratio * span
    peak_velocity = a * (0.5 * span + hold + velocity_gain * crossing)
    peaks = (highest * c * crossing**p for c, p in spline_peaks(order))
    if peak_velocity > velocity or any(p > b for p, b in zip(peaks, bounds[2:], strict=False)):
        return None
    duration = 2.0 * (span + hold) + crossing
    return SwingPlan(order, a, distance, span, crossing, hold, highest, duration)


def fastest_plan(distance: float, bounds: Sequence[float]) -> ChainPlan | SwingPlan:
    """Return the shortest of all closed-form plans; for n ≤ 3 it is the minimum time."""
    plans = [chain_plan(distance, bounds, level) for level in range(len(bounds))]
    feasible = [plan for plan in (*plans, swing_plan(distance, bounds)) if plan is not None]
    return min(feasible, key=lambda plan: plan.duration)


@lru_cache(maxsize=64)
def spline_peaks(order: int) -> tuple[tuple[float, int], ...]:
    """Return (c, p) for derivatives 1…n−1 of a perfect spline: peak = c·D·T^p, p = n − k."""
    unit = unit_spline(order)
    peaks = []
    for k in range(1, order):
        low, high = extrema(unit.durations, unit.rows[k:])
        peak = max(float(high.max()), -float(low.min()))
        peaks.append((peak / spline_divisor(order), order - k))
    return tuple(peaks)


@lru_cache(maxsize=64)
def _crossing_gains(order: int) -> tuple[float, float]:
    """Return the first and second integral of the crossing 1 → −1 over its first half.

    For the unit spline s the crossing is 1 − 2s; the double integral of s over the whole span is
    then 1/4 less the second of these.
    """
    unit = unit_spline(order)
    rows: RealArray = -2.0 * unit.rows
    rows[0] += 1.0
    for _ in range(2):
        rows = prepend_integral(unit.durations, rows, 0.0, rise=False)
    middle = order // 2
    tau = 0.5 * float(unit.durations[middle]) if order % 2 else 0.0
    state = advance(rows[:, middle], tau)
    return float(state[1]), float(state[0])


def _core_span(limit: Sequence[float], level: int) -> tuple[float, int]:
    """Return the span of the innermost spline and the derivative whose bound stops it.

    The derivative returned is the outermost one that is not above `level`, or `level` + 1 where
    a bound inside the spline stops it.
    """
    order = len(limit) - 1 - level
    highest, divisor = limit[-1], spline_divisor(order)
    span, binding = inf, level + 1
    for (c, p), bound in zip(spline_peaks(order), limit[level + 1 :], strict=False):
        span = min(span, (bound / (c * highest)) ** (1.0 / p))
    for q in range(level + 1):
        # Outer widths that just follow the spline: peak_{level−q} = peak·span^q·2^(q(q−1)/2).
        ratio = limit[level - q] / highest * (divisor / 2.0 ** (q * (q - 1) // 2))
        widest = ratio ** (1.0 / (order + q))
        if widest <= span:
            span, binding = widest, level - q
    return span, binding


def _pulse_width(limit: Sequence[float], k: int, span: float, peak: float) -> tuple[float, int]:
    """Return the widest pulse of derivative k, and the derivative whose bound stops it."""
    width, binding = inf, k - 1
    for q in range(k):
        # With outer widths that just follow: peak_{k−1−q} = peak·w·(span + w)^q·2^(q(q−1)/2).
        target = limit[k - 1 - q] / peak / 2.0 ** (q * (q - 1) // 2)
        if isfinite(target) and width * (span + width) ** q >= target:
            width, binding = _solve_width(target, span, q), k - 1 - q
    return width, binding


def _solve_width(target: float, span: float, q: int) -> float:
    """Solve w·(span + w)^q = target for w > 0 by Newton's method from above."""
    if q == 0:
        return target
    if q == 1:
        return 2.0 * target / (span + sqrt(span * span + 4.0 * target))
    width = float(min(target ** (1.0 / (q + 1)), target / span**q))
    while True:
        outer = span + width
        excess = width * outer - target / outer ** (q - 1)
        lower = width - excess / (outer + q * width)
        if not lower < width:
            return width
        width = lower
