"""Splines on equally spaced knots: basis, derivatives, variances and averages of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...shaping.frozen import Frozen

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

DEGREE = 5


@dataclass(frozen=True, eq=False)
class SplineFit(Frozen):
    """A spline of degree 5 through readings, with the covariance of its coefficients.

    Attributes
    ----------
    start, spacing : float
        Time of the first knot and distance of the knots.
    coefficients : (K,) array
        Of the B-splines; number j is not zero on the intervals j − 5 … j between knots.
    covariance : (6, K) array
        Row i holds the covariances of coefficients j + i and j.
    noise : float
        Standard deviation of a reading.
    smoothing_time : float
        τ of the equivalent kernel, whose frequency response is 1/(1 + (ωτ)⁸).
    reading_time : float
        From reading to reading, but for the farthest twentieth.
    freedom : float
        Equivalent degrees of freedom: trace of the matrix that takes readings to the fit.
    """

    start: float
    spacing: float
    coefficients: FloatArray
    covariance: FloatArray
    noise: float
    smoothing_time: float
    reading_time: float
    freedom: float

    @property
    def sharpness(self) -> float:
        """Time in which the fit can change: τ, or from reading to reading where that is longer."""
        return max(self.smoothing_time, self.reading_time)

    def times(self, per_interval: int) -> FloatArray:
        """Return the times of points spread evenly over every interval between knots."""
        intervals = np.arange(len(self.coefficients) - DEGREE)[:, None]
        return np.asarray(self.start + self.spacing * (intervals + _places(per_interval)).ravel())

    def derivative(self, k: int, per_interval: int) -> FloatArray:
        """Return derivative k at those points."""
        return self._curve(np.diff(self.coefficients, k), k, per_interval)

    def averaged(self, k: int, per_interval: int, width: float) -> FloatArray:
        """Return derivative k there, averaged over time by a Gaussian of that standard deviation.

        Beyond the ends the derivative counts as constant.
        """
        from scipy.ndimage import gaussian_filter1d

        differences = np.diff(self.coefficients, k)
        smoothed = gaussian_filter1d(differences, width / self.spacing, mode="nearest")
        return self._curve(smoothed, k, per_interval)

    def variance(self, k: int, per_interval: int) -> FloatArray:
        """Return the posterior variance of derivative k there."""
        weights = basis(_places(per_interval), k)
        intervals = self.covariance.shape[1] - DEGREE
        total = np.zeros((intervals, per_interval))
        for i in range(DEGREE + 1):
            for j in range(i, DEGREE + 1):
                shared = self.covariance[j - i, i : i + intervals, None]
                total += shared * ((1.0 if i == j else 2.0) * weights[i] * weights[j])
        return np.asarray(np.maximum(total, 0.0).ravel() / self.spacing ** (2 * k))

    def _curve(self, differences: FloatArray, k: int, per_interval: int) -> FloatArray:
        weights = basis(_places(per_interval), degree=DEGREE - k) / self.spacing**k
        intervals = len(self.coefficients) - DEGREE
        curve = np.zeros((intervals, per_interval))
        for j, weight in enumerate(weights):
            curve += differences[j : j + intervals, None] * weight
        return curve.ravel()


def basis(places: FloatArray, k: int = 0, degree: int = DEGREE) -> FloatArray:
    """Return derivative k of the B-splines that are not zero on one interval between knots.

    Parameters
    ----------
    places : (N,) array
        Where in the interval, from 0 to 1; knots are 1 apart.
    k : int, optional
        At most `degree`.
    degree : int, optional

    Returns
    -------
    (degree + 1, N) array
        The B-spline that begins `degree` intervals earlier first.
    """
    from scipy.interpolate import BSpline

    knots, unit = np.arange(-degree, degree + 2.0), np.eye(degree + 1)
    rows = np.zeros((degree + 1, len(places)))
    for row, coefficients in zip(rows, unit, strict=True):
        spline = BSpline(knots, coefficients, degree)
        for order in range(degree, k - 1, -1):
            row *= places / (order - k + 1)
            row += float(spline(0.0, order))
    return rows


def _places(per_interval: int) -> FloatArray:
    return np.asarray((np.arange(per_interval) + 0.5) / per_interval)
