"""Polynomials by the thousand: products of their coefficients, and their roots.

Rows of an array are polynomials, their coefficients in ascending powers.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .factored_loop import Complex, Real

NONE = -np.inf
"""Stands for a root that is not there."""

_NEGLIGIBLE = 1e-150


def trimmed(rows: Real) -> tuple[Real, Real]:
    """Return the rows shifted to a constant term other than zero, and by how many powers.

    A row of zeros stays as it is.
    """
    count, width = rows.shape
    lowest = np.argmax(rows != 0, axis=1)
    places = lowest[:, None] + np.arange(width)
    padded = np.concatenate([rows, np.zeros((count, width))], axis=1)
    return np.take_along_axis(padded, places, axis=1), lowest


def degrees(rows: Real) -> Real:
    """Return the degree of each row, 0 for a row of zeros."""
    some = rows != 0
    return np.where(some.any(axis=1), rows.shape[1] - 1 - np.argmax(some[:, ::-1], axis=1), 0)


def product(
    left: Real, right: Real, weigh: Callable[[int, int], float | Real] = lambda *_: 1.0
) -> Real:
    """Return Σ w(i, j)·aᵢ·bⱼ·xⁱ⁺ʲ of each pair of rows."""
    if not left.shape[1] or not right.shape[1]:
        return np.zeros((len(left), 1))
    total = np.zeros((len(left), left.shape[1] + right.shape[1] - 1))
    for i, a in enumerate(left.T):
        for j, b in enumerate(right.T):
            total[:, i + j] += weigh(i, j) * a * b
    return total


def summed(*parts: Real) -> Real:
    """Return the sum of polynomials of any degree, row by row."""
    total = np.zeros((len(parts[0]), max(part.shape[1] for part in parts)))
    for part in parts:
        total[:, : part.shape[1]] += part
    return total


def roots(rows: Real) -> Complex:
    """Return the roots of each row but those at zero, (B, degree), filled up with NONE."""
    largest = abs(rows).max(axis=1, initial=0.0)
    scaled = np.ldexp(rows, -np.frexp(largest)[1][:, None])
    scaled, _ = trimmed(np.where(abs(scaled) < _NEGLIGIBLE, 0.0, scaled))
    degree = degrees(scaled)
    found = np.full((len(rows), max(rows.shape[1] - 1, 0)), NONE, dtype=complex)
    for n in np.unique(degree[degree > 0]).tolist():
        [some] = np.nonzero(degree == n)
        found[some, :n] = _of_degree(scaled[some, : n + 1])
    return found


def _of_degree(rows: Real) -> Complex:
    degree = rows.shape[1] - 1
    if degree == 1:
        return np.asarray(-rows[:, :1] / rows[:, 1:], dtype=complex)
    if degree == 2:
        return _of_quadratics(*rows.T)
    size = abs(rows)
    power = np.rint((np.log2(size[:, 0]) - np.log2(size[:, -1])) / degree)
    scaled = rows * np.exp2(power[:, None] * (np.arange(degree + 1.0) - degree))
    companion = np.zeros((len(rows), degree, degree))
    companion[:, 1:, :-1] = np.eye(degree - 1)
    companion[:, :, -1] = -scaled[:, :-1] / scaled[:, -1:]
    return np.asarray(np.linalg.eigvals(companion) * np.exp2(power)[:, None], dtype=complex)


def _of_quadratics(c: Real, b: Real, a: Real) -> Complex:
    square = b * b - 4.0 * a * c
    root = np.sqrt(abs(square))
    larger = -0.5 * (b + np.where(b < 0.0, -root, root))
    real = np.stack([larger / a, c / larger], axis=1)
    pair = (-b + 1j * root) / (2.0 * a)
    return np.where((square >= 0.0)[:, None], real, np.stack([pair, pair.conj()], axis=1))
