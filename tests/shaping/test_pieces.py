"""Taylor pieces: evaluation, integration and extrema against mpmath, numpy roots and samples."""

from math import factorial, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import piece_value, polynomial_extremes

from jounce.shaping.pieces import advance, evaluate, extrema, integral

ORDERS = range(1, 11)


def taylor(coefficients):
    """Return the Taylor state of a polynomial given by power coefficients, lowest first."""
    return np.array([c * factorial(j) for j, c in enumerate(coefficients)], dtype=float)


@pytest.mark.parametrize("order", ORDERS)
def test_evaluation_matches_mpmath(order):
    rng = np.random.default_rng(order)
    rows, tau = rng.normal(size=(order + 1, 9)), rng.uniform(0.0, 2.0, 9)
    values = evaluate(rows, tau, range(order + 1))
    for k in range(order + 1):
        expected = [float(piece_value(rows[:, i], tau[i], k)) for i in range(9)]
        scale = np.exp(2.0) * np.abs(rows).max()
        np.testing.assert_allclose(values[k], expected, rtol=0, atol=4e-16 * scale)


@pytest.mark.parametrize("order", ORDERS)
def test_every_range_of_derivatives_is_part_of_the_whole(order):
    rng = np.random.default_rng(100 + order)
    rows, tau = rng.normal(size=(order + 1, 50)), np.sort(rng.uniform(0.0, 2.0, 50))
    whole = evaluate(rows, tau, range(order + 1))
    for first in range(order + 1):
        for last in range(first + 1, order + 2):
            some = evaluate(rows, tau, range(first, last))
            np.testing.assert_array_equal(some, whole[first:last])


@pytest.mark.parametrize("order", ORDERS)
def test_advance_moves_the_whole_state(order):
    state = np.random.default_rng(order).normal(size=order + 1)
    expected = [float(piece_value(state, 0.7, k)) for k in range(order + 1)]
    np.testing.assert_allclose(advance(state, 0.7), expected, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(
        advance(advance(state, 0.5), 0.2), advance(state, 0.7), rtol=1e-13, atol=1e-14
    )


@pytest.mark.parametrize("order", ORDERS)
def test_integral_matches_mpmath(order):
    rng = np.random.default_rng(200 + order)
    durations, rows = rng.uniform(0.1, 1.5, 4), rng.normal(size=(order + 1, 4))
    for i, change in enumerate(integral(durations, rows)):
        expected = mpmath.quad(
            lambda t, i=i: piece_value(rows[:, i], float(t), 0), [0, float(durations[i])]
        )
        assert change == pytest.approx(float(expected), rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("degree", range(1, 12))
def test_extrema_of_chebyshev_polynomials_are_one(degree):
    shape = np.polynomial.Chebyshev.basis(degree, domain=[0.0, 3.0])
    state = taylor(shape.convert(kind=np.polynomial.Polynomial).coef)
    low, high = extrema(np.array([3.0]), state[:, None])
    rounding = 1e-15 * 6.0**degree  # power coefficients of T_n grow so
    assert (low[0], high[0]) == pytest.approx((-1.0, 1.0), abs=max(rounding, 1e-14))


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        ([2.0], (2.0, 2.0)),
        ([0.0, 0.0, 0.0], (0.0, 0.0)),
        ([1.0, -2.0], (-1.0, 1.0)),
        ([-0.125, 0.75, -1.5, 1.0], (-0.125, 0.125)),  # (t − 1/2)³: slope touches zero
        ([0.0625, -0.5, 1.5, -2.0, 1.0], (0.0, 0.0625)),  # (t − 1/2)⁴: a flat minimum
        ([0.0, -1e-9, 1.0], (-2.5e-19, 1.0 - 1e-9)),  # turns next to its start
        ([0.0, 2.0 - 1e-9, -1.0], (0.0, 1.0 - 1e-9)),  # turns next to its end
        ([0.0, 0.0, 16.0, -32.0, 16.0], (0.0, 1.0)),  # stationary at both ends and inside
        ([1.0, -1.0, 1e-300], (1e-300, 1.0)),
    ],
)
def test_extrema_of_degenerate_shapes(coefficients, expected):
    low, high = extrema(np.ones(1), taylor(coefficients)[:, None])
    assert (low[0], high[0]) == pytest.approx(expected, rel=1e-14, abs=1e-16)


def test_extrema_of_the_minimum_jerk_quintic():
    state = taylor([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
    expected = [(0.0, 1.0), (0.0, 1.875), (-10 / sqrt(3), 10 / sqrt(3)), (-30.0, 60.0)]
    for k, pair in enumerate(expected):
        low, high = extrema(np.ones(1), state[k:, None])
        assert (low[0], high[0]) == pytest.approx(pair, rel=1e-14, abs=1e-14)


@given(
    seed=st.integers(0, 2**32 - 1),
    degree=st.integers(1, 10),
    duration=st.sampled_from([1e-6, 0.3, 1.0, 2.5, 1e6]),
)
def test_extrema_are_attained_and_never_passed(seed, degree, duration):
    rng = np.random.default_rng(seed)
    unit = rng.normal(size=(degree + 1, 6)) * 10.0 ** rng.uniform(-1, 2, size=(degree + 1, 6))
    powers = duration ** -np.arange(degree + 1.0)
    rows = unit * powers[:, None]
    low, high = extrema(np.full(6, duration), rows)
    tau = np.linspace(0.0, duration, 400)
    for i in range(6):
        scale = np.abs(unit[:, i]).sum()
        samples = evaluate(np.repeat(rows[:, i, None], len(tau), axis=1), tau, range(1))[0]
        assert low[i] <= samples.min() + 1e-15 * scale
        assert high[i] >= samples.max() - 1e-15 * scale
        expected = polynomial_extremes(rows[:, i] / powers, 1.0, 0)
        assert (low[i], high[i]) == pytest.approx(expected, rel=0, abs=1e-12 * scale)
