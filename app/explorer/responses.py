"""Responses of a loop in time: a step, and the move, with the torque beside its limit."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...analysis.margins import LoopMargins
from ...analysis.requirement_checks import RequirementCheck, figure_of
from ...analysis.specification import OF_MOVES, Move
from ...analysis.step_response import step_response
from ...analysis.surveyed_loop import decaying_poles
from ...analysis.surveyed_moves import MoveSurvey, move_survey
from ...analysis.unstable_loop import UnstableLoopError
from ...shaping.pieces import FloatArray
from ..scenario_loop import jerk_filter_of
from .state import State
from .verdicts import finite_or_none

Part = dict[str, Any]

_MOST = 900
_TAIL = 1.6  # times the settling time that a step is drawn for


def step_part(state: State, margins: LoopMargins) -> Part:
    """Return the step response of the model's loop; nothing of an unstable one."""
    if not margins.stable:
        return {"part": "step"}
    step = step_response(state.loop, decaying_poles(margins))
    shown = step.time <= max(_TAIL * step.settling_time_s, 4.0 * step.rise_time_s)
    time, position = _thin(step.time[shown], step.position[shown])
    return {
        "part": "step",
        "time": time,
        "position": position,
        "figures": [
            ["overshoot", step.overshoot_percent, "%"],
            ["rise time", step.rise_time_s, "s"],
            ["settling time", finite_or_none(step.settling_time_s), "s"],
        ],
    }


def response_part(state: State, margins: LoopMargins) -> Part:
    """Return what the move does in the loop: error, torque beside its limit, settling."""
    moves = state.scenario.moves
    if not moves:
        return {"part": "response"}
    if not margins.stable:
        return {"part": "response", "problem": "the loop is unstable: nothing to respond"}
    try:
        found = _survey(state, moves[state.move], margins)
    except (ValueError, UnstableLoopError) as error:
        return {"part": "response", "problem": str(error)}
    return {"part": "response", **_response(state, found)}


def _survey(state: State, move: Move, margins: LoopMargins) -> MoveSurvey:
    loops = {"with feedforward": state.loop}
    behind = jerk_filter_of(state.scenario)
    return move_survey(
        move, loops, decaying_poles(margins), jerk_filter=behind, modes=state.scenario.modes
    )


def _response(state: State, found: MoveSurvey) -> Part:
    scale, unit = state.scenario.position_scale, state.scenario.position_unit
    figures, response = found.configured, found.configured.response
    until = min(_TAIL * max(figures.settling_time_s, found.duration_s), response.time[-1])
    shown = response.time <= until
    columns = (response.time, response.position, response.command, response.error, response.torque)
    time, position, command, error, torque = _thin(*(column[shown] for column in columns))
    limit = state.loop.axis.torque_limit
    torque_unit = "N m" if state.scenario.motion == "angle" else "N"
    share = [["share of the torque limit", 100.0 * figures.peak_torque / limit, "%"]]
    return {
        "time": time,
        "position": position / scale,
        "command": command / scale,
        "error": error / scale,
        "torque": torque,
        "torque_limit": finite_or_none(limit),
        "unit": unit,
        "torque_unit": torque_unit,
        "required": list(_required(state, found)),
        "figures": [
            ["settling time", finite_or_none(figures.settling_time_s), "s"],
            ["peak error", figures.peak_error / scale, unit],
            ["overshoot", figures.overshoot / scale, unit],
            ["peak torque", figures.peak_torque, torque_unit],
            *(share if isfinite(limit) else []),
        ],
    }


def _required(state: State, found: MoveSurvey) -> Iterator[list[Any]]:
    """Yield what is required of the move: name, what is asked, what it is, whether it is met."""
    survey = SimpleNamespace(moves=(found,))
    for asked in state.scenario.requirements:
        if asked.figure in OF_MOVES and asked.owner in ("", found.name):
            check = RequirementCheck(asked, figure_of(survey, asked))
            must, achieved, _ = check.shown(state.scenario.labels)
            yield [asked.figure.replace("_", " "), must, achieved, check.met]


def _thin(time: FloatArray, *columns: FloatArray) -> tuple[FloatArray, ...]:
    """Return few samples of all: those at the extremes of each column within every stride."""
    if time.size <= _MOST:
        return (time, *columns)
    stride = -(-time.size * 4 // _MOST)
    kept = {0, time.size - 1, *range(0, time.size, stride)}
    for column in columns:
        for start in range(0, time.size, 2 * stride):
            some = column[start : start + 2 * stride]
            kept |= {start + int(np.argmin(some)), start + int(np.argmax(some))}
    at = np.array(sorted(kept))
    return tuple(np.asarray(array[at]) for array in (time, *columns))
