"""The survey of a servo loop (Thompson, Section VII): margins, step, moves, wrong Ĵ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import log
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..plant import (
    PID,
    Inertia,
    InertiaFeedforward,
    LoopResponse,
    ServoLoop,
    design_pid,
    printed_pid,
)
from ..shaping import JerkFilter, Limits, Trajectory, min_time_move
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from .margins import LoopMargins, loop_margins
from .margins.result import shown_intervals
from .sampling import Clock, clock_for, followed, thinned
from .scenario import Gains, Mode, Move, Scenario, as_scenario
from .shapers import residual_vibration
from .step import KEPT, StepResponse, step_response

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
    """A move of the scenario, shaped, filtered and run through the loop.

    `responses` maps a name to a response: "without feedforward", "with feedforward", and Ĵ
    varied either way. `settling_time_s`, `peak_error` and `peak_torque` are those of the loop
    as the scenario describes it, with feedforward. `residual_vibration` maps the name of a mode
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
        """The response with the scenario's own feedforward."""
        return self.responses["with feedforward"]


@dataclass(frozen=True, eq=False)
class Survey:
    """Everything that the survey of a scenario found, in SI units."""

    scenario: Scenario
    loop: ServoLoop
    jerk_filter: JerkFilter | None
    margins: LoopMargins
    checks: tuple[SpecificationCheck, ...]
    step: StepResponse
    moves: tuple[MoveSurvey, ...]

    @property
    def findings(self) -> tuple[str, ...]:
        """Plain sentences on what does not meet its specification."""
        missed = [check for check in self.checks if not check.met]
        if not missed:
            return ()
        listed = ", ".join(
            f"{check.name} {check.shown} {check.unit} (asked {check.asked:.4g})" for check in missed
        )
        overshoot = f"step overshoot {self.step.overshoot_percent:.1f} %"
        if self.scenario.gains == "published":
            return (
                "The gains printed in Thompson, Section VII (k_r = 11.09J, k_i = 6.286k_r, "
                f"k_p = 3.187k_r) miss their specifications: {listed}; {overshoot}, where the "
                'text has 40 %. Use gains = "design" for a loop that meets them.',
            )
        return (f"The gains miss their specifications: {listed}; {overshoot}.",)

    def plot(self) -> Figure:
        """Draw the survey in pyplot's current figure, or a new one if that is not empty."""
        from .plots import plot_survey

        return plot_survey(self)


def survey(
    scenario: Scenario | str | Path, *, overrides: Mapping[str, Any] | None = None
) -> Survey:
    """Survey the servo loop that a scenario describes.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario, or the path of its TOML file.
    overrides : mapping of str to object, optional
        Values in place of the file's, as `load_scenario` takes them.

    Returns
    -------
    Survey

    Raises
    ------
    ScenarioError
        For a scenario file that cannot be used.
    UnstableLoopError
        Where the closed loop is unstable.
    ValueError
        Where gains cannot be designed or a move cannot be planned or driven.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """
    scenario = as_scenario(scenario, overrides)
    try:
        controller = controller_of(scenario)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: controller.specification: {error}") from None
    plant, feedforward = Inertia(scenario.inertia), InertiaFeedforward(scenario.feedforward_inertia)
    loop = ServoLoop(plant, controller, feedforward)
    margins = loop_margins(loop.loop_transfer())
    if not margins.stable:
        worst = max(margins.closed_loop_poles, key=lambda pole: pole.real)
        gains = shown_intervals(margins.stabilizing_gains)
        remedy = f"by a common factor {gains}" if margins.stabilizing_gains else "one by one"
        raise UnstableLoopError(
            f"{scenario.path}: the closed loop is UNSTABLE, with a pole at {worst:.4g} rad/s; "
            f"there are no margins to report. Change the gains {remedy}"
        )
    behind = scenario.filter
    jerk_filter = None if behind is None else JerkFilter(behind.corner_hz, behind.order)
    poles = margins.closed_loop_poles
    return Survey(
        scenario,
        loop,
        jerk_filter,
        margins,
        _specification_checks(scenario, margins),
        step_response(loop, poles),
        tuple(_move(scenario, loop, jerk_filter, move, poles) for move in scenario.moves),
    )


def controller_of(scenario: Scenario) -> PID:
    """Return the controller that a scenario gives or asks for."""
    if isinstance(scenario.gains, Gains):
        return PID(scenario.gains.kp, scenario.gains.ki, scenario.gains.kr)
    if scenario.gains == "published":
        return printed_pid(scenario.inertia)
    asked = scenario.specification
    assert asked is not None  # the scenario's own check
    return design_pid(
        scenario.inertia,
        crossover_hz=asked.crossover_hz,
        phase_margin_deg=asked.phase_margin_deg,
        lower_gain_margin_db=asked.lower_gain_margin_db,
    )


def _specification_checks(
    scenario: Scenario, margins: LoopMargins
) -> tuple[SpecificationCheck, ...]:
    asked = scenario.specification
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
    scenario: Scenario, loop: ServoLoop, jerk_filter: JerkFilter | None, move: Move, poles: Poles
) -> MoveSurvey:
    try:
        trajectory = min_time_move(move.distance, Limits.from_bounds(move.bounds))
        clock = _move_clock(trajectory, jerk_filter, move, poles)
        responses = {}
        for name, feedforward in _variants(scenario).items():
            varied = ServoLoop(loop.plant, loop.controller, feedforward)

            def respond(dt: float, duration: float, loop: ServoLoop = varied) -> LoopResponse:
                return loop.respond(trajectory, dt, duration=duration, jerk_filter=jerk_filter)

            responses[name] = _follow(name, respond, clock, move)
        residual = {
            mode.name: _left_ringing(trajectory, jerk_filter, mode) for mode in scenario.modes
        }
    except ValueError as error:
        raise ValueError(f"{scenario.path}: move {move.name!r}: {error}") from None
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


def _variants(scenario: Scenario) -> dict[str, InertiaFeedforward]:
    """Return the feedforwards that are compared, by name."""
    j_hat, error = scenario.feedforward_inertia, scenario.inertia_error
    inertias = {
        "without feedforward": 0.0,
        "with feedforward": j_hat,
        f"Ĵ {100 * error:+.4g} %": j_hat * (1.0 + error),
        f"Ĵ {-100 * error:+.4g} %": j_hat * (1.0 - error),
    }
    return {name: InertiaFeedforward(inertia) for name, inertia in inertias.items()}


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
