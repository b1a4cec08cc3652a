"""First-order lags that come nearest to a describing function, and a rate limiter's corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import Limits
from ...shaping.checks import of_kind
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import real_array
from .periodic import TRIANGLE, rate_limited_harmonic
from .sine_sweep import checked_sweep

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray
    from .describing_functions import DescribingFunction
    from .periodic import ComplexArray


@dataclass(frozen=True, eq=False)
class FirstOrderLag(Frozen):
    """The lags L = 1/(1 + jω/ω_c) that come nearest to a describing function, one per amplitude.

    Attributes
    ----------
    amplitude : array
        Shape of the describing function without its last axis.
    corner_omega : array
        ω_c in radians per time unit; infinite where nothing lags.
    rms_error, max_error : arrays
        Root mean square and largest |N/L − 1| over the frequencies swept.
    """

    amplitude: FloatArray
    corner_omega: FloatArray
    rms_error: FloatArray
    max_error: FloatArray

    def response(self, omega: ArrayLike) -> ComplexArray:
        """Return the lags at frequencies (N,), shape (…, N)."""
        turns = real_array("omega", omega) / self.corner_omega[..., None]
        return np.asarray(1.0 / (1.0 + 1j * turns))

    def __repr__(self) -> str:
        return f"FirstOrderLag(amplitudes={self.amplitude.size})"


def first_order_lag(describing: DescribingFunction) -> FirstOrderLag:
    """Return the first-order lags L = 1/(1 + jω/ω_c) that come nearest to a describing function.

    For each amplitude that with the least Σ |N/L − 1|² over the frequencies swept, in which a dB
    counts as much as 6.6°:

        1/ω_c = −Σ ω·Im N / Σ ω²·|N|²

    Parameters
    ----------
    describing : DescribingFunction
        Of shape (…, N), with frequencies along the last axis at constant amplitude. Evenly
        spread over the logarithm of ω they weigh each octave the same.

    Returns
    -------
    FirstOrderLag

    Raises
    ------
    ValueError
        For another describing function.

    Notes
    -----
    The corner falls as the amplitude grows; that of a rate limiter is proportional to V/A. Towards
    high frequencies its N tends to the lag with ω_c = (4/π)·V/A = 1.273·V/A. Fitted from a tenth
    to ten times V/A, ω_c = 2.00·V/A with an rms error of 0.28; N is −3 dB at 1.801·V/A
    (`rate_limiter_corner_omega`). Thompson's rule, V/R for a step of size R, has the
    same form; with R = A it is the asymptote less a fifth.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VI.

    Examples
    --------
    >>> from jounce.analysis.frequency_view.describing_functions import describing_function
    >>> amplitudes, omega = np.array([[1.0], [10.0]]), np.geomspace(1e-3, 1e3, 601)
    >>> lag = first_order_lag(describing_function(Limits(velocity=1.0), amplitudes, omega))
    >>> lag.corner_omega.round(3).tolist(), lag.rms_error.round(3).tolist()
    ([1.464, 0.141], [0.207, 0.212])
    """
    from .describing_functions import DescribingFunction

    of_kind("describing", describing, DescribingFunction, "what describing_function gives")
    amplitude, omega, response = describing.amplitude, describing.omega, describing.response
    if amplitude.ndim == 0 or not amplitude.size or (amplitude != amplitude[..., :1]).any():
        raise ValueError(
            f"describing function of shape {amplitude.shape}: expected frequencies along the last "
            "axis at constant amplitude, as of amplitude[:, None] and omega"
        )
    turn = omega / omega.max()
    weight = ((turn * np.abs(response)) ** 2).sum(axis=-1)
    lag = np.maximum(-(turn * response.imag).sum(axis=-1) / weight, 0.0)
    off = np.abs(response * (1.0 + 1j * turn * lag[..., None]) - 1.0)
    with np.errstate(divide="ignore"):
        corner = omega.max() / lag
    rms = np.sqrt(np.mean(off * off, axis=-1))
    return FirstOrderLag(amplitude[..., 0], corner, rms, off.max(axis=-1))


def rate_limiter_corner_omega(limits: Limits, amplitude: ArrayLike) -> FloatArray:
    """Return the frequency at which |N| of a rate limiter has fallen to 1/√2 (−3 dB).

        ω = λ·V/A   with   |N|² = 1/2 at A·ω/V = λ = 1.80054

    Parameters
    ----------
    limits : Limits
        Of velocity alone, the same in both directions.
    amplitude : array
        A, positive.

    Returns
    -------
    array
        In radians per time unit, to the last digits.

    Raises
    ------
    ValueError
        For other limits or amplitudes.

    Examples
    --------
    >>> rate_limiter_corner_omega(Limits(velocity=1.0), [1.0, 10.0]).round(4).tolist()
    [1.8005, 0.1801]
    """
    sweep = checked_sweep(limits, amplitude, 1.0)
    if sweep.counts is not None:
        raise ValueError(
            f"{limits!r}: expected limits of velocity alone; fit a first_order_lag to the "
            "describing function of others"
        )
    return np.asarray(_corner_load() * limits.upper[0] / sweep.amplitude)


@cache
def _corner_load() -> float:
    """Return A·ω/V at which |N|² = 1/2."""
    from scipy.optimize import brentq

    def excess(load: float) -> float:
        return float(np.abs(rate_limited_harmonic(np.array([1.0 / load]))[0]) ** 2 - 0.5)

    return float(brentq(excess, 1.0, TRIANGLE, xtol=1e-15, rtol=1e-14))
