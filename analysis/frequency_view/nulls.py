"""Nulls of a move: where they are, and how they move with the size of the move."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import Limits, Trajectory, min_time_move
from ...shaping.checks import positive, whole
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.pieces import MAX_ORDER
from ...shaping.trajectory import Motion, as_trajectory
from .spectrum import checked_distances, move_distance, spectrum_bound, velocity_spectrum

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ...shaping.pieces import FloatArray

    ComplexArray = NDArray[np.complex128]

SYMMETRIC = 1e-9
"""H(jω)·e^(jωT/2) of a motion symmetric in time is real but for this much."""

DOUBLE = 1e-9
"""A turning point of the response is a double null below this part of its bound."""

_PER_RADIAN = 4  # samples of ωT, some 25 to a lobe
_MOST = 10**7  # samples
_ROUGHLY, _FULLY = 24, 54  # bisections
_WIDENINGS = 6
_SAME = 1e-4  # radians of phase: nearer to a double null than this is that null itself
_ROUNDING = 1e-12
_STEP = 1e-4  # of the distance, to see a null move
_STAYS = 1e-3


@dataclass(frozen=True, eq=False)
class NullBySize(Frozen):
    """The null nearest to a frequency, over the distance of the move.

    Attributes
    ----------
    distances : (M,) array
    frequency_hz : float
        The frequency that was asked for, in cycles per time unit.
    null_hz : (M,) array
        Nearest to it; NaN where the move has no null.
    exponent : (M,) array
        d ln(null)/d ln(distance): the null moves as distance^exponent. It is 0 for the null of a
        ramp that has reached its full width, −1 for that of the whole cruise, R/V, and −1/n where
        nothing but derivative n is bounded.
    durations : (M,) array
        Of the moves.
    """

    distances: FloatArray
    frequency_hz: float
    null_hz: FloatArray
    exponent: FloatArray
    durations: FloatArray

    @property
    def stays(self) -> NDArray[np.bool_]:
        """Whether the null stays where it is as the distance changes, (M,)."""
        return np.asarray(np.abs(self.exponent) < _STAYS)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the null over the distance; without an Axes in pyplot's current ones."""
        drawn: Axes = draw(self, ax)
        return drawn

    def __repr__(self) -> str:
        return (
            f"NullBySize(distances={len(self.distances)}, frequency_hz={self.frequency_hz:.6g}, "
            f"staying={int(self.stays.sum())})"
        )


def null_omegas(trajectory: Motion, highest: float) -> FloatArray:
    """Return the frequencies up to a highest one at which the response is zero.

    Those of a motion that runs backwards as it runs forwards: g(ω) = H(jω)·e^(jωT/2) is real,
    and its changes of sign are found to the last digits, as are the double nulls, turning points
    of g below 1e-9 of what g cannot exceed there. Other motions have minima, but no nulls.

    Parameters
    ----------
    trajectory : Trajectory
        A move from rest to rest over a distance R ≠ 0.
    highest : float
        In radians per time unit; positive.

    Returns
    -------
    (K,) array
        Increasing, in radians per time unit, a multiple null once; empty for a motion that is not
        symmetric in time. A triple null is found where the response is rounding, not closer.

    Raises
    ------
    ValueError
        For another motion, or a highest frequency that turns the phase by more than 2.5e6
        radians.

    Examples
    --------
    Ramps of 1 s without a cruise: a velocity triangle, whose nulls are double.

    >>> from jounce.shaping import Limits, min_time_move
    >>> null_omegas(min_time_move(1.0, Limits(acceleration=1.0)), 14.0) / (2.0 * np.pi)
    array([1., 2.])
    """
    return _nulls_between(as_trajectory(trajectory), 0.0, positive("highest", highest))


def null_by_size(limits: Limits, distances: ArrayLike, frequency_hz: float) -> NullBySize:
    """Return the null nearest to a frequency for moves of several distances.

    A fastest move of order n ≤ 3 within symmetric limits is a convolution of n boxcars, each with
    nulls at the multiples of 1/width: R/v, v/a and a/j with v, a, j the peaks reached. As the
    distance R grows, a **ramp** keeps its width once the bound on its height is reached, and its
    nulls **stay**: A/W of the jerk ramp where A is reached, V/A of the acceleration where V is,
    too. The nulls of the width that still grows, R/V of the whole move at last, **move** down
    with it. For higher orders the ramps are perfect splines, and the same holds.

    Parameters
    ----------
    limits : Limits
        Of the moves, `min_time_move(distance, limits, method="closed-form")`.
    distances : (M,) array
        Signed, other than zero.
    frequency_hz : float
        In cycles per time unit; positive.

    Returns
    -------
    NullBySize

    Raises
    ------
    ValueError
        As in `min_time_move`, or for a distance of zero.

    Examples
    --------
    >>> found = null_by_size(Limits(velocity=1.0, acceleration=2.0), [0.125, 0.7, 5.0], 2.0)
    >>> found.null_hz, found.stays
    (array([4., 2., 2.]), array([False,  True,  True]))
    """
    sizes, frequency = checked_distances(distances), positive("frequency_hz", frequency_hz)
    rows = []
    for distance in sizes.tolist():
        move = min_time_move(distance, limits, method="closed-form")
        null = _nearest_null(move, 2.0 * np.pi * frequency)
        smaller, larger = (
            _nearest_null(min_time_move(distance * factor, limits, method="closed-form"), null)
            for factor in (1.0 - _STEP, 1.0 + _STEP)
        )
        exponent = np.log(larger / smaller) / np.log((1.0 + _STEP) / (1.0 - _STEP))
        rows.append((null / (2.0 * np.pi), exponent, move.duration))
    null_hz, exponents, durations = np.array(rows).T
    return NullBySize(sizes, frequency, null_hz, exponents, durations)


def null_rise_time(frequency_hz: float, order: int) -> float:
    """Return the rise time of acceleration whose ramp has its first null at a frequency.

    The ramp 0 → A of acceleration is a perfect spline of order m = n − 2, whose nulls are those of

        Σ_k (−1)^k·e^(jz·cos(kπ/m)) ∝ J_m(z) + (−1)^m·J_3m(z) + J_5m(z) + …,    z = π·f·t_r

    (k = 0 … m, end terms halved), the first at f·t_r = 1 for jerk (n = 3), 2 for snap (a double
    null) and crackle, 2.4226 for pop. Every change of acceleration in a move that holds A and
    cruises at V is this ramp, so that its nulls **stay** whatever the distance, as long as both
    are reached.

    Parameters
    ----------
    frequency_hz : float
        Of the mode, in cycles per time unit; positive.
    order : int
        The derivative n ≥ 3 that is to be bounded, by `bound_for_rise_time(acceleration,
        rise_time, order)`.

    Returns
    -------
    float
        t_r, in the time unit.

    Raises
    ------
    ValueError
        For an order outside 3…40 or a frequency that is not positive.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV (the ramp as a perfect spline); the series of
    Bessel functions is that of Jacobi and Anger.

    Examples
    --------
    >>> null_rise_time(4.0, 3)
    0.25
    """
    frequency = positive("frequency_hz", frequency_hz)
    return _first_null(whole("order", order, 3, MAX_ORDER) - 2) / frequency


@lru_cache(maxsize=64)
def _first_null(order: int) -> float:
    """Return the first null of a perfect spline of duration 1, in cycles."""
    if order <= 3:
        return float(min(order, 2))
    from scipy.optimize import brentq
    from scipy.special import jn_zeros, jv

    first = float(jn_zeros(order, 1)[0])
    multiples = order * np.array([1, 3, 5, 7])
    signs = (-1.0) ** (order * np.arange(4))
    root = brentq(lambda z: signs @ jv(multiples, z), first - 0.1, first + 0.1, xtol=1e-14)
    return float(root / np.pi)


def _nearest_null(trajectory: Trajectory, omega: float) -> float:
    """Return the null nearest to a frequency, NaN where there is none."""
    if np.isnan(omega):
        return np.nan
    reach = 4.0 * np.pi / trajectory.duration
    for _ in range(_WIDENINGS):
        found = _nulls_between(trajectory, max(0.0, omega - reach), omega + reach)
        if found.size:
            return float(found[np.abs(found - omega).argmin()])
        reach *= 2.0
    return np.nan


def _nulls_between(trajectory: Trajectory, low: float, high: float) -> FloatArray:
    """Return the nulls from one frequency to another, as in `null_omegas`."""
    duration = trajectory.duration
    count = (high - low) * duration * _PER_RADIAN
    if not count < _MOST:
        raise ValueError(
            f"{count / _PER_RADIAN:.3g} radians of phase to look for nulls in: expected at most "
            f"{_MOST / _PER_RADIAN:.1e}; choose a lower highest frequency"
        )
    value, slope = _real_response(trajectory)
    omega = low + np.arange(np.ceil(count) + 2.0) * (high - low) / np.ceil(count)
    values = value(omega)
    if np.abs(values.imag).max() > SYMMETRIC:
        return np.empty(0)
    low_sides, high_sides = _bisected(slope, *_crossings(slope, omega), _ROUGHLY)
    turning = 0.5 * (low_sides + high_sides)
    scale = spectrum_bound(trajectory, turning) / abs(move_distance(trajectory))
    flat = np.abs(value(turning).real) <= DOUBLE * scale
    double = np.mean(_bisected(slope, low_sides[flat], high_sides[flat], _FULLY), axis=0)

    def real(frequencies: FloatArray) -> FloatArray:
        return value(frequencies).real

    edges = np.sort(np.concatenate([omega, turning[~flat]]))
    simple = np.mean(_bisected(real, *_crossings(real, edges), _FULLY), axis=0)
    apart = np.abs(simple[:, None] - double).min(axis=1, initial=np.inf) * duration > _SAME
    found = np.sort(np.concatenate([simple[apart], double]))
    return np.asarray(found[found <= high * (1.0 + _ROUNDING)])


def _real_response(
    trajectory: Trajectory,
) -> tuple[Callable[[FloatArray], ComplexArray], Callable[[FloatArray], FloatArray]]:
    """Return g(ω) = H(jω)·e^(jωT/2), and the slope of its real part.

    The slope is the response of (t − T/2)·v(t), a piecewise polynomial of the next order.
    """
    distance, middle = move_distance(trajectory), 0.5 * trajectory.duration
    n = trajectory.order
    offsets = trajectory.breaks[:-1, None] - trajectory.start_time - middle
    rows = np.zeros((len(offsets), n + 2))
    rows[:, 1:-1] = offsets * trajectory.states[:, 1:]
    rows[:, 2:] += np.arange(1, n + 1) * trajectory.states[:, 1:]
    moment = Trajectory.from_arrays(
        trajectory.breaks.copy(), rows, trajectory.durations.copy(), np.zeros(n + 2)
    )

    def value(omega: FloatArray) -> ComplexArray:
        turned = velocity_spectrum(trajectory, 1j * omega) * np.exp(1j * omega * middle)
        return np.asarray(turned / distance)

    def slope(omega: FloatArray) -> FloatArray:
        turned = velocity_spectrum(moment, 1j * omega) * np.exp(1j * omega * middle)
        return np.asarray(turned.imag / distance)

    return value, slope


def _crossings(
    function: Callable[[FloatArray], FloatArray], edges: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return neighbouring edges between which a function changes sign."""
    below = function(edges) < 0.0
    [changes] = np.nonzero(below[1:] != below[:-1])
    return edges[changes], edges[changes + 1]


def _bisected(
    function: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray, times: int
) -> tuple[FloatArray, FloatArray]:
    """Return the brackets of a change of sign, halved so many times."""
    rising = function(low) < 0.0
    for _ in range(times if low.size else 0):
        middle = 0.5 * (low + high)
        before = (function(middle) < 0.0) == rising
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return low, high
