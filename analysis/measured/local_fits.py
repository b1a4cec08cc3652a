"""A measured response between its lines: a rational function fitted around every gap.

Of no pole, one and two the fit is taken that Schwarz's criterion prefers, so that noise makes no
resonances; where it does not follow its lines, one of fewer lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .rational_fits import NUMERATOR, Complex, Index, Mask, Place, RationalFits, Real, rational_fits

LEAST_LINES = 8
"""Lines that a response has, at the least, to be fitted at all."""

_WINDOW, _FEW = 10, 7
_POOR, _ROUGH = 2.0, 5.0  # mean square misfit, in σ²
_SURE = 3.0  # standard deviations of a resonance between two lines
_BESIDE = 0.1  # of a gap
_PER_GAP = 8
_SPREAD = np.sinh(np.linspace(-3.0, 3.0, 13))  # halfwidths of a pole
_HOLE = 4.0  # spacings of the lines beside it
_LEVELLED, _BESIDE_LINE = 9, 5  # windows and lines over which an unknown noise is levelled
_FLOOR = 1e-9  # of |G|: what a file's digits leave of it
_MOST_POWER = 3
_STUDENT = 2.0  # (t/z)² of 95 % at the 4 degrees of freedom that 7 lines leave
_OVERFITTED = 0.7  # of σ², as fits of pure noise show it


@dataclass(frozen=True, eq=False)
class LocalFits:
    """Fits of the N − 1 gaps between N lines.

    Attributes
    ----------
    lines : (N,) array
        In Hz.
    sigma : (N,) array
        Complex standard deviation of each line, as measured, else as estimated from the misfit.
    curves : RationalFits
        One for each gap, of f^power·G: what integrators make steep is taken out beforehand.
    hole : (N − 1,) array of bool
        Gaps too wide to say what is in them.
    """

    lines: Real
    sigma: Real
    curves: RationalFits
    hole: Mask
    power: int

    def gap_of(self, frequency_hz: Real) -> Index:
        """Return the gap that each frequency lies in."""
        after = np.searchsorted(self.lines, frequency_hz, side="right")
        return np.clip(after - 1, 0, len(self.hole) - 1)

    def in_hole(self, frequency_hz: Real) -> Mask:
        """Return which frequencies lie in a hole."""
        gap = self.gap_of(frequency_hz)
        inside = (frequency_hz > self.lines[gap]) & (frequency_hz < self.lines[-1])
        return np.asarray(self.hole[gap] & inside)

    @cached_property
    def among(self) -> tuple[Real, Place]:
        """Frequencies in every gap, dense beside poles that lie in it, and the response there."""
        shares = (np.arange(_PER_GAP) + 0.5) / _PER_GAP
        inner = self.lines[:-1, None] + np.diff(self.lines)[:, None] * shares
        places = [self.lines[[0, -1]], inner[~self.hole].ravel(), self._beside_poles()]
        frequency = np.unique(np.concatenate(places))
        inside = (frequency >= self.lines[0]) & (frequency <= self.lines[-1])
        frequency = frequency[inside & ~self.in_hole(frequency)]
        return frequency, self.at(frequency)

    def value(self, frequency_hz: Real) -> Complex:
        """Return the response alone."""
        flat = self.curves.value(frequency_hz, self.gap_of(frequency_hz))
        return np.asarray(flat / frequency_hz**self.power)

    def at(self, frequency_hz: Real) -> Place:
        """Return the response at frequencies between the first and the last line."""
        flat = self.curves.at(frequency_hz, self.gap_of(frequency_hz))
        steep = frequency_hz**self.power
        slope = flat.slope - self.power * flat.value / frequency_hz
        return Place(flat.value / steep, flat.sigma / steep, slope / steep)

    def _beside_poles(self) -> Real:
        """Return places at and beside the poles that lie in the gaps of their fits."""
        poles = self.curves.poles()
        low, high = self.lines[:-1, None], self.lines[1:, None]
        with np.errstate(invalid="ignore"):
            inside = (poles.real > low) & (poles.real < high) & (abs(poles.imag) < high - low)
        some = poles[inside]
        return np.asarray((some.real[:, None] + abs(some.imag)[:, None] * _SPREAD).ravel())


def local_fits(lines: Real, response: Complex, sigma: Real | None) -> LocalFits:
    """Return fits of the gaps between lines.

    Parameters
    ----------
    lines : (N,) array
        Ascending, in Hz, `LEAST_LINES` at the least.
    response : (N,) complex array
    sigma : (N,) array, optional
        Complex standard deviations, √E|dG|². Default: estimated from what the fits leave.
    """
    hole = _holes(lines)
    few = _windows(hole, _FEW)
    power = _power(lines, response)
    flat = response * lines**power
    bars = _estimated_noise(lines, flat, few) if sigma is None else sigma * lines**power
    bars = np.maximum(bars, _FLOOR * np.maximum(abs(flat), 1e-300))
    wide = _windows(hole, min(_WINDOW, len(lines)))
    best = _preferred(lines, flat, bars, wide, np.arange(len(hole)))
    poor = np.flatnonzero(best.misfit > _POOR)
    if poor.size:
        narrow = _preferred(lines, flat, bars, few, poor)
        best.replace(poor, narrow, narrow.misfit < best.misfit[poor])
    return LocalFits(lines, bars / lines**power, best, hole, power)


def _power(lines: Real, response: Complex) -> int:
    """Return how many integrators the lowest lines look like."""
    size = np.log(np.maximum(abs(response[:LEAST_LINES]), 1e-300))
    slope = np.polyfit(np.log(lines[:LEAST_LINES]), size, 1)[0]
    return int(np.clip(round(-float(slope)), 0, _MOST_POWER))


def _holes(lines: Real) -> Mask:
    """Return which gaps are much wider than the two beside them."""
    gaps = np.diff(lines)
    before = np.concatenate([gaps[1:2], gaps[:-1]])
    after = np.concatenate([gaps[1:], gaps[-2:-1]])
    return np.asarray(gaps > _HOLE * np.maximum(before, after))


def _windows(hole: Mask, count: int) -> Index:
    """Return the numbers of the lines of each gap's window, (N − 1, count).

    A window is shifted off a hole as it is off the ends, where there are lines enough.
    """
    gap, lines = np.arange(len(hole)), len(hole) + 1
    first, last = np.zeros(len(hole), dtype=np.intp), np.full(len(hole), lines)
    for edge in np.flatnonzero(hole).tolist():
        first[edge + 1 :] = edge + 1
        last[: edge + 1] = np.minimum(last[: edge + 1], edge + 1)
    start = np.clip(gap + 1 - count // 2, first, np.maximum(last - count, first))
    return np.asarray(np.clip(start, 0, lines - count)[:, None] + np.arange(count))


def _estimated_noise(lines: Real, response: Complex, windows: Index) -> Real:
    """Return σ of each line from what fits of two poles leave, as a part of |G|, levelled.

    A line that noise makes small by chance counts with the size of its neighbours.
    """
    size = np.maximum(abs(response), 1e-300)
    size = np.maximum(size, _neighbours(size, _BESIDE_LINE))
    left = rational_fits(lines, response, size, windows, poles=2).misfit
    level = _neighbours(left, _LEVELLED)
    stiff = rational_fits(lines, response, size, windows, poles=1).misfit
    for end in (slice(_FEW // 2), slice(-(_FEW // 2), None)):  # a last line alone bends two poles
        level[end] = np.maximum(level[end], _STUDENT * np.maximum(left[end], stiff[end]))
    level = np.sqrt(level / _OVERFITTED)
    at_lines = np.concatenate([level[:1], np.maximum(level[:-1], level[1:]), level[-1:]])
    return np.asarray(at_lines * size)


def _neighbours(values: Real, count: int) -> Real:
    """Return the median of each value and those beside it."""
    reach = min(count, len(values))
    near = np.arange(len(values))[:, None] + np.arange(reach) - reach // 2
    return np.asarray(np.median(values[np.clip(near, 0, len(values) - 1)], axis=1))


def _preferred(
    lines: Real, response: Complex, sigma: Real, windows: Index, gaps: Index
) -> RationalFits:
    """Return for each of some gaps the fit that Schwarz's criterion prefers, of no pole up to two.

    Poles are not tried where they could not be preferred were their fit perfect.
    """
    count = windows.shape[1]
    best = rational_fits(lines, response, sigma, windows[gaps], poles=0)
    smooth = best.misfit < _ROUGH
    least = _cost(best, count, 0)
    for poles in (1, 2):
        some = np.flatnonzero(least > _cost_of(NUMERATOR + poles, count))
        fits = rational_fits(lines, response, sigma, windows[gaps[some]], poles=poles)
        doubtful = smooth[some] & _doubtful(lines, fits, gaps[some])
        cost = np.where(doubtful, np.inf, _cost(fits, count, poles))
        best.replace(some, fits, cost < least[some])
        least[some] = np.minimum(cost, least[some])
    return best


def _cost(fits: RationalFits, count: int, poles: int) -> Real:
    """Return −2·ln of the likelihood, and ln(2n) for each real coefficient."""
    coefficients = NUMERATOR + poles
    squares = 2.0 * fits.misfit * (count - coefficients)
    return np.asarray(squares + _cost_of(coefficients, count))


def _cost_of(coefficients: int, count: int) -> float:
    return 2.0 * coefficients * float(np.log(2.0 * count))


def _doubtful(lines: Real, fits: RationalFits, gaps: Index) -> Mask:
    """Return which fits have a resonance at or between the two lines that is lost in its σ."""
    room = _BESIDE * (lines[gaps + 1] - lines[gaps])
    low, high = lines[gaps] - room, lines[gaps + 1] + room
    doubtful = np.zeros(len(low), dtype=bool)
    for pole in fits.poles().T:
        some = np.flatnonzero((pole.real > low) & (pole.real < high))
        for side in (-1.0, 0.0, 1.0):
            at = fits.at(pole.real[some] + side * abs(pole.imag[some]), some)
            doubtful[some] |= abs(at.value) < _SURE * at.sigma
    return doubtful
