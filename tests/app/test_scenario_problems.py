"""What is wrong in a scenario file: one clear line for each problem."""

from pathlib import Path

import pytest
from good_scenario import GOOD, LINEAR, MODES, changed

from jounce.app.scenario import (
    ScenarioError,
    load_scenario,
)


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
        ("tilte = 3\n" + GOOD, "moves, format; did you mean title?"),
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
