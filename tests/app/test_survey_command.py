"""`jounce survey`: what is printed, what is written, and one clear line for a wrong input."""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command_lines import UNSTABLE, names, refused
from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("folder")

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def quick(monkeypatch):
    """Save empty pictures, where the picture is not the point."""
    monkeypatch.setattr(Figure, "savefig", lambda *args, **_: Path(args[1]).write_bytes(b"picture"))


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


def test_survey_without_a_folder_only_prints(run, folder):
    status, out, errors = run("survey", EXAMPLES / "rubin_mount.toml")
    assert (status, errors) == (0, [])
    assert "1.4315" in out
    assert "Wrote" not in out
    assert names(folder) == set()


@pytest.mark.usefixtures("quick")
def test_survey_writes_details_and_pdf_on_request(run):
    axis = EXAMPLES / "telescope_azimuth.toml"
    status, out, errors = run("survey", axis, "-o", "out", "--details", "--pdf")
    assert (status, errors) == (0, [])
    pages = {"survey.png", "survey.pdf", "details.png", "details.pdf"}
    assert pages <= names(Path("out"))
    assert all(page in out for page in pages)


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


@pytest.mark.usefixtures("quick")
def test_survey_prints_where_there_is_no_circumflexed_j(run, monkeypatch):
    """Windows' code page 1252 has no Ĵ, and a pipe there is not UTF-8."""
    pipe = io.TextIOWrapper(io.BytesIO(), encoding="cp1252")
    monkeypatch.setattr(sys, "stdout", pipe)
    status, _, errors = run("survey", EXAMPLES / "telescope.toml", "-o", "out")
    assert (status, errors) == (0, [])
    pipe.flush()
    assert "settled to 0.05 arcsec" in pipe.buffer.getvalue().decode("cp1252")


MISSED = """format = 2
title = "stage"
plant = {inertia = "1 kg m^2"}
[controller]
gains = "design"
sample_time = "1 ms"
specification = {crossover = "5 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
[[controller.filters]]
kind = "notch"
frequency = "450 Hz"
zero_damping = "10 %"
pole_damping = "60 %"
[limits.all]
acceleration = "1 rad/s^2"
[[moves]]
name = "there"
distance = "1 deg"
limits = "all"
settle_to = "1 mdeg"
[requirements]
phase_margin = {min = "50 deg"}
"""


@pytest.mark.filterwarnings("default::UserWarning")
@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("options", [(), ("--json", "-o", "out")])
def test_a_missed_requirement_is_a_failed_check_and_a_warning_is_told_once(run, options):
    Path("stage.toml").write_text(MISSED, encoding="utf-8")
    status, out, errors = run("survey", "stage.toml", *options)
    assert status == 1
    assert "missed" in out
    assert Path("out/survey.json").exists() == ("-o" in options)
    (line,) = errors
    assert line.startswith(
        "jounce: warning: stage.toml: controller.filters[0]: "
        "Notch at 450 Hz, 0.9 of the Nyquist frequency of 500"
    )


@pytest.mark.filterwarnings("default::RuntimeWarning")
@pytest.mark.usefixtures("quick")
def test_a_warning_of_a_move_names_file_and_move(run):
    bounds = 'acceleration = "1 rad/s^2"\nderivative_11 = "1.5e16 rad/s^11"'
    text = MISSED.replace('acceleration = "1 rad/s^2"', bounds).replace("450 Hz", "45 Hz")
    Path("stage.toml").write_text(text, encoding="utf-8")
    _, _, errors = run("survey", "stage.toml")
    (line,) = errors
    assert line.startswith("jounce: warning: stage.toml: move 'there': order 11 is above 10")
