"""What the commands print with --json: plain data, numbers that do not exist as null."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shaping.derivatives import derivative_name

if TYPE_CHECKING:
    from ..fmu.cosimulation.cosimulation_result import CosimulationResult
    from ..shaping import Certificate
    from .gate import GateReport
    from .plan import Plan


def print_json(data: object) -> None:
    """Print plain data on standard output."""
    print(json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False))


def plain(value: Any) -> Any:
    """Return a value as JSON has it: nouns as their fields, what is not finite as null."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, dict) or hasattr(value, "items"):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def plan_data(plan: Plan, certificate: Certificate | None) -> dict[str, Any]:
    """Return a planned move: its duration, peaks beside limits, the switches, the proof."""
    from .plan_report import switch_rows

    move, scale = plan.trajectory, plan.scale
    header, rows = switch_rows(plan)
    data: dict[str, Any] = {
        "order": move.order,
        "duration_s": move.duration,
        "unit": plan.unit,
        "peaks": {
            derivative_name(k): {
                "peak": move.peak(k) / scale,
                "limits": [side / scale for side in plan.limits.bounds(k)],
            }
            for k in range(1, move.order + 1)
        },
        "switches": {"columns": header, "rows": rows},
        "remarks": plan.remarks,
    }
    if certificate is not None:
        data["proof"] = {
            "proven_minimum_s": certificate.lower_bound,
            "gap": certificate.gap,
            "sensitivities": certificate.sensitivities,
        }
    return data


def run_data(result: CosimulationResult, units: Mapping[str, str]) -> dict[str, Any]:
    """Return a run of FMUs: its time, and where each output starts, ends and lies between."""
    return {
        "start_s": result.time[0],
        "end_s": result.time[-1],
        "steps": len(result.time) - 1,
        "ended": result.ended or None,
        "outputs": {
            name: {
                "start": result[name][0],
                "end": result[name][-1],
                "least": result[name].min(),
                "greatest": result[name].max(),
                "unit": units.get(name) or "1",
            }
            for name in result.outputs
        },
        "notes": result.notes,
    }


def report_data(report: GateReport) -> dict[str, Any]:
    """Return what a scenario was held to, number by number, and what that came to."""
    return {
        "scenario": str(report.path),
        "passed": report.passed,
        "unstable": report.unstable or None,
        "missing": report.missing or None,
        "changes": [plain(change) for change in report.changes],
        "numbers": [
            {
                "name": row.name,
                "verdict": row.verdict,
                **{side: getattr(row, side) for side in ("was", "now", "least", "most")},
            }
            for row in report.rows
        ],
    }
