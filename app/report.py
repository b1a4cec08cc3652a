"""A survey and a move as text: tables for the terminal, plain data for JSON and CSV."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any, Literal

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text

from ..analysis.margins.result import shown_intervals
from ..shaping import binding_limits
from ..shaping.derivatives import derivative_name
from ..shaping.optimal.binding import BINDING_RTOL

if TYPE_CHECKING:
    from ..analysis.loop_survey import MoveSurvey
    from ..shaping import Certificate
    from .plan import Plan
    from .scenario_survey import ScenarioSurvey


_FEW_PIECES = 3  # the highest order whose moves have at most seven


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


@dataclass(frozen=True)
class WideTable:
    """A table that a narrow console shows as several, each with the first column.

    Numbers are so never broken across lines.
    """

    title: str
    columns: list[list[str]]

    def __rich_console__(self, _: Console, options: ConsoleOptions) -> Iterator[Table]:
        """Return the fewest tables that fit."""
        title, columns, room = self.title, self.columns, options.max_width
        if _width(columns) > room:
            columns = [[column[0].replace(" [", "\n["), *column[1:]] for column in columns]
        first, *left = columns
        while left:
            count = len(left)
            while count > 1 and _width([first, *left[:count]]) > room:
                count -= 1
            header, *rows = zip(first, *left[:count], strict=True)
            table = _table(title, *header)
            for row in rows:
                table.add_row(*row)
            yield table
            title, left = f"{self.title}, continued", left[count:]


def _width(columns: list[list[str]]) -> int:
    """Return how wide a table is in which no line is broken."""
    lines = ([line for cell in column for line in cell.split("\n")] for column in columns)
    return 1 + sum(3 + max(map(cell_len, column)) for column in lines)


def plan_tables(plan: Plan, *, pieces: bool = True) -> list[Table | WideTable | str]:
    """Return a planned move for reading: peaks beside limits, and the switches.

    Without `pieces` a line says from order 4 on, where there may be dozens, how many there are.
    """
    if pieces or plan.trajectory.order <= _FEW_PIECES:
        return [_peaks_table(plan), _switch_table(plan)]
    return [_peaks_table(plan), f"{len(plan.trajectory.states)} pieces; --pieces prints them"]


def certificate_table(plan: Plan, certificate: Certificate) -> Table:
    """Return the proof of how near a move is to the minimum time, and what each limit costs."""
    table = _table("Proof of minimum time", "", "value")
    table.add_row("duration", f"{certificate.duration:.10g} s")
    table.add_row("proven minimum", f"{certificate.lower_bound:.10g} s")
    table.add_row("gap", f"{100.0 * certificate.gap:.3g} %")
    if not certificate.reached:
        table.add_row("gap aimed at", f"{100.0 * certificate.rtol:g} %, not reached")
        if not plan.limits.symmetric:
            table.add_row("limits that differ by direction", "taken as their mean")
    for k, sensitivity in enumerate(certificate.sensitivities, start=1):
        if isfinite(plan.limits.bounds(k)[1]):
            saved = f"saves {-sensitivity + 0.0:.2f} %" if sensitivity < -5e-3 else "saves nothing"
            table.add_row(f"raising {derivative_name(k)} by 1 %", saved)
    return table


def _peaks_table(plan: Plan) -> Table:
    move, unit = plan.trajectory, plan.unit
    title = f"Move of order {move.order}, {move.duration:.10g} s"
    table = _table(title, "", "peak", "limit", "unit", "at its limit")
    binding = _binding(plan)
    for k in range(1, move.order + 1):
        lower, upper = (side / plan.scale for side in plan.limits.bounds(k))
        limit = f"{upper:.9g}" if upper == -lower else f"{lower:.9g} … {upper:.9g}"
        table.add_row(
            derivative_name(k),
            f"{move.peak(k) / plan.scale + 0.0:.9g}",
            "none" if upper == inf and lower == -inf else limit,
            f"{unit}/s" if k == 1 else f"{unit}/s^{k}",
            binding[k],
        )
    return table


def _binding(plan: Plan) -> dict[int, str]:
    """Return for how much of the time each derivative is at its limit."""
    move, limits = plan.trajectory, plan.limits
    active = binding_limits(move, limits)
    told = {}
    for k in range(1, move.order + 1):
        spans = [t for t, some in zip(move.durations, active, strict=True) if k in some]
        share = 100.0 * sum(spans) / move.duration if spans else 0.0
        lower, upper = (side * (1.0 - BINDING_RTOL) for side in limits.bounds(k))
        least, most = move.extremes(k)
        touched = bool(len(active)) and (most >= upper or least <= lower)
        told[k] = f"{share:.3g} % of the time" if share else "touched" if touched else ""
    return told


def _switch_table(plan: Plan) -> WideTable:
    """Return the state at every switch of a move, just after it."""
    header, rows = switch_rows(plan)
    peaks = [plan.trajectory.peak(k) / plan.scale for k in range(plan.trajectory.order + 1)]
    shown = [[f"{row[0]:.9g}", *map(_cleaned, row[1:], peaks)] for row in rows]
    columns = [list(column) for column in zip(header, *shown, strict=True)]
    return WideTable("Switch table: state just after each switch", columns)


def switch_rows(plan: Plan) -> tuple[list[str], list[list[float]]]:
    """Return header and rows of the switch table: time, state just after it, end included."""
    trajectory, unit, scale = plan.trajectory, plan.unit, plan.scale
    units = [unit, f"{unit}/s"] + [f"{unit}/s^{k}" for k in range(2, trajectory.order + 1)]
    header = ["time [s]"] + [f"{derivative_name(k)} [{u}]" for k, u in enumerate(units)]
    states = [*trajectory.states, trajectory.end_state]
    rows = [
        [float(time), *(float(value) / scale + 0.0 for value in state)]
        for time, state in zip(trajectory.breaks, states, strict=True)
    ]
    return header, rows


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
    table = _table("Loop margins", "", "value", "at")
    crossover = ("gain crossover", margins.crossover_hz, "Hz", nan)
    for name, value, unit, at in (crossover, *margins.rows()):
        place = f"{at:.4g} Hz" if isfinite(at) else ""
        table.add_row(name, _shown(value, unit), place)
    table.add_row("stable at gain times", shown_intervals(margins.stabilizing_gains), "")
    delays = shown_intervals(margins.stabilizing_delays_s)
    table.add_row("stable with added delay [s]", delays, "")
    return table


def _design_table(survey: ScenarioSurvey) -> Table:
    table = _table("Design check", "", "asked", "achieved", "")
    for check in survey.checks:
        verdict = Text("met", "green") if check.met else Text("missed", "red")
        table.add_row(
            check.name, f"{check.asked:.4g} {check.unit}", f"{check.shown} {check.unit}", verdict
        )
    return table


def _step_table(survey: ScenarioSurvey) -> Table:
    step = survey.step
    table = _table("Unit step, without feedforward", "", "value")
    table.add_row("overshoot", f"{step.overshoot_percent:.2f} %")
    table.add_row("peak at", f"{step.peak_time_s:.4f} s")
    table.add_row("rise, 10 to 90 %", f"{step.rise_time_s:.4f} s")
    table.add_row("settled to 2 %", f"{step.settling_time_s:.4f} s")
    return table


def _moves_table(survey: ScenarioSurvey) -> Table:
    unit, scale = survey.scenario.position_unit, survey.scenario.position_scale
    torque = "torque" if survey.scenario.motion == "angle" else "force"
    table = _table(
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
    table = _table("Residual vibration", "", *names)
    for move in survey.moves:
        left = [_small(move.residual_vibration[m.name], move.move.settle_to, scale) for m in modes]
        table.add_row(Text(move.name), *left)
    return table


def _cleaned(value: float, peak: float) -> str:
    """Return a number for reading, rounding errors beside its peak left out."""
    return f"{value:.6g}" if abs(value) > 1e-12 * peak else "0"


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


def _table(title: str, *columns: str) -> Table:
    table = Table(title=Text(title), title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for i, column in enumerate(columns):
        # Text, lest rich take a unit in brackets for its markup; folded, lest it cut digits off
        justify: Literal["left", "right"] = "left" if i == 0 else "right"
        table.add_column(Text(column), justify=justify, overflow="fold")
    return table
