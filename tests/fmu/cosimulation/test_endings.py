"""Runs that an FMU ends, and runs that an error breaks off: what was had is kept."""

from dataclasses import replace

import control
import handmade_fmus
import numpy as np
import pytest
from handmade_fmus import INERTIA, Model, fmu
from tiers import some

from jounce.fmu import FmuError, FmuTerminated, cosimulate, load_fmu
from jounce.plant import Inertia

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
ISOLATED = pytest.mark.parametrize("isolated", [False, True], ids=["inside", "isolated"])

# counts seconds, and ends at t = 2.5 whatever the step; it forgets to reset that it has ended
ENDING2 = """
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *x) {
    *x = k == fmi2Terminated && S(c)->x[1] > 0; return fmi2OK; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *x) {
    *x = S(c)->t; return k == fmi2LastSuccessfulTime ? fmi2OK : fmi2Error; }
"""
STEP = "if (t + h >= 2.5) {{ s->t = 2.5; y[0] = 2.5; x[1] = 1; return {}; }} y[0] = t + h;"
ENDING = {
    "2.0": Model("timer", states=2, step=STEP.format(2), epilogue=ENDING2, step_size=0.5),
    "3.0": Model("timer", states=2, step=STEP.format(100), step_size=0.5),
}


def ending(folder, version, **options):
    return load_fmu(fmu(folder, ENDING[version], version), **options)


@VERSIONS
@ISOLATED
@pytest.mark.parametrize(("dt", "rows"), some([(0.5, 6), (0.25, 11), (4.0, 1), (0.8, 4)], 2))
def test_the_rows_up_to_the_end_are_kept(tmp_path, version, isolated, dt, rows):
    with ending(tmp_path, version, isolated=isolated) as timer:
        run = cosimulate({"timer": timer}, (), dt=dt, duration=40 * dt)
        assert timer.time == 2.5
    np.testing.assert_allclose(run.time, dt * np.arange(rows), rtol=1e-12)
    np.testing.assert_allclose(run["timer.y"], run.time, rtol=1e-12)
    assert len(run["timer.u"]) == rows
    assert run.ended == "timer ended the simulation at time 2.5"
    assert run.ended in str(run)


@VERSIONS
def test_a_run_that_goes_through_has_no_ending(tmp_path, version):
    with ending(tmp_path, version) as timer:
        run = cosimulate({"timer": timer}, (), dt=0.5, duration=2.0)
        assert (run.ended, run["timer.y"].tolist()) == ("", [0.0, 0.5, 1.0, 1.5, 2.0])


@VERSIONS
@ISOLATED
def test_stepping_beyond_the_end(tmp_path, version, isolated):
    with ending(tmp_path, version, isolated=isolated) as timer:
        for _ in range(4):
            timer.step()
        for _ in range(2):
            with pytest.raises(FmuTerminated, match=r"at time 2\.5.*reset") as told:
                timer.step()
            assert (told.value.time, told.value.outputs.tolist()) == (2.5, [2.5])
        assert (timer.time, timer.get("y"), timer.outputs.tolist()) == (2.5, 2.5, [2.5])
        again = cosimulate({"timer": timer}, (), dt=0.5, duration=1.0)
        assert (again.time.tolist(), again.ended[:11]) == ([2.5], "timer ended")
        timer.reset()
        assert timer.step().tolist() == [0.5]


@VERSIONS
def test_the_others_stand_where_the_run_ended(tmp_path, version):
    with ending(tmp_path, version) as timer, load_fmu(fmu(tmp_path, version=version)) as plant:
        blocks = {"plant": plant, "timer": timer}
        run = cosimulate(blocks, [("timer.y", "plant.u")], dt=0.5, duration=9.0)
        assert (plant.time, timer.time, run.time[-1]) == (2.5, 2.5, 2.5)
        assert run["plant.u"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.0]


def test_a_discarded_step_is_an_error_that_says_how_far_it_came(tmp_path):
    epilogue = ENDING2.replace("k == fmi2Terminated && S(c)->x[1] > 0", "0")
    timer = load_fmu(fmu(tmp_path, replace(ENDING["2.0"], epilogue=epilogue)))
    with timer, pytest.raises(FmuError, match=r"discarded the call: it came to time 2\.5") as told:
        timer.step(dt=3.0)
    assert not isinstance(told.value, FmuTerminated)


def test_an_fmu_that_comes_back_early_is_stepped_on(tmp_path, monkeypatch):
    step = "    int status = advance(S(c), h, n);\n"
    assert step in handmade_fmus._FMI3
    early = "    if (h > 0.004) { h = 0.004; *early = 1; *last = t + h; }\n"
    monkeypatch.setattr(handmade_fmus, "_FMI3", handmade_fmus._FMI3.replace(step, early + step))
    with load_fmu(fmu(tmp_path, replace(INERTIA, name="early"), "3.0")) as plant:
        assert plant.step([1.0], 0.01) == pytest.approx([0.25e-4, 0.5e-2], rel=1e-12)
        assert plant.time == 0.01


@VERSIONS
@ISOLATED
@pytest.mark.parametrize("k", [0, 7])
def test_an_error_leaves_the_rows_before_it(tmp_path, version, isolated, k):
    broken = replace(
        INERTIA, name="broken", step=f"if (t > {k - 0.5} * 0.001) return 3;" + INERTIA.step
    )
    with load_fmu(fmu(tmp_path, broken, version), isolated=isolated) as plant:
        with pytest.raises(FmuError, match="could not step from time") as told:
            cosimulate({"plant": plant}, [(1.0, "plant.u")], dt=0.001, duration=1.0)
        run = told.value.result
        np.testing.assert_allclose(run.time, 0.001 * np.arange(k + 1), rtol=1e-12)
        np.testing.assert_allclose(run["plant.y"], 0.25 * run.time**2, rtol=1e-9)
        assert run["plant.u"].tolist() == [1.0] * (k + 1)
        with pytest.raises(FmuError, match=r"after the error at time .*call reset\(\) first"):
            plant.step()
        plant.reset()
        assert plant.time == 0.0


def test_an_error_before_the_first_row_leaves_none(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant, pytest.raises(FmuError) as told:
        cosimulate({"plant": plant}, [(1.0, "plant.v")], dt=0.001, duration=1.0)
    assert told.value.result is None


def test_what_leaves_the_range_of_a_double_leaves_the_rows_before():
    wild = control.ss([[1e30]], [[1.0]], [[1.0]], [[0.0]], 1.0, inputs="u", outputs="y")
    with pytest.raises(FmuError, match=r"wild\.y left the range of a double at time 12") as told:
        cosimulate({"wild": wild}, [(1.0, "wild.u")], dt=1.0, duration=500.0)
    run = told.value.result
    assert run.time.tolist() == list(range(12))
    assert np.isfinite(run["wild.y"]).all()


def test_native_blocks_never_end_a_run():
    run = cosimulate({"plant": Inertia(2.0)}, [(1.0, "plant.u")], dt=0.5, duration=1.0)
    assert run.ended == ""
