"""`-` in the place of a file that is read is standard input."""

import io
import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from command_lines import refused
from fmu_runs import DT, ENDS
from good_scenario import GOOD
from handmade_fmus import INERTIA, fmu
from handmade_ssps import component, ssp, system

from jounce.app import load_scenario, survey_file

MOTOR = replace(INERTIA, step_size=DT)
MEASURED = Path(__file__).parents[1] / "data" / "measured"
CHECKS = "baseline = false\n[margins]\nphase_margin_deg = { min = 10 }\n"
RUN = ("fmu", "run", "--no-isolated", "--step", DT, "--duration", "1", "--json")

pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture
def given(monkeypatch):
    """Put a text or bytes into standard input."""

    def put(content):
        raw = content.encode() if isinstance(content, str) else content
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(raw)))

    return put


@pytest.mark.parametrize(
    "arguments",
    [
        ("survey", "-", "--json"),
        ("survey", "-"),
        ("fmu", "export", "-", "--block", "filter", "--platform", "none"),
    ],
)
def test_a_scenario_is_read_as_from_its_file(run, given, folder, arguments):
    (folder / "scenario.toml").write_text(GOOD, encoding="utf-8")
    expected = run(*(str(word).replace("-", "scenario.toml") if word == "-" else word
                     for word in arguments))  # fmt: skip
    given(GOOD)
    status, out, errors = run(*arguments)
    assert (status, out.replace('"-"', '"scenario.toml"'), errors) == expected


def test_what_is_wrong_with_it_is_told_of_standard_input(run, given, folder):
    for text, told in (("plant = 3", "plant"), ("not toml", "not TOML"), ("", "holds no scenario")):
        given(text)
        status, out, errors = run("survey", "-")
        assert (status, out) == (2, "")
        assert all(line.startswith(("jounce: standard input: ", "standard input: "))
                   for line in errors)  # fmt: skip
        assert told in errors[0]
    assert not list(folder.iterdir())


def test_a_check_takes_its_files_from_there(run, given, folder):
    given(GOOD)
    assert "--baseline FILE" in refused(run, folder, "check", "-")
    given(GOOD)
    status, _, errors = run("check", "-", "--baseline", "case.json", "--update")
    assert (status, errors) == (0, [])
    given(GOOD)
    assert run("check", "-", "--baseline", "case.json")[0] == 0
    (folder / "case.toml").write_text(f'title = "scenario"\n{GOOD}', encoding="utf-8")
    given(Path("case.json").read_text(encoding="utf-8"))
    assert run("check", "case.toml", "--baseline", "-")[0] == 0
    given(CHECKS)
    status, out, errors = run("check", "case.toml", "--checks", "-")
    assert (status, errors) == (0, [])
    assert "1 within" in out


def test_one_file_alone_can_come_from_there(run, given, folder):
    given(GOOD)
    line = refused(run, folder, "check", "-", "--checks", "-", "--baseline", "b.json")
    assert "standard input is a scenario file (TOML) already" in line


def test_measured_responses_of_each_kind(run, given):
    for name, kind in (("stage_plant_frf.csv", "plant"), ("stage_ascii.uff", "plant")):
        _, expected, _ = run("frf", MEASURED / name, "--kind", kind, "--json")
        given((MEASURED / name).read_bytes())
        status, out, _ = run("frf", "-", "--kind", kind, "--json")
        assert (status, out) == (0, expected)
        assert json.loads(out)


def test_fmus_systems_and_their_inputs(run, given, folder):
    path = fmu(folder, MOTOR)
    inputs = "time,u\n0,1\n1,1\n"
    (folder / "in.csv").write_text(inputs, encoding="utf-8")
    _, expected, _ = run(*RUN, path, "--input", "in.csv")
    given(path.read_bytes())
    assert run(*RUN, "-", "--input", "in.csv")[:2] == (0, expected)
    given(inputs)
    assert run(*RUN, path, "--input", "-")[:2] == (0, expected)
    given(path.read_bytes())
    assert json.loads(run("fmu", "inspect", "-", "--json")[1])["variables"]
    whole = ssp(folder, system([component("a", ENDS)], [], []), {"a": MOTOR})
    given(whole.read_bytes())
    status, out, _ = run("fmu", "inspect", "-")
    assert (status, "SSP of 1 FMUs" in out) == (0, True)


def test_the_library_reads_it_too_and_again(given):
    given(GOOD)
    scenario = load_scenario("-")
    assert scenario.title == "scenario"
    assert (
        survey_file("-").margins.phase_margin_deg == survey_file(scenario).margins.phase_margin_deg
    )


def test_where_there_is_none_one_line_says_so(run, folder, monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    assert "there is no standard input" in refused(run, folder, "survey", "-")


@pytest.mark.parametrize(
    "arguments",
    [("frf", "-", "--kind", "plant"), ("fmu", "inspect", "-"), ("fmu", "run", "-")],
    ids=" ".join,
)
def test_no_copy_of_standard_input_is_named(run, given, folder, arguments):
    given("neither numbers nor an FMU")
    line = refused(run, folder, *arguments)
    assert line.startswith("jounce: standard input: ")
    assert "/" not in line


def test_a_sweep_file_in_which_nothing_varies(run, given, folder):
    (folder / "scenario.toml").write_text(GOOD, encoding="utf-8")
    given("")
    line = refused(run, folder, "sweep", "scenario.toml", "-", "--output", "out")
    assert "standard input: nothing varies" in line
