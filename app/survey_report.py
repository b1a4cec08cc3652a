"""A survey as text: tables for the terminal, plain data for JSON and CSV."""

from __future__ import annotations

from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from ..analysis.margins.result import shown_intervals
from ..shaping.derivatives import derivative_name
from .tables import plain_table

if TYPE_CHECKING:
    from ..analysis.loop_survey import MoveSurvey
    from .scenario_survey import ScenarioSurvey


def survey_tables(survey: ScenarioSurvey) -> list[Table]:
    """Return the tables of a survey: margins, design check, step, moves."""
    tables = [_margins_table(survey)]
    if survey.checks:
        tables.append(_design_table(survey))
    tables += [_step_table(survey), _moves_table(survey)]
    return [*tables, _vibration_table(survey)] if survey.scenario.modes else tables


def survey_data(survey: ScenarioSurvey) -> dict[str, Any]:
    """Return every number of a survey as plain data, positions in the scenario's unit.

    Numbers that are infinite or do not exist become None.
    """
    scenario, step = survey.scenario, survey.step
    controller = survey.loop.controller
    return {
        "title": scenario.title,
        "scenario": scenario.path.name,
        "overrides": list(scenario.overrides),
        "units": {
            "position": scenario.position_unit,
            "torque": _torque_unit(survey),
            "inertia": "kg m^2" if scenario.motion == "angle" else "kg",
            "gains": "torque unit per rad, m and s",
        },
        "plant": {"inertia": scenario.inertia},
        "controller": {"kp": controller.kp, "ki": controller.ki, "kr": controller.kr},
        "feedforward": {"inertia": scenario.feedforward_inertia},
        "filter": survey.jerk_filter
        and {"corner_hz": survey.jerk_filter.corner_hz, "order": survey.jerk_filter.order},
        "margins": survey.margins.as_dict(),
        "design_check": [
            {
                "name": check.name,
                "unit": check.unit,
                "asked": check.asked,
                "achieved": _number(check.achieved),
                "met": check.met,
            }
            for check in survey.checks
        ],
        "step": {
            "overshoot_percent": step.overshoot_percent,
            "peak_time_s": step.peak_time_s,
            "rise_time_s": step.rise_time_s,
            "settling_time_s": step.settling_time_s,
        },
        "moves": [_move_data(move, scenario.position_scale) for move in survey.moves],
        "findings": list(survey.findings),
    }


def _move_data(move: MoveSurvey, scale: float) -> dict[str, Any]:
    configured = move.configured
    return {
        "name": move.name,
        "distance": _as_written(move.move.distance / scale),
        "settle_to": _as_written(move.move.settle_to / scale),
        "order": move.trajectory.order,
        "duration_s": move.duration_s,
        "switch_times_s": [float(time) for time in move.trajectory.switch_times],
        "peaks": {
            derivative_name(k): move.trajectory.peak(k) / scale
            for k in range(1, move.trajectory.order + 1)
        },
        "settling_time_s": _number(configured.settling_time_s),
        "peak_error": configured.peak_error / scale,
        "peak_torque": configured.peak_torque,
        "residual_vibration": {
            mode: left / scale for mode, left in move.residual_vibration.items()
        },
        "responses": [
            {
                "name": result.name,
                "settling_time_s": _number(result.settling_time_s),
                "peak_error": result.peak_error / scale,
                "peak_torque": result.peak_torque,
                "overshoot": result.overshoot / scale,
            }
            for result in move.responses.values()
        ],
    }


def _margins_table(survey: ScenarioSurvey) -> Table:
    margins = survey.margins
    table = plain_table("Loop margins", "", "value", "at")
    crossover = ("gain crossover", margins.crossover_hz, "Hz", nan)
    for name, value, unit, at in (crossover, *margins.rows()):
        place = f"{at:.4g} Hz" if isfinite(at) else ""
        table.add_row(name, _shown(value, unit), place)
    table.add_row("stable at gain times", shown_intervals(margins.stabilizing_gains), "")
    delays = shown_intervals(margins.stabilizing_delays_s)
    table.add_row("stable with added delay [s]", delays, "")
    return table


def _design_table(survey: ScenarioSurvey) -> Table:
    table = plain_table("Design check", "", "asked", "achieved", "")
    for check in survey.checks:
        verdict = Text("met", "green") if check.met else Text("missed", "red")
        table.add_row(
            check.name, f"{check.asked:.4g} {check.unit}", f"{check.shown} {check.unit}", verdict
        )
    return table


def _step_table(survey: ScenarioSurvey) -> Table:
    step = survey.step
    table = plain_table("Unit step, without feedforward", "", "value")
    table.add_row("overshoot", f"{step.overshoot_percent:.2f} %")
    table.add_row("peak at", f"{step.peak_time_s:.4f} s")
    table.add_row("rise, 10 to 90 %", f"{step.rise_time_s:.4f} s")
    table.add_row("settled to 2 %", f"{step.settling_time_s:.4f} s")
    return table


def _moves_table(survey: ScenarioSurvey) -> Table:
    unit, scale = survey.scenario.position_unit, survey.scenario.position_scale
    torque = "torque" if survey.scenario.motion == "angle" else "force"
    table = plain_table(
        "Moves",
        "",
        "duration [s]",
        "settled [s]",
        f"peak error [{unit}]",
        f"peak {torque} [{_torque_unit(survey)}]",
    )
    for move in survey.moves:
        settle_to = f"settled to {move.move.settle_to / scale:.4g} {unit}"
        name = Text.assemble((move.name, "bold"), f" ({settle_to})")
        table.add_row(name, f"{move.duration_s:.4f}", "", "", "")
        for result in move.responses.values():
            table.add_row(
                f"  {result.name}",
                "",
                _shown(result.settling_time_s, "", 4),
                _small(result.peak_error, move.move.settle_to, scale),
                f"{result.peak_torque:.4g}",
            )
    return table


def _vibration_table(survey: ScenarioSurvey) -> Table:
    """Return what the commands leave ringing in each mode at their end."""
    unit, scale = survey.scenario.position_unit, survey.scenario.position_scale
    modes = survey.scenario.modes
    names = [
        f"{mode.name}, {mode.frequency_hz:.4g} Hz, {100 * mode.damping:.3g} % [{unit}]"
        for mode in modes
    ]
    table = plain_table("Residual vibration", "", *names)
    for move in survey.moves:
        left = [_small(move.residual_vibration[m.name], move.move.settle_to, scale) for m in modes]
        table.add_row(Text(move.name), *left)
    return table


def _small(error: float, tolerance: float, scale: float) -> str:
    """Return an error, or "0" where it is rounding beside the settling tolerance."""
    return "0" if error < 1e-9 * tolerance else f"{error / scale:.4g}"


def _shown(value: float, unit: str, digits: int = 5) -> str:
    if isfinite(value):
        return f"{value:.{digits}g} {unit}".strip()
    return "none" if value > 0 else "—"


def _as_written(value: float) -> float:
    """Return a value from the scenario without the rounding of its conversion to SI and back."""
    return float(f"{value:.14g}")


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def _torque_unit(survey: ScenarioSurvey) -> str:
    return "N m" if survey.scenario.motion == "angle" else "N"
