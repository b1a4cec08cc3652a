"""Rises of many moves: pieces of closed forms on arrays, as `rise` builds them one by one.

Durations are (m, K) and rows (q + 1, m, K): value and derivatives 1…q of a derivative at the
starts of m pieces, for K moves of the same form. A hold that a move does without has duration 0.
"""

from __future__ import annotations

import numpy as np

from ..pieces import FloatArray, integral
from ..rise import unit_spline
from .chains import Chains
from .swings import Swings

Rows = tuple[FloatArray, FloatArray]
"""Durations and rows."""


def chain_pieces(form: Chains) -> Rows:
    """Return the pieces of chains: durations (m, K) and states (n + 1, m, K)."""
    durations, rows = _spline(form.order, form.span, form.peak, form.highest)
    rise_peak = form.peak
    for hold, peak in zip(form.holds, form.peaks, strict=True):
        top = np.zeros((len(rows), 1, len(hold)))
        top[0] = rise_peak
        down = -rows
        down[0] += rise_peak
        durations = np.concatenate([durations, hold[None], durations])
        rows = np.concatenate([rows, top, down], axis=1)
        rows = _integral(durations, rows, peak, rise=True)
        rise_peak = peak
    return durations, rows


def swing_pieces(form: Swings, distance: FloatArray) -> Rows:
    """Return the pieces of longer moves: durations (m, K) and states (n + 1, m, K)."""
    up_span, up_highest = form.up
    span, highest = form.across
    top = form.acceleration
    up_durations, up = _spline(form.order, up_span, top, up_highest)
    durations, crossing = _spline(form.order, span, 2.0 * top, highest)
    crossing = -crossing
    crossing[0] += top
    back = up.copy()
    back[0] -= top
    held = np.zeros((len(up), 1, len(top)))
    held[0] = top
    hold = form.hold[None]
    durations = np.concatenate([up_durations, hold, durations, hold, up_durations])
    rows = np.concatenate([up, held, crossing, -held, back], axis=1)
    rows = _integral(durations, rows, np.zeros_like(top), rise=False)
    return durations, _integral(durations, rows, distance, rise=True)


def _spline(order: int, span: FloatArray, peak: FloatArray, bound: FloatArray) -> Rows:
    """Return perfect splines; `bound` = peak · divisor / span^order exactly."""
    unit = unit_spline(order)
    rows = np.empty((order + 1, order, len(span)))
    factor = peak
    for given, row in zip(unit.rows, rows, strict=True):
        np.multiply(given[:, None], factor, out=row)
        factor = factor / span
    rows[-1] = np.copysign(bound, unit.rows[-1][:, None])
    return unit.durations[:, None] * span, rows


def _integral(
    durations: FloatArray, rows: FloatArray, peak: FloatArray, *, rise: bool
) -> FloatArray:
    """Put the integral of row 0 on top: first half summed up, second half mirrored.

    A rise is mirrored to peak − value, a pulse (rise=False) to itself.
    """
    m = len(durations)
    middle = m // 2
    value = np.zeros((1, *durations.shape))
    [sums] = value
    np.cumsum(integral(durations[:middle], rows[:, :middle]), axis=0, out=sums[1 : middle + 1])
    mirrored = sums[m - middle - 1 : 0 : -1]
    sums[middle + 1 :] = peak - mirrored if rise else mirrored
    return np.concatenate([value, rows])
