"""The smoothing spline against a slow one without knots, built from its kernel."""

from math import factorial, sqrt

import numpy as np
import pytest

from jounce.analysis.log_conformance.fit import fit_spline

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for the kernel's degree 6


def kernel(s, t, k):
    """Return ∂ᵏ/∂sᵏ ∫ (s − u)₊³·(t − u)₊³ / 36 du."""
    upper = np.minimum(s[:, None], t[None])
    u = 0.5 * upper[..., None] * (1.0 + NODES)
    left = (s[:, None, None] - u) ** (3 - k) / factorial(3 - k)
    right = (t[None, :, None] - u) ** 3 / 6.0
    return 0.5 * upper * (left * right * WEIGHTS).sum(axis=-1)


def cubics(t, k):
    return np.column_stack(
        [np.zeros_like(t) if j < k else t ** (j - k) / factorial(j - k) for j in range(4)]
    )


class ExactSpline:
    """Smoothing spline of 0 ≤ t ≤ 1: cubic polynomial plus Gaussian process (Wahba)."""

    def __init__(self, t, y, smoothing_time):
        self.t, self.b = t, 1.0 / (len(t) * smoothing_time**8)
        spread = self.b * kernel(t, t, 0) + np.eye(len(t))
        self.inverse, p = np.linalg.inv(spread), cubics(t, 0)
        self.normal = p.T @ self.inverse @ p
        self.project = np.linalg.solve(self.normal, p.T @ self.inverse)
        self.rest = self.inverse @ (np.eye(len(t)) - p @ self.project)
        self.y, free = y, len(t) - 4
        self.variance = y @ self.rest @ y / free
        determinants = np.linalg.slogdet(spread)[1] + np.linalg.slogdet(self.normal)[1]
        self.criterion = free * np.log(self.variance) + determinants

    def weights(self, at, k):
        """Return the rows that take readings to derivative k."""
        return cubics(at, k) @ self.project + self.b * kernel(at, self.t, k) @ self.rest

    def posterior(self, at, k):
        """Return the variance of derivative k given the readings."""
        cross = self.b * kernel(at, self.t, k)
        own = self.b * at ** (7 - 2 * k) / ((7 - 2 * k) * factorial(3 - k) ** 2)
        rows = cubics(at, k) - cross @ self.inverse @ cubics(self.t, 0)
        known = ((cross @ self.inverse) * cross).sum(axis=1)
        trend = ((rows @ np.linalg.inv(self.normal)) * rows).sum(axis=1)
        return self.variance * (own - known + trend)


@pytest.fixture(scope="module")
def noisy():
    rng = np.random.default_rng(3)
    t = np.sort(rng.uniform(0.0, 1.0, 120))
    t[0], t[-1] = 0.0, 1.0
    y = np.sin(9.0 * t) + 0.02 * rng.standard_normal(len(t))
    fit = fit_spline(t, y, 0.0)
    return t, y, fit, ExactSpline(t, y, fit.smoothing_time)


@pytest.mark.parametrize("k", range(4))
def test_the_fit_is_the_smoothing_spline(noisy, k):
    """To a fiftieth of its own standard deviation: knots do not matter."""
    _, y, fit, exact = noisy
    at = fit.times(4)
    expected, deviation = exact.weights(at, k) @ y, np.sqrt(fit.variance(k, 4))
    assert np.all(np.abs(fit.derivative(k, 4) - expected) < 0.02 * deviation)


@pytest.mark.parametrize(("k", "rtol"), [(1, 0.05), (2, 0.05), (3, 0.15)])
def test_the_covariance_is_that_of_the_process(noisy, k, rtol):
    """Of jerk, knots leave out the finest part: its sample paths are rough."""
    _, _, fit, exact = noisy
    expected = np.sqrt(exact.posterior(fit.times(4), k))
    np.testing.assert_allclose(np.sqrt(fit.variance(k, 4)), expected, rtol=rtol)


def test_noise_freedom_and_smoothing_are_the_likeliest(noisy):
    t, y, fit, exact = noisy
    assert fit.noise == pytest.approx(sqrt(exact.variance), rel=1e-3)
    assert fit.freedom == pytest.approx(np.trace(exact.weights(t, 0)), rel=3e-3)
    best = sqrt(0.01 * 0.3)
    for width in (sqrt(30.0), 1.25):  # the whole range, then where the best of it lies
        tried = best * np.geomspace(1.0 / width, width, 20)
        best = tried[np.argmin([ExactSpline(t, y, tau).criterion for tau in tried])]
    assert fit.smoothing_time == pytest.approx(best, rel=0.03)


@pytest.mark.parametrize("degree", range(4))
@pytest.mark.parametrize("noise", [1e-6, 1e-2])
def test_polynomials_are_left_as_they_are(degree, noise):
    t = np.linspace(2.0, 5.0, 300)
    y = (t - 3.0) ** degree + noise * np.random.default_rng(degree).standard_normal(300)
    fit = fit_spline(t, y, 0.0)
    assert fit.freedom < 7.0
    assert fit.noise == pytest.approx(noise, rel=0.15)
    expected = degree * (fit.times(4) - 3.0) ** max(degree - 1, 0)
    error = np.abs(fit.derivative(1, 4) - expected)
    assert np.all(error < 4.0 * np.sqrt(fit.variance(1, 4)) + 1e-9)


def test_fast_motion_is_found_behind_a_slow_one():
    """The likelihood has two maxima; the lower one would take the fast motion for noise."""
    t = np.linspace(0.0, 1.0, 4000)
    y = np.sin(3.0 * t) + 0.01 * np.sin(400.0 * t)
    y += 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    fit = fit_spline(t, y, 0.0)
    assert fit.noise == pytest.approx(1e-4, rel=0.1)
    expected = 3.0 * np.cos(3.0 * fit.times(4)) + 4.0 * np.cos(400.0 * fit.times(4))
    np.testing.assert_allclose(fit.derivative(1, 4), expected, atol=0.4)


@pytest.mark.parametrize("count", [16, 31, 33, 64, 65, 1000])
def test_noise_is_found_whatever_the_count(count):
    t = np.linspace(0.0, 1.0, count)
    noise = [
        fit_spline(t, 1e-3 * np.random.default_rng(seed).standard_normal(count), 0.0).noise
        for seed in range(8)
    ]
    assert np.sqrt(np.mean(np.square(noise))) == pytest.approx(1e-3, rel=2.0 / sqrt(4 * count))


def test_noise_is_not_below_what_it_is_known_to_be():
    t = np.linspace(0.0, 1.0, 200)
    assert fit_spline(t, t**2, 1e-3).noise == pytest.approx(1e-3, rel=1e-12)
    assert fit_spline(t, np.full(200, 5.0), 1e-3).noise == pytest.approx(1e-3, rel=1e-12)
