"""The measured loop that a scenario describes, and its survey."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from ..analysis.measured import MeasuredResponse, read_frf
from ..analysis.specification import Requirement
from ..analysis.survey_of_data import MeasuredSurvey, measured_survey
from ..analysis.unstable_loop import UnstableLoopError
from .scenario import Scenario
from .scenario_loop import controller_of


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class MeasuredScenarioSurvey(MeasuredSurvey):
    """The survey of a measured loop that a scenario describes, with the scenario."""

    scenario: Scenario

    @property
    def heading(self) -> tuple[str, ...]:
        """The lines above the tables: the title, and what stands in place of the file's values."""
        return (self.scenario.title, *self.scenario.overrides_told)


def measured_loop_of(scenario: Scenario) -> tuple[MeasuredResponse, Any]:
    """Return what was measured and the controller, None where that is in it; gains tuned if asked.

    Raises
    ------
    ValueError
        For a file that cannot be used, or gains that are not found: one line, with the key.
    """
    measured = _read(scenario)
    if scenario.gains == "measured":
        return measured, None
    return measured, controller_of(scenario, measured)


def survey_measured(
    scenario: Scenario, requirements: Sequence[Requirement] | None = None
) -> MeasuredScenarioSurvey:
    """Survey the measured loop that a scenario describes, by its own requirements or others.

    Errors name its file.
    """
    measured, controller = measured_loop_of(scenario)
    try:
        found = measured_survey(
            measured,
            controller,
            requirements=scenario.requirements if requirements is None else requirements,
            labels=scenario.labels,
        )
    except ValueError as error:
        kind = UnstableLoopError if isinstance(error, UnstableLoopError) else ValueError
        raise kind(f"{scenario.path}: {error}") from None
    own = {field.name: getattr(found, field.name) for field in fields(found)}
    return MeasuredScenarioSurvey(**own, scenario=scenario)


def _read(scenario: Scenario) -> MeasuredResponse:
    """Return the response of a file beside the scenario, sampled as its controller is."""
    frf = scenario.plant.frf
    assert frf is not None  # what the scenario's body says
    given = {field.name: getattr(frf, field.name) for field in fields(frf) if field.name != "file"}
    try:
        return read_frf(
            scenario.path.parent / frf.file, dt=scenario.controller.sample_time, **given
        )
    except ValueError as error:
        raise ValueError(f"{scenario.path}: plant.frf: {error}") from None
