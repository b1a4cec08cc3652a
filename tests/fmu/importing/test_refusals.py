"""What is refused changes nothing: inputs, copies, linear models that would be wrong."""

import copy
import pickle

import control
import numpy as np
import pytest
from handmade_fmus import PD, Model, fmu

from jounce.fmu.exporting.export import export_fmu
from jounce.fmu.exporting.loop_blocks import SampledController
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.linearize import linearize_fmu
from jounce.fmu.importing.load import load_fmu
from jounce.plant import PID

SAMPLED = control.ss([[0.5, 1.0], [0.0, 0.2]], [[0.0], [1.0]], [[1.0, 0.0]], [[2.0]], 0.01)


def exported(folder, block):
    path = folder / "block.fmu"
    export_fmu(block, path, platforms=["x86_64-linux"])
    return load_fmu(path)


@pytest.mark.parametrize(
    ("block", "dt"),
    [
        (SAMPLED, 0.005),
        (SAMPLED, 0.015),
        (SAMPLED, 0.0101),
        (SampledController(PID(4.0, 1.0, 4.0), 1e-3), 4e-4),
    ],
    ids=["half", "one and a half", "one in a hundred off", "controller"],
)
def test_inner_sampling_that_dt_is_no_multiple_of(tmp_path, block, dt):
    told = rf"alike at every step of dt = {dt!r}.*multiple of it"
    with exported(tmp_path, block) as loaded, pytest.raises(FmuError, match=told):
        linearize_fmu(loaded, dt)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_multiples_of_the_inner_sampling_are_exact(tmp_path, steps):
    u = np.r_[1.0, -2.0, 0.5, np.zeros(9)]
    with exported(tmp_path, SAMPLED) as loaded:
        model = linearize_fmu(loaded, steps * 0.01)
        seen = [loaded.step([value], steps * 0.01)[0] for value in u[:-1]]
    found = control.forced_response(model, U=u).outputs
    np.testing.assert_allclose(found[1:], seen, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"y": 9.0, "q": 1.0}, FmuError),
        ({"y": 9.0, "r": None}, TypeError),
        ({"y": 9.0, "r": "2"}, TypeError),
        ([9.0, None, 1.0], TypeError),
        (np.array(["a", "b", "c"]), TypeError),
        ([1.0], FmuError),
    ],
    ids=["name", "none", "text", "none in a list", "texts", "too few"],
)
def test_a_refused_input_changes_nothing(tmp_path, given, error):
    with load_fmu(fmu(tmp_path, PD)) as block:
        block.step([1.0, 0.25, 0.5])
        with pytest.raises(error, match=r"'r'|'q'|'y'|1 values"):
            block.step(given)
        assert block.inputs.tolist() == [1.0, 0.25, 0.5]
        assert block.step().tolist() == [4.0 * 0.75 - 2.0 * 0.5]


def test_an_input_that_the_fmu_refuses_is_taken_back(tmp_path):
    picky = Model("picky", step="if (u[0] != u[0]) return 3; y[0] = u[0];")
    with load_fmu(fmu(tmp_path, picky)) as block:
        block.step([2.0])
        with pytest.raises(FmuError, match="could not"):
            block.step({"u": np.nan})
        assert block.inputs.tolist() == [2.0]
        with pytest.raises(FmuError, match=r"after the error at time 0\.001: call reset\(\) first"):
            block.step()
        block.reset()
        assert block.step([2.0]).tolist() == [2.0]


def test_after_a_refused_input_its_state_is_no_news(tmp_path):
    """An FMU that minds its state says "illegal call sequence" from its first error on."""
    no = 'if (lost) return fail(c, "fmi2: Illegal call sequence.");'
    big = 'if (in[i] > 1) { lost = 1; return fail(c, "too large"); }'
    store, finite = "*a = in[i];", "for (int i = 0; i < NU; i++)"
    code = ((store, f"{no} {big} {store}"), (finite, f"{no} {finite}"),
            ("{ defaults(S(c)); return", "{ lost = 0; defaults(S(c)); return"))  # fmt: skip
    strict = Model("strict", prelude="static int lost;", step="y[0] = u[0];", code=code)
    with load_fmu(fmu(tmp_path, strict)) as block:
        with pytest.raises(FmuError, match="too large"):
            block.step([2.0])
        for _ in range(2):
            with pytest.raises(FmuError, match=r"call reset\(\) first") as caught:
                block.step([0.5])
            assert "call sequence" not in str(caught.value)
        block.reset()
        assert block.step([0.5]).tolist() == [0.5]


@pytest.mark.parametrize("wrong", [{"J": -1e7}, {"J": "two"}], ids=["by the FMU", "here"])
def test_parameters_that_are_refused_are_not_kept(tmp_path, wrong):
    with load_fmu(fmu(tmp_path), parameters={"J": 4.0}) as plant:
        with pytest.raises((FmuError, TypeError)):
            plant.reset(wrong)
        plant.reset()
        assert plant.get("J") == 4.0


def test_numbers_beyond_a_float32(tmp_path):
    narrow = Model("narrow", types={"u": "Float32"}, step="y[0] = u[0];")
    with load_fmu(fmu(tmp_path, narrow, "3.0")) as block:
        for given in ({"u": 1e39}, [-3.5e38]):
            with pytest.raises(FmuError, match=r"u = .*e.3[89]: expected a number"):
                block.step(given)
        with pytest.raises(FmuError, match="expected a number of type Float32"):
            block.reset({"u": 1e39})
        block.reset()
        assert block.step([3e38])[0] == pytest.approx(3e38, rel=1e-7)


def test_an_own_export_goes_on_after_nan(tmp_path):
    with exported(tmp_path, SampledController(PID(4.0, 1.0, 4.0), 1e-3)) as block:
        block.step(np.ones(len(block.input_names)))
        with pytest.raises(FmuError):
            block.step({"r": np.nan})
        assert block.inputs.tolist() == [1.0] * len(block.input_names)
        assert np.isfinite(block.step()).all()


@pytest.mark.parametrize("copier", [copy.copy, copy.deepcopy, pickle.dumps])
def test_no_copies(tmp_path, copier):
    with load_fmu(fmu(tmp_path)) as plant:
        with pytest.raises(TypeError, match="load it again"):
            copier(plant)
        with pytest.raises(TypeError, match="take another with get_state"):
            copier(plant.get_state())


@pytest.mark.parametrize(
    ("step", "match"),
    [
        ("y[0] = fabs(u[0]) < 0.2 ? 0 : u[0] * u[0] * u[0];", "impulse of 1 moves.*0.1 does not"),
        ("y[0] = 0 * u[0];", "do not react to an impulse of 1: give a larger amplitude"),
        ("y[0] = fabs(u[0]) < 5 ? 0 : u[0];", "do not react to an impulse of 1: give a larger"),
    ],
    ids=["dead zone", "nothing", "wide dead zone"],
)
def test_what_is_said_of_dead_outputs(tmp_path, step, match):
    block = load_fmu(fmu(tmp_path, Model("dead", step=step)))
    with block, pytest.raises(FmuError, match=match):
        linearize_fmu(block)


def test_wrong_types_are_told_in_words(tmp_path):
    path = fmu(tmp_path)
    with pytest.raises(TypeError, match="sha256 = 5: expected a string"):
        load_fmu(path, sha256=5)
    with pytest.raises(TypeError, match=r"fmu = 'a\.fmu': expected an Fmu"):
        linearize_fmu("a.fmu")
    with load_fmu(path) as plant:
        with pytest.raises(TypeError, match="state = None: expected an FmuState"):
            plant.set_state(None)
        with pytest.raises(FmuError, match=r"use linearize_fmu, not control\.linearize"):
            control.linearize(plant.system(), 0.0, 0.0)


def test_a_suggested_step_of_zero(tmp_path):
    path = fmu(
        tmp_path, Model("still", step="y[0] = 1;", xml=(('stepSize="0.001"', 'stepSize="0"'),))
    )
    with pytest.raises(FmuError, match=r"stepSize .* = 0\.0: .*give load_fmu a dt"):
        load_fmu(path)
    with load_fmu(path, dt=0.5) as block:
        assert block.step([0.0]).tolist() == [1.0]
