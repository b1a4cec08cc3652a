"""The gate: a scenario's numbers judged by its check file and its baseline."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...analysis.survey_of_data import MeasuredSurvey
from ...analysis.unstable_loop import UnstableLoopError
from ..scenario import Scenario, as_scenario
from ..scenario_survey import survey_file
from .baseline import Baseline, check_origin, in_unit, load_baseline, stored_conditions
from .check_file import CheckError, Checks, load_checks, wants_baseline, with_bounds
from .comparison import compare, measured_baseline
from .conditions import Change, changes, scenario_conditions
from .numbers import bounds_of, is_position, survey_numbers
from .report import GateReport


def check_scenario(
    scenario: Scenario | str | Path,
    *,
    baseline: str | Path | None = None,
    checks: str | Path | None = None,
    update: bool = False,
    overrides: Mapping[str, Any] | None = None,
) -> GateReport:
    """Judge the numbers of a scenario by its check file and its baseline.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario, or the path of its TOML file.
    baseline : str or Path, optional
        The stored numbers. Default: ``<scenario>.baseline.json`` beside the scenario.
    checks : str or Path, optional
        Bounds and tolerances. Default: ``<scenario>.check.toml`` beside it, if there. A tolerance
        given to the number itself counts first, then the one stored in the baseline; the file's
        `rtol` of all numbers counts for those that are stored anew with the usual 1e-6.
    update : bool, optional
        Whether the baseline is about to be replaced: it need not be there, and only bounds
        count. The report's `measured` is what to store; nothing is written here.
    overrides : mapping of str to object, optional
        Values in place of the scenario file's, as `load_scenario` takes them. They are compared
        like the file's own, and cannot be stored.

    Returns
    -------
    GateReport
        An improvement passes, with a note; a change for the worse, or in a number that has no
        better side, fails. So does a number that is measured no more, an unstable loop, a
        baseline that is missing though the check file does not say ``baseline = false``, and a
        condition (what the scenario asks and what is given, all but its gains and its
        feedforward's inertia) that is not as it was stored.

    Raises
    ------
    ScenarioError, CheckError
        For a scenario, check file or baseline that cannot be used, for a baseline of another
        scenario, and where there is neither baseline nor check file.
    ValueError
        Where gains cannot be designed or a move cannot be planned or driven.
    """
    scenario = as_scenario(scenario, overrides)
    if update and scenario.overrides:
        raise CheckError(
            f"{scenario.path}: a baseline is of the file as it is, not of what overrides it "
            f"({'; '.join(scenario.overrides)}); write that into the file, or store nothing"
        )
    beside = baseline_beside(scenario.path)
    stored_at = there(baseline, beside, missing_is_fine=update)
    checks_at = there(checks, checks_beside(scenario.path))
    missing = missing_baseline(scenario.path, stored_at, checks_at, update=update)
    stored = Baseline(scenario.title, scenario.position_unit, {}) if update else None
    changed: tuple[Change, ...] = ()
    unit_was = None
    if stored_at is not None:
        before = load_baseline(stored_at)
        unit_was = None if update else before.position_unit
        stored = in_unit(before, scenario.position_unit)
        check_origin(stored, stored_at, scenario.title, scenario.position_unit)
        if not (update and stored.conditions is None):
            changed = changes(stored_conditions(stored, stored_at), scenario_conditions(scenario))
    report = _report(scenario, stored, checks_at, unit_was)
    return replace(
        report, update=update, changes=changed, missing=missing, overrides=scenario.overrides
    )


def baseline_beside(scenario: Path) -> Path:
    """Return where the baseline of a scenario file is looked for."""
    return scenario.with_name(f"{scenario.stem}.baseline.json")


def checks_beside(scenario: Path) -> Path:
    """Return where the check file of a scenario file is looked for."""
    return scenario.with_name(f"{scenario.stem}.check.toml")


def _report(
    scenario: Scenario, stored: Baseline | None, checks_at: Path | None, unit_was: str | None
) -> GateReport:
    title, unit = scenario.title, scenario.position_unit
    try:
        found = survey_file(scenario)
    except UnstableLoopError as error:
        return GateReport(title, scenario.path, unit, (), unstable=str(error))
    if isinstance(found, MeasuredSurvey) and found.untold:
        return GateReport(title, scenario.path, unit, (), unstable=" ".join(found.untold))
    numbers = survey_numbers(found)
    written = Checks() if checks_at is None else load_checks(checks_at, numbers)
    if unit_was not in (None, unit):
        refuse_bounded_positions(written, checks_at, scenario, unit_was)
    checks = with_bounds(written, bounds_of(found))
    measured = measured_baseline(
        numbers,
        stored,
        checks,
        scenario=title,
        position_unit=unit,
        conditions=scenario_conditions(scenario),
    )
    rows = compare(numbers, stored, checks)
    return GateReport(title, scenario.path, unit, rows, measured=measured)


def refuse_bounded_positions(
    checks: Checks, at: Path | None, scenario: Scenario, unit_was: str | None
) -> None:
    """Refuse bounds of positions in a unit that is the scenario's no more."""
    unit = scenario.position_unit
    if any(map(is_position, checks.requirements)):
        raise CheckError(
            f"{at}: bounds positions in the scenario's unit, which was {unit_was} and is "
            f'{unit}; write position_unit = "{unit_was}" into {scenario.path}, or the bounds in '
            f"{unit} and store anew with --update"
        )


def there(given: str | Path | None, beside: Path, *, missing_is_fine: bool = False) -> Path | None:
    """Return the file to read, if any: the one given, or the one beside the scenario."""
    if given is None:
        return beside if beside.exists() else None
    path = Path(given)
    return None if missing_is_fine and not path.exists() else path


def missing_baseline(
    scenario: Path, stored_at: Path | None, checks_at: Path | None, *, update: bool
) -> str:
    """Return what to say of a baseline that is missing, or nothing; CheckError if none may be."""
    if checks_at is not None and not wants_baseline(checks_at):
        if update or stored_at is not None:
            there = "--update is to store one" if update else f"{stored_at} is there"
            remedy = "leave --update out" if update else "delete that file"
            raise CheckError(
                f"{checks_at}: says baseline = false, but {there}; remove the line, or {remedy}"
            )
        return ""
    if update or stored_at is not None:
        return ""
    if checks_at is None:
        raise CheckError(_nothing_to_judge_by(scenario))
    return (
        f"{baseline_beside(scenario)} is missing; store the numbers with --update, or write "
        f"baseline = false into {checks_at}"
    )


def _nothing_to_judge_by(path: Path) -> str:
    return (
        f"{path}: there is nothing to judge it by; store its numbers with --update, or write "
        f"bounds and baseline = false into {checks_beside(path)}"
    )
