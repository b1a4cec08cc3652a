"""The survey of a measured loop as plain data."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from .survey_data import described

if TYPE_CHECKING:
    from .scenario_measured import MeasuredScenarioSurvey


def measured_data(survey: MeasuredScenarioSurvey) -> dict[str, Any]:
    """Return every number of the survey of a measured loop; those that do not exist are None."""
    scenario, measured = survey.scenario, survey.measured
    return {
        "title": scenario.title,
        "scenario": scenario.path.name,
        "overrides": list(scenario.overrides),
        "measured": {
            "kind": measured.kind,
            "lines": len(measured.frequency_hz),
            "lowest_hz": float(measured.frequency_hz[0]),
            "highest_hz": float(measured.frequency_hz[-1]),
        },
        "controller": described(survey.controller),
        "margins": survey.margins.as_dict(),
        "requirements": [
            {
                "name": check.requirement.name,
                "unit": survey.labels.unit_of(check.requirement.unit)[0],
                "least": check.requirement.least,
                "most": check.requirement.most,
                "achieved": check.achieved if isfinite(check.achieved) else None,
                "sigma": survey.sigma_of(check),
                "met": check.met,
            }
            for check in survey.requirements
        ],
        "findings": list(survey.findings),
        "notes": list(survey.notes),
    }
