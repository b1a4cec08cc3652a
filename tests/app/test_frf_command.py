"""The command `jounce frf`: a table, JSON, a picture, exit statuses and refusals."""

import json
from pathlib import Path

import pytest
from command_lines import refused

FOLDER = Path(__file__).parents[1] / "data" / "measured"
STAGE = """
format = 2
title = "stage"
plant = { inertia = "2 kg" }
controller.sample_time = "0.25 ms"
controller.derivative_filter = "1 ms"
controller.gains = { kp = "3000 N/m", ki = "2e4 N/(m s)", kr = "100 N s/m" }
limits.axis = { velocity = "1 m/s", acceleration = "2 m/s^2" }
moves = [{name = "go", distance = "20 mm", settle_to = "1 mm"}]
"""


def test_the_margins_of_a_loop_are_printed_with_their_error_bars(run):
    file = FOLDER / "drive_loop_db_deg.csv"
    status, out, errors = run("frf", file, "--kind", "loop", "--averages", 20)
    assert (status, errors) == (0, [])
    assert "phase margin [deg]" in out
    assert "60.111 ±" in out
    assert "\nstable\n" in out


def test_json_is_all_that_is_printed_where_it_is_asked_for(run, tmp_path):
    file = FOLDER / "drive_coarse_2hz.csv"
    picture = tmp_path / "loop.png"
    status, out, _ = run("frf", file, "--kind", "loop", "--json", "--plot", picture)
    assert status == 0
    assert json.loads(out)["phase_margin_deg"] == pytest.approx(16.5976, rel=3e-3)
    assert picture.stat().st_size > 10_000


def test_an_unstable_loop_fails(run):
    status, out, _ = run("frf", FOLDER / "stage_gain_up_4x.csv", "--kind", "loop")
    assert status == 1
    assert "UNSTABLE" in out


def test_a_plant_is_judged_with_the_controller_of_a_scenario(run, tmp_path):
    scenario = tmp_path / "stage.toml"
    scenario.write_text(STAGE, encoding="utf-8")
    file = FOLDER / "stage_plant_frf.csv"
    status, out, errors = run("frf", file, "--kind", "plant", "--controller", scenario)
    assert (status, errors) == (0, [])
    assert "gain crossovers [Hz]: " in out
    status, out, _ = run("frf", file, "--kind", "plant", "--json")
    assert json.loads(out)["lines"] == 1399


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("none.csv", "--kind", "loop"), "cannot be read"),
        (("drive_coarse_2hz.csv", "--kind", "open"), "kind = 'open'"),
        (("drive_coarse_2hz.csv", "--kind", "process-sensitivity"), "without a controller"),
        (("drive_coarse_2hz.csv", "--kind", "loop", "--plot", "a.gif"), "a.gif"),
    ],
)
def test_wrong_input_is_told_in_one_line(words, told, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert told in refused(run, tmp_path, "frf", FOLDER / words[0], *words[1:])


@pytest.mark.parametrize("options", [(), ("--controller", "stage.toml")], ids=["plant", "loop"])
def test_quiet_prints_json_alone_and_only_where_that_is_asked_for(run, folder, options):
    (folder / "stage.toml").write_text(STAGE, encoding="utf-8")
    call = ("frf", FOLDER / "stage_plant_frf.csv", "--kind", "plant", *options, "--quiet")
    assert run(*call) == (0, "", [])
    status, out, errors = run(*call, "--json")
    assert (status, errors) == (0, [])
    assert json.loads(out)
