"""Thompson's approximation of a shaper by first-order lags in series, and its error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from ...shaping.checks import one_of
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.trajectory import Motion, as_trajectory
from ...shaping.trajectory_checks import finite_array
from .frequency_responses import FrequencyResponse, corner_omega, frequency_response
from .spectrum import move_distance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...shaping.pieces import FloatArray

_UP_TO_CORNER = 200  # frequencies, at which the error up to the corner is looked for


@dataclass(frozen=True, eq=False)
class CascadedLags(Frozen):
    """Lags in series beside the shaper they stand for.

    Attributes
    ----------
    match : "delay" or "rates"
        Whether they have the move's delay, or Thompson's corners.
    lags : (n,) array
        Time constants, one for each 20 dB per decade of the shaper's rollover.
    approximation, exact : FrequencyResponse
        Of the lags and of the shaper, at the same frequencies.
    corner_omega : float
        Where the exact gain has fallen by 3 dB, in radians per time unit.
    error_to_corner_db : float
        The largest error of the gain up to that corner, in dB, with its sign.
    """

    match: Literal["delay", "rates"]
    lags: FloatArray
    approximation: FrequencyResponse
    exact: FrequencyResponse
    corner_omega: float
    error_to_corner_db: float

    @property
    def error_db(self) -> FloatArray:
        """Gain of the lags over the exact gain, in dB, (N,); infinite at a null."""
        return np.asarray(self.approximation.gain_db - self.exact.gain_db)

    @property
    def largest_error_db(self) -> float:
        """The largest magnitude of the error at the frequencies given; at nulls it is infinite."""
        return float(np.abs(self.error_db).max(initial=0.0))

    def plot(self) -> Figure:
        """Return the picture of both gains, and of the error below."""
        drawn: Figure = draw(self)
        return drawn

    def __repr__(self) -> str:
        lags = ", ".join(f"{lag:.4g}" for lag in self.lags)
        return f"CascadedLags([{lags}], error_to_corner_db={self.error_to_corner_db:.3g})"


def cascaded_lags(
    trajectory: Motion, omega: ArrayLike, *, match: Literal["delay", "rates"] = "delay"
) -> CascadedLags:
    """Return first-order lags in series that stand for a move as a filter, and their error.

        H(s) ≈ Π_k 1/(1 + τ_k·s),     k = 1 … n, n the lowest derivative that jumps

    Thompson puts the corner of a rate limiter at V/R, for a step of size R: τ_1 = R/V, a corner
    that falls as the step grows. Carried on to the higher derivatives ("rates") the corners are
    V/R, A/V, W/A, … with the peaks reached. In an S-curve these τ_k are the widths of the boxcars
    that it is the convolution of, so the lags together delay slow signals by T, twice as much as
    the move, which delays them by T/2, and their asymptote lies 6 dB per lag below the envelope
    of the move's lobes. Halved, so that Σ τ_k = T/2 ("delay"), they have the delay of the move
    and, in an S-curve, its envelope.

    Parameters
    ----------
    trajectory : Trajectory
        A move from rest to rest over a distance R ≠ 0.
    omega : float or (N,) array
        Frequencies in radians per time unit.
    match : "delay" or "rates", optional
        The delay of the move (default), which errs less, or Thompson's corners.

    Returns
    -------
    CascadedLags

    Raises
    ------
    ValueError
        For another motion, frequencies that are not finite, or an unknown match.

    Notes
    -----
    The lags have no nulls: behind the corner only the envelope of the lobes is comparable. Gain
    of the lags over the exact one, in dB, at its worst up to the corner, and over the envelope at
    high frequencies:

    ======================  =====================  ==========================
    move                    "delay"                "rates"
    ======================  =====================  ==========================
    velocity limit          −1.7, then 0           −6.4, then −6
    S-curve, n = 2          −1.7 to −3.0, then 0   −6.4 to −11, then −12
    S-curve, n = 3          −1.7 to −3.2, then 0   −6.4 to −12.4, then −18
    perfect spline, n = 4   −3.5, then +6.8        −14.2, then −18
    perfect spline, n = 6   −3.9, then +14         −15.4, then −22
    ======================  =====================  ==========================

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VI, for the rate limiter.

    Examples
    --------
    >>> from jounce.shaping import Limits, min_time_move
    >>> move = min_time_move(4.0, Limits(velocity=2.0, acceleration=4.0))
    >>> cascaded_lags(move, [1.0], match="rates").lags
    array([2. , 0.5])
    >>> cascaded_lags(move, [1.0])
    CascadedLags([1, 0.25], error_to_corner_db=-1.99)
    """
    one_of("match", match, ("delay", "rates"))
    frequencies = np.atleast_1d(finite_array("omega", omega))
    trajectory = as_trajectory(trajectory)
    distance = abs(move_distance(trajectory))
    peaks = [distance, *(trajectory.peak(k) for k in range(1, trajectory.lowest_jump() + 1))]
    lags = np.array(peaks[:-1]) / np.array(peaks[1:])
    if match == "delay":
        lags *= 0.5 * trajectory.duration / lags.sum()
    corner = corner_omega(trajectory)
    below = np.linspace(0.0, corner, _UP_TO_CORNER)
    errors = _response(lags, below).gain_db - frequency_response(trajectory, below).gain_db
    return CascadedLags(
        match,
        lags,
        _response(lags, frequencies),
        frequency_response(trajectory, frequencies),
        corner,
        float(errors[np.abs(errors).argmax()]),
    )


def _response(lags: FloatArray, omega: FloatArray) -> FrequencyResponse:
    return FrequencyResponse(omega, 1.0 / np.prod(1.0 + 1j * omega[:, None] * lags, axis=1), np.inf)
