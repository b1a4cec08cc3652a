"""A whole servo loop as one block: planned motion, jerk filter, sampled controller, plant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Any

from ...plant.commands import Ramp, Sine, Sum
from ...plant.exact_response import state_space
from ...plant.feedforward import InertiaFeedforward
from ...plant.flexible_inertia import FlexibleInertia
from ...plant.inertia import Inertia
from ...plant.layout import at_rest
from ...plant.linear_system import linear_system
from ...plant.pid import PID
from ...plant.servo_loop import ServoLoop
from ...shaping import JerkFilter, Trajectory
from ...shaping.checks import of_kind, positive
from ...shaping.propagate import check_fed
from ...shaping.trajectory import as_trajectory
from . import units
from .axis_block import linear_units
from .blocks import Block, Variable, output, signal
from .digital_loop import check_digital_loop, digital_loop_block
from .linear_blocks import linear_block
from .loop_blocks import SampledController, controller_block
from .motion_blocks import SAMPLING, jerk_filter_block, trajectory_block
from .units import rate

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class SampledLoop:
    """A servo loop that follows a planned motion, to be exported as one block.

    A PID runs once every dt, as `SampledController` does; the plant goes on exactly between
    samples. A digital controller runs as it is, with filters, delay and limit, on an axis with
    friction and all: what leaves is what `ServoLoop.respond` runs. It starts at rest where the
    trajectory starts.

    Parameters
    ----------
    trajectory : Trajectory
        Of order 2 or more; behind a jerk filter, of any. Of a digital loop, of the order of its
        feedforward.
    loop : ServoLoop
        The plant of a PID is linear, with the outputs y and y_rate.
    dt : float, optional
        Sample time, positive. Default: the digital controller's.
    jerk_filter : JerkFilter, optional
        Between trajectory and the loop of a PID; of order 3 or more.

    Raises
    ------
    TypeError, ValueError
        For a part of another type or of too low an order, or a dt that is not positive.
    """

    trajectory: Trajectory
    loop: ServoLoop
    dt: float | None = None
    jerk_filter: JerkFilter | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "trajectory", planned(self.trajectory))
        of_kind("loop", self.loop, ServoLoop, "a ServoLoop")
        if self.loop.is_digital:
            check_digital_loop(self.trajectory, self.loop, self.dt, self.jerk_filter)
            object.__setattr__(self, "dt", self.loop.controller_noun.sample_time)
            return
        check_bare_pid(self.loop)
        _check_linear(self.loop, float(self.trajectory.start_state[0]))
        if self.dt is None:
            raise ValueError("dt is missing: give the sample time at which the PID runs, dt=1e-3")
        object.__setattr__(self, "dt", positive("dt", self.dt))
        check_commands(self.trajectory, self.jerk_filter)

    @property
    def sample_time(self) -> float:
        """Sample time of what runs."""
        assert self.dt is not None
        return self.dt


def planned(command: Any) -> Trajectory:
    """Return a command that is a planned motion; refuse those that go on for ever."""
    if isinstance(command, Ramp | Sine | Sum):
        raise TypeError(
            f"trajectory = {type(command).__name__}: a command without end cannot leave; export "
            "the controller alone and feed it from outside, or give a planned motion"
        )
    return as_trajectory(command)


def check_bare_pid(loop: ServoLoop) -> None:
    """Refuse a continuous controller that is more than a PID with feedforward of acceleration."""
    controller, axis = loop.controller_noun, loop.axis
    _refuse_any(
        {
            "filters": len(controller.filters) > 0,
            "a cascade": not isinstance(controller.law, PID),
            "a derivative filter": controller.rate_filter > 0.0,
            "anti-windup": controller.anti_windup not in (None, "none"),
            "a torque limit": axis.torque_limit < inf,
            "an encoder's resolution": axis.encoder_step > 0.0,
            "two encoders": axis.sensor == "both",
            "feedforward of more than the acceleration": (
                not isinstance(loop.feedforward, InertiaFeedforward | None)
            ),
        }
    )


def _check_linear(loop: ServoLoop, start: float) -> None:
    """Refuse a continuous loop on an axis that is not linear, or holds a load at its start."""
    _refuse_any(
        {
            "friction": loop.axis.friction is not None,
            "ripple": loop.axis.ripple is not None,
            "a load to hold": at_rest(loop.axis, start)[1] != 0.0,
        }
    )


def _refuse_any(reasons: dict[str, bool]) -> None:
    for what, there in reasons.items():
        if there:
            raise ValueError(
                f"a continuous controller with {what} cannot leave: what runs in a processor is "
                "sampled; give it a sample time, Controller(…, sample_time=1e-3)"
            )


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
    if sampled.loop.is_digital:
        return digital_loop_block(sampled.trajectory, sampled.loop, name, unit)
    loop, dt, behind = sampled.loop, sampled.sample_time, sampled.jerk_filter
    law = loop.controller_noun.law
    assert isinstance(law, PID)  # as it was checked where the loop was put together
    motion = trajectory_block(sampled.trajectory, name, unit)
    control = controller_block(SampledController(law, dt, loop.feedforward), name, unit)
    plant = plant_block(loop, name, unit)
    shaped = [] if behind is None else jerk_filter_block(behind, name, unit).variables[:1]
    start = float(sampled.trajectory.start_state[0])
    states = [own for own in plant.variables if own.name.startswith("state.")]
    states = resting(states, loop, start)
    variables = _variables(control, shaped, plant, states, unit)
    lasting = motion.stop_time - motion.start_time
    lasting += 0.0 if behind is None else behind.settling_time(1e-6)
    lags = 0 if behind is None else behind.order
    return Block(
        name,
        "Servo loop: planned motion, sampled PID controller with feedforward, plant",
        tuple(variables),
        "servo",
        constants={
            **{key: text for key, text in plant.constants.items() if key.startswith("N_")},
            **{key: motion.constants[key] for key in ("ORDER", "N_PIECES")},
            "SAMPLE_TIME": repr(dt),
            "N_LAGS": str(lags),
            **_places(variables, states),
        },
        tables={**motion.tables, **plant.tables},
        memory=1 + max(lags, 1),
        work=plant.work,
        sample_time=dt,
        start_time=motion.start_time,
        stop_time=motion.start_time + max(round(lasting / dt), 1) * dt,
        step=dt,
        notes=(SAMPLING, _TIMING),
    )


_TIMING = (
    "At a sample the controller sees command and plant at that time, without delay; its "
    "torque is held until the next sample, and the plant goes on exactly in between. "
    "Outputs are those at the end of the communication step."
)


def _variables(
    control: Block,
    shaped: Sequence[Variable],
    plant: Block,
    states: Sequence[Variable],
    unit: str,
) -> list[Variable]:
    parameters = [own for own in control.variables if own.variability == "tunable"]
    rates = [own for own in control.variables if own.name == "sample_time"]
    integral = [own for own in control.variables if own.name == "e_integral"]
    exact = [*parameters, *shaped, *states, *integral]
    known = {own.name: "dependent" for own in exact} | {"d": "dependent"}
    return [
        *parameters,
        *shaped,
        *rates,
        signal("d", "Disturbance torque, held during each step", units.effort(unit)),
        *_outputs(plant, unit, known),
        *states,
        *integral,
    ]


def _places(variables: Sequence[Variable], states: Sequence[Variable]) -> dict[str, str]:
    """Return where the states of the plant begin, and its outputs, behind the torque."""
    places = {own.name: k for k, own in enumerate(variables)}
    return {"V_STATE": str(places[states[0].name]), "V_OUTPUT": str(places["u"] + 1)}


def plant_block(loop: ServoLoop, name: str, unit: str) -> Block:
    """Return a plant as a linear block of continuous time, with outputs y and y_rate."""
    system = plant_system(loop)
    labels = [*system.output_labels]
    kinds = {"rate": rate(unit, 1), "u": units.effort(unit)}
    names = [*system.input_labels, *labels, *system.state_labels]
    known = {own: kinds.get(own.rpartition("_")[2], unit) for own in names}
    if not _is_ideal(loop.plant):
        known |= {own: linear_units(loop.axis, unit)[own] for own in names}
    return linear_block(system, name, known)


def plant_system(loop: ServoLoop) -> control.StateSpace:
    """Return the plant of a loop from its torque u; of an axis without what disturbs it."""
    if _is_ideal(loop.plant):
        return state_space(loop.plant.system())
    whole = loop.axis.system()
    return linear_system(
        (whole.A, whole.B[:, :1], whole.C, whole.D[:, :1]),
        0,
        inputs=whole.input_labels[:1],
        outputs=whole.output_labels,
        states=whole.state_labels,
        name="plant",
    )


def _is_ideal(plant: Any) -> bool:
    return isinstance(plant, Inertia | FlexibleInertia)


def resting(states: Sequence[Variable], loop: ServoLoop, start: float) -> list[Variable]:
    """Return variables, those of the plant's states at rest where the trajectory starts."""
    rest = {"state.y": start}
    if not _is_ideal(loop.plant):
        values, _ = at_rest(loop.axis, start)
        rest = {f"state.{own}": x for own, x in zip(loop.axis.dynamics.names, values, strict=True)}
    return [replace(own, start=float(rest.get(own.name, own.start))) for own in states]


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
