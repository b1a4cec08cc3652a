"""`jounce check` of one scenario: what passes, what fails, and what is left behind."""

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import control
import pytest
from command_lines import UNSTABLE, names, refused

from jounce.analysis import loop_margins

pytestmark = pytest.mark.usefixtures("folder")


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
