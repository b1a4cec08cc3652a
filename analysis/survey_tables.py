"""A survey as text: tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isfinite, nan
from typing import Any

from rich.table import Table
from rich.text import Text

from .disturbed import total_of
from .limit_cycles import shown_wait
from .margins.result import in_samples, shown_intervals
from .requirement_table import requirements_table
from .surveyed_moves import MoveResponse, MoveSurvey
from .tables import WideTable, plain_table

_NO_OVERSHOOT = 0.005  # %, told as 0.00: the largest value is then but the last one


def survey_tables(survey: Any) -> list[Table | WideTable]:
    """Return the tables of a Survey: what is required, margins, disturbances, moves."""
    tables: list[Table | WideTable] = []
    tables += requirements_table(survey.requirements, survey.labels)
    tables.append(_margins_table(survey))
    if survey.checks:
        tables.append(_design_table(survey))
    tables += [_step_table(survey), *_disturbance_tables(survey)]
    if survey.moves:
        tables.append(_moves_table(survey) if survey.is_ideal else _real_moves_table(survey))
    if survey.tracking:
        tables.append(_tracking_table(survey))
    return [*tables, _vibration_table(survey)] if survey.modes else tables


def _margins_table(survey: Any) -> Table:
    margins = survey.margins
    table = plain_table("Loop margins", "", "value", "at")
    crossover = ("gain crossover", margins.crossover_hz, "Hz", nan)
    for name, value, unit, at in (crossover, *margins.rows()):
        place = f"{at:.4g} Hz" if isfinite(at) else ""
        table.add_row(name, _shown(value, unit), place)
    if not survey.is_ideal:
        compliance, per_torque = survey.labels.unit_of("compliance")
        for name, peak, unit, scale in (
            ("peak of PS", survey.compliance, compliance, per_torque),
            ("peak of CS", survey.noise_gain, f"{survey.labels.torque_unit}/{_si(survey)}", 1.0),
        ):
            hz = f"{peak.frequency_hz:.4g} Hz" if isfinite(peak.frequency_hz) else ""
            value = _shown(peak.value / scale, unit) if peak.value < inf else "unbounded"
            table.add_row(name, value, hz)
    table.add_row("stable at gain times", shown_intervals(margins.stabilizing_gains), "")
    delays = shown_intervals(margins.stabilizing_delays_s)
    table.add_row(f"stable with added delay [s{in_samples(margins)}]", delays, "")
    return table


def _si(survey: Any) -> str:
    return "rad" if survey.labels.motion == "angle" else "m"


def _design_table(survey: Any) -> Table:
    table = plain_table("Design check", "", "asked", "achieved", "")
    for check in survey.checks:
        verdict = Text("met", "green") if check.met else Text("missed", "red")
        table.add_row(
            check.name, f"{check.asked:.4g} {check.unit}", f"{check.shown} {check.unit}", verdict
        )
    return table


def _step_table(survey: Any) -> Table:
    step = survey.step
    part = "" if survey.is_ideal else ", of the linear part"
    table = plain_table(f"Unit step, without feedforward{part}", "", "value")
    table.add_row("overshoot", f"{step.overshoot_percent:.2f} %")
    if step.overshoot_percent >= _NO_OVERSHOOT:
        table.add_row("peak at", f"{step.peak_time_s:.4f} s")
    table.add_row("rise, 10 to 90 %", f"{step.rise_time_s:.4f} s")
    table.add_row("settled to 2 %", f"{step.settling_time_s:.4f} s")
    return table


def _disturbance_tables(survey: Any) -> Iterator[Table]:
    labels = survey.labels
    unit, scale = labels.position_unit, labels.position_scale
    if survey.disturbance is not None:
        step = survey.disturbance
        name = f"{labels.torque_name.capitalize()} of {step.torque:.4g} {labels.torque_unit}"
        table = plain_table(f"{name} on the {step.on}, the command still", "", "value")
        table.add_row("peak of the load", f"{step.peak / scale:.4g} {unit}")
        table.add_row("back within a tenth of it", _time(step.recovery_time_s))
        at_end = f"at the end, {step.response.time[-1]:.4g} s"
        final = step.final if abs(step.final) > 1e-9 * step.peak else 0.0
        table.add_row(at_end, f"{final / scale:.4g} {unit}")
        yield table
    if survey.budget:
        torque = f"{labels.torque_name} [{labels.torque_unit}]"
        table = plain_table(f"Errors of the load [{unit}]", "", "rms", "peak", torque, "")
        for source in survey.budget:
            random = source.kind == "random"
            load = f"{source.load / scale:.4g}"
            shown = (load, "") if random else ("", load)
            table.add_row(source.name, *shown, _finite(source.torque), Text(source.remark))
        rms, of_torque = total_of(survey.budget)
        table.add_row("random ones together", f"{rms / scale:.4g}", "", f"{of_torque:.4g}", "")
        yield table


def _real_moves_table(survey: Any) -> WideTable:
    """Return the moves of a loop as it is, simulated with friction, limit and resolution."""
    labels, axis = survey.labels, survey.loop.axis
    unit, limit = labels.position_unit, axis.torque_limit
    bound = f" of {limit:.4g}" if limit < inf else ""
    heads = ["", "load settled [s]", "measured [s]", f"peak load error [{unit}]"]
    heads += [f"left at the end [{unit}]", f"{labels.torque_name}{bound} [{labels.torque_unit}]"]
    heads += ["motor current [A]"] * (axis.torque_constant is not None)
    heads += ["at the limit [s]"] * (limit < inf)
    heads += ["next breakaway [s]"] * (axis.friction is not None)
    rows = []
    for move in survey.moves:
        settle_to = f"{move.move.settle_to / labels.position_scale:.4g} {unit}"
        acted = ", disturbed" if move.move.disturbances else ""
        name = f"{move.name}, {move.duration_s:.4f} s, settled to {settle_to}{acted}"
        rows.append([name, *[""] * (len(heads) - 1)])
        for result in move.responses.values():
            rows.append([f"  {result.name}", *_move_cells(survey, move, result)])
    columns = [list(column) for column in zip(heads, *rows, strict=True)]
    return WideTable("Moves, in closed loop", columns)


def _move_cells(survey: Any, move: MoveSurvey, result: MoveResponse) -> list[str]:
    scale, tolerance = survey.labels.position_scale, move.move.settle_to
    axis = survey.loop.axis
    followed = float(result.response.time[-1] - result.response.time[0])
    cells = [
        f"{time:.4f}" if isfinite(time) else f"not by {followed:.4g}"
        for time in (result.load_settling_time_s, result.settling_time_s)
    ]
    cells += [_small(each, tolerance, scale) for each in (result.peak_load_error, result.left_over)]
    cells.append(f"{result.peak_torque:.4g}")
    if axis.torque_constant is not None:
        cells.append(f"{result.peak_current:.4g}")
    if axis.torque_limit < inf:
        cells.append(f"{result.saturated_time_s:.4g}")
    if axis.friction is not None:
        slides = result.next_breakaway_s <= result.response.time[-1]
        cells.append("slides" if slides else shown_wait(result.next_breakaway_s))
    return cells


def _tracking_table(survey: Any) -> Table:
    unit, scale = survey.labels.position_unit, survey.labels.position_scale
    rms, peak = f"rms error of the load [{unit}]", f"peak [{unit}]"
    table = plain_table("Tracking", "", "from [s]", "to [s]", rms, peak, "slips")
    for each in survey.tracking:
        asked = each.tracking
        table.add_row(
            Text(each.name),
            f"{asked.after:.4g}",
            f"{asked.duration:.4g}",
            f"{each.rms_error / scale:.4g}",
            f"{each.peak_error / scale:.4g}",
            str(each.slips) if survey.loop.axis.friction is not None else "",
        )
    return table


def _time(value: float) -> str:
    return f"{value:.4f} s" if isfinite(value) else "never"


def _finite(value: float) -> str:
    return f"{value:.4g}" if isfinite(value) else ""


def _moves_table(survey: Any) -> Table:
    unit, scale = survey.labels.position_unit, survey.labels.position_scale
    torque = survey.labels.torque_name
    table = plain_table(
        "Moves",
        "",
        "duration [s]",
        "settled [s]",
        f"peak error [{unit}]",
        f"peak {torque} [{survey.labels.torque_unit}]",
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


def _vibration_table(survey: Any) -> Table:
    """Return what the commands alone leave ringing in each mode at their end, in open loop."""
    unit, scale = survey.labels.position_unit, survey.labels.position_scale
    modes = survey.modes
    names = [
        f"{mode.name}, {mode.frequency_hz:.4g} Hz, {100 * mode.damping:.3g} % [{unit}]"
        for mode in modes
    ]
    table = plain_table("Residual vibration of the commands alone, in open loop", "", *names)
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
