"""The figures of a scenario at one point of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from math import inf, nan
from pathlib import Path
from typing import Any

from ...analysis.partial_survey import PartialSurvey
from ...analysis.specification import FIGURES, HIGHER_IS_BETTER, Requirement
from ...plant import PID, as_controller
from ..scenario import CascadeSection, Gains, Scenario, scenario_of
from ..scenario_commands import survey_conditions
from ..scenario_loop import jerk_filter_of, servo_loop_of
from ..scenario_measured import measured_loop_of, survey_measured


@dataclass(frozen=True)
class Problem:
    """What is worked out at every point: a scenario's content, and which figures of it.

    It is sent to other processes and machines, which need not have the file. With `hold_gains`
    the gains that a file has designed are designed for the plant as it stands in the file, and
    stay what they are however the plant varies.
    """

    path: Path
    content: Mapping[str, Any]
    keys: tuple[str, ...]
    figures: tuple[str, ...]
    hold_gains: bool = True
    _designed: dict[tuple[object, ...], Any] = field(
        default_factory=dict, repr=False, compare=False
    )

    def overrides(self, values: Sequence[object]) -> dict[str, object]:
        """Return what is put into the file at a point, held gains included."""
        given = dict(zip(self.keys, values, strict=True))
        if self.hold_gains and not any(key.startswith("controller.gains") for key in self.keys):
            gains = self._gains(given)
            if gains is not None:
                given["controller.gains"] = gains
        return given

    def scenario(self, values: Sequence[object]) -> Scenario:
        """Return the scenario at a point."""
        return self.with_overrides(self.overrides(values))

    def evaluate(self, values: Sequence[object]) -> tuple[tuple[float, ...], str]:
        """Return the figures at a point in the scenario's units; nan with the reason if it fails.

        A point that cannot be surveyed does not end the sweep; anything else than bad input
        does, being a mistake of ours.
        """
        try:
            scenario = self.scenario(values)
            labels = scenario.labels
            asked = [requirement_of(name) for name in self.figures]
            found = [
                value / labels.unit_of(each.unit)[1]
                for value, each in zip(_figures(scenario, asked), asked, strict=True)
            ]
        except ValueError as error:
            return (nan,) * len(self.figures), str(error)
        return tuple(found), ""

    def with_overrides(self, overrides: Mapping[str, object]) -> Scenario:
        """Return the scenario with values in place of the file's."""
        return scenario_of(self.path, deepcopy(dict(self.content)), overrides)

    def _gains(self, given: Mapping[str, object]) -> dict[str, str] | None:
        """Return the designed gains as a file has them; None where the file gives its own."""
        believed = {key: value for key, value in given.items() if not key.startswith("plant.")}
        key = tuple(believed.items())
        if key not in self._designed:
            self._designed[key] = _designed_gains(self.with_overrides(believed))
        known: dict[str, str] | None = self._designed[key]
        return known


def _figures(scenario: Scenario, asked: Sequence[Requirement]) -> Sequence[float]:
    """Return figures of a scenario in SI units, of a measured loop those of its margins."""
    if scenario.body == "frf":
        return [check.achieved for check in survey_measured(scenario, asked).requirements]
    conditions = survey_conditions(scenario)
    loop, behind = servo_loop_of(scenario), jerk_filter_of(scenario)
    partial = PartialSurvey(loop, scenario.moves, jerk_filter=behind, conditions=conditions)
    return partial.figures(asked)


def _designed_gains(scenario: Scenario) -> dict[str, str] | None:
    if isinstance(scenario.gains, Gains | CascadeSection) or scenario.gains == "measured":
        return None
    if scenario.body == "frf":
        law = as_controller(measured_loop_of(scenario)[1]).law
    else:
        law = servo_loop_of(scenario).controller_noun.law
    assert isinstance(law, PID)  # which alone is designed
    torque, per = ("N m", "rad") if scenario.motion == "angle" else ("N", "m")
    return {
        "kp": f"{law.kp!r} {torque}/{per}",
        "ki": f"{law.ki!r} {torque}/({per} s)",
        "kr": f"{law.kr!r} {torque} s/{per}",
    }


def requirement_of(name: str) -> Requirement:
    """Return a figure as what can be asked of a survey, by its worse side without a bound."""
    if name.rpartition(".")[2] in HIGHER_IS_BETTER:
        return Requirement(name, least=-inf)
    return Requirement(name, most=inf)


def check_figures(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of figures; ValueError for none, one twice, and one that there is not."""
    if isinstance(names, str):
        names = (names,)
    if not names:
        raise ValueError(
            "figures = []: nothing is asked for; give some of " + ", ".join(FIGURES) + ", or "
            "[requirements] in the scenario"
        )
    for name in names:
        requirement_of(name)
        if list(names).count(name) > 1:
            raise ValueError(f"figures: {name!r} is given twice; give it once")
    return tuple(names)
