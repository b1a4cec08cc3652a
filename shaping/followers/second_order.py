"""Following with bounded acceleration: each sample is the start of a minimum-time motion.

Seen from the command, which moves at its own constant velocity u, the motion is one from (e, w)
to rest at zero with velocity bounds shifted by u (Thompson, Section II): accelerate, cruise at the
bound, decelerate so that e = ∓w²/(2·a) to the last. One loop of scalars, in which each of the two
directions is written out: a call or a sign would cost more than the mathematics.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise, repeat
from math import inf, remainder, sqrt
from typing import NamedTuple

import numpy as np

from ..pieces import FloatArray
from ..transfers.task import Task
from .approach import along, approach, courses

_RESOLUTION = 2.0**-50  # of a command's position: what is nearer is there
_ROUNDED_UP = 1.0 + 2.0**-50
_LONG = 64  # samples on one course that are cheaper as one motion


class Bounds(NamedTuple):
    """Bounds on velocity, and the magnitudes of those on acceleration."""

    v_min: float
    v_max: float
    up: float
    down: float


def follow(
    start: tuple[float, float],
    commands: FloatArray,
    velocities: FloatArray,
    bounds: Bounds,
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
    bounds : Bounds
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
    long = np.flatnonzero(np.diff(edges) >= _LONG)
    parts = np.unique(np.concatenate([[0], edges[long], edges[long + 1], [len(commands)]]))
    for i, j in pairwise(parts.tolist()):
        some, held = slice(i, j), i in edges[long]
        part = _held if held else _changing
        rows[:, some] = part(start, commands[some], velocities[some], bounds, dt, period)
        start = float(rows[0, j - 1]), float(rows[1, j - 1])
    for bound in (bounds.v_min, bounds.v_max):
        speeds = rows[1] / bound
        rows[1, (speeds > 1.0) & (speeds <= _ROUNDED_UP)] = bound
    return rows


def _held(
    start: tuple[float, float],
    commands: FloatArray,
    velocities: FloatArray,
    bounds: Bounds,
    dt: float,
    period: float | None,
) -> FloatArray:
    """Return the motion towards commands that stay on one course."""
    (x, v), r, u = start, float(commands[0]), float(velocities[0])
    if period is not None:
        r = x - remainder(x - r, period)
    v_min, v_max, up, down = bounds
    task = Task(0.0, 0.0, 0.0, 0.0, 0.0, v_min, v_max, -down, up, inf, inf)
    rows = along(approach((x - r, v - u, 0.0), r, u, task), dt, len(commands))
    rows[0] += (r - commands[0]) + commands + u * dt
    rows[1] += u
    return rows


def _changing(
    start: tuple[float, float],
    commands: FloatArray,
    velocities: FloatArray,
    bounds: Bounds,
    dt: float,
    period: float | None,
) -> FloatArray:
    """Return the motion towards commands that may leave their course at every sample."""
    (x, v), ends = start, commands + velocities * dt
    jumps = np.concatenate([[x], ends[:-1]]) - commands  # of e, as the command changes
    slacks = (_RESOLUTION * np.abs(commands)).tolist()
    if velocities.any():
        changes = (np.concatenate([[v], velocities[:-1]]) - velocities).tolist()
        tops = (bounds.v_max - velocities).tolist()
        bottoms = (bounds.v_min - velocities).tolist()
    else:
        changes = [v, *repeat(0.0, len(commands) - 1)]
        tops, bottoms = repeat(bounds.v_max), repeat(bounds.v_min)
    samples = zip(jumps.tolist(), changes, slacks, tops, bottoms, strict=False)
    *motion, turns = _follow(samples, bounds.up, bounds.down, dt, period)
    rows = np.array(motion)
    rows[0] += ends if period is None else ends + turns
    rows[1] += velocities
    return rows


def sample(
    start: tuple[float, float],
    command: float,
    velocity: float,
    bounds: Bounds,
    dt: float,
    period: float | None = None,
) -> tuple[float, float, float]:
    """Return position, velocity and acceleration after a single sample, as `follow`."""
    (x, v), (v_min, v_max, up, down) = start, bounds
    one = (
        x - command,
        v - velocity,
        _RESOLUTION * abs(command),
        v_max - velocity,
        v_min - velocity,
    )
    [e], [w], [a], turns = _follow([one], up, down, dt, period)
    x, v = command + velocity * dt + e + sum(turns), velocity + w
    for bound in (v_min, v_max):
        if 1.0 < v / bound <= _ROUNDED_UP:
            v = bound
    return x, v, a


Lists = tuple[list[float], list[float], list[float], list[float]]


def _follow(
    samples: Iterable[tuple[float, float, float, float, float]],
    up: float,
    down: float,
    dt: float,
    period: float | None,
) -> Lists:
    """Return e, w and the acceleration after each sample, and with a period the whole ones in it.

    A sample is what e and w jump by when it begins, how near to zero e counts as zero, and the
    bounds on w.
    """
    half_up, half_down, lift = 0.5 / up, 0.5 / down, 2.0 * up * down / (up + down)
    gain_up, gain_down, half_dt = up * dt, down * dt, 0.5 * dt
    out: Lists = [], [], [], []
    add_e, add_w, add_a, add_turns = (column.append for column in out)
    e = w = turns = 0.0
    for jump, change, slack, top, bottom in samples:
        e += jump
        w += change
        if period is not None:
            turns += e
            e = remainder(e, period)
            turns -= e
            add_turns(turns)
        square = w * w
        beyond = e + square * half_down if w > 0.0 else e - square * half_up  # where it would stop
        if beyond < -slack or (w > 0.0 and beyond <= slack):
            # the peak velocity: peak² = w² + rise while it moves ahead, else rise
            rise = -beyond * lift if beyond < -slack else 0.0
            if w > 0.0:
                rise += square
            later = w + gain_up
            if later <= top and (later <= 0.0 or later * later <= rise):
                e += (w + later) * half_dt
                w = later
                a = up
            elif w == top and e + w * (dt + w * half_down) <= 0.0:
                e += w * dt
                a = 0.0
            elif (peak := sqrt(rise)) < top:
                w = peak - down * (dt - (peak - w) / up)
                e, w, a = (-w * w * half_down, w, -down) if w > 0.0 else (0.0, 0.0, 0.0)
            else:
                e, w, a = _by_the_bound(e, w, top, up, down, dt)
        elif beyond > slack or w < 0.0:
            rise = beyond * lift if beyond > slack else 0.0
            if w < 0.0:
                rise += square
            later = w - gain_down
            if later >= bottom and (later >= 0.0 or later * later <= rise):
                e += (w + later) * half_dt
                w = later
                a = -down
            elif w == bottom and e + w * (dt - w * half_up) >= 0.0:
                e += w * dt
                a = 0.0
            elif (peak := sqrt(rise)) < -bottom:
                w = up * (dt - (peak + w) / down) - peak
                e, w, a = (w * w * half_up, w, up) if w < 0.0 else (0.0, 0.0, 0.0)
            else:
                e, w, a = (-value for value in _by_the_bound(-e, -w, -bottom, down, up, dt))
        else:
            e = w = a = 0.0
        add_e(e)
        add_w(w)
        add_a(a)
    return out


def _by_the_bound(
    e: float, w: float, top: float, speed_up: float, slow_down: float, left: float
) -> tuple[float, float, float]:
    """Return (e, w) and the acceleration after a time `left` of going to the velocity bound.

    From either side of it; then it cruises, slows down and stops at e = 0.
    """
    if w != top:
        change = speed_up if w < top else -slow_down
        t = (top - w) / change
        if t >= left:
            return e + (w + 0.5 * change * left) * left, w + change * left, change
        e, left = e + 0.5 * (w + top) * t, left - t
    stop = -0.5 * top * top / slow_down
    if e + top * left <= stop:
        return e + top * left, top, 0.0
    w = top - slow_down * (left - (stop - e) / top) if top > 0.0 else 0.0
    return (-0.5 * w * w / slow_down, w, -slow_down) if w > 0.0 else (0.0, 0.0, 0.0)
