"""First-order lags: against a minimizer, of lags themselves, and a rate limiter's corner."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from jounce.analysis.frequency_view.describing_functions import (
    DescribingFunction,
    describing_function,
)
from jounce.analysis.frequency_view.nearest_lag import (
    first_order_lag,
    rate_limiter_corner_omega,
)
from jounce.shaping import Limits

LIMITER = Limits(velocity=1.0)
OMEGA = np.geomspace(0.01, 100.0, 201)


def test_a_lag_is_its_own_fit():
    corner = np.array([[0.2, 3.0], [1e4, 1e-3]])
    response = 1.0 / (1.0 + 1j * OMEGA / corner[..., None])
    sizes, omega = np.broadcast_arrays(np.ones((2, 2, 1)), OMEGA)
    lag = first_order_lag(DescribingFunction(sizes, omega, response))
    np.testing.assert_allclose(lag.corner_omega, corner, rtol=1e-12)
    assert lag.max_error.max() < 1e-12
    np.testing.assert_allclose(lag.response(OMEGA), response, rtol=1e-12)
    assert repr(lag) == "FirstOrderLag(amplitudes=4)"


@pytest.mark.parametrize("limits", [LIMITER, Limits(1.0, 2.0)], ids=["rate limiter", "follower"])
def test_no_other_lag_is_nearer(limits):
    swept = describing_function(
        limits, np.array([[0.3], [2.0]]), np.geomspace(0.1, 10.0, 20), samples_per_period=64
    )
    lag = first_order_lag(swept)
    for i in range(2):

        def off(log_corner, i=i):
            nearest = 1.0 / (1.0 + 1j * swept.omega[i] / np.exp(log_corner))
            return np.abs(swept.response[i] / nearest - 1.0)

        best = minimize_scalar(
            lambda x, off=off: (off(x) ** 2).mean(), bounds=(-7.0, 7.0), options={"xatol": 1e-10}
        )
        assert np.exp(best.x) == pytest.approx(lag.corner_omega[i], rel=1e-6)
        assert lag.rms_error[i] == pytest.approx(np.sqrt(best.fun), rel=1e-9)
        assert lag.max_error[i] == pytest.approx(off(best.x).max(), rel=1e-6)


def test_the_corner_of_a_rate_limiter_falls_with_the_amplitude():
    """As V/A exactly: ω·A/V is swept over the same values."""
    expected = describing_function(LIMITER, 1.0, OMEGA)
    fitted = first_order_lag(expected)
    assert 4.0 / np.pi < fitted.corner_omega < rate_limiter_corner_omega(LIMITER, 1.0)
    for size in (0.1, 7.0, 100.0):
        swept = describing_function(Limits(velocity=3.0), size, OMEGA * 3.0 / size)
        np.testing.assert_allclose(swept.response, expected.response, rtol=1e-12)
        lag = first_order_lag(swept)
        assert lag.corner_omega * size / 3.0 == pytest.approx(fitted.corner_omega, rel=1e-12)
        assert lag.rms_error == pytest.approx(fitted.rms_error, rel=1e-10)


def test_the_corner_of_a_follower_falls_with_the_amplitude():
    sizes = np.geomspace(0.2, 20.0, 5)[:, None]
    omega = np.geomspace(0.02, 2.0, 25)
    corner = first_order_lag(describing_function(Limits(1.0, 4.0), sizes, omega)).corner_omega
    assert (np.diff(corner) < 0.0).all()
    limited = first_order_lag(describing_function(LIMITER, sizes, omega)).corner_omega
    assert corner[-2:] == pytest.approx(limited[-2:], rel=0.1)  # large ones need no acceleration


def test_far_beyond_its_bound_a_rate_limiter_is_a_lag():
    """With the corner (4/π)·V/A; Thompson's V/R, R = A, is that less a fifth."""
    swept = describing_function(LIMITER, 1.0, np.geomspace(1e3, 1e5, 50))
    lag = first_order_lag(swept)
    assert lag.corner_omega == pytest.approx(4.0 / np.pi, rel=1e-5)
    assert lag.max_error < 1e-3
    assert 1.0 / lag.corner_omega == pytest.approx(0.785, abs=1e-3)


def test_what_does_not_lag_has_no_corner():
    lag = first_order_lag(describing_function(LIMITER, 1.0, [0.1, 0.5, 1.0]))
    assert lag.corner_omega == np.inf
    assert lag.max_error == 0.0
    np.testing.assert_array_equal(lag.response([1.0, 9.0]), 1.0)


@pytest.mark.parametrize(
    ("sizes", "omega"),
    [(1.0, 2.0), ([1.0, 2.0], [1.0, 2.0]), ([1.0, 2.0], [[3.0], [4.0]]), ([], [])],
    ids=["one point", "paired", "amplitudes last", "none"],
)
def test_what_is_not_swept_over_frequency_is_refused(sizes, omega):
    with pytest.raises(ValueError, match="frequencies along the last axis at constant amplitude"):
        first_order_lag(describing_function(LIMITER, sizes, omega))


# The corner of a rate limiter


def test_the_gain_at_the_corner_is_one_over_root_two():
    sizes = np.array([1e-9, 0.3, 1.0, 1e9])
    omega = rate_limiter_corner_omega(Limits(velocity=2.0), sizes)
    found = describing_function(Limits(velocity=2.0), sizes, omega)
    np.testing.assert_allclose(np.abs(found.response), np.sqrt(0.5), rtol=1e-14)
    np.testing.assert_allclose(omega * sizes / 2.0, 1.80054, rtol=1e-5)
    below = describing_function(Limits(velocity=2.0), sizes, omega * (1.0 - 1e-6))
    assert (np.abs(below.response) > np.sqrt(0.5)).all()


def test_only_a_rate_limiter_has_this_corner():
    with pytest.raises(ValueError, match="limits of velocity alone; fit a first_order_lag"):
        rate_limiter_corner_omega(Limits(1.0, 2.0), 1.0)
    with pytest.raises(ValueError, match="expected positive"):
        rate_limiter_corner_omega(LIMITER, 0.0)
