"""The pytest fixture `margins_regression`: a loop's numbers, kept in a file beside the test."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pytest_regressions.common import perform_regression_check

from ...analysis.margins import LoopMargins, loop_margins
from ...analysis.measured import MeasuredMargins, MeasuredResponse
from ...plant import ServoLoop
from ...shaping.checks import finite
from ..result_files import write_files
from .baseline import Baseline, in_unit, load_baseline
from .check_file import CheckError, Checks, Requirement
from .comparison import compare, measured_baseline
from .conditions import Conditions, changes, scenario_conditions
from .numbers import Number, loop_numbers, measured_numbers, survey_numbers
from .report import table_text

if TYPE_CHECKING:
    import control
    import pytest
    from pytest_datadir.plugin import LazyDataDir

    from ...analysis.loop_survey import Survey
    from ...analysis.survey_of_data import MeasuredSurvey
    from ..scenario import Scenario

    Data: TypeAlias = control.FrequencyResponseData | MeasuredResponse | MeasuredMargins
    Loop: TypeAlias = control.StateSpace | control.TransferFunction | ServoLoop | LoopMargins | Data
    Checked: TypeAlias = Loop | Survey | MeasuredSurvey | Scenario | str | Path

_DIFFERENT = ("worse", "changed", "gone", "better")


class MarginsRegression:
    """The fixture `margins_regression`; it is made by pytest for one test."""

    def __init__(
        self, datadir: LazyDataDir, original_datadir: Path, request: pytest.FixtureRequest
    ) -> None:
        self._datadir = datadir
        self._original_datadir = original_datadir
        self._request = request
        self.force_regen = False
        self.with_test_class_names = False

    def check(
        self,
        loop: Checked,
        *,
        delay: float = 0.0,
        controller: Any = None,
        rtol: float | None = None,
        basename: str | None = None,
        fullpath: str | Path | None = None,
    ) -> None:
        """Compare the numbers of a loop with those kept in a JSON file beside the test.

        The first run writes the file and fails, as all of pytest-regressions' fixtures do;
        `pytest --force-regen` writes it anew. Any change beyond the tolerance fails, for the
        better too: the file says what the loop is like. So does a change of what the numbers
        depend on: the delay, or the conditions of a scenario. ::

            def test_axis(margins_regression):
                margins_regression.check(loop)

        Parameters
        ----------
        loop : control.StateSpace, control.TransferFunction, ServoLoop, LoopMargins, …
            An open loop L(s), a servo loop or a measured response, whose margins are kept; or a
            Survey, a Scenario or the path of a scenario file, of which every number is kept.
        delay : float, optional
            Pure delay in seconds behind an open loop or a continuous servo loop, as `loop_margins`
            takes it; a digital controller has its own.
        controller : Controller, PID, CascadedPI or python-control system, optional
            That of a plant, measured or a model, as `loop_margins` takes it. Margins of measured
            responses are compared within 3 standard deviations of their difference.
        rtol : float, optional
            Relative tolerance of every number. Default: the file's, 1e-6 where it is new.
        basename : str, optional
            Name of the file without its suffix, where a test checks several loops. Default:
            the test's name.
        fullpath : str or Path, optional
            Path of the file, in place of `basename`.

        Raises
        ------
        AssertionError
            Where a number, or what it depends on, differs, with a table of what was, is and is
            allowed; where the file is no baseline; where the loop is unstable.
        ValueError
            For a negative tolerance, for a delay of what has its margins already, and where the
            loop has no margins at all.
        """
        __tracebackhide__ = True
        if rtol is not None and finite("rtol", rtol) < 0.0:
            raise ValueError(f"rtol = {rtol!r}: expected a number not below zero")
        numbers, unit, conditions = _measured(loop, delay, controller)
        checks = Checks(requirements={number.key: Requirement(rtol=rtol) for number in numbers})
        baseline = measured_baseline(
            numbers, None, checks, position_unit=unit, conditions=conditions or None
        )
        perform_regression_check(
            datadir=self._datadir,
            original_datadir=self._original_datadir,
            request=self._request,
            check_fn=partial(_compare, numbers, baseline, checks),
            dump_fn=lambda path: write_files({path: baseline.write}),
            extension=".json",
            basename=basename,
            fullpath=None if fullpath is None else Path(fullpath),
            force_regen=self.force_regen,
            with_test_class_names=self.with_test_class_names,
        )


def _measured(
    loop: Checked, delay: float, controller: Any = None
) -> tuple[tuple[Number, ...], str | None, Conditions]:
    """Return the numbers of a loop, the unit of positions among them, and their conditions."""
    __tracebackhide__ = True
    from ...analysis.loop_survey import Survey
    from ...analysis.survey_of_data import MeasuredSurvey
    from ...analysis.unstable_loop import UnstableLoopError
    from ..scenario import Scenario
    from ..scenario_measured import MeasuredScenarioSurvey
    from ..scenario_survey import ScenarioSurvey, survey_file

    if delay and isinstance(loop, Scenario | str | Path | Survey | LoopMargins):
        raise ValueError(
            f"delay = {delay!r} of a {type(loop).__name__}: expected an open loop or a ServoLoop; "
            "give those, or loop_margins(…, delay=…)"
        )
    if isinstance(loop, Scenario | str | Path):
        try:
            loop = survey_file(loop)
        except UnstableLoopError as error:
            raise AssertionError(str(error)) from None
    if isinstance(loop, MeasuredSurvey) and loop.untold:
        raise AssertionError(" ".join(loop.untold))
    if isinstance(loop, Survey | MeasuredSurvey):
        conditions: Conditions = {}
        if isinstance(loop, ScenarioSurvey | MeasuredScenarioSurvey):
            conditions = scenario_conditions(loop.scenario)
        return survey_numbers(loop), loop.labels.position_unit, conditions
    margins = _margins(loop, delay, controller)
    if not margins.stable:
        raise AssertionError(f"there are no margins to keep: {margins.summary()}")
    if isinstance(margins, MeasuredMargins):
        return measured_numbers(margins), None, {}
    return loop_numbers(margins), None, {("delay",): f"{float(delay):.12g} s"} if delay else {}


def _margins(loop: Any, delay: float, controller: Any) -> LoopMargins | MeasuredMargins:
    if isinstance(loop, LoopMargins | MeasuredMargins):
        return loop
    margins: LoopMargins | MeasuredMargins = loop_margins(loop, delay=delay, controller=controller)
    return margins


def _compare(
    numbers: tuple[Number, ...], now: Baseline, checks: Checks, _obtained: Path, expected: Path
) -> None:
    __tracebackhide__ = True
    remedy = "If this is meant, run pytest --force-regen and commit the file."
    try:
        stored = in_unit(load_baseline(expected, anew="pytest --force-regen"), now.position_unit)
    except CheckError as error:
        raise AssertionError(f"{error}\n{remedy}") from None
    unit = now.position_unit
    if stored.position_unit != unit:
        raise AssertionError(
            f"{expected.name} has positions in {stored.position_unit}, not in {unit}. {remedy}"
        )
    if unit is not None and now.conditions and stored.conditions is None:
        raise AssertionError(
            f"{expected.name} was stored without the conditions of its numbers, so that none can "
            f"be compared. {remedy}"
        )
    changed = changes(stored.conditions or {}, now.conditions or {})
    rows = compare(numbers, stored, checks, two_sided=True)
    conditions = [each for each in changed if each.verdict in _DIFFERENT]
    different = [row for row in rows if row.verdict in _DIFFERENT]
    if conditions or different:
        title = f"{len(different)} of {len(rows)} numbers differ from {expected.name}"
        if conditions:
            title += f", and {len(conditions)} of the conditions that they depend on"
        raise AssertionError(f"{table_text([*changed, *different], title)}\n{remedy}")
