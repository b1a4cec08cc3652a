"""The command line as a whole, and `jounce plan`: what is printed and written, and refusals."""

import csv
import math
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from command_lines import names, refused

pytestmark = pytest.mark.usefixtures("folder")

MOVE = ("plan", "60 arcsec")
LIMIT = ("--acceleration", "0.2 deg/s^2")
CURVE = ("--velocity", "0.1 deg/s", *LIMIT)


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
        (("survey", "case.toml", "--pdf"), "--output"),
        (("survey", "case.toml", "--details"), "--output"),
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
    assert word in "\n".join(errors).lower()
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
        ("survey",): ("--output", "--details", "--pdf", "replaced"),
    }
    assert all(word in out for word in shown[command])


def test_alone_it_shows_help(run):
    _, out, errors = run()
    text = out + "\n".join(errors)
    assert "Usage" in text
    assert "plan" in text
    assert "survey" in text


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
