"""Rises: how a derivative goes from rest to a peak; pulses and integrals build moves of them.

A rise of derivative k starts and ends with all its own derivatives zero and is antisymmetric
about its middle. Holding its peak and running it backwards gives a pulse; the integral of a
pulse is the rise of derivative k − 1. Every closed-form move is a chain of these two steps, and
because each peak and each hold is set to its exact value, no rounding drifts into a long hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import factorial

import numpy as np

from .checks import whole
from .pieces import MAX_ORDER, FloatArray, RealArray, integral
from .trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Rise:
    """A motion of one derivative from 0 to `peak` in time `span`, at rest at both ends.

    `durations` (m,) and `rows` (q + 1, m): value and its derivatives 1…q at the pieces' starts.
    """

    durations: RealArray
    rows: RealArray
    span: float
    peak: float


def spline_divisor(order: int) -> int:
    """Return (n−1)!·4^(n−1), the ratio D·Tⁿ/R of a perfect spline (Thompson, Table 1)."""
    return factorial(order - 1) * int(4 ** (order - 1))


def switch_fractions(order: int) -> FloatArray:
    """Return the switch times of a `perfect_spline` as fractions of its duration.

        t_k / T = sin²(kπ / (2n)),   k = 0 … n

    Parameters
    ----------
    order : int
        Derivative n ≥ 1 that switches between its bounds.

    Returns
    -------
    (n + 1,) array

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV and Table 1, whose digits this form gives.
    """
    return np.asarray(_switch_fractions(whole("order", order, 1, MAX_ORDER)), dtype=float)


def _switch_fractions(order: int) -> np.typing.NDArray[np.longdouble]:
    k = np.arange(order + 1, dtype=np.longdouble)
    quarter = np.arctan(np.longdouble(1.0))
    return np.asarray(np.sin(k * (2 * quarter / order)) ** 2)


@lru_cache(maxsize=64)
def unit_spline(order: int) -> Rise:
    """Return the perfect spline of an order with span 1 and peak 1.

    Integrated in extended precision where the machine has it: in double precision the middle
    of the order-10 spline would be off by 1e-13.
    """
    fractions = _switch_fractions(order)
    durations = np.diff(fractions)
    signs = (-1.0) ** np.arange(order)
    rows = (np.longdouble(spline_divisor(order)) * signs)[None, :]
    for level in range(1, order + 1):
        even = (order - level) % 2 == 0
        rows = prepend_integral(durations, rows, float(level == order), rise=even)
    return Rise(np.asarray(durations, float), np.asarray(rows, float), 1.0, 1.0)


def spline_rise(order: int, span: float, peak: float, bound: float) -> Rise:
    """Return the perfect spline of an order; `bound` = peak · divisor / span^order exactly."""
    unit = unit_spline(order)
    rows = unit.rows * (peak * span ** -np.arange(order + 1.0))[:, None]
    rows[-1] = np.copysign(bound, rows[-1])
    return Rise(unit.durations * span, rows, span, peak)


def pulse_rise(rise: Rise, hold: float, peak: float) -> Rise:
    """Return the rise one derivative lower: the integral of up, hold, down.

    Parameters
    ----------
    rise : Rise
        The way up; the way down is its mirror image.
    hold : float
        Time at the peak, ≥ 0.
    peak : float
        rise.peak · (rise.span + hold), as the caller knows it best.
    """
    down = -rise.rows
    down[0] += rise.peak
    if hold > 0.0:
        top = np.zeros((len(down), 1))
        top[0, 0] = rise.peak
        rows = np.concatenate([rise.rows, top, down], axis=1)
        durations = np.concatenate([rise.durations, [hold], rise.durations])
    else:
        rows = np.concatenate([rise.rows, down], axis=1)
        durations = np.concatenate([rise.durations, rise.durations])
    rows = prepend_integral(durations, rows, peak, rise=True)
    return Rise(durations, rows, 2.0 * rise.span + hold, peak)


def swing_rise(up: Rise, hold: float, across: Rise, peak: float) -> Rise:
    """Return the rise two derivatives lower: up, hold, across to −peak, hold, back to zero.

    Parameters
    ----------
    up : Rise
        The way from 0 to the peak value.
    hold : float
        Time at the peak and at its opposite, ≥ 0.
    across : Rise
        From 0 to twice the peak value: the shape of the way across.
    peak : float
        The peak of the result.
    """
    crossing = -across.rows
    crossing[0] += up.peak
    back = up.rows.copy()
    back[0] -= up.peak
    top = np.zeros((len(back), 1))
    top[0, 0] = up.peak
    rows = np.concatenate([up.rows, top, crossing, -top, back], axis=1)
    durations = np.concatenate([up.durations, [hold], across.durations, [hold], up.durations])
    kept = durations > 0.0
    durations, rows = durations[kept], rows[:, kept]
    rows = prepend_integral(durations, rows, 0.0, rise=False)
    rows = prepend_integral(durations, rows, peak, rise=True)
    return Rise(durations, rows, 2.0 * (up.span + hold) + across.span, peak)


def prepend_integral(
    durations: RealArray, rows: RealArray, peak: float, *, rise: bool
) -> RealArray:
    """Put the integral of row 0 on top: first half summed up, second half mirrored.

    A rise is mirrored to peak − value, a pulse (rise=False) to itself.
    """
    m = len(durations)
    middle = m // 2
    value = np.zeros(m, dtype=rows.dtype)
    np.cumsum(integral(durations[:middle], rows[:, :middle]), out=value[1 : middle + 1])
    mirrored = value[m - middle - 1 : 0 : -1]
    value[middle + 1 :] = peak - mirrored if rise else mirrored
    return np.concatenate([value[None, :], rows])


def to_trajectory(rise: Rise) -> Trajectory:
    """Return a rise of position as a trajectory from 0, neighbours of one polynomial merged."""
    m = len(rise.durations)
    middle = m // 2
    breaks = np.zeros(m + 1)
    np.cumsum(rise.durations[:middle], out=breaks[1 : middle + 1])
    breaks[m - middle :] = rise.span - breaks[middle::-1]
    switches = np.flatnonzero(rise.rows[-1, 1:] != rise.rows[-1, :-1]) + 1
    first = np.concatenate([[0], switches])
    end = np.zeros(len(rise.rows))
    end[0] = rise.peak
    breaks = np.maximum.accumulate(np.append(breaks[first], rise.span))
    states = np.array(rise.rows[:, first].T, dtype=float)
    durations = np.add.reduceat(np.asarray(rise.durations, dtype=float), first)
    return Trajectory.from_arrays(breaks, states, durations, end)
