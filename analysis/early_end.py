"""Exact figures of a move, from as much of its response as they are proven to hang on."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..plant import LoopResponse, ServoLoop
from ..plant.tail import tail_of
from ..shaping import Trajectory
from ..shaping.pieces import FloatArray
from .specification import Move
from .surveyed_loop import Poles
from .surveyed_moves import EXACT_FIGURES, followed_for, run_move

_FIRST = 1.0 / 16.0  # of the time behind the command: about a time constant of the slowest mode
_WORTH = 3000  # samples less: what the proof costs
_LOAD, _POSITION, _TORQUE = range(3)
_LARGEST = {
    "peak_error": _POSITION,
    "overshoot": _POSITION,
    "peak_torque": _TORQUE,
    "peak_load_error": _LOAD,
    "left_over": _LOAD,
}
"""Figures that are the largest of a signal, which the rest of a response may pass."""


def exact_figures(
    loop: ServoLoop, trajectory: Trajectory, move: Move, poles: Poles
) -> Callable[[str], float]:
    """Return what gives each figure of a response, without the times of a picture, when asked.

    A response is followed until load and measured position are proven to stay within the tolerance
    and the torque within its limit; for figures that may still grow then, as for loops of which
    nothing is proven, as long as a survey follows it. The numbers are the same.
    """
    return _Responses(loop, trajectory, move, poles).figure


class _Responses:
    """The response to a move, as far as it has to be known."""

    def __init__(self, loop: ServoLoop, trajectory: Trajectory, move: Move, poles: Poles) -> None:
        self._loop, self._trajectory, self._move = loop, trajectory, move
        self._longest = followed_for(loop, trajectory, move, poles)

    def figure(self, name: str) -> float:
        """Return one of the figures of `MoveResponse`."""
        response, after = self._early
        found = self._of(response, name)
        if name in _LARGEST and not found > after[_LARGEST[name]]:
            return self._of(self._whole, name)
        return found

    def _of(self, response: LoopResponse, name: str) -> float:
        return EXACT_FIGURES[name](response, self._move, self._trajectory.duration)

    def _response(self, duration: float) -> LoopResponse:
        end = np.array([self._trajectory.start_time + duration])
        return run_move(self._loop, self._trajectory, self._move, duration, end)

    @cached_property
    def _whole(self) -> LoopResponse:
        return self._response(self._longest)

    @cached_property
    def _early(self) -> tuple[LoopResponse, FloatArray]:
        """A response that is long enough, and what bounds load, position and torque behind it."""
        dt, lead = self._loop.controller_noun.sample_time, self._trajectory.duration
        behind = self._longest - lead
        if dt is None or (1.0 - _FIRST) * behind < _WORTH * dt:
            return self._whole, np.zeros(3)
        samples = int((lead + _FIRST * behind) / dt) + 1
        response = self._response(samples * dt)
        tail, most = tail_of(response.run, self._loop.open_model()), self._within(response)
        if tail is None or not tail.bounds()[_TORQUE] < most[_TORQUE]:
            return self._whole, np.zeros(3)
        more = tail.samples_until(most)
        if more is None or (samples + more) * dt >= self._longest:
            return self._whole, np.zeros(3)
        if more:
            response = self._response((samples + more) * dt)
        return response, tail.bounds(more)

    def _within(self, response: LoopResponse) -> FloatArray:
        """Return what load, position and torque must stay within."""
        off = abs(float(response.command[-1]) - self._move.distance)
        tolerance = self._move.settle_to - off
        return np.array([tolerance, tolerance, self._loop.axis.torque_limit])
