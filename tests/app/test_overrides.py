"""Overridden keys: the file as if it had been edited, and one clear line for all else."""

from pathlib import Path

import numpy as np
import pytest

from jounce.app import check_scenario, load_scenario, survey_file
from jounce.app.overrides import read_overrides
from jounce.app.scenario import ScenarioError

TEXT = """
title = "Axis"
[plant]
inertia = "1 kg m^2"
[controller]
gains = "design"
specification = {crossover = "1 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
[limits.axis]
acceleration = "0.2 deg/s^2"
[[modes]]
name = "tower"
frequency = "1.3 Hz"
[[moves]]
name = "go"
distance = "60 arcsec"
settle_to = "50 mas"
[[moves]]
name = "back.to = \\"0\\""
distance = "-60 arcsec"
settle_to = "50 mas"
"""


@pytest.fixture
def path(tmp_path) -> Path:
    """Return a scenario file."""
    file = tmp_path / "axis.toml"
    file.write_text(TEXT, encoding="utf-8")
    return file


def edited(path: Path, old: str, new: str) -> Path:
    assert old in TEXT
    other = path.with_name("edited.toml")
    other.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    return other


def content(scenario) -> dict[str, object]:
    """Return all of a scenario but where it comes from."""
    return {k: v for k, v in vars(scenario).items() if k not in ("path", "overrides")}


LIMIT = 'acceleration = "0.2 deg/s^2"'


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        ("limits.axis.jerk=3 deg/s^3", LIMIT, f'{LIMIT}\njerk = "3 deg/s^3"'),
        ('limits.axis.jerk="3 deg/s^3"', LIMIT, f'{LIMIT}\njerk = "3 deg/s^3"'),
        (" limits . axis . jerk = 3 deg/s^3 ", LIMIT, f'{LIMIT}\njerk = "3 deg/s^3"'),
        ('limits.axis.jerk=["-1 deg/s^3", "2 deg/s^3"]', LIMIT,
         f'{LIMIT}\njerk = ["-1 deg/s^3", "2 deg/s^3"]'),
        ("limits.axis.acceleration=1 deg/s^2", "0.2 deg/s^2", "1 deg/s^2"),
        ("moves.go.settle_to=20 mas", "50 mas", "20 mas"),
        ("moves.0.settle_to=20 mas", "50 mas", "20 mas"),
        ("moves[0].settle_to=20 mas", "50 mas", "20 mas"),
        ("moves.'go'.settle_to=20 mas", "50 mas", "20 mas"),
        ("modes.tower.damping=2 %", '"1.3 Hz"', '"1.3 Hz"\ndamping = "2 %"'),
        ("modes[0].frequency=2 Hz", "1.3 Hz", "2 Hz"),
        ('filter={corner = "2 Hz", order = 4}', "[plant]",
         'filter = {corner = "2 Hz", order = 4}\n[plant]'),
        ("feedforward.error=5 %", "[plant]", 'feedforward.error = "5 %"\n[plant]'),
        ("controller.specification.crossover=2 Hz", "1 Hz", "2 Hz"),
        ("controller.gains=published", '"design"', '"published"'),
        ("title=a = b", '"Axis"', '"a = b"'),
        ('title="true"', '"Axis"', '"true"'),
        (r"""moves."back.to = \"0\"".distance=-90 arcsec""", "-60 arcsec", "-90 arcsec"),
        ("moves.'back.to = \"0\"'.distance=-90 arcsec", "-60 arcsec", "-90 arcsec"),
    ],
    ids=range(19),
)  # fmt: skip
def test_it_is_as_if_the_file_had_been_edited(path, text, old, new):
    found = load_scenario(path, overrides=read_overrides([text]))
    assert content(found) == content(load_scenario(edited(path, old, new)))
    assert len(found.overrides) == 1


def test_python_gives_values_as_toml_has_them(path):
    overrides = {"filter.corner": "2 Hz", "filter.order": 4, "limits.axis.velocity": "1 deg/s"}
    scenario = load_scenario(path, overrides=overrides)
    assert (scenario.filter.order, len(scenario.overrides)) == (4, 3)
    assert scenario.overrides[0] == "filter.corner = '2 Hz'"
    assert load_scenario(path, overrides={}) == load_scenario(path)


def test_numbers_of_numpy_are_numbers(path):
    for number in (np.int64(4), np.uint8(4), np.arange(5)[-1]):
        overrides = {"filter.corner": "2 Hz", "filter.order": number}
        assert load_scenario(path, overrides=overrides).filter.order == 4
    with pytest.raises(ScenarioError, match=r"override filter.order: 4.0 is not a whole number"):
        load_scenario(path, overrides={"filter.corner": "2 Hz", "filter.order": np.float64(4)})


@pytest.mark.parametrize("given", ["filter.order=4", ["filter.order=4"], [("filter.order", 4)]])
def test_what_is_no_mapping_is_refused(path, given):
    for use in (load_scenario, survey_file, check_scenario):
        with pytest.raises(TypeError, match=r"expected a mapping of keys to values, such as \{"):
            use(path, overrides=given)


def test_what_is_given_is_not_changed(path):
    gains = {"kp": "28 N m/rad", "ki": "38 N m/(rad s)", "kr": "5.4 N m s/rad"}
    given = {"controller.gains": gains, "controller.gains.kp": "30 N m/rad"}
    assert load_scenario(path, overrides=given).gains.kp == 30.0
    assert gains["kp"] == "28 N m/rad"


def test_survey_and_check_take_them(path):
    overrides = {"moves.go.distance": "90 arcsec"}
    expected = survey_file(load_scenario(path, overrides=overrides)).moves[0].duration_s
    assert survey_file(path, overrides=overrides).moves[0].duration_s == expected
    assert expected != survey_file(path).moves[0].duration_s
    path.with_name("axis.check.toml").write_text("baseline = false")
    rows = check_scenario(path, overrides=overrides).rows
    (duration,) = (row.now for row in rows if row.name == "moves.go.duration_s")
    assert duration == expected


def test_a_scenario_that_is_read_takes_none(path):
    scenario = load_scenario(path)
    for use in (survey_file, check_scenario):
        with pytest.raises(ScenarioError, match=r"give load_scenario\(path, overrides=…\)"):
            use(scenario, overrides={"title": "x"})


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("limits.axis.jrek=3 deg/s^3",
         "limits.axis.jrek: unknown key (with '3 deg/s^3'); accepted: velocity, "),
        ("limits.axsi.jerk=3 deg/s^3",
         "limits.axsi.jerk: limits has no entry 'axsi', it has \"axis\"; did you mean limits"),
        ("limits.axis.jerk=3 deg/s^2",
         "limits.axis.jerk: '3 deg/s^2' has the wrong dimension; write a positive angular jerk"),
        ("limits.axis.jerk=3", "limits.axis.jerk: 3 has no unit; write a positive angular jerk"),
        ("limits.axis.jerk=", "limits.axis.jerk: '' is empty; write"),
        ("limits.axis.jerk=3 deg/s^3\nx = 1", "limits.axis.jerk: '3 deg/s^3\\nx = 1' has no read"),
        ("controler.gains=design", "controler: unknown key (with a table); accepted: title, "),
        ("plant.inertai=1 kg m^2", "plant.inertai: unknown key (with '1 kg m^2'); accepted: inert"),
        ("plant=3", "plant: 3 is not a table; write [plant] with inertia"),
        ("plant.inertia.x=3",
         "plant.inertia.x: plant.inertia is '1 kg m^2', which has no keys; override plant.inertia"),
        ("moves.goo.settle_to=1 mas",
         "moves.goo.settle_to: moves has no entry 'goo', it has \"go\", \"back.to = \\\"0\\\"\"; "
         "did you mean moves.go?"),
        ("moves[2].settle_to=1 mas", "moves[2].settle_to: moves has no entry [2], it has "),
        ("moves[2]=1", "moves[2]: moves has no entry [2], it has "),
        ("moves.go.setle_to=1 mas", "moves[0].setle_to: unknown key (with '1 mas'); accepted: na"),
        ("moves.go.settle_to=61 arcsec", "moves[0].settle_to: '61 arcsec' is not smaller than the"),
        ("modes.towr.damping=1 %", "modes.towr.damping: modes has no entry 'towr', it has \"tower"),
        ("filter={corner='2 Hz'}", "filter.order: is missing; write order = 6"),
        ("filter={corner='2 Hz', order=4.5}", "filter.order: 4.5 is not a whole number from"),
        ("controller.gains.kp=3 N m/rad", "controller.gains.kp: controller.gains is 'design', whi"),
        (".title=x", "'.title': is not a key; write one such as limits.axis.jerk"),
        ("a..b=x", "'a..b': is not a key; write one such as limits.axis.jerk"),
        ("[0]=x", "'[0]': is not a key; write one such as limits.axis.jerk"),
        ("moves[x].distance=x", "'moves[x].distance': is not a key; write one such as"),
        ("moves[0]distance=x", "'moves[0]distance': is not a key; write one such as"),
    ],
    ids=range(24),
)  # fmt: skip
def test_one_line_says_what_is_wrong(path, text, line):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(path, overrides=read_overrides([text]))
    lines = str(refusal.value).splitlines()
    assert lines[0].startswith(f"{path}: override {line}")
    assert len(lines) == 1


def test_a_file_without_modes_has_none_to_override(path):
    path.write_text(TEXT.replace("[[modes]]", "[[moves]]").replace("frequency", "distance").replace(
        "1.3 Hz\"", "5 deg\"\nsettle_to = \"1 deg\""))  # fmt: skip
    with pytest.raises(ScenarioError, match="modes has no entry 'tower', it has none; write it in"):
        load_scenario(path, overrides={"modes.tower.damping": "1 %"})


def test_what_the_file_itself_says_wrong_is_not_said_of_an_override(path):
    other = edited(path, "50 mas", "50 s")
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(other, overrides={"plant.inertia": "2 kg m^2"})
    assert str(refusal.value).startswith(f"{other}: moves[0].settle_to: '50 s' has the wrong")


@pytest.mark.parametrize("text", ["", "x", "=3", '"moves.x=3', "'a=3"])
def test_what_has_no_key_is_refused(text):
    with pytest.raises(ValueError, match=r"--set .*: expected KEY=VALUE, such as --set limits"):
        read_overrides([text])


def test_a_key_is_given_once(path):
    with pytest.raises(ValueError, match="--set title: is given twice; give it once"):
        read_overrides(["title=a", "title = b"])
    twice = {"moves.go.distance": "9 arcsec", "moves[0].distance": "8 arcsec"}
    with pytest.raises(ScenarioError, match=r"override moves\[0\].distance: is given twice"):
        load_scenario(path, overrides=twice)
