"""FMUs in python-control: loops against the exactly sampled ones, and repeated evaluation."""

from dataclasses import replace

import control
import numpy as np
import pytest
from handmade_fmus import INERTIA, PD, Model, fmu

from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.io_system import io_system
from jounce.fmu.importing.load import load_fmu
from jounce.plant import PID, Inertia, zero_order_hold

VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
DT = 0.001
TIME = DT * np.arange(600)
COMMAND = np.sin(8.0 * TIME) + 0.1 * np.random.default_rng(1).normal(size=TIME.size)


def closed(plant):
    """Return the loop r → (y, u) of a digital PID around a plant with outputs y and y_rate."""
    signs = np.array([[1.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    pid = PID(40.0, 100.0, 8.0).sampled(DT)
    controller = control.ss(
        *(pid.A, pid.B @ signs, pid.C, pid.D @ signs, DT),
        inputs=["r", "y", "y_rate"], outputs=["u"], name="controller",
    )  # fmt: skip
    return control.interconnect([plant, controller], inputs=["r"], outputs=["y", "u"], dt=DT)


@VERSIONS
def test_a_loop_is_the_exact_one(tmp_path, version):
    """No sample of delay more than a zero-order hold has."""
    exact = control.input_output_response(
        closed(zero_order_hold(Inertia(2.0).system(), DT)), TIME, COMMAND
    )
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        loop = closed(plant.system(DT))
        found = control.input_output_response(loop, TIME, COMMAND)
        again = control.input_output_response(loop, TIME, COMMAND)
    for row, expected in zip(found.outputs, exact.outputs, strict=True):
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_array_equal(again.outputs, found.outputs)
    np.testing.assert_array_equal(again.states, found.states)


def test_evaluation_is_repeatable_in_any_order(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant:
        system = io_system(plant, 0.5)
        start = np.zeros(2)
        one = system.dynamics(0.0, start, [1.0])
        other = system.dynamics(0.0, start, [-3.0])
        further = system.dynamics(0.5, one, [1.0])
        assert one[0] == other[0] == 1.0
        assert one[1] != other[1]
        assert system.output(0.0, other, [0.0]).tolist() == [-0.1875, -0.75]
        assert system.output(0.0, one, [9.0]).tolist() == [0.0625, 0.25]
        assert system.output(0.0, further, [0.0]).tolist() == [0.25, 0.5]
        assert system.output(0.0, start, [7.0]).tolist() == [0.0, 0.0]
        assert system.dynamics(0.0, start, [1.0]).tolist() == one.tolist()
        plant.step([50.0])
        assert system.dynamics(0.5, one, [1.0]).tolist() == further.tolist()
        assert (
            system.dynamics(0.0, start, [-0.0]).tolist()
            == system.dynamics(0.0, start, [0.0]).tolist()
        )


def test_it_begins_where_the_fmu_stands(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant:
        plant.step([1.0], 1.0)
        system = plant.system(0.5)
        assert system.output(0.0, np.zeros(2), [0.0]).tolist() == [0.25, 0.5]


def test_a_bounded_number_of_snapshots(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant:
        system = io_system(plant, snapshots=8)
        x = first = system.dynamics(0.0, np.zeros(2), [0.0])
        for _ in range(100):
            x = system.dynamics(0.0, x, [1.0])
        assert len(plant._session.states) <= 9
        with pytest.raises(
            FmuError, match=r"no snapshot of it is kept.*raise snapshots= \(now 8\)"
        ):
            system.output(0.0, first, [0.0])
        with pytest.raises(FmuError, match="no snapshot"):
            system.dynamics(0.0, np.array([1.0, 5.0]), [0.0])
        system.dynamics(0.0, np.zeros(2), [0.0])


def test_a_sampled_controller_shows_its_tick_a_step_later(tmp_path):
    with load_fmu(fmu(tmp_path, PD)) as controller:
        found = control.input_output_response(
            controller.system(), TIME, np.array([COMMAND, 0.0 * TIME, 0.0 * TIME])
        )
    np.testing.assert_allclose(found.outputs[0, 1:], 4.0 * COMMAND[:-1], rtol=1e-15)
    assert found.outputs[0, 0] == 0.0


def test_names_that_python_control_cannot_have(tmp_path):
    named = Model("axis", inputs=("motor.u[1]", "motor_u_1"), outputs=("der(phi)", "a b"))
    with load_fmu(fmu(tmp_path, named)) as block:
        system = block.system()
    assert system.input_labels == ["motor_u_1", "motor_u_1_"]
    assert system.output_labels == ["der_phi", "a_b"]
    assert (system.name, system.dt) == ("axis", DT)


def test_what_is_refused(tmp_path):
    plant = load_fmu(fmu(tmp_path, replace(INERTIA, rollback=False)))
    with plant, pytest.raises(FmuError, match=r"cannot be evaluated repeatedly.*`cosimulate`"):
        plant.system()
    with load_fmu(fmu(tmp_path, replace(INERTIA, step_size=None))) as plant:
        with pytest.raises(ValueError, match="snapshots = 1"):
            plant.system(1.0, snapshots=1)
        system = plant.system(1.0)
    with pytest.raises(FmuError, match="plant is closed"):
        system.dynamics(0.0, np.zeros(2), [1.0])


def test_an_error_of_the_fmu_comes_through(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant:
        system = plant.system()
        with pytest.raises(FmuError, match="input is not finite"):
            system.dynamics(0.0, np.zeros(2), [np.inf])
        assert system.dynamics(0.0, np.zeros(2), [1.0])[0] == 1.0
