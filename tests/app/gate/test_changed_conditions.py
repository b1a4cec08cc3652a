"""The gate where a scenario's requirements changed: told until they are stored."""

import json

import pytest
from gated_axis import AXIS, MODE, change, store, verdicts

from jounce.app.gate import CheckError, check_scenario

REQUIREMENTS = [
    ("tolerance", "50 mas", "500 mas", "moves.go.settle_to", "0.05 arcsec"),
    ("distance", "60 arcsec", "59 arcsec", "moves.go.distance", "60 arcsec"),
    ("limit", "0.2 deg/s^2", "0.21 deg/s^2", "moves.go.limits.acceleration", "720 arcsec/s^2"),
    ("damping", "2 %", "20 %", "modes.tower.damping", "2 %"),
    ("frequency", "1.3 Hz", "13 Hz", "modes.tower.frequency", "1.3 Hz"),
    ("inertia", '[plant]\ninertia = "1 kg m^2"', '[plant]\ninertia = "1.01 kg m^2"',
     "plant.inertia", "1 kg m^2"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "name", "was"),
    [each[1:] for each in REQUIREMENTS],
    ids=[r[0] for r in REQUIREMENTS],
)
def test_a_changed_requirement_fails_until_it_is_stored(axis, old, new, name, was):
    axis.write_text(AXIS + MODE + '[feedforward]\ninertia = "1 kg m^2"\n', encoding="utf-8")
    store(axis)
    change(axis, old, new)
    report = check_scenario(axis)
    assert not report.passed
    (changed,) = report.changes
    assert changed in report.failures
    assert (changed.name, changed.was, changed.verdict) == (name, was, "changed")
    assert changed.now.split()[0] != was.split()[0]
    assert name in str(report)
    assert check_scenario(axis, update=True).passed
    store(axis)
    assert check_scenario(axis).changes == ()


def test_a_wrong_inertia_of_another_size_is_another_condition(axis):
    axis.write_text(AXIS + '[feedforward]\nerror = "10 %"\n', encoding="utf-8")
    store(axis)
    change(axis, "10 %", "1 %")
    (changed,) = check_scenario(axis).failures
    assert changed.message == (
        "feedforward.error is 1 %, was 10 %: changed, and numbers depend on it"
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("50 mas", "0.05 arcsec"),
        ("60 arcsec", "1 arcmin"),
        ("0.2 deg/s^2", "720 arcsec/s^2"),
        ("1 kg m^2", "1000 g m^2"),
        ("2 %", "2 percent"),
        ("1.3 Hz", "78 rpm"),
        ('name = "go"', 'name = "go"\nlimits = "axis"'),
    ],
)
def test_the_same_in_other_words_is_no_change(axis, old, new):
    text = f'position_unit = "arcsec"\n{AXIS}{MODE}'
    axis.write_text(text, encoding="utf-8")
    store(axis)
    change(axis, old, new)
    report = check_scenario(axis)
    assert report.passed
    assert report.changes == ()


@pytest.mark.parametrize("unit", ["mas", "deg"])
def test_another_unit_of_positions_is_no_change(axis, unit):
    axis.write_text(AXIS + MODE, encoding="utf-8")
    store(axis)
    axis.write_text(f'position_unit = "{unit}"\n{AXIS}{MODE}', encoding="utf-8")
    report = check_scenario(axis)
    assert report.passed
    assert (report.position_unit, report.changes) == (unit, ())
    assert set(verdicts(report).values()) == {"same"}
    change(axis, "50 mas", "51 mas")
    (changed,) = check_scenario(axis).changes
    assert changed.was == "0.05 arcsec"
    assert changed.now.endswith(f" {unit}")
    store(axis)
    assert check_scenario(axis).measured.position_unit == unit
    assert check_scenario(axis).passed


def test_a_first_distance_in_another_unit_is_no_change(axis):
    store(axis)
    change(axis, "60 arcsec", "1 arcmin")
    report = check_scenario(axis)
    assert report.passed
    assert report.position_unit == "arcmin"


def test_bounds_of_positions_do_not_change_their_unit_in_silence(axis):
    store(axis)
    checks = axis.with_name("axis.check.toml")
    checks.write_text("[moves.go]\npeaks.velocity = {max = 210}")
    change(axis, "60 arcsec", "1 arcmin")
    with pytest.raises(CheckError, match="which was arcsec and is arcmin; write position_unit = "):
        check_scenario(axis)
    assert check_scenario(axis, update=True).passed
    axis.write_text('position_unit = "arcsec"\n' + axis.read_text())
    assert check_scenario(axis).passed
    checks.write_text("[moves.go]\nduration_s = {max = 2}")
    axis.write_text(axis.read_text().replace('"arcsec"', '"mas"'))
    assert check_scenario(axis).passed


def test_a_new_design_passes_on_its_numbers(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "5.40000001 N m s/rad")
    report = check_scenario(axis)
    assert report.passed
    assert [(c.name, c.verdict) for c in report.changes] == [("controller.gains.kr", "redesigned")]


def test_a_baseline_without_conditions_is_refused_until_it_is_stored_anew(axis):
    store(axis)
    path = axis.with_name("axis.baseline.json")
    tree = json.loads(path.read_text())
    del tree["conditions"]
    tree["numbers"]["margins"]["phase_margin_deg"]["rtol"] = 0.5
    path.write_text(json.dumps(tree))
    with pytest.raises(CheckError, match=r"without the conditions.*anew with --update$"):
        check_scenario(axis)
    assert store(axis).measured.numbers["margins", "phase_margin_deg"].rtol == 0.5
    assert check_scenario(axis).passed
