"""Scenario files: values in SI units, optional keys, moves and limits, the examples."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from good_scenario import GOOD, LINEAR, MODES, changed
from toml_values import inline

from jounce.analysis.specification import Mode, Specification
from jounce.app.scenario import (
    FilterSection,
    Gains,
    load_scenario,
)
from jounce.app.scenario_messages import EXAMPLE

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600


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


def test_modes_are_taken(write):
    assert load_scenario(write(GOOD)).modes == ()
    assert load_scenario(write("modes = []\n" + GOOD)).modes == ()
    assert load_scenario(write(GOOD + MODES)).modes == (
        Mode("tower", 12.0, 0.02),
        Mode("go", 1.5, 0.0),
    )


def test_a_byte_order_mark_is_ignored(write):
    assert load_scenario(write("\ufeff" + GOOD)).inertia == 2.0


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
    """Those of format 2 in test_scenario_examples.py."""
    ideal = {"telescope.toml", "telescope_published_gains.toml", "rubin_mount.toml"}
    scenarios = {path.name for path in EXAMPLES.glob("*.toml") if "." not in path.stem}
    assert {
        name for name in scenarios if "format = 2" not in (EXAMPLES / name).read_text()
    } == ideal


def test_rubin_limits_are_those_of_the_requirement():
    azimuth, elevation = load_scenario(EXAMPLES / "rubin_mount.toml").moves
    expected = tuple(DEGREE * bound for bound in (10.5, 10.5, 42.0))
    assert azimuth.bounds == pytest.approx(expected, rel=4e-16)
    assert elevation.bounds == pytest.approx(tuple(b / 2 for b in expected), rel=4e-16)


def test_a_file_of_format_1_may_say_so(write):
    assert load_scenario(write("format = 1\n" + GOOD)) == load_scenario(write(GOOD))


def test_a_file_of_format_1_is_one_of_format_2_too(write):
    assert load_scenario(write("format = 2\n" + GOOD + MODES)).inertia == 2.0
    same = [load_scenario(write(head + GOOD + MODES)) for head in ("", "format = 2\n")]
    assert replace(same[1], limit_sets={}) == same[0]


def test_the_built_in_example_of_all_keys_is_itself_a_scenario(write):
    text = "\n".join(f"{key} = {inline(value)}" for key, value in EXAMPLE.items())
    assert load_scenario(write(text)).title == "Telescope axis"
