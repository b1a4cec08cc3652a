"""The survey of a servo loop (Thompson, Section VII): margins, step, moves, wrong Ĵ."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import log
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..plant import (
    InertiaFeedforward,
    LoopResponse,
    ServoLoop,
    TorqueSteps,
    Wind,
)
from ..shaping import JerkFilter, Limits, Trajectory, min_time_move
from ..shaping.drawing import draw
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from .frequency_view import residual_vibration
from .margins import LoopMargins, loop_margins
from .margins.result import shown_intervals
from .sampling import Clock, clock_for, followed, thinned
from .specification import Labels, Mode, Move, Requirement, Specification, Tracking
from .step_response import KEPT, StepResponse, step_response

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Poles = NDArray[np.complex128]


class UnstableLoopError(ValueError):
    """The closed loop is not asymptotically stable, so that it has no survey."""


@dataclass(frozen=True)
class SpecificationCheck:
    """One line of the design check: what was asked, what the loop has."""

    name: str
    unit: str
    asked: float
    achieved: float

    @property
    def shown(self) -> str:
        """The achieved value with the digits that its unit deserves."""
        return f"{self.achieved:.3f}" if self.unit == "Hz" else f"{self.achieved:.1f}"

    @property
    def met(self) -> bool:
        """Whether the two agree to 0.1 %."""
        return abs(self.achieved - self.asked) <= 1e-3 * abs(self.asked)


@dataclass(frozen=True, eq=False)
class MoveResponse:
    """One response to a move, with its figures in SI units."""

    name: str
    response: LoopResponse
    settling_time_s: float
    peak_error: float
    peak_torque: float
    overshoot: float


@dataclass(frozen=True, eq=False)
class MoveSurvey(Frozen):
    """A move, shaped, filtered and run through the loop.

    `responses` maps a name to a response: "without feedforward", "with feedforward", and Ĵ
    varied either way. `settling_time_s`, `peak_error` and `peak_torque` are those of the loop
    as it is, with its feedforward. `residual_vibration` maps the name of a mode
    to the amplitude, at the end of the shaped command, of what the command leaves ringing in it.
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Survey:
    """Everything that the survey of a loop found, in SI units."""

    loop: ServoLoop
    jerk_filter: JerkFilter | None
    margins: LoopMargins
    checks: tuple[SpecificationCheck, ...]
    step: StepResponse
    moves: tuple[MoveSurvey, ...]
    labels: Labels = field(default_factory=Labels)

    @property
    def missed(self) -> str:
        """The specifications that are not met, and the step's overshoot; empty if all are."""
        missed = [check for check in self.checks if not check.met]
        if not missed:
            return ""
        listed = ", ".join(
            f"{check.name} {check.shown} {check.unit} (asked {check.asked:.4g})" for check in missed
        )
        return f"{listed}; step overshoot {self.step.overshoot_percent:.1f} %"

    @property
    def findings(self) -> tuple[str, ...]:
        """Plain sentences on what does not meet its specification."""
        return (f"The gains miss their specifications: {self.missed}.",) if self.missed else ()

    def plot(self) -> Figure:
        """Draw the survey in pyplot's current figure, or a new one if that is not empty."""
        drawn: Figure = draw(self)
        return drawn


def survey(
    loop: ServoLoop,
    moves: Sequence[Move],
    *,
    jerk_filter: JerkFilter | None = None,
    modes: Sequence[Mode] = (),
    specification: Specification | None = None,
    wind: Wind | None = None,
    encoder_noise: float = 0.0,
    torque_step: float | TorqueSteps | None = None,
    tracking: Sequence[Tracking] = (),
    requirements: Sequence[Requirement] = (),
    inertia_error: float = 0.1,
    labels: Labels | None = None,
) -> Survey:
    """Survey a servo loop: its margins, step response, and what it makes of moves.

    Parameters
    ----------
    loop : ServoLoop
        Its feedforward is the one that is varied.
    moves : sequence of Move
        In rad or m.
    jerk_filter : JerkFilter, optional
        Behind the shaper.
    modes : sequence of Mode, optional
        What the moves must not leave ringing.
    specification : Specification, optional
        What the loop is to achieve.
    inertia_error : float, optional
        The fraction by which Ĵ is varied.
    labels : Labels, optional
        How the results are told. Default: without a title, in rad.

    Returns
    -------
    Survey

    Raises
    ------
    UnstableLoopError
        Where the closed loop is unstable.
    ValueError
        Where a move cannot be planned or driven.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """
    margins = loop_margins(loop.loop_transfer())
    if not margins.stable:
        worst = max(margins.closed_loop_poles, key=lambda pole: pole.real)
        gains = shown_intervals(margins.stabilizing_gains)
        remedy = f"by a common factor {gains}" if margins.stabilizing_gains else "one by one"
        raise UnstableLoopError(
            f"the closed loop is UNSTABLE, with a pole at {worst:.4g} rad/s; "
            f"there are no margins to report. Change the gains {remedy}"
        )
    poles = margins.closed_loop_poles
    variants = _variants(loop, inertia_error)
    return Survey(
        loop=loop,
        jerk_filter=jerk_filter,
        margins=margins,
        checks=_specification_checks(specification, margins),
        step=step_response(loop, poles),
        moves=tuple(_move(move, variants, jerk_filter, modes, poles) for move in moves),
        labels=labels or Labels(),
    )


def _specification_checks(
    asked: Specification | None, margins: LoopMargins
) -> tuple[SpecificationCheck, ...]:
    if asked is None:
        return ()
    return (
        SpecificationCheck("crossover", "Hz", asked.crossover_hz, margins.crossover_hz),
        SpecificationCheck("phase margin", "deg", asked.phase_margin_deg, margins.phase_margin_deg),
        SpecificationCheck(
            "lower gain margin", "dB", asked.lower_gain_margin_db, margins.lower_gain_margin_db
        ),
    )


def _move(
    move: Move,
    variants: Mapping[str, ServoLoop],
    jerk_filter: JerkFilter | None,
    modes: Sequence[Mode],
    poles: Poles,
) -> MoveSurvey:
    try:
        trajectory = min_time_move(move.distance, Limits.from_bounds(move.bounds))
        clock = _move_clock(trajectory, jerk_filter, move, poles)
        responses = {}
        for name, varied in variants.items():

            def respond(dt: float, duration: float, loop: ServoLoop = varied) -> LoopResponse:
                return loop.respond(trajectory, dt, duration=duration, jerk_filter=jerk_filter)

            responses[name] = _follow(name, respond, clock, move)
        residual = {mode.name: _left_ringing(trajectory, jerk_filter, mode) for mode in modes}
    except ValueError as error:
        raise ValueError(f"move {move.name!r}: {error}") from None
    return MoveSurvey(
        move.name, move, trajectory, MappingProxyType(responses), MappingProxyType(residual)
    )


def _left_ringing(trajectory: Trajectory, jerk_filter: JerkFilter | None, mode: Mode) -> float:
    try:
        return float(
            residual_vibration(trajectory, mode.frequency_hz, mode.damping, jerk_filter=jerk_filter)
        )
    except ValueError as error:
        raise ValueError(f"mode {mode.name!r}: {error}") from None


def _variants(loop: ServoLoop, error: float) -> dict[str, ServoLoop]:
    """Return the loop with each of the feedforwards that are compared, by name."""
    j_hat = 0.0 if loop.feedforward is None else loop.feedforward.J_hat
    inertias = {
        "without feedforward": 0.0,
        "with feedforward": j_hat,
        f"Ĵ {100 * error:+.4g} %": j_hat * (1.0 + error),
        f"Ĵ {-100 * error:+.4g} %": j_hat * (1.0 - error),
    }
    return {
        name: ServoLoop(loop.plant, loop.controller, InertiaFeedforward(inertia))
        for name, inertia in inertias.items()
    }


def _move_clock(
    trajectory: Trajectory, jerk_filter: JerkFilter | None, move: Move, poles: Poles
) -> Clock:
    """Return how to sample a move: until every mode is 1e-2 of the settling tolerance."""
    decay = log(100.0 * abs(move.distance) / move.settle_to)
    lead = trajectory.duration
    if jerk_filter is not None:
        lead += jerk_filter.settling_time(0.01 * move.settle_to / abs(move.distance))
        poles = np.append(poles, -jerk_filter.omega)
    return clock_for(poles, decay, lead=lead, quickest=trajectory.duration / 20.0)


def _follow(
    name: str, respond: Callable[[float, float], LoopResponse], clock: Clock, move: Move
) -> MoveResponse:
    def arrays(dt: float, duration: float) -> tuple[FloatArray, ...]:
        response = respond(dt, duration)
        return response.time, response.inputs, response.outputs, response.states

    samples = followed(arrays, clock)
    full = LoopResponse(*samples)
    beyond = (full.position - move.distance) * np.sign(move.distance)
    return MoveResponse(
        name,
        LoopResponse(*thinned(samples, KEPT)),
        settling_time_s=full.settling_time(move.distance, move.settle_to),
        peak_error=float(np.abs(full.error).max()),
        peak_torque=float(np.abs(full.torque).max()),
        overshoot=max(float(beyond.max()), 0.0),
    )
