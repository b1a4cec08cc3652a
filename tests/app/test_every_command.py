"""What every command has: --json and --quiet; what is replaced, said in the help."""

import json
from dataclasses import replace

import pytest
from every_command import COMMANDS, command_of, options_of
from fmu_runs import DT
from good_scenario import GOOD
from handmade_fmus import INERTIA, fmu

from jounce.app import survey_file
from jounce.fmu.exporting import export_c as writing


@pytest.fixture(autouse=True)
def files(folder, monkeypatch):
    """Work beside a scenario and an FMU; measure no firmware."""
    (folder / "case.toml").write_text(GOOD, encoding="utf-8")
    fmu(folder, replace(INERTIA, step_size=DT)).rename(folder / "motor.fmu")
    monkeypatch.setattr(writing, "measure", lambda *_: None)
    return folder


CALLS = {
    "survey": ("survey", "case.toml"),
    "check": ("check", "case.toml", "--update"),
    "plan": ("plan", "60 arcsec", "--acceleration", "0.2 deg/s^2"),
    "schema": ("schema",),
    "completion": ("completion", "bash"),
    "fmu inspect": ("fmu", "inspect", "motor.fmu"),
    "fmu run": ("fmu", "run", "--no-isolated", "motor.fmu", "--step", DT, "--duration", "1"),
    "fmu export": ("fmu", "export", "case.toml", "--block", "filter", "--platform", "none"),
    "export c": ("export", "c", "case.toml", "--block", "filter", "--output", "made"),
}
ELSEWHERE = {"explore", "frf", "sweep"}  # with a server, measured data, an extra: their own tests


def test_every_command_can_print_json_and_be_quiet():
    assert set(CALLS) | ELSEWHERE == set(COMMANDS)
    for name in COMMANDS:
        assert {"--json", "--quiet", "-q"} <= options_of(name), name


@pytest.mark.parametrize("name", CALLS)
def test_json_is_all_that_is_printed(run, name):
    status, out, errors = run(*CALLS[name], "--json")
    assert (status, errors) == (0, [])
    assert json.loads(out)


@pytest.mark.parametrize("name", CALLS)
def test_quiet_prints_nothing_but_errors(run, name):
    assert run(*CALLS[name], "--quiet") == (0, "", [])
    status, out, errors = run(*CALLS[name], "--quiet", "--nonsense")
    assert (status, out, len(errors)) == (2, "", 1)
    assert run(*CALLS["plan"])[1]  # the next is as loud as ever


def test_quiet_leaves_json_and_the_exit_status(run):
    status, out, _ = run("survey", "case.toml", "--quiet", "--json")
    assert status == 0
    assert json.loads(out)["title"] == survey_file("case.toml").scenario.title
    run("check", "case.toml", "--update")
    change = ("--set", "controller.specification.phase_margin=40 deg")
    assert run("check", "case.toml", "--quiet", *change) == (1, "", [])


def test_a_run_has_where_its_outputs_start_and_end(run):
    """½·u/J·t² of J = 2 under u = 1."""
    _, out, _ = run(*CALLS["fmu run"], "--set", "u=1", "--json")
    told = json.loads(out)
    assert (told["start_s"], told["end_s"], told["ended"]) == (0.0, 1.0, None)
    assert told["steps"] == round(1.0 / DT)
    output = told["outputs"]["plant.y"]
    assert (output["start"], output["least"]) == (0.0, 0.0)
    assert output["end"] == output["greatest"] == pytest.approx(0.25)


def test_what_is_written_is_told(run, files):
    _, out, _ = run(*CALLS["fmu export"], "--json")
    assert json.loads(out)["path"] == "case_filter.fmu"
    _, out, _ = run(*CALLS["export c"], "--json")
    told = json.loads(out)
    assert set(told["files"]) == {
        path.relative_to(files / "made").as_posix()
        for path in (files / "made").rglob("*")
        if path.is_file()
    }


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_says_of_every_file_that_is_written_that_it_is_replaced(name):
    written = {"--output", "--csv", "--plot", "--junit"}
    for each in command_of(name).parameters:
        if set(each.names) & written and "position, velocity" not in each.told.help:
            assert "replaced" in each.told.help, (name, each.names)
