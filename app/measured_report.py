"""What was measured of a loop as text and as plain data: margins with error bars."""

from __future__ import annotations

from math import isfinite, isnan
from typing import TYPE_CHECKING, Any

from .survey_data import described
from .tables import plain_table

if TYPE_CHECKING:
    from rich.table import Table

    from ..analysis.measured import MeasuredMargins, MeasuredResponse
    from .scenario_measured import MeasuredScenarioSurvey


def margins_report(measured: MeasuredResponse, margins: MeasuredMargins) -> list[Table | str]:
    """Return a table of margins with error bars, crossovers, the verdict with reasons, notes."""
    table = plain_table(repr(measured), "margin", "value", "sigma", "at worst", "at [Hz]")
    for name, value, sigma, worst, unit, place in margins.rows():
        cells = (_shown(number) for number in (value, sigma, worst, place))
        table.add_row(f"{name} [{unit}]" if unit else name, *cells)
    crossovers = [
        f"{hz:.5g} ± {sigma:.2g}"
        for hz, sigma in zip(margins.crossovers_hz, margins.crossovers_hz_sigma, strict=True)
    ]
    verdict = {True: "stable", False: "UNSTABLE", None: "STABILITY CANNOT BE TOLD"}
    return [
        table,
        f"gain crossovers [Hz]: {', '.join(crossovers) or 'none'}",
        verdict[margins.stable],
        *(f"  {reason}" for reason in margins.reasons),
    ]


def _shown(value: float) -> str:
    return "–" if isnan(value) else f"{value:.4g}"


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
