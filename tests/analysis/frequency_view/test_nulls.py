"""Nulls of moves: closed forms, double ones, and how they move with the distance."""

from math import nan

import mpmath
import numpy as np
import pytest
from tiers import some

from jounce.analysis.frequency_view import (
    frequency_response,
    null_by_size,
    null_omegas,
    null_rise_time,
    residual_vibration,
)
from jounce.shaping import (
    Limits,
    bound_for_rise_time,
    min_jerk_move,
    min_time_move,
    perfect_spline,
)


def nulls_hz(move, highest_hz):
    return null_omegas(move, 2.0 * np.pi * highest_hz) / (2.0 * np.pi)


def multiples(widths, highest_hz):
    """Return the nulls of boxcars in series, each of them once."""
    every = [np.arange(1, int(highest_hz * w * (1.0 + 1e-12)) + 1) / w for w in widths]
    found = np.sort(np.concatenate(every))
    return found[np.append(True, np.diff(found) > 1e-9)]


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize(
    ("limits", "widths"),
    [
        ([1.5], [2.0]),
        ([1.5, 3.0], [2.0, 0.5]),
        ([1.5, 3.1], [2.0, 1.5 / 3.1]),
        ([1.5, 3.0, 10.0], [2.0, 0.5, 0.3]),
        ([1.5, 0.75], [2.0, 2.0]),
    ],
    ids=["velocity", "acceleration", "incommensurable", "jerk", "triangle"],
)
def test_boxcars_have_nulls_at_multiples(limits, widths, unit):
    bounds = [bound / unit**k for k, bound in enumerate(limits, start=1)]
    move = min_time_move(3.0, Limits.from_bounds(bounds), method="closed-form")
    found = nulls_hz(move, 8.1 / unit) * unit
    np.testing.assert_allclose(found, multiples(widths, 8.1), rtol=1e-10)


@pytest.mark.parametrize("order", some(range(1, 7), 4))
def test_nulls_are_zeros_and_none_is_missed(order):
    """Between nulls the real response has one sign, by samples far denser than the search."""
    limits = Limits.from_bounds([1.0, 3.7, 31.0, 400.0, 9e3, 3e5][:order])
    move = min_time_move(1.03, limits)
    nulls = null_omegas(move, 60.0 / move.duration)
    omega = np.linspace(0.0, 60.0 / move.duration, 6000)
    g = frequency_response(move, omega).response * np.exp(0.5j * omega * move.duration)
    assert np.abs(frequency_response(move, nulls).response).max() < 1e-14
    signs = np.sign(g.real) * (-1.0) ** np.searchsorted(nulls, omega)
    clear = np.abs(g.real) > 1e-13
    assert np.abs(g.imag).max() < 1e-13
    assert (signs[clear] == 1.0).all(), omega[clear][signs[clear] < 0.0][:3]


def test_the_ends_of_the_range_count():
    move = min_time_move(2.0, Limits(velocity=1.0))
    assert nulls_hz(move, 1.0) == pytest.approx([0.5, 1.0], rel=1e-14)
    assert nulls_hz(move, 1.0 - 1e-6) == pytest.approx([0.5], rel=1e-14)
    triangle = min_time_move(1.0, Limits(acceleration=1.0))
    assert nulls_hz(triangle, 2.0) == pytest.approx([1.0, 2.0], rel=1e-12)


def test_two_nulls_nearly_one():
    """Boxcars of 1 and 1 + 1e-4, whose nulls are a ten-thousandth apart."""
    widths = [1.0001, 1.0]
    move = min_time_move(1.0001, Limits(velocity=1.0, acceleration=1.0))
    assert nulls_hz(move, 3.5) == pytest.approx(multiples(widths, 3.5), rel=1e-9)


def test_a_move_that_is_not_symmetric_has_none():
    move = min_time_move(1.0, Limits(velocity=1.0, acceleration=(-1.0, 3.0)))
    assert null_omegas(move, 50.0).size == 0
    assert np.isnan(null_by_size(Limits(1.0, (-1.0, 3.0)), [1.0], 2.0).null_hz).all()


def test_minimum_jerk_is_symmetric_and_has_nulls():
    """Velocity ∝ t²(T − t)²: the spherical Bessel function j₂, zero where tan z = 3z/(3 − z²)."""
    move = min_jerk_move(1.0, duration=2.0)
    z = null_omegas(move, 10.0)  # T/2 = 1
    np.testing.assert_allclose(z, [5.763459196894550, 9.095011330476355], rtol=1e-12)


@pytest.mark.parametrize("highest", [0.0, -1.0, nan, 1e9])
def test_wrong_highest_frequencies_are_refused(highest):
    with pytest.raises(ValueError, match=r"^highest = |lower highest frequency"):
        null_omegas(perfect_spline(1.0, 3, 1.0), highest)


# Over the distance


def test_what_stays_and_what_moves():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=10.0)
    a_ramp, v_ramp = 2.0 / 10.0, 1.0 / 2.0
    distances = [0.001, 0.3, 0.61, 5.03, -5.03]
    jerk_ramp = null_by_size(limits, distances, 1.0 / a_ramp)
    np.testing.assert_array_equal(jerk_ramp.stays, [False, True, True, True, True])
    assert jerk_ramp.null_hz[1:] == pytest.approx(np.full(4, 5.0), rel=1e-12)
    # nothing but the jerk is bounded: 2/T, T = (32 R/W)^(1/3)
    assert jerk_ramp.null_hz[0] == pytest.approx(2.0 / (32.0 * 0.001 / 10.0) ** (1.0 / 3.0))
    assert jerk_ramp.exponent[0] == pytest.approx(-1.0 / 3.0, rel=1e-6)
    assert jerk_ramp.durations[-1] == jerk_ramp.durations[-2]
    velocity_ramp = null_by_size(limits, [0.71, 5.03], 1.0 / v_ramp)
    assert velocity_ramp.null_hz == pytest.approx([2.0, 2.0], rel=1e-12)
    assert velocity_ramp.stays.all()
    whole = null_by_size(limits, [0.71, 0.9, 3.0], 0.2)
    assert whole.null_hz == pytest.approx([1.0 / 0.71, 1.0 / 0.9, 1.0 / 3.0], rel=1e-12)
    assert whole.exponent == pytest.approx([-1.0, -1.0, -1.0], rel=1e-6)
    assert repr(whole) == "NullBySize(distances=3, frequency_hz=0.2, staying=0)"


@pytest.mark.parametrize("order", some(range(1, 7), 3))
def test_nulls_of_a_single_bound_move_as_the_duration(order):
    limits = Limits.from_bounds([*[None] * (order - 1), 5.0])
    found = null_by_size(limits, [0.1, 1.0, 10.0], 0.01)
    assert found.exponent == pytest.approx(np.full(3, -1.0 / order), rel=1e-5)
    assert found.null_hz * found.durations == pytest.approx(
        np.full(3, found.null_hz[0] * found.durations[0]), rel=1e-10
    )


@pytest.mark.parametrize(
    ("distances", "frequency_hz", "message"),
    [
        ([1.0, 0.0], 1.0, "none that is zero"),
        ([], 1.0, "expected one row, not empty"),
        ([[1.0]], 1.0, "expected one row"),
        ([1.0], 0.0, "frequency_hz = 0.0: expected a positive"),
    ],
)
def test_wrong_sizes_are_refused(distances, frequency_hz, message):
    with pytest.raises(ValueError, match=message):
        null_by_size(Limits(1.0), distances, frequency_hz)


# By rise time


@pytest.mark.parametrize("order", [*range(3, 12), 25, 40])
def test_the_first_null_of_a_ramp_in_40_digits(order):
    """A perfect spline switches at T·sin²(kπ/2m): its spectrum is a sum of m + 1 turns."""
    m, cycles = order - 2, null_rise_time(1.0, order)
    with mpmath.workdps(40):
        switches = [mpmath.cos(k * mpmath.pi / m) for k in range(m + 1)]
        signs = [(-1) ** k * (0.5 if k in (0, m) else 1.0) for k in range(m + 1)]

        def spectrum(x):
            terms = zip(signs, switches, strict=True)
            turns = mpmath.fsum(s * mpmath.expj(mpmath.pi * x * c) for s, c in terms)
            return mpmath.re(turns / mpmath.mpc(0, 1) ** m)

        assert abs(spectrum(cycles)) < 1e-12 * m
        earlier = [spectrum(cycles * i / 50) for i in range(25, 50)]
        assert all(value * earlier[0] > 0 for value in earlier)
    if order <= 12:
        spline = perfect_spline(1.0, m, 1.0)
        found = nulls_hz(spline, (cycles + 0.1) / spline.duration) * spline.duration
        assert found == pytest.approx([cycles], rel=1e-12)


@pytest.mark.parametrize("order", [3, 4, 5, 6])
def test_a_mode_on_the_first_null_of_the_ramp_is_never_rung(order):
    acceleration, velocity, mode_hz = 2.0, 3.0, 3.0
    rise_time = null_rise_time(mode_hz, order)
    bounds = [None] * order
    bounds[:2] = velocity, acceleration
    bounds[order - 1] = bound_for_rise_time(acceleration, rise_time, order)
    limits = Limits.from_bounds(bounds)
    for distance in (20.0, 21.3, 50.0):
        assert (
            residual_vibration(min_time_move(distance, limits, method="closed-form"), mode_hz)
            < 1e-12
        )


def test_a_rise_time_scales_and_refuses():
    assert null_rise_time(1e-9, 6) == pytest.approx(1e18 * null_rise_time(1e9, 6), rel=1e-14)
    with pytest.raises(ValueError, match="frequency_hz = 0"):
        null_rise_time(0, 6)
    with pytest.raises(ValueError, match="order = 2: expected a whole number from 3 to 40"):
        null_rise_time(1.0, 2)
