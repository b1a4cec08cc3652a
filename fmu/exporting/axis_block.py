"""The axis as a block, exact from event to event: friction, torque limit, modes, load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import floor, isfinite, log10

import numpy as np

from ...plant.axis import Axis
from ...plant.controller import Controller
from ...plant.core_numbers import fastest
from ...plant.hybrid import Hybrid, hybrid_of
from ...plant.layout import Layout, at_rest
from ...plant.pid import PID
from ...plant.signal_pieces import TERMS
from ...shaping.pieces import FloatArray
from . import units
from .blocks import LEAST_POSITIVE, Block, Variable, output, parameter, signal
from .linear_blocks import MAX_STATES, linear_block, table_rows
from .units import rate

_STEPS = 1000
_SHOWN = (
    ("y", "Position measured"),
    ("y_rate", "Velocity measured"),
    ("y_load", "Position of the load"),
    ("twist", "Position of the load less that of the motor"),
    ("torque", "Torque of the motor, behind the current loop"),
    ("y_motor", "Position of the motor"),
)
"""What an axis puts out: the outputs of `Axis.system`."""


def axis_block(axis: Axis, name: str, unit: str) -> Block:
    """Return an axis as a block of continuous time, a linear one as a linear block."""
    if not _kinds(axis):
        return linear_block(axis.system(), name, linear_units(axis, unit))
    layout, hybrid = events_of(axis)
    limit, inputs = limit_of(axis, unit), torques_of(unit)
    states = axis_states(axis, unit, 0.0)
    known = [own.name for own in (*limit, *inputs, *states)]
    variables = [*limit, *inputs, *axis_outputs(axis, layout, unit, known), *states]
    step = _step(fastest(layout, hybrid))
    return Block(
        name,
        f"Axis, {', '.join(_kinds(axis))}, {len(states)} states",
        tuple(variables),
        "axis",
        constants=event_constants(axis, hybrid, variables, (step, step))
        | {
            "V_D": "V_D_MOTOR",
            "OWN_LIMIT": "s->value[V_TORQUE_LIMIT]" if limit else "INFINITE",
        },
        tables=event_tables(axis, layout, hybrid),
        memory=2,
        work=event_work(layout, hybrid),
        stop_time=_STEPS * step,
        step=step,
        notes=(
            "Exact for inputs that are held during each communication step, from event to event "
            "between stick and slide, whatever the length of the steps. The encoder's resolution "
            "is the controller's matter.",
        ),
    )


def limit_of(axis: Axis, unit: str) -> list[Variable]:
    """Return the parameter of a torque limit, where there is one."""
    if not isfinite(axis.torque_limit):
        return []
    told = ("torque_limit", "Limit", axis.torque_limit, units.effort(unit))
    return [parameter(*told, minimum=LEAST_POSITIVE)]


def torques_of(unit: str) -> list[Variable]:
    """Return the torques on drive, motor and load as inputs."""
    told = (
        ("u", "Torque command, held during each step"),
        ("d_motor", "Torque that disturbs the motor, held during each step"),
        ("d_load", "Torque that disturbs the load, held during each step"),
    )
    return [signal(*own, units.effort(unit)) for own in told]


def _kinds(axis: Axis) -> list[str]:
    """Return what of an axis no linear block can have."""
    told = ["dry friction"] * (axis.friction is not None)
    told += ["ripple"] * (axis.ripple is not None)
    told += ["torque limit"] * isfinite(axis.torque_limit)
    return told + ["constant load"] * bool(axis.constant_load)


def linear_units(axis: Axis, unit: str) -> dict[str, str]:
    """Return the units of all signals and states of `Axis.system`, by name."""
    torque = units.effort(unit)
    known = dict.fromkeys(("u", "d_motor", "d_load"), torque)
    known |= {own: _unit_of(own, unit) for own, _ in _SHOWN}
    return known | {own: _unit_of(own, unit) for own in axis.dynamics.names}


def _unit_of(signal_name: str, unit: str) -> str:
    if signal_name == "torque":
        return units.effort(unit)
    if signal_name.startswith("x_"):
        return "1"
    return rate(unit, 1) if signal_name.endswith("rate") else unit


def _step(norm: float) -> float:
    """Return a round step in which the series converges at once."""
    return min(10.0 ** floor(log10(2.0 / norm)), 1e-3) if norm else 1e-3


def events_of(axis: Axis) -> tuple[Layout, Hybrid]:
    """Return an axis as a piecewise linear system under torques held on motor, load and drive."""
    size = axis.dynamics.size
    if size > MAX_STATES:
        raise ValueError(
            f"an axis of {size} states: expected at most {MAX_STATES}; leave out modes beyond the "
            "bandwidth"
        )
    layout = Layout(size, (), set=("motor", "load", "ripple"), digital=True)
    held = Controller(PID(1.0, 0.0, 0.0), sample_time=1.0)  # a torque that is held has no law
    return layout, hybrid_of(axis, held, layout, None, 0.0)


def axis_states(axis: Axis, unit: str, position: float) -> list[Variable]:
    """Return the states of an axis that rests with the measured position given."""
    rest, _ = at_rest(axis, position)
    return [
        Variable(
            f"state.{own}",
            f"State {own}",
            "local",
            initial="exact",
            start=float(x),
            unit=_unit_of(own, unit),
            state=True,
            macro="",
        )
        for own, x in zip(axis.dynamics.names, rest, strict=True)
    ]


def axis_outputs(
    axis: Axis, layout: Layout, unit: str, known: Sequence[str], *, inputs: bool = True
) -> list[Variable]:
    """Return what an axis puts out; `inputs` where its torque is one."""
    names = [f"state.{own}" for own in axis.dynamics.names]
    behind = [*names, "d_motor", "d_load", "u"] if inputs else names
    initial = dict.fromkeys(known, "dependent")
    shown = []
    for (own, told), row in zip(_SHOWN, output_rows(axis, layout), strict=True):
        on = {of: "dependent" for of, x in zip(behind, row, strict=False) if x}
        shown.append(
            output(
                own,
                told,
                _unit_of(own, unit),
                dependencies=on,
                initial_dependencies=initial,
            )
        )
    if axis.friction is not None:
        told = "Direction in which the motor slides, 0 while it sticks"
        shown.append(output("sliding", told, variability="discrete", initial_dependencies=initial))
    return shown


def output_rows(axis: Axis, layout: Layout) -> FloatArray:
    """Return the rows of `_SHOWN` over z."""
    d = axis.dynamics
    position = d.motor if axis.sensor == "motor" else d.load
    velocity = d.load_rate if axis.sensor == "load" else d.motor_rate
    rows = [
        layout.row(own)
        for own in (position, velocity, d.load, d.load - d.motor, d.torque[:-1], d.motor)
    ]
    rows[4][layout.held] = d.torque[-1]
    return np.array(rows)


def event_constants(
    axis: Axis, hybrid: Hybrid, variables: Sequence[Variable], steps: tuple[float, float]
) -> dict[str, str]:
    """Return the macros of events.c; `steps` are two lengths, the longer first."""
    frictions = len({mode.friction for mode in hybrid.modes})
    places = {own.name: k for k, own in enumerate(variables)}
    states = [k for k, own in enumerate(variables) if own.name.startswith("state.")]
    return {
        "N_Z": str(hybrid.rows.shape[2]),
        "N_MOVING": str(hybrid.rates.shape[1]),
        "N_MODES": str(len(hybrid.modes)),
        "N_GUARDS": str(hybrid.rows.shape[1]),
        "N_FRICTION": str(frictions),
        "RIPPLE_PERIOD": repr(1.0 if axis.ripple is None else axis.ripple.period),
        "N_OUTPUTS": str(len(_SHOWN)),
        "V_STATE": str(states[0]),
        "V_OUTPUT": str(places["y"]),
        "LONGER_STEP": repr(float(steps[0])),
        "SHORTER_STEP": repr(float(steps[1])),
    }


def delay_constants(axis: Axis, position: float, delay: float, dt: float) -> dict[str, str]:
    """Return the constants of torques that wait for a computing delay, at most N_WAITING at once.

    What holds the axis at its position acts before the first of them.
    """
    return {
        "OWN_DELAY": repr(delay),
        "N_WAITING": str(floor(delay / dt) + 2),
        "HOLDING": repr(at_rest(axis, position)[1]),
    }


def event_tables(axis: Axis, layout: Layout, hybrid: Hybrid) -> dict[str, list[object]]:
    """Return the arrays of events.c."""
    return {
        "mode_rates": table_rows(hybrid.rates),
        "guard_rows": table_rows(hybrid.rows),
        "guard_next": table_rows(hybrid.next),
        "event_onto": table_rows(hybrid.onto),
        "event_along": table_rows(hybrid.along),
        "rate_row": table_rows(layout.row(axis.dynamics.motor_rate)),
        "motor_row": table_rows(layout.row(axis.dynamics.motor)),
        "ripple_edges": table_rows([0.0, 1.0] if axis.ripple is None else axis.ripple.edges),
        "output_rows": table_rows(output_rows(axis, layout)),
    }


def event_work(layout: Layout, hybrid: Hybrid) -> int:
    """Return the numbers of work space: the core's JOUNCE_AUTOMATON_WORK, and one more."""
    n, moving, terms = layout.size, layout.moving, TERMS
    modes, guards = len(hybrid.modes), int(hybrid.rows.shape[1])
    each = 2 * moving * n + guards * n * (14 + terms)
    return 1 + modes * each + (terms + 2) * n + 2 * moving * n + 2 * terms


def rest_at(block: Block, axis: Axis, position: float) -> Block:
    """Return an axis's block that rests with the measured position given."""
    rest, _ = at_rest(axis, position)
    start = {f"state.{own}": float(x) for own, x in zip(axis.dynamics.names, rest, strict=True)}
    return replace(
        block,
        variables=tuple(
            replace(own, start=start[own.name]) if own.name in start else own
            for own in block.variables
        ),
    )
