"""A whole digital servo loop as one block: planned motion, controller with its delay, axis."""

from __future__ import annotations

from math import ceil
from typing import Any

from ...plant.core_numbers import fastest, sampled_steps
from ...plant.servo_loop import ServoLoop
from ...shaping import Trajectory
from ...shaping.propagate import check_fed
from . import units
from .axis_block import (
    axis_outputs,
    axis_states,
    delay_constants,
    event_constants,
    event_tables,
    event_work,
    events_of,
)
from .blocks import Block, Variable, output, sample_time_constant, signal
from .digital_block import controller_constants, controller_tables, memory_of, tunables
from .digital_controller import DigitalController
from .inverse_block import inverse_constants, inverse_tables
from .linear_blocks import table_rows
from .motion_blocks import trajectory_block
from .units import rate

_TIMING = (
    "Samples run and torques act at their own times, start + k times the sample time and a "
    "computing delay later, whatever the length of the communication steps; the axis goes on "
    "exactly in between, from event to event. Outputs are those at the end of the communication "
    "step, before a sample that is due then."
)


def check_digital_loop(
    trajectory: Trajectory, loop: ServoLoop, dt: float | None, jerk_filter: Any
) -> None:
    """Refuse what cannot leave as one block with a digital loop."""
    own = loop.controller_noun.sample_time
    if dt is not None and dt != own:
        raise ValueError(
            f"dt = {dt!r} for a controller with sample_time = {own!r}: leave dt out, or give the "
            "controller that sample time"
        )
    if jerk_filter is not None:
        raise ValueError(
            "a jerk filter in front of a digital loop: shape the command by limits instead, or "
            "leave the filter out"
        )
    check_fed(trajectory, range(loop.feedforward_noun.order + 1))


def digital_loop_block(trajectory: Trajectory, loop: ServoLoop, name: str, unit: str) -> Block:
    """Return a digital loop on its way along a trajectory as one block."""
    axis, digital = loop.axis, DigitalController.of(loop, trajectory)
    dynamics = digital.feedforward.dynamics
    delay, dt = digital.controller.delay, digital.dt
    motion = trajectory_block(trajectory, name, unit)
    layout, hybrid = events_of(axis)
    start = float(trajectory.start_state[0])
    parameters, memory = tunables(digital, unit), memory_of(digital, unit)
    states = axis_states(axis, unit, start)
    inputs = _disturbances(unit)
    known = [own.name for own in (*inputs, *states)]
    variables: list[Variable] = [
        *parameters,
        sample_time_constant(dt),
        *inputs,
        *_shown(unit, known),
        *axis_outputs(axis, layout, unit, known, inputs=False),
        *states,
        *memory,
    ]
    seen = axis.dynamics.motor if axis.sensor == "motor" else axis.dynamics.load
    moved = axis.dynamics.load if axis.sensor == "load" else axis.dynamics.motor
    steps = sampled_steps(fastest(layout, hybrid), dt, delay)
    waiting = delay_constants(axis, start, delay, dt)
    return Block(
        name,
        "Servo loop: planned motion, digital controller, axis",
        tuple(variables),
        "digital_loop" if dynamics is None else "inverse_loop",
        constants=controller_constants(digital, variables)
        | event_constants(axis, hybrid, variables, steps)
        | {key: motion.constants[key] for key in ("ORDER", "N_PIECES")}
        | {
            "V_ACTING": "V_U",
            "OWN_LEAD": repr(digital.feedforward.lead),
        }
        | waiting
        | ({} if dynamics is None else inverse_constants(dynamics, trajectory)),
        tables={
            **motion.tables,
            **controller_tables(digital),
            **event_tables(axis, layout, hybrid),
            "seen_row": table_rows(layout.row(seen)),
            "moved_row": table_rows(layout.row(moved)),
        }
        | ({} if dynamics is None else inverse_tables(dynamics, trajectory)),
        memory=4 + int(waiting["N_WAITING"]),
        work=event_work(layout, hybrid),
        sample_time=dt,
        start_time=motion.start_time,
        stop_time=motion.start_time + max(ceil(trajectory.duration / dt * (1 - 1e-12)), 1) * dt,
        step=dt,
        notes=(_TIMING,),
    )


def _disturbances(unit: str) -> list[Variable]:
    torque = units.effort(unit)
    return [
        signal("d", "Torque that disturbs the motor, held during each step", torque),
        signal("d_load", "Torque that disturbs the load, held during each step", torque),
    ]


def _shown(unit: str, known: list[str]) -> list[Variable]:
    """Return command, error and torque."""
    told = (
        ("r", "Command", unit),
        ("r_rate", "Velocity of the command", rate(unit, 1)),
        ("r_acceleration", "Acceleration of the command", rate(unit, 2)),
        ("e", "Error", unit),
        ("u", "Torque command that acts", units.effort(unit)),
    )
    return [output(*own, initial_dependencies=dict.fromkeys(known, "dependent")) for own in told]
