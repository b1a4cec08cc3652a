"""Frequency response of shapers: the spectrum of a move's velocity over its distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import JerkFilter, Trajectory
from ...shaping.checks import positive, whole
from ...shaping.frozen import Frozen
from ...shaping.jerk_filter import checked_filter
from ...shaping.real_numbers import shown
from ...shaping.trajectory import Motion, as_trajectory
from ...shaping.trajectory_checks import finite_array
from .spectrum import move_distance, variations, velocity_spectrum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...shaping.pieces import FloatArray

    ComplexArray = NDArray[np.complex128]

Shaper = Motion | JerkFilter

_TRUSTED = 0.01  # error of a response that is trusted
_MOST_POINTS = 1e8


@dataclass(frozen=True, eq=False)
class FrequencyResponse(Frozen):
    """H(jω) of a shaper.

    Attributes
    ----------
    omega : (N,) array
        Radians per time unit.
    response : (N,) complex array
        H(jω), 1 at ω = 0; the phase counts from the start of a move.
    trusted_omega : float
        Frequency up to which the response can be trusted to 1 % of its largest value; infinite
        where it is exact.
    """

    omega: FloatArray
    response: ComplexArray
    trusted_omega: float

    @property
    def gain_db(self) -> FloatArray:
        """20·log10 |H|, −inf at a null."""
        with np.errstate(divide="ignore"):
            return np.asarray(20.0 * np.log10(np.abs(self.response)))

    def __repr__(self) -> str:
        return f"FrequencyResponse(frequencies={len(self.omega)}, trusted={self.trusted_omega:.6g})"


def frequency_response(
    shaper: Shaper, omega: ArrayLike, *, jerk_filter: JerkFilter | None = None
) -> FrequencyResponse:
    """Return the exact frequency response of a move or a jerk filter, or of one behind the other.

        H(jω) = (1/R)·∫ v(t)·e^(−jωt) dt = (1/R)·Σ_k Σ_i Δx^(k)(t_i)·e^(−jωt_i) / (jω)^k

    with Δx^(k)(t_i) the jumps of the derivatives k = 1 … n, most of which are zero below n; for a
    jerk filter H = (ω_c/(jω + ω_c))^m.

    Parameters
    ----------
    shaper : Trajectory or JerkFilter
        A trajectory has to be a move from rest to rest over a distance R ≠ 0.
    omega : float or (N,) array
        Frequencies in radians per time unit, of any sign.
    jerk_filter : JerkFilter, optional
        Behind the trajectory: the product of the two.

    Returns
    -------
    FrequencyResponse

    Raises
    ------
    ValueError
        For frequencies that are not finite, a motion that moves at an end or goes nowhere.

    Notes
    -----
    Towards ω = 0 the sum over the jumps cancels; there the integral is taken piece by piece
    (`velocity_spectrum`): H is within 1e-13 of its value in 60 digits at any frequency, for orders
    to 7.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VI.

    Examples
    --------
    >>> from jounce.shaping import Limits, min_time_move
    >>> ramp = min_time_move(2.0, Limits(velocity=1.0))  # a boxcar of 2 s: a null at 0.5 Hz
    >>> response = frequency_response(ramp, [0.0, np.pi]).response
    >>> bool(abs(response[0] - 1.0) < 1e-12), bool(abs(response[1]) < 1e-12)
    (True, True)
    """
    shaper = _checked(shaper, jerk_filter)
    frequencies = np.atleast_1d(finite_array("omega", omega))
    if isinstance(shaper, JerkFilter):
        response = _of_filter(shaper, frequencies)
    else:
        response = _of_move(shaper, frequencies)
    if jerk_filter is not None:
        response = response * _of_filter(jerk_filter, frequencies)
    return FrequencyResponse(frequencies, response, np.inf)


def fft_frequency_response(trajectory: Motion, dt: float, padding: int = 8) -> FrequencyResponse:
    """Return the frequency response by Thompson's method: FFT of the sampled velocity.

        H(jω_k) ≈ (dt/R)·Σ_i v(t_i)·e^(−jω_k·t_i),   ω_k = 2πk/(m·N·dt)

    Parameters
    ----------
    trajectory : Trajectory
        A move from rest to rest over a distance R ≠ 0.
    dt : float
        Sampling interval; positive.
    padding : int, optional
        m: the N samples are padded with zeros to m·N points, 1 to 1000.

    Returns
    -------
    FrequencyResponse
        At frequencies from 0 to π/dt, with the frequency up to which the error is surely below
        1 % in `trusted_omega`: a tenth of π/dt where the move is sampled finely, less where dt is
        long beside its ramps, 0 where it is too long for any.

    Raises
    ------
    ValueError
        For a motion that moves at an end or goes nowhere, a dt that is not positive or makes
        more than 1e8 points.

    Notes
    -----
    Sampling folds the spectrum beyond π/dt back onto what lies below: the error is the sum of V at
    2πm/dt ± ω, m = 1, 2, …, which the jumps and variations of the derivatives bound. Where the
    velocity jumps, it is at most dt/2 times the total variation of v(t)·e^(−jωt).

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VI.
    """
    trajectory = as_trajectory(trajectory)
    distance, dt = move_distance(trajectory), positive("dt", dt)
    factor = whole("padding", padding, 1, 1000)
    if not trajectory.duration / dt * factor < _MOST_POINTS:
        raise ValueError(
            f"dt = {dt!r} and padding = {factor}: more than {_MOST_POINTS:g} points in a move of "
            f"{trajectory.duration:.6g}; use a longer dt"
        )
    count = int(np.ceil(trajectory.duration / dt)) + 1
    time = trajectory.start_time + dt * np.arange(count)
    velocity = np.asarray(trajectory(time, "velocity"))
    velocity[0] *= 0.5 if trajectory.order == 1 else 1.0  # a sample on a jump counts half
    points = count * factor
    response = np.fft.rfft(velocity, points) * dt / distance
    omega = np.asarray(2.0 * np.pi * np.fft.rfftfreq(points, dt), dtype=np.float64)
    return FrequencyResponse(omega, response, _trusted_omega(trajectory, dt, abs(distance)))


def _trusted_omega(trajectory: Trajectory, dt: float, distance: float) -> float:
    """Return the frequency up to which sampling errs by less than 1 %, a tenth of π/dt at most."""
    jumps, integrals = variations(trajectory)
    highest = 0.1 * np.pi / dt
    omega = np.linspace(0.0, highest, 1001)
    if jumps[0]:  # the trapezoidal rule for v·e^(−jωt), a function of bounded variation
        error = 0.5 * dt * (jumps[0] + integrals[1] + omega * integrals[0])
    else:
        error = _folded(2.0 * np.pi / dt - omega, jumps, integrals)
    trusted = omega[error <= _TRUSTED * distance]
    return float(trusted[-1]) if trusted.size else 0.0


def _folded(omega: FloatArray, jumps: FloatArray, integrals: FloatArray) -> FloatArray:
    """Return a bound of Σ_m |V(j·m·ω)| + |V(−j·m·ω)|, m = 1, 2, …, for a continuous velocity."""
    from scipy.special import zeta

    k = np.arange(2, len(jumps) + 1)
    if not k.size:
        return np.full(omega.shape, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        sums = 2.0 * zeta(k) / omega[:, None] ** k  # Σ 1/(m·ω)^k
        bounds = np.cumsum(sums * jumps[1:], axis=1) + sums * integrals[2:]
    return np.asarray(np.fmin.reduce(bounds, axis=1))


def corner_omega(shaper: Shaper, *, jerk_filter: JerkFilter | None = None) -> float:
    """Return the lowest frequency at which |H| has fallen to 1/√2 (−3 dB), to the last digits.

    Parameters
    ----------
    shaper, jerk_filter
        As in `frequency_response`.

    Returns
    -------
    float
        In radians per time unit.

    Examples
    --------
    >>> from jounce.shaping import JerkFilter
    >>> round(corner_omega(JerkFilter(1.0, 1)) / (2.0 * np.pi), 12)
    1.0
    """
    from scipy.optimize import brentq

    def excess(omega: float) -> float:
        response = frequency_response(shaper, omega, jerk_filter=jerk_filter).response[0]
        return float(abs(response) ** 2 - 0.5)

    shaper = _checked(shaper, jerk_filter)
    low = high = 0.01 * _pace(shaper, jerk_filter)
    while excess(high) > 0.0:
        low, high = high, 1.05 * high
    return float(brentq(excess, low, high, xtol=1e-15 * high, rtol=1e-14))


def rollover_db_per_decade(shaper: Shaper, *, jerk_filter: JerkFilter | None = None) -> float:
    """Return by how much the envelope of |H| falls per decade at high frequencies.

        20 dB · (k + m),   |H(ω)| ≲ c/ω^(k + m),   ω → ∞

    k is the order of the lowest derivative that jumps, m the number of lags of a filter.

    Parameters
    ----------
    shaper : Trajectory or JerkFilter
    jerk_filter : JerkFilter, optional
        Behind a trajectory.

    Returns
    -------
    float
        dB per decade, positive.
    """
    shaper = _checked(shaper, jerk_filter)
    order = shaper.order if isinstance(shaper, JerkFilter) else shaper.lowest_jump()
    return 20.0 * (order + (0 if jerk_filter is None else jerk_filter.order))


def _pace(shaper: Trajectory | JerkFilter, jerk_filter: JerkFilter | None) -> float:
    """Return a frequency below which nothing happens but at a hundredth of it."""
    paces = [
        shaper.omega / shaper.order
        if isinstance(shaper, JerkFilter)
        else 1.0 / max(shaper.duration, 1e-300)
    ]
    if jerk_filter is not None:
        paces.append(jerk_filter.omega / jerk_filter.order)
    return min(paces)


def _checked(shaper: Shaper, jerk_filter: JerkFilter | None) -> Trajectory | JerkFilter:
    if not isinstance(shaper, Motion | JerkFilter):
        raise TypeError(f"shaper = {shown(shaper)}: expected a Trajectory or a JerkFilter")
    if jerk_filter is not None:
        checked_filter(jerk_filter)
    return shaper if isinstance(shaper, JerkFilter) else as_trajectory(shaper)


def _of_filter(jerk_filter: JerkFilter, omega: FloatArray) -> ComplexArray:
    return np.asarray((1.0 + 1j * omega / jerk_filter.omega) ** -jerk_filter.order)


def _of_move(trajectory: Trajectory, omega: FloatArray) -> ComplexArray:
    distance = move_distance(trajectory)
    return velocity_spectrum(trajectory, 1j * omega) / distance
