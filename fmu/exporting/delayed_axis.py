"""An axis behind a computing delay as a block: what a digital controller in an SSP moves."""

from __future__ import annotations

from ...plant.axis import Axis
from ...plant.controller import Controller
from ...plant.core_numbers import fastest, sampled_steps
from . import units
from .axis_block import (
    axis_outputs,
    axis_states,
    delay_constants,
    event_constants,
    event_tables,
    event_work,
    events_of,
    limit_of,
    torques_of,
)
from .blocks import Block, output, sample_time_constant
from .motion_blocks import SAMPLING


def delayed_axis_block(
    axis: Axis, controller: Controller, name: str, unit: str, *, position: float
) -> Block:
    """Return an axis that rests with the measured position given, behind a controller's delay.

    Its torque is sampled as often as the controller runs, and acts the computing delay later,
    exactly, until the next one does; what holds the axis acts before.
    """
    dt, delay = controller.sample_time, controller.delay
    assert dt is not None  # as only what is digital has a delay
    layout, hybrid = events_of(axis)
    limit, inputs = limit_of(axis, unit), torques_of(unit)
    states = axis_states(axis, unit, position)
    known = [own.name for own in (*inputs[1:], *states)]
    acting = output(
        "u_acting",
        "Torque command that acts",
        units.effort(unit),
        initial_dependencies=dict.fromkeys(known, "dependent"),
    )
    shown = axis_outputs(axis, layout, unit, known, inputs=False)
    variables = [*limit, sample_time_constant(dt), *inputs, acting, *shown, *states]
    steps = sampled_steps(fastest(layout, hybrid), dt, delay)
    waiting = delay_constants(axis, position, delay, dt)
    return Block(
        name,
        f"Axis behind a computing delay, {len(states)} states",
        tuple(variables),
        "delayed_axis",
        constants=event_constants(axis, hybrid, variables, steps)
        | {
            "V_D": "V_D_MOTOR",
            "V_ACTING": "V_U_ACTING",
            "OWN_LIMIT": "s->value[V_TORQUE_LIMIT]" if limit else "INFINITE",
            "SAMPLE_TIME": repr(dt),
        }
        | waiting,
        tables=event_tables(axis, layout, hybrid),
        memory=4 + int(waiting["N_WAITING"]),
        work=event_work(layout, hybrid),
        sample_time=dt,
        stop_time=1000 * dt,
        step=dt,
        notes=(
            SAMPLING,
            f"The torque of a sample acts {delay!r} s after it, until that of the next one does, "
            "whatever the length of the communication steps; the axis goes on exactly, from event "
            "to event.",
        ),
    )
