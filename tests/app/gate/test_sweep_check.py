"""`jounce check --sweep`: yield and worst cases of a sweep, held to what they were."""

import json
from pathlib import Path

import pytest
from swept_axis import AXIS

from jounce.app import sweep
from jounce.app.gate.sweep_check import check_sweep
from jounce.app.sweeps.sweep_file import read_sweep_file

SWEEP = """figures = ["phase_margin", "modulus_margin"]
[parameters]
plant.inertia = ["1.9 kg m^2", "2 kg m^2", "2.1 kg m^2", "2.4 kg m^2"]
"""


@pytest.fixture
def files(tmp_path) -> tuple[Path, Path]:
    (tmp_path / "axis.toml").write_text(AXIS, encoding="utf-8")
    (tmp_path / "spread.toml").write_text(SWEEP, encoding="utf-8")
    return tmp_path / "axis.toml", tmp_path / "spread.toml"


@pytest.fixture
def check(files, run, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    return lambda *more: run("check", files[0], "--sweep", files[1], *more)


def failed(check):
    """Return the report of a check that fails, and its numbers by name."""
    status, out, _ = check("--json")
    assert status == 1
    [report] = json.loads(out)
    return report, {row["name"]: row for row in report["numbers"]}


def test_a_stored_sweep_passes_and_its_numbers_are_those_of_the_sweep(files, check):
    status, out, errors = check()
    assert (status, out) == (2, "")
    assert "nothing to judge it by; store its numbers with --update" in errors[0]
    assert check("--update")[0] == 0
    stored = json.loads((files[1].with_name("spread.baseline.json")).read_text(encoding="utf-8"))
    found = sweep(files[0], **read_sweep_file(files[1]), workers=1)
    assert stored["numbers"]["sweep"]["yield_percent"]["value"] == 100.0 * found.met().fraction
    worst = stored["numbers"]["worst"]["phase_margin"]["value"]
    assert worst == found.values("phase_margin").min()
    status, out, errors = check()
    assert (status, errors) == (0, [])
    assert "Passed" in out
    html = check_sweep(*files, workers=1)._repr_html_()
    assert "<th style='text-align:left'>passed</th><td style='text-align:left'>yes</td>" in html


def test_a_worse_plant_fails_with_what_was_is_and_may_be(files, check):
    check("--update")
    axis = files[0].read_text(encoding="utf-8")
    files[0].write_text(axis.replace("45 deg", "38 deg"), encoding="utf-8")
    _, rows = failed(check)
    assert rows["worst.phase_margin"]["verdict"] == "worse"
    assert rows["worst.phase_margin"]["now"] < rows["worst.phase_margin"]["was"]
    assert rows["worst.phase_margin"]["least"] == pytest.approx(
        rows["worst.phase_margin"]["was"], rel=1e-5
    )
    assert rows["sweep.yield_percent"]["verdict"] == "worse"
    status, out, _ = check()
    assert status == 1
    assert "worst.phase_margin" in out


def test_points_that_fail_are_counted_and_what_varies_must_be_as_it_was(files, check):
    check("--update")
    text = files[1].read_text(encoding="utf-8")
    files[1].write_text(text.replace("2.4 kg m^2", "1000 kg m^2"), encoding="utf-8")
    report, rows = failed(check)
    assert (rows["sweep.failed_points"]["was"], rows["sweep.failed_points"]["now"]) == (0.0, 1.0)
    assert rows["sweep.failed_points"]["verdict"] == "worse"
    [change] = report["changes"]
    assert "1000 kg m^2" in str(change)


def test_bounds_of_a_check_file_count_and_bad_input_is_told(files, check, tmp_path):
    bounds = (
        "baseline = false\nyield_percent = { min = 99 }\n[worst]\nmodulus_margin = { min = 0.1 }"
    )
    (tmp_path / "spread.check.toml").write_text(bounds, encoding="utf-8")
    verdicts = {name: row["verdict"] for name, row in failed(check)[1].items()}
    assert verdicts["sweep.yield_percent"] == "outside"
    assert verdicts["worst.modulus_margin"] == "within"
    for more, told in (
        (("--set", 'plant.inertia="3 kg m^2"'), "--set plant.inertia: is for the check"),
        ((files[0].with_name("other.toml"),), "--sweep"),
    ):
        (tmp_path / "other.toml").write_text(AXIS, encoding="utf-8")
        status, _, errors = check(*more)
        assert status == 2
        assert told in errors[0]
