"""Systems without states are gains, made without arrays that python-control has to reshape."""

import control
import numpy as np
import pytest

from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.plant import PID, FlexibleInertia, Inertia, InertiaFeedforward, ServoLoop
from jounce.plant.exact_response import respond, state_space
from jounce.plant.linear_system import linear_system, static_gain
from jounce.plant.sampled import zero_order_hold
from jounce.shaping import Limits, min_time_move

MOVE = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=8.0))
LOOP = ServoLoop(Inertia(2.0), PID(40.0, 30.0, 20.0), InertiaFeedforward(1.5))
TURNED = control.tf([[[2.0], [0.0]]], [[[4.0], [1.0]]], 0.1, inputs=["a", "b"], outputs=["c"])


def test_a_gain_has_its_names_and_no_states():
    gain = static_gain([[2.0, -3.0]], 0.5, inputs=["a", "b"], outputs=["c"], name="mix")
    assert (gain.nstates, gain.A.shape, gain.B.shape, gain.C.shape) == (0, (0, 0), (0, 2), (1, 0))
    assert (gain.input_labels, gain.output_labels, gain.state_labels) == (["a", "b"], ["c"], [])
    assert (gain.name, gain.dt) == ("mix", 0.5)
    np.testing.assert_array_equal(gain.D, [[2.0, -3.0]])
    run = control.forced_response(gain, 0.5 * np.arange(3), [[1.0, 0.0, 2.0], [0.0, 1.0, 1.0]])
    np.testing.assert_array_equal(np.ravel(run.outputs), [2.0, -3.0, 1.0])


@pytest.mark.parametrize("dt", [0.1, None])
def test_a_gain_joins_systems_of_its_time_base(dt):
    gain = static_gain([[3.0]], dt, inputs=["a"], outputs=["b"])
    lag = control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1)
    assert (gain * lag).dt == 0.1
    assert complex((gain * lag)(2.0)) == pytest.approx(3.0 / (2.0 - 0.5))


def test_states_are_kept_even_where_nothing_sees_them():
    matrices = np.zeros((2, 2)), np.zeros((2, 1)), np.zeros((1, 2)), np.ones((1, 1))
    system = linear_system(matrices, 0, inputs=["u"], outputs=["y"], states=["x", "v"])
    assert (system.state_labels, system.dt) == (["x", "v"], 0)


def test_a_transfer_function_that_is_a_gain():
    found = state_space(TURNED)
    np.testing.assert_array_equal(found.D, [[0.5, 0.0]])
    assert (found.nstates, found.dt, found.name) == (0, 0.1, TURNED.name)
    assert (found.input_labels, found.output_labels) == (["a", "b"], ["c"])


def loop_of(pid):
    return ServoLoop(FlexibleInertia(1.0, 7.0, 0.1), pid)


WITHOUT_STATES = {
    "feedforward": InertiaFeedforward(2.0).system,
    "digital controller": lambda: PID(1.0, 0.0, 2.0).sampled(0.1),
    "interconnected loop": lambda: loop_of(PID(1.0, 1.0, 1.0)).system(),
    "sampled loop": lambda: loop_of(PID(1.0, 0.0, 2.0)).sampled_loop_transfer(0.01, delay=0.004),
    "transfer function": lambda: state_space(TURNED),
    "held gain": lambda: zero_order_hold(control.tf([3.0], [1.0]), 0.2),
    "response of a gain": lambda: respond(control.tf([3.0], [2.0]), MOVE, 0.1),
    "co-simulation": lambda: cosimulate(
        {"gain": TURNED}, [(1.0, "gain.a"), (2.0, "gain.b")], dt=0.1, duration=0.3
    ),
}


@pytest.mark.parametrize("make", WITHOUT_STATES.values(), ids=WITHOUT_STATES)
def test_python_control_is_never_given_empty_matrices(make, monkeypatch):
    """It would set their shapes in place, which numpy 2.5 deprecates; so on any numpy."""
    created = control.StateSpace.__init__
    sizes = []

    def spy(self, *arguments, **options):
        first = arguments[0]
        sizes.append(np.size(first.A if isinstance(first, control.StateSpace) else first))
        created(self, *arguments, **options)

    monkeypatch.setattr(control.StateSpace, "__init__", spy)
    make()
    assert sizes
    assert 0 not in sizes
