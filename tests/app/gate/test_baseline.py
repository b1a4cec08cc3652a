"""Baselines: the same numbers come back, to the last digit, and all else is explained."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from jounce.app.gate.baseline import (
    Baseline,
    Stored,
    check_origin,
    in_unit,
    load_baseline,
    stored_conditions,
)
from jounce.app.gate.check_file import CheckError

NUMBERS = {
    ("margins", "phase_margin_deg"): Stored(45.00000000000001, 1e-6, 0.0),
    ("margins", "upper_gain_margin_db"): Stored(None, 1e-6, 0.0),
    ("moves", '[red]"Größe"\\ 😀', "residual_vibration", "value"): Stored(5e-324, 0.0, 1e-300),
    ("moves", "a.b", "peaks", "velocity"): Stored(-0.1, 0.1, 2.0),
}
BASELINE = Baseline("Axis [1]", "arcsec", NUMBERS)


def write(folder: Path, content: object) -> Path:
    path = folder / "case.baseline.json"
    text = content if isinstance(content, str) else json.dumps(content)
    path.write_text(text, encoding="utf-8")
    return path


def problems(path: Path) -> list[str]:
    with pytest.raises(CheckError) as refusal:
        load_baseline(path)
    lines = str(refusal.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


def refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")


def test_what_is_written_comes_back(tmp_path):
    path = tmp_path / "case.baseline.json"
    BASELINE.write(path)
    assert load_baseline(path) == BASELINE
    assert b"\r" not in path.read_bytes()


def test_the_text_is_sorted_strict_json_with_a_line_for_each_number():
    text = BASELINE.text()
    tree = json.loads(text, parse_constant=refuse)
    assert list(tree) == ["jounce_baseline", "numbers", "position_unit", "scenario"]
    assert json.dumps(tree) == json.dumps(tree, sort_keys=True)
    assert (
        '\n      "phase_margin_deg": {"atol": 0.0, "rtol": 1e-06, "value": 45.00000000000001},\n'
        in text
    )
    assert sum("value" in line and "atol" in line for line in text.splitlines()) == len(NUMBERS)
    assert text.endswith("\n}\n")


FINITE = st.floats(allow_nan=False, allow_infinity=False)
TOLERANCES = st.floats(min_value=0.0, allow_infinity=False, allow_nan=False)
NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8)


@seed(5)
@settings(max_examples=100, deadline=None, database=None)
@given(
    moves=st.dictionaries(
        NAMES, st.builds(Stored, st.none() | FINITE, TOLERANCES, TOLERANCES), min_size=1, max_size=4
    )
)
def test_any_number_comes_back(tmp_path_factory, moves):
    path = tmp_path_factory.getbasetemp() / "fuzz.baseline.json"
    numbers = {("moves", name, "duration_s"): stored for name, stored in moves.items()}
    baseline = Baseline(None, None, numbers)
    baseline.write(path)
    assert load_baseline(path) == baseline


@pytest.mark.parametrize("ends", ["\r\n", "\r"])
def test_line_ends_and_byte_order_mark_of_other_platforms(tmp_path, ends):
    path = tmp_path / "case.baseline.json"
    path.write_bytes(b"\xef\xbb\xbf" + BASELINE.text().replace("\n", ends).encode())
    assert load_baseline(path) == BASELINE


def content(**entry: object) -> dict[str, object]:
    """Return a baseline of one number, the given parts of it changed or (None given) left out."""
    number = {"value": 45.0, "rtol": 1e-6, "atol": 0.0} | entry
    return {
        "jounce_baseline": 1,
        "scenario": "Axis",
        "position_unit": "mm",
        "numbers": {"margins": {"x": {k: v for k, v in number.items() if v != "left out"}}},
    }


@pytest.mark.parametrize(
    ("broken", "line"),
    [
        ("", "not JSON: "),
        ("<<<<<<< HEAD\n{}", "not JSON: Expecting value: line 1 column 1 (char 0); name"),
        ("[" * 99999, "not readable JSON: a number of thousands of digits or brackets nested too"),
        ("9" * 9999, "not readable JSON: a number of thousands of digits or brackets nested too"),
        ([], "is no baseline; name a baseline (JSON), or delete the file and store anew with"),
        ({"numbers": {}}, "is no baseline; name a baseline (JSON), or delete the file and stor"),
        (content() | {"jounce_baseline": 2}, "jounce_baseline: 2 is a layout that this version"),
        (content() | {"jounce_baseline": True}, "jounce_baseline: true is a layout that this vers"),
        (content() | {"scenario": 3}, "scenario: 3 is not text; delete the file and store anew w"),
        (content() | {"numbers": 3}, "numbers: 3 is not a table; delete the file and store anew w"),
        (content() | {"numbers": {}}, "numbers: holds none; delete the file and store anew with -"),
        ({"jounce_baseline": 1}, "numbers: None is not a table; delete the file and store"),
        (content() | {"numbers": {"x": 3}}, "numbers.x: 3 is not a table; delete the file"),
        (content(value=math.nan), "numbers.margins.x: value = nan is not a finite number; delete"),
        (content(value=-math.inf), "numbers.margins.x: value = -inf is not a finite number; del"),
        (json.dumps(content()).replace("45.0", "1e999"), "value = inf is not a finite number; del"),
        (content(value="45"), "numbers.margins.x: value = '45' is not a finite number; delete the"),
        (content(value=True), "numbers.margins.x: value = true is not a finite number; delete the"),
        (content(value=10**400), "numbers.margins.x: value = 1000000000000000000000000000000000"),
        (content(value="left out"), "numbers.margins.x: value is missing; delete the file and st"),
        (content(rtol="left out"), "numbers.margins.x: rtol is missing; delete the file and store"),
        (content(rtol=None), "numbers.margins.x: rtol = None is not a number not below zero; dele"),
        (content(atol=-1.0), "numbers.margins.x: atol = -1.0 is not a number not below zero; dele"),
        (content(tol=1), "numbers.margins.x: 'tol' is not known; delete the file and store anew"),
    ],
    ids=range(24),
)  # fmt: skip
def test_a_broken_file_is_explained(tmp_path, broken, line):
    (problem,) = problems(write(tmp_path, broken))
    assert line in problem
    assert problem.endswith("delete the file and store anew with --update")


def test_every_problem_is_reported(tmp_path):
    broken = content(value="x") | {"scenario": 3, "position_unit": []}
    assert [line.split(":")[0] for line in problems(write(tmp_path, broken))] == [
        "scenario",
        "position_unit",
        "numbers.margins.x",
    ]


@pytest.mark.parametrize("name", ["", "absent.json", "a\0b"])
def test_paths_that_are_no_file_are_explained(tmp_path, name):
    (problem,) = problems(tmp_path / name)
    assert problem.endswith("; name a baseline (JSON), or store one with --update")


def test_text_that_is_not_utf_8_is_explained(tmp_path):
    path = tmp_path / "case.json"
    path.write_bytes(b'{"caf\xe9": 1}')
    assert problems(path) == [
        "byte 5 is not UTF-8; save the file as UTF-8 text, or delete the file and store anew with "
        "--update"
    ]


def test_a_merge_conflict_says_how_to_get_out_of_it(tmp_path):
    lines = BASELINE.text().splitlines(keepends=True)
    conflict = ["<<<<<<< HEAD\n", lines[3], "=======\n", lines[3], ">>>>>>> other\n"]
    (problem,) = problems(write(tmp_path, "".join(lines[:3] + conflict + lines[4:])))
    assert problem.startswith("not JSON: ")
    assert problem.endswith("delete the file and store anew with --update")


@pytest.mark.parametrize(
    ("scenario", "unit", "words"),
    [
        ("Axis [2]", "arcsec", "is the baseline of 'Axis [1]', not of 'Axis [2]'; name another"),
        ("Axis [1]", "deg", "is in 'arcsec', the scenario in 'deg'; delete the file and store"),
    ],
)
def test_another_origin_is_refused(scenario, unit, words):
    check_origin(BASELINE, Path("b.json"), "Axis [1]", "arcsec")
    with pytest.raises(CheckError) as refusal:
        check_origin(BASELINE, Path("b.json"), scenario, unit)
    assert str(refusal.value).startswith(f"b.json: {words}")
    assert str(refusal.value).endswith("delete the file and store anew with --update")


CONDITIONS = {
    ("moves", "a.b é", "settle_to"): "0.05 arcsec",
    ("moves", "a.b é", "limits", "jerk"): "-1 to 2 mm/s^3",
    ("controller", "gains"): "design",
}


@pytest.mark.parametrize("conditions", [None, {}, CONDITIONS])
def test_conditions_come_back(tmp_path, conditions):
    path = tmp_path / "case.baseline.json"
    baseline = replace(BASELINE, conditions=conditions)
    baseline.write(path)
    assert load_baseline(path) == baseline
    assert ("conditions" in json.loads(path.read_text("utf-8"))) == (conditions is not None)


@pytest.mark.parametrize(
    ("broken", "line"),
    [
        (3, "conditions: 3 is not a table; delete the file"),
        ("x", "conditions: 'x' is not a table; delete the file"),
        ({"plant": {"inertia": 3}}, "conditions.plant.inertia: 3 is not text; delete the file"),
        ({"moves": []}, "conditions.moves: [] is not text; delete the file"),
    ],
    ids=range(4),
)
def test_broken_conditions_are_explained(tmp_path, broken, line):
    (problem,) = problems(write(tmp_path, content() | {"conditions": broken}))
    assert problem.startswith(line)


def test_a_file_without_conditions_says_how_to_get_them():
    with pytest.raises(CheckError) as refusal:
        stored_conditions(BASELINE, Path("b.json"))
    assert str(refusal.value).startswith("b.json: was stored without the conditions")
    assert str(refusal.value).endswith("store it anew with --update")
    assert stored_conditions(replace(BASELINE, conditions={}), Path("b.json")) == {}


def test_positions_change_with_the_unit_and_nothing_else():
    converted = in_unit(BASELINE, "mas")
    assert converted.position_unit == "mas"
    peak, left = ("moves", "a.b", "peaks", "velocity"), list(NUMBERS)[2]
    assert converted.numbers[peak] == Stored(-100.0, 0.1, 2000.0)
    assert converted.numbers[left].atol == pytest.approx(1e-297)
    assert [converted.numbers[key] for key in list(NUMBERS)[:2]] == list(NUMBERS.values())[:2]
    check_origin(converted, Path("b.json"), "Axis [1]", "mas")


@pytest.mark.parametrize("unit", ["arcsec", "mm", "lux", None])
def test_a_unit_of_another_kind_leaves_a_baseline_as_it_is(unit):
    assert in_unit(BASELINE, unit) is BASELINE
    loop = replace(BASELINE, position_unit=None)
    assert in_unit(loop, "mm") is loop
