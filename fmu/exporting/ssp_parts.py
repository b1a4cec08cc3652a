"""The components of a servo loop in an SSP, and how they are connected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...plant.inertia import Inertia
from ...plant.pid import PID
from ...plant.servo_loop import ServoLoop
from .axis_block import rest_at
from .blocks import Block, Variable
from .delayed_axis import delayed_axis_block
from .digital_block import command_name
from .digital_controller import DigitalController
from .dispatch import block_of
from .inverse_block import inverse_trajectory_block
from .loop_blocks import SampledController
from .servo_block import SampledLoop, plant_block, resting

_MOTION = {"position": "r", "velocity": "r_rate", "acceleration": "r_acceleration"}
_FED = {"position": "", "velocity": "_velocity", "acceleration": "_acceleration"}
_SETTLED = 1e-6

Parts = tuple[dict[str, Any], list[tuple[str, str]]]
"""Components by name, and connections."""


def parts_of(sampled: SampledLoop, unit: str) -> Parts:
    """Return the components of a loop on its way along a trajectory, and their connections."""
    return (_digital_parts if sampled.loop.is_digital else _pid_parts)(sampled, unit)


def lasting_of(sampled: SampledLoop) -> float:
    """Return how long the motion lasts, what the filter does to it included."""
    behind = sampled.jerk_filter
    return sampled.trajectory.duration + (0.0 if behind is None else behind.settling_time(_SETTLED))


def _pid_parts(sampled: SampledLoop, unit: str) -> Parts:
    """Return a PID that runs once every dt, its linear plant, and what commands it."""
    trajectory, loop, behind = sampled.trajectory, sampled.loop, sampled.jerk_filter
    law, position = loop.controller_noun.law, float(trajectory.start_state[0])
    assert isinstance(law, PID)
    blocks: dict[str, Any] = {
        "controller": SampledController(law, sampled.sample_time, loop.feedforward),
        "plant": _plant(loop, unit, position),
    }
    connections = [
        ("controller.u", "plant.u"),
        ("plant.y", "controller.y"),
        ("plant.y_rate", "controller.y_rate"),
    ]
    source = "shaper"
    if behind is not None:
        source, start = "filter", {"start_position": position}
        start["start_velocity"] = trajectory.start_state[1] if trajectory.order > 1 else 0.0
        blocks["filter"] = _started(block_of(behind, name="filter", unit=unit), start)
        given = list(_FED)[: trajectory.order + 1]
        connections += [(f"shaper.{own}", f"filter.command{_FED[own]}") for own in given]
    connections += [(f"{source}.{own}", f"controller.{to}") for own, to in _MOTION.items()]
    return blocks | {"shaper": trajectory}, connections


def _digital_parts(sampled: SampledLoop, unit: str) -> Parts:
    """Return a digital controller, its axis, and what commands it."""
    trajectory = sampled.trajectory
    digital = DigitalController.of(sampled.loop, trajectory)
    dynamics = digital.feedforward.dynamics
    shaper = (
        block_of(trajectory, name="shaper", unit=unit)
        if dynamics is None
        else inverse_trajectory_block(trajectory, dynamics, "shaper", unit)
    )
    plant = _axis(sampled.loop, unit, float(trajectory.start_state[0]))
    blocks: dict[str, Any] = {"controller": digital, "plant": plant, "shaper": shaper}
    connections = [("controller.u", "plant.u"), ("plant.y", "controller.y")]
    connections += [("plant.y_motor", "controller.y_motor")] * digital.two_encoders
    moving = [(own.name, command_name(k)) for k, own in enumerate(shaper.outputs)]
    moving = moving[: digital.order + 1]
    if dynamics is not None:
        moving += [(own.name, own.name) for own in shaper.outputs[-2:]]
    connections += [(f"shaper.{own}", f"controller.{to}") for own, to in moving]
    if digital.feedforward.lead:
        blocks["ahead"] = _started(
            replace(shaper, name="ahead"), {"delay": -digital.feedforward.lead}
        )
        connections += [(f"ahead.{own}", f"controller.{to}_ahead") for own, to in moving]
    return blocks, connections


def _axis(loop: ServoLoop, unit: str, start: float) -> Block:
    """Return the axis of a digital loop, with the computing delay if there is one, at rest."""
    axis, controller = loop.axis, loop.controller_noun
    if controller.delay:
        return delayed_axis_block(axis, controller, "plant", unit, position=start)
    return rest_at(block_of(axis, name="plant", unit=unit), axis, start)


def _plant(loop: ServoLoop, unit: str, start: float) -> Block:
    """Return a plant as a block that rests at `start`."""
    if isinstance(loop.plant, Inertia):
        return _started(block_of(loop.plant, name="plant", unit=unit), {"y": start})
    plant = plant_block(loop, "plant", unit)
    return replace(plant, variables=tuple(resting(plant.variables, loop, start)))


def _started(block: Block, start: Mapping[str, float]) -> Block:
    """Return a block with other start values."""

    def moved(variable: Variable) -> Variable:
        own = start.get(variable.name)
        return variable if own is None else replace(variable, start=float(own))

    return replace(block, variables=tuple(map(moved, block.variables)))
