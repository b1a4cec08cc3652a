"""The gate: a scenario's numbers judged by its check file and its baseline."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..scenario import Scenario, load_scenario
from ..survey import Survey, UnstableLoopError, survey
from .baseline import Baseline, check_origin, load_baseline
from .check_file import CheckError, Checks, load_checks, read_check_file
from .comparison import FAILURES, NOTES, Row, compare, measured_baseline
from .numbers import survey_numbers


@dataclass(frozen=True, repr=False)
class GateReport:
    """What the gate found.

    Attributes
    ----------
    title : str
        The scenario's.
    path : Path
        The scenario's file.
    position_unit : str
        The unit of positions in `rows`.
    rows : tuple of Row
        One for every number, measured or stored; none where the loop is unstable.
    unstable : str
        What is wrong with an unstable loop; empty for a stable one.
    measured : Baseline or None
        What was measured, to be stored; None where the loop is unstable.
    update : bool
        Whether the baseline is about to be replaced, so that only the bounds count.
    """

    title: str
    path: Path
    position_unit: str
    rows: tuple[Row, ...]
    unstable: str = ""
    measured: Baseline | None = None
    update: bool = False

    @property
    def failures(self) -> tuple[Row, ...]:
        """The rows that fail: all that are out of bounds, worse, changed or gone."""
        failing = ("outside",) if self.update else FAILURES
        return tuple(row for row in self.rows if row.verdict in failing)

    @property
    def notes(self) -> tuple[Row, ...]:
        """The rows that pass, but that a new baseline would settle: better and new."""
        return tuple(row for row in self.rows if row.verdict in NOTES)

    @property
    def passed(self) -> bool:
        """Whether the loop is stable and no row fails."""
        return not self.unstable and not self.failures

    def __repr__(self) -> str:
        return f"GateReport({self.title!r}, rows={len(self.rows)}, passed={self.passed})"

    def __str__(self) -> str:
        from .formats import report_text

        return report_text(self)


def check_scenario(
    scenario: Scenario | str | Path,
    *,
    baseline: str | Path | None = None,
    checks: str | Path | None = None,
    update: bool = False,
) -> GateReport:
    """Judge the numbers of a scenario by its check file and its baseline.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario, or the path of its TOML file.
    baseline : str or Path, optional
        The stored numbers. Default: ``<scenario>.baseline.json`` beside the scenario, if there.
    checks : str or Path, optional
        Bounds and tolerances. Default: ``<scenario>.check.toml`` beside it, if there. A tolerance
        given to the number itself counts first, then the one stored in the baseline; the file's
        `rtol` of all numbers counts for those that are stored anew with the usual 1e-6.
    update : bool, optional
        Whether the baseline is about to be replaced: it need not be there, and only bounds
        count. The report's `measured` is what to store; nothing is written here.

    Returns
    -------
    GateReport
        An improvement passes, with a note; a change for the worse, or in a number that has no
        better side, fails. So does a number that is measured no more, and an unstable loop.

    Raises
    ------
    ScenarioError, CheckError
        For a scenario, check file or baseline that cannot be used, for a baseline of another
        scenario, and where there is neither baseline nor check file.
    ValueError
        Where gains cannot be designed or a move cannot be planned or driven.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario)
    stored_at = _there(baseline, baseline_beside(scenario.path), missing_is_fine=update)
    checks_at = _there(checks, checks_beside(scenario.path))
    if stored_at is None and checks_at is None and not update:
        raise CheckError(_nothing_to_judge_by(scenario.path))
    stored = Baseline(scenario.title, scenario.position_unit, {}) if update else None
    if stored_at is not None:
        stored = load_baseline(stored_at)
        check_origin(stored, stored_at, scenario.title, scenario.position_unit)
    if checks_at is not None:
        read_check_file(checks_at)  # before the work of the survey
    return _report(scenario, stored, checks_at, update=update)


def baseline_beside(scenario: Path) -> Path:
    """Return where the baseline of a scenario file is looked for."""
    return scenario.with_name(f"{scenario.stem}.baseline.json")


def checks_beside(scenario: Path) -> Path:
    """Return where the check file of a scenario file is looked for."""
    return scenario.with_name(f"{scenario.stem}.check.toml")


def _report(
    scenario: Scenario, stored: Baseline | None, checks_at: Path | None, *, update: bool
) -> GateReport:
    title, unit = scenario.title, scenario.position_unit
    try:
        found: Survey = survey(scenario)
    except UnstableLoopError as error:
        return GateReport(title, scenario.path, unit, (), unstable=str(error), update=update)
    numbers = survey_numbers(found)
    checks = Checks() if checks_at is None else load_checks(checks_at, numbers)
    rows = compare(numbers, stored, checks)
    measured = measured_baseline(numbers, stored, checks, scenario=title, position_unit=unit)
    return GateReport(title, scenario.path, unit, rows, measured=measured, update=update)


def _there(given: str | Path | None, beside: Path, *, missing_is_fine: bool = False) -> Path | None:
    """Return the file to read, if any: the one given, or the one beside the scenario."""
    if given is None:
        return beside if beside.exists() else None
    path = Path(given)
    return None if missing_is_fine and not path.exists() else path


def _nothing_to_judge_by(path: Path) -> str:
    return (
        f"{path}: there is nothing to judge it by; store its numbers with --update, or write "
        f"bounds into {checks_beside(path)}"
    )
