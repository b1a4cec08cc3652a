"""Signals in pieces: extremes and settling against values on a fine grid."""

from math import factorial, inf

import numpy as np
import pytest

from jounce.plant.signal_pieces import Pieces

U = np.linspace(0.0, 1.0, 20001)


def drawn(seed, degree, count=60):
    """Return pieces that go on from one another, and their values on a grid, one piece a row."""
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(degree + 1, count))
    durations = rng.uniform(0.1, 2.0, count)
    for i in range(1, count):
        coefficients[0, i] = coefficients[:, i - 1].sum()
    scale = np.array([factorial(k) / durations**k for k in range(degree + 1)])
    pieces = Pieces(np.cumsum(durations) - durations, durations, coefficients * scale)
    return pieces, np.array([np.polyval(c[::-1], U) for c in coefficients.T])


@pytest.mark.parametrize("degree", [0, 1, 2, 5, 12])
def test_extremes_are_those_of_a_fine_grid(degree):
    for seed in range(4):
        pieces, values = drawn(seed, degree)
        fine = 1e-6 * (1.0 + np.abs(values).max())
        low, high = pieces.extremes()
        assert values.min() - fine <= low <= values.min() + 1e-12
        assert values.max() - 1e-12 <= high <= values.max() + fine
        assert pieces.peak() == max(high, -low)


@pytest.mark.parametrize("degree", [1, 3, 9])
def test_the_last_time_outside_is_that_of_a_fine_grid(degree):
    pieces, values = drawn(3, degree)
    for share in (0.3, 0.7, 0.95):
        tolerance = share * np.abs(values).max()
        outside = np.argwhere(np.abs(values) > tolerance)
        piece, k = outside[-1]
        found = pieces.last_outside(tolerance)
        if found == inf:
            assert (piece, k) == (len(values) - 1, len(U) - 1)
        else:
            expected = pieces.times[piece] + U[k] * pieces.durations[piece]
            assert found == pytest.approx(expected, abs=1e-4)


def test_nothing_has_no_extremes():
    assert Pieces(np.empty(0), np.empty(0), np.empty((3, 0))).extremes() == (0.0, 0.0)
