"""Smoothing of readings: a penalised spline whose smoothness is found by likelihood."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, exp, log, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from .banded import band_of, banded, inverse_band, times_vector
from .readings import reading_time
from .spline import DEGREE, SplineFit, basis

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

PENALTY = 4
"""Derivative whose square is penalised: the lowest that leaves jerk a finite variance."""

_DIFFERENCES = [(-1.0) ** j * comb(PENALTY, j) for j in range(PENALTY + 1)]
_TWO_SCALE = [comb(DEGREE + 1, j) / 2.0**DEGREE for j in range(DEGREE + 2)]
_FEWEST, _MOST = 4, 2**18  # intervals between knots
_STEP = sqrt(2.0)  # from one smoothing time that is tried to the next
_ROUNDING = 4.0 * np.finfo(float).eps  # of the largest position
_LONGEST_GAP = 50.0  # in τ: knots in a longer one depend on nothing but rounding
_SOLVED = 1e-12  # of half the travel, to which the equations can be solved


def fit_spline(times: FloatArray, positions: FloatArray, least_noise: float) -> SplineFit:
    """Fit a spline to readings by penalised least squares, smoothed by likelihood.

        Σ (y_i − f(t_i))² + λ·∫ f''''(t)² dt → min

    The integral is that of P-splines: h⁻⁷ times the sum of squares of the fourth differences of
    the coefficients, on knots so close that they do not matter (h < τ/2, unless the readings
    are no closer). λ and the noise σ maximise the restricted likelihood of the model in which
    f'''' is white noise, σ not below `least_noise`. The covariance is that of f given the
    readings in this model: noise, and on average over the log the bias of smoothing.

    Parameters
    ----------
    times : (N,) array
        Strictly increasing, N > 4.
    positions : (N,) array
    least_noise : float
        Lowest standard deviation of a reading; positive where the positions are all the same.

    Raises
    ------
    ValueError
        For readings so unevenly spread that they leave a polynomial of degree 3 open.

    Notes
    -----
    Memory and time are proportional to N. There are at most 262,144 intervals between knots, and
    τ is at least a fiftieth of the longest time without a reading.

    References
    ----------
    Eilers & Marx, "Flexible smoothing with B-splines and penalties", Statistical Science 11
    (1996). Wahba, "A comparison of GCV and GML for choosing the smoothing parameter", Annals of
    Statistics 13 (1985); "Bayesian 'confidence intervals' for the cross-validated smoothing
    spline", J. Roy. Stat. Soc. B 45 (1983).
    """
    span = float(times[-1] - times[0])
    floor = max(least_noise, _ROUNDING * float(np.abs(positions).max()))
    middle = 0.5 * float(positions.min() + positions.max())
    scale = 0.5 * float(np.ptp(positions)) or floor
    least_variance = max(floor / scale, _SOLVED) ** 2
    try:
        readings = _Readings(
            (times - times[0]) / span, (positions - middle) / scale, least_variance
        )
        level, ratio = readings.best()
        found = readings.solve(level, ratio)
    except np.linalg.LinAlgError:
        raise ValueError(
            "the readings lie in too few places in time to be fitted: leave the pauses out and "
            "check what lies between them apart"
        ) from None
    covariance = inverse_band(found.factor)
    shared = covariance * level.gram
    return SplineFit(
        start=float(times[0]),
        spacing=span / level.intervals,
        coefficients=middle + scale * found.coefficients,
        covariance=covariance * (found.variance * scale**2),
        noise=sqrt(found.variance) * scale,
        smoothing_time=ratio * span / level.intervals,
        reading_time=reading_time(times),
        freedom=float(shared[0].sum() + 2.0 * shared[1:].sum()),
    )


@dataclass(frozen=True, eq=False)
class _Level:
    """Normal equations on one grid of knots; `refine` takes coefficients to the finest grid."""

    intervals: int
    gram: FloatArray
    moments: FloatArray
    penalty: FloatArray
    refine: Any


@dataclass(frozen=True, eq=False)
class _Solution:
    coefficients: FloatArray
    factor: FloatArray
    variance: float
    criterion: float


class _Readings:
    """Readings on a time from 0 to 1, and their normal equations on grids of knots.

    Each grid has half the intervals of the one before; its equations follow by the two-scale
    relation of B-splines, so that the readings are gone through once. Misfits are counted from
    a close fit, lest the sum of squares cancel.
    """

    def __init__(self, times: FloatArray, values: FloatArray, least_variance: float) -> None:
        self.count, self.least_variance = len(times), least_variance
        intervals = _FEWEST
        while intervals < min(self.count, _MOST):
            intervals *= 2
        finest = _finest_level(times, values, intervals)
        self.levels = [finest]
        while self.levels[-1].intervals > _FEWEST:
            self.levels.append(_coarser(self.levels[-1]))
        self._shortest = float(np.diff(times).max()) / _LONGEST_GAP
        start, ratio = self._trials()[0]
        self._close = start.refine @ _solved(start, self._weight(start, ratio))[1]
        misfits = values - _at(times, self._close, intervals)
        self._rest = float(misfits @ misfits)
        self._slope = _moments(times, misfits, intervals)

    def best(self) -> tuple[_Level, float]:
        """Return the grid and the ratio τ/h of the greatest likelihood."""
        from scipy.optimize import minimize_scalar

        level, ratio = min(self._trials(), key=lambda trial: self.solve(*trial).criterion)
        least = max(ratio / _STEP, self._shortest * level.intervals)
        found = minimize_scalar(
            lambda log_ratio: self.solve(level, exp(log_ratio)).criterion,
            bounds=(log(least), log(ratio * _STEP)),
            method="bounded",
            options={"xatol": 1e-3},
        )
        return level, exp(found.x)

    def _trials(self) -> list[tuple[_Level, float]]:
        """Return grids and ratios τ/h, the shortest τ first."""
        trials = [
            (level, 1.25 * _STEP**exponent)
            for level in self.levels
            for exponent in range(0 if level is self.levels[0] else 2, 4)
        ]
        return [trial for trial in trials if trial[1] >= self._shortest * trial[0].intervals]

    def _weight(self, level: _Level, ratio: float) -> float:
        return self.count / level.intervals * ratio ** (2 * PENALTY)

    def solve(self, level: _Level, ratio: float) -> _Solution:
        """Return the fit for τ = ratio·h, with −2·log of its restricted likelihood."""
        intervals, free = level.intervals, self.count - PENALTY
        weight = self._weight(level, ratio)
        factor, coefficients = _solved(level, weight)
        away = level.refine @ coefficients - self._close
        misfit = self._rest - 2.0 * away @ self._slope
        misfit += away @ times_vector(self.levels[0].gram, away)
        jumps = np.diff(coefficients, PENALTY)
        total = max(misfit, 0.0) + weight * float(jumps @ jumps)
        variance = max(total / free, self.least_variance)
        criterion = free * log(variance) + total / variance
        criterion += 2.0 * float(np.log(factor[0]).sum()) - len(jumps) * log(weight)
        # polynomials have coefficients that depend on the grid: what makes grids comparable
        criterion -= PENALTY * (PENALTY - 1) * log(intervals)
        return _Solution(coefficients, factor, variance, criterion)


def _solved(level: _Level, weight: float) -> tuple[FloatArray, FloatArray]:
    """Return the Cholesky factor of the normal equations, and the coefficients."""
    from scipy.linalg import cho_solve_banded, cholesky_banded

    factor = cholesky_banded(level.gram + weight * level.penalty, lower=True)
    return factor, np.asarray(cho_solve_banded((factor, True), level.moments))


def _finest_level(times: FloatArray, values: FloatArray, intervals: int) -> _Level:
    from scipy.sparse import eye_array

    where, weights = _weights(times, intervals)
    count = intervals + DEGREE
    gram = np.zeros((DEGREE + 1, count))
    for i in range(DEGREE + 1):
        for j in range(i, DEGREE + 1):
            gram[j - i] += np.bincount(where + i, weights[i] * weights[j], count)
    moments = _moments(times, values, intervals)
    return _Level(intervals, gram, moments, _penalty(count), eye_array(count, format="csr"))


def _coarser(level: _Level) -> _Level:
    from scipy.sparse import csr_array

    fine, count = level.intervals + DEGREE, level.intervals // 2 + DEGREE
    columns = np.repeat(np.arange(count), len(_TWO_SCALE))
    rows = 2 * columns - DEGREE + np.tile(np.arange(len(_TWO_SCALE)), count)
    inside = (rows >= 0) & (rows < fine)
    shares = np.tile(_TWO_SCALE, count)
    refine = csr_array((shares[inside], (rows[inside], columns[inside])), shape=(fine, count))
    gram = band_of(refine.T @ banded(level.gram) @ refine, DEGREE)
    moments = refine.T @ level.moments
    return _Level(level.intervals // 2, gram, moments, _penalty(count), level.refine @ refine)


def _penalty(count: int) -> FloatArray:
    """Return the band of DᵀD, D the fourth differences of so many coefficients."""
    band = np.zeros((DEGREE + 1, count))
    for i, first in enumerate(_DIFFERENCES):
        for j, second in enumerate(_DIFFERENCES[i:]):
            band[j, i : count - PENALTY + i] += first * second
    return band


def _weights(times: FloatArray, intervals: int) -> tuple[Any, FloatArray]:
    """Return the interval of each time and the B-splines there."""
    places = times * intervals
    where = np.minimum(places.astype(int), intervals - 1)
    return where, basis(places - where)


def _moments(times: FloatArray, values: FloatArray, intervals: int) -> FloatArray:
    where, weights = _weights(times, intervals)
    count = intervals + DEGREE
    parts = [np.bincount(where + i, weights[i] * values, count) for i in range(DEGREE + 1)]
    return np.asarray(np.sum(parts, axis=0))


def _at(times: FloatArray, coefficients: FloatArray, intervals: int) -> FloatArray:
    where, weights = _weights(times, intervals)
    values = np.zeros(len(times))
    for i, weight in enumerate(weights):
        values += weight * coefficients[where + i]
    return values
