"""The minimum-jerk move: published example, exact polynomial, optimality, errors."""

from fractions import Fraction
from math import factorial, inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from strategies import MAGNITUDES, UNIT_FACTORS

from jounce.shaping import min_jerk_move

SIGNS = st.sampled_from([-1.0, 1.0])
QUINTIC = [Fraction(c) for c in (0, 0, 0, 10, -15, 6)]


def exact_state(distance, duration, start, t):
    """Return position and derivatives 1…5 at time t, in rational arithmetic."""
    r, total, s = Fraction(distance), Fraction(duration), Fraction(t) / Fraction(duration)
    state = [
        r / total**k * sum(
            QUINTIC[j] * Fraction(factorial(j), factorial(j - k)) * s ** (j - k)
            for j in range(k, 6)
        )
        for k in range(6)
    ]  # fmt: skip
    return [float(Fraction(start) + state[0]), *map(float, state[1:])]


def test_the_published_example_at_20_deg_per_s():
    move = min_jerk_move(180.0, average_velocity=20.0)
    assert move.duration == 9.0
    assert move.peak("velocity") == pytest.approx(37.5, rel=1e-15)
    assert move(4.5) == pytest.approx(90.0, rel=1e-15)
    assert move(9.0) == 180.0


def test_the_published_example_at_26_7_deg_per_s_peaks_near_50():
    assert min_jerk_move(180.0, average_velocity=26.7).peak("velocity") == pytest.approx(
        50, abs=0.1
    )


@given(magnitude=MAGNITUDES, sign=SIGNS, pace=MAGNITUDES, unit=UNIT_FACTORS)
def test_peak_over_average_velocity_is_15_to_8(magnitude, sign, pace, unit):
    distance, average = sign * magnitude * unit, pace * unit
    move = min_jerk_move(distance, average_velocity=average)
    call = f"min_jerk_move({distance!r}, average_velocity={average!r})"
    assert abs(distance) / move.duration == pytest.approx(average, rel=1e-15), call
    assert move.peak("velocity") / average == pytest.approx(15 / 8, rel=1e-14), call


@given(magnitude=MAGNITUDES, sign=SIGNS, duration=MAGNITUDES, unit=UNIT_FACTORS)
def test_the_three_ways_to_ask_agree(magnitude, sign, duration, unit):
    distance = sign * magnitude * unit
    average = abs(distance) / duration
    moves = [
        min_jerk_move(distance, duration=duration),
        min_jerk_move(distance, average_velocity=average),
        min_jerk_move(distance, max_velocity=15 / 8 * average),
    ]
    for move in moves:
        assert move.duration == pytest.approx(duration, rel=1e-15), f"{distance!r}, {duration!r}"
        np.testing.assert_allclose(move.states, moves[0].states, rtol=1e-14)


@pytest.mark.parametrize(
    ("distance", "duration", "start"),
    [(1.0, 1.0, 0.0), (-2.5, 0.37, 4.0), (180.0, 9.0, -90.0), (1e-9, 1e6, 0.0), (-3e8, 2e-7, 1e3)],
)
def test_every_derivative_is_the_quintics_own(distance, duration, start):
    move = min_jerk_move(distance, duration=duration, start=start)
    assert move.order == 5
    peaks = np.array([abs(distance) / duration**k for k in range(6)])
    peaks *= [1.0, 1.875, 5.774, 60.0, 360.0, 720.0]
    peaks[0] += abs(start)
    for fraction in (0.0, 0.1, 0.25, 0.5, 0.7, 0.99):
        t = fraction * duration
        expected = exact_state(distance, duration, start, t)
        np.testing.assert_allclose(move.evaluate(t) / peaks, expected / peaks, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("derivative", "largest"), [(1, 1.875), (2, 10 / 3**0.5), (3, 60.0), (4, 360.0), (5, 720.0)]
)
def test_peaks_of_all_derivatives(derivative, largest):
    move = min_jerk_move(-3.0, duration=2.0)
    assert move.peak(derivative) == pytest.approx(largest * 3.0 / 2.0**derivative, rel=1e-14)


@given(magnitude=MAGNITUDES, sign=SIGNS, duration=MAGNITUDES, start=st.floats(-100, 100))
def test_it_rests_at_both_ends_which_are_both_included(magnitude, sign, duration, start):
    distance = sign * magnitude
    move = min_jerk_move(distance, duration=duration, start=start)
    call = f"min_jerk_move({distance!r}, duration={duration!r}, start={start!r})"
    assert (move.start_time, move.end_time) == (0.0, duration), call
    ends = move.evaluate([0.0, duration], 2)
    assert ends[0].tolist() == [start, start + distance], call
    assert (ends[1:] == 0.0).all(), call
    before_end = move.evaluate(np.nextafter(duration, 0.0), 2)
    scale = magnitude / duration ** np.arange(3.0)
    scale[0] += abs(start)
    assert (np.abs(before_end - [start + distance, 0, 0]) <= 1e-13 * scale).all(), call


def test_jerk_is_not_zero_at_the_ends():
    move = min_jerk_move(2.0, duration=4.0)
    assert move(0.0, "jerk") == 60.0 * 2.0 / 4.0**3
    assert move(np.nextafter(4.0, 0.0), "jerk") == pytest.approx(60.0 * 2.0 / 4.0**3, rel=1e-14)


def test_the_second_half_mirrors_the_first():
    move = min_jerk_move(2.0, duration=3.0, start=1.0)
    t = np.linspace(0.0, 3.0, 101)
    np.testing.assert_allclose(move(t) + move(3.0 - t), 4.0, rtol=1e-15)
    assert (np.diff(move(t)) > 0).all()


def test_a_negative_distance_mirrors_the_move():
    there, back = min_jerk_move(2.0, max_velocity=3.0), min_jerk_move(-2.0, max_velocity=3.0)
    np.testing.assert_array_equal(there.states, -back.states)
    assert there.duration == back.duration


@pytest.mark.parametrize("way", ["duration", "average_velocity", "max_velocity"])
@pytest.mark.parametrize("zero", [0.0, -0.0, 0])
def test_no_distance_takes_no_time(way, zero):
    move = min_jerk_move(zero, **{way: 2.0}, start=7.0)
    assert move.duration == 0.0
    assert move(0.0) == move(5.0) == 7.0
    assert move.peak("velocity") == 0.0


@given(
    seed=st.integers(0, 2**32 - 1), distance=st.sampled_from([-2.0, 1.0, 30.0]), duration=MAGNITUDES
)
def test_no_motion_with_the_same_ends_has_less_jerk(seed, distance, duration):
    """Any such motion adds s³(1 − s)³·p(s); the cross term vanishes, so the sum only grows."""
    move = min_jerk_move(distance, duration=duration)
    scaled = move.states[0] * duration ** np.arange(6.0) / distance
    jerk = Polynomial(scaled / [factorial(k) for k in range(6)]).deriv(3)
    p = Polynomial(np.random.default_rng(seed).normal(size=6))
    other = (Polynomial([0, 0, 0, 1]) * Polynomial([1, -1]) ** 3 * p).deriv(3)
    cost, extra, cross = (
        q.integ()(1.0) - q.integ()(0.0) for q in (jerk * jerk, other * other, jerk * other)
    )
    call = f"min_jerk_move({distance!r}, duration={duration!r}), seed {seed}"
    assert cost == pytest.approx(720.0, rel=1e-13), call
    assert abs(cross) <= 1e-11 * (cost * extra) ** 0.5, call
    total = (jerk + other) ** 2
    assert total.integ()(1.0) > cost, call


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_of_distance_and_time_change_nothing(unit):
    move = min_jerk_move(1.7, duration=2.3)
    other = min_jerk_move(1.7 * unit, duration=2.3 / unit)
    expected = move.states * unit ** (1.0 + np.arange(6.0))
    np.testing.assert_allclose(other.states, expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("given_values", "named"),
    [
        ({}, "none"),
        ({"duration": 1.0, "max_velocity": 2.0}, "duration, max_velocity"),
        ({"average_velocity": 1.0, "max_velocity": 2.0}, "average_velocity, max_velocity"),
        (
            {"duration": 1.0, "average_velocity": 1.0, "max_velocity": 2.0},
            "duration, average_velocity, max_velocity",
        ),
    ],
)
@pytest.mark.parametrize("distance", [1.0, 0.0])
def test_exactly_one_must_be_given(given_values, named, distance):
    with pytest.raises(ValueError, match=f"^got {named} of .*: give exactly one$"):
        min_jerk_move(distance, **given_values)


@pytest.mark.parametrize("way", ["duration", "average_velocity", "max_velocity"])
@pytest.mark.parametrize("value", [0.0, -1.0, nan, inf])
@pytest.mark.parametrize("distance", [1.0, 0.0])
def test_what_is_not_positive_is_refused(way, value, distance):
    with pytest.raises(ValueError, match=f"{way} = {value!r}: expected a positive"):
        min_jerk_move(distance, **{way: value})


@pytest.mark.parametrize("name", ["distance", "start"])
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_place_that_is_not_finite_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a finite"):
        min_jerk_move(**{"distance": 1.0, name: value}, duration=1.0)


@pytest.mark.parametrize(
    "values",
    [
        {"duration": 1e-80},
        {"duration": 1e-110},
        {"duration": 1e110},
        {"average_velocity": 1e-308},
        {"max_velocity": 1e200},
    ],
)
def test_a_duration_whose_powers_leave_the_range_of_a_double_is_a_value_error(values):
    with pytest.raises(ValueError, match=r"duration|finite|range"):
        min_jerk_move(10.0, **values)
