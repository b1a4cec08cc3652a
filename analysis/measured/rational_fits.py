"""Rational functions fitted to many windows of lines at once.

With r the frequency from the middle of a window in halves of its width,

    G(r) = (a₀ + a₁r + a₂r²)/(1 + b₁r + b₂r²),

by linear least squares with weights 1/(σ|D|), D being the denominator of the round before
(Sanathanan and Koerner, IEEE Trans. Automatic Control 8 (1963) 56-58).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]

NUMERATOR = 3
"""Coefficients of the numerator."""

_ROUNDS = 4
_AT_ONCE = 2048  # windows: what a cache holds
_PRIOR = 1e-3  # one over the size of b that is no surprise: keeps fits of too many poles regular


class Place(NamedTuple):
    """A response at some frequencies: value, complex standard deviation and slope by f."""

    value: Complex
    sigma: Real
    slope: Complex


class RationalFits(NamedTuple):
    """K fits.

    Attributes
    ----------
    middle, halfwidth : (K,) arrays
        Of the windows, in Hz.
    coefficients : (K, 5) complex array
        a₀, a₁, a₂, b₁, b₂.
    covariance : (K, 5, 5) complex array
        As the standard deviations of the lines make it.
    misfit : (K,) array
        Mean square of (measured − fitted)/σ per degree of freedom, expected 1.
    """

    middle: Real
    halfwidth: Real
    coefficients: Complex
    covariance: Complex
    misfit: Real

    def value(self, frequency_hz: Real, which: Index) -> Complex:
        """Return the values of some fits alone, one at each frequency."""
        r = (frequency_hz - self.middle[which]) / self.halfwidth[which]
        a0, a1, a2, b1, b2 = self.coefficients[which].T
        return np.asarray((a0 + r * (a1 + r * a2)) / (1.0 + r * (b1 + r * b2)))

    def at(self, frequency_hz: Real, which: Index) -> Place:
        """Return some fits with their standard deviations and slopes, one at each frequency."""
        width = self.halfwidth[which]
        above, below = self.coefficients[which, :NUMERATOR], self.coefficients[which, NUMERATOR:]
        powers = ((frequency_hz - self.middle[which]) / width)[:, None] ** np.arange(3)
        rising = np.arange(1, 3) * powers[:, :2]
        divisor = 1.0 + (below * powers[:, 1:]).sum(axis=1)
        value = (above * powers).sum(axis=1) / divisor
        slope = (above[:, 1:] * rising).sum(axis=1) - value * (below * rising).sum(axis=1)
        by = np.concatenate([powers, -value[:, None] * powers[:, 1:]], axis=1) / divisor[:, None]
        variance = np.einsum("ki,kij,kj->k", by, self.covariance[which], by.conj()).real
        sigma = np.sqrt(np.maximum(variance * np.maximum(self.misfit[which], 1.0), 0.0))
        return Place(value, sigma, slope / divisor / width)

    def poles(self) -> Complex:
        """Return the poles as complex frequencies in Hz, (K, 2), nan where there are fewer."""
        found = np.full((len(self.middle), 2), np.nan, dtype=complex)
        b1, b2 = self.coefficients[:, 3], self.coefficients[:, 4]
        one, two = (b2 == 0.0) & (b1 != 0.0), b2 != 0.0
        found[one, 0] = -1.0 / b1[one]
        root = np.sqrt(b1[two] ** 2 - 4.0 * b2[two])
        found[two] = np.stack([root - b1[two], -root - b1[two]], axis=1) / (2.0 * b2[two, None])
        return np.asarray(self.middle[:, None] + self.halfwidth[:, None] * found)

    def replace(self, some: Index, others: RationalFits, where: Mask) -> None:
        """Put in others, which are fits of some windows, where they are chosen."""
        for own, other in zip(self, others, strict=True):
            own[some[where]] = other[where]


def rational_fits(
    lines: Real, response: Complex, sigma: Real, windows: Index, *, poles: int
) -> RationalFits:
    """Return the fits of all windows with 0, 1 or 2 poles, coefficients beyond them 0.

    Parameters
    ----------
    lines, response, sigma : (N,) arrays
    windows : (K, n) array
        Numbers of the lines in each; n is more than 3 + poles.
    poles : int
    """
    starts = range(0, max(len(windows), 1), _AT_ONCE)
    parts = [
        _fits(lines, response, sigma, windows[start : start + _AT_ONCE], poles) for start in starts
    ]
    return RationalFits(*(np.concatenate(some) for some in zip(*parts, strict=True)))


def _fits(lines: Real, response: Complex, sigma: Real, windows: Index, poles: int) -> RationalFits:
    first, last = lines[windows[:, 0]], lines[windows[:, -1]]
    middle, halfwidth = 0.5 * (first + last), 0.5 * (last - first)
    values, weight = response[windows], 1.0 / sigma[windows]
    r = (lines[windows] - middle[:, None]) / halfwidth[:, None]
    powers = r[:, :, None] ** np.arange(NUMERATOR)
    columns = [powers, -values[:, :, None] * powers[:, :, 1 : poles + 1]]
    terms = np.concatenate(columns, axis=2)
    best, upper, misfit = _rounds(terms, values, weight, powers)
    coefficients = np.zeros((len(windows), 5), dtype=complex)
    coefficients[:, : NUMERATOR + poles] = best
    freedom = windows.shape[1] - NUMERATOR - poles
    return RationalFits(middle, halfwidth, coefficients, _covariance(upper), misfit / freedom)


def _rounds(
    terms: Complex, values: Complex, weight: Real, powers: Real
) -> tuple[Complex, Complex, Real]:
    """Return the coefficients of the best round, R of its QR factors and its sum of squares."""
    count, poles = len(terms), terms.shape[2] - NUMERATOR
    prior = np.zeros((count, poles, terms.shape[2]))
    prior[:, np.arange(poles), NUMERATOR + np.arange(poles)] = _PRIOR
    below = np.ones_like(values)
    best = np.zeros((count, terms.shape[2]), dtype=complex)
    uppers = np.zeros((count, terms.shape[2], terms.shape[2]), dtype=complex)
    least = np.full(count, np.inf)
    for _ in range(_ROUNDS if poles else 1):
        rows = weight / abs(below)
        matrix = np.concatenate([terms * rows[:, :, None], prior], axis=1)
        right = np.concatenate([values * rows, np.zeros((count, poles))], axis=1)
        q, upper = np.linalg.qr(matrix)
        upper = _regular(upper)
        projected = q.conj().swapaxes(1, 2) @ right[:, :, None]
        found = np.linalg.solve(upper, projected)[:, :, 0]
        below = 1.0 + (found[:, None, NUMERATOR:] * powers[:, :, 1 : poles + 1]).sum(axis=2)
        below = np.where(below == 0.0, 1e-12, below)
        fitted = (found[:, None, :NUMERATOR] * powers).sum(axis=2) / below
        square = (abs((values - fitted) * weight) ** 2).sum(axis=1)
        better = square < least
        best[better], uppers[better] = found[better], upper[better]
        least = np.minimum(least, square)
    return best, uppers, least


def _covariance(upper: Complex) -> Complex:
    """Return (RᴴR)⁻¹ in blocks of 5 × 5."""
    inverse = np.linalg.inv(upper)
    size = upper.shape[1]
    whole = np.zeros((len(upper), 5, 5), dtype=complex)
    whole[:, :size, :size] = inverse @ inverse.conj().swapaxes(1, 2)
    return whole


def _regular(upper: Complex) -> Complex:
    """Return R with a diagonal that is kept off zero."""
    size = np.arange(upper.shape[1])
    diagonal = upper[:, size, size]
    least = 1e-14 * abs(diagonal).max(axis=1, keepdims=True) + 1e-300
    upper[:, size, size] = np.where(abs(diagonal) > least, diagonal, least)
    return upper
