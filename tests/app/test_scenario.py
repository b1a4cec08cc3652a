"""Scenario files: values in SI, one clear line for each problem, and arbitrary content."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from jounce.analysis.specification import Mode, Specification
from jounce.app.scenario import (
    FilterSection,
    Gains,
    Scenario,
    ScenarioError,
    load_scenario,
)
from jounce.app.scenario_messages import EXAMPLE

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600
GOOD = """
[plant]
inertia = "2 kg m^2"
[controller]
gains = "design"
[controller.specification]
crossover = "1 Hz"
phase_margin = "45 deg"
lower_gain_margin = "12 dB"
[feedforward]
error = "10 %"
[filter]
corner = "2 Hz"
order = 6
[limits.axis]
acceleration = "0.2 deg/s^2"
jerk = ["-1 deg/s^3", "2 deg/s^3"]
[[moves]]
name = "go"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
"""
LINEAR = """
plant.inertia = "5 kg"
controller.gains = {kp = "3 N/mm", ki = "2 N/(m s)", kr = "0 N s/m"}
limits.axis = {velocity = "1 m/s", derivative_7 = "9 mm/s^7"}
moves = [{name = "go", distance = "-5 mm", settle_to = "1 um"}]
"""

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write_text(text: str) -> Path:
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write_text


def problems(path: Path) -> list[str]:
    """Return the lines of the refusal, without the file's name, which each must begin with."""
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(path)
    assert refusal.value.__cause__ is None
    assert refusal.value.__suppress_context__ or refusal.value.__context__ is None
    lines = str(refusal.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    assert not any(word in str(refusal.value) for word in ("Input should", "pydantic", "http"))
    return [line.removeprefix(f"{path}: ") for line in lines]


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


def test_values_are_in_si_units(write):
    scenario = load_scenario(write(GOOD))
    assert scenario.title == "case"
    assert scenario.motion == "angle"
    assert scenario.position_unit == "arcsec"
    assert scenario.position_scale == pytest.approx(ARCSEC, rel=4e-16)
    assert scenario.inertia == scenario.feedforward_inertia == 2.0
    assert scenario.inertia_error == 0.1
    assert scenario.gains == "design"
    assert scenario.specification == Specification(1.0, 45.0, 12.0)
    assert scenario.filter == FilterSection(2.0, 6)
    (move,) = scenario.moves
    assert (move.name, move.limits_name) == ("go", "axis")
    assert move.distance == pytest.approx(60 * ARCSEC, rel=4e-16)
    assert move.settle_to == pytest.approx(0.05 * ARCSEC, rel=4e-16)
    assert move.bounds[:2] == (math.inf, pytest.approx(0.2 * DEGREE, rel=4e-16))
    assert move.bounds[2:] == (pytest.approx((-DEGREE, 2 * DEGREE), rel=4e-16),)


def test_linear_axes_with_gains_of_their_own(write):
    scenario = load_scenario(write(LINEAR))
    assert (scenario.motion, scenario.position_unit) == ("length", "mm")
    assert scenario.inertia == scenario.feedforward_inertia == 5.0
    assert scenario.gains == Gains(3000.0, 2.0, 0.0)
    assert scenario.specification is None
    assert scenario.filter is None
    assert scenario.moves[0].distance == -0.005
    assert scenario.moves[0].bounds == (1.0, *[math.inf] * 5, 0.009)


def test_optional_keys_are_taken(write):
    head = 'title = "My axis"\nposition_unit = "deg"\n'
    feedforward = 'inertia = "2.2 N m s^2/rad"\nerror = "25 %"'
    scenario = load_scenario(write(head + changed('error = "10 %"', feedforward)))
    assert scenario.title == "My axis"
    assert scenario.position_unit == "deg"
    assert scenario.feedforward_inertia == 2.2
    assert scenario.inertia_error == 0.25


MODES = """
[[modes]]
name = "tower"
frequency = "12 Hz"
damping = "2 %"
[[modes]]
name = "go"
frequency = "90 rpm"
"""


def test_modes_are_taken(write):
    assert load_scenario(write(GOOD)).modes == ()
    assert load_scenario(write("modes = []\n" + GOOD)).modes == ()
    assert load_scenario(write(GOOD + MODES)).modes == (
        Mode("tower", 12.0, 0.02),
        Mode("go", 1.5, 0.0),
    )


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"12 Hz"', "12", "modes[0].frequency: 12 has no unit; write a positive frequency such as"),
        ('"12 Hz"', '"0 Hz"', "modes[0].frequency: '0 Hz' is out of range; write a positive freq"),
        ('"12 Hz"', '"12 s"', "modes[0].frequency: '12 s' has the wrong dimension; write a posit"),
        ('"2 %"', '"100 %"', "modes[0].damping: '100 %' is out of range; write a damping from 0 t"),
        ('"2 %"', '"-1 %"', "modes[0].damping: '-1 %' is out of range; write a damping from 0 to"),
        ('"2 %"', "0.02", "modes[0].damping: 0.02 has no unit; write a damping from 0 to below 10"),
        ('"2 %"', '"nan %"', "modes[0].damping: 'nan %' is not finite; write a damping from 0 to"),
        ('"go"', '"tower"', "modes[1].name: 'tower' is the name of an earlier mode; write one not"),
        ('"go"', '""', "modes[1].name: '' is not a name; write printable text such as"),
        ('frequency = "90 rpm"', "", 'modes[1].frequency: is missing; write frequency = "12 Hz"'),
        ("damping", "dampng", "modes[0].dampng: unknown key (with '2 %'); accepted: name, frequen"),
    ],
    ids=range(11),
)  # fmt: skip
def test_a_wrong_mode_is_explained(write, old, new, line):
    assert MODES.count(old) == 1
    (problem,) = problems(write(GOOD + MODES.replace(old, new)))
    assert problem.startswith(line)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("modes = 3\n" + GOOD, "modes: 3 is not a list of modes; write [[modes]] with name, frequ"),
        ("modes = [3]\n" + GOOD, "modes[0]: 3 is not a table; write [[modes]] with name, frequen"),
        ("[modes]\n" + GOOD, "modes: a table is not a list of modes; write [[modes]] with name,"),
        ("modes = [{}]\n" + GOOD, "modes[0].name: is missing; write name = \"tower\""),
    ],
    ids=range(4),
)  # fmt: skip
def test_misshapen_modes_are_explained(write, text, line):
    assert sum(problem.startswith(line) for problem in problems(write(text))) == 1


def test_a_byte_order_mark_is_ignored(write):
    assert load_scenario(write("\ufeff" + GOOD)).inertia == 2.0


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"2 kg m^2"', "2", 'plant.inertia: 2 has no unit; write a positive moment of inertia'),
        ('"2 kg m^2"', '"2 kg"', "plant.inertia: '2 kg' has the wrong dimension; write a positive"),
        ('"2 kg m^2"', '"-2 kg m^2"', "plant.inertia: '-2 kg m^2' is out of range; write"),
        ('inertia = "2 kg m^2"', "", 'plant.inertia: is missing; write inertia = "1 kg m^2"'),
        ("inertia", "inerta", "plant.inerta: unknown key (with '2 kg m^2'); accepted: inertia; di"),
        ('"design"', '"best"', "controller.gains: 'best' is not known; write 'design', 'published"),
        ('"design"', "3", "controller.gains: 3 is not known; write 'design', 'published'"),
        (
            '"design"',
            '{kp = "1 N m", ki = "0 N m/(rad s)", kr = "1 N m s/rad"}',
            "controller.gains.kp: '1 N m' has the wrong dimension; write a positive gain such as",
        ),
        (
            '"design"',
            '{kp = "0 N m/rad", ki = "0 N m/(rad s)", kr = "1 N m s/rad"}',
            "controller.gains.kp: '0 N m/rad' is out of range; write a positive gain such as",
        ),
        (
            '"design"',
            '{kp = "1 N m/rad", ki = "0 N m/(rad s)"}',
            'controller.gains.kr: is missing; write kr = "',
        ),
        (
            '"design"',
            '{kp = "1 N m/rad", ki = "0 N m/(rad s)", kr = "0 N m s/rad", kd = 1}',
            "controller.gains.kd: unknown key (with 1); accepted: kp, ki, kr; remove it",
        ),
        ('"1 Hz"', '"1 s"', "controller.specification.crossover: '1 s' has the wrong dimension"),
        ('"1 Hz"', '"0 Hz"', "controller.specification.crossover: '0 Hz' is out of range; write"),
        ('"45 deg"', '"90 deg"', "phase_margin: '90 deg' is out of range; write an angle between"),
        ('"45 deg"', "45", "controller.specification.phase_margin: 45 has no unit; write an angle"),
        ('"12 dB"', '"12"', "lower_gain_margin: '12' has no unit; write a positive ratio in dB"),
        ('"12 dB"', '"-1 dB"', "lower_gain_margin: '-1 dB' is out of range; write a positive rati"),
        ('"10 %"', '"0 %"', "feedforward.error: '0 %' is out of range; write a percentage between"),
        ('"10 %"', "0.1", "feedforward.error: 0.1 has no unit; write a percentage between 0 and"),
        ('"2 Hz"', '"nan Hz"', "filter.corner: 'nan Hz' is not finite; write a positive frequency"),
        ("= 6", "= 0", "filter.order: 0 is not a whole number from 1 to 50; write one without"),
        ("= 6", "= 51", "filter.order: 51 is not a whole number from 1 to 50"),
        ("= 6", "= true", "filter.order: true is not a whole number from 1 to 50"),
        ("= 6", "= 6.0", "filter.order: 6.0 is not a whole number from 1 to 50"),
        ("= 6", '= "6"', "filter.order: '6' is not a whole number from 1 to 50; write one without"),
        ('"0.2 deg/s^2"', '"0 deg/s^2"', "limits.axis.acceleration: '0 deg/s^2' is out of range"),
        ('"0.2 deg/s^2"', '"2 m/s^2"', "limits.axis.acceleration: '2 m/s^2' has the wrong dimensi"),
        ('"0.2 deg/s^2"', "inf", "limits.axis.acceleration: inf is not finite; write a positive"),
        ('"2 deg/s^3"]', '"-2 deg/s^3"]', "'-2 deg/s^3'] is not a pair around zero; write one"),
        (', "2 deg/s^3"]', "]", "limits.axis.jerk: ['-1 deg/s^3'] is not a pair around zero; writ"),
        ('"2 deg/s^3"]', "2]", "limits.axis.jerk: 2 has no unit; write an angular jerk such as"),
        ("jerk =", "jrek =", "limits.axis.jrek: unknown key (with ['-1 deg/s^3', '2 deg/s^3'])"),
        ("jerk =", "derivative_15 =", "pop, derivative_7 to derivative_14; did you mean derivativ"),
        ('"go"', '""', "moves[0].name: '' is not a name; write printable text such as"),
        ('"go"', "3", "moves[0].name: 3 is not a name; write printable text"),
        ('"go"', r'"a\nb"', r"moves[0].name: 'a\nb' is not a name; write printable text"),
        ('"60 arcsec"', '"0 arcsec"', "moves[0].distance: '0 arcsec' is no move; write a distance"),
        ('"60 arcsec"', "60", "moves[0].distance: 60 has no unit; write an angle such as '5 deg'"),
        ('"60 arcsec"', "[60]", "moves[0].distance: [60] is not a quantity in quotation marks"),
        ('"50 mas"', '"0 mas"', "moves[0].settle_to: '0 mas' is out of range; write a positive"),
        ('"50 mas"', '"60 arcsec"', "moves[0].settle_to: '60 arcsec' is not smaller than the dist"),
        ('settle_to = "50 mas"', "", 'moves[0].settle_to: is missing; write settle_to = "50 mas"'),
        ('"axis"', '"axes"', "moves[0].limits: 'axes' is not a set of limits here; write one of '"),
    ],
)  # fmt: skip
def test_a_problem_is_one_line_with_key_value_and_remedy(write, old, new, line):
    text = GOOD.replace(old, new, 1) if old == "inertia" else changed(old, new)
    found = [problem for problem in problems(write(text)) if line in problem]
    assert len(found) == 1
    assert any(remedy in found[0] for remedy in ("; write ", "; did you mean ", "; remove it"))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("colour = 3\n" + GOOD, "colour: unknown key (with 3); accepted: title, position_unit,"),
        ("tilte = 3\n" + GOOD, "moves; did you mean title?"),
        ("title = 3\n" + GOOD, "title: 3 is not a name; write printable text such as"),
        ('position_unit = "m"\n' + GOOD, "position_unit: 'm' has the wrong dimension; write the u"),
        ("position_unit = 3\n" + GOOD, "position_unit: 3 is not a unit in quotation marks; write"),
        (GOOD.replace('[plant]\ninertia = "2 kg m^2"', "plant = 3"), "plant: 3 is not a table; wr"),
        (GOOD.replace("[[moves]]", "[moves]"), "moves: a table is not a list of moves; write [[mo"),
        (GOOD + "[limits.empty]", "limits.empty: is empty; write at least one limit such as"),
        (LINEAR + "[limits.'a b']\nx = 3", 'limits."a b".x: unknown key (with 3); accepted: veloc'),
        (LINEAR.replace("limits", "limit"), "limits: is missing; write [limits.axis] with acc"),
        (LINEAR.replace("-5 mm", "5 deg"), "moves[0].distance: '5 deg' has the wrong dimension"),
        (GOOD[: GOOD.index("[[moves")], "moves: is missing; write [[moves]] with name, distance,"),
        ("moves = []\n" + GOOD[: GOOD.index("[[moves")], "moves: [] is not a list of moves; write"),
        ("limits = {}", "limits: is empty; write [limits.axis] with acceleration"),
        ('limits = {velocity = "1 m/s"}', "limits.velocity: '1 m/s' is not a table; write [limits"),
        ("moves = [3]", "moves[0]: 3 is not a table; write [[moves]] with name, distance"),
        ("[controller]", "specification: is missing, and gains = 'design' needs it; write [contr"),
        ("controller.specification = 3", "controller.specification: 3 is not a table; write [cont"),
    ],
)  # fmt: skip
def test_a_misshapen_file_is_explained(write, text, line):
    assert sum(line in problem for problem in problems(write(text))) == 1


def test_moves_are_named_once(write):
    move = GOOD[GOOD.index("[[moves]]") :]
    assert problems(write(GOOD + move)) == [
        "moves[1].name: 'go' is the name of an earlier move; write one not yet used"
    ]


def test_limits_may_be_left_out_only_where_there_is_one_set(write):
    text = changed('limits = "axis"\n', "")
    assert load_scenario(write(text)).moves[0].limits_name == "axis"
    second = '[limits.other]\njerk = "1 deg/s^3"\n'
    assert problems(write(text + second)) == [
        "moves[0].limits: is missing; write one of 'axis', 'other'"
    ]


def test_a_lone_linear_distance_among_angles_is_the_one_reported(write):
    text = changed('"60 arcsec"', '"60 mm"') + GOOD[GOOD.index("[[moves]]") :].replace("go", "back")
    assert problems(write(text)) == [
        "moves[0].distance: '60 mm' has the wrong dimension; write an angle such as '5 deg'"
    ]


def test_the_inertia_decides_between_one_angle_and_one_length(write):
    assert problems(write(LINEAR.replace("1 um", "1 mas"))) == [
        "moves[0].settle_to: '1 mas' has the wrong dimension; write a positive length "
        "such as '5 mm'"
    ]


def test_every_problem_is_reported(write):
    text = GOOD.replace('"2 kg m^2"', "2").replace("= 6", "= 0").replace('"50 mas"', "50")
    assert [line.split(":")[0] for line in problems(write(text))] == [
        "plant.inertia",
        "filter.order",
        "moves[0].settle_to",
    ]


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"", "holds no scenario; write [plant] with inertia, [controller.specification] with"),
        (b"# nothing", "holds no scenario; write [plant]"),
        (b"[plant]\ninertia = 2 kg", "not TOML: "),
        (b"title = 'caf\xe9'", "byte 12 is not UTF-8; save the file as UTF-8 text"),
        (b"a = " + b"[" * 9999, "not readable TOML: a number of thousands of digits or brackets"),
        (b"a = " + b"9" * 9999, "not readable TOML: a number of thousands of digits or brackets"),
    ],
    ids=["empty", "comment", "not-toml", "latin-1", "nested", "digits"],
)
def test_files_that_are_no_toml_are_explained(tmp_path, content, line):
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    (problem,) = problems(path)
    assert problem.startswith(line)


def test_where_toml_breaks_is_told(write):
    (problem,) = problems(write("[plant]\ninertia = 2 kg"))
    assert "line 2, column 13" in problem


@pytest.mark.parametrize("name", ["", "absent.toml", "a\0b"])
def test_paths_that_are_no_file_are_explained(tmp_path, name):
    (problem,) = problems(tmp_path / name)
    assert problem.endswith("; name a scenario file (TOML)")


def test_a_file_without_permission_is_explained(write, monkeypatch):
    def refuse(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refuse)
    assert problems(write(GOOD)) == ["Permission denied; name a scenario file (TOML)"]


@pytest.mark.parametrize(
    ("name", "gains"),
    [
        ("telescope.toml", "design"),
        ("telescope_published_gains.toml", "published"),
        ("rubin_mount.toml", "design"),
    ],
)
def test_examples_load(name, gains):
    scenario = load_scenario(EXAMPLES / name)
    assert scenario.gains == gains
    assert scenario.specification == Specification(1.0, 45.0, 12.0)
    assert len(scenario.moves) == 2


def test_every_example_is_tested():
    scenarios = {path.name for path in EXAMPLES.glob("*.toml")} - {"telescope.check.toml"}
    assert scenarios == {
        "telescope.toml",
        "telescope_published_gains.toml",
        "rubin_mount.toml",
    }


def test_rubin_limits_are_those_of_the_requirement():
    azimuth, elevation = load_scenario(EXAMPLES / "rubin_mount.toml").moves
    expected = tuple(DEGREE * bound for bound in (10.5, 10.5, 42.0))
    assert azimuth.bounds == pytest.approx(expected, rel=4e-16)
    assert elevation.bounds == pytest.approx(tuple(b / 2 for b in expected), rel=4e-16)


def test_the_built_in_example_of_all_keys_is_itself_a_scenario(write):
    text = "\n".join(f"{key} = {inline(value)}" for key, value in EXAMPLE.items())
    assert load_scenario(write(text)).title == "Telescope axis"


def inline(value: object) -> str:
    """Return a value as TOML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    return str(value)


SCALARS = (
    st.text(max_size=20)
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.dates()
    | st.datetimes()
    | st.sampled_from(["1 deg", "1e308 kg m^2", "-1 Hz", "1e-320 mas", "12 dB", "axis", "design"])
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["kp", "inertia", "jerk", "axis"]), inner, max_size=2)
    ),
    max_leaves=4,
)
PLACES = [line for line in GOOD.splitlines() if " = " in line]


@seed(2)
@settings(max_examples=250, deadline=None, database=None)
@given(place=st.sampled_from(PLACES), value=VALUES)
def test_any_value_anywhere_is_taken_or_explained(tmp_path_factory, place, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.toml"
    key = place.split(" = ")[0]
    path.write_text(GOOD.replace(place, f"{key} = {inline(value)}"), encoding="utf-8")
    assert_taken_or_explained(path)


@seed(3)
@settings(max_examples=150, deadline=None, database=None)
@given(key=st.sampled_from(sorted(EXAMPLE)), value=VALUES)
def test_any_section_is_taken_or_explained(tmp_path_factory, key, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.toml"
    sections = dict(EXAMPLE) | {key: value}
    text = "\n".join(f"{name} = {inline(section)}" for name, section in sections.items())
    path.write_text(text, encoding="utf-8")
    assert_taken_or_explained(path)


def assert_taken_or_explained(path: Path) -> None:
    try:
        scenario = load_scenario(path)
    except ScenarioError as error:
        lines = str(error).split("\n")
        if not all(line.startswith(f"{path}: ") for line in lines):
            raise AssertionError(lines) from None
    else:
        assert_finite(scenario)


def assert_finite(scenario: Scenario) -> None:
    numbers = [scenario.inertia, scenario.feedforward_inertia, scenario.inertia_error]
    numbers += [number for move in scenario.moves for number in (move.distance, move.settle_to)]
    assert all(math.isfinite(number) and number != 0.0 for number in numbers)
