"""The block that an object of the library becomes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...plant.axis import Axis
from ...plant.controller import Controller
from ...plant.exact_response import state_space
from ...plant.flexible_inertia import FlexibleInertia
from ...plant.inertia import Inertia
from ...shaping import CommandFollower, JerkFilter, Trajectory
from ...shaping.trajectory import Planned
from .axis_block import axis_block
from .blocks import Block
from .digital_block import digital_block
from .digital_controller import DigitalController
from .linear_blocks import linear_block
from .loop_blocks import SampledController, controller_block, inertia_block
from .motion_blocks import follower_block, jerk_filter_block, trajectory_block
from .sampled_shaper import SampledShaper, shaper_block
from .servo_block import SampledLoop, servo_block
from .units import effort, position_unit, rate

Unit = str | Mapping[str, str]


def _flexible_block(plant: FlexibleInertia, name: str, unit: str) -> Block:
    positions = ("y", "y_load", "twist")
    units = dict.fromkeys(positions, unit) | dict.fromkeys(("y_rate", "twist_rate"), rate(unit, 1))
    return linear_block(plant.system(), name, units | {"u": effort(unit)})


def _bare_block(controller: Controller, name: str, unit: str) -> Block:
    return digital_block(DigitalController(controller), name, unit)


_KINDS: tuple[tuple[type, str, Any], ...] = (
    (Trajectory, "trajectory", trajectory_block),
    (CommandFollower, "command_follower", follower_block),
    (JerkFilter, "jerk_filter", jerk_filter_block),
    (SampledShaper, "input_shaper", shaper_block),
    (Inertia, "inertia", inertia_block),
    (FlexibleInertia, "flexible_inertia", _flexible_block),
    (Axis, "axis", axis_block),
    (SampledController, "controller", controller_block),
    (DigitalController, "controller", digital_block),
    (Controller, "controller", _bare_block),
    (SampledLoop, "servo_loop", servo_block),
)


def block_of(source: Any, *, name: str | None = None, unit: Unit = "1") -> Block:
    """Return what an object is to the outside.

    Parameters
    ----------
    source : Trajectory, CommandFollower, JerkFilter, SampledShaper, Inertia, FlexibleInertia, \
Axis, SampledController, DigitalController, Controller, SampledLoop, StateSpace or TransferFunction
    name : str, optional
        A C identifier. Default: after the kind of object, or a linear system's own name.
    unit : str or mapping, optional
        Unit of position, from which the others follow; of a python-control system a mapping from
        the names of its signals and states to units. Default: none.

    Returns
    -------
    Block

    Raises
    ------
    TypeError
        For an object of another kind.
    ValueError
        For a name that is no C identifier, a unit that is not known, or a block that cannot be
        exported.

    Examples
    --------
    >>> from jounce.plant import Inertia
    >>> [variable.unit for variable in block_of(Inertia(2.0), unit="rad").variables]
    ['kg.m2', 'N.m', 'rad', 'rad/s', 'rad/s', 'rad/s2']
    """
    if isinstance(source, Block):
        return source if name is None else replace(source, name=name)
    source = source.trajectory if isinstance(source, Planned) else source
    for kind, own_name, make in _KINDS:
        if isinstance(source, kind):
            if not isinstance(unit, str):
                raise TypeError(f"unit = {unit!r}: expected the unit of position, such as 'rad'")
            block: Block = make(source, own_name if name is None else name, position_unit(unit))
            return block
    return _linear(source, name, unit)


def _linear(source: Any, name: str | None, unit: Unit) -> Block:
    try:
        system = state_space(source)
    except TypeError:
        kinds = ", ".join(kind.__name__ for kind, _, _ in _KINDS)
        raise TypeError(
            f"got {type(source).__name__}: expected one of {kinds} (a PID with its sample time), "
            "or a python-control StateSpace or TransferFunction"
        ) from None
    if unit == "1":
        unit = {}
    if isinstance(unit, str):
        raise TypeError(
            f"unit = {unit!r}: of a python-control system, expected a mapping from the names of "
            "its signals to their units"
        )
    return linear_block(system, _identifier(source.name) if name is None else name, unit)


def _identifier(name: str) -> str:
    """Return a C identifier like a system's name; not python-control's own, which are counted."""
    if not name or name.startswith("sys["):
        return "linear_system"
    return re.sub(r"\W", "_", name, flags=re.ASCII)[:60].lstrip("0123456789") or "linear_system"
