"""The commands `jounce fmu`: what they write and print, and one clear line for a wrong input."""

import csv
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from fmus import fmu_of, needs_compiler

from jounce.app import load_scenario
from jounce.app.scenario_blocks import trajectory_of
from jounce.app.scenario_loop import servo_loop_of
from jounce.fmu import CompilerError
from jounce.fmu.importing.reading import inspect_fmu
from jounce.plant import Inertia

SCENARIO = """
plant.inertia = "2 kg"
controller.gains = {kp = "90 N/m", ki = "60 N/(m s)", kr = "20 N s/m"}
filter = {corner = "20 Hz", order = 4}
limits.axis = {velocity = "1 m/s", acceleration = "2 m/s^2"}
"""
ONE_MOVE = SCENARIO + 'moves = [{name = "go", distance = "20 mm", settle_to = "1 mm"}]\n'
TWO_MOVES = (
    SCENARIO
    + 'moves = [{name = "out & in", distance = "20 mm", settle_to = "1 mm"}, '
    + '{name = "back", distance = "-10 mm", settle_to = "1 mm"}]\n'
)
SOURCES = ("--platform", "none")


def plant_of_two_kg():
    return Inertia(2.0)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Work in a folder that holds two scenarios."""
    monkeypatch.chdir(tmp_path)
    Path("axis.toml").write_text(ONE_MOVE, encoding="utf-8")
    Path("two.toml").write_text(TWO_MOVES, encoding="utf-8")
    return tmp_path


@pytest.fixture
def run(run):
    """Run a command of `jounce fmu`."""
    return partial(run, "fmu")


@pytest.fixture
def refused(run, folder):
    """Run what is refused; give its one line."""

    def call(*arguments: object) -> str:
        before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        status, out, errors = run(*arguments)
        assert (status, out) == (2, "")
        (line,) = errors
        assert line.startswith("jounce: ")
        assert {p: p.read_bytes() for p in folder.iterdir() if p.is_file()} == before
        return line

    return call


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("block", ["trajectory", "follower", "filter", "controller", "plant"])
def test_every_block_of_a_scenario_leaves(run, block, version):
    status, out, errors = run("export", "axis.toml", "--block", block, "--fmi", version, *SOURCES)
    assert (status, errors) == (0, [])
    assert out.startswith(f"Wrote axis_{block}.fmu: {block}, FMI {version}, no binary")
    found = inspect_fmu(f"axis_{block}.fmu")
    assert (found.fmi_version, found.platforms, found.has_sources) == (version, (), True)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_whole_loop_leaves_as_one_fmu(run, version):
    given = ("export", "axis.toml", "--block", "servo", "--fmi", version, "-o", "a.fmu", *SOURCES)
    status, out, errors = run(*given)
    assert (status, errors) == (0, [])
    assert out.startswith(f"Wrote a.fmu: servo, FMI {version}, no binary")
    units = {variable.name: variable.unit for variable in inspect_fmu("a.fmu").variables}
    assert (units["d"], units["y"], units["corner_hz"]) == ("N", "m", "Hz")


def test_what_leaves_is_what_the_scenario_says(run):
    for block in ("controller", "plant", "follower"):
        run("export", "axis.toml", "--block", block, "--sample-time", "2 ms", *SOURCES)
    start = {
        block: {v.name: (v.start, v.unit) for v in inspect_fmu(f"axis_{block}.fmu").variables}
        for block in ("controller", "plant", "follower")
    }
    assert start["plant"]["J"] == (2.0, "kg")
    assert start["controller"]["kp"] == (90.0, "N/m")
    assert start["controller"]["ki"] == (60.0, "N/m/s")
    assert start["controller"]["kr"] == (20.0, "N.s/m")
    assert start["controller"]["J_hat"] == (2.0, "kg")
    assert start["controller"]["sample_time"] == (0.002, "s")
    assert start["follower"]["velocity_max"] == (1.0, "m/s")
    assert start["follower"]["acceleration_min"] == (-2.0, "m/s2")
    assert start["follower"]["corner_hz"] == (20.0, "Hz")


def test_the_loop_leaves_as_an_ssp(run):
    status, out, _ = run("export", "two.toml", "--block", "loop", "--move", "back", *SOURCES)
    assert status == 0
    assert "two_loop_back.ssp" in out
    with zipfile.ZipFile("two_loop_back.ssp") as made:
        assert sorted(made.namelist()) == [
            "SystemStructure.ssd",
            *(f"resources/{name}.fmu" for name in ("controller", "filter", "plant", "shaper")),
        ]


@pytest.mark.parametrize("block", ["trajectory", "follower"])
def test_without_a_name_it_is_the_first_move(run, block):
    status, out, errors = run("export", "two.toml", "--block", block, *SOURCES)
    assert (status, errors) == (0, [])
    assert "The move is 'out & in', the first; --move takes another: 'back'" in out
    assert f"two_{block}.fmu" in out


def test_a_loop_without_move_takes_the_first_and_says_so(run):
    status, out, errors = run("export", "two.toml", "--block", "loop", *SOURCES)
    assert (status, errors) == (0, [])
    assert "The move is 'out & in', the first; --move takes another: 'back'" in out
    run("export", "two.toml", "--block", "loop", "--move", "out & in", *SOURCES)
    assert Path("two_loop.ssp").read_bytes() == Path("two_loop_out_in.ssp").read_bytes()
    assert "The move" not in run("export", "axis.toml", "--block", "loop", *SOURCES)[1]


def test_the_move_is_chosen_by_name(run, refused):
    status, out, _ = run(
        "export", "two.toml", "--block", "trajectory", "--move", "out & in", *SOURCES
    )
    assert status == 0
    assert "two_trajectory_out_in.fmu" in out
    end = inspect_fmu("two_trajectory_out_in.fmu").default_experiment.stop_time
    assert end == trajectory_of(load_scenario("two.toml"), "out & in").end_time
    line = refused("export", "two.toml", "--block", "trajectory", "--move", "away", *SOURCES)
    assert "has no move 'away'; give --move one of 'out & in', 'back'" in line


def test_the_same_export_twice_is_the_same_file(run):
    for name in ("a.fmu", "b.fmu"):
        run("export", "axis.toml", "--block", "plant", "-o", name, *SOURCES)
    assert Path("a.fmu").read_bytes() == Path("b.fmu").read_bytes()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--block", "plant", "--move", "go"), ["--move", "leave it out"]),
        (("--block", "plant", "-o", "plant.zip"), ["plant.zip", ".fmu"]),
        (("--block", "loop", "-o", "loop.fmu"), ["loop.fmu", ".ssp"]),
        (("--block", "plant", "-o", "no/such/folder.fmu"), ["no/such", "create it"]),
        (("--block", "controller", "--sample-time", "0"), ["--sample-time", "positive"]),
        (("--block", "controller", "--sample-time", "nan"), ["--sample-time", "positive"]),
        (("--block", "controller", "--sample-time", "1 kg"), ["--sample-time", "dimension"]),
        (("--block", "controller", "--sample-time", "soon"), ["--sample-time", "duration"]),
        (("--block", "plant", "--platform", "vax"), ["vax", "x86_64-linux"]),
        (("--block", "plant", *SOURCES, "--platform", "host"), ["none", "leave the other"]),
    ],
    ids=lambda value: None if isinstance(value, list) else " ".join(value),
)
def test_a_wrong_export_is_refused(refused, options, words):
    line = refused("export", "axis.toml", *options)
    assert all(word in line for word in words), line


def test_blocks_that_the_scenario_lacks_are_refused(refused, folder):
    plain = ONE_MOVE.replace("filter =", "#").replace('"2 m/s^2"}', '"2 m/s^2", snap = "9 m/s^4"}')
    (folder / "plain.toml").write_text(plain, encoding="utf-8")
    assert "no [filter]" in refused("export", "plain.toml", "--block", "filter")
    assert "order 4" in refused("export", "plain.toml", "--block", "follower")
    assert "no.toml" in refused("export", "no.toml", "--block", "filter")


def test_options_that_do_not_exist_are_refused(run):
    for options in (["--block", "motor"], ["--block", "plant", "--fmi", "1.0"], []):
        status, out, errors = run("export", "axis.toml", *options)
        assert (status, out) == (2, "")
        assert any("--block" in line or "--fmi" in line for line in errors)


@pytest.mark.parametrize("error", [CompilerError, ModuleNotFoundError])
def test_what_the_machine_lacks_is_told_in_one_line(refused, monkeypatch, error):
    def fail(*_, **__):
        raise error("cc refused:\n  line 1")

    monkeypatch.setattr("jounce.app.scenario_blocks.export_fmu", fail)
    assert "cc refused: line 1" in refused("export", "axis.toml", "--block", "plant")


def test_inspect_tells_variables_units_and_digest(run):
    run("export", "axis.toml", "--block", "controller", "--fmi", "3.0", *SOURCES)
    status, out, errors = run("inspect", "axis_controller.fmu")
    assert (status, errors) == (0, [])
    rows = {row[0]: row[1:] for row in map(str.split, out.splitlines()) if row}
    assert rows["kp"][:2] == ["90", "N/m"]
    assert rows["sha256"] == [inspect_fmu("axis_controller.fmu").sha256]
    assert rows["binaries"] == ["none"]
    assert "e_integral" not in rows
    assert max(map(len, out.splitlines())) <= 160
    assert "e_integral" in run("inspect", "axis_controller.fmu", "--local")[1]


def test_inspect_refuses_what_is_no_fmu(refused, folder):
    (folder / "text.fmu").write_text("no archive", encoding="utf-8")
    assert "text.fmu" in refused("inspect", "text.fmu")
    assert "missing.fmu" in refused("inspect", "missing.fmu")


@needs_compiler
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_run_steps_the_fmu(run, version):
    path = fmu_of(plant_of_two_kg, version)
    options = ("--duration", "2", "--step", "500 ms", "--set", "u=-3", "--set", "y=1")
    status, out, errors = run("run", path, *options, "--csv", "y.csv", "--plot", "y.png")
    assert (status, errors) == (0, [])
    rows = {row[0]: row[1:] for row in map(str.split, out.splitlines()) if row}
    assert [float(value) for value in rows["inertia.y"][:4]] == [1.0, -2.0, -2.0, 1.0]
    assert [float(value) for value in rows["inertia.y_rate"][:4]] == [0.0, -3.0, -3.0, 0.0]
    with Path("y.csv").open(newline="", encoding="utf-8") as file:
        header, *table = csv.reader(file)
    columns = dict(zip(header, np.array(table, dtype=float).T, strict=True))
    time = columns["time"]
    np.testing.assert_array_equal(time, [0.0, 0.5, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(columns["inertia.y"], 1.0 - 0.75 * time**2, rtol=1e-14)
    np.testing.assert_array_equal(columns["inertia.u"], -3.0)
    assert Path("y.png").read_bytes().startswith(b"\x89PNG")


@needs_compiler
def test_run_takes_the_experiment_of_the_fmu(run):
    path = fmu_of(plant_of_two_kg, "2.0")
    experiment = inspect_fmu(path).default_experiment
    status, out, _ = run("run", path, "--set", "y_rate=1")
    assert status == 0
    steps = round(experiment.stop_time / experiment.step_size)
    assert f"to {experiment.stop_time:g} s in {steps} steps" in out


@needs_compiler
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--set", "u"), ["--set", "NAME=VALUE"]),
        (("--set", "torque=1"), ["no variable 'torque'"]),
        (("--set", "u=one"), ["'u=one'", "expected a number"]),
        (("--set", "u=nan"), ["'u=nan'", "expected a number"]),
        (("--set", "J=1,2"), ["'J=1,2'", "expected a number"]),
        (("--set", "der(y)=1"), ["cannot be set"]),
        (("--set", "J=-1"), ["J = -1", "could not"]),
        (("--step", "-1"), ["--step", "positive"]),
        (("--duration", "inf"), ["--duration", "positive"]),
        (("--duration", "1", "--step", "0.3"), ["0.3", "whole number"]),
        (("--sha256", "00"), ["sha256", "pinned"]),
        (("--plot", "y.txt"), ["y.txt", ".png"]),
        (("--csv", "y.png", "--plot", "y.png"), ["name two files"]),
        (("--csv", "no/such.csv"), ["no/such.csv", "No such file"]),
    ],
    ids=lambda value: None if isinstance(value, list) else " ".join(value),
)
def test_a_wrong_run_is_refused(refused, options, words):
    line = refused("run", fmu_of(plant_of_two_kg, "2.0"), *options)
    assert all(word in line for word in words), line


@needs_compiler
def test_run_does_not_write_over_the_fmu(refused, folder):
    (folder / "p.fmu").write_bytes(fmu_of(plant_of_two_kg, "2.0").read_bytes())
    assert "p.fmu" in refused("run", "p.fmu", "--csv", "p.fmu")


def test_a_source_only_fmu_does_not_run(run, refused):
    run("export", "axis.toml", "--block", "plant", *SOURCES)
    assert "no binary" in refused("run", "axis_plant.fmu")


def test_the_blocks_are_those_of_the_survey():
    loop = servo_loop_of(load_scenario("axis.toml"))
    assert (loop.plant.J, loop.controller.kp, loop.feedforward.J_hat) == (2.0, 90.0, 2.0)


def test_the_help_loads_no_simulation():
    code = (
        "import sys; import jounce.app.command_line; "
        "heavy = 'control', 'fmpy', 'matplotlib', 'scipy', 'jounce.fmu.importing.load'; "
        "print([m for m in heavy if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert found.stdout.strip() == "[]"
