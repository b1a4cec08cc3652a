"""The command line: what is printed, what is written, and one clear line for a wrong input."""

import csv
import io
import json
import math
import re
import subprocess
import sys
import warnings
from pathlib import Path
from xml.etree import ElementTree

import control
import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from jounce.analysis import loop_margins
from jounce.app import command_line

EXAMPLES = Path(__file__).parents[2] / "examples"
MOVE = ("plan", "60 arcsec")
LIMIT = ("--acceleration", "0.2 deg/s^2")
CURVE = ("--velocity", "0.1 deg/s", *LIMIT)
UNSTABLE = """
plant.inertia = "1 kg m^2"
controller.gains = {kp = "28 N m/rad", ki = "38 N m/(rad s)", kr = "1 N m s/rad"}
limits.axis = {acceleration = "0.2 deg/s^2"}
moves = [{name = "go", distance = "60 arcsec", settle_to = "50 mas"}]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


@pytest.fixture
def quick(monkeypatch):
    """Save empty pictures, where the picture is not the point."""
    monkeypatch.setattr(Figure, "savefig", lambda *args, **_: Path(args[1]).write_bytes(b"picture"))


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def refused(run, folder: Path, *arguments: object) -> str:
    """Return the one line of a refusal that printed and wrote nothing else."""
    before = names(folder)
    status, out, errors = run(*arguments)
    assert (status, out) == (2, "")
    (line,) = errors
    assert line.startswith("jounce: ")
    assert names(folder) == before
    return line


def test_plan_prints_thompsons_values(run, folder):
    status, out, errors = run(*MOVE, *LIMIT)
    assert (status, errors) == (0, [])
    assert "0.5773502692 s" in out
    assert "0.288675135" in out
    assert "207.846097" in out
    assert names(folder) == set()


def test_plan_goes_backwards_and_from_a_start(run):
    status, out, _ = run("plan", "-60 arcsec", *LIMIT, "--start", "-1 arcmin")
    assert status == 0
    last = [line.split() for line in out.splitlines() if line.strip()][-1]
    assert last[:2] == ["0.577350269", "-120"]


def test_plan_goes_from_one_position_to_another(run):
    _, there, _ = run("plan", "--from", "-1 arcmin", "--to", "-120 arcsec", *LIMIT)
    _, same, _ = run("plan", "-60 arcsec", *LIMIT, "--start", "-1 arcmin")
    assert there == same
    status, out, errors = run("plan", "--from", "1 mm", *LIMIT)
    assert (status, out) == (2, "")
    assert errors == ["jounce: no distance is given: write one such as '60 arcsec', or where to "
                      "go, --to '60 arcsec'"]  # fmt: skip


RATES = ("--velocity", "4 mm/s", "--acceleration", "8 mm/s^2", "--decel", "2 mm/s^2")


def test_plan_takes_a_deceleration_and_a_jerk_percent(run):
    """By hand: 0.5 s up to 4, 2 s down, and 3 mm in between; peaks are 1/(1 − 0.25) higher."""
    move = ("plan", "--from", "10 mm", "--to", "2 mm", *RATES, "--jerk-percent")
    for percent in ("50 %", "50"):
        status, out, errors = run(*move, percent, "--csv", "move.csv")
        assert (status, errors) == (0, [])
        assert "Move of order 3, 3.25 s" in out
        assert "-10.6666667 … 2.66666667" in out
        assert "Slowing down: 2 mm/s^2, jerk percent 50 %, which keeps the duration" in out
        header, *rows = list(csv.reader(Path("move.csv").read_text().splitlines()))
        assert [float(x) for x in rows[-1][:3]] == pytest.approx([3.25, 2.0, 0.0], abs=1e-12)
        assert len(header) == 5
    _, out, _ = run(*move, "50 %", "--percent-keeps", "acceleration")
    assert "Move of order 3, 3.666666667 s" in out  # ramps of 10/3 s, and 4/3 mm between
    assert "8 mm/s^2, jerk percent 50 %, which keeps the acceleration" in out
    _, out, _ = run(*move, "0 %")
    assert re.search(r"jerk +0 ", out)


def test_plan_takes_four_rates(run):
    jerks = ("--jerk", "40 mm/s^3", "--deceleration-jerk", "10 mm/s^3")
    status, out, errors = run("plan", "20 mm", *RATES, *jerks)
    assert (status, errors) == (0, [])
    up, down = 0.5 + 0.2, 2.0 + 0.2
    assert f"Move of order 3, {up + down + (20.0 - 2.0 * (up + down)) / 4.0:.10g} s" in out
    assert "-2 … 8" in out
    assert "Slowing down: 2 mm/s^2, jerk 10 mm/s^3" in out
    _, out, _ = run("plan", "20 mm", *RATES, "--jerk", "0.5 mm/s^3")
    assert "acceleration_jerk = 0.5 is below acceleration²/velocity = 16: " in out


def test_plan_takes_pairs_of_bounds(run):
    status, out, _ = run(*MOVE, "--acceleration", "-0.1 deg/s^2, 0.2 deg/s^2")
    assert status == 0
    expected = math.sqrt(2 * 60 / 3600 * 15)
    assert f"{expected:.10g} s" in out


@pytest.mark.parametrize("key", ["7", "jerk", " jerk "])
def test_plan_takes_any_derivative(run, key):
    k, divisor = (7, 2949120) if key == "7" else (3, 32)
    status, out, _ = run("plan", "2 mm", "--limit", f"{key}=3e3 mm/s^{k}")
    assert status == 0
    assert f"{(2 * divisor / 3e3) ** (1 / k):.10g} s" in out


def test_plan_takes_several_limits(run):
    _, both, _ = run("plan", "2 mm", "--limit", "1=1 mm/s", "--limit", "2=5 mm/s^2")
    _, named, _ = run("plan", "2 mm", "--velocity", "1 mm/s", "--acceleration", "5 mm/s^2")
    assert both == named
    assert "2.2 s" in both


def test_plan_takes_a_rise_time(run):
    status, out, _ = run(
        "plan", "600 deg", *LIMIT, "--rise-time", "1 s", "--order", "6", "--closed-form"
    )
    assert status == 0
    row = next(line.split() for line in out.splitlines() if line.split()[:1] == ["pop"])
    assert row[1:3] == ["76.8", "76.8"]


def test_plan_proves_how_near_the_minimum_time_it_is(run):
    """Half of the time of an acceleration-limited move hangs on the limit: T = 2√(R/A)."""
    status, out, errors = run(*MOVE, *LIMIT, "--certify")
    assert (status, errors) == (0, [])
    rows = [line.split() for line in out.splitlines()]
    assert ["duration", "0.5773502692", "s"] in rows
    assert ["proven", "minimum", "0.5773502692", "s"] in rows
    assert "raising acceleration by 1 %     saves 0.50 %" in out


def test_plan_goes_faster_than_the_closed_forms(run):
    limits = ("--velocity", "2 deg/s", "--acceleration", "1 deg/s^2", "--jerk", "2 deg/s^3")
    move = ("plan", "0.5 deg", *limits, "--snap", "8 deg/s^4", "--crackle", "40 deg/s^5")
    durations = []
    for options in (("--closed-form",), ("--certify",)):
        status, out, errors = run(*move, *options)
        assert (status, errors) == (0, [])
        durations.append(float(out.split("Move of order 5, ")[1].split()[0]))
    closed, optimal = durations
    proven = float(out.split("proven minimum")[1].split()[0])
    assert proven <= optimal < closed * (1 - 1e-3)
    assert optimal < proven * 1.001


def test_plan_warns_in_one_line_where_it_returns_a_closed_form(run):
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        status, out, errors = run("plan", "9 mm", "--limit", "2=1 mm/s^2", "--limit", "11=9 m/s^11")
    assert status == 0
    assert "Move of order 11" in out
    assert len(errors) == 1, errors
    assert errors[0].startswith("jounce: warning: order 11 is above 10")


def test_plan_cuts_no_number_off(run):
    status, out, _ = run("plan", "60 arcsec", *LIMIT, "--rise-time", "1 s", "--order", "6")
    assert status == 0
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= 160


def test_plan_prints_many_pieces_when_asked(run):
    move = ("plan", "60 arcsec", *LIMIT, "--rise-time", "1 s", "--order", "6", "--closed-form")
    _, short, _ = run(*move)
    _, long, _ = run(*move, "--pieces")
    assert "Switch table" not in short
    assert "--pieces prints them" in short
    assert "% of the time" in short
    assert "Switch table" in long
    assert long.startswith(short[: short.index("pieces; --pieces")].rsplit("\n", 1)[0])


def test_plan_names_the_units_of_its_columns(run):
    _, out, _ = run("plan", "2 mm", "--limit", "3=40 mm/s^3")
    assert "time [s]" in out
    assert "[mm/s^3]" in out


def test_plan_writes_every_digit(run, folder):
    status, out, _ = run(*MOVE, "--limit", "3=1 deg/s^3", *LIMIT, "--csv", "move.csv")
    assert status == 0
    assert "move.csv" in out
    assert names(folder) == {"move.csv"}
    with Path("move.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == ["time [s]", "position [arcsec]", "velocity [arcsec/s]",
                      "acceleration [arcsec/s^2]", "jerk [arcsec/s^3]"]  # fmt: skip
    # Thompson III, case 2: t_w = 0.2 s.
    total = 0.2 + math.sqrt(0.04 + 4 * 60 / 720)
    case_2 = [0.0, 0.2, total / 2 - 0.2, total / 2 + 0.2, total - 0.2, total]
    table = np.array(rows, dtype=float)
    np.testing.assert_allclose(table[:, 0], case_2, rtol=1e-14)
    assert table[-1, 1:] == pytest.approx([60, 0, 0, 0], abs=1e-10)
    assert table[1, 3] == pytest.approx(720, rel=1e-14)
    assert table[:-1, 4] == pytest.approx([3600, 0, -3600, 0, 3600])


@pytest.mark.parametrize("name", ["move.png", "move.pdf", "move.svg"])
def test_plan_draws(run, folder, name):
    status, out, _ = run(*MOVE, *LIMIT, "--plot", name)
    assert status == 0
    assert name in out
    assert names(folder) == {name}
    start = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}[Path(name).suffix]
    assert Path(name).read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), ["limit", "--acceleration"]),
        (("--acceleration", "0.2"), ["acceleration", "no unit"]),
        (("--acceleration", "0.2 mm/s^2"), ["acceleration", "dimension"]),
        (("--velocity", "nan deg/s"), ["velocity", "not finite"]),
        (("--velocity", "inf deg/s"), ["velocity", "not finite"]),
        (("--velocity", "-1 deg/s"), ["velocity", "positive"]),
        (("--limit", "7"), ["--limit", "'7'"]),
        (("--limit", "=1 deg/s"), ["derivative"]),
        (("--limit", "0=1 deg"), ["derivative", "'0'"]),
        (("--limit", "15=1 deg/s^15"), ["derivative", "'15'"]),
        (("--limit", "lock=1 deg/s^6"), ["derivative", "'lock'"]),
        (("--limit", "7="), ["derivative 7"]),
        ((*LIMIT, "--limit", "2=1 deg/s^2"), ["already", "2"]),
        (("--limit", "7=1 deg/s^7", "--limit", "7=2 deg/s^7"), ["already", "7"]),
        ((*LIMIT, "--rise-time", "1 s"), ["order"]),
        ((*LIMIT, "--order", "6"), ["rise time"]),
        (("--rise-time", "1 s", "--order", "6"), ["acceleration"]),
        ((*LIMIT, "--rise-time", "1 mm", "--order", "6"), ["rise time", "dimension"]),
        ((*LIMIT, "--start", "1 mm"), ["start", "dimension"]),
        ((*LIMIT, "--from", "1 mm"), ["start", "dimension"]),
        ((*LIMIT, "--to", "1 deg"), ["distance", "--to", "one or the other"]),
        ((*CURVE, "--decel", "1 deg/s"), ["deceleration", "dimension"]),
        ((*CURVE, "--decel", "-1 deg/s^2"), ["deceleration", "positive"]),
        ((*CURVE, "--decel", "1 deg/s^2"), ["--jerk", "--jerk-percent"]),
        ((*CURVE, "--jerk-percent", "0.5"), ["jerk percent", "'0.5'", "50 %"]),
        ((*CURVE, "--jerk-percent", "120"), ["jerk percent", "'120'", "0 to 100 %"]),
        ((*CURVE, "--jerk-percent", "-5 %"), ["jerk percent", "0 to 100 %"]),
        ((*CURVE, "--jerk-percent", "nan"), ["jerk percent", "not finite"]),
        ((*CURVE, "--jerk-percent", "half"), ["jerk percent", "50 %"]),
        ((*CURVE, "--jerk-percent", "50 %", "--jerk", "1 deg/s^3"), ["in place of a jerk"]),
        ((*CURVE, "--jerk-percent", "5 %", "--deceleration-jerk", "1 deg/s^3"), ["in place of"]),
        ((*CURVE, "--jerk-percent", "50 %", "--percent-keeps", "jerk"), ["'duration' or 'acc"]),
        ((*CURVE, "--jerk", "1 deg/s^3", "--percent-keeps", "duration"), ["--jerk-percent"]),
        ((*LIMIT, "--jerk-percent", "50 %"), ["--velocity", "deg/s"]),
        (("--velocity", "1 deg/s", "--jerk-percent", "50 %"), ["--acceleration", "deg/s^2"]),
        ((*CURVE, "--jerk-percent", "50 %", "--certify"), ["--certify", "S-curve"]),
        ((*CURVE, "--jerk-percent", "50 %", "--limit", "4=1 deg/s^4"), ["--limit", "S-curve"]),
    ],
)
def test_plan_refuses(run, folder, options, words):
    line = refused(run, folder, *MOVE, *options)
    for word in words:
        assert word in line


@pytest.mark.parametrize("distance", ["sixty", "60", "nan mm", "-inf mm", "60 s", "", "-x"])
def test_plan_refuses_distances(run, folder, distance):
    assert "distance" in refused(run, folder, "plan", distance, *LIMIT)


@pytest.mark.parametrize("option", ["--csv", "--plot"])
@pytest.mark.parametrize("place", ["nowhere/move.png", "taken/move.png", "folder.png"])
def test_plan_names_the_place_that_it_cannot_write(run, folder, option, place):
    Path("taken").write_text("mine")
    Path("folder.png").mkdir()
    line = refused(run, folder, *MOVE, *LIMIT, option, place)
    assert place in line
    assert "draft" not in line
    assert names(folder / "folder.png") == set()


@pytest.mark.parametrize("name", ["move.xyz", "move"])
def test_plan_refuses_pictures_of_unknown_kind(run, folder, name):
    line = refused(run, folder, *MOVE, *LIMIT, "--plot", name)
    assert "png" in line


@pytest.mark.parametrize("bad", ["nowhere/move.png", "move.xyz"])
def test_plan_writes_both_files_or_none(run, folder, bad):
    refused(run, folder, *MOVE, *LIMIT, "--csv", "move.csv", "--plot", bad)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("plan",), "distance"),
        (("plan", "60 arcsec", "--velocty", "1 deg/s"), "--velocty"),
        (("plan", "60 arcsec", *LIMIT, "--order", "six"), "--order"),
        (("plan", "60 arcsec", "--acceleration"), "--acceleration"),
        (("survey",), "scenario"),
        (("survey", "case.toml"), "--output"),
        (("survey", "case.toml", "--outptu", "out"), "--outptu"),
        (("check",), "scenario"),
        (("check", "case.toml", "--baselin", "b.json"), "--baselin"),
        (("check", "case.toml", "--format", "xml"), "--format"),
        (("surbey",), "surbey"),
    ],
)
def test_wrong_usage(run, folder, arguments, word):
    status, out, errors = run(*arguments)
    assert (status, out) == (2, "")
    assert word in "\n".join(errors).lower()  # older releases of typer print SCENARIO
    assert names(folder) == set()


@pytest.mark.parametrize("command", [(), ("check",), ("plan",), ("survey",)])
def test_help(run, command):
    status, out, errors = run(*command, "--help")
    assert (status, errors) == (0, [])
    assert "Usage" in out
    shown = {
        (): ("check", "plan", "survey"),
        ("check",): (
            "--baseline",
            "--checks",
            "--update",
            "--junit",
            "--format",
            "--all",
            "neither",
        ),
        ("plan",): ("--rise-time", "--plot"),
        ("survey",): ("--output",),
    }
    assert all(word in out for word in shown[command])


def test_alone_it_shows_help(run):
    _, out, errors = run()
    text = out + "\n".join(errors)
    assert "Usage" in text
    assert "plan" in text
    assert "survey" in text


def test_survey_prints_and_writes(run, folder):
    status, out, errors = run("survey", EXAMPLES / "rubin_mount.toml", "--output", "a/b")
    assert (status, errors) == (0, [])
    for part in ("Rubin Observatory mount", "45 deg", "12 dB", "39.85 %", "1.4315", "1.9020"):
        assert part in out
    data = json.loads(Path("a/b/survey.json").read_text(encoding="utf-8"))
    assert data["moves"][0]["duration_s"] == pytest.approx(1.4314539066, abs=1e-10)
    for path in (folder / "a" / "b").iterdir():
        assert path.name in out
    assert names(folder) == {"a"}


@pytest.mark.usefixtures("quick")
def test_survey_says_that_the_published_gains_miss(run):
    status, out, _ = run("survey", EXAMPLES / "telescope_published_gains.toml", "-o", "out")
    assert status == 0
    text = " ".join(out.split())
    assert text.count("missed") == 3
    assert "crossover 1.750 Hz (asked 1), phase margin 73.0 deg (asked 45)" in text
    assert 'Use gains = "design"' in text


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("title", ["[red]axis :cat:", "axis [/b]"])
def test_survey_prints_the_title_as_it_is(run, title):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    old = "Telescope axis (Thompson, Section VII)"
    Path("case.toml").write_text(text.replace(old, title), encoding="utf-8")
    status, out, _ = run("survey", "case.toml", "-o", "out")
    assert status == 0
    assert title in out


@pytest.mark.usefixtures("quick")
def test_survey_prints_the_folder_as_it_is(run):
    status, out, _ = run("survey", EXAMPLES / "telescope.toml", "-o", "out [old] :cat:")
    assert status == 0
    assert "out [old] :cat:" in " ".join(out.split())


def test_survey_of_an_unstable_loop(run, folder):
    Path("case.toml").write_text(UNSTABLE)
    status, out, (line,) = run("survey", "case.toml", "--output", "out")
    assert (status, out) == (1, "")
    assert "UNSTABLE" in line
    worst = max(np.roots([1.0, 1.0, 28.0, 38.0]), key=lambda pole: pole.real)
    assert f"{worst.real:.4g}" in line
    # s³ + k·(s² + 28s + 38) is stable from k = 38/28 on
    assert line.endswith("Change the gains by a common factor above 1.357")
    assert "case.toml" in line
    assert names(folder) == {"case.toml"}


def test_survey_of_a_velocity_limit_alone(run, folder):
    Path("case.toml").write_text(UNSTABLE.replace('kr = "1 ', 'kr = "5 ').replace(
        'acceleration = "0.2 deg/s^2"', 'velocity = "1 deg/s"'))  # fmt: skip
    line = refused(run, folder, "survey", "case.toml", "--output", "out")
    assert "acceleration" in line
    assert "case.toml" in line


def test_survey_refuses_what_is_no_scenario(run, folder):
    Path("folder.toml").mkdir()
    Path("text.toml").write_text("this is a letter")
    Path("empty.toml").write_text("")
    Path("binary.toml").write_bytes(b"\xff\xfe\x00")
    for name, word in (
        ("nowhere.toml", "No such file"),
        ("folder.toml", "directory"),
        ("text.toml", "not TOML"),
        ("empty.toml", "no scenario"),
        ("binary.toml", "UTF-8"),
    ):
        line = refused(run, folder, "survey", name, "--output", "out")
        assert name in line
        assert word in line


def test_survey_has_a_line_for_each_problem(run, folder):
    text = UNSTABLE.replace("0.2 deg/s^2", "0.2 deg/s").replace("50 mas", "50 s")
    Path("case.toml").write_text(text)
    status, out, errors = run("survey", "case.toml", "--output", "out")
    assert (status, out) == (2, "")
    assert len(errors) == 2
    for line, words in zip(errors, (("acceleration", "deg/s"), ("settle_to", "50 s")), strict=True):
        assert "case.toml" in line
        assert all(word in line for word in words)
    assert names(folder) == {"case.toml"}


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("output", ["taken", "taken/out"])
def test_survey_names_the_folder_that_it_cannot_write(run, folder, output):
    Path("taken").write_text("mine")
    line = refused(run, folder, "survey", EXAMPLES / "telescope.toml", "--output", output)
    assert "taken" in line
    assert Path("taken").read_text() == "mine"


@pytest.fixture
def axis(run, folder) -> Path:
    """Store the numbers of a scenario in this folder beside it."""
    (folder / "axis.toml").write_text(UNSTABLE.replace('kr = "1 ', 'kr = "5 '))
    status, out, errors = run("check", "axis.toml", "--update")
    assert (status, errors) == (0, [])
    assert out.endswith("Passed: 23 numbers (23 new)\nWrote axis.baseline.json\n")
    assert names(folder) == {"axis.toml", "axis.baseline.json"}
    return folder / "axis.toml"


def loosen(axis: Path) -> None:
    axis.write_text(axis.read_text().replace('kr = "5 ', 'kr = "4.9 '))


def test_check_passes_what_is_stored(run, folder, axis):
    for option in ((), ("--baseline", axis.with_name("axis.baseline.json"))):
        status, out, errors = run("check", "axis.toml", *option)
        assert (status, errors) == (0, [])
        assert out.splitlines()[-1] == "Passed: 23 numbers (23 same)"
    assert names(folder) == {"axis.toml", "axis.baseline.json"}


@pytest.mark.usefixtures("axis")
def test_check_stores_the_same_file_each_time(run, folder):
    before = (folder / "axis.baseline.json").read_bytes()
    run("check", "axis.toml", "--update", "--baseline", "second.json")
    assert (folder / "second.json").read_bytes() == before


def test_check_fails_on_a_regression(run, folder, axis):
    loosen(axis)
    before = (folder / "axis.baseline.json").read_bytes()
    status, out, errors = run("check", "axis.toml", "--junit", "junit.xml", "--format", "github")
    assert (status, errors) == (1, [])
    row = next(line.split() for line in out.splitlines() if "margins.phase_margin_deg" in line)
    margins = [loop_margins(control.tf([k, 28, 38], [1, 0, 0, 0])) for k in (5.0, 4.9)]
    expected = [margin.phase_margin_deg for margin in margins]
    assert [float(word) for word in row[1:3]] == pytest.approx(expected, rel=1e-6)
    assert row[3:] == [">=", row[4], "worse"]
    assert "::error file=axis.toml,title=jounce check%3A axis::margins.phase_margin_deg is" in out
    assert "FAILED: " in out
    assert "--update" in out
    suite = ElementTree.parse("junit.xml").getroot()[0]
    assert int(suite.get("failures")) == out.count("::error") > 0
    assert int(suite.get("tests")) == 24
    assert (folder / "axis.baseline.json").read_bytes() == before
    assert names(folder) == {"axis.toml", "axis.baseline.json", "junit.xml"}


def test_check_updates_what_keeps_its_bounds(run, folder, axis):
    loosen(axis)
    before = (folder / "axis.baseline.json").read_bytes()
    (folder / "axis.check.toml").write_text("[margins]\nphase_margin_deg = {min = 80}")
    status, out, _ = run("check", "axis.toml", "--update", "--junit", "junit.xml")
    assert status == 1
    assert "Nothing is stored" in out
    assert (folder / "axis.baseline.json").read_bytes() == before
    (folder / "axis.check.toml").unlink()
    status, out, _ = run("check", "axis.toml", "--update")
    assert status == 0
    assert "worse" in out
    assert run("check", "axis.toml")[0] == 0


def test_check_of_an_unstable_loop(run, folder, axis):
    axis.write_text(UNSTABLE)
    before = (folder / "axis.baseline.json").read_bytes()
    for option in ((), ("--update",)):
        status, out, errors = run(
            "check", "axis.toml", "--junit", "junit.xml", "--format", "github", *option
        )
        assert (status, errors) == (1, [])
        assert "FAILED: axis.toml: the closed loop is UNSTABLE" in out
        assert "::error file=axis.toml" in out
        (case,) = ElementTree.parse("junit.xml").getroot()[0]
        assert "UNSTABLE" in case.find("failure").text
    assert (folder / "axis.baseline.json").read_bytes() == before


@pytest.mark.usefixtures("axis")
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--baseline", "nowhere.json"), ["nowhere.json", "No such file", "name a baseline"]),
        (("--baseline", "folder"), ["folder", "Is a directory", "name a baseline"]),
        (("--baseline", "axis.toml"), ["axis.toml", "not JSON"]),
        (("--baseline", "axis.toml", "--update"), ["axis.toml", "not JSON"]),
        (("--baseline", "nowhere/b.json", "--update"), ["nowhere/b.json", "No such file"]),
        (("--checks", "nowhere.toml"), ["nowhere.toml", "No such file", "name a check file"]),
        (("--checks", "axis.baseline.json"), ["axis.baseline.json", "not TOML"]),
        (("--checks", "axis.toml"), ["axis.toml", "plant: no number has this name"]),
        (("--junit", "nowhere/j.xml"), ["nowhere/j.xml", "No such file"]),
        (("--junit", "folder"), ["folder", "Is a directory"]),
        (("--junit", "link"), ["link", "is a link or a device"]),
        (("--junit", "axis.toml"), ["--junit axis.toml", "a file that is read"]),
        (("--junit", "./axis.baseline.json"), ["--junit axis.baseline.json", "a file that is"]),
    ],
    ids=range(13),
)
def test_check_refuses(run, folder, options, words):
    Path("folder").mkdir()
    Path("link").symlink_to("folder/junit.xml")
    before = {path: path.read_bytes() for path in folder.glob("axis*")}
    status, out, errors = run("check", "axis.toml", *options)
    assert (status, out) == (2, "")
    assert errors[0].startswith("jounce: ")
    assert all(word in errors[0] for word in words)
    assert {path: path.read_bytes() for path in folder.glob("axis*")} == before
    assert names(folder) == {"axis.toml", "axis.baseline.json", "folder", "link"}
    assert Path("link").is_symlink()


@pytest.mark.usefixtures("axis")
def test_check_of_bad_input_leaves_no_green_file(run, folder):
    (folder / "junit.xml").write_text("<testsuites/>")
    (folder / "axis.check.toml").write_text("xyz = 1\nrtol = -1")
    options = ("--junit", "junit.xml", "--format", "github")
    status, out, errors = run("check", "axis.toml", *options)
    assert (status, len(errors)) == (2, 2)
    (annotation,) = out.splitlines()
    assert annotation == "::error ::" + "%0A".join(errors).removeprefix("jounce: ")
    (suite,) = ElementTree.parse("junit.xml").getroot()
    assert [suite.get(key) for key in ("tests", "failures", "errors")] == list("101")
    assert "xyz" in suite.find("testcase/error").text
    assert names(folder) == {"axis.toml", "axis.baseline.json", "axis.check.toml", "junit.xml"}


@pytest.mark.usefixtures("axis")
def test_check_of_bad_input_keeps_the_files_that_it_reads(run, folder):
    (folder / "axis.baseline.json").write_text("<<<<<<< HEAD")
    for name in ("axis.toml", "axis.baseline.json", "axis.check.toml"):
        before = {path: path.read_bytes() for path in folder.iterdir()}
        status, _, (line,) = run("check", "axis.toml", "--junit", name)
        assert status == 2
        assert "not JSON" in line
        assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.usefixtures("axis")
def test_check_says_how_to_replace_a_damaged_baseline(run, folder):
    baseline = folder / "axis.baseline.json"
    baseline.write_text("<<<<<<< HEAD\n" + baseline.read_text())
    line = refused(run, folder, "check", "axis.toml", "--update")
    assert line.endswith("delete the file and store anew with --update")
    baseline.unlink()
    assert run("check", "axis.toml", "--update")[0] == 0


def test_check_shows_failures_alone_unless_all_is_asked_for(run, axis):
    loosen(axis)
    status, out, _ = run("check", "axis.toml")
    _, full, _ = run("check", "axis.toml", "--all")
    same = int(re.search(r"^and (\d+) numbers the same", out, re.MULTILINE)[1])
    assert status == 1
    assert "moves.go.duration_s" not in out
    assert "moves.go.duration_s" in full
    assert "numbers the same" not in full
    assert len(full.splitlines()) - len(out.splitlines()) == same - 2  # its line and an empty one
    assert f", {same} same)" in out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.usefixtures("axis")
def test_check_says_that_it_cannot_print():
    code = "from jounce.app.command_line import main; main()"
    command = [sys.executable, "-c", code, "check", "axis.toml"]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60, check=False)
    assert done.returncode == 2
    line = done.stderr.decode().splitlines()[0]
    assert line.startswith("jounce: standard output: No space left on device; ")


def test_check_needs_something_to_judge_by(run, folder):
    (folder / "axis.toml").write_text(UNSTABLE.replace('kr = "1 ', 'kr = "5 '))
    line = refused(run, folder, "check", "axis.toml")
    assert "--update" in line
    assert "axis.check.toml" in line


@pytest.mark.usefixtures("axis")
def test_check_prints_names_as_they_are(run, folder):
    text = (folder / "axis.toml").read_text().replace('"go"', "'[red]go :cat: é \"x\"'")
    (folder / "odd [1].toml").write_text(text, encoding="utf-8")
    status, out, _ = run("check", "odd [1].toml", "--update")
    assert status == 0
    assert r'moves."[red]go :cat: é \"x\"".duration_s' in out
    assert "Wrote odd [1].baseline.json" in out


def test_the_app_serves_a_runner():
    result = CliRunner().invoke(command_line.app, [*MOVE, *LIMIT])
    assert result.exit_code == 0
    assert "0.5773502692 s" in result.stdout


def start(*arguments: str) -> subprocess.CompletedProcess:
    code = "from jounce.app.command_line import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        timeout=60,
        check=False,
    )


def test_as_a_process(folder):
    done = start("plan", "-60 arcsec", *LIMIT, "--csv", "nowhere/move.csv")
    assert done.returncode == 2
    assert done.stdout == b""
    assert len(done.stderr.splitlines()) == 1
    assert names(folder) == set()


@pytest.mark.usefixtures("quick")
def test_survey_prints_where_there_is_no_circumflexed_j(run, monkeypatch):
    """Windows' code page 1252 has no Ĵ, and a pipe there is not UTF-8."""
    pipe = io.TextIOWrapper(io.BytesIO(), encoding="cp1252")
    monkeypatch.setattr(sys, "stdout", pipe)
    status, _, errors = run("survey", EXAMPLES / "telescope.toml", "-o", "out")
    assert (status, errors) == (0, [])
    pipe.flush()
    assert "settled to 0.05 arcsec" in pipe.buffer.getvalue().decode("cp1252")
