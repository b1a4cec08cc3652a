"""The measured cases: every margin within its error bars, no crossing lost, none made up."""

import json
from pathlib import Path

import pytest
from measured_cases import run_case

FOLDER = Path(__file__).parents[2] / "data" / "measured"
CASES = json.loads((FOLDER / "expected.json").read_text(encoding="utf-8"))["cases"]
FORMATS = {
    "ascii universal file": ("stage", {"file": "stage_ascii.uff"}),
    "record": ("stage", {"file": None}),
    "sensitivity": ("drive", {"file": "drive_sensitivity.tsv", "kind": "sensitivity"}),
    "no averages": ("drive", {"averages": None}),
}


def check(entry, found):
    assert found["stable"] is entry["expected_stable"]
    assert found["reasons"]
    for name, value in entry.get("exact", {}).items():
        if name == "crossovers_hz":
            assert len(found[name]) == len(value)
            assert found[name] == pytest.approx(value, rel=5e-3)
            continue
        room = 6.25 * found[f"{name}_sigma"] + 3e-3 * abs(value)
        assert found[name] == pytest.approx(value, abs=room), name


@pytest.mark.parametrize("name", CASES)
def test_the_margins_are_those_of_the_true_loop(name):
    check(CASES[name], run_case(CASES[name], FOLDER))


@pytest.mark.parametrize("name", FORMATS)
def test_other_files_of_the_same_loops_give_the_same_margins(name):
    case, changed = FORMATS[name]
    entry = {key: value for key, value in (CASES[case] | changed).items() if value is not None}
    check(entry, run_case(entry, FOLDER))


def test_what_cannot_be_told_says_why():
    found = run_case(CASES["stage_starts_above_crossover"], FOLDER)
    assert "no line with |L| > 1" in found["reasons"][0]
    assert "phase_margin_deg" not in found
    coarse = run_case(CASES["drive_coarse_2hz"], FOLDER)
    [warning] = [text for text in coarse["warnings"] if "narrower" in text]
    assert "resonance near 61 Hz is narrower than the lines (0.73 against 2 Hz)" in warning
