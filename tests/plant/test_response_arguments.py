"""What a response takes, in which shapes it comes, and what is refused."""

import re
from math import inf, nan

import control
import numpy as np
import pytest
from responses import LAG, MOVE

from jounce.plant import (
    PID,
    Controller,
    Inertia,
    ServoLoop,
    TorqueSteps,
    respond,
    respond_all,
)
from jounce.shaping import Limits, min_time_move


@pytest.mark.parametrize("delay", [-0.4, 3.0])
def test_the_grid_begins_at_the_trajectorys_start(delay):
    later, now = respond(LAG, MOVE.delay(delay), 0.01), respond(LAG, MOVE, 0.01)
    assert later.time[0] == delay
    np.testing.assert_allclose(later.time - delay, now.time, rtol=0, atol=1e-14)
    np.testing.assert_allclose(later.outputs, now.outputs, rtol=0, atol=1e-13)


def test_the_initial_state_decays_beside_the_response():
    rested = respond(LAG, MOVE, 0.01)
    response = respond(LAG, MOVE, 0.01, initial_state=[3.0])
    expected = rested.outputs + 3.0 * np.exp(-rested.time)
    np.testing.assert_allclose(response.outputs, expected, rtol=0, atol=1e-13)


def test_labels_and_shapes_of_a_system_with_many_signals():
    plant = control.ss(
        np.diag([-1.0, -2.0]), np.eye(2), np.ones((3, 2)), np.zeros((3, 2)),
        inputs=["a", "b"], outputs=["p", "q", "s"], states=["v", "w"],
    )  # fmt: skip
    response = respond(plant, MOVE, 0.1, derivatives=("velocity", 0), duration=1.0)
    assert isinstance(response, control.TimeResponseData)
    assert response.input_labels == ["a", "b"]
    assert response.output_labels == ["p", "q", "s"]
    assert response.state_labels == ["v", "w"]
    np.testing.assert_allclose(response.time, 0.1 * np.arange(11), rtol=1e-14)
    assert response.outputs.shape == (3, 11)
    assert response.states.shape == (2, 11)
    np.testing.assert_allclose(response.inputs, [MOVE(response.time, 1), MOVE(response.time)])
    np.testing.assert_allclose(response.outputs, np.tile(response.states.sum(axis=0), (3, 1)))


def test_one_input_and_output_are_squeezed_as_in_python_control():
    response = respond(LAG, MOVE, 0.1)
    reference = control.forced_response(LAG, response.time, MOVE(response.time))
    for name in ("time", "outputs", "inputs"):
        assert getattr(response, name).shape == getattr(reference, name).shape, name
    assert response.issiso


def test_a_system_without_states_is_a_gain():
    gain = control.ss([], [], [], [[2.0, -1.0]])
    response = respond(gain, MOVE, 0.01, derivatives=(0, 2))
    expected = 2.0 * MOVE(response.time) - MOVE(response.time, 2)
    np.testing.assert_allclose(np.ravel(response.outputs), expected, rtol=0, atol=1e-14)
    assert response.states.shape[0] == 0


def test_the_default_duration_is_the_trajectorys():
    time = respond(LAG, MOVE, 0.25).time
    np.testing.assert_allclose(time[[0, -1]], [0.0, MOVE.duration], atol=1e-14)
    assert respond(LAG, MOVE, 0.1, duration=0.55).time[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    "plant", [control.tf([1.0, 0.0], [1.0]), control.tf([1.0, 0.0, 0.0], [2.0, 1.0])]
)
def test_an_improper_transfer_function_is_refused(plant):
    with pytest.raises(ValueError, match=r"improper transfer function: feed it a derivative"):
        respond(plant, MOVE, 0.1)


@pytest.mark.parametrize(("derivative", "name"), [(4, "snap"), ("crackle", "crackle")])
@pytest.mark.parametrize("plant", [LAG, control.tf([1.0], [1.0, 2.0])])
def test_a_derivative_above_the_order_is_refused(plant, derivative, name):
    with pytest.raises(ValueError, match=f"{name} of a trajectory of order 3 is a train of imp"):
        respond(plant, MOVE, 0.1, derivatives=(derivative,))


@pytest.mark.parametrize("derivatives", [(), (0,), (0, 1, 2)])
def test_every_input_needs_one_derivative(derivatives):
    plant = control.ss([[-1.0]], [[1.0, 2.0]], [[1.0]], [[0.0, 0.0]], inputs=["left", "right"])
    message = rf"{len(derivatives)} derivatives .* 2 inputs \(left, right\): give one"
    with pytest.raises(ValueError, match=message):
        respond(plant, MOVE, 0.1, derivatives=derivatives)


def pass_on(_t, _x, u, _params):
    return u


@pytest.mark.parametrize("system", [control.nlsys(None, pass_on, inputs=1, outputs=1), 3.0, None])
def test_what_is_not_linear_is_refused(system):
    with pytest.raises(TypeError, match=r"got \w+: expected a python-control StateSpace"):
        respond(system, MOVE, 0.1)


@pytest.mark.parametrize("name", ["dt", "duration"])
@pytest.mark.parametrize("value", [0.0, -1.0, nan, inf])
def test_a_dt_or_duration_that_is_not_positive_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a positive"):
        respond(LAG, MOVE, **({"dt": 0.1, "duration": 1.0} | {name: value}))


@pytest.mark.parametrize("initial", [[1.0, 2.0], [nan], 1.0, []])
def test_an_initial_state_that_does_not_fit_is_refused(initial):
    with pytest.raises(
        ValueError, match=r"initial_state .*: expected 1 finite numbers, for x\[0\]"
    ):
        respond(LAG, MOVE, 0.1, initial_state=initial)


@pytest.mark.parametrize("derivative", [-1, "speed"])
def test_what_is_no_derivative_is_refused(derivative):
    with pytest.raises(ValueError, match="derivative"):
        respond(LAG, MOVE, 0.1, derivatives=(derivative,))


def test_an_unstable_response_out_of_range_is_refused():
    move = min_time_move(1.0, Limits(acceleration=1.0))
    with pytest.raises(ValueError, match=r"leaves the range of a double .* shorten the duration"):
        respond(control.tf([1], [1, -1000]), move, 0.01, duration=100.0)


def test_a_grid_without_end_is_refused():
    move = min_time_move(1.0, Limits(acceleration=1.0))
    with pytest.raises(ValueError, match=r"dt = 1e-12 makes 2e\+12 samples"):
        respond(control.tf([1], [1, 1]), move, 1e-12)
    with pytest.raises(ValueError, match=r"dt = 1e-12 makes 2e\+12 samples"):
        move.sample(1e-12)


@pytest.mark.parametrize(
    ("do", "told"),
    [
        (
            lambda loop, move: loop.respond(move, noise=[1.0], dt=0.1),
            "a continuous controller takes",
        ),
        (
            lambda loop, move: ServoLoop(
                loop.plant, Controller(loop.controller, sample_time=1e-3)
            ).respond(move, 1.0, duration=1e9),
            "duration = 1000000000.0 makes 1e+12 samples of 0.001: expected at most 1e+08",
        ),
        (
            lambda loop, move: respond_all([loop], move, 0.1, figures=3),
            "figures = 3: expected a function of a LoopResponse",
        ),
        (
            lambda loop, move: respond_all([loop], move, 0.1, figures=len, workers=0),
            "workers = 0: expected a whole number from 1",
        ),
        (lambda *_: TorqueSteps([0.1], [nan]), "torques = [nan]: expected finite torques"),
    ],
)
def test_arguments_that_no_response_has_are_refused(do, told):
    loop = ServoLoop(Inertia(1.0), PID(2.0, 1.0, 3.0))
    with pytest.raises((ValueError, TypeError), match=re.escape(told)):
        do(loop, min_time_move(1.0, Limits(1.0, 1.0)))
