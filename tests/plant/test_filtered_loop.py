"""The servo loop behind a jerk filter: the two in series, started at rest."""

import control
import numpy as np
import pytest
from references import RESPONSE
from servo_loops import MOMENT, MOVE, loop_with
from tiers import some

from jounce.plant import (
    PID,
    Inertia,
    InertiaFeedforward,
    ServoLoop,
    filter_system,
)
from jounce.shaping import JerkFilter, Limits, min_time_move


@pytest.mark.parametrize("order", [2, 3, 6])
@pytest.mark.parametrize("filter_order", some([1, 2, 4, 6], 2))
@pytest.mark.parametrize("corner", [0.5, 20.0])
def test_perfect_feedforward_passes_the_filtered_command_on(order, filter_order, corner):
    move = min_time_move(
        -2.0, Limits.from_bounds([0.5, 1.0, 4.0, 30.0, 4e2, 4e3][:order]), method="closed-form"
    )
    jerk_filter = JerkFilter(corner, filter_order)
    length = move.duration + jerk_filter.settling_time(1e-6)
    response = loop_with(MOMENT).respond(move, 0.01, duration=length, jerk_filter=jerk_filter)
    filtered = jerk_filter.respond(move, 0.01)
    np.testing.assert_allclose(response.position, filtered.states[0], rtol=0, atol=2e-12)
    np.testing.assert_allclose(response.command, filtered.states[0], rtol=0, atol=2e-12)
    assert np.abs(response.error).max() <= 2e-12
    torque = MOMENT * filtered.states[2] if filter_order > 1 else response.torque
    np.testing.assert_allclose(response.torque, torque, rtol=0, atol=1e-11 * np.abs(torque).max())


@pytest.mark.parametrize("filter_order", [3, 6])
@pytest.mark.parametrize("estimate", [None, 2.0])
def test_filter_and_loop_are_the_system_in_series(filter_order, estimate):
    """Fed with the velocity of an order-2 move, which is linear, through an integrator."""
    move = min_time_move(2.0, Limits(velocity=1.0, acceleration=2.0))
    np.testing.assert_allclose(move.breaks * 4, np.round(move.breaks * 4), atol=1e-14)
    jerk_filter, loop = JerkFilter(1.5, filter_order), loop_with(estimate)
    integrator = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]])
    series = loop.system() * filter_system(jerk_filter, derivatives=2) * integrator
    response = loop.respond(move, 2.0**-7, duration=6.0, jerk_filter=jerk_filter)
    reference = control.forced_response(series, response.time, move(response.time, 1))
    peaks = np.abs(reference.outputs).max(axis=1, keepdims=True)
    np.testing.assert_allclose(
        response.outputs / peaks, reference.outputs / peaks, rtol=0, atol=RESPONSE
    )


@pytest.mark.parametrize("start", [-3.0, 7.0])
def test_behind_a_filter_the_loop_still_starts_at_rest(start):
    response = loop_with(2.0).respond(
        MOVE.shift(start).delay(1.0), 0.01, jerk_filter=JerkFilter(2.0, 6), duration=6.0
    )
    zero = loop_with(2.0).respond(MOVE, 0.01, jerk_filter=JerkFilter(2.0, 6), duration=6.0)
    assert response.position[0] == response.command[0] == start
    assert response.time[0] == 1.0
    np.testing.assert_allclose(response.position - start, zero.position, rtol=0, atol=1e-12)


def test_a_trajectory_of_order_1_is_refused_unless_a_filter_smooths_it():
    ramp = min_time_move(1.0, Limits(velocity=1.0))
    message = "acceleration of a trajectory of order 1 is a train of impulses: use .*acceleration"
    with pytest.raises(ValueError, match=message):
        loop_with(1.0).respond(ramp, 0.1)
    with pytest.raises(ValueError, match=r"filter of order 1 behind .* use order 2 or more"):
        loop_with(1.0).respond(ramp, 0.1, jerk_filter=JerkFilter(2.0, 1))


@pytest.mark.parametrize("order", [2, 3, 6])
def test_a_filter_can_be_put_behind_a_velocity_limited_move(order):
    ramp, behind = min_time_move(1.0, Limits(velocity=2.0), start=3.0), JerkFilter(2.0, order)
    loop = ServoLoop(Inertia(2.0), PID(50.0, 70.0, 11.0), InertiaFeedforward(2.0))
    response = loop.respond(ramp, 0.01, duration=4.0, jerk_filter=behind)
    alone = behind.respond(ramp, 0.01, duration=4.0)
    np.testing.assert_allclose(response.inputs, alone.states[:3], atol=1e-12)
    np.testing.assert_allclose(response.error, 0.0, atol=1e-12)
