"""Residual vibration: against exact simulations of the mode, and as a map."""

from math import inf, nan, pi, sqrt

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jounce.analysis.frequency_view import frequency_response
from jounce.analysis.frequency_view.vibration import residual_vibration, vibration_map
from jounce.plant import respond
from jounce.shaping import JerkFilter, Limits, min_jerk_move, min_time_move, min_time_transfer

DAMPINGS = [0.0, 0.01, 0.2, 0.7, 0.99]
BOUNDS = [1.0, 4.0, 30.0, 400.0, 9e3, 3e5]


def move_of(order, distance=1.7):
    return min_time_move(
        distance, Limits.from_bounds(BOUNDS[:order]), start=0.4, method="closed-form"
    )


def amplitude(deflection, rate, frequency_hz, damping):
    """Return A of A·e^(−ζωt)·cos(ω_d·t + φ) from its value and rate at t = 0."""
    omega = 2.0 * pi * frequency_hz
    damped = omega * sqrt(1.0 - damping**2)
    return np.hypot(deflection, (rate + damping * omega * deflection) / damped)


def base_excited(frequency_hz, damping):
    """Return q'' = −2ζω(q' − x') − ω²(q − x) with the inputs x, x' and the states q, q'."""
    omega = 2.0 * pi * frequency_hz
    c, k = 2.0 * damping * omega, omega**2
    return control.ss([[0, 1], [-k, -c]], [[0, 0], [k, c]], np.eye(2), np.zeros((2, 2)))


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("order", range(1, 7))
def test_what_a_simulation_is_left_with(order, damping):
    move = move_of(order)
    for frequency_hz in (0.05, 0.4, 1.0, 3.7, 11.0):
        found = residual_vibration(move, frequency_hz, damping)
        mode = base_excited(frequency_hz, damping)
        start = [move.start_state[0], 0.0]
        response = respond(
            mode, move, move.duration, derivatives=(0, 1), duration=move.duration,
            initial_state=start,
        )  # fmt: skip
        q, rate = response.states[:, -1]
        expected = amplitude(q - move.end_state[0], rate, frequency_hz, damping)
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-11), (frequency_hz, found)


def test_an_integrator_step_by_step():
    """The equation of the deflection itself, by another method than the exact response."""
    move, frequency_hz, damping = move_of(3), 1.3, 0.05
    omega = 2.0 * pi * frequency_hz

    def slope(t, state):
        rate = -2.0 * damping * omega * state[1] - omega**2 * state[0] - move(t, "acceleration")
        return [state[1], rate]

    state = [0.0, 0.0]
    for left, right in zip(move.breaks[:-1], move.breaks[1:], strict=True):
        done = solve_ivp(slope, (left, right), state, rtol=1e-11, atol=1e-13)
        state = done.y[:, -1]
    expected = amplitude(*state, frequency_hz, damping)
    assert residual_vibration(move, frequency_hz, damping) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("damping", [0.0, 0.03, 0.3])
def test_a_filter_behind(damping):
    """The mode's own part, long after the filter has settled, extrapolated back to the end."""
    move, jerk_filter, frequency_hz = move_of(2), JerkFilter(6.0, 3), 0.8
    a, b = jerk_filter.state_space()
    omega = 2.0 * pi * frequency_hz
    rows = np.zeros((5, 5))
    rows[:3, :3], rows[3, 4] = a, 1.0
    rows[4] = [0.0, 0.0, 0.0, -(omega**2), -2.0 * damping * omega]
    # the mode is driven by the acceleration that comes out of the filter
    rows[4, 2] -= 1.0
    system = control.ss(rows, np.vstack([b, [[0.0], [0.0]]]), np.eye(5), np.zeros((5, 1)))
    later = 2.0
    response = respond(
        system, move, move.duration + later, derivatives=(2,), duration=move.duration + later
    )
    expected = amplitude(*response.states[3:, -1], frequency_hz, damping)
    expected *= np.exp(damping * omega * later)
    found = residual_vibration(move, frequency_hz, damping, jerk_filter=jerk_filter)
    assert found == pytest.approx(expected, rel=1e-9)


def test_without_damping_it_is_the_gain():
    frequencies = np.geomspace(0.01, 300.0, 60)
    for order in range(1, 7):
        move = move_of(order, -1.7)
        gain = np.abs(frequency_response(move, 2.0 * pi * frequencies).response)
        found = residual_vibration(move, frequencies)
        np.testing.assert_allclose(found, 1.7 * gain, rtol=1e-12, atol=1e-15)


def test_a_slow_mode_is_left_behind_and_a_damped_one_forgets():
    move = min_jerk_move(2.0, duration=1.0)
    assert residual_vibration(move, 1e-9) == pytest.approx(2.0, rel=1e-12)
    assert residual_vibration(move, 1e5, 0.9) < 1e-12
    assert residual_vibration(move, 1e300, 0.5) == 0.0


@pytest.mark.parametrize("unit", [1e-9, 1e9])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_units_do_not_matter(unit, damping):
    move, frequencies = move_of(4), np.array([0.1, 1.0, 7.0])
    expected = residual_vibration(move, frequencies, damping)
    other = move.scale(unit).stretch(unit**2).delay(3.0 * unit**2)
    found = residual_vibration(other, frequencies / unit**2, damping)
    np.testing.assert_allclose(found / unit, expected, rtol=1e-9, atol=1e-13)


def test_arrays_are_broadcast_and_a_number_stays_one():
    move = move_of(3)
    frequencies, dampings = np.array([1.0, 2.0, 3.0]), np.array([[0.0], [0.1]])
    found = residual_vibration(move, frequencies, dampings)
    assert found.shape == (2, 3)
    assert found[1, 2] == pytest.approx(residual_vibration(move, 3.0, 0.1), rel=1e-12)
    assert isinstance(residual_vibration(move, 3.0), float)


def test_there_and_back_is_a_move_too():
    there = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))
    back = there.then(min_time_move(-1.0, Limits(velocity=1.0, acceleration=2.0)))
    one = residual_vibration(there, 0.31)
    turned = abs(1.0 - np.exp(2j * pi * 0.31 * there.duration))
    assert residual_vibration(back, 0.31) == pytest.approx(turned * one, rel=1e-12)


@pytest.mark.parametrize(
    ("frequency_hz", "damping", "message"),
    [
        (0.0, 0.0, "frequency_hz: expected positive"),
        ([1.0, -2.0], 0.0, "frequency_hz: expected positive frequencies, got -2.0"),
        (nan, 0.0, "frequency_hz must be finite"),
        (inf, 0.0, "frequency_hz must be finite"),
        (1.0, -0.1, "damping = -0.1: expected"),
        (1.0, [0.5, 1.0], "damping = 1.0: expected"),
        (1.0, nan, "damping must be finite"),
    ],
)
def test_what_is_no_mode_is_refused(frequency_hz, damping, message):
    with pytest.raises(ValueError, match=message):
        residual_vibration(move_of(2), frequency_hz, damping)


def test_a_motion_that_does_not_rest_is_refused():
    for start, end in (((0.0, 1.0), 3.0), (0.0, (3.0, 1.0))):
        with pytest.raises(ValueError, match="expected a move from rest to rest"):
            residual_vibration(min_time_transfer(start, end, Limits(2.0, 1.0)), 1.0)


def test_a_mode_that_decays_as_the_filter_does_is_refused():
    with pytest.raises(ValueError, match="cannot be told apart"):
        residual_vibration(move_of(2), 1.0, 0.999, jerk_filter=JerkFilter(1.0, 2))


# The map


def test_a_map_is_move_by_move():
    limits, distances = Limits(1.0, 4.0, 30.0), [-0.02, 0.5, 3.0]
    frequencies, jerk_filter = [0.5, 2.0, 7.5, 8.0], JerkFilter(20.0, 2)
    found = vibration_map(limits, distances, frequencies, 0.02, jerk_filter=jerk_filter)
    assert found.residual.shape == found.relative.shape == (3, 4)
    for i, distance in enumerate(distances):
        move = min_time_move(distance, limits, method="closed-form")
        assert found.durations[i] == move.duration
        expected = residual_vibration(move, frequencies, 0.02, jerk_filter=jerk_filter)
        np.testing.assert_array_equal(found.residual[i], expected)
        np.testing.assert_allclose(found.relative[i], expected / abs(distance), rtol=1e-15)
    assert repr(found) == "VibrationMap(distances=3, frequencies=4, damping=0.02)"


def test_a_map_of_numbers():
    assert vibration_map(Limits(1.0), 2.0, 0.5).relative == pytest.approx(np.zeros((1, 1)))


@pytest.mark.parametrize(
    ("distances", "frequencies", "message"),
    [
        ([1.0, 0.0], [1.0], "distances: expected none that is zero"),
        ([[1.0]], [1.0], "expected one row, not empty"),
        ([1.0], [[1.0]], "expected one row, not empty"),
        ([], [1.0], "expected one row, not empty"),
        ([1.0], [], "expected one row, not empty"),
        ([nan], [1.0], "distances must be finite"),
        ([1.0], [0.0], "frequencies_hz: expected positive"),
    ],
)
def test_wrong_maps_are_refused(distances, frequencies, message):
    with pytest.raises(ValueError, match=message):
        vibration_map(Limits(1.0), distances, frequencies)
