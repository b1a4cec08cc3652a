"""The plant of a scenario: an inertia, or an axis with all that the file says of it."""

from __future__ import annotations

from math import inf, pi
from typing import Any

from ..plant import Axis, FlexibleMode, Friction, Inertia, Ripple, chain_axis, system_axis
from .scenario import Scenario
from .scenario_sections import ModeSection, PlantSection, RippleSection


def plant_of(scenario: Scenario) -> Inertia | Axis:
    """Return the plant; an inertia where there is nothing else to it.

    Raises
    ------
    ValueError
        For modes that do not fit together, or an axis that cannot hold its load.
    """
    counts = scenario.plant.encoder_counts
    if counts is not None and scenario.motion == "length":
        raise ValueError(
            f"{scenario.path}: plant.encoder_counts: {counts} a revolution, and a linear axis has "
            'none; write encoder_step = "10 nm"'
        )
    try:
        axis = _axis(scenario.inertia, scenario.plant)
    except ValueError as error:
        told = str(error).replace("torque_limit", _limit_name(scenario.plant))
        raise ValueError(f"{scenario.path}: plant: {told}") from None
    return Inertia(axis.J) if scenario.plant == PlantSection() else axis


def _axis(inertia: float, plant: PlantSection) -> Axis:
    common = _drive(plant)
    within: dict[str, Any] = {
        name: getattr(plant, name) for name in ("viscous", "load_viscous", "spring")
    }
    if plant.transfer is not None:
        given = [name for name, value in within.items() if value]
        if given:
            raise ValueError(f"has {', '.join(given)} beside a transfer, which has its own")
        return system_axis(plant.transfer.system(), **common)
    if plant.chain is not None:
        chain = plant.chain
        return chain_axis(chain.masses, chain.springs, chain.dampers, **common, **within)
    return Axis(inertia, modes=tuple(map(_mode, plant.modes)), **common, **within)


def _mode(mode: ModeSection) -> FlexibleMode:
    return FlexibleMode(
        mode.frequency,
        mode.damping,
        load_fraction=mode.load_fraction,
        motor_shape=mode.motor_shape,
        load_shape=mode.load_shape,
        held=mode.held,
    )


def _drive(plant: PlantSection) -> dict[str, Any]:
    """Return drive, friction and sensors."""
    friction = plant.friction
    return {
        "friction": None if friction is None else Friction(friction.coulomb, friction.static),
        "ripple": None if plant.ripple is None else _ripple(plant.ripple),
        "torque_limit": _limit(plant),
        "constant_load": plant.constant_load,
        "torque_constant": plant.torque_constant,
        "gear_ratio": plant.gear_ratio,
        "current_lag": plant.current_lag,
        "encoder_step": _step(plant),
        "sensor": plant.sensor,
    }


def _ripple(ripple: RippleSection) -> Ripple:
    if ripple.amplitude is not None:
        return Ripple.sine(ripple.amplitude, ripple.period)
    return Ripple(ripple.positions or (), ripple.torques or (), ripple.period)


def _step(plant: PlantSection) -> float:
    """Return the encoder's resolution, of counts per revolution in rad."""
    return plant.encoder_step if plant.encoder_counts is None else 2.0 * pi / plant.encoder_counts


def _limit_name(plant: PlantSection) -> str:
    """Return the key that limits the torque, of a current with what it is told in."""
    if plant.current_limit is not None:
        return "current_limit, seen at the axis a torque,"
    return "torque_limit" if plant.force_limit is None else "force_limit"


def _limit(plant: PlantSection) -> float:
    """Return the limit of the torque, or the force, at the axis."""
    if plant.current_limit is not None and plant.torque_constant is not None:
        return plant.current_limit * plant.torque_constant * plant.gear_ratio
    return plant.torque_limit or plant.force_limit or inf
