"""The gate on real loops: each number is guarded, and requirements fail a check."""

import pytest
from real_loops import AXIS, DIGITAL, REAL, J, move, real_survey
from real_scenario import scenario_survey

from jounce.analysis import Requirement, loop_margins, survey
from jounce.app.gate import check as gate
from jounce.app.gate import check_scenario
from jounce.app.gate.margins_regression import _measured
from jounce.app.gate.numbers import survey_numbers
from jounce.plant import InertiaFeedforward, ServoLoop


def checked(axis, monkeypatch, found, **options):
    monkeypatch.setattr(gate, "survey_file", lambda _: scenario_survey(axis, found))
    return check_scenario(axis, **options)


def test_a_delayed_digital_flexible_saturating_loop_is_guarded(axis, monkeypatch):
    found = real_survey()
    stored = checked(axis, monkeypatch, found, update=True)
    stored.measured.write(axis.with_name("axis.baseline.json"))
    report = checked(axis, monkeypatch, found)
    assert {row.verdict for row in report.rows} == {"same", "outside"}
    later = ServoLoop(REAL.plant, REAL.controller, InertiaFeedforward(1.01 * J))
    worse = checked(axis, monkeypatch, survey(later, [move()], labels=found.labels))
    verdicts = {row.name: row.verdict for row in worse.rows}
    assert verdicts["moves.slew.peak_load_error"] in ("worse", "better")
    assert verdicts["disturbance.peak"] == "gone"
    assert not worse.passed


def test_a_requirement_that_is_missed_fails_and_says_what_is_allowed(axis, monkeypatch):
    report = checked(axis, monkeypatch, real_survey(), update=True)
    [row] = report.failures
    assert row.name == "requirements.load_settling"
    assert (row.verdict, row.allowed) == ("outside", "<= 2")
    assert not report.passed
    asked = [Requirement("load_settling", most=60.0)]
    loop = ServoLoop(AXIS, DIGITAL, InertiaFeedforward(J))
    met = checked(axis, monkeypatch, survey(loop, [move()], requirements=asked), update=True)
    assert met.passed


def test_the_fixture_takes_digital_loops_and_surveys():
    numbers, unit, conditions = _measured(REAL, 0.0)
    assert (unit, conditions) == (None, {})
    margins = loop_margins(REAL)
    assert numbers[1].value == margins.phase_margin_deg
    numbers, unit, _ = _measured(real_survey(), 0.0)
    assert unit == "arcsec"
    assert numbers == survey_numbers(real_survey())
    with pytest.raises(ValueError, match=r"^delay = 0.001 with a system that is discrete"):
        _measured(REAL, 1e-3)
