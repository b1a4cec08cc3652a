"""A trajectory with what the exact inverse of a damped axis remembers of it, as a block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...plant.inverse_dynamics import InverseDynamics
from ...shaping import Trajectory
from .blocks import Block, output
from .linear_blocks import table_rows
from .motion_blocks import trajectory_block
from .units import effort


def inverse_trajectory_block(
    trajectory: Trajectory, dynamics: InverseDynamics, name: str, unit: str
) -> Block:
    """Return a trajectory with what the exact inverse of a damped axis remembers of it."""
    block = trajectory_block(trajectory, name, unit)
    on, at_first = {"time": "dependent"}, {"delay": "dependent"}
    added = [
        output(*own, dependencies=on, initial_dependencies=at_first) for own in remembered_of(unit)
    ]
    return replace(
        block,
        description="Trajectory, and what the exact inverse of a damped axis remembers of it",
        variables=(*block.variables, *added),
        core="inverse_trajectory",
        constants={**block.constants, **inverse_constants(dynamics, trajectory)},
        tables={**block.tables, **inverse_tables(dynamics, trajectory)},
    )


def remembered_of(unit: str) -> list[tuple[str, str, str]]:
    """Return name, description and unit of what such an inverse adds to torque and reference."""
    return [
        ("inverse_torque", "Torque that the exact inverse remembers", effort(unit)),
        ("inverse_position", "What it adds to the command that the motor follows", unit),
    ]


def inverse_constants(dynamics: InverseDynamics, trajectory: Trajectory) -> dict[str, str]:
    """Return the macros of inverse.c."""
    fed = trajectory.order - dynamics.derivative + 1
    return {"N_INVERSE": str(dynamics.size), "N_INVERSE_FED": str(fed)}


def inverse_tables(dynamics: InverseDynamics, trajectory: Trajectory) -> dict[str, list[object]]:
    """Return the arrays of inverse.c."""
    rates, _, shown, through = dynamics.matrices()
    settled, decaying = dynamics.behind(trajectory)
    return {
        "inverse_rates": table_rows(rates),
        "inverse_scale": table_rows(np.ones(dynamics.size)),
        "inverse_settled": table_rows(settled),
        "inverse_decaying": table_rows(decaying),
        "inverse_shown": table_rows(shown),
        "inverse_through": table_rows(through),
    }
