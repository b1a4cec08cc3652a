"""Splines on equal knots against scipy's, and averages against quadrature."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from jounce.analysis.log_conformance.spline import SplineFit, basis

COUNT = 40


@pytest.fixture(scope="module")
def random_fit():
    rng = np.random.default_rng(5)
    factor = rng.normal(size=(COUNT, COUNT)) / COUNT
    covariance = factor @ factor.T
    band = np.zeros((6, COUNT))
    for i in range(6):
        band[i, : COUNT - i] = np.diag(covariance, -i)
    fit = SplineFit(3.0, 0.2, rng.normal(size=COUNT), band, 0.1, 0.5, 0.2, 10.0)
    knots = 3.0 + 0.2 * np.arange(-5, COUNT + 1)
    return fit, BSpline(knots, fit.coefficients, 5), knots, covariance


@pytest.mark.parametrize("k", range(6))
def test_the_basis_is_scipys(k):
    places = np.array([0.0, 0.3, 0.99])
    found = basis(places, k)
    for j in range(6):
        spline = BSpline(np.arange(-5, 7.0), np.eye(6)[j], 5)
        np.testing.assert_allclose(found[j], spline(places, k), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("k", range(4))
def test_derivatives_are_scipys(random_fit, k):
    fit, spline, _, _ = random_fit
    times = fit.times(4)
    assert len(times) == 4 * (COUNT - 5)
    expected = spline(times, k)
    np.testing.assert_allclose(fit.derivative(k, 4), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("k", range(4))
def test_variances_are_those_of_the_whole_matrix(random_fit, k):
    fit, _, knots, covariance = random_fit
    rows = np.column_stack(
        [BSpline(knots, np.eye(COUNT)[j], 5)(fit.times(3), k) for j in range(COUNT)]
    )
    expected = ((rows @ covariance) * rows).sum(axis=1)
    np.testing.assert_allclose(fit.variance(k, 3), expected, rtol=1e-9)


def test_averages_are_weighted_by_a_gaussian(random_fit):
    fit, spline, _, _ = random_fit
    width, at = 0.5, 70
    middle = fit.times(4)[at]
    offsets = np.linspace(-3.4, 3.4, 20_001)
    weights = np.exp(-0.5 * (offsets / width) ** 2)
    inside = spline.t[5] < middle - 3.4 < middle + 3.4 < spline.t[-6]
    assert inside, "the average must not reach the ends"
    expected = weights @ spline(middle + offsets, 1) / weights.sum()
    assert fit.averaged(1, 4, width)[at] == pytest.approx(expected, rel=1e-3)


def test_an_average_of_what_is_constant_is_the_same():
    fit = SplineFit(0.0, 0.5, 3.0 * np.arange(COUNT), np.zeros((6, COUNT)), 0.1, 1.0, 0.2, 4.0)
    np.testing.assert_allclose(fit.averaged(1, 4, 3.0), 6.0, rtol=1e-12)
