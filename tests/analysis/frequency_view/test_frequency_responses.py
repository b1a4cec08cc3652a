"""Frequency response of shapers: against 60 digits, closed forms, and the FFT of samples."""

from math import inf, nan

import numpy as np
import pytest
from tiers import some
from transforms import random_move, transform_in_digits

from jounce.analysis import (
    corner_omega,
    fft_frequency_response,
    frequency_response,
    rollover_db_per_decade,
)
from jounce.shaping import (
    JerkFilter,
    Limits,
    Trajectory,
    min_jerk_move,
    min_time_move,
    min_time_transfer,
    perfect_spline,
)


def in_60_digits(move, omega):
    """Return H(jω): the transform of the velocity over the distance."""
    return transform_in_digits(60, move, 1j * omega) / (move.end_state[0] - move.start_state[0])


@pytest.mark.parametrize("seed", some(range(4), 2))
@pytest.mark.parametrize("order", some(range(1, 8), 4))
def test_moves_in_60_digits(order, seed):
    move = random_move(order, seed)
    turns = np.array([1e-3, 0.1, 1.0, 3.0, 10.0, 30.0, 31.0, 100.0, 1e3, 1e5])
    omega = turns / move.duration
    found = frequency_response(move, omega).response
    expected = np.array([in_60_digits(move, w) for w in omega])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13, err_msg=repr(move))


@pytest.mark.parametrize("order", range(1, 8))
def test_zero_frequency_is_one_and_negative_ones_are_conjugate(order):
    move = random_move(order, 9)
    omega = np.array([0.0, 1e-9, 2.0, 50.0])
    response = frequency_response(move, omega).response
    assert response[0] == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_array_equal(frequency_response(move, -omega).response, response.conj())


def test_a_rate_limited_move_is_a_boxcar():
    omega = np.linspace(0.1, 40.0, 500)
    found = frequency_response(min_time_move(3.0, Limits(velocity=1.5)), omega).response
    expected = np.sinc(omega / np.pi) * np.exp(-1j * omega)  # over 2 time units
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


def test_an_acceleration_limited_move_is_a_boxcar_squared():
    omega = np.linspace(0.1, 40.0, 500)
    found = frequency_response(min_time_move(4.0, Limits(acceleration=1.0)), omega).response
    expected = (np.sinc(omega / np.pi) * np.exp(-1j * omega)) ** 2
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


def test_a_delay_and_a_shift_change_nothing():
    move = random_move(3, 1)
    omega = np.geomspace(0.1, 1e4, 30)
    expected = frequency_response(move, omega).response
    for other in (move.delay(7.0), move.mirror(), move.scale(3.0)):
        found = frequency_response(other, omega).response
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("order", [2, 3, 4, 6])
def test_perfect_splines_roll_off_with_their_order(order):
    move = perfect_spline(1.0, order, 1.0)
    levels = []
    for first in (1e3, 1e4):
        omega = np.linspace(first, 1.5 * first, 20_001) / move.duration
        response = frequency_response(move, omega).response
        levels.append(np.sqrt(np.mean(np.abs(response * omega**order) ** 2)))
    assert levels[1] == pytest.approx(levels[0], rel=0.02)


def test_filters_and_products():
    jerk_filter, move = JerkFilter(2.0, 6), random_move(2, 3)
    omega = np.geomspace(0.01, 1e3, 40)
    alone = frequency_response(jerk_filter, omega).response
    np.testing.assert_allclose(alone, (1.0 + 1j * omega / (4.0 * np.pi)) ** -6.0, rtol=1e-13)
    both = frequency_response(move, omega, jerk_filter=jerk_filter).response
    np.testing.assert_allclose(both, alone * frequency_response(move, omega).response, rtol=1e-13)


@pytest.mark.parametrize("name", ["order 2", "order 5", "minimum jerk"])
def test_the_fft_agrees_as_far_as_it_can_be_trusted(name):
    moves = {"order 2": random_move(2, 0), "order 5": random_move(5, 0)}
    move = moves.get(name) or min_jerk_move(2.0, duration=3.0)
    sampled = fft_frequency_response(move, move.duration / 5000.0, padding=4)
    known = sampled.omega <= sampled.trusted_omega
    exact = frequency_response(move, sampled.omega).response
    np.testing.assert_allclose(sampled.response[known], exact[known], rtol=0, atol=1e-4)
    assert sampled.omega[0] == 0.0
    assert sampled.omega[-1] == pytest.approx(np.pi * 5000.0 / move.duration, rel=1e-3)


@pytest.mark.parametrize("share", [1e-3, 0.03, 0.08, 0.15, 0.3, 0.9, 2.0])
@pytest.mark.parametrize("name", ["ramp", "order 2", "order 3", "order 6"])
def test_the_fft_errs_by_no_more_than_it_promises(name, share):
    moves = {
        "ramp": min_time_move(1.0, Limits(velocity=1.0)),
        "order 2": random_move(2, 1),
        "order 3": min_time_move(5.0, Limits(velocity=2.0, acceleration=3.0, jerk=20.0)),
        "order 6": random_move(6, 2),
    }
    move = moves[name]
    sampled = fft_frequency_response(move, share * move.duration)
    error = abs(sampled.response - frequency_response(move, sampled.omega).response)
    known = sampled.omega <= sampled.trusted_omega
    trusted = sampled.trusted_omega
    assert trusted == 0.0 or error[known].max() <= 0.01, f"{name}, dt = {share} T"
    if share == 1e-3 and name != "ramp":
        assert trusted == pytest.approx(0.1 * np.pi / (share * move.duration))


@pytest.mark.parametrize("dt", [1e-9, 1e-300])
def test_more_samples_than_memory_holds_are_refused(dt):
    with pytest.raises(ValueError, match=r"more than 1e\+08 points in a move of"):
        fft_frequency_response(random_move(2, 0), dt)


def test_a_single_frequency_and_gains():
    result = frequency_response(min_time_move(2.0, Limits(velocity=1.0)), 0.0)
    assert result.response.shape == result.omega.shape == (1,)
    assert result.gain_db == pytest.approx([0.0], abs=1e-12)
    assert result.trusted_omega == inf


@pytest.mark.parametrize("omega", [nan, inf, [1.0, nan]])
def test_frequencies_that_are_not_finite_are_refused(omega):
    with pytest.raises(ValueError, match="omega must be finite"):
        frequency_response(JerkFilter(1.0, 2), omega)


@pytest.mark.parametrize(
    "motion",
    [
        min_time_transfer((0.0, 1.0), 3.0, Limits(2.0, 1.0)),
        min_time_transfer(0.0, (3.0, 1.0), Limits(2.0, 1.0)),
        min_time_move(0.0, Limits(acceleration=1.0)),
        Trajectory([0.0, 1.0], [[0.0, 1.0, 0.0]]),
    ],
    ids=["moving start", "moving end", "nowhere", "coasting"],
)
def test_what_is_no_move_from_rest_to_rest_is_refused(motion):
    for response in (
        lambda: frequency_response(motion, 1.0),
        lambda: fft_frequency_response(motion, 0.1),
    ):
        with pytest.raises(ValueError, match="expected a move from rest to rest"):
            response()


@pytest.mark.parametrize(("dt", "padding"), [(0.0, 2), (nan, 2), (0.1, 0), (0.1, 1001), (0.1, 1.5)])
def test_wrong_sampling_is_refused(dt, padding):
    with pytest.raises(ValueError, match=r"^(dt|padding) = "):
        fft_frequency_response(random_move(2, 0), dt, padding)


# Figures of a response


@pytest.mark.parametrize("order", [1, 2, 6, 20])
def test_the_corner_of_a_filter(order):
    expected = 2.0 * np.pi * 3.0 * np.sqrt(2.0 ** (1.0 / order) - 1.0)
    assert corner_omega(JerkFilter(3.0, order)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_the_corner_of_a_boxcar(unit):
    """Half the power at sin(x)/x = 1/√2, x = ωT/2 = 1.39155737825."""
    move = min_time_move(2.0, Limits(velocity=1.0 / unit))
    assert corner_omega(move) * unit == pytest.approx(1.391557378251510, rel=1e-12)


def test_the_corner_behind_a_filter_is_lower_than_either():
    move, jerk_filter = random_move(3, 2), JerkFilter(1.0, 6)
    both = corner_omega(move, jerk_filter=jerk_filter)
    assert both < min(corner_omega(move), corner_omega(jerk_filter))
    [response] = frequency_response(move, both, jerk_filter=jerk_filter).response
    assert abs(response) ** 2 == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("order", range(1, 7))
def test_the_rollover_is_that_of_the_lowest_jump(order):
    move = perfect_spline(1.0, order, 1.0)
    assert rollover_db_per_decade(move) == 20.0 * order
    assert rollover_db_per_decade(move, jerk_filter=JerkFilter(1.0, 6)) == 20.0 * (order + 6)
    assert rollover_db_per_decade(JerkFilter(1.0, order)) == 20.0 * order


def test_the_rollover_of_a_minimum_jerk_move_is_that_of_its_jerk():
    assert rollover_db_per_decade(min_jerk_move(1.0, duration=1.0)) == 60.0
