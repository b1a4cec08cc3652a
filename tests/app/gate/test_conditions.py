"""What numbers depend on: nothing of a scenario is forgotten, and nothing changes by rounding."""

import math
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import pytest

from jounce.analysis.specification import Mode
from jounce.app import load_scenario
from jounce.app.gate.conditions import Change, changes, scenario_conditions
from jounce.app.scenario import Gains, Scenario
from jounce.app.scenario_asked import WindSection
from jounce.shaping import InputShaper

EXAMPLES = Path(__file__).parents[3] / "examples"
OVERRIDES = {
    "limits.axis.jerk": ["-1 deg/s^3", "2 deg/s^3"],
    "controller.gains": {"kp": "28 N m/rad", "ki": "38 N m/(rad s)", "kr": "5.4 N m s/rad"},
}
REAL = ("telescope_azimuth", "wafer_stage", "gantry_crane", "servo_drive", "lift")
SCENARIO = load_scenario(EXAMPLES / "telescope.toml", overrides=OVERRIDES)
NAMES = {"path", "title", "motion", "position_unit", "overrides", "limits_name", "name"}
NAMES |= {"limit_sets", "requirements", "body", "counted", "disturbed"}


def varied(part):
    """Yield a part once for every value within it, that value made larger."""
    for field in fields(part):
        value = getattr(part, field.name)
        if field.name in NAMES or is_left_out(part, field, value):
            continue
        if isinstance(part, WindSection) and field.name == "kind":
            continue  # another kind has other keys
        for other in others(value):
            yield field.name, replace(part, **{field.name: other})


def is_left_out(part, field, value):
    return not isinstance(part, Scenario | Mode) and value == field.default


def others(value):
    if value is None:
        return
    if isinstance(value, InputShaper):
        yield InputShaper(value.times * (1 + 1e-6), value.amplitudes)
    elif isinstance(value, bool):
        yield not value
    elif isinstance(value, str):
        yield f"{value}, but another"
    elif is_dataclass(value):
        yield from (other for _, other in varied(value))
    elif isinstance(value, tuple):
        for i, entry in enumerate(value):
            for other in others(entry):
                yield (*value[:i], other, *value[i + 1 :])
    elif isinstance(value, float) and math.isinf(value):
        yield 1.0
    else:
        yield value + 1 if isinstance(value, int) else value * (1 + 1e-6)


VARIED = list(varied(SCENARIO))


def test_every_value_of_the_scenario_is_tried():
    """Inertia, 3 gains, 3 specifications, Ĵ, its error, 2 of the filter, 2 moves, a mode."""
    assert len(VARIED) == 1 + 3 + 3 + 1 + 1 + 2 + 2 * (1 + 4 + 1) + 2


@pytest.mark.parametrize("other", [other for _, other in VARIED], ids=range(len(VARIED)))
def test_a_change_of_any_value_is_told(other):
    stored = scenario_conditions(SCENARIO)
    (change,) = changes(stored, scenario_conditions(other))
    assert change.was != change.now
    (back,) = changes(scenario_conditions(other), stored)
    assert (back.was, back.now) == (change.now, change.was)


def test_conditions_fail_and_the_design_may_change():
    stored = scenario_conditions(SCENARIO)
    found = {
        change.name: change.verdict
        for _, other in VARIED
        for change in changes(stored, scenario_conditions(other))
    }
    redesigned = {name for name, verdict in found.items() if verdict == "redesigned"}
    assert redesigned == {
        "controller.gains.kp",
        "controller.gains.ki",
        "controller.gains.kr",
        "feedforward.inertia",
    }


def test_values_have_the_units_of_the_report():
    conditions = scenario_conditions(SCENARIO)
    move = ("moves", "60 arcsec step")
    assert conditions[*move, "distance"] == "60 arcsec"
    assert conditions[*move, "settle_to"] == "0.05 arcsec"
    assert conditions[*move, "limits", "acceleration"] == "720 arcsec/s^2"
    assert conditions[*move, "limits", "jerk"] == "-3600 to 7200 arcsec/s^3"
    assert (*move, "limits", "velocity") not in conditions
    assert conditions["plant", "inertia"] == "1 kg m^2"
    assert conditions["controller", "gains", "ki"] == "38 N m/(rad s)"
    assert conditions["controller", "specification", "lower_gain_margin"] == "12 dB"
    assert conditions["feedforward", "error"] == "10 %"
    assert conditions["modes", "mirror", "damping"] == "1 %"
    assert conditions["filter", "order"] == "6"


def test_a_linear_axis_has_its_own_units():
    conditions = scenario_conditions(replace(SCENARIO, motion="length", position_unit="mm"))
    assert conditions["plant", "inertia"] == "1 kg"
    assert conditions["controller", "gains", "kp"] == "28 N/m"


@pytest.mark.parametrize("body", ["inertia", "mass"])
def test_what_moves_has_the_key_of_the_file(body):
    conditions = scenario_conditions(replace(SCENARIO, body=body, motion="length"))
    assert conditions["plant", body] == "1 kg"
    assert {key[1] for key in conditions if key[0] == "plant"} == {body}
    assert not [k for k in scenario_conditions(replace(SCENARIO, body="chain")) if k[0] == "plant"]


def test_entries_without_a_name_are_told_by_number():
    change = Change(("controller", "filters", "0", "frequency"), "8 Hz", "9 Hz")
    assert change.name == "controller.filters[0].frequency"
    assert (
        Change(("plant", "modes", "tower", "damping"), "", "").name == "plant.modes.tower.damping"
    )


def test_less_than_rounding_is_no_change():
    stored = scenario_conditions(SCENARIO)
    move = SCENARIO.moves[0]
    rounded = replace(move, settle_to=math.nextafter(move.settle_to, 1.0))
    other = replace(SCENARIO, moves=(rounded, *SCENARIO.moves[1:]))
    assert changes(stored, scenario_conditions(other)) == ()
    assert changes({("a",): "0.1 mm"}, {("a",): "0.10000000000000002 mm"}) == ()
    assert changes({("a",): "0.1 mm"}, {("a",): "0.1 m"})
    assert changes({("a",): "0.1 mm"}, {("a",): "1e-4 m"}) == ()
    assert changes({("a",): "-1 to 2 mm/s^3"}, {("a",): "-1e-3 to 2e-3 m/s^3"}) == ()
    assert changes({("a",): "-1 to 2 mm/s^3"}, {("a",): "-1e-3 to 3e-3 m/s^3"})
    assert changes({("a",): "1 rad"}, {("a",): "1 m"})
    assert changes({("a",): "design"}, {("a",): "published"})
    assert changes({("a",): "6"}, {("a",): "7"})
    assert changes({("a",): "1 to 2 mm"}, {("a",): "1 mm"})
    assert changes({("a",): "nan"}, {("a",): "1"})


def test_a_limit_that_comes_or_goes_is_a_change():
    without = replace(
        SCENARIO, moves=tuple(replace(m, bounds=m.bounds[:2]) for m in SCENARIO.moves)
    )
    lost = changes(scenario_conditions(SCENARIO), scenario_conditions(without))
    assert [(c.now, c.verdict) for c in lost] == [("none", "changed")] * 2
    won = changes(scenario_conditions(without), scenario_conditions(SCENARIO))
    assert [c.was for c in won] == ["none"] * 2
    assert won[0].message == (
        'moves."60 arcsec step".limits.jerk is -3600 to 7200 arcsec/s^3, was none: changed, and '
        "numbers depend on it"
    )


def test_a_pair_of_equal_limits_is_one_limit():
    plain, pair, wider = (
        load_scenario(EXAMPLES / "telescope.toml", overrides={"limits.axis.jerk": jerk})
        for jerk in ("1 deg/s^3", ["-1 deg/s^3", "1 deg/s^3"], ["-1 deg/s^3", "1.1 deg/s^3"])
    )
    assert changes(scenario_conditions(plain), scenario_conditions(pair)) == ()
    assert len(changes(scenario_conditions(plain), scenario_conditions(wider))) == 2


def test_of_moves_and_modes_that_come_or_go_their_numbers_tell():
    more = replace(SCENARIO, modes=(*SCENARIO.modes, Mode("tower", 3.0, 0.1)))
    fewer = replace(SCENARIO, moves=SCENARIO.moves[:1], modes=())
    for was, now in ((SCENARIO, more), (more, SCENARIO), (SCENARIO, fewer), (fewer, SCENARIO)):
        assert changes(scenario_conditions(was), scenario_conditions(now)) == ()


def test_a_rule_for_the_gains_gives_way_to_gains():
    stored = scenario_conditions(replace(SCENARIO, gains="design"))
    found = changes(stored, scenario_conditions(replace(SCENARIO, gains=Gains(1.0, 2.0, 3.0))))
    assert {change.verdict for change in found} == {"redesigned"}
    assert Change(("controller", "gains"), "design", "none") in found


def test_a_loop_alone_may_gain_a_delay():
    (change,) = changes({}, {("delay",): "0.002 s"})
    assert (change.was, change.now, change.verdict) == ("none", "0.002 s", "changed")


@pytest.mark.parametrize("name", REAL)
def test_nothing_of_a_real_axis_is_forgotten(name):
    """Whatever value of the file is another one is told, once, the same whatever the order."""
    scenario = load_scenario(EXAMPLES / f"{name}.toml")
    stored = scenario_conditions(scenario)
    everything = list(varied(scenario))
    assert len(everything) > 20
    for field, other in everything:
        found = changes(stored, scenario_conditions(other))
        assert len(found) == 1, (field, found)
        assert found[0].was != found[0].now
    assert changes(stored, scenario_conditions(scenario)) == ()


def test_filters_and_feedforward_are_design_and_a_delay_is_not():
    given = {
        "controller.delay": "2 ms",
        "controller.derivative_filter": "3 ms",
        "plant.viscous": "30 N m s/rad",
    }
    axis = EXAMPLES / "telescope_azimuth.toml"
    was, now = (scenario_conditions(load_scenario(axis, overrides=o)) for o in ({}, given))
    assert {c.name: (c.was, c.now, c.verdict) for c in changes(was, now)} == {
        "controller.delay": ("0.0015 s", "0.002 s", "changed"),
        "controller.derivative_filter": ("0.002 s", "0.003 s", "redesigned"),
        "plant.viscous": ("20 N m s/rad", "30 N m s/rad", "changed"),
    }
