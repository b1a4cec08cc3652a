"""Cascaded lags: Thompson's corners, the delay of the move, and honest errors."""

from math import inf, nan, pi

import control
import numpy as np
import pytest
from tiers import some

from jounce.analysis.frequency_view import cascaded_lags, corner_omega, frequency_response
from jounce.shaping import Limits, min_jerk_move, min_time_move, min_time_transfer, perfect_spline

MOVES = {
    "velocity limit": min_time_move(3.0, Limits(velocity=2.0)),
    "trapezoid": min_time_move(-3.0, Limits(velocity=2.0, acceleration=4.0)),
    "S-curve": min_time_move(5.3, Limits(velocity=2.0, acceleration=4.1, jerk=23.0)),
    "spline of order 3": perfect_spline(1.0, 3, 7.0),
    "spline of order 6": perfect_spline(1.0, 6, 7.0),
    "minimum jerk": min_jerk_move(1.0, duration=2.0),
}


@pytest.fixture(params=MOVES)
def move(request):
    return MOVES[request.param]


def test_the_rate_limiter_has_thompsons_corner_which_falls_with_the_step():
    for step in (0.1, 1.0, 10.0):
        [lag] = cascaded_lags(
            min_time_move(step, Limits(velocity=2.0)), 1.0, match="rates"
        ).lags.tolist()
        assert 1.0 / lag == pytest.approx(2.0 / step, rel=1e-12)


def test_rates_are_the_widths_of_the_boxcars():
    lags = cascaded_lags(MOVES["S-curve"], 1.0, match="rates").lags
    assert lags == pytest.approx([5.3 / 2.0, 2.0 / 4.1, 4.1 / 23.0], rel=1e-12)
    assert lags.sum() == pytest.approx(MOVES["S-curve"].duration, rel=1e-12)


def test_slow_signals_are_delayed_by_half_the_duration(move):
    lags = cascaded_lags(move, 1.0).lags
    assert lags.sum() == pytest.approx(0.5 * move.duration, rel=1e-12)
    slow = cascaded_lags(move, 1e-3 / move.duration)
    for response in (slow.approximation, slow.exact):
        delay = -np.angle(response.response[0]) / response.omega[0]
        assert delay == pytest.approx(0.5 * move.duration, rel=1e-6)


@pytest.mark.parametrize("match", ["delay", "rates"])
def test_the_response_is_that_of_lags_in_series(move, match):
    omega = np.geomspace(0.01, 100.0, 40)
    result = cascaded_lags(move, omega, match=match)
    series = np.prod([control.tf([1], [lag, 1])(1j * omega) for lag in result.lags], axis=0)
    np.testing.assert_allclose(result.approximation.response, series, rtol=1e-12)
    exact = frequency_response(move, omega).response
    np.testing.assert_array_equal(result.exact.response, exact)
    expected = 20.0 * np.log10(np.abs(series) / np.abs(exact))
    np.testing.assert_allclose(result.error_db, expected, rtol=0, atol=1e-9)
    assert result.largest_error_db == pytest.approx(np.abs(expected).max(), abs=1e-9)


@pytest.mark.parametrize("name", some(["velocity limit", "trapezoid", "S-curve"], 2))
@pytest.mark.parametrize(("match", "below_db"), [("delay", 0.0), ("rates", 6.0206)])
def test_lobes_touch_the_lags_far_beyond_the_corner(name, match, below_db):
    move = MOVES[name]
    omega = np.linspace(1e4, 1.1e4, 50_001) / move.duration
    result = cascaded_lags(move, omega, match=match)
    jumps = np.abs(np.diff(move.states[:, -1], prepend=0.0, append=0.0)).sum()
    envelope_db = 20.0 * np.log10(jumps / omega**move.order / abs(np.ptp(move(move.breaks))))
    lobes = result.exact.gain_db - envelope_db
    assert lobes.max() < 1e-3
    assert lobes.max() > -0.5
    over = result.approximation.gain_db - envelope_db
    assert over == pytest.approx(np.full(over.shape, -below_db * len(result.lags)), abs=1e-2)


def test_errors_up_to_the_corner():
    """Those printed in the docstring."""
    printed = {
        ("velocity limit", "delay"): -1.7,
        ("velocity limit", "rates"): -6.4,
        ("spline of order 3", "delay"): -3.2,
        ("spline of order 3", "rates"): -12.4,
        ("spline of order 6", "delay"): -3.9,
        ("spline of order 6", "rates"): -15.4,
    }
    for (name, match), expected in printed.items():
        result = cascaded_lags(MOVES[name], 1.0, match=match)
        assert result.error_to_corner_db == pytest.approx(expected, abs=0.06), name
        assert result.corner_omega == corner_omega(MOVES[name])
        up_to_corner = cascaded_lags(
            MOVES[name], np.linspace(1e-6, 1.0, 3000) * result.corner_omega, match=match
        )
        largest = up_to_corner.largest_error_db
        assert abs(result.error_to_corner_db) == pytest.approx(largest, rel=1e-3)


def test_at_a_null_the_error_is_infinite_or_nearly():
    result = cascaded_lags(MOVES["velocity limit"], 2.0 * pi / 1.5)
    assert result.largest_error_db > 250.0


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_units_do_not_matter(unit):
    move = MOVES["S-curve"]
    other = cascaded_lags(move.scale(unit).stretch(unit), 1.0 / unit)
    assert other.lags / unit == pytest.approx(cascaded_lags(move, 1.0).lags, rel=1e-9)


def test_wrong_arguments_are_refused():
    with pytest.raises(ValueError, match="match = 'phase': expected 'delay' or 'rates'"):
        cascaded_lags(MOVES["S-curve"], 1.0, match="phase")
    for omega in (nan, inf):
        with pytest.raises(ValueError, match="omega must be finite"):
            cascaded_lags(MOVES["S-curve"], omega)
    with pytest.raises(ValueError, match="from rest to rest"):
        cascaded_lags(min_time_transfer((0.0, 1.0), 3.0, Limits(2.0, 1.0)), 1.0)
