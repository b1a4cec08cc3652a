"""`--json`: the numbers of each command as JSON alone on standard output."""

import json

import pytest
from good_scenario import GOOD

from jounce.app import survey_file
from jounce.fmu import export_fmu
from jounce.plant import Inertia


@pytest.fixture
def scenario(write):
    return write(GOOD)


def test_a_survey_has_the_survey_s_numbers(run, scenario):
    status, out, errors = run("survey", scenario, "--json")
    assert (status, errors) == (0, [])
    margins = survey_file(scenario).margins
    assert json.loads(out)["margins"]["phase_margin_deg"] == margins.phase_margin_deg


def test_a_check_has_every_number_with_its_verdict(run, scenario):
    run("check", scenario, "--update")
    status, out, _ = run("check", scenario, "--json")
    [report] = json.loads(out)
    assert (status, report["passed"]) == (0, True)
    assert {row["verdict"] for row in report["numbers"]} == {"same"}
    change = "controller.specification.phase_margin=40 deg"
    status, out, _ = run("check", scenario, "--json", "--set", change)
    [report] = json.loads(out)
    assert (status, report["passed"]) == (1, False)
    worse = {row["name"] for row in report["numbers"] if row["verdict"] == "worse"}
    assert "margins.phase_margin_deg" in worse


def test_a_plan_has_peaks_switches_and_the_proof(run):
    move = ("plan", "60 arcsec", "--acceleration", "0.2 deg/s^2")
    status, out, _ = run(*move, "--certify", "--json")
    plan = json.loads(out)
    assert status == 0
    assert plan["duration_s"] == pytest.approx(0.5773502692, rel=1e-9)
    assert plan["peaks"]["acceleration"]["limits"] == pytest.approx([-720.0, 720.0])
    assert plan["peaks"]["velocity"]["limits"] == [None, None]
    assert len(plan["switches"]["rows"]) == 3
    assert plan["proof"]["gap"] < 1e-9


def test_an_fmu_has_its_variables(run, tmp_path):
    export_fmu(Inertia(2.0), tmp_path / "motor.fmu")
    status, out, _ = run("fmu", "inspect", tmp_path / "motor.fmu", "--json")
    assert status == 0
    assert "u" in {variable["name"] for variable in json.loads(out)["variables"]}
