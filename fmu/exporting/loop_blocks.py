"""Blocks of a servo loop: inertia, and sampled PID with feedforward."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...plant.feedforward import InertiaFeedforward
from ...plant.inertia import Inertia
from ...plant.pid import PID, Rate
from ...shaping.checks import positive
from . import units
from .blocks import (
    LEAST_POSITIVE,
    Block,
    Variable,
    output,
    parameter,
    sample_time_constant,
    signal,
)
from .motion_blocks import SAMPLING
from .units import rate

_TICKS = 1000
HELD = (
    "What sample k computes is put out at the end of the step in which it runs, and held: step "
    "this block before the block that uses its output (Gauss-Seidel order) and there is no delay; "
    "a host that steps all blocks on the values of the last communication point adds one step. "
    "Before the first sample the output is what the inputs of the initialisation give."
)


@dataclass(frozen=True)
class SampledController:
    """A PID run once every dt, with feedforward of the command's acceleration.

        u_k = kp·e_k + ki·I_k + kr·ė_k + Ĵ·r̈_k,   I_k = I_{k−1} + dt·e_k,   e = r − y

    as in `PID.sampled`, to be exported.

    Parameters
    ----------
    controller : PID
    dt : float
        Sample time, positive.
    feedforward : InertiaFeedforward, optional
        Default: none (Ĵ = 0, still tunable in the FMU).
    rate : "measured" or "differenced", optional
        Whether ė is r_rate − y_rate, or (e_k − e_{k−1})/dt.

    Raises
    ------
    TypeError, ValueError
        For a part of another type, a dt that is not positive, or another rate.

    Examples
    --------
    >>> SampledController(PID(kp=2.0, ki=1.0, kr=3.0), dt=1e-3).dt
    0.001
    """

    controller: PID
    dt: float
    feedforward: InertiaFeedforward | None = None
    rate: Rate = "measured"

    def __post_init__(self) -> None:
        if not isinstance(self.controller, PID):
            raise TypeError(f"controller = {self.controller!r}: expected PID")
        if not isinstance(self.feedforward, InertiaFeedforward | None):
            raise TypeError(f"feedforward = {self.feedforward!r}: expected InertiaFeedforward")
        object.__setattr__(self, "dt", positive("dt", self.dt))
        if self.rate not in ("measured", "differenced"):
            raise ValueError(f"rate = {self.rate!r}: expected 'measured' or 'differenced'")


def inertia_block(plant: Inertia, name: str, unit: str) -> Block:
    """Return a pure inertia as a block of continuous time."""
    moving = ("y", "Position", unit), ("y_rate", "Velocity", rate(unit, 1))
    states = [
        Variable(
            own,
            told,
            "output",
            initial="exact",
            unit=of,
            state=True,
            dependencies={own: "constant"},
            macro=f"V_{own.upper()}",
        )
        for own, told, of in moving
    ]
    return Block(
        name,
        "Inertia without friction",
        (
            parameter(
                "J", "Moment of inertia", plant.J, units.inertia(unit), minimum=LEAST_POSITIVE
            ),
            signal("u", "Torque, held during each step", units.effort(unit)),
            *states,
            _rate_of("y", rate(unit, 1), {"y_rate": "constant"}, {"y_rate": "constant"}),
            _rate_of(
                "y_rate", rate(unit, 2), {"u": "tunable"}, {"u": "dependent", "J": "dependent"}
            ),
        ),
        "inertia",
        partials=True,
        notes=("Exact for a torque that is held during each communication step.",),
    )


def _rate_of(
    state: str, unit: str, dependencies: Mapping[str, str], initial: Mapping[str, str]
) -> Variable:
    return Variable(
        f"der({state})",
        f"Derivative of {state}",
        "local",
        initial="calculated",
        unit=unit,
        derivative_of=state,
        dependencies=dependencies,
        initial_dependencies=initial,
        macro=f"V_DER_{state.upper()}",
    )


def controller_block(sampled: SampledController, name: str, unit: str) -> Block:
    """Return a sampled controller as a block with a fixed sample time."""
    gains, measured = sampled.controller, sampled.rate == "measured"
    feedforward = 0.0 if sampled.feedforward is None else sampled.feedforward.J_hat
    parameters = [
        parameter("kp", "Proportional gain", gains.kp, units.gain(unit, 0)),
        parameter("ki", "Integral gain", gains.ki, units.gain(unit, -1)),
        parameter("kr", "Rate gain", gains.kr, units.gain(unit, 1)),
        parameter("J_hat", "Inertia fed forward", feedforward, units.inertia(unit), minimum=0.0),
    ]
    rates = [
        signal("r_rate", "Velocity of the command", rate(unit, 1)),
        signal("y_rate", "Velocity measured", rate(unit, 1)),
    ]
    inputs = [
        signal("r", "Command", unit),
        *(rates[:1] if measured else []),
        signal("r_acceleration", "Acceleration of the command", rate(unit, 2)),
        signal("y", "Position measured", unit),
        *(rates[1:] if measured else []),
    ]
    states = [("e_integral", "Running integral of the error", f"{unit}.s" if unit != "1" else "s")]
    if not measured:
        states.append(("e_past", "Error of the sample before", unit))
    memory = [
        Variable(own, told, "local", "discrete", "exact", unit=of, macro=f"V_{own.upper()}")
        for own, told, of in states
    ]
    known = [variable.name for variable in (*parameters, *inputs, *memory)]
    return Block(
        name,
        "Sampled PID controller with feedforward of the command's acceleration",
        (
            *parameters,
            sample_time_constant(sampled.dt),
            *inputs,
            output(
                "u",
                "Torque",
                units.effort(unit),
                variability="discrete",
                initial_dependencies=dict.fromkeys(known, "dependent"),
            ),
            *memory,
        ),
        "sampled_controller",
        constants={"SAMPLE_TIME": repr(sampled.dt)} | ({"MEASURED_RATE": "1"} if measured else {}),
        sample_time=sampled.dt,
        stop_time=_TICKS * sampled.dt,
        step=sampled.dt,
        notes=(SAMPLING, HELD),
    )
