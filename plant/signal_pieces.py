"""A signal in polynomial pieces: its peak, and when it is outside a tolerance for the last time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from ..shaping.pieces import FloatArray

TERMS = 25
"""Of the Taylor series between the times that a run keeps: ‖A‖·h ≤ 2 there."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """A signal in pieces, given by its derivatives at the start of each, (n, m), n ≤ TERMS."""

    times: FloatArray
    durations: FloatArray
    rows: FloatArray

    @cached_property
    def scaled(self) -> FloatArray:
        """Coefficients of powers of the part of a piece that has passed."""
        scaled, power = self.rows.copy(), np.ones_like(self.durations)
        for k in range(1, len(scaled)):
            power *= self.durations / k
            scaled[k] *= power
        return scaled

    @cached_property
    def ends(self) -> FloatArray:
        """Values at start and end of each piece, (2, m)."""
        return np.array([self.rows[0], self.scaled.sum(axis=0)])

    @cached_property
    def bumps(self) -> FloatArray:
        """By how much a piece is at most beyond its ends: |p″| is at most 8 times as large."""
        found = np.zeros_like(self.durations)
        for k in range(2, len(self.scaled)):
            found += (k * (k - 1.0) / 8.0) * np.abs(self.scaled[k])
        return found

    def peak(self) -> float:
        """Return the largest magnitude."""
        low, high = self.extremes()
        return max(high, -low)

    def extremes(self) -> tuple[float, float]:
        """Return the smallest and the largest value; 0 where there are no pieces."""
        if not self.times.size:
            return 0.0, 0.0
        return -self._largest(-1.0), self._largest(1.0)

    def _largest(self, sign: float) -> float:
        """Return the largest value of sign·p: at an end, or where a piece that may pass it turns.

        Pieces are looked at from the one that may pass it by most.
        """
        ends = (sign * self.ends).max(axis=0)
        known, most = float(ends.max()), ends + self.bumps
        some = np.flatnonzero(most > known)
        for i in some[np.argsort(-most[some])].tolist():
            if most[i] <= known:
                break
            known = max(known, self._turning(i, sign))
        return known

    def _turning(self, i: int, sign: float) -> float:
        """Return the largest value of sign·p where it turns within a piece."""
        coefficients = sign * self.scaled[:, i]
        at = _roots_between(coefficients[1:] * np.arange(1.0, len(coefficients)))
        return float(np.polyval(coefficients[::-1], at).max()) if at else -inf

    def last_outside(self, tolerance: float) -> float:
        """Return the last time at which the magnitude exceeds a tolerance.

        0 where it never does, infinite where it does so at the end.
        """
        outside = np.abs(self.ends).max(axis=0) + self.bumps > tolerance
        for i in np.flatnonzero(outside)[::-1]:
            part = self._last_part_outside(self.scaled[:, i], tolerance)
            if part is not None:
                at_end = i == len(self.times) - 1 and part >= 1.0
                return inf if at_end else float(self.times[i] + part * self.durations[i])
        return 0.0

    @staticmethod
    def _last_part_outside(coefficients: FloatArray, tolerance: float) -> float | None:
        """Return the last part of a piece with a magnitude beyond the tolerance, 1 for its end."""
        if abs(coefficients.sum()) > tolerance:
            return 1.0
        roots: list[float] = []
        for level in (tolerance, -tolerance):
            shifted = coefficients.copy()
            shifted[0] -= level
            roots += _roots_between(shifted)
        for root in sorted(roots, reverse=True):
            before = root - 1e-9 * max(root, 1e-3)
            if abs(np.polyval(coefficients[::-1], before)) > tolerance:
                return root
        return 0.0 if abs(coefficients[0]) > tolerance else None


def _roots_between(coefficients: FloatArray) -> list[float]:
    """Return real roots in [0, 1], polished by Newton's iteration."""
    sizes = np.abs(coefficients)
    if not sizes.any() or sizes[0] > sizes[1:].sum():
        return []
    count = int(np.flatnonzero(sizes > 1e-19 * sizes.max())[-1]) + 1
    polynomial = coefficients[:count][::-1]
    slope = np.polyder(polynomial)
    found = []
    for root in np.roots(polynomial):
        x = float(root.real)
        if abs(root.imag) > 1e-6 or not -1e-6 <= x <= 1.0 + 1e-6:
            continue
        for _ in range(4):
            rate = float(np.polyval(slope, x))
            x -= float(np.polyval(polynomial, x)) / rate if rate else 0.0
        if 0.0 <= x <= 1.0:
            found.append(x)
    return found
