"""Several scenarios, missing baselines and overrides, as `jounce check` is called."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

AXIS = """
title = "Axis {0}"
plant.inertia = "1 kg m^2"
controller.gains = {{kp = "28 N m/rad", ki = "38 N m/(rad s)", kr = "5 N m s/rad"}}
limits.axis = {{acceleration = "0.2 deg/s^2"}}
modes = [{{name = "tower", frequency = "3 Hz", damping = "1 %"}}]
moves = [{{name = "go", distance = "{0} arcsec", settle_to = "50 mas"}}]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Work in a folder with three scenarios."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "axes").mkdir()
    for name in ("axes/a", "axes/b", "c"):
        (tmp_path / f"{name}.toml").write_text(AXIS.format(60 + ord(name[-1])))
    return tmp_path


@pytest.fixture
def stored(run):
    """Store a baseline beside each scenario."""
    status, out, errors = run("check", "axes/*.toml", "c.toml", "--update")
    assert (status, errors) == (0, [])
    return out


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def edit(path: str, old: str, new: str) -> None:
    text = Path(path).read_text()
    assert old in text
    Path(path).write_text(text.replace(old, new))


def suites(path: str) -> dict[str, tuple[int, int]]:
    """Return the failures and errors of each suite."""
    found = ElementTree.parse(path).getroot()
    return {s.get("name"): (int(s.get("failures")), int(s.get("errors"))) for s in found}


def test_each_has_its_baseline_beside_it(run, folder, stored):
    assert set(contents(folder)) == {
        f"{name}.{suffix}"
        for name in ("axes/a", "axes/b", "c")
        for suffix in ("toml", "baseline.json")
    }
    assert stored.endswith(
        "3 scenarios: 3 passed\nWrote axes/a.baseline.json\nWrote axes/b.baseline.json\n"
        "Wrote c.baseline.json\n"
    )
    status, out, errors = run("check", "axes/*.toml", "c.toml", "--junit", "j.xml")
    assert (status, errors) == (0, [])
    assert out.splitlines() == [
        "Check of Axis 157 (axes/a.toml), positions in arcsec",
        "Passed: 24 numbers (24 same)",
        "",
        "Check of Axis 158 (axes/b.toml), positions in arcsec",
        "Passed: 24 numbers (24 same)",
        "",
        "Check of Axis 159 (c.toml), positions in arcsec",
        "Passed: 24 numbers (24 same)",
        "",
        "3 scenarios: 3 passed",
        "Wrote j.xml",
    ]
    assert suites("j.xml") == {f"Axis {size}": (0, 0) for size in (157, 158, 159)}
    _, out, _ = run("check", "axes/*.toml", "--all")
    assert out.count("margins.phase_margin_deg") == 2


@pytest.mark.usefixtures("stored")
def test_check_files_and_baselines_are_no_scenarios(run):
    Path("axes/a.check.toml").write_text("[margins]\nphase_margin_deg = {min = 80}")
    found = sorted(str(path) for path in Path("axes").iterdir())  # as a shell expands axes/*
    for arguments in (["axes/*"], ["axes/*.toml"], found):
        status, out, errors = run("check", *arguments)
        assert (status, errors) == (1, [])
        assert out.endswith("2 scenarios: 1 passed, 1 FAILED\n")
        assert "phase_margin_deg" in out


@pytest.mark.usefixtures("stored")
def test_a_broken_one_hides_no_other(run, folder):
    Path("axes/b.toml").write_text("this is a letter")
    edit("c.toml", 'kr = "5 ', 'kr = "4.9 ')
    before = contents(folder)
    status, out, errors = run("check", "axes/*.toml", "c.toml", "--junit", "j.xml")
    assert status == 2
    (line,) = errors
    assert line.startswith("jounce: axes/b.toml: not TOML: ")
    assert "Check of Axis 157 (axes/a.toml)" in out
    assert "margins.phase_margin_deg" in out
    assert "3 scenarios: 1 passed, 1 FAILED, 1 could not be checked" in out
    found = suites("j.xml")
    assert found.pop("Axis 157") == (0, 0)
    assert found.pop("axes/b.toml") == (0, 1)
    assert found.pop("Axis 159")[0] > 1
    assert contents(folder) == before | {"j.xml": Path("j.xml").read_bytes()}


@pytest.mark.usefixtures("stored")
def test_an_update_stores_those_that_can_be_stored(run, folder):
    Path("axes/b.toml").write_text("this is a letter")
    Path("c.check.toml").write_text("[margins]\nphase_margin_deg = {min = 80}")
    for name in ("axes/a", "c"):
        edit(f"{name}.toml", 'kr = "5 ', 'kr = "4.9 ')
    before = contents(folder)
    status, out, _ = run("check", "axes/*.toml", "c.toml", "--update")
    assert status == 2
    assert out.count("Wrote") == 1
    assert "Nothing is stored while a bound is broken" in out
    after = contents(folder)
    assert {name for name in after if after[name] != before[name]} == {"axes/a.baseline.json"}
    assert run("check", "axes/a.toml")[0] == 0


@pytest.mark.usefixtures("stored")
@pytest.mark.parametrize("option", [("--junit", "nowhere/j.xml"), ("--junit", "axes/a.toml")])
def test_an_update_that_cannot_write_all_writes_nothing(run, folder, option):
    edit("c.toml", 'kr = "5 ', 'kr = "4.9 ')
    before = contents(folder)
    status, out, errors = run("check", "axes/*.toml", "c.toml", "--update", *option)
    assert (status, out, len(errors)) == (2, "", 1)
    assert contents(folder) == before


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["axes/*.tml", "c.toml"], "axes/*.tml: matches no scenario file (.toml); give a pattern"),
        (["axes/a.check.toml"], "axes/a.check.toml: is a check file; name its scenario, axes/a.to"),
        (["axes/*.toml", "--baseline", "x"], "--baseline x: is of one scenario, and 2 are given; "),
        (["c.toml", "axes/a.toml", "--checks", "x"], "--checks x: is of one scenario, and 2 are"),
        (["c.toml", "--set", "x"], "--set 'x': expected KEY=VALUE, such as --set limits.axis.jer"),
        (["c.toml", "--set", "title=a", "--set", "title=b"], "--set title: is given twice; give"),
    ],
    ids=range(6),
)
def test_wrong_words_are_told_before_any_work(run, folder, arguments, line):
    before = contents(folder)
    status, out, errors = run("check", *arguments, "--junit", "j.xml")
    assert (status, out, len(errors)) == (2, "", 1)
    assert errors[0].startswith(f"jounce: {line}")
    (suite,) = suites("j.xml").values()
    assert suite == (0, 1)
    assert contents(folder) == before | {"j.xml": Path("j.xml").read_bytes()}


@pytest.mark.usefixtures("stored")
def test_one_of_a_pattern_may_have_its_own_baseline(run):
    Path("c.baseline.json").rename("other.json")
    assert run("check", "c.tom[l]", "--baseline", "other.json")[0] == 0


def test_a_missing_baseline_fails_until_it_is_stored(run):
    Path("c.check.toml").write_text("[margins]\nphase_margin_deg = {min = 10}")
    status, out, errors = run("check", "c.toml", "--junit", "j.xml", "--format", "github")
    assert (status, errors) == (1, [])
    line = "c.baseline.json is missing; store the numbers with --update, or write baseline = false"
    assert f"FAILED: {line}" in out
    assert f"::error file=c.toml,title=jounce check%3A Axis 159::{line}" in out
    assert suites("j.xml") == {"Axis 159": (1, 0)}
    assert run("check", "c.toml", "--update")[0] == 0
    assert run("check", "c.toml")[0] == 0
    Path("c.baseline.json").unlink()
    Path("c.check.toml").write_text("baseline = false\n[margins]\nphase_margin_deg = {min = 10}")
    assert run("check", "c.toml")[0] == 0


@pytest.mark.usefixtures("stored")
def test_a_loosened_tolerance_is_no_improvement(run):
    edit("c.toml", "50 mas", "500 mas")
    options = ("--junit", "j.xml", "--format", "github")
    status, out, errors = run("check", "c.toml", *options)
    assert (status, errors) == (1, [])
    words = [line.split() for line in out.splitlines()]
    assert ["moves.go.settle_to", "0.05", "arcsec", "0.5", "arcsec", "changed"] in words
    assert "FAILED: 1 condition changed, 24 numbers" in out
    assert out.count("::error file=c.toml") == 1
    assert suites("j.xml") == {"Axis 159": (1, 0)}
    assert run("check", "c.toml", "--update")[0] == 0
    assert run("check", "c.toml")[0] == 0


@pytest.mark.usefixtures("stored")
def test_an_override_is_compared_and_not_stored(run, folder):
    before = contents(folder)
    option = ("--set", "limits.axis.jerk=3 deg/s^3")
    status, out, errors = run("check", "axes/*.toml", *option)
    assert (status, errors) == (1, [])
    words = [line.split() for line in out.splitlines()]
    row = ["moves.go.limits.jerk", "none", "10800", "arcsec/s^3", "changed"]
    assert words.count(row) == 2
    assert "positions in arcsec, with limits.axis.jerk = '3 deg/s^3'" in out
    status, out, errors = run("check", "c.toml", "--update", *option)
    assert (status, out) == (2, "")
    assert "not of what overrides it (limits.axis.jerk = '3 deg/s^3')" in errors[0]
    assert contents(folder) == before


def test_a_wrong_override_names_key_and_value(run):
    for command in (("check", "c.toml"), ("survey", "c.toml", "-o", "out")):
        status, out, (line,) = run(*command, "--set", "moves.go.distance=1 mm")
        assert (status, out) == (2, "")
        assert line.startswith(
            "jounce: c.toml: override moves[0].distance: '1 mm' has the wrong dimension; write an "
        )


def test_survey_takes_overrides(run):
    status, out, errors = run(
        "survey",
        "c.toml",
        "-o",
        "out",
        "--set",
        "title=Other axis",
        "--set",
        "moves.go.distance=1 deg",
    )
    assert (status, errors) == (0, [])
    assert out.startswith(
        "Other axis\nwith title = 'Other axis'\nwith moves.go.distance = '1 deg'\n"
    )
    data = json.loads(Path("out/survey.json").read_text(encoding="utf-8"))
    assert data["overrides"] == ["title = 'Other axis'", "moves.go.distance = '1 deg'"]
    assert data["moves"][0]["duration_s"] == pytest.approx(2 * (1 / 0.2) ** 0.5, rel=1e-12)
