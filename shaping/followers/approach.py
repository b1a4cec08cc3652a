"""The fastest motion towards a moving command, as seen from the command, while it keeps on."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from math import inf, remainder, sqrt

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray, evaluate
from ..transfers.brake import brake
from ..transfers.planner import fastest
from ..transfers.task import ROUNDING, Piece, Task, in_own_units, taylor
from ..transfers.velocity_change import change_velocity

_NOTHING = 2.0**-100


def approach(
    relative: Sequence[float], position: float, velocity: float, bounds: Task, dt: float
) -> list[Piece]:
    """Return the pieces of the fastest motion to rest at the command, and of rest there.

    Parameters
    ----------
    relative : (position, velocity, acceleration)
        As seen from the command. What is less than 2⁻¹⁰⁰ of a sample's worth counts as zero.
    position : float
        Where it is itself; its rounding is not to be corrected.
    velocity : float
        Of the command, within the bounds.
    bounds : Task
        Of which only the bounds are used.
    dt : float
        Length of a sample.

    Returns
    -------
    list
        Positions and velocities relative to the command. The last piece goes on for ever. It is
        not at the command where that moves as fast as the bounds allow and is not caught up.
    """
    if bounds.rise < inf:
        least = min(bounds.rise, bounds.fall) * dt * _NOTHING
        e, w, a = (
            value if abs(value) > least * dt**k else 0.0
            for k, value in zip((2, 1, 0), relative, strict=True)
        )
    else:
        e, w, a = *relative[:2], 0.0
    task = bounds._replace(
        distance=-e,
        v0=w,
        a0=a,
        v_min=bounds.v_min - velocity,
        v_max=bounds.v_max - velocity,
        resolution=2.0**-52 * (abs(e) + abs(position)),
    )
    scaled, time, length = in_own_units(task)
    braking, left, position = brake(scaled, e / length)
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


def follow_course(
    state: Sequence[float],
    commands: FloatArray,
    velocity: float,
    bounds: Task,
    dt: float,
    period: float | None,
) -> FloatArray:
    """Return the motion (order + 1, N) towards commands that stay on one course.

    With a period the way round is chosen anew where the command comes to lie behind.
    """
    rows = np.empty((3 if bounds.rise == inf else 4, len(commands)))
    done, state = 0, tuple(state)
    while done < len(commands):
        (x, v, a), r = state[:3], float(commands[done])
        off = x - r if period is None else remainder(x - r, period)
        e = _nearer(off, v - velocity, a, bounds, dt * (len(commands) - done))
        plan = approach((e, v - velocity, a), x, velocity, bounds, dt)
        part = along(plan, dt, len(commands) - done)
        if period is not None:
            turned = np.flatnonzero(np.abs(part[0]) > 0.5 * period)
            part = part[:, : turned[0] + 1] if turned.size else part
        some = slice(done, done + part.shape[1])
        if period is None and e == off:
            part[0] += commands[some]
        else:  # as if the command were whole periods away, or no farther than matters
            part[0] += (x - e) + (commands[some] - r)
        part[0] += velocity * dt
        part[1] += velocity
        rows[:, some] = part
        done, state = some.stop, tuple(part[:, -1].tolist())
    return rows


def _nearer(e: float, w: float, a: float, bounds: Task, time: float) -> float:
    """Return a position as seen from a command that is no farther than matters within a time.

    From a command beyond some times the distance in which one could stop in the end, the motion
    until then is the same; and the position keeps its digits beside a command of 1e300.
    """
    power, gentle = (pick(bounds.a_max, -bounds.a_min) for pick in (max, min))
    speed, turn = abs(w) + power * time, 0.0
    if bounds.rise < inf:
        jerk = min(bounds.rise, bounds.fall)
        push = min(abs(a) + max(bounds.rise, bounds.fall) * time, max(abs(a), power))
        speed = abs(w) + push * (time + 0.5 * push / jerk)
        turn = push / jerk + 2.0 * sqrt(speed / jerk)
    far = 4.0 * speed * (time + turn + speed / gentle)
    return min(max(e, -far), far)


def courses(commands: FloatArray, velocities: FloatArray, dt: float) -> NDArray[np.intp]:
    """Return the samples at which the command leaves its course, 0 and N included."""
    if not len(commands):
        return np.zeros(1, dtype=np.intp)
    expected = commands[:-1] + velocities[:-1] * dt
    leaves = np.abs(commands[1:] - expected) > ROUNDING * np.abs(commands[1:])
    leaves |= velocities[1:] != velocities[:-1]
    return np.concatenate([[0], 1 + np.flatnonzero(leaves), [len(commands)]])
