"""Points and bounds of a sweep that are odd, and what is said of them."""

import json
import sys
from io import BytesIO, TextIOWrapper
from pathlib import Path

import numpy as np
import pytest
import xarray
from swept_axis import AXIS

from jounce.analysis.sweep_result import SweepResult
from jounce.app import ScenarioSweep, Uniform, sweep, sweep_command
from jounce.app.sweeps.store import Store
from jounce.app.sweeps.sweep_file import read_sweep_file

QUICK = ("phase_margin", "crossover")


@pytest.fixture
def axis(tmp_path) -> Path:
    path = tmp_path / "axis.toml"
    path.write_text(AXIS, encoding="utf-8")
    return path


def of_values(design="sobol", parameters=("a",), **figures):
    """Return a result with these figures."""
    count = len(next(iter(figures.values())))
    columns = {name: ("point", np.arange(float(count))) for name in parameters}
    data = {name: ("point", np.array(values, dtype=float)) for name, values in figures.items()}
    data["failure"] = "point", np.full(count, "", dtype=object)
    data["done"] = "point", np.ones(count, dtype=bool)
    told = {"figures": list(figures), "parameters": list(parameters), "design": design}
    told |= {"requirements": "{}"}
    return SweepResult(xarray.Dataset(data, coords=columns, attrs=told))


@pytest.mark.parametrize("first", [0, 1])
def test_a_first_point_that_is_no_scenario_ends_nothing_either(axis, first):
    distances = ["0 deg", "90 deg"][:: 1 - 2 * first]
    found = sweep(axis, {"moves.quarter.distance": distances}, figures=QUICK, workers=1)
    [(point, reason)] = found.failures().items()
    assert point == first
    assert "'0 deg' is no move" in reason
    assert found.values("phase_margin")[1 - first] == pytest.approx(45.0, abs=1e-6)


def test_samples_and_counts_have_one_unit_in_the_singular_and_the_plural(axis):
    text = AXIS.replace("[limits.drive]", 'sample_time = "1 ms"\n[limits.drive]')
    axis.write_text(text, encoding="utf-8")
    delays = ["1 sample", "1.5 samples", "0.0 samples"]
    found = sweep(axis, {"controller.delay": delays}, figures=QUICK, workers=1)
    assert found.dataset["controller.delay"].values.tolist() == [1.0, 1.5, 0.0]
    assert found.failures() == {}
    assert Uniform("1 sample", "2 samples").at(0.5) == 1.5


@pytest.mark.parametrize(
    "wrong", [44, "44 deg", ("44 deg", None), (1.0, np.nan), (2.0, 1.0), {"min": 1}]
)
def test_bounds_that_are_none_are_refused_in_a_line(wrong):
    with pytest.raises(ValueError, match=r"^requirements\['phase_margin'\] = .* such as") as told:
        of_values(phase_margin=[40.0, 45.0]).met({"phase_margin": wrong})
    assert "\n" not in str(told.value)


def test_a_side_without_a_bound_is_none():
    found = of_values(phase_margin=[40.0, 45.0, np.nan, 50.0, np.inf])
    assert found.met({"phase_margin": (44, None)}).met == 3
    assert found.met({"phase_margin": (None, 44)}).met == 1


def test_the_interval_of_a_sample_for_sobol_s_indices_is_of_its_independent_points():
    whole = of_values("sensitivity", ("a", "b"), settling=np.tile([0.0, 1.0, 1.0, 1.0], 4))
    half = of_values(settling=np.tile([0.0, 1.0, 1.0, 1.0], 2))
    bounds = {"settling": (0.5, None)}
    assert (whole.met(bounds).met, whole.met(bounds).points) == (12, 16)
    assert whole.met(bounds).low == half.met(bounds).low
    assert whole.met(bounds).high == half.met(bounds).high


def test_indices_of_what_is_infinite_are_refused():
    endless = of_values("sensitivity", ("a", "b"), settling=np.full(16, np.inf))
    with pytest.raises(ValueError, match="missing or infinite at 16 points"):
        endless.influences("settling")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_picture_of_nothing_is_drawn(value):
    figure = of_values(settling=np.full(4, value)).plot()
    assert figure.axes[0].get_title() == "0 points, 4 without a finite value"


def test_a_key_is_shown_as_it_is_written(axis):
    keys = {"moves.quarter.settle_to": ["0.05 deg", "0.1 deg"]}
    figure = sweep(axis, keys, figures=["phase_margin"], workers=1).plot()
    assert "moves.quarter.settle_to [deg]" in {ax.get_xlabel() for ax in figure.axes}


@pytest.mark.parametrize("name", ["sweep.zarr", "sweep.nc"])
def test_a_sweep_that_is_done_is_returned_by_the_same_call(axis, tmp_path, monkeypatch, name):
    keys = {"plant.inertia": ["2 kg m^2", "3 kg m^2"]}
    before = sweep(axis, keys, figures=QUICK, workers=1, output=tmp_path / name)
    monkeypatch.setattr(Store, "write", None)
    again = sweep(axis, keys, figures=QUICK, workers=1, output=tmp_path / name)
    assert again.values("phase_margin").tolist() == before.values("phase_margin").tolist()
    with pytest.raises(ValueError, match="holds another sweep, of other figures"):
        sweep(axis, keys, figures=["crossover"], workers=1, output=tmp_path / name)


def test_a_damaged_sweep_is_told_in_a_line(axis, tmp_path):
    keys, folder = {"plant.inertia": ["2 kg m^2", "3 kg m^2"]}, tmp_path / "sweep.zarr"
    sweep(axis, keys, figures=QUICK, workers=1, output=folder)
    for chunk in (folder / "phase_margin").glob("[0-9]*"):
        chunk.write_bytes(b"garbage")
    for read in (
        lambda: sweep(axis, keys, figures=QUICK, workers=1, output=folder),
        lambda: ScenarioSweep.load(folder),
    ):
        with pytest.raises(ValueError, match=r"sweep\.zarr: is no sweep") as told:
            read()
        assert "\n" not in str(told.value)


def test_a_sweep_is_told_by_its_own_name(axis):
    found = sweep(axis, {"plant.inertia": ["2 kg m^2"]}, figures=QUICK, workers=1)
    assert repr(found).startswith("ScenarioSweep(1 of 1 point, parameters plant.inertia;")


@pytest.mark.parametrize("kind", ["log_uniform", "unifrom", "Normal"])
def test_a_range_of_a_kind_that_there_is_not_names_those_that_there_are(tmp_path, kind):
    path = tmp_path / "sweep.toml"
    path.write_text(
        f'[parameters]\n"plant.inertia" = {{ {kind} = ["1 kg m^2", "2 kg m^2"] }}\n',
        encoding="utf-8",
    )
    with pytest.raises(ValueError, match=r"sweep.toml: parameter plant.inertia = .* log-uniform ="):
        read_sweep_file(path)


def test_the_command_tells_what_matters_and_draws_all_over_all(axis, tmp_path, run, monkeypatch):
    asked = tmp_path / "sweep.toml"
    asked.write_text(
        'figures = ["phase_margin"]\nsamples = 4\ndesign = "sensitivity"\n[parameters]\n'
        'plant.inertia = { uniform = ["1.9 kg m^2", "2.1 kg m^2"] }\n'
        'plant.modes.top.damping = { uniform = ["1 %", "3 %"] }\n',
        encoding="utf-8",
    )
    arguments = ("sweep", axis, asked, "--output", tmp_path / "out", "--workers", 1)
    status, out, errors = run(*arguments)
    assert (status, errors) == (0, [])
    assert "Sobol's indices" in out
    assert (tmp_path / "out" / "scatter_matrix.png").exists()
    monkeypatch.setattr(sweep_command, "_write", lambda *_: [])  # pictures take their time
    indices = json.loads(run(*arguments, "--json")[1])["influences"]["phase_margin"]
    assert set(indices) == {"plant.inertia", "plant.modes.top.damping"}
    inertia, damping = (indices[key]["total"] for key in indices)
    assert inertia > 10.0 * damping
    status, _, errors = run(*arguments, "--scheduler", "tcp://127.0.0.1:1")
    assert (status, len(errors)) == (2, 1)
    assert "a cluster has its own" in errors[0]
    status, _, errors = run(*arguments[:-2], "--scheduler", "nonsense")
    assert (status, len(errors)) == (2, 1)
    assert "nobody answers there" in errors[0]
    assert "such as tcp://" in errors[0]


def test_a_sweep_file_that_is_not_there_is_told_before_its_baseline(axis, tmp_path, run):
    status, _, errors = run("check", axis, "--sweep", tmp_path / "none.toml")
    assert status == 2
    assert "none.toml: No such file or directory" in errors[0]


def test_what_an_extra_would_bring_is_told_in_a_line(axis, tmp_path, run, monkeypatch):
    asked = tmp_path / "sweep.toml"
    asked.write_text(
        'figures = ["crossover"]\n[parameters]\nplant.inertia = ["2 kg m^2"]\n', encoding="utf-8"
    )
    monkeypatch.setitem(sys.modules, "zarr", None)
    status, _, errors = run("sweep", axis, asked, "--output", tmp_path / "out", "--workers", 1)
    assert status == 2
    assert errors == ["jounce: a sweep needs xarray, zarr and dask: pip install 'jounce[sweep]'"]


RANGE = '[parameters]\n"plant.inertia" = ["1 kg m^2", "2 kg m^2"]\n'


@pytest.mark.parametrize(
    ("text", "more", "told"),
    [
        ('figures = ["load_setling"]\n' + RANGE, (), "did you mean 'load_settling'"),
        (
            'figures = ["friction_spike"]\n' + RANGE,
            (),
            "give the axis a friction, or leave the figure",
        ),
        ("samples = -4\n" + RANGE, (), "samples = -4: expected how many points"),
        (RANGE.replace("inertia", "inertias"), (), "override plant.inertias: unknown key"),
        (RANGE, ("--workers", "0"), "--workers 0: expected a whole number from 1 on"),
    ],
)
def test_what_a_sweep_file_asks_wrongly_is_told_in_a_line_with_its_name(
    axis, tmp_path, run, text, more, told
):
    file = tmp_path / "swept.toml"
    file.write_text(text, encoding="utf-8")
    status, _, errors = run("sweep", axis, file, "-o", tmp_path / "none", *more)
    assert (status, len(errors)) == (2, 1)
    assert told in errors[0]
    assert (f"{file}: " in errors[0]) == (not more)
    assert "requirement" not in errors[0]
    assert not (tmp_path / "none").exists()


def test_standard_input_for_both_files_is_refused_with_one_remedy(tmp_path, run, monkeypatch):
    monkeypatch.setattr(sys, "stdin", TextIOWrapper(BytesIO(RANGE.encode())))
    status, _, errors = run("sweep", "-", "-", "-o", tmp_path / "none")
    assert (status, len(errors)) == (2, 1)
    assert errors[0].count("name a scenario file (TOML)") == 1
