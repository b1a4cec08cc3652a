"""A whole servo loop as one block: planned motion, jerk filter, sampled controller, plant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ...plant.exact_response import state_space
from ...plant.servo_loop import ServoLoop
from ...shaping import JerkFilter, Trajectory
from ...shaping.checks import of_kind, positive
from ...shaping.propagate import check_fed
from ...shaping.trajectory import as_trajectory
from . import units
from .blocks import Block, Variable, output, sample_time_constant, signal
from .linear_blocks import linear_block
from .loop_blocks import SampledController, controller_block
from .motion_blocks import SAMPLING, jerk_filter_block, trajectory_block
from .units import rate


@dataclass(frozen=True)
class SampledLoop:
    """A servo loop that follows a planned motion, to be exported as one block.

    The controller runs once every dt, as `SampledController` does; the plant goes on exactly
    between samples. It starts at rest where the trajectory starts.

    Parameters
    ----------
    trajectory : Trajectory
        Of order 2 or more; behind a jerk filter, of any.
    loop : ServoLoop
        Its plant has the outputs y and y_rate.
    dt : float
        Sample time, positive.
    jerk_filter : JerkFilter, optional
        Between trajectory and loop; of order 3 or more.

    Raises
    ------
    TypeError, ValueError
        For a part of another type or of too low an order, or a dt that is not positive.
    """

    trajectory: Trajectory
    loop: ServoLoop
    dt: float
    jerk_filter: JerkFilter | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "trajectory", as_trajectory(self.trajectory))
        of_kind("loop", self.loop, ServoLoop, "a ServoLoop")
        object.__setattr__(self, "dt", positive("dt", self.dt))
        check_commands(self.trajectory, self.jerk_filter)


def check_commands(trajectory: Trajectory, jerk_filter: JerkFilter | None) -> None:
    """Refuse what gives a controller no acceleration of the command."""
    if jerk_filter is None:
        check_fed(trajectory, (0, 1, 2))
        return
    if not isinstance(jerk_filter, JerkFilter):
        raise TypeError(f"jerk_filter = {jerk_filter!r}: expected a JerkFilter or None")
    if jerk_filter.order < 3:
        raise ValueError(
            f"a jerk filter of order {jerk_filter.order} puts out no acceleration, which the "
            "controller needs: use order 3 or more"
        )


def servo_block(sampled: SampledLoop, name: str, unit: str) -> Block:
    """Return a servo loop as one block with a fixed sample time."""
    loop, dt, behind = sampled.loop, sampled.dt, sampled.jerk_filter
    motion = trajectory_block(sampled.trajectory, name, unit)
    control = controller_block(SampledController(loop.controller, dt, loop.feedforward), name, unit)
    plant = _plant_block(loop.plant, name, unit)
    shaped = [] if behind is None else jerk_filter_block(behind, name, unit).variables[:1]
    start = float(sampled.trajectory.start_state[0])
    states = [_at(start, own) for own in plant.variables if own.name.startswith("state.")]
    parameters = [own for own in control.variables if own.variability == "tunable"]
    integral = [own for own in control.variables if own.name == "e_integral"]
    exact = [*parameters, *shaped, *states, *integral]
    known = {own.name: "dependent" for own in exact} | {"d": "dependent"}
    variables = [
        *parameters,
        *shaped,
        sample_time_constant(dt),
        signal("d", "Disturbance torque, held during each step", units.effort(unit)),
        *_outputs(plant, unit, known),
        *states,
        *integral,
    ]
    places = {own.name: k for k, own in enumerate(variables)}
    lasting = motion.stop_time - motion.start_time
    lasting += 0.0 if behind is None else behind.settling_time(1e-6)
    sizes = {key: text for key, text in plant.constants.items() if key.startswith("N_")}
    return Block(
        name,
        "Servo loop: planned motion, sampled PID controller with feedforward, plant",
        tuple(variables),
        "servo",
        constants=sizes
        | {key: motion.constants[key] for key in ("ORDER", "N_PIECES")}
        | {
            "SAMPLE_TIME": repr(dt),
            "N_LAGS": str(0 if behind is None else behind.order),
            "V_STATE": str(places[states[0].name]),
            "V_OUTPUT": str(places["u"] + 1),
        },
        tables={**motion.tables, **plant.tables},
        memory=1 + max(0 if behind is None else behind.order, 1),
        work=plant.work,
        sample_time=dt,
        start_time=motion.start_time,
        stop_time=motion.start_time + max(round(lasting / dt), 1) * dt,
        step=dt,
        notes=(
            SAMPLING,
            "At a sample the controller sees command and plant at that time, without delay; its "
            "torque is held until the next sample, and the plant goes on exactly in between. "
            "Outputs are those at the end of the communication step.",
        ),
    )


def _plant_block(plant: Any, name: str, unit: str) -> Block:
    """Return a plant as a linear block of continuous time, with outputs y and y_rate."""
    system = state_space(plant.system())
    labels = [*system.output_labels]
    if system.ninputs != 1 or not {"y", "y_rate"} <= set(labels) or system.isdtime(strict=True):
        raise ValueError(
            f"a plant with {system.ninputs} inputs and outputs {', '.join(labels)}: expected one "
            "input and outputs y and y_rate, in continuous time"
        )
    kinds = {"rate": rate(unit, 1), "u": units.effort(unit)}
    names = [*system.input_labels, *labels, *system.state_labels]
    return linear_block(
        system, name, {own: kinds.get(own.rpartition("_")[2], unit) for own in names}
    )


def _at(start: float, variable: Variable) -> Variable:
    """Return a state's variable; the position starts where the trajectory does."""
    return replace(variable, start=start) if variable.name == "state.y" else variable


def _outputs(plant: Block, unit: str, known: dict[str, str]) -> list[Variable]:
    """Return command, error and torque, and what the plant puts out."""
    [torque] = (own.name for own in plant.variables if own.causality == "input")
    fed = {own.name for own in plant.outputs if torque in own.dependencies}
    fed |= {"e"} if "y" in fed else set()
    told = [
        ("r", "Command", unit),
        ("r_rate", "Velocity of the command", rate(unit, 1)),
        ("r_acceleration", "Acceleration of the command", rate(unit, 2)),
        ("e", "Error", unit),
        ("u", "Torque of the controller", units.effort(unit)),
        *((own.name, own.description, own.unit) for own in plant.outputs),
    ]
    return [
        output(
            *own,
            dependencies={"d": "constant"}
            if own[0] in fed or (own[0] == "e" and "y" in fed)
            else {},
            initial_dependencies=known,
        )
        for own in told
    ]
