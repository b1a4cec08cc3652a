"""`jounce fmu run`: its options on FMUs written by hand, and one line for each error."""

import shutil
import zipfile
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from fmu_runs import DT, columns, rows
from handmade_fmus import Model, fmu
from handmade_ssps import (
    ADDER,
)

from jounce.app import fmu_run
from jounce.fmu.importing import unpacking


def test_inputs_come_from_a_file_in_the_units_that_it_names(run, plant):
    Path("in.csv").write_text("time [ms],u [kN]\n0,0\n500,2\n500,-1\n1000,-1\n", encoding="utf-8")
    status, out, errors = run(plant, "--input", "in.csv", "--duration", 1, "--csv", "out.csv")
    assert (status, errors) == (0, [])
    found = columns("out.csv")
    held = [0.0, 500.0, 1000.0, 1500.0] + [-1000.0] * 4
    np.testing.assert_allclose(found["plant.u"][:-1], held, rtol=1e-14)
    velocity = np.concatenate([[0.0], np.cumsum(held) * DT / 2.0])
    np.testing.assert_allclose(found["plant.y_rate"], velocity, rtol=1e-13)
    assert rows(out)["plant.y"][-1] == "m"
    assert "holds" not in out


def test_an_fmu_is_initialised_with_the_inputs_at_its_start(run, folder, whole):
    """What passes its input on shows it from the start, in an SSP, too."""
    Path("in.csv").write_text("time,u\n0,5\n1,5\n", encoding="utf-8")
    path = fmu(folder, replace(ADDER, step_size=DT))
    assert run(path, "--input", "in.csv", "--duration", 1, "--csv", "out.csv")[0] == 0
    assert columns("out.csv")["adder.y"].tolist() == [5.0] * 9
    Path("in.csv").write_text("time,angle\n0,180\n", encoding="utf-8")
    assert run(whole, "--input", "in.csv", "--csv", "out.csv")[0] == 0
    np.testing.assert_allclose(columns("out.csv")["a.y"], [pi + 1.0] * 9, rtol=1e-14)


def test_a_file_that_ends_early_is_held_and_that_is_told(run, plant):
    Path("in.csv").write_text("t,plant.u\n0,1\n0.25,3\n", encoding="utf-8")
    status, out, _ = run(plant, "--input", "in.csv", "--duration", 1, "--csv", "out.csv")
    assert status == 0
    assert "plant.u holds its last value from 0.25 on" in out
    assert columns("out.csv")["plant.u"].tolist() == [1.0, 2.0] + [3.0] * 7


def test_a_wrong_file_of_inputs_is_refused(refused, plant):
    Path("in.csv").write_text("time,force\n0,1\n", encoding="utf-8")
    assert "in.csv, line 1, column 2: no input 'force'" in refused(
        plant, "--input", "in.csv", "--duration", 1
    )
    assert "none.csv: No such file" in refused(plant, "--input", "none.csv", "--duration", 1)
    assert "is the file of --input" in refused(plant, "--input", "in.csv", "--csv", "in.csv")


def test_any_variable_is_recorded(run, plant):
    status, out, errors = run(
        plant, "--set", "u=2", "--duration", 1, "--record", "x1", "--record", "J",
        "--csv", "out.csv", "--plot", "out.svg",
    )  # fmt: skip
    assert (status, errors) == (0, [])
    found = columns("out.csv")
    np.testing.assert_allclose(found["plant.x1"], found["time"], rtol=1e-14)
    assert rows(out)["plant.J"] == ["2"] * 4
    assert "plant.x1" in Path("out.svg").read_text(encoding="utf-8")


def test_what_is_recorded_may_be_infinite(run, folder):
    limit = Model("limit", parameters={"k": 1.0}, states=1, step="x[0] = INFINITY;",
                  outputs_code="y[0] = p[0];", derivatives_code="dy[0] = 0;")  # fmt: skip
    status, out, errors = run(fmu(folder, limit), "--duration", 0.01, "--record", "x0")
    assert (status, errors) == (0, [])
    assert rows(out)["limit.x0"] == ["0", "inf", "0", "inf"]
    assert rows(out)["limit.y"] == ["1"] * 4


def test_the_stop_time_ends_the_run(run, refused, plant):
    status, out, _ = run(plant, "--stop-time", "500 ms")
    assert status == 0
    assert "From 0 s to 0.5 s in 4 steps" in out
    assert "in 2 steps" in run(plant, "--stop-time", 1, "--duration", 0.25)[1]
    line = refused(plant, "--stop-time", 0.5, "--duration", 1)
    assert "--duration 1 s from 0 s goes beyond --stop-time 0.5 s" in line
    assert "0.3 is 2.4 steps" in refused(plant, "--stop-time", 0.3)
    assert "--stop-time" in refused(plant, "--stop-time", "-1")
    assert "give --duration" in refused(plant)


def test_tolerance_and_stop_time_reach_the_fmu(run, folder):
    """The FMU's setup is made to show what it was told."""
    head = "e, fmi2Real stop) { S(c)->t = start;"
    told = Model(
        "told", states=1, outputs_code="y[0] = x[0];", step_size=DT,
        code=((head, f"{head} S(c)->x[0] = d ? tol + (e ? stop : 0) : -1;"),),
    )  # fmt: skip
    path = fmu(folder, told)
    for options, shown in (
        (["--tolerance", "0.5"], "0.5"),
        (["--tolerance", "0.5", "--stop-time", "4"], "4.5"),
        ([], "-1"),
    ):
        out = run(path, "--duration", 1, *options)[1]
        assert rows(out)["told.y"][0] == shown


def test_the_log_goes_to_the_error_output_on_demand(run, folder):
    """An FMU that logs at each step, if it is asked to."""
    head = "fmi2Real h, fmi2Boolean n) {"
    logs = 'i->call.logger(i->call.componentEnvironment, i->name, fmi2OK, "info", "stepped");'
    chatty = Model(
        "chatty", step_size=DT, code=((head, f"{head} Instance *i = c; {logs}"),)
    )  # fmt: skip
    path = fmu(folder, chatty)
    status, out, errors = run(path, "--duration", 0.25, "--log")
    assert (status, errors) == (0, ["jounce: chatty: stepped"] * 2)
    assert "stepped" not in out
    assert run(path, "--duration", 0.25)[2] == []


def test_a_limit_of_size_may_be_raised(run, refused, folder, monkeypatch):
    monkeypatch.setattr(unpacking, "FREE_BYTES", 2**20)
    path = fmu(folder, extra=[("resources/zeros", bytes(2**23))])
    line = refused(path, "--duration", 0.01)
    assert "--max-size" in line
    assert run(path, "--duration", 0.01, "--max-size", "2 GB")[0] == 0
    for wrong in ("0", "-1", "big", "1 m", "nan"):
        assert f"--max-size {wrong!r}: expected a number of bytes" in refused(
            path, "--max-size", wrong
        )


def test_a_folder_runs_like_its_archive(run, plant, folder):
    with zipfile.ZipFile(plant) as packed:
        packed.extractall(folder / "unpacked")
    options = ("--duration", 1, "--set", "u=1")
    assert run(folder / "unpacked", *options)[:2] == run(plant, *options)[:2]
    shutil.rmtree(folder / "unpacked")


def test_the_folder_of_an_ssp_runs_like_its_archive(run, whole, folder):
    with zipfile.ZipFile(whole) as packed:
        packed.extractall(folder / "unpacked")
    assert run(folder / "unpacked")[:2] == run(whole)[:2]
    (folder / "unpacked" / "SystemStructure.ssd").unlink()
    status, out, (line,) = run(folder / "unpacked")
    assert (status, out) == (2, "")
    assert "SystemStructure.ssd" in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("u", "NAME=VALUE"),
        ("J=one", "expected a number"),
        ("J=inf", "expected a number"),
        ("z=1", "no variable 'z'"),
        ("u=x", "expected a number, in N"),
    ],
)
def test_a_wrong_setting_is_refused(refused, plant, text, words):
    assert words in refused(plant, "--set", text, "--duration", 1)


def test_many_outputs_are_drawn_as_far_as_they_fit(run, folder, monkeypatch):
    monkeypatch.setattr(fmu_run, "_MAX_PANELS", 2)
    wide = Model("wide", outputs=tuple(f"y{i}" for i in range(4)), step_size=DT)
    status, out, errors = run(fmu(folder, wide), "--duration", 0.25, "--plot", "out.svg")
    assert (status, errors) == (0, [])
    assert "The picture shows the first 2 of 4 outputs" in out
    drawn = Path("out.svg").read_text(encoding="utf-8")
    assert "wide.y1" in drawn
    assert "wide.y2" not in drawn


def test_what_is_not_there_is_told_before_the_run(refused, folder, plant):
    nothing = folder / "nothing"
    nothing.mkdir()
    assert "a folder without a modelDescription.xml" in refused(nothing)
    line = refused(plant, "--duration", "1", "--plot", "no/such.png")
    assert "--plot no/such.png: No such file or directory" in line


def test_whole_numbers_are_shown_whole(run, folder):
    wide = Model("wide", outputs=("n",), types={"n": "Int64"}, step_size=DT, epilogue=COUNT)
    out = run(fmu(folder, wide, version="3.0"), "--duration", "0.5")[1]
    assert rows(out)["wide.n"][:4] == ["9007199254740993"] * 4


COUNT = """
fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Int64 x[],
    size_t s) { x[0] = 9007199254740993; return fmi3OK; }
"""


def test_one_fmu_by_itself_is_no_loop(run, folder):
    lost = Model("lost", step="y[0] = t > 0.2 ? 1e308 * 1e308 : 0;", step_size=DT)
    status, _, (line,) = run(fmu(folder, lost), "--duration", "1")
    assert status == 2
    assert "left the range of a double" in line
    assert "loop" not in line
