"""A move as a loop makes it: planned, shaped, run through the loop, with its figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, log, nan
from types import MappingProxyType
from typing import Literal

import numpy as np

from ..plant import LoopResponse, ServoLoop
from ..plant.response_figures import load_extremes, peak_torque
from ..shaping import JerkFilter, Trajectory
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.told import Told
from ..shaping.warned import warned_of
from .disturbances import Disturbances
from .frequency_view import residual_vibration
from .planned_moves import planned
from .sampling import clock_for, followed, thinned
from .specification import Mode, Move
from .step_response import KEPT
from .surveyed_loop import Poles, followed_until, is_ideal, shown_times


@dataclass(frozen=True, eq=False, repr=False)
class MoveResponse(Told):
    """One response to a move, with its figures in SI units.

    Attributes
    ----------
    name : str
    response : LoopResponse
        On times for a picture; the figures are exact, or of finer samples.
    settling_time_s : float
        After which the measured position stays within the tolerance of its target; infinite
        where it does not within the time for which it is followed.
    peak_error : float
        Largest error r − y of the measured position.
    peak_torque : float
        Largest torque that the drive is asked for, within its limit.
    overshoot : float
        By how much the measured position passes its target.
    load_settling_time_s, peak_load_error : float
        The same of the load.
    left_over : float
        Largest |r − load| once the command has ended: what is left ringing, and creeping, in
        closed loop.
    saturated_time_s : float
        Time at the torque limit.
    next_breakaway_s : float
        When a motor that sticks at the end of the response breaks away, were the command to
        stand still on: infinite where it never does, nan without friction.
    peak_current : float
        Largest current of the motor, in A, behind the current loop, as `LoopResponse.current` has
        it: with a current lag a little less than peak_torque, which is asked for, stands for. nan
        without a torque constant.
    """

    name: str
    response: LoopResponse
    settling_time_s: float
    peak_error: float
    peak_torque: float
    overshoot: float
    load_settling_time_s: float
    peak_load_error: float
    left_over: float
    saturated_time_s: float = 0.0
    next_breakaway_s: float = nan
    peak_current: float = nan


@dataclass(frozen=True, eq=False, repr=False)
class MoveSurvey(Told, Frozen):
    """A move, shaped, filtered and run through the loop.

    `responses` maps a name to a response: "without feedforward", "with feedforward", and Ĵ
    varied either way; `configured` is that of the loop as it is, with its feedforward, and
    `configured.load_settling_time_s` one of its figures. `residual_vibration` maps the name of a
    mode to the amplitude, at the end of the shaped command, of what the command alone, without a
    loop, leaves ringing in it.
    """

    name: str
    move: Move
    trajectory: Trajectory
    responses: Mapping[str, MoveResponse]
    residual_vibration: Mapping[str, float]

    @property
    def duration_s(self) -> float:
        """Duration of the shaped command, before the filter."""
        return self.trajectory.duration

    @property
    def configured(self) -> MoveResponse:
        """The response with the loop's own feedforward."""
        return self.responses["with feedforward"]


def move_survey(
    move: Move,
    loops: Mapping[str, ServoLoop],
    poles: Poles,
    *,
    jerk_filter: JerkFilter | None,
    modes: Sequence[Mode],
) -> MoveSurvey:
    """Return a move run through each of the loops; ValueError, with its name, if it cannot be."""
    try:
        with warned_of(f"move {move.name!r}"):
            trajectory = planned(move)
        responses = {
            name: _response(name, loop, trajectory, move, poles, jerk_filter)
            for name, loop in loops.items()
        }
        residual = left_ringing(trajectory, jerk_filter, modes)
    except ValueError as error:
        raise ValueError(f"move {move.name!r}: {error}") from None
    return MoveSurvey(
        move.name, move, trajectory, MappingProxyType(responses), MappingProxyType(residual)
    )


def left_ringing(
    trajectory: Trajectory, jerk_filter: JerkFilter | None, modes: Sequence[Mode]
) -> dict[str, float]:
    """Return by mode what the command alone leaves ringing in it."""
    return {mode.name: _left_in(mode, trajectory, jerk_filter) for mode in modes}


def _left_in(mode: Mode, trajectory: Trajectory, jerk_filter: JerkFilter | None) -> float:
    try:
        return float(
            residual_vibration(trajectory, mode.frequency_hz, mode.damping, jerk_filter=jerk_filter)
        )
    except ValueError as error:
        raise ValueError(f"mode {mode.name!r}: {error}") from None


def _response(
    name: str,
    loop: ServoLoop,
    trajectory: Trajectory,
    move: Move,
    poles: Poles,
    jerk_filter: JerkFilter | None,
) -> MoveResponse:
    if on_a_grid(loop, move, jerk_filter):
        return _on_a_grid(name, loop, trajectory, move, poles, jerk_filter)
    return _exactly(name, loop, trajectory, move, poles)


def on_a_grid(loop: ServoLoop, move: Move, jerk_filter: JerkFilter | None) -> bool:
    """Whether a response is taken from fine samples; ValueError for what neither way has."""
    acting = move.disturbances
    if acting is not None and jerk_filter is not None:
        raise ValueError(
            "disturbances behind a jerk filter: the filter is for a linear loop that nothing "
            "disturbs; shape the command by limits instead, or leave one of the two out"
        )
    return jerk_filter is not None or (is_ideal(loop) and acting is None)


def _exactly(
    name: str, loop: ServoLoop, trajectory: Trajectory, move: Move, poles: Poles
) -> MoveResponse:
    lead, duration = trajectory.duration, followed_for(loop, trajectory, move, poles)
    times = shown_times(trajectory.start_time, lead, duration)
    found = run_move(loop, trajectory, move, duration, times)
    figures = {figure: of(found, move, lead) for figure, of in EXACT_FIGURES.items()}
    current = _current(loop, lambda: peak_torque(found, of_motor=True))
    return MoveResponse(name, found, **figures, peak_current=current)


def _current(loop: ServoLoop, torque: Callable[[], float]) -> float:
    constant = loop.axis.torque_constant
    return nan if constant is None else torque() / (loop.axis.gear_ratio * constant)


def followed_for(loop: ServoLoop, trajectory: Trajectory, move: Move, poles: Poles) -> float:
    """Return how long a response is followed."""
    acting = move.disturbances or Disturbances()
    return followed_until(loop, poles, _decay(move), max(trajectory.duration, acting.until))


def run_move(
    loop: ServoLoop, trajectory: Trajectory, move: Move, duration: float, times: FloatArray
) -> LoopResponse:
    """Return the response to a move and what acts meanwhile, shown at times."""
    acting = move.disturbances or Disturbances()
    return loop.respond(trajectory, duration=duration, times=times, **acting.acting(loop, duration))


def _overshoot(found: LoopResponse, move: Move) -> float:
    low, high = load_extremes(found, move.distance, of="position")
    return max(high if move.distance > 0.0 else -low, 0.0)


def _left_over(found: LoopResponse, lead: float) -> float:
    low, high = load_extremes(found, after=lead)
    return max(high, -low)


def _settling(found: LoopResponse, move: Move, of: Literal["position", "load"]) -> float:
    return found.settling_time(move.distance, move.settle_to, of=of)


def _saturated_time(found: LoopResponse) -> float:
    return found.saturated_time if found.run.scene.axis.torque_limit < inf else 0.0


def _next_breakaway(found: LoopResponse) -> float:
    return nan if found.run.scene.axis.friction is None else found.next_breakaway


EXACT_FIGURES: Mapping[str, Callable[[LoopResponse, Move, float], float]] = {
    "settling_time_s": lambda found, move, _: _settling(found, move, "position"),
    "peak_error": lambda found, *_: found.peak_error,
    "peak_torque": lambda found, *_: peak_torque(found),
    "overshoot": lambda found, move, _: _overshoot(found, move),
    "load_settling_time_s": lambda found, move, _: _settling(found, move, "load"),
    "peak_load_error": lambda found, *_: found.peak_load_error,
    "left_over": lambda found, _, lead: _left_over(found, lead),
    "saturated_time_s": lambda found, *_: _saturated_time(found),
    "next_breakaway_s": lambda found, *_: _next_breakaway(found),
}
"""Figures of an exact response to a move, of the response, the move and the command's length."""


def _decay(move: Move) -> float:
    """Return how far modes are followed: to 1e-2 of the settling tolerance."""
    return log(100.0 * abs(move.distance) / move.settle_to)


def _on_a_grid(
    name: str,
    loop: ServoLoop,
    trajectory: Trajectory,
    move: Move,
    poles: Poles,
    jerk_filter: JerkFilter | None,
) -> MoveResponse:
    """Return the response of a linear loop from fine samples, behind the filter if there is one."""
    lead = trajectory.duration
    if jerk_filter is not None:
        lead += jerk_filter.settling_time(0.01 * move.settle_to / abs(move.distance))
        poles = np.append(poles, -jerk_filter.omega)
    quickest = trajectory.duration / 20.0
    clock = clock_for(poles, _decay(move), lead=lead, quickest=quickest)

    def arrays(dt: float, duration: float) -> tuple[FloatArray, ...]:
        response = loop.respond(trajectory, dt, duration=duration, jerk_filter=jerk_filter)
        return response.time, response.inputs, response.outputs, response.states

    samples = followed(arrays, clock)
    full = LoopResponse(*samples)
    settling = full.settling_time(move.distance, move.settle_to)
    beyond = (full.position - move.distance) * np.sign(move.distance)
    ended = full.time >= full.time[0] + trajectory.duration
    return MoveResponse(
        name,
        LoopResponse(*thinned(samples, KEPT)),
        settling_time_s=settling,
        peak_error=float(np.abs(full.error).max()),
        peak_torque=float(np.abs(full.torque).max()),
        overshoot=max(float(beyond.max()), 0.0),
        load_settling_time_s=full.settling_time(move.distance, move.settle_to, of="load"),
        peak_load_error=float(np.abs(full.load_error).max()),
        left_over=float(np.abs(full.load_error[ended]).max(initial=0.0)),
        peak_current=_current(loop, lambda: float(np.abs(full.motor_torque).max())),
    )
