"""Closed forms of rest-to-rest moves: which bounds are reached, and for how long.

A form starts with a perfect spline as the rise of some derivative k and works outwards: each
lower derivative is the integral of a pulse (up, hold, down). `chain_form` grows the spline and
then every width, innermost first, until the first bound or the distance stops it. With k = n − 1
that is the recursive S-curve (Pourkavoos; Lambrechts; Biagiotti & Melchiorri); with k = n − 2 and
so on, the ramps are Thompson's perfect splines; with k = 0 the whole move is one. `swing_form` is
Thompson's "longer move" without cruise, where acceleration crosses from A to −A in one spline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, isfinite, log, sqrt

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

_SECANT_STEPS = 40


@dataclass(frozen=True)
class ChainForm:
    """A spline rise of some order and the pulses around it, innermost first."""

    order: int
    span: float
    peak: float
    highest: float
    holds: tuple[float, ...]
    peaks: tuple[float, ...]
    duration: float

    def build(self) -> Rise:
        """Return the position rise of this form."""
        rise = spline_rise(self.order, self.span, self.peak, self.highest)
        for hold, peak in zip(self.holds, self.peaks, strict=True):
            rise = pulse_rise(rise, hold, peak)
        return rise


@dataclass(frozen=True)
class SwingForm:
    """Acceleration up to A, held, across to −A in one spline, held, and back to zero.

    `up` and `across` are the span of each spline and the bound of its highest derivative.
    """

    order: int
    acceleration: float
    distance: float
    up: tuple[float, float]
    across: tuple[float, float]
    hold: float
    duration: float

    def build(self) -> Rise:
        """Return the position rise of this form."""
        up_span, up_highest = self.up
        span, highest = self.across
        up = spline_rise(self.order, up_span, self.acceleration, up_highest)
        across = spline_rise(self.order, span, 2.0 * self.acceleration, highest)
        return swing_rise(up, self.hold, across, self.distance)


def chain_form(distance: float, bounds: Sequence[float], level: int) -> ChainForm:
    """Return the move whose innermost rise is the perfect spline of derivative `level`.

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
    order = len(bounds) - level
    peak, binding = _core_peak(limit, level)
    span, highest = spline_span(peak, limit[level + 1 :])
    core = (order, span, peak, highest)
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
    return ChainForm(*core, tuple(holds), tuple(peaks), span)


def swing_form(distance: float, bounds: Sequence[float]) -> SwingForm | None:
    """Return Thompson's longer move without cruise (Section IV); None where it breaks a bound.

    Where the distance is too short to hold A, A is lowered until the hold vanishes.
    """
    order = len(bounds) - 2
    if order < 1 or not isfinite(bounds[1]):
        return None
    velocity, acceleration, inner = bounds[0], bounds[1], bounds[2:]
    velocity_gain, position_gain = crossing_gains(order)
    excess = 0.5 * (distance - _swing_distance(acceleration, inner, position_gain)) / acceleration
    if excess < 0.0:
        acceleration = _solve_acceleration(distance, acceleration, inner, position_gain)
        excess = 0.0
    up, across = spline_span(acceleration, inner), spline_span(2.0 * acceleration, inner)
    # R/2 = a·(h²/2 + b·h) + R(h = 0)/2, the position at the middle
    b = 0.5 * (up[0] + across[0])
    hold = 2.0 * excess / (b + sqrt(b * b + 2.0 * excess))
    if acceleration * (0.5 * up[0] + hold + velocity_gain * across[0]) > velocity:
        return None
    duration = 2.0 * (up[0] + hold) + across[0]
    return SwingForm(order, acceleration, distance, up, across, hold, duration)


def fastest_form(distance: float, bounds: Sequence[float]) -> ChainForm | SwingForm:
    """Return the shortest of all closed forms; for n ≤ 3 it is the minimum time."""
    forms: list[ChainForm | SwingForm] = [
        chain_form(distance, bounds, level) for level in range(len(bounds))
    ]
    swing = swing_form(distance, bounds)
    if swing is not None:
        forms.append(swing)
    return min(forms, key=lambda form: form.duration)


def spline_span(peak: float, inner: Sequence[float]) -> tuple[float, float]:
    """Return the shortest span of a spline rise within bounds, and its highest derivative.

    Parameters
    ----------
    peak : float
        What the rise reaches.
    inner : sequence of float
        Bounds on its derivatives 1…m, the last one finite. Where one below m binds, the spline
        is slower than derivative m alone would allow, which lowers that derivative.
    """
    m = len(inner)
    divisor = spline_divisor(m)
    full = (peak / inner[-1] * divisor) ** (1.0 / m)
    span = full
    for i, c in enumerate(spline_peaks(m), start=1):
        span = max(span, (c * divisor * peak / inner[i - 1]) ** (1.0 / i))
    if not (span**m):
        raise OverflowError
    return span, inner[-1] if span == full else peak * divisor / span**m


@lru_cache(maxsize=64)
def spline_peaks(order: int) -> tuple[float, ...]:
    """Return c_k for derivatives k = 1…n−1 of a perfect spline: peak = c_k·D·T^(n−k)."""
    unit = unit_spline(order)
    peaks = []
    for k in range(1, order):
        low, high = extrema(unit.durations, unit.rows[k:])
        peak = max(float(high.max()), -float(low.min()))
        peaks.append(peak / spline_divisor(order))
    return tuple(peaks)


@lru_cache(maxsize=64)
def crossing_gains(order: int) -> tuple[float, float]:
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


def _swing_distance(acceleration: float, inner: Sequence[float], gain: float) -> float:
    """Return the distance of a swing without hold."""
    up, across = spline_span(acceleration, inner)[0], spline_span(2.0 * acceleration, inner)[0]
    return 2.0 * acceleration * ((0.25 - gain) * up * up + 0.25 * up * across + gain * across**2)


def _solve_acceleration(
    distance: float, acceleration: float, inner: Sequence[float], gain: float
) -> float:
    """Return the acceleration, below the one given, whose swing without hold covers a distance.

    Secant steps in logarithms: the distance is a power of the acceleration, or a few of them in
    turn with exponents of 3 at most.
    """
    excess = log(_swing_distance(acceleration, inner, gain) / distance)
    step = -excess / 3.0
    for _ in range(_SECANT_STEPS):
        acceleration *= exp(step)
        before, excess = excess, log(_swing_distance(acceleration, inner, gain) / distance)
        if abs(excess) < 1e-15 or excess == before:
            break
        step *= excess / (before - excess)
    return acceleration


def _core_peak(limit: Sequence[float], level: int) -> tuple[float, int]:
    """Return the peak of the innermost spline and the derivative whose bound stops it.

    Of several that bind it is the outermost, so that no width between is left with a hold that
    is nothing but rounding.
    """
    inner = limit[level + 1 :]
    m, divisor = len(inner), spline_divisor(len(inner))
    slopes = [c * divisor / bound for c, bound in zip(spline_peaks(m), inner, strict=False)]
    slopes.append(divisor / inner[-1])
    peak, binding = limit[level], level
    for q in range(1, level + 1):
        # Outer widths that just follow: peak_{level−q} = p·span^q·2^(q(q−1)/2) for each
        # span = (slope·p)^(1/i) of `spline_span`.
        target = limit[level - q] / 2.0 ** (q * (q - 1) // 2)
        widest = min(
            target ** (i / (i + q)) * slope ** (-q / (i + q)) if slope else inf
            for i, slope in enumerate(slopes, start=1)
        )
        if widest <= peak:
            peak, binding = widest, level - q
    return peak, binding


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
    if not (span**q):
        raise OverflowError
    width = float(min(target ** (1.0 / (q + 1)), target / span**q))
    while True:
        outer = span + width
        excess = width * outer - target / outer ** (q - 1)
        lower = width - excess / (outer + q * width)
        if not lower < width:
            return width
        width = lower
