"""What is shown of a move: its derivatives beside their limits, its spectrum, its proof."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np

from ...analysis import frequency_response, residual_vibration
from ...analysis.planned_moves import planned
from ...analysis.specification import Mode, Move
from ...shaping import JerkFilter, Limits, Trajectory, binding_limits, certify
from ...shaping.derivatives import derivative_name
from ..scenario_loop import jerk_filter_of
from ..scenario_shapers import held_mode
from .fields import move_fields
from .loop_view import decibel
from .state import State

Part = dict[str, Any]

_SAMPLES = 500
_LINES = 500
_DECADES = 2.5
_EXACT = 1e-9  # of a gap
_LITTLE = 5e-3  # of a limit's share


def planned_of(state: State) -> Trajectory | None:
    """Return the trajectory of the move that is shown; None where there is none."""
    moves = state.scenario.moves
    return planned(moves[state.move]) if moves else None


def move_part(state: State, trajectory: Trajectory) -> Part:
    """Return the move: each derivative with its limits, which of them binds, what modes keep."""
    move = state.scenario.moves[state.move]
    scale, unit = state.scenario.position_scale, state.scenario.position_unit
    limits = Limits.from_bounds(move.bounds)
    times = _times(trajectory)
    order = max(limits.order, min(trajectory.order, limits.order + 1))
    return {
        "part": "move",
        "names": [each.name for each in state.scenario.moves],
        "shown": state.move,
        "unit": unit,
        "duration_s": trajectory.duration,
        "time": times,
        "derivatives": [_derivative(trajectory, k, times, limits, scale) for k in range(order + 1)],
        "binding": _binding(trajectory, limits),
        "residual": [_left(trajectory, mode, state) for mode in modes_of(state)],
        "spectrum": _spectrum(state, trajectory),
        "elements": move_fields(state),
        "figures": [
            ["duration", trajectory.duration, "s"],
            ["pieces", len(trajectory.durations), ""],
        ],
    }


def proof_part(state: State, trajectory: Trajectory) -> Part:
    """Return how near the move is to the minimum time, proven."""
    move = state.scenario.moves[state.move]
    why = _why_not(move)
    if why:
        return {"part": "proof", "text": why}
    try:
        found = certify(trajectory, Limits.from_bounds(move.bounds))
    except ValueError as error:
        return {"part": "proof", "text": f"nothing is proven: {error}"}
    near = "exactly" if found.gap < _EXACT else f"within {found.gap:.1g} of"
    shares = ", ".join(
        f"{derivative_name(k)} {abs(share):.2f} %"
        for k, share in enumerate(found.sensitivities, start=1)
        if abs(share) > _LITTLE
    )
    text = f"Proven: {near} the minimum time. A limit 1 % higher saves: {shares}."
    return {"part": "proof", "text": text, "gap": found.gap}


def _why_not(move: Move) -> str:
    """Return why a move is not the fastest and cannot be proven to be, or nothing."""
    if move.shapers:
        return "not the minimum time: an input shaper makes it longer"
    if move.minimum_jerk:
        return "not the minimum time: of minimum jerk"
    if move.duration is not None or move.round_to is not None:
        return "not the minimum time: a duration was asked for"
    return ""


def _times(trajectory: Trajectory) -> Any:
    """Return times to draw at: even, and both sides of each break."""
    start, end = trajectory.start_time, trajectory.start_time + trajectory.duration
    even = np.linspace(start, end, _SAMPLES)
    breaks = np.asarray(trajectory.breaks)
    step = 1e-9 * trajectory.duration
    return np.unique(np.clip(np.concatenate([even, breaks - step, breaks + step]), start, end))


def _derivative(
    trajectory: Trajectory, k: int, times: Any, limits: Limits, scale: float
) -> dict[str, Any]:
    low, high = limits.bounds(k) if k else (-inf, inf)
    return {
        "name": derivative_name(k),
        "values": np.asarray(trajectory(times, k)) / scale,
        "low": low / scale if isfinite(low) else None,
        "high": high / scale if isfinite(high) else None,
        "peak": trajectory.peak(k) / scale if k else abs(float(trajectory(times[-1]))) / scale,
    }


def _binding(trajectory: Trajectory, limits: Limits) -> list[dict[str, Any]]:
    """Return the pieces with the derivatives that are at a limit all along each."""
    breaks = np.asarray(trajectory.breaks, dtype=float)
    return [
        {"from": float(breaks[i]), "to": float(breaks[i + 1]), "by": list(held)}
        for i, held in enumerate(binding_limits(trajectory, limits))
        if breaks[i + 1] > breaks[i]
    ]


def modes_of(state: State) -> list[Mode]:
    """Return the modes that a move may leave ringing: the scenario's, and the plant's held ones."""
    plant = [
        Mode(mode.name or f"mode {index}", *held_mode(mode))
        for index, mode in enumerate(state.scenario.plant.modes, start=1)
    ]
    return [*state.scenario.modes, *plant]


def _behind(state: State) -> JerkFilter | None:
    return jerk_filter_of(state.scenario)


def _left(trajectory: Trajectory, mode: Mode, state: State) -> dict[str, Any]:
    told: dict[str, Any] = {"name": mode.name, "hz": mode.frequency_hz}
    try:
        left = float(
            residual_vibration(
                trajectory, mode.frequency_hz, mode.damping, jerk_filter=_behind(state)
            )
        )
    except ValueError as error:
        return told | {"problem": str(error)}
    return told | {"left": left / state.scenario.position_scale}


def _spectrum(state: State, trajectory: Trajectory) -> dict[str, Any]:
    """Return the move as a low-pass filter over frequency, the modes within sight."""
    first = 0.2 / trajectory.duration
    places = [mode.frequency_hz for mode in modes_of(state)]
    last = max([first * 10.0**_DECADES, *(3.0 * place for place in places)])
    frequency = np.geomspace(first, last, _LINES)
    found = frequency_response(trajectory, 2.0 * np.pi * frequency, jerk_filter=_behind(state))
    return {"frequency": frequency, "gain_db": np.maximum(decibel(found.response), -160.0)}
