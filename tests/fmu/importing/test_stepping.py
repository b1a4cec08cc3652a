"""Stepping FMUs: against the exact model and FMPy, states, types, errors."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest
from handmade_fmus import INERTIA, PD, Model, fmu

from jounce.fmu.exporting.export import export_fmu
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.plant import Inertia, zero_order_hold

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
DT = 0.001
RANDOM = np.random.default_rng(4).normal(size=1000)


def exact(inputs, dt=DT):
    """Return the outputs after each step of the exactly sampled plant of INERTIA."""
    held = zero_order_hold(Inertia(2.0).system(), dt)
    x, rows = np.zeros(2), []
    for u in inputs:
        x = held.A @ x + held.B[:, 0] * u
        rows.append(x)
    return np.array(rows)


# Stepping


@VERSIONS
def test_it_steps_as_the_exact_plant_does(tmp_path, version):
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        assert (plant.input_names, plant.output_names) == (("u",), ("y", "y_rate"))
        assert (plant.dt, plant.time) == (DT, 0.0)
        found = np.array([plant.step([u]) for u in RANDOM])
    expected = exact(RANDOM)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@VERSIONS
def test_it_steps_as_fmpy_does(tmp_path, version):
    path = tmp_path / "inertia.fmu"
    export_fmu(Inertia(2.0), path, fmi_version=version, platforms=["x86_64-linux"])
    time = DT * np.arange(len(RANDOM) + 1)
    signal = np.array(
        list(zip(time, [*RANDOM, 0.0], strict=True)), dtype=[("time", float), ("u", float)]
    )
    theirs = fmpy.simulate_fmu(
        str(path), input=signal, stop_time=time[-1], step_size=DT, output_interval=DT,
        use_event_mode=False, set_input_derivatives=False, validate=False,
        output=["y", "y_rate"], fmi_type="CoSimulation", start_values={"J": 3.0},
    )  # fmt: skip
    with load_fmu(path, parameters={"J": 3.0}) as plant:
        ours = np.array([plant.outputs, *(plant.step([u]) for u in RANDOM)])
    assert len(theirs) == len(ours)
    for i, name in enumerate(("y", "y_rate")):
        peak = np.abs(ours[:, i]).max()
        np.testing.assert_allclose(theirs[name], ours[:, i], rtol=0, atol=1e-12 * peak)


@VERSIONS
def test_inputs_by_name_by_array_or_kept(tmp_path, version):
    with load_fmu(fmu(tmp_path, PD, version)) as controller:
        first = controller.step({"r": 1.0, "y": 0.25, "y_rate": 0.5})
        assert first.tolist() == [4.0 * 0.75 - 2.0 * 0.5]
        assert controller.step([1.0, 0.25, 0.5]).tolist() == first.tolist()
        assert controller.step().tolist() == first.tolist()
        assert controller.step({"y": 1.0}).tolist() == [-1.0]
        assert controller.step(np.array([2, 1, 0])).tolist() == [4.0]
        assert controller.inputs.tolist() == [2.0, 1.0, 0.0]
        first[0] = 99.0
        assert controller.outputs.tolist() == [4.0]


@VERSIONS
def test_uneven_steps(tmp_path, version):
    """The sum of the steps counts, and the clock adds no rounding of its own."""
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        for length in [0.001] * 700 + [0.1, 0.0123, 0.1877]:
            last = plant.step([1.0], length)
        assert plant.time == pytest.approx(1.0, rel=1e-14)
        np.testing.assert_allclose(last, [0.25, 0.5], rtol=1e-12)


@VERSIONS
def test_a_hundred_thousand_steps_lose_no_time(tmp_path, version):
    clock = Model("clock", inputs=(), states=1, step="x[0] += 1.0; y[0] = x[0];")
    with load_fmu(fmu(tmp_path, clock, version)) as ticking:
        for _ in range(100_000):
            count = ticking.step()
        assert count.tolist() == [100_000.0]
        assert ticking.time == 100_000 * 0.001


@VERSIONS
def test_start_time_and_parameters(tmp_path, version):
    with load_fmu(fmu(tmp_path, version=version), start_time=5.0, parameters={"J": 0.5}) as plant:
        assert plant.time == 5.0
        assert plant.parameters == {"J": 0.5}
        assert plant.step([1.0], 1.0).tolist() == [1.0, 2.0]
        plant.set("J", 1.0)
        assert plant.get("J") == 1.0
        assert plant.step([1.0], 1.0).tolist() == [3.5, 3.0]
        plant.reset()
        assert (plant.time, plant.parameters, plant.inputs.tolist()) == (5.0, {"J": 0.5}, [0.0])
        assert plant.step([1.0], 1.0).tolist() == [1.0, 2.0]
        plant.reset({})
        assert plant.parameters == {"J": 2.0}


@VERSIONS
def test_two_instances_know_nothing_of_each_other(tmp_path, version):
    path = fmu(tmp_path, version=version)
    with load_fmu(path) as one, load_fmu(path, parameters={"J": 4.0}) as two:
        for u in RANDOM[:50]:
            found = one.step([u]), two.step([-2.0 * u])
        np.testing.assert_allclose(found[0], -found[1], rtol=1e-13)
        one.close()
        two.step([1.0])


@VERSIONS
def test_state_round_trip(tmp_path, version):
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        for u in RANDOM[:10]:
            plant.step([u])
        state = plant.get_state()
        first = [plant.step([u]).tolist() for u in RANDOM[10:40]]
        plant.step([1.0], 0.5)
        later = plant.get_state()
        plant.set_state(state)
        assert plant.time == 10 * DT
        assert plant.inputs.tolist() == [RANDOM[9]]
        assert [plant.step([u]).tolist() for u in RANDOM[10:40]] == first
        plant.reset()
        plant.set_state(later)
        assert plant.time == pytest.approx(40 * DT + 0.5)
        for _ in range(1000):
            plant.get_state()
        assert len(plant._session.states) == 2


@VERSIONS
def test_other_types_than_doubles(tmp_path, version):
    mixed = Model(
        "mixed",
        inputs=("a", "n", "flag"),
        outputs=("twice", "count", "back"),
        types={"n": "Int32", "flag": "Boolean", "count": "Int32", "back": "Boolean"},
        step="y[0] = 2 * u[0]; y[1] = u[1] + 1; y[2] = u[2];",
    )
    with load_fmu(fmu(tmp_path, mixed, version)) as block:
        assert block.step([1.5, 3, True]).tolist() == [3.0, 4.0, 1.0]
        assert block.step({"flag": False}).tolist() == [3.0, 4.0, 0.0]
        assert (block.get("count"), block.get("back")) == (4, False)
        for odd in (2.5, 1e12, np.nan):
            with pytest.raises(FmuError, match=r"n = .*: expected whole numbers within .* int32"):
                block.step([1.5, odd, 0.0])


def test_arrays_of_fmi3(tmp_path):
    vector = Model(
        "vector",
        inputs=("u", "hidden"),
        outputs=("y", "hidden_too"),
        step="y[0] = u[0] + u[1]; y[1] = u[0] - u[1];",
        xml=(
            ('<Float64 name="hidden" valueReference="1" causality="input" '
             'variability="continuous" start="0.0"/>', ""),
            ('<Float64 name="hidden_too" valueReference="101" causality="output" '
             'variability="continuous"/>', ""),
            ('<Output valueReference="101"/>', ""),
            ('causality="input" variability="continuous" start="0.0"/>',
             'causality="input" start="0.0 0.0"><Dimension start="2"/></Float64>'),
            ('causality="output" variability="continuous"/>',
             'causality="output"><Dimension start="2"/></Float64>'),
        ),
    )  # fmt: skip
    with load_fmu(fmu(tmp_path, vector, "3.0")) as block:
        assert (block.input_names, block.output_names) == (("u[1]", "u[2]"), ("y[1]", "y[2]"))
        assert block.step([5.0, 2.0]).tolist() == [7.0, 3.0]
        assert block.step({"u[2]": 1.0}).tolist() == [6.0, 4.0]
        assert block.get("y").tolist() == [6.0, 4.0]


@VERSIONS
def test_errors_carry_what_the_fmu_logged(tmp_path, version):
    path = fmu(tmp_path, version=version)
    with load_fmu(path) as plant:
        with pytest.raises(FmuError, match=r"could not step from time 0\.0 by 0\.001: it reported "
                           "an error: input is not finite"):  # fmt: skip
            plant.step([np.nan])
        plant.reset()
        assert plant.step([1.0])[1] == 0.0005
    with pytest.raises(FmuError, match=r"could not be initialised: .* parameter too small"):
        load_fmu(path, parameters={"J": -1e7})


@VERSIONS
def test_a_closed_fmu_says_so(tmp_path, version):
    plant = load_fmu(fmu(tmp_path, version=version))
    state = plant.get_state()
    plant.close()
    plant.close()
    uses = [
        plant.step, lambda: plant.step([1.0]), lambda: plant.outputs, plant.reset, plant.get_state,
        lambda: plant.set_state(state), lambda: plant.get("J"), lambda: plant.set("J", 1.0),
    ]  # fmt: skip
    for use in uses:
        with pytest.raises(FmuError, match="plant is closed: load it again"):
            use()
    assert "closed" in repr(plant)


@VERSIONS
def test_a_fatal_error_ends_it(tmp_path, version):
    deadly = replace(INERTIA, name="deadly", step="if (u[0] > 9) return 4;" + INERTIA.step)
    plant = load_fmu(fmu(tmp_path, deadly, version))
    plant.step([1.0])
    with pytest.raises(FmuError, match="fatal error"):
        plant.step([10.0])
    with pytest.raises(FmuError, match="closed"):
        plant.step([1.0])


@VERSIONS
@pytest.mark.parametrize(
    ("status", "match"), [(2, "discarded"), (5, "asynchronously"), (77, "status 77")], ids=str
)
def test_other_statuses_are_errors_too(tmp_path, version, status, match):
    odd = replace(INERTIA, name="odd", step=f"if (u[0] > 9) return {status};" + INERTIA.step)
    with load_fmu(fmu(tmp_path, odd, version)) as plant:
        plant.step([1.0])
        with pytest.raises(FmuError, match=match):
            plant.step([10.0])


def test_a_warning_is_kept_and_no_error(tmp_path):
    wary = replace(INERTIA, name="wary", step="if (u[0] > 9) return 1;" + INERTIA.step)
    with load_fmu(fmu(tmp_path, wary)) as plant:
        plant.step([10.0])
        assert plant.time == DT


def test_an_fmu_that_wants_to_end(tmp_path):
    short = replace(INERTIA, name="brief", step=INERTIA.step + "if (x[0] > 1) return 100;")
    with load_fmu(fmu(tmp_path, short, "3.0")) as plant:
        plant.step([1.0], 1.0)
        with pytest.raises(FmuError, match=r"end of the simulation: at time 3\.0"):
            plant.step([1.0], 2.0)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"uu": 1.0}, "no input 'uu': did you mean 'u'"),
        ([1.0, 2.0], r"2 values for 1 inputs \(u\)"),
        ([], r"0 values for 1 inputs"),
        ([[1.0]], "1 values for 1 inputs"),
    ],
    ids=["name", "two", "none", "matrix"],
)
def test_inputs_that_are_refused(tmp_path, given, match):
    with load_fmu(fmu(tmp_path)) as plant, pytest.raises(FmuError, match=match):
        plant.step(given)


@pytest.mark.parametrize("dt", [0.0, -1.0, np.nan, np.inf], ids=str)
def test_steps_that_are_refused(tmp_path, dt):
    path = fmu(tmp_path)
    with load_fmu(path) as plant, pytest.raises(ValueError, match="dt = "):
        plant.step([1.0], dt)
    with pytest.raises(ValueError, match="dt = "):
        load_fmu(path, dt=dt)


@VERSIONS
def test_one_length_of_step_only(tmp_path, version):
    rigid = replace(INERTIA, variable_step=False, step_size=None)
    with load_fmu(fmu(tmp_path, rigid, version)) as plant:
        plant.step([1.0], 0.01)
        plant.step([1.0], 0.01)
        with pytest.raises(FmuError, match=r"steps of one length only, here 0\.01"):
            plant.step([1.0], 0.02)
        plant.reset()
        plant.step([1.0], 0.02)


def test_no_way_back_for_those_that_cannot(tmp_path):
    with load_fmu(fmu(tmp_path, replace(INERTIA, rollback=False))) as plant:
        with pytest.raises(FmuError, match="cannot take snapshots: it declares no"):
            plant.get_state()
        with load_fmu(fmu(tmp_path)) as other, pytest.raises(FmuError, match="of another FMU"):
            plant.set_state(other.get_state())
