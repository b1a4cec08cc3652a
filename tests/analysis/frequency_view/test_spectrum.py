"""Laplace transform of the velocity: against 120 digits, closed forms and symmetries."""

import numpy as np
import pytest
from tiers import some
from transforms import random_move, transform_in_digits

from jounce.analysis.frequency_view.spectrum import spectrum_bound, velocity_spectrum
from jounce.shaping import (
    Limits,
    Trajectory,
    min_jerk_move,
    min_time_move,
    min_time_transfer,
    perfect_spline,
)

MODULI = [1e-6, 1.0, 29.0, 31.0, 700.0, 1e4]
ANGLES_DEG = [0.0, 90.0, 95.0, 120.0, 269.0]


@pytest.mark.parametrize("from_end", [False, True], ids=["from start", "from end"])
@pytest.mark.parametrize("order", some(range(1, 8), 3))
def test_moves_in_120_digits(order, from_end):
    move = random_move(order, 5)
    turns = np.outer(np.exp(1j * np.radians(ANGLES_DEG)), MODULI).ravel()
    growth = turns.real if from_end else -turns.real
    turns = turns[growth < 600.0]
    largest = np.exp(np.maximum(growth[growth < 600.0], 0.0))
    s = turns / move.duration
    found = velocity_spectrum(move, s, from_end=from_end)
    expected = np.array([transform_in_digits(120, move, z, from_end) for z in s])
    error = np.abs(found - expected) / (abs(move.end_state[0] - move.start_state[0]) * largest)
    assert error.max() < 1e-13, (move, turns[error.argmax()])


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_zero_is_the_distance_and_units_do_not_matter(unit):
    move = min_time_move(3.0, Limits(1.0, 2.0, 8.0))
    slower = move.stretch(unit).scale(1.0 / unit)
    assert velocity_spectrum(move, 0.0) == pytest.approx(3.0, rel=1e-14)
    s = np.array([1e-8, 0.3 + 2j, -0.3 + 2j, 90.0, -90.0 + 10j])
    found = velocity_spectrum(slower, s / unit, from_end=True) * unit
    expected = velocity_spectrum(move, s, from_end=True)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    "motion",
    [
        min_jerk_move(2.0, duration=3.0),
        min_time_transfer((0.0, 1.0), (3.0, -0.5), Limits(2.0, 1.0)),
        Trajectory([0.0, 1.0], [[0.0, 1.0, 0.0]]),
    ],
    ids=["minimum jerk", "moving ends", "coasting"],
)
def test_any_motion(motion):
    s = np.array([0.01, 2j, -1.0 + 3j, 1.0 - 30j, 200.0])
    expected = np.array([transform_in_digits(120, motion, z, False) for z in s])
    np.testing.assert_allclose(velocity_spectrum(motion, s), expected, rtol=1e-12, atol=1e-13)


def test_backwards_is_seen_from_the_end():
    """x(T − t) has the velocity −v(T − t): what decays seen from one end grows from the other."""
    move = min_time_move(1.0, Limits(velocity=(-1.0, 2.0), acceleration=(-1.0, 3.0)))
    s = np.array([0.1 + 1j, -0.1 + 5j, -3.0, 40j])
    seen = velocity_spectrum(move, s, from_end=True)
    np.testing.assert_allclose(-velocity_spectrum(move.reverse(), -s), seen, rtol=0, atol=1e-14)
    with_decay = np.exp(s * move.duration) * velocity_spectrum(move, s)
    np.testing.assert_allclose(with_decay, seen, rtol=0, atol=1e-14)


def test_what_decays_never_overflows_and_what_grows_says_so():
    move = perfect_spline(1.0, 6, 1.0)
    s = np.array([-1e3, -1e6, -1e3 + 5e3j]) / move.duration
    assert np.abs(velocity_spectrum(move, s, from_end=True)).max() < 1e-12
    assert not np.isfinite(velocity_spectrum(move, s)).any()


def test_shapes_and_many_frequencies():
    move = min_time_move(1.0, Limits(jerk=3.0))
    s = 1j * np.linspace(0.0, 300.0, 10_000).reshape(100, 100)
    found = velocity_spectrum(move, s)
    assert found.shape == s.shape
    assert found[57, 3] == pytest.approx(complex(velocity_spectrum(move, s[57, 3])), rel=1e-9)
    assert velocity_spectrum(move, 1.0).shape == ()
    assert velocity_spectrum(min_time_move(0.0, Limits(1.0)), s).any() == np.False_


@pytest.mark.parametrize("name", ["minimum jerk", 1, 2, 4, 6])
def test_the_bound_is_kept_and_nearly_met(name):
    move = min_jerk_move(2.0, duration=3.0) if name == "minimum jerk" else random_move(name, 5)
    for turns in (1e-3, 1.0, 30.0, 1e3, 1e6):
        omega = np.linspace(turns, turns + 200.0, 2000) / move.duration
        found = np.abs(velocity_spectrum(move, 1j * omega))
        bound = spectrum_bound(move, omega)
        assert (found <= bound * (1.0 + 1e-12) + 1e-15).all(), turns
        assert found.max() > 0.02 * bound[found.argmax()], turns
    assert spectrum_bound(move, 0.0) == pytest.approx(abs(np.ptp(move(move.breaks))), rel=1e-12)
