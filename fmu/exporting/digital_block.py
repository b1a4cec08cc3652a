"""The whole digital controller as a block: its variables, macros and tables."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from ...plant.anti_windup import BackCalculation, Clamp
from ...plant.cascade import CascadedPI
from ...plant.core_numbers import memory_at_rest, tuning
from ...plant.feedforward import Feedforward
from ...shaping.derivatives import derivative_name
from . import units
from .blocks import (
    LEAST_POSITIVE,
    Block,
    Variable,
    macro,
    output,
    parameter,
    sample_time_constant,
    signal,
)
from .digital_controller import DigitalController
from .inverse_block import remembered_of
from .linear_blocks import table_rows
from .loop_blocks import HELD
from .motion_blocks import SAMPLING
from .units import rate

_TICKS = 1000
_NUMBERS = (
    *("LAW", "ANTI_WINDUP", "SECTIONS", "ORDER", "DT", "KP", "KI", "KR", "RATE_FILTER"),
    *("POSITION_GAIN", "VELOCITY_FEEDFORWARD", "FRICTION", "LIMIT", "TRACKING_TIME"),
    *("INTEGRAL_LIMIT", "ENCODER_STEP"),
)
"""Of the core's `jounce_controller`, in the order of `tuning`; the first four are whole."""


def digital_block(digital: DigitalController, name: str, unit: str) -> Block:
    """Return a digital controller as a block with a fixed sample time."""
    parameters, memory = tunables(digital, unit), memory_of(digital, unit)
    now = commands(digital, unit)
    ahead = commands(digital, unit, ahead=True) if digital.feedforward.lead else []
    inputs = [*now, *ahead, signal("y", "Position measured", unit)]
    if digital.two_encoders:
        inputs.append(signal("y_motor", "Position of the motor, for its velocity", unit))
    known = [own.name for own in (*parameters, *inputs, *memory)]
    variables = [
        *parameters,
        sample_time_constant(digital.dt),
        *inputs,
        *(
            output(
                own,
                told,
                of,
                variability="discrete",
                initial_dependencies=dict.fromkeys(known, "dependent"),
            )
            for own, told, of in (
                ("e", "Error", unit),
                ("u_asked", "Torque before the limit", units.effort(unit)),
                ("u", "Torque", units.effort(unit)),
            )
        ),
        *memory,
    ]
    return Block(
        name,
        _description(digital),
        tuple(variables),
        "digital_controller",
        constants=controller_constants(digital, variables)
        | {
            "V_MOVED": "V_Y_MOTOR" if digital.two_encoders else "V_Y",
            "V_AHEAD": ahead[0].macro if ahead else "V_R",
        },
        tables=controller_tables(digital),
        sample_time=digital.dt,
        stop_time=_TICKS * digital.dt,
        step=digital.dt,
        notes=(SAMPLING, HELD, *_notes(digital)),
    )


def _description(digital: DigitalController) -> str:
    cascade = isinstance(digital.controller.law, CascadedPI)
    parts = ["P-PI cascade" if cascade else "PID"]
    parts += [f"{len(digital.controller.sections)} filter sections"] * bool(
        len(digital.controller.sections)
    )
    parts += ["feedforward"] * bool(digital.feedforward.torque or digital.feedforward.position)
    parts += ["torque limit"] * isfinite(digital.torque_limit)
    return f"Digital controller: {', '.join(parts)}"


def _notes(digital: DigitalController) -> list[str]:
    notes = []
    if digital.controller.delay:
        notes.append(
            f"The computing delay of {digital.controller.delay!r} s is the processor's own and not "
            "in this block; the loop as one block has it."
        )
    if digital.feedforward.lead:
        notes.append(
            f"The inputs that end in _ahead are the command {digital.feedforward.lead!r} s later."
        )
    return notes


def commands(digital: DigitalController, unit: str, *, ahead: bool = False) -> list[Variable]:
    """Return the command, its derivatives, and what an inverse adds to them, as inputs."""
    told = [
        (command_name(k), f"{derivative_name(k).capitalize()} of the command", rate(unit, k))
        for k in range(digital.order + 1)
    ]
    if digital.feedforward.dynamics is not None:
        told += remembered_of(unit)
    return [
        signal(own + "_ahead" * ahead, text + ", a lead later" * ahead, of)
        for own, text, of in told
    ]


def command_name(k: int) -> str:
    """Return the name of derivative k of the command: r, r_rate, r_acceleration and so on."""
    return ("r", "r_rate")[k] if k < 2 else "r_" + derivative_name(k).replace(" ", "_")


def tunables(digital: DigitalController, unit: str) -> list[Variable]:
    """Return what may be tuned; the feedforward's gains stand together, of derivatives 0 on."""
    law, way = digital.controller.law, digital.controller.anti_windup
    torque = units.effort(unit)
    if isinstance(law, CascadedPI):
        found = [
            parameter("position_gain", "Velocity per error", law.position_gain, "1/s"),
            parameter("kp", "Torque per velocity", law.velocity_gain, units.gain(unit, 1)),
            parameter("ki", "Torque per its integral", law.integral_gain, units.gain(unit, 0)),
            parameter("velocity_feedforward", "Part fed forward", law.velocity_feedforward),
        ]
    else:
        found = [
            parameter("kp", "Proportional gain", law.kp, units.gain(unit, 0)),
            parameter("ki", "Integral gain", law.ki, units.gain(unit, -1)),
            parameter("kr", "Rate gain", law.kr, units.gain(unit, 1)),
        ]
    lag = digital.controller.rate_filter
    found.append(parameter("rate_filter", "Time constant of the rate", lag, "s", minimum=0.0))
    fed: Feedforward = digital.feedforward
    if isfinite(digital.torque_limit):
        found.append(_positive("torque_limit", "Torque limit", digital.torque_limit, torque))
    if isinstance(way, BackCalculation):
        found.append(_positive("tracking_time", "Of the integral", way.tracking_time, "s"))
    if isinstance(way, Clamp):
        found.append(_positive("integral_limit", "Of its torque", way.integral_limit, torque))
    found.append(
        parameter("friction_fed", "Friction fed forward", fed.friction, torque, minimum=0.0)
    )
    return found + [
        parameter(
            f"feed_{derivative_name(k).replace(' ', '_')}",
            f"Torque per {derivative_name(k)} of the command",
            gain,
            units.feed(unit, k),
        )
        for k, gain in enumerate(fed.torque_gains(digital.order).tolist())
    ]


def _positive(name: str, told: str, start: float, unit: str) -> Variable:
    return parameter(name, told, start, unit, minimum=LEAST_POSITIVE)


def memory_of(digital: DigitalController, unit: str) -> list[Variable]:
    """Return what is kept from sample to sample, together, in the core's order."""
    cascade = isinstance(digital.controller.law, CascadedPI)
    torque = units.effort(unit)
    told = [
        ("started", "0 before the first sample, then 1", "1"),
        ("integral", "Integral of the error", units.integral(unit, 0 if cascade else 1)),
        ("past", "Position or error of the sample before", unit),
        ("rate", "Its rate, filtered", rate(unit, 1)),
    ]
    for i in range(len(digital.controller.sections)):
        told += [
            (f"filter_{i + 1}_{k}", f"Memory {k} of filter section {i + 1}", torque) for k in (1, 2)
        ]
    start = memory_at_rest(digital.controller, digital.holding)
    return [
        Variable(own, text, "local", "discrete", "exact", float(x), of, macro=macro(own))
        for (own, text, of), x in zip(told, start, strict=True)
    ]


def controller_constants(
    digital: DigitalController, variables: Sequence[Variable]
) -> dict[str, str]:
    """Return the macros of digital.c: what of the controller is a variable, and all else."""
    c, fed = digital.controller, digital.feedforward
    numbers = tuning(c, fed, digital.torque_limit, digital.encoder_step)
    texts = [*(str(int(x)) for x in numbers[:4]), *map(_text, numbers[4:])]
    own = {f"OWN_{key}": text for key, text in zip(_NUMBERS, texts, strict=True)}
    renamed = {"FRICTION": "FRICTION_FED", "LIMIT": "TORQUE_LIMIT"}
    taken = {variable.macro for variable in variables if variable.variability == "tunable"}
    for key in _NUMBERS:
        place = f"V_{renamed.get(key, key)}"
        if place in taken:
            own[f"OWN_{key}"] = f"v[{place}]"
    return own | {
        "SAMPLE_TIME": repr(digital.dt),
        "N_REMEMBERED": "0" if fed.dynamics is None else "2",
        "V_FED": "V_FEED_POSITION",
        "V_OWN": "V_STARTED",
    }


def _text(x: float) -> str:
    return repr(x) if isfinite(x) else "INFINITE"


def controller_tables(digital: DigitalController) -> dict[str, list[object]]:
    """Return the arrays of digital.c."""
    gains = digital.feedforward.position_gains(digital.order)
    if digital.feedforward.dynamics is not None:
        gains = np.append(gains, [0.0, 1.0])
    return {
        "filter_sections": table_rows(np.asarray(digital.controller.sections)),
        "position_gains": table_rows(gains),
    }
