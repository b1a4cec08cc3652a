"""The survey of a scenario file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ..analysis.loop_survey import Survey, survey
from ..analysis.unstable_loop import UnstableLoopError
from ..plant.discretise import FilterWarning
from ..shaping.warned import untold, warned_of
from .scenario import Scenario, as_scenario
from .scenario_commands import moves_of, survey_conditions
from .scenario_loop import jerk_filter_of, servo_loop_of
from .scenario_measured import MeasuredScenarioSurvey, survey_measured


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ScenarioSurvey(Survey):
    """The survey of a loop that a scenario describes, with the scenario."""

    scenario: Scenario

    @property
    def heading(self) -> tuple[str, ...]:
        """The lines above the tables: the title, another plant believed in, and overrides."""
        scenario = self.scenario
        return (scenario.title, *scenario.believed_told, *scenario.overrides_told)

    @property
    def findings(self) -> tuple[str, ...]:
        """Plain sentences on what does not meet its specification."""
        if self.scenario.gains != "published" or not self.missed:
            return super().findings
        return (
            "The gains printed in Thompson, Section VII (k_r = 11.09J, k_i = 6.286k_r, "
            f"k_p = 3.187k_r) miss their specifications: {self.missed}, where the "
            'text has 40 %. Use gains = "design" for a loop that meets them.',
            *self.unmet,
        )


def survey_file(
    scenario: Scenario | str | Path, *, overrides: Mapping[str, Any] | None = None
) -> ScenarioSurvey | MeasuredScenarioSurvey:
    """Survey the servo loop that a scenario file describes.

    Parameters
    ----------
    scenario : Scenario, str or Path
        The path of a TOML file, or what `load_scenario` made of one.
    overrides : mapping of str to object, optional
        Values in place of the file's, as `load_scenario` takes them.

    Returns
    -------
    ScenarioSurvey
        Of a plant that was measured a MeasuredScenarioSurvey: margins alone.

    Raises
    ------
    ScenarioError
        For a scenario file that cannot be used.
    UnstableLoopError
        Where the closed loop is unstable.
    ValueError
        Where gains cannot be designed or a move cannot be planned or driven.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """
    scenario = as_scenario(scenario, overrides)
    if scenario.body == "frf":
        return survey_measured(scenario)
    loop, behind = servo_loop_of(scenario), jerk_filter_of(scenario)
    moves, conditions = moves_of(scenario), survey_conditions(scenario)
    try:
        with warned_of(str(scenario.path)), untold(FilterWarning):
            found = survey(
                loop,
                moves,
                jerk_filter=behind,
                modes=scenario.modes,
                specification=scenario.specification,
                inertia_error=scenario.inertia_error,
                **conditions,
                labels=scenario.labels,
            )
    except ValueError as error:
        kind = UnstableLoopError if isinstance(error, UnstableLoopError) else ValueError
        raise kind(f"{scenario.path}: {error}") from None
    own = {field.name: getattr(found, field.name) for field in fields(found)}
    return ScenarioSurvey(**own, scenario=scenario)
