"""Following with bounded acceleration: each sample is the start of a minimum-time motion.

Seen from the command, which moves at its own constant velocity u, the motion is one from (e, w)
to rest at zero with velocity bounds shifted by u (Thompson, Section II): accelerate, cruise at the
bound, decelerate so that e = ∓w²/(2·a) to the last. One loop of scalars, in which each of the two
directions is written out: a call or a sign would cost more than the mathematics.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise, repeat
from math import remainder, sqrt

import numpy as np

from ..pieces import FloatArray
from ..transfers import batch_tasks
from ..transfers.brake import inside
from ..transfers.task import Task
from .approach import courses, follow_course

_RESOLUTION = 2.0**-50  # of a command's position: what is nearer is there
_LONG = 64  # samples on one course that are cheaper as one motion


def follow(
    start: tuple[float, float],
    commands: FloatArray,
    velocities: FloatArray,
    bounds: Task,
    dt: float,
    period: float | None = None,
) -> FloatArray:
    """Return position, velocity and acceleration (3, N) at the end of each sample.

    Parameters
    ----------
    start : (position, velocity)
        When the first sample begins.
    commands, velocities : (N,) arrays
        Position of the command when each sample begins, and its velocity during the sample,
        within the bounds.
    bounds : Task
        Of which only the bounds on velocity and acceleration are used.
    dt : float
        Length of a sample.
    period : float, optional
        Distance after which positions repeat: the command is followed the shortest way.

    Returns
    -------
    (3, N) array
        Accelerations are those in force when the sample ends.
    """
    rows = np.empty((3, len(commands)))
    edges = courses(commands, velocities, dt)
    long = edges[:-1][np.diff(edges) >= _LONG]
    parts = np.unique([0, *long, *edges[1:][np.diff(edges) >= _LONG], len(commands)])
    for i, j in pairwise(parts.tolist()):
        some = slice(i, j)
        if i in long:
            state, velocity = (*start, 0.0), float(velocities[i])
            rows[:, some] = follow_course(state, commands[some], velocity, bounds, dt, period)
        else:
            each = _samples(commands[some], velocities[some])
            rows[:, some] = _follow(start, each, bounds, dt, period)
        start = float(rows[0, j - 1]), float(rows[1, j - 1])
    rows[1] = batch_tasks.inside(rows[1], bounds.v_min, bounds.v_max)
    return rows


def _samples(commands: FloatArray, velocities: FloatArray) -> Iterator[tuple[float, float, float]]:
    """Return command, velocity, and how near to the command counts as there, of each sample."""
    slacks = (_RESOLUTION * np.abs(commands)).tolist()
    moving = velocities.tolist() if velocities.any() else repeat(0.0)
    return zip(commands.tolist(), moving, slacks, strict=False)


def sample(
    start: tuple[float, float],
    command: float,
    velocity: float,
    bounds: Task,
    dt: float,
    period: float | None = None,
) -> tuple[float, float, float]:
    """Return position, velocity and acceleration after a single sample, as `follow`."""
    one = command, velocity, _RESOLUTION * abs(command)
    [x], [v], [a] = _follow(start, [one], bounds, dt, period)
    return x, inside(v, bounds.v_min, bounds.v_max), a


Lists = tuple[list[float], list[float], list[float]]


def _follow(
    start: tuple[float, float],
    samples: Iterable[tuple[float, float, float]],
    bounds: Task,
    dt: float,
    period: float | None,
) -> Lists:
    """Return position, velocity and acceleration after each sample.

    A sample is a command, its velocity, and how near to the command counts as there.
    """
    v_min, v_max, up, down = bounds.v_min, bounds.v_max, bounds.a_max, -bounds.a_min
    half_up, half_down, lift = 0.5 / up, 0.5 / down, 2.0 * up * down / (up + down)
    gain_up, gain_down, half_dt = up * dt, down * dt, 0.5 * dt
    out: Lists = [], [], []
    add_x, add_v, add_a = (column.append for column in out)
    x, v = start
    for r, u, slack in samples:
        if period is not None:
            r = x - remainder(x - r, period)
        e, w = x - r, v - u
        square = w * w
        beyond = e + square * half_down if w > 0.0 else e - square * half_up  # where it would stop
        if beyond < -slack or (w > 0.0 and beyond <= slack):
            # the peak velocity: peak² = w² + rise while it moves ahead, else rise
            rise = -beyond * lift if beyond < -slack else 0.0
            if w > 0.0:
                rise += square
            later = w + gain_up
            if later + u <= v_max and (later <= 0.0 or later * later <= rise):
                x += (w + later) * half_dt + u * dt
                v = later + u
                a = up
            elif v == v_max and e + w * (dt + w * half_down) <= 0.0:
                x += v * dt
                a = 0.0
            elif (peak := sqrt(rise)) < v_max - u:
                w = peak - down * (dt - (peak - w) / up)
                e, w, a = (-w * w * half_down, w, -down) if w > 0.0 else (0.0, 0.0, 0.0)
                x, v = r + u * dt + e, u + w
            else:
                step, w, a = _by_the_bound(e, w, v_max - u, up, down, dt)
                x, v = x + step + u * dt, u + w
        elif beyond > slack or w < 0.0:
            rise = beyond * lift if beyond > slack else 0.0
            if w < 0.0:
                rise += square
            later = w - gain_down
            if later + u >= v_min and (later >= 0.0 or later * later <= rise):
                x += (w + later) * half_dt + u * dt
                v = later + u
                a = -down
            elif v == v_min and e + w * (dt - w * half_up) >= 0.0:
                x += v * dt
                a = 0.0
            elif (peak := sqrt(rise)) < u - v_min:
                w = up * (dt - (peak + w) / down) - peak
                e, w, a = (w * w * half_up, w, up) if w < 0.0 else (0.0, 0.0, 0.0)
                x, v = r + u * dt + e, u + w
            else:
                step, w, a = _by_the_bound(-e, -w, u - v_min, down, up, dt)
                x, v, a = x - step + u * dt, u - w, -a
        else:
            x, v, a = r + u * dt, u, 0.0
        add_x(x)
        add_v(v)
        add_a(a)
    return out


def _by_the_bound(
    e: float, w: float, top: float, speed_up: float, slow_down: float, left: float
) -> tuple[float, float, float]:
    """Return what e changes by, w and the acceleration after a time `left` of going to the bound.

    From either side of it; then it cruises, slows down and stops at e = 0.
    """
    gone = 0.0
    if w != top:
        change = speed_up if w < top else -slow_down
        t = (top - w) / change
        if t >= left:
            return (w + 0.5 * change * left) * left, w + change * left, change
        gone, left = 0.5 * (w + top) * t, left - t
    stop = -0.5 * top * top / slow_down
    if e + gone + top * left <= stop:
        return gone + top * left, top, 0.0
    w = top - slow_down * (left - (stop - e - gone) / top) if top > 0.0 else 0.0
    return (-0.5 * w * w / slow_down - e, w, -slow_down) if w > 0.0 else (-e, 0.0, 0.0)
