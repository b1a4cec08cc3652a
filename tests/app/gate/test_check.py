"""The gate from scenario to verdict: which files it takes, and what passes."""

import json
from pathlib import Path

import pytest
from gated_axis import AXIS, MODE, change, store, verdicts

from jounce.app import load_scenario
from jounce.app.gate import CheckError, check_scenario
from jounce.app.scenario import ScenarioError

EXAMPLES = Path(__file__).parents[3] / "examples"


def test_what_is_stored_passes(axis):
    assert set(verdicts(store(axis)).values()) == {"new"}
    report = check_scenario(axis)
    assert report.passed
    assert report.failures == report.notes == ()
    assert set(verdicts(report).values()) == {"same"}
    assert report.measured.text() == axis.with_name("axis.baseline.json").read_text()


def test_a_regression_fails(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "5.0 N m s/rad")
    report = check_scenario(axis)
    assert not report.passed
    found = verdicts(report)
    assert found["margins.phase_margin_deg"] == "worse"
    assert found["margins.crossover_hz"] == "changed"
    assert found["moves.go.duration_s"] == "same"
    assert {row.verdict for row in report.failures} == {"worse", "changed"}


def edit(scenario: Path, name: str, value: float | None) -> None:
    """Change the value of a margin in the baseline."""
    path = scenario.with_name("axis.baseline.json")
    tree = json.loads(path.read_text())
    tree["numbers"]["margins"][name]["value"] = value
    path.write_text(json.dumps(tree))


def test_an_improvement_alone_passes_with_a_note(axis):
    store(axis)
    edit(axis, "phase_margin_deg", 40.0)
    report = check_scenario(axis)
    assert report.passed
    assert [row.name for row in report.notes] == ["margins.phase_margin_deg"]


def test_a_margin_that_nothing_limited_and_now_does_is_a_regression(axis):
    store(axis)
    edit(axis, "lower_gain_margin_db", None)
    (row,) = check_scenario(axis).failures
    assert (row.was_shown, row.allowed, row.verdict) == ("none", "none", "worse")


def test_a_margin_that_nothing_limits_any_more_is_an_improvement(axis):
    store(axis)
    edit(axis, "upper_gain_margin_db", 60.0)
    report = check_scenario(axis)
    assert report.passed
    assert [(row.was_shown, row.now_shown) for row in report.notes] == [("60", "none")]


def test_a_tolerance_of_the_check_file_lets_a_number_move(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "5.4001 N m s/rad")
    failing = check_scenario(axis).failures
    assert failing
    entries = [f"{row.name} = {{ rtol = 1e-3 }}\n" for row in failing]
    axis.with_name("axis.check.toml").write_text("".join(entries))
    assert check_scenario(axis).passed


def test_the_tolerance_of_all_numbers_counts_once_it_is_stored(axis):
    store(axis)
    axis.with_name("axis.check.toml").write_text("rtol = 1e-3\n")
    original = axis.read_text()
    change(axis, "5.4 N m s/rad", "5.4001 N m s/rad")
    assert not check_scenario(axis).passed
    axis.write_text(original)
    store(axis)
    change(axis, "5.4 N m s/rad", "5.4001 N m s/rad")
    assert check_scenario(axis).passed


def test_a_tolerance_of_all_numbers_does_not_override_a_stored_one(axis):
    store(axis)
    path = axis.with_name("axis.baseline.json")
    tree = json.loads(path.read_text())
    tree["numbers"]["margins"]["phase_margin_deg"]["rtol"] = 0.5
    path.write_text(json.dumps(tree))
    axis.with_name("axis.check.toml").write_text("rtol = 1e-9\n")
    change(axis, "5.4 N m s/rad", "5.0 N m s/rad")
    report = check_scenario(axis)
    assert verdicts(report)["margins.phase_margin_deg"] == "same"
    assert report.measured.numbers["margins", "phase_margin_deg"].rtol == 0.5
    assert report.measured.numbers["margins", "disk_margin"].rtol == 1e-9


def test_bounds_alone_decide_without_a_baseline(axis):
    checks = axis.with_name("axis.check.toml")
    checks.write_text("baseline = false\n[margins]\nphase_margin_deg = {min = 40}")
    report = check_scenario(axis)
    assert report.passed
    assert verdicts(report)["margins.phase_margin_deg"] == "within"
    assert verdicts(report)["margins.crossover_hz"] == "unchecked"
    checks.write_text("baseline = false\n[margins]\nphase_margin_deg = {min = 60}")
    assert [row.name for row in check_scenario(axis).failures] == ["margins.phase_margin_deg"]


@pytest.mark.parametrize("said", ["", "baseline = true\n", "[margins]\nphase_margin_deg = {min=1}"])
def test_a_missing_baseline_fails_unless_the_check_file_says_that_there_is_none(axis, said):
    checks = axis.with_name("axis.check.toml")
    checks.write_text(said)
    report = check_scenario(axis)
    assert not report.passed
    assert report.failures == ()
    assert report.missing == (
        f"{axis.with_name('axis.baseline.json')} is missing; store the numbers with --update, or "
        f"write baseline = false into {checks}"
    )
    assert report.missing in str(report)
    store(axis)
    assert check_scenario(axis).passed


def test_a_baseline_that_is_there_though_there_is_said_to_be_none(axis):
    store(axis)
    axis.with_name("axis.check.toml").write_text("baseline = false")
    with pytest.raises(CheckError, match=r"says baseline = false, but .*json is there; remove"):
        check_scenario(axis)
    with pytest.raises(CheckError, match=r"says baseline = false, but --update is to store one"):
        check_scenario(axis, update=True)


def test_an_update_passes_where_the_bounds_hold(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "5.0 N m s/rad")
    assert check_scenario(axis, update=True).passed
    checks = axis.with_name("strict.toml")
    checks.write_text("[margins]\nphase_margin_deg = {min = 60}")
    report = check_scenario(axis, checks=checks, update=True)
    assert [row.verdict for row in report.failures] == ["outside"]


def test_new_and_vanished_numbers(axis):
    store(axis)
    axis.write_text(AXIS + MODE, encoding="utf-8")
    report = check_scenario(axis)
    assert report.passed
    assert [row.name for row in report.notes] == ["moves.go.residual_vibration.tower"]
    store(axis)
    axis.write_text(AXIS, encoding="utf-8")
    report = check_scenario(axis)
    assert [(row.name, row.verdict) for row in report.failures] == [
        ("moves.go.residual_vibration.tower", "gone")
    ]


def test_overrides_are_compared_but_not_stored(axis):
    store(axis)
    wider = {"moves.go.settle_to": "0.5 arcsec"}
    report = check_scenario(axis, overrides=wider)
    assert [row.name for row in report.failures] == ["moves.go.settle_to"]
    assert report.overrides == ("moves.go.settle_to = '0.5 arcsec'",)
    assert "with moves.go.settle_to = '0.5 arcsec'" in str(report)
    assert "--update" not in str(report)
    for scenario, overrides in ((axis, wider), (load_scenario(axis, overrides=wider), None)):
        with pytest.raises(CheckError, match="not of what overrides it"):
            check_scenario(scenario, overrides=overrides, update=True)
    assert check_scenario(axis, overrides={"moves.go.settle_to": "0.05 arcsec"}).passed


def test_an_unstable_loop_fails_and_is_not_stored(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "1 N m s/rad")
    for update in (False, True):
        report = check_scenario(axis, update=update)
        assert not report.passed
        assert report.measured is None
        assert "UNSTABLE" in report.unstable


def test_the_files_may_lie_anywhere(axis, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    baseline, checks = tmp_path / "elsewhere" / "b", tmp_path / "elsewhere" / "c"
    checks.write_text("[step]\novershoot_percent = {max = 1}")
    check_scenario(axis, update=True).measured.write(baseline)
    report = check_scenario(str(axis), baseline=str(baseline), checks=str(checks))
    assert [row.name for row in report.failures] == ["step.overshoot_percent"]
    assert check_scenario(load_scenario(axis), baseline=baseline).passed


def test_it_needs_something_to_judge_by(axis):
    with pytest.raises(CheckError) as refusal:
        check_scenario(axis)
    assert str(refusal.value) == (
        f"{axis}: there is nothing to judge it by; store its numbers with --update, or write "
        f"bounds and baseline = false into {axis.with_name('axis.check.toml')}"
    )


@pytest.mark.parametrize("option", ["baseline", "checks"])
def test_a_file_that_is_not_there_is_named(axis, option):
    with pytest.raises(CheckError, match=r"nowhere: No such file or directory; name a"):
        check_scenario(axis, **{option: "nowhere"})


@pytest.mark.parametrize("option", ["baseline", "checks"])
@pytest.mark.parametrize("update", [False, True])
def test_a_folder_is_named(axis, option, update, tmp_path):
    with pytest.raises(CheckError, match=r"Is a directory; name a"):
        check_scenario(axis, **{option: tmp_path}, update=update)


@pytest.mark.parametrize("update", [False, True])
def test_a_baseline_of_another_scenario_is_refused(axis, update):
    store(axis)
    change(axis, '"Axis"', '"Another"')
    with pytest.raises(CheckError, match="is the baseline of 'Axis', not of 'Another'"):
        check_scenario(axis, update=update)


def test_a_file_that_is_no_baseline_is_not_updated(axis):
    with pytest.raises(CheckError, match="not JSON"):
        check_scenario(axis, baseline=axis, update=True)


def test_a_broken_scenario_is_explained(tmp_path):
    with pytest.raises(ScenarioError, match="No such file"):
        check_scenario(tmp_path / "absent.toml")


def test_the_report_prints(axis):
    store(axis)
    change(axis, "5.4 N m s/rad", "5.0 N m s/rad")
    report = check_scenario(axis)
    assert repr(report) == f"GateReport('Axis', rows={len(report.rows)}, passed=False)"
    text = str(report)
    assert "Check of Axis, positions in arcsec" in text
    assert "FAILED: " in text
    assert "margins.phase_margin_deg" in text


def test_the_example_passes():
    report = check_scenario(EXAMPLES / "telescope.toml")
    assert report.passed
    assert {row.verdict for row in report.rows} <= {"same", "new"}
