"""Derivatives of a fit with error bars: noise of the readings, and bias of the smoothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf, pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from ...shaping.frozen import Frozen
from .fit import PENALTY
from .spline import SplineFit

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

CONFIDENCE = 0.95
"""Probability that a derivative stays within its error bars at all times of the log."""

RESOLVED = 3.4
"""Shortest pulse of a derivative that the fit shows to 90 %, in smoothing times τ."""

OVERSHOOT = 0.068
"""Part of a jump by which the fit overshoots beside it."""

_HIDDEN = 2.0 / 3.0  # of the resolved time: a jump shows its height over 0.62 of it, or more

_POINTS = 4  # per interval between knots
_AVERAGED = 2.0  # width in τ of the average whose kernel is positive, to 0.2 % of a jump


@dataclass(frozen=True, eq=False)
class Band(Frozen):
    """A derivative over time with half-widths of its simultaneous 95 % band.

    Attributes
    ----------
    times, values : (P,) array
    noise : (P,) array
        Half-width that the noise of the readings makes.
    smoothing : (P,) array
        Half-width allowed for the bias of the smoothing.
    amplification : float
        Median standard deviation of the derivative over that of a reading.
    starts : tuple of int
        Where the parts of the log begin, which pauses part.
    """

    times: FloatArray
    values: FloatArray
    noise: FloatArray
    smoothing: FloatArray
    amplification: float
    starts: tuple[int, ...] = (0,)

    @property
    def error(self) -> FloatArray:
        """Half-width of the band."""
        return self.noise + self.smoothing


def joint_band(fits: Sequence[SplineFit], k: int) -> Band:
    """Return derivative k of the parts of a log, with error bars that hold for all of them."""
    c = critical_value(k, sum(fit.freedom for fit in fits))
    bands = [derivative_band(fit, k, c) for fit in fits]
    ends = np.cumsum([len(band.times) for band in bands]).tolist()
    return Band(
        times=np.concatenate([band.times for band in bands]),
        values=np.concatenate([band.values for band in bands]),
        noise=np.concatenate([band.noise for band in bands]),
        smoothing=np.concatenate([band.smoothing for band in bands]),
        amplification=max(band.amplification for band in bands),
        starts=(0, *ends[:-1]),
    )


def derivative_band(fit: SplineFit, k: int, c: float) -> Band:
    """Return derivative k of a fit, 1 to 3, with its error bars.

        |x^(k)(t) − f^(k)(t)| ≤ c·s(t) + |f^(k)(t) − g(t)|   at all t, with probability 0.95

    s is the noise's part of the posterior standard deviation: where readings are evenly spaced
    1 − (2k + 1)/8 of its square, the rest being bias; what lies above the median square, in gaps
    and at the ends, counts in full. c, the critical value, is the level that |f^(k) − E f^(k)|/s
    crosses in one of twenty logs. g averages f^(k) over time with a Gaussian of width 2τ. Its
    kernel is positive (but for 0.2 %): of a motion without noise g never exceeds the peak,
    whatever the motion; f^(k) follows more closely and overshoots beside jumps. The difference
    of the two stands for the bias of either.

    References
    ----------
    Rice's formula with the term for the ends: Sun & Loader, "Simultaneous confidence bands for
    linear regression and smoothing", Annals of Statistics 22 (1994), equation 2.2.
    """
    variance = fit.variance(k, _POINTS)
    share = noise_share(k)
    typical = float(np.median(variance))
    deviation = np.sqrt(np.maximum(share * variance, variance - (1.0 - share) * typical))
    values = fit.derivative(k, _POINTS)
    averaged = fit.averaged(k, _POINTS, _AVERAGED * fit.sharpness)
    return Band(
        times=fit.times(_POINTS),
        values=values,
        noise=c * deviation,
        smoothing=np.abs(values - averaged),
        amplification=sqrt(share * typical) / fit.noise,
    )


def extent(band: Band, direction: int) -> tuple[float, float, float, float]:
    """Return a band's peak, its least and its most, and its time.

    Parameters
    ----------
    band : Band
    direction : int
        1 forward, −1 backward, 0 whichever is larger.
    """
    if not direction:
        larger, other = sorted((extent(band, 1), extent(band, -1)), reverse=True)
        return larger[0], max(larger[1], other[1]), max(larger[2], other[2]), larger[3]
    values = direction * band.values
    at = int(values.argmax())
    ends = (values[at], (values - band.error).max(), (values + band.error).max())
    used, least, most = (max(float(end), 0.0) for end in ends)
    return used, least, most, float(band.times[at])


def upper_end_holds(
    bands: Sequence[Band], resolved_time: float, displacement: float
) -> tuple[bool, ...]:
    """Return whether the upper end of each derivative's peak excludes higher ones.

        (2/3)·resolved_time·most_k ≤ least_(k−1)

    Where the derivative below jumps by D, the fit shows D/(0.9·resolved_time), and the upper end
    with its allowance for smoothing is at least D/(0.62·resolved_time): one lower than that of a
    jump by the whole peak of the derivative below excludes such a jump.

    Parameters
    ----------
    bands : sequence of Band
        Of derivatives 1, 2, …
    resolved_time : float
    displacement : float
        least₀: what the readings surely moved; infinite for an axis known to be at rest.
    """
    ends = [extent(band, 0)[1:3] for band in bands]
    shown = [displacement, *(inf if displacement == inf else least for least, _ in ends)]
    return tuple(
        most == 0.0 or _HIDDEN * resolved_time * most <= below
        for (_, most), below in zip(ends, shown[:-1], strict=True)
    )


def noise_share(k: int) -> float:
    """Return the noise's part of the posterior variance of derivative k: ∫ω²ᵏH² / ∫ω²ᵏH."""
    return 1.0 - (2 * k + 1) / (2 * PENALTY)


def critical_value(k: int, freedom: float) -> float:
    """Return c for which |z| > c somewhere with probability 0.05, z the error of derivative k.

        (κ/π)·exp(−c²/2) + 2·(1 − Φ(c)) = 0.05,   κ = (T/τ)·√(∫ω²ᵏ⁺²H² / ∫ω²ᵏH²)

    with H = 1/(1 + (ωτ)⁸), and T/τ from the degrees of freedom (T/2π)·∫H dω.
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    lengths = freedom * 2 * PENALTY * sin(pi / (2 * PENALTY))
    length = lengths * sqrt(_moment(k + 1) / _moment(k))

    def excess(c: float) -> float:
        crossings = length / pi * exp(-0.5 * c * c) + 2.0 * float(ndtr(-c))
        return crossings - (1.0 - CONFIDENCE)

    return float(brentq(excess, 0.0, 40.0))


def _moment(k: int) -> float:
    """Return ∫ω²ᵏ/(1 + ω⁸)² dω, but for a factor."""
    order = (2 * k + 1) / (2 * PENALTY)
    return (1.0 - order) / sin(order * pi)
