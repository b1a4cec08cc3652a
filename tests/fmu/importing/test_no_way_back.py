"""FMUs that give out results only when they are told that no state is gone back to."""

from dataclasses import replace

import numpy as np
import pytest
from handmade_fmus import INERTIA, Model, fmu

from jounce.fmu import FmuError, cosimulate, io_system, linearize_fmu, load_fmu

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
ISOLATED = pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])
DT, J, STEPS = 0.01, 2.0, 50

# v += h·u/J, x += h·v; the impulse h·u is kept back as long as the step may be undone
FLUSHING = Model(
    "truck",
    outputs=("y", "told"),
    parameters={"J": J},
    states=3,
    step="x[2] += h * u[0]; if (settled) { x[1] += x[2] / p[0]; x[2] = 0; } x[0] += h * x[1]; "
    "y[0] = x[0]; y[1] = settled;",
    step_size=DT,
)
PUSHED = DT**2 / J * np.arange(STEPS + 1) * np.arange(1, STEPS + 2) / 2.0
MARKOV = DT**2 / J * np.arange(1, STEPS + 1)  # x_k after an impulse of one step


@VERSIONS
@ISOLATED
def test_a_plain_run_and_a_cosimulation_are_told_that_nothing_is_gone_back_to(
    tmp_path, version, isolated
):
    with load_fmu(fmu(tmp_path, FLUSHING, version), isolated=isolated) as truck:
        found = [truck.step([1.0])[0] for _ in range(STEPS)]
        np.testing.assert_allclose(found, PUSHED[1:], rtol=1e-12)
        truck.reset()
        run = cosimulate({"truck": truck}, [(1.0, "truck.u")], dt=DT, duration=STEPS * DT)
    np.testing.assert_allclose(run["truck.y"], PUSHED, rtol=1e-12)
    assert run["truck.told"].tolist() == [0.0] + [1.0] * STEPS


@VERSIONS
@ISOLATED
def test_it_is_told_otherwise_as_long_as_a_snapshot_is_alive(tmp_path, version, isolated):
    with load_fmu(fmu(tmp_path, FLUSHING, version), isolated=isolated) as truck:
        state, other = truck.get_state(), truck.get_state()
        assert truck.step([1.0]).tolist() == [0.0, 0.0]
        truck.set_state(state)
        del state
        assert truck.step([1.0])[1] == 0.0
        del other
        assert truck.step([1.0])[1] == 1.0


def test_it_is_told_so_where_no_state_can_be_had(tmp_path):
    with load_fmu(fmu(tmp_path, replace(FLUSHING, rollback=False))) as truck:
        assert truck.step([1.0])[1] == 1.0


@VERSIONS
@ISOLATED
def test_linearised_at_its_start_it_has_all_its_states(tmp_path, version, isolated):
    with load_fmu(fmu(tmp_path, FLUSHING, version), isolated=isolated) as truck:
        found = linearize_fmu(truck, outputs=["y"], horizon=STEPS)
        assert truck.time == 0.0
        assert truck.step([1.0])[0] == PUSHED[1]
    assert found.nstates == 2
    response = [
        (found.C @ np.linalg.matrix_power(found.A, k) @ found.B)[0, 0] for k in range(STEPS)
    ]
    np.testing.assert_allclose(response, MARKOV, rtol=1e-7)


@VERSIONS
def test_elsewhere_it_is_not_linearised(tmp_path, version):
    with load_fmu(fmu(tmp_path, FLUSHING, version)) as truck:
        truck.step([1.0])
        with pytest.raises(
            FmuError, match=r"snapshot of it is kept .*just after load_fmu or reset"
        ):
            linearize_fmu(truck, horizon=STEPS)
        assert truck.step([1.0])[0] == pytest.approx(PUSHED[2], rel=1e-12)
        truck.reset({"J": 1.0})
        assert linearize_fmu(truck, outputs=["y"], horizon=STEPS).nstates == 2


@VERSIONS
def test_it_is_no_system_of_python_control(tmp_path, version):
    with load_fmu(fmu(tmp_path, FLUSHING, version)) as truck:
        with pytest.raises(FmuError, match=r"evaluated repeatedly.*use `cosimulate`"):
            io_system(truck)
        assert truck.step([1.0])[0] == PUSHED[1]


def test_the_check_touches_no_global_variables_of_the_fmu(tmp_path):
    sloppy = replace(
        INERTIA,
        name="sloppy",
        step="static int count; if (++count > 250) return 3;" + INERTIA.step,
    )
    with load_fmu(fmu(tmp_path, sloppy)) as plant:
        io_system(plant)
        for _ in range(200):
            plant.step([1.0])


def test_only_one_instance_in_a_process_is_checked_in_another_one(tmp_path):
    single = replace(
        INERTIA,
        name="single",
        xml=(('modelIdentifier="single"', 'modelIdentifier="single" '
              'canBeInstantiatedOnlyOncePerProcess="true"'),),
    )  # fmt: skip
    with load_fmu(fmu(tmp_path, single)) as plant:
        assert linearize_fmu(plant, horizon=STEPS).nstates == 2


def test_what_cannot_be_checked_is_told(tmp_path, monkeypatch):
    def refuse(*_):
        raise FmuError("no licence left")

    with load_fmu(fmu(tmp_path)) as plant:
        monkeypatch.setattr(plant, "_instantiate", refuse)
        with pytest.warns(UserWarning, match=r"could not be checked, .* failed \(no licence left"):
            io_system(plant)
