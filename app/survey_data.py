"""A survey as plain data, for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.limit_cycles import LimitCycles
from ..shaping.derivatives import derivative_name

if TYPE_CHECKING:
    from ..analysis.disturbed import DisturbanceStep
    from ..analysis.loop_survey import MoveResponse, MoveSurvey, Survey
    from .scenario_survey import ScenarioSurvey


def survey_data(survey: ScenarioSurvey) -> dict[str, Any]:
    """Return every number of a survey as plain data, positions in the scenario's unit.

    Numbers that are infinite or do not exist become None.
    """
    scenario, step = survey.scenario, survey.step
    return {
        "title": scenario.title,
        "scenario": scenario.path.name,
        "overrides": list(scenario.overrides),
        "units": {
            "position": scenario.position_unit,
            "torque": survey.labels.torque_unit,
            "inertia": "kg m^2" if scenario.motion == "angle" else "kg",
            "gains": "torque unit per rad, m and s",
        },
        **_loop_data(survey),
        "filter": survey.jerk_filter
        and {"corner_hz": survey.jerk_filter.corner_hz, "order": survey.jerk_filter.order},
        "margins": survey.margins.as_dict(),
        "design_check": _design_data(survey),
        "step": {
            "overshoot_percent": step.overshoot_percent,
            "peak_time_s": step.peak_time_s,
            "rise_time_s": step.rise_time_s,
            "settling_time_s": step.settling_time_s,
        },
        "moves": [_move_data(move, scenario.position_scale) for move in survey.moves],
        **({} if survey.is_ideal else _real_data(survey)),
        "tracking": [
            {
                "name": each.name,
                "rms_error": each.rms_error / scenario.position_scale,
                "peak_error": each.peak_error / scenario.position_scale,
                "slips": each.slips,
            }
            for each in survey.tracking
        ],
        "requirements": _requirement_data(survey),
        "findings": list(survey.findings),
        "notes": list(survey.notes),
    }


def _design_data(survey: ScenarioSurvey) -> list[dict[str, Any]]:
    return [
        {
            "name": check.name,
            "unit": check.unit,
            "asked": check.asked,
            "achieved": _number(check.achieved),
            "met": check.met,
        }
        for check in survey.checks
    ]


def _requirement_data(survey: ScenarioSurvey) -> list[dict[str, Any]]:
    return [
        {
            "name": check.requirement.name,
            "unit": survey.labels.unit_of(check.requirement.unit)[0],
            "least": _in_unit(survey, check.requirement.unit, check.requirement.least),
            "most": _in_unit(survey, check.requirement.unit, check.requirement.most),
            "achieved": _in_unit(survey, check.requirement.unit, check.achieved),
            "met": check.met,
        }
        for check in survey.requirements
    ]


def _loop_data(survey: ScenarioSurvey) -> dict[str, Any]:
    """Return plant, controller and feedforward; of an ideal loop by their few numbers."""
    loop = survey.loop
    if not survey.is_ideal:
        parts = {"plant": loop.plant, "controller": loop.controller}
        told = {name: described(part) for name, part in parts.items()}
        return told | {"feedforward": described(loop.feedforward)}
    controller = loop.controller
    return {
        "plant": {"inertia": loop.plant.J},
        "controller": {"kp": controller.kp, "ki": controller.ki, "kr": controller.kr},
        "feedforward": {"inertia": loop.feedforward_noun.torque.get(2, 0.0)},
    }


def described(value: Any) -> Any:
    """Return a noun as its kind and what of it is not as usual."""
    if is_dataclass(value):
        told = {"kind": type(value).__name__}
        for field in fields(value):
            part = getattr(value, field.name)
            usual = field.default is not MISSING and type(part) is type(field.default)
            if not (usual and part == field.default):
                told[field.name] = described(part)
        return told
    if isinstance(value, Mapping):
        return {str(name): described(part) for name, part in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [described(part) for part in value]
    if isinstance(value, float | np.floating):
        return _number(float(value))
    return value if value is None or isinstance(value, str | int) else type(value).__name__


def _in_unit(survey: Survey, kind: Any, value: float | None) -> float | None:
    return None if value is None else _number(value / survey.labels.unit_of(kind)[1])


def _real_data(survey: Survey) -> dict[str, Any]:
    """Return what only a loop has that is not ideal."""
    scale, axis = survey.labels.position_scale, survey.loop.axis
    return {
        "peaks": {
            "compliance": _number(survey.compliance.value / scale),
            "compliance_hz": _number(survey.compliance.frequency_hz),
            "noise_gain": _number(survey.noise_gain.value),
            "noise_gain_hz": _number(survey.noise_gain.frequency_hz),
        },
        "torque_limit": _number(axis.torque_limit),
        "disturbance": survey.disturbance and _disturbance_data(survey.disturbance, scale),
        "budget": [
            {
                "name": source.name,
                "kind": source.kind,
                "load": source.load / scale,
                "torque": _number(source.torque),
                "remark": source.remark,
            }
            for source in survey.budget
        ],
        "limit_cycles": survey.limit_cycles and _cycles_data(survey.limit_cycles, scale),
    }


def _disturbance_data(step: DisturbanceStep, scale: float) -> dict[str, Any]:
    return {
        "torque": step.torque,
        "on": step.on,
        "peak": step.peak / scale,
        "recovery_time_s": _number(step.recovery_time_s),
        "final": step.final / scale,
    }


def _cycles_data(found: LimitCycles, scale: float) -> dict[str, Any]:
    still = found.standstill
    return {
        "describing_function": [
            {"amplitude": each.amplitude / scale, "frequency_hz": _number(each.frequency_hz)}
            for each in found.foreseen
        ],
        "simulated": {
            "offset": still.offset / scale,
            "duration_s": still.duration_s,
            "swing": still.swing / scale,
            "error": still.error / scale,
            "slips": still.slips,
            "next_breakaway_s": _number(still.next_breakaway_s),
        },
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
        **_load_data(configured, scale),
        "responses": [_response_data(result, scale) for result in move.responses.values()],
    }


def _response_data(result: MoveResponse, scale: float) -> dict[str, Any]:
    return {
        "name": result.name,
        "settling_time_s": _number(result.settling_time_s),
        "peak_error": result.peak_error / scale,
        "peak_torque": result.peak_torque,
        "overshoot": result.overshoot / scale,
        **_load_data(result, scale),
    }


def _load_data(result: MoveResponse, scale: float) -> dict[str, Any]:
    current = result.peak_current
    return {
        **({"peak_current": current} if isfinite(current) else {}),
        "load_settling_time_s": _number(result.load_settling_time_s),
        "peak_load_error": result.peak_load_error / scale,
        "left_over": result.left_over / scale,
        "saturated_time_s": result.saturated_time_s,
        "next_breakaway_s": _number(result.next_breakaway_s),
    }


def _as_written(value: float) -> float:
    """Return a value from the scenario without the rounding of its conversion to SI and back."""
    return float(f"{value:.14g}")


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
