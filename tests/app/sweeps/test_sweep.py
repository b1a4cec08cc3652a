"""Sweeps of a scenario: their points, the numbers found there, and what they answer."""

import os
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray
from swept_axis import AXIS, INERTIA, QUICK

from jounce.app import LogUniform, Normal, ScenarioSweep, Uniform, survey_file, sweep
from jounce.app.scenario import read_content
from jounce.app.sweeps.figures import Problem
from jounce.app.sweeps.sweep_file import read_sweep_file
from jounce.app.sweeps.workers import _work_there

TELESCOPE = Path(__file__).parents[3] / "examples" / "telescope_azimuth.toml"
MARGINS = ("phase_margin", "lower_gain_margin", "modulus_margin", "delay_margin", "bandwidth")

whole = pytest.mark.skipif(
    os.environ.get("JOUNCE_TIER") != "slow", reason="starts processes anew: in make test-slow"
)


def test_a_grid_has_every_value_with_every_other_and_the_survey_s_numbers(axis):
    keys = {
        "limits.drive.jerk": ["300 deg/s^3", "900 deg/s^3"],
        "plant.inertia": ["2 kg m^2", "3 kg m^2"],
    }
    found = sweep(
        axis, keys, figures=["load_settling", "phase_margin"], workers=1, hold_gains=False
    )
    data = found.dataset
    assert data["limits.drive.jerk"].values.tolist() == [300.0, 300.0, 900.0, 900.0]
    assert data["plant.inertia"].values.tolist() == [2.0, 3.0, 2.0, 3.0]
    assert data["plant.inertia"].attrs["units"] == "kg m^2"
    assert data["load_settling"].attrs["units"] == "s"
    alone = survey_file(
        axis, overrides={"limits.drive.jerk": "900 deg/s^3", "plant.inertia": "3 kg m^2"}
    )
    assert data["load_settling"].values[3] == alone.moves[0].configured.load_settling_time_s
    assert data["phase_margin"].values[3] == alone.margins.phase_margin_deg


def test_the_example_of_a_sweep_file_is_swept():
    asked = read_sweep_file(TELESCOPE.with_suffix(".sweep.toml")) | {"samples": 2}
    found = sweep(TELESCOPE, **asked, workers=1)
    assert found.dataset.sizes["point"] == 2
    assert [name for name in asked["figures"] if np.isfinite(found.values(name)).all()] == (
        asked["figures"]
    )


def test_gains_are_held_where_the_plant_varies(axis):
    inertias = ["1 kg m^2", "2 kg m^2", "4 kg m^2"]
    held = sweep(axis, {"plant.inertia": inertias}, figures=QUICK, workers=1)
    anew = sweep(axis, {"plant.inertia": inertias}, figures=QUICK, workers=1, hold_gains=False)
    assert held.values("crossover")[0] > 1.5 * held.values("crossover")[2]
    assert held.values("crossover")[1] == pytest.approx(2.0, rel=1e-6)
    assert anew.values("crossover") == pytest.approx([2.0, 2.0, 2.0], rel=1e-6)


def test_the_worst_case_is_a_file_that_gives_its_figures(axis, tmp_path):
    found = sweep(axis, INERTIA, figures=QUICK, samples=8, workers=1)
    case = found.worst("phase_margin")
    assert case.figures["phase_margin"] == found.values("phase_margin").min()
    case.save(tmp_path / "worst.toml")
    alone = survey_file(tmp_path / "worst.toml")
    assert alone.margins.phase_margin_deg == case.figures["phase_margin"]
    assert case.scenario.inertia == pytest.approx(found.dataset["plant.inertia"].values[case.point])
    for refused, told in (
        (lambda: found.case(8), "0 to 7"),
        (lambda: found.case("1"), "point = '1'"),
        (lambda: found.worst("crossover", "upper"), "side = 'upper'"),
    ):
        with pytest.raises(ValueError, match=told):
            refused()
    with pytest.raises(FileExistsError):
        case.save(tmp_path / "worst.toml")


def test_the_numbers_are_the_same_bits_whichever_points_are_worked_out_together():
    keys = ("plant.inertia", "plant.modes.structure.frequency", "controller.delay")
    problem = Problem(TELESCOPE, read_content(TELESCOPE), keys, (*MARGINS, "load_settling"))
    points = [
        *(("900 kg m^2", "6.1 Hz", "1.2 samples"), ("1100 kg m^2", "5.8 Hz", "1.8 samples")),
        *(("1000 kg m^2", "6 Hz", "2 samples"), ("1 kg m^2", "6 Hz", "2 samples")),
        *(("-1 kg m^2", "6 Hz", "2 samples"), ("950 kg m^2", "6.05 Hz", "1.3 samples")),
    ]
    sent = pickle.dumps(problem)
    found = []
    for size in (1, 4, 6):
        there = pickle.loads(sent)
        batches = [points[k : k + size] for k in range(0, len(points), size)]
        found.append([row for batch in batches for row in _work_there(there, 0, batch)[1]])
    assert [bool(failure) for _, failure in found[0]] == [False, False, False, True, True, False]
    assert repr(found[1]) == repr(found[0])
    assert repr(found[2]) == repr(found[0])


def test_a_sweep_warns_once_of_what_all_its_points_have(axis):
    digital = AXIS.replace('gains = "design"', 'gains = "design"\nsample_time = "1 ms"')
    filters = '[[controller.filters]]\nkind = "low-pass"\ncorner = "450 Hz"\n'
    axis.write_text(digital.replace("[limits", filters + "[limits"), encoding="utf-8")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = sweep(axis, INERTIA, figures=QUICK, samples=4, workers=1)
    assert not found.failures()
    (message,) = (str(each.message) for each in told)
    assert message.startswith(f"{axis}: controller.filters[0]: LowPass at 450 Hz, 0.9 of the")


@whole
def test_the_numbers_do_not_depend_on_how_many_processes_there_are(axis):
    here = sweep(axis, INERTIA, figures=QUICK, samples=8, workers=1)
    there = sweep(axis, INERTIA, figures=QUICK, samples=8, workers=2)
    assert here.dataset.drop_vars("failure").equals(there.dataset.drop_vars("failure"))


def test_a_point_that_fails_is_told_and_ends_nothing(axis):
    found = sweep(axis, {"plant.inertia": ["2 kg m^2", "1000 kg m^2"]}, figures=QUICK, workers=1)
    [(point, reason)] = found.failures().items()
    assert point == 1
    assert "UNSTABLE" in reason
    assert np.isnan(found.values("phase_margin")[1])
    assert (found.met().met, found.met().points) == (1, 2)
    html = found._repr_html_()
    for told in ("2 of 2", "1 of 2 points meet", "deg at plant.inertia = 2 kg m^2", ">failed<"):
        assert told in html


@pytest.mark.parametrize("wrong", [ZeroDivisionError("by 0"), KeyError("gone")])
def test_whatever_goes_wrong_at_a_point_is_told_there(axis, monkeypatch, wrong):
    from jounce.app.sweeps import figures

    honest = figures.servo_loop_of

    def failing(scenario, *more):
        if scenario.inertia == 3.0:
            raise wrong
        return honest(scenario, *more)

    monkeypatch.setattr(figures, "servo_loop_of", failing)
    keys = {"plant.inertia": ["2 kg m^2", "3 kg m^2", "2.5 kg m^2"]}
    found = sweep(axis, keys, figures=QUICK, workers=1)
    assert found.failures() == {1: f"{type(wrong).__name__}: {wrong}"}
    wrong = MemoryError()
    with pytest.raises(MemoryError):
        sweep(axis, keys, figures=QUICK, workers=1)


def test_margins_that_fail_at_one_point_leave_the_others_theirs(axis, monkeypatch):
    from jounce.analysis.margins import shared_margins

    honest, seen = shared_margins.without_cancelled, []

    def failing(loop):
        seen.append(loop)
        if len(seen) == 2:
            raise FloatingPointError("overflow")
        return honest(loop)

    monkeypatch.setattr(shared_margins, "without_cancelled", failing)
    found = sweep(axis, INERTIA, figures=QUICK, samples=4, workers=1)
    assert found.failures() == {1: "FloatingPointError: overflow"}


def test_sobol_s_indices_find_what_matters(axis):
    """Crossover of a held gain over J: k/J to first order, and nearly nothing of the mode."""
    keys = {
        "plant.inertia": LogUniform("1.8 kg m^2", "2.2 kg m^2"),
        "plant.modes.top.damping": Uniform("1 %", "3 %"),
    }
    found = sweep(axis, keys, figures=["crossover"], samples=16, design="sensitivity", workers=1)
    indices = found.influences("crossover")
    assert indices["plant.inertia"].first > 0.9
    assert indices["plant.modes.top.damping"].total < 0.05
    assert next(iter(found.swings("crossover"))) == "plant.inertia"
    with pytest.raises(ValueError, match="design='sensitivity'"):
        sweep(axis, INERTIA, figures=QUICK, samples=4, workers=1).influences("crossover")


def test_samples_have_the_distributions_asked_for():
    assert [Uniform("1 Hz", "3 Hz").at(f) for f in (0.0, 0.25, 1.0)] == [1.0, 1.5, 3.0]
    assert LogUniform(1.0, 100.0).at(0.5) == pytest.approx(10.0, rel=1e-14)
    assert Normal("6 Hz", "200 mHz").at(0.8413447460685429) == pytest.approx(6.2, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "nothing varies"),
        ({"plant.inertia": "2 kg m^2"}, "expected a list of values, or Uniform"),
        ({"plant.inertia": []}, "expected a list of values"),
        ({"plant.inertias": ["2 kg m^2"]}, "inertias"),
        ({"plant.inertia": ["2 kg m^2", "3 Hz"]}, "plant.inertia = '3 Hz'.* one kind"),
        ({"plant.inertia": ["2 kg m^2", "nan kg m^2"]}, "plant.inertia = '2 kg m"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(axis, given, told):
    with pytest.raises(ValueError, match=told) as refused:
        sweep(axis, given, figures=QUICK, workers=1)
    assert "\n" not in str(refused.value)


def test_other_bad_input_is_refused(axis):
    for asked, told in (
        ({"figures": ["settle"], "samples": 2}, "settle"),
        ({"figures": QUICK, "samples": 0}, "samples = 0"),
        ({"figures": QUICK, "samples": 4, "design": "grid"}, "leave samples out"),
        ({"figures": QUICK, "design": "grid"}, "which has no grid"),
        ({"figures": QUICK, "samples": 12, "design": "sensitivity"}, "such as 16"),
        ({"figures": QUICK, "samples": 4, "workers": 0}, "workers = 0"),
        ({"figures": QUICK, "samples": 4, "workers": True}, "workers = True"),
        ({"figures": QUICK, "samples": 4, "seed": None}, "seed = None"),
        ({"figures": [3], "samples": 4}, "figures: 3"),
        ({"figures": [], "samples": 4}, r"figures = \[\]: nothing is asked for"),
        ({"figures": ["nomove.load_settling"], "samples": 4}, "there is no 'nomove'"),
        ({"figures": ["disturbance_peak"], "samples": 4}, "no such figure"),
    ):
        with pytest.raises(ValueError, match=told):
            sweep(axis, INERTIA, **asked)
    with pytest.raises(ValueError, match="'2 Hz' and '1 s' in a range"):
        Uniform("2 Hz", "1 s")
    with pytest.raises(TypeError, match="parameter 3: expected a key as text"):
        sweep(axis, {3: ["2 kg m^2"]}, figures=QUICK)
    with pytest.raises(TypeError, match="dask"):
        sweep(axis, INERTIA, figures=QUICK, samples=4, client="tcp://host:8786")
    with pytest.raises(ValueError, match="high = '1 Hz'"):
        Uniform("2 Hz", "1 Hz")
    with pytest.raises(ValueError, match="positive value"):
        LogUniform("-1 Hz", "1 Hz")


def test_the_pareto_front_is_what_nothing_beats():
    generator = np.random.default_rng(3)
    x, y = generator.random((2, 200))
    data = xarray.Dataset(
        {"settling": ("point", x), "modulus_margin": ("point", y), "done": ("point", x > -1.0)},
        attrs={"figures": ["settling", "modulus_margin"], "parameters": ["a"], "design": "sobol"},
    )
    front = ScenarioSweep(data).pareto("settling", "modulus_margin")
    slow = [
        i for i in range(200) if not ((x < x[i]) & (y >= y[i]) | (x <= x[i]) & (y > y[i])).any()
    ]
    assert sorted(front["settling"].values) == sorted(x[slow])
