"""Exact responses of python-control systems, against python-control where that is exact."""

from math import inf, nan

import control
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references import RESPONSE
from scipy.signal import dlsim
from strategies import any_trajectory, smooth_trajectory

from jounce.plant import respond
from jounce.shaping import Limits, Trajectory, min_jerk_move, min_time_move

FEW = settings(max_examples=settings.default.max_examples // 2)
MOVE = min_time_move(1.0, Limits(velocity=0.5, acceleration=1.0, jerk=4.0))
"""Its breaks are multiples of 1/4, so that its acceleration is linear between samples."""

LAG = control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]])


def random_plant(seed, states, inputs, outputs, shift=0.0):
    """Return a random system with feedthrough, its rightmost pole at `shift`."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(states, states))
    a += (shift - np.linalg.eigvals(a).real.max(initial=-inf if states else 0.0)) * np.eye(states)
    return control.ss(
        a,
        rng.normal(size=(states, inputs)),
        rng.normal(size=(outputs, states)),
        rng.normal(size=(outputs, inputs)),
    )


def forced(system, time, inputs, initial=0.0):
    return control.forced_response(system, time, inputs, X0=initial, squeeze=False)


def check_agrees(response, reference, text):
    for name in ("outputs", "states"):
        ours, theirs = (
            np.atleast_2d(getattr(response, name)),
            np.atleast_2d(getattr(reference, name)),
        )
        ours, theirs = ours.reshape(-1, ours.shape[-1]), theirs.reshape(-1, theirs.shape[-1])
        peak = np.abs(theirs).max(axis=1, keepdims=True, initial=1e-300)
        worst = (np.abs(ours - theirs) / peak).max(initial=0.0)
        assert worst <= RESPONSE, f"{text}: {name} differ by {worst:g} of their peak"


# Against control.forced_response


def test_the_moves_breaks_are_on_the_grid():
    np.testing.assert_allclose(MOVE.breaks * 4, np.round(MOVE.breaks * 4), rtol=0, atol=1e-14)


@FEW
@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(1, 6),
    outputs=st.integers(1, 3),
    shift=st.sampled_from([-1.0, 0.0, 0.5]),
    dt=st.sampled_from([0.25, 0.125, 2.0**-7]),
)
def test_acceleration_into_any_system(seed, states, outputs, shift, dt):
    plant = random_plant(seed, states, 1, outputs, shift)
    initial = np.random.default_rng(seed).normal(size=states)
    response = respond(
        plant, MOVE, dt, derivatives=("acceleration",), duration=6.0, initial_state=initial
    )
    reference = forced(plant, response.time, MOVE(response.time, 2), initial)
    check_agrees(response, reference, f"random_plant({seed}, {states}, 1, {outputs}, {shift})")


@pytest.mark.parametrize("dt", [0.25, 2.0**-6])
def test_velocity_and_acceleration_of_an_order_2_move_into_two_inputs(dt):
    """Order 2: velocity is linear; acceleration comes with it through an integrator."""
    move = min_time_move(-2.0, Limits(velocity=1.0, acceleration=2.0))
    np.testing.assert_allclose(move.breaks * 4, np.round(move.breaks * 4), atol=1e-14)
    plant = random_plant(3, 3, 2, 2)
    integrated = control.ss([[0.0]], [[1.0]], [[1.0], [0.0]], [[0.0], [1.0]])
    fed = plant * integrated
    response = respond(plant, move, dt, derivatives=(0, 1), duration=5.0)
    reference = forced(fed, response.time, move(response.time, 1))
    np.testing.assert_allclose(
        response.outputs, reference.outputs, rtol=0, atol=1e-11 * np.abs(reference.outputs).max()
    )


def test_a_step_of_velocity_on_a_long_grid():
    """5e4 samples of a constant velocity, against the closed form t − 1 + e^(−t)."""
    ramp = min_time_move(50.0, Limits(velocity=1.0))
    response = respond(LAG, ramp, 1e-3)
    assert response.time.size == 50_001
    expected = response.time + np.expm1(-response.time)
    np.testing.assert_allclose(response.outputs, expected, rtol=0, atol=1e-11 * 50.0)


@pytest.mark.parametrize("poles", [(-2.0, -2.0, -2.0), (0.0, 0.0, 0.0), (-1e-3, -1.0, -1e3)])
def test_transfer_functions(poles):
    plant = control.tf([0.5, 1.0], np.poly(poles), inputs="torque", outputs="angle")
    response = respond(plant, MOVE, 2.0**-6, derivatives=(2,), duration=8.0)
    reference = forced(plant, response.time, MOVE(response.time, 2))
    worst = np.abs(response.outputs - reference.outputs.ravel()).max()
    assert worst <= RESPONSE * np.abs(reference.outputs).max()
    assert response.input_labels == ["torque"]
    assert response.output_labels == ["angle"]


def test_a_transfer_function_of_equal_degrees_passes_its_input_on():
    plant = control.tf([2.0, 0.0], [1.0, 3.0])
    response = respond(plant, MOVE, 2.0**-6, derivatives=(2,), duration=4.0)
    reference = forced(plant, response.time, MOVE(response.time, 2))
    np.testing.assert_allclose(response.outputs, reference.outputs.ravel(), rtol=0, atol=1e-11)


@pytest.mark.parametrize("order", [1, 3, 5])
def test_a_differentiating_transfer_function_gives_the_derivative_itself(order):
    """s/(s + 1) of the position is 1/(s + 1) of the velocity."""
    moving = smooth_trajectory(order, order)
    washout, lag = control.tf([1.0, 0.0], [1.0, 1.0]), control.tf([1.0], [1.0, 1.0])
    high = respond(washout, moving, 0.01)
    # the washout starts with its whole input across it: its state carries the first position
    low = respond(lag, moving, 0.01, derivatives=(1,))
    first = moving.start_state[0] * np.exp(-(high.time - high.time[0]))
    np.testing.assert_allclose(high.outputs, low.outputs + first, rtol=0, atol=1e-11)


# Discrete systems


@FEW
@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(0, 5),
    order=st.integers(1, 5),
    timebase=st.sampled_from([True, 0.07]),
)
def test_discrete_systems_are_their_recursion(seed, states, order, timebase):
    plant = random_plant(seed, states, 2, 2, -0.1)
    radius = np.abs(np.linalg.eigvals(plant.A)).max(initial=1.0)
    plant = control.ss(plant.A / radius, plant.B, plant.C, plant.D, timebase)
    moving = any_trajectory(seed, order)
    response = respond(plant, moving, 0.07, derivatives=(0, order), duration=9.0)
    _, outputs, reference = dlsim((*control.ssdata(plant), 0.07), response.inputs[0:2].T)
    text = f"random_plant({seed}, {states}, …), any_trajectory({seed}, {order})"
    scale = 1.0 + np.abs(response.inputs).max() * np.abs(plant.D).sum() + np.abs(outputs).max()
    np.testing.assert_allclose(
        response.outputs, outputs.T, rtol=0, atol=1e-11 * scale, err_msg=text
    )
    if states:
        atol = 1e-11 * (scale + np.abs(reference).max())
        np.testing.assert_allclose(response.states, reference.T, rtol=0, atol=atol, err_msg=text)


@given(
    tenths=st.lists(st.integers(1, 12), min_size=2, max_size=8),
    dt=st.sampled_from([0.1, 0.3, 0.01, 1 / 3]),
    start=st.sampled_from([0.0, 0.3, -0.7, 12.1]),
)
def test_the_reported_inputs_are_those_that_drove_a_discrete_system(tenths, dt, start):
    """A jump at a sample time may fall on either side of it, but on one side only."""
    breaks = start + dt * np.concatenate([[0], np.cumsum(tenths)])
    signs = (-1.0) ** np.arange(len(tenths))
    jumping = Trajectory(breaks, np.column_stack([np.zeros(len(tenths)), signs]))
    delay = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], True)
    response = respond(delay, jumping, dt, derivatives=(1,), duration=dt * sum(tenths))
    np.testing.assert_array_equal(
        np.ravel(response.states)[1:], np.ravel(response.inputs)[:-1],
        err_msg=f"breaks {breaks.tolist()}, dt={dt!r}",
    )  # fmt: skip


def test_an_unspecified_timebase_is_read_as_python_control_reads_it():
    plant = control.ss([[-0.5]], [[1.0]], [[1.0]], [[0.0]], None)
    response = respond(plant, MOVE, 0.25, derivatives=(2,))
    reference = forced(plant, response.time, MOVE(response.time, 2))
    np.testing.assert_allclose(response.outputs, reference.outputs.ravel(), rtol=0, atol=1e-13)


@pytest.mark.parametrize("dt", [0.1, 0.0999, 0.2])
def test_another_sampling_time_is_refused(dt):
    plant = control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.05)
    with pytest.raises(ValueError, match=rf"dt = {dt}: the system is sampled every 0\.05"):
        respond(plant, MOVE, dt)


# Against closed forms and itself


@pytest.mark.parametrize("rate", [1e-3, 1.0, 30.0, 1e6])
def test_a_lag_behind_a_minimum_jerk_move(rate):
    """By the 40-digit particular solution Σ(−1)^k r^(k)/λ^k."""
    move = min_jerk_move(2.0, duration=1.5)
    lag = control.ss([[-rate]], [[rate]], [[1.0]], [[0.0]])
    response = respond(lag, move, 0.02)
    peak = np.abs(response.outputs).max()
    with mpmath.workdps(60):
        size = mpmath.mpf(rate)

        def particular(t):
            return mpmath.fsum(
                (-1) ** k * mpmath.mpf(float(move.states[0, j])) * t ** (j - k)
                / mpmath.factorial(j - k) / size**k
                for k in range(6) for j in range(k, 6)
            )  # fmt: skip

        for i in (1, 20, 50, 74):
            t = i * mpmath.mpf(0.02)
            expected = particular(t) - particular(mpmath.mpf(0)) * mpmath.exp(-size * t)
            error = abs(mpmath.mpf(float(response.outputs[i])) - expected)
            assert error <= 1e-12 * max(peak, abs(expected)), (rate, i, float(error / peak))


@pytest.mark.parametrize("dt", [1e-4, 0.013, 0.3, 7.0])
def test_dt_does_not_change_the_values(dt):
    plant = random_plant(17, 4, 2, 3, 0.1)
    moving = smooth_trajectory(5, 4)
    fine = respond(plant, moving, dt, derivatives=(0, "jerk"), duration=14.0)
    for i in {1, fine.time.size // 2, fine.time.size - 1}:
        once = respond(plant, moving, i * dt, derivatives=(0, 3), duration=i * dt * 1.001)
        np.testing.assert_allclose(
            once.outputs[:, 1], fine.outputs[:, i], rtol=0, atol=1e-10 * np.abs(fine.outputs).max()
        )


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_time_changes_nothing(unit):
    plant = random_plant(19, 3, 2, 2, -0.2)
    slower = control.ss(plant.A / unit, plant.B / unit, plant.C, plant.D)
    slower.B[:, 1] *= unit
    slower.D[:, 1] *= unit
    moving = smooth_trajectory(6, 4, start=0.0)
    one = respond(plant, moving, 0.03, derivatives=(0, 1))
    other = respond(slower, moving.stretch(unit), 0.03 * unit, derivatives=(0, 1))
    np.testing.assert_allclose(
        other.outputs, one.outputs, rtol=0, atol=1e-11 * np.abs(one.outputs).max()
    )


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


# What comes back


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


# Errors


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
