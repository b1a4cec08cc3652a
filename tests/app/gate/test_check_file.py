"""Check files: bounds and tolerances by name, one clear line for each problem."""

import math
from pathlib import Path

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st
from toml_values import inline

from jounce.app.gate.check_file import (
    CheckError,
    Checks,
    Requirement,
    load_checks,
    wants_baseline,
)
from jounce.app.gate.numbers import Number

EXAMPLES = Path(__file__).parents[3] / "examples"
NUMBERS = (
    Number(("margins", "phase_margin_deg"), 45.0, "higher"),
    Number(("margins", "upper_gain_margin_db"), math.inf, "higher"),
    Number(("step", "overshoot_percent"), 39.8, "lower"),
    Number(("moves", "60 arcsec step", "settling_time_s"), 1.676, "lower"),
    Number(("moves", "60 arcsec step", "residual_vibration", "min"), 1e-3, "lower"),
    Number(("moves", "[red]Größe", "settling_time_s"), 1.0, "lower"),
)
GOOD = """
rtol = 1e-4
[margins]
phase_margin_deg = { min = 44, rtol = 0 }
[step]
overshoot_percent = { min = 1, max = 42.5, atol = 0.1 }
[moves."60 arcsec step".residual_vibration]
min = { max = 1 }
[moves."[red]Größe"]
settling_time_s = { max = 2 }
[moves."60 arcsec step"]
"""


@pytest.fixture
def write(tmp_path):
    def write_text(text: str) -> Path:
        path = tmp_path / "case.check.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write_text


def problems(path: Path) -> list[str]:
    """Return the lines of the refusal, without the file's name, which each must begin with."""
    with pytest.raises(CheckError) as refusal:
        load_checks(path, NUMBERS)
    lines = str(refusal.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


def said(entry: str) -> str:
    """Return a check file that says something of the phase margin."""
    return f"[margins]\nphase_margin_deg = {{{entry}}}"


def test_bounds_and_tolerances_are_read(write):
    checks = load_checks(write(GOOD), NUMBERS)
    assert checks.rtol == 1e-4
    assert checks.requirements == {
        ("margins", "phase_margin_deg"): Requirement(least=44.0, rtol=0.0),
        ("step", "overshoot_percent"): Requirement(1.0, 42.5, atol=0.1),
        ("moves", "60 arcsec step", "residual_vibration", "min"): Requirement(most=1.0),
        ("moves", "[red]Größe", "settling_time_s"): Requirement(most=2.0),
    }
    assert checks.of(("margins", "upper_gain_margin_db")) == Requirement()


def test_a_bare_name_is_enough_where_one_number_has_it(write):
    text = "phase_margin_deg = { min = 44 }\nmin = { max = 1 }\n[margins]\n[step]"
    assert load_checks(write(text), NUMBERS).requirements == {
        ("margins", "phase_margin_deg"): Requirement(least=44.0),
        ("moves", "60 arcsec step", "residual_vibration", "min"): Requirement(most=1.0),
    }


def test_a_table_is_no_bare_name(write):
    """A mode may be called like a table."""
    numbers = (*NUMBERS, Number(("moves", "go", "residual_vibration", "step"), 1.0, "lower"))
    checks = load_checks(write("[step]\novershoot_percent = {max = 40}"), numbers)
    assert set(checks.requirements) == {("step", "overshoot_percent")}


@pytest.mark.parametrize("text", ["", "# nothing", "[margins]\n[moves]"])
def test_a_file_may_ask_nothing(write, text):
    assert load_checks(write(text), NUMBERS) == Checks()


def test_line_ends_and_byte_order_mark_of_other_platforms(tmp_path):
    path = tmp_path / "case.check.toml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_checks(path, NUMBERS).rtol == 1e-4


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[margins]\nphase_margin = {min = 4}", "margins.phase_margin: no number has this name; t"),
        ("[margins]\nphase_margin = {min = 4}", "there are phase_margin_deg, upper_gain_margin_db"),
        ("[margins]\nphase_margin = {min = 4}", "; did you mean margins.phase_margin_deg?"),
        ("[margin]\nphase_margin_deg = {min = 4}", "there are margins, step, moves; did you mean"),
        ("phase_margin = {min = 4}", "there are margins, step, moves; did you mean phase_margin_d"),
        ("settling_time_s = {max = 4}", 'write one of moves."60 arcsec step".settling_time_s, mov'),
        ("phase_margin_deg = 44", "margins.phase_margin_deg: 44 is not a table; write { min = 44"),
        (f"phase_margin_deg = {{min = 4}}\n{said('max = 9')}", "deg: is given twice, by its whole"),
        ("[step]\nphase_margin_deg = {min = 4}", "there are overshoot_percent; did you mean margi"),
        ("[moves.'60 arcsec stpe']\nx = 1", 'did you mean moves."60 arcsec step"?'),
        ("xyz = 3", "xyz: no number has this name; there are margins, step, moves; remove it"),
        ("atol = 1", "atol: no number has this name; there are margins, step, moves; remove it"),
        ("margins = 3", "margins: 3 is not a table; write margins.phase_margin_deg = { min = 45 }"),
        ("margins = []", "margins: [] is not a table; write margins.phase_margin_deg = { min = 45"),
        ("[margins]\nphase_margin_deg = 4", "margin_deg: 4 is not a table; write { min = 4 }"),
        ("[margins]\nupper_gain_margin_db = nan", "nan is not a table; write { min = 1 }"),
        ("[step]\novershoot_percent = 4", "overshoot_percent: 4 is not a table; write { max = 4 }"),
        ("[step]\novershoot_percent = true", "true is not a table; write { max = 39.8 }"),
        ("[step]\novershoot_percent = {}", "overshoot_percent: is empty; write { max = 39.8 }"),
        (said("mni = 4"), "margins.phase_margin_deg: mni is not known; write some of min, max, rt"),
        (said("min = '4 deg'"), "min = '4 deg' is not a number; write it plain, in the unit of th"),
        (said("min = true"), "min = true is not a number; write it plain, in the unit of the numb"),
        (said("min = nan"), "min = nan is not finite; write a finite number or leave min out"),
        (said("max = inf"), "max = inf is not finite; write a finite number or leave max out"),
        (said(f"min = 1{'0' * 400}"), "is not finite; write a finite number or leave min out"),
        (said("min = 4, max = 3"), "min = 4 is above max = 3; exchange them"),
        (said("rtol = -1e-6"), "rtol = -1e-06 is below zero; write a tolerance such as 1e-6"),
        (said("atol = nan"), "atol = nan is not finite; write a finite number or leave atol out"),
        ("rtol = -1", "rtol: -1 is below zero; write a tolerance such as 1e-6"),
        ("rtol = '1e-6'", "rtol: '1e-6' is not a number; write it plain, in the unit of the numbe"),
        ("[margins", "not TOML: "),
        ("a = " + "9" * 9999, "not readable TOML: a number of thousands of digits or brackets nes"),
    ],
    ids=range(32),
)  # fmt: skip
def test_a_problem_is_one_line_with_key_value_and_remedy(write, text, line):
    (problem,) = problems(write(text))
    assert line in problem
    remedies = ("; write ", "; did you mean ", "; remove ", "; exchange them", "; correct")
    assert any(remedy in problem for remedy in remedies)


def test_every_problem_is_reported(write):
    text = "rtol = -1\nxyz = 1\n[margins]\nphase_margin_deg = {min = nan, max = nan, tol = 1}"
    assert [line.split(":")[0] for line in problems(write(text))] == [
        "rtol",
        "xyz",
        *["margins.phase_margin_deg"] * 3,
    ]


@pytest.mark.parametrize("name", ["", "absent.toml", "a\0b"])
def test_paths_that_are_no_file_are_explained(tmp_path, name):
    (problem,) = problems(tmp_path / name)
    assert problem.endswith("; name a check file (TOML)")


def test_a_bound_admits_no_value_that_does_not_exist():
    assert Requirement().admits(math.nan)
    assert not Requirement(least=1.0).admits(math.nan)
    assert Requirement(least=1.0).admits(math.inf)
    assert not Requirement(most=1.0).admits(math.inf)


VALUES = st.recursive(
    st.text(max_size=5) | st.booleans() | st.integers() | st.floats() | st.dates(),
    lambda inner: (
        st.lists(inner, max_size=2)
        | st.dictionaries(st.sampled_from(["min", "max", "rtol", "x"]), inner, max_size=3)
    ),
    max_leaves=4,
)
PLACES = st.sampled_from(
    ["rtol", "margins", "moves", "margins.phase_margin_deg", 'moves."60 arcsec step"', "x.y"]
)


@seed(4)
@settings(max_examples=150, deadline=None, database=None)
@given(place=PLACES, value=VALUES)
def test_any_value_anywhere_is_taken_or_explained(tmp_path_factory, place, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.check.toml"
    path.write_text(f"{place} = {inline(value)}\n", encoding="utf-8")
    try:
        checks = load_checks(path, NUMBERS)
    except CheckError as error:
        if not all(line.startswith(f"{path}: ") for line in str(error).split("\n")):
            raise AssertionError(str(error)) from None
    else:
        assert all(asked.least <= asked.most for asked in checks.requirements.values())


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", True),
        ("baseline = true", True),
        ("baseline = false\nrtol = 1e-3", False),
        ("baseline = { max = 1 }", True),
    ],
)
def test_a_file_may_say_that_there_is_no_baseline(write, text, wanted):
    path = write(text)
    assert wants_baseline(path) is wanted
    number = Number(("moves", "go", "residual_vibration", "baseline"), 1.0, "lower")
    checks = load_checks(path, [*NUMBERS, number])
    assert set(checks.requirements) == ({number.key} if "max" in text else set())


@pytest.mark.parametrize("said", ["'none'", "0", "[]", "1.5", "2026-01-01"])
def test_anything_else_said_of_it_is_explained(write, said):
    path = write(f"baseline = {said}")
    with pytest.raises(CheckError, match=r"is neither true nor false; write baseline = false whe"):
        wants_baseline(path)
