"""A planned move as text: peaks beside limits, the switch table, the proof of its duration."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING

from rich.table import Table

from ..analysis.tables import WideTable, plain_table, without_rounding
from ..shaping import binding_limits
from ..shaping.derivatives import derivative_name
from ..shaping.optimal.binding import BINDING_RTOL

if TYPE_CHECKING:
    from ..shaping import Certificate
    from .plan import Plan


_FEW_PIECES = 3  # the highest order whose moves have at most seven


def plan_tables(plan: Plan, *, pieces: bool = True) -> list[Table | WideTable | str]:
    """Return a planned move for reading: peaks beside limits, and the switches.

    Without `pieces` a line says from order 4 on, where there may be dozens, how many there are.
    """
    if pieces or plan.trajectory.order <= _FEW_PIECES:
        return [_peaks_table(plan), _switch_table(plan)]
    return [_peaks_table(plan), f"{len(plan.trajectory.states)} pieces; --pieces prints them"]


def certificate_table(plan: Plan, certificate: Certificate) -> Table:
    """Return the proof of how near a move is to the minimum time, and what each limit costs."""
    from ..shaping.optimal.whole.planner import HIGHEST_ORDER

    table = plain_table("Proof of minimum time", "", "value")
    table.add_row("duration", f"{certificate.duration:.10g} s")
    table.add_row("proven minimum", f"{certificate.lower_bound:.10g} s")
    table.add_row("gap", f"{100.0 * certificate.gap:.3g} %")
    if not certificate.reached:
        table.add_row("gap aimed at", f"{100.0 * certificate.rtol:g} %, not reached")
        if plan.limits.order > HIGHEST_ORDER and not plan.limits.symmetric:
            table.add_row("limits that differ by direction", "taken as their mean")
    for k, sensitivity in enumerate(certificate.sensitivities, start=1):
        if isfinite(plan.limits.bounds(k)[1]):
            saved = f"saves {-sensitivity + 0.0:.2f} %" if sensitivity < -5e-3 else "saves nothing"
            table.add_row(f"raising {derivative_name(k)} by 1 %", saved)
    return table


def excess_text(plan: Plan) -> str:
    """Return what a closed form loses at most, as far as no program is asked."""
    from ..shaping import proven_excess

    most = 100.0 * proven_excess(plan.trajectory, plan.limits)
    return (
        f"closed form: at most {most:.2g} % more than the minimum time; --certify proves how much"
    )


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


def _peaks_table(plan: Plan) -> Table:
    move, unit = plan.trajectory, plan.unit
    title = f"Move of order {move.order}, {move.duration:.10g} s"
    table = plain_table(title, "", "peak", "limit", "unit", "at its limit")
    binding = _binding(plan)
    if plan.limits.position != (-inf, inf):
        least, most, low, high = (
            f"{x / plan.scale + 0.0:.9g}" for x in (*move.extremes(0), *plan.limits.position)
        )
        table.add_row("position", f"{least} … {most}", f"{low} … {high}", unit, binding[0])
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
    for k in range(move.order + 1):
        spans = [t for t, some in zip(move.durations, active, strict=True) if k in some]
        share = 100.0 * sum(spans) / move.duration if spans else 0.0
        lower, upper = (side * (1.0 - BINDING_RTOL) for side in limits.bounds(k))
        least, most = move.extremes(k)
        touched = bool(len(active)) and (most >= upper > 0.0 or least <= lower < 0.0)
        told[k] = f"{share:.3g} % of the time" if share else "touched" if touched else ""
    return told


def _switch_table(plan: Plan) -> WideTable:
    """Return the state at every switch of a move, just after it."""
    header, rows = switch_rows(plan)
    peaks = [plan.trajectory.peak(k) / plan.scale for k in range(plan.trajectory.order + 1)]
    shown = [[f"{row[0]:.9g}", *map(without_rounding, row[1:], peaks)] for row in rows]
    columns = [list(column) for column in zip(header, *shown, strict=True)]
    return WideTable("Switch table: state just after each switch", columns)
