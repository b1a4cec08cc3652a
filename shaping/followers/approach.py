"""The fastest motion towards a moving command, as seen from the command, while it keeps on."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from math import inf

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray, evaluate
from ..transfers.brake import brake
from ..transfers.planner import fastest
from ..transfers.task import ROUNDING, Piece, Task, own_units, taylor
from ..transfers.velocity_change import change_velocity


def approach(
    relative: Sequence[float], command: float, velocity: float, bounds: Task
) -> list[Piece]:
    """Return the pieces of the fastest motion to rest at the command, and of rest there.

    Parameters
    ----------
    relative : (position, velocity, acceleration)
        As seen from the command.
    command, velocity : float
        The command, moving within the bounds.
    bounds : Task
        Of which only the bounds are used.

    Returns
    -------
    list
        Positions and velocities relative to the command. The last piece goes on for ever. It is
        not at the command where that moves as fast as the bounds allow and is not caught up.
    """
    e, w, a = relative
    task = bounds._replace(
        distance=-e,
        v0=w,
        a0=a if bounds.rise < inf else 0.0,
        v_min=bounds.v_min - velocity,
        v_max=bounds.v_max - velocity,
        resolution=2.0**-52 * (abs(e) + abs(command)),
    )
    time, length = own_units(task)
    braking, left, position = brake(task.in_units(time, length), e / length)
    plan, end = fastest(left, position, 0.0), 0.0
    if plan is None:
        change = change_velocity(left)
        plan, end = change.pieces(position), position + change.distance
    pieces = [
        (duration * time, tuple(value * length / time**k for k, value in enumerate(row)))
        for duration, row in [*braking, *plan]
        if duration > 0.0
    ]
    resting = (end * length, 0.0, 0.0, 0.0)
    return [*pieces, (inf, resting if bounds.rise < inf else resting[:3])]


def along(pieces: list[Piece], dt: float, count: int) -> FloatArray:
    """Return the states (order + 1, count) at dt, 2·dt, … of a motion that begins with pieces.

    The highest derivative is the one in force just before.
    """
    if count == 1:
        left, piece = dt, 0
        while left > pieces[piece][0]:
            left -= pieces[piece][0]
            piece += 1
        return np.array(taylor(pieces[piece][1], left))[:, None]
    time = dt * np.arange(1.0, count + 1.0)
    ends = np.array(list(accumulate(duration for duration, _ in pieces)))
    which = np.searchsorted(ends, time)
    begun = np.concatenate([[0.0], ends])[which]
    rows = np.array([row for _, row in pieces]).T
    return evaluate(rows[:, which], time - begun, range(len(rows)))


def courses(commands: FloatArray, velocities: FloatArray, dt: float) -> NDArray[np.intp]:
    """Return the samples at which the command leaves its course, 0 and N included."""
    expected = commands[:-1] + velocities[:-1] * dt
    leaves = np.abs(commands[1:] - expected) > ROUNDING * np.abs(commands[1:])
    leaves |= velocities[1:] != velocities[:-1]
    return np.concatenate([[0], 1 + np.flatnonzero(leaves), [len(commands)]])
