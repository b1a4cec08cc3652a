"""Residual vibration: how a lightly damped mode rings after a move, exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import JerkFilter, Limits, min_time_move
from ...shaping.checks import finite
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.jerk_filter import checked_filter
from ...shaping.plain_moves import Method
from ...shaping.trajectory import Motion
from ...shaping.trajectory_checks import finite_array
from .spectrum import at_rest, checked_distances, velocity_spectrum

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ...shaping.pieces import FloatArray

    ComplexArray = NDArray[np.complex128]

_APART = 0.1  # |p + ω_c|/ω_c of a mode and a filter that can be told apart


@dataclass(frozen=True, eq=False)
class VibrationMap(Frozen):
    """Residual vibration over the distance of the move and the frequency of the mode.

    Attributes
    ----------
    distances : (M,) array
        Signed, in the limits' distance unit.
    frequencies_hz : (N,) array
        Of the mode without damping, in cycles per time unit.
    residual : (M, N) array
        Amplitude at the end of the move, in the limits' distance unit.
    durations : (M,) array
        Of the moves.
    damping : float
        Of the mode.
    """

    distances: FloatArray
    frequencies_hz: FloatArray
    residual: FloatArray
    durations: FloatArray
    damping: float

    @property
    def relative(self) -> FloatArray:
        """Amplitude over the distance moved, (M, N): |H(jω)| of the move where damping is zero."""
        return np.asarray(self.residual / np.abs(self.distances)[:, None])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the relative amplitude as a map; without an Axes in pyplot's current ones."""
        drawn: Axes = draw(self, ax)
        return drawn

    def __repr__(self) -> str:
        shape = self.residual.shape
        return f"VibrationMap(distances={shape[0]}, frequencies={shape[1]}, damping={self.damping})"


def residual_vibration(
    trajectory: Motion,
    frequency_hz: ArrayLike,
    damping: ArrayLike = 0.0,
    *,
    jerk_filter: JerkFilter | None = None,
) -> FloatArray:
    """Return the amplitude with which a mode rings on after a move.

    The mode's deflection from the commanded position, at rest before the move, follows

        δ'' + 2ζω·δ' + ω²·δ = −x''        ω = 2π·frequency_hz

    and after the end T of the move is A·e^(−ζω(t−T))·cos(ω·√(1−ζ²)·(t−T) + φ) with

        A = |∫ v(τ)·e^(p(T−τ)) dτ| / √(1−ζ²),     p = −ζω + jω·√(1−ζ²)

    so that without damping A/R is the gain |H(jω)| of the move as a filter.

    Parameters
    ----------
    trajectory : Trajectory
        A move from rest to rest, of any order.
    frequency_hz : float or array
        Natural frequency of the mode without damping, in cycles per time unit; positive.
    damping : float or array, optional
        Damping ratio ζ, 0 ≤ ζ < 1. Broadcast against `frequency_hz`.
    jerk_filter : JerkFilter, optional
        Behind the trajectory. A is then multiplied by |f(p)| = |1 + p/ω_c|^−m: the amplitude of
        the mode's own part, extrapolated back to the end T of the unfiltered move, beside which
        the filter's own tail dies out. With damping it may exceed that without the filter,
        which delays the motion.

    Returns
    -------
    float or array
        A at the end of the move, in the trajectory's distance unit.

    Raises
    ------
    ValueError
        For a motion that moves at an end, a frequency that is not positive, a damping outside
        [0, 1), or a mode that decays as the filter's lags do, |1 + p/ω_c| < 0.1, where the two
        cannot be told apart.

    Notes
    -----
    Within 1e-13 of the distance covered, at any frequency and damping, for orders to 7.

    Examples
    --------
    A velocity ramp of 0.5 s rings no mode of 2 Hz, whatever the distance.

    >>> from jounce.shaping import Limits, min_time_move
    >>> move = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))
    >>> bool(residual_vibration(move, 2.0) < 1e-15)
    True
    >>> round(float(residual_vibration(move, 2.0, damping=0.02)), 4)
    0.0003
    """
    trajectory = at_rest(trajectory)
    frequencies, ratios = np.broadcast_arrays(
        _positive_array("frequency_hz", frequency_hz), checked_damping(damping)
    )
    root = np.sqrt((1.0 - ratios) * (1.0 + ratios))
    with np.errstate(over="ignore"):
        omega = finite_array("2π·frequency_hz", 2.0 * np.pi * frequencies)
    pole = omega * (-ratios + 1j * root)
    amplitude = np.abs(velocity_spectrum(trajectory, pole, from_end=True)) / root
    if jerk_filter is not None:
        amplitude = amplitude * _filter_gain(jerk_filter, pole)
    return np.asarray(amplitude)[()]


def vibration_map(
    limits: Limits,
    distances: ArrayLike,
    frequencies_hz: ArrayLike,
    damping: float = 0.0,
    *,
    jerk_filter: JerkFilter | None = None,
    method: Method = "optimal",
) -> VibrationMap:
    """Return the residual vibration of fastest moves over several distances, for several modes.

    Parameters
    ----------
    limits : Limits
        Of the moves, `min_time_move(distance, limits, method=method)`.
    distances : (M,) array
        Signed, other than zero.
    frequencies_hz : (N,) array
        Of the modes; positive.
    damping : float, optional
        Of the modes.
    jerk_filter : JerkFilter, optional
        Behind the moves.
    method : "optimal" or "closed-form", optional
        Of the moves; "closed-form" is much quicker from order 4 on.

    Returns
    -------
    VibrationMap

    Raises
    ------
    ValueError
        As in `min_time_move` and `residual_vibration`, or for a distance of zero.

    Examples
    --------
    >>> found = vibration_map(Limits(jerk=32.0), [0.125, 1.0, 8.0], [1.0, 2.0])
    >>> found.durations
    array([0.5, 1. , 2. ])
    >>> found.relative[:, 1].round(3)  # a bounded jerk over T has a null at 2/T
    array([0.516, 0.   , 0.   ])
    """
    sizes = checked_distances(distances)
    frequencies = np.atleast_1d(_positive_array("frequencies_hz", frequencies_hz))
    if frequencies.ndim != 1 or not frequencies.size:
        raise ValueError(
            f"frequencies_hz of shape {frequencies.shape}: expected one row, not empty"
        )
    ratio = finite("damping", damping)
    moves = [min_time_move(distance, limits, method=method) for distance in sizes.tolist()]
    rows = [residual_vibration(m, frequencies, ratio, jerk_filter=jerk_filter) for m in moves]
    durations = np.array([move.duration for move in moves])
    residual = np.array(rows).reshape(len(moves), len(frequencies))
    return VibrationMap(sizes, frequencies, residual, durations, ratio)


def _positive_array(name: str, values: ArrayLike) -> FloatArray:
    array = finite_array(name, values)
    if not (array > 0.0).all():
        raise ValueError(f"{name}: expected positive frequencies, got {array.min()}")
    return array


def checked_damping(damping: ArrayLike) -> FloatArray:
    """Return damping ratios, 0 ≤ ζ < 1."""
    ratios = finite_array("damping", damping)
    wrong = ratios[~((ratios >= 0.0) & (ratios < 1.0))]
    if wrong.size:
        raise ValueError(
            f"damping = {float(wrong[0])!r}: expected a ratio with 0 ≤ damping < 1; a mode damped "
            "more does not vibrate"
        )
    return ratios


def _filter_gain(jerk_filter: JerkFilter, pole: ComplexArray) -> FloatArray:
    distance = np.abs(1.0 + pole / checked_filter(jerk_filter).omega)
    if (distance < _APART).any():
        raise ValueError(
            f"a mode decays as the lags of {jerk_filter!r} do: their parts of the motion cannot "
            "be told apart; choose a lower damping or another corner"
        )
    return np.asarray(distance ** -float(jerk_filter.order))
