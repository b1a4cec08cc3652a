"""Scans: lines at constant velocity, back and forth, with turns of least time between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .checks import finite, positive, whole
from .limits import Limits, check_plain, of_one
from .moves import min_time_move
from .pieces import FloatArray, advance
from .trajectory import Planned, Trajectory, as_trajectory

_BEYOND = 1.0 + 1e-12  # times a bound: more than rounding


@dataclass(frozen=True, eq=False, repr=False)
class Scan(Planned):
    """A scan, which answers what its trajectory does.

    Attributes
    ----------
    trajectory : Trajectory
        From rest to rest.
    lines : (N, 2) array
        Times between which each line is run at constant velocity.
    """

    trajectory: Trajectory
    lines: FloatArray

    def __post_init__(self) -> None:
        lines = np.array(self.lines, dtype=float)
        lines.flags.writeable = False
        object.__setattr__(self, "trajectory", as_trajectory(self.trajectory))
        object.__setattr__(self, "lines", lines)


def scan_move(
    length: float, velocity: float, limits: Limits, *, lines: int = 1, start: float = 0.0
) -> Scan:
    """Return a scan of lines at constant velocity, each the way back of the one before.

    The axis runs up before the first line, turns outside of [start, start + length], and runs
    out after the last one. A change of velocity is a move of velocity: that from rest to rest of
    one order less within the bounds on acceleration, jerk, …, integrated.

    Parameters
    ----------
    length : float
        Signed length of a line, not 0.
    velocity : float
        Along the lines, positive.
    limits : Limits
        Of order 2 to 14; velocity may be unbounded.
    lines : int, optional
        How many.
    start : float, optional
        Where the first line begins.

    Returns
    -------
    Scan

    Raises
    ------
    ValueError
        For a velocity beyond its bound, limits of order 1, or as in `min_time_move`.

    Examples
    --------
    >>> scan = scan_move(10.0, 2.0, Limits(acceleration=4.0, jerk=40.0), lines=2)
    >>> scan.lines.round(3).tolist()
    [[0.6, 5.6], [6.7, 11.7]]
    >>> scan([0.6, 3.0, 5.6], "velocity").tolist()
    [2.0, 2.0, 2.0]
    """
    length, count = finite("length", length), whole("lines", lines, 1, 1_000_000)
    speed = positive("velocity", velocity)
    if length == 0.0:
        raise ValueError("length = 0.0: a line has no length; give one, or use min_time_move")
    if of_one(limits).order < 2:
        raise ValueError("limits of order 1: a change of velocity takes a bound on acceleration")
    check_plain(limits)
    rate = speed if length > 0.0 else -speed
    for way in (rate, -rate)[:count]:
        _check_reached(way, limits)
    run_up = change_of_velocity(0.0, rate, limits)
    motion = run_up.shift(finite("start", start) - float(run_up.end_state[0]))
    times = []
    for line in range(count):
        way = rate if line % 2 == 0 else -rate
        straight = motion.end_time + abs(length) / speed
        times.append((motion.end_time, straight))
        after = -way if line + 1 < count else 0.0
        motion = motion.until(straight).then(change_of_velocity(way, after, limits))
    return Scan(motion, np.array(times))


def _check_reached(velocity: float, limits: Limits) -> None:
    low, high = limits.bounds(1)
    if not low <= velocity <= high:
        raise ValueError(
            f"velocity = {abs(velocity)!r} with limits from {low!r} to {high!r}: scan more "
            "slowly, or raise the velocity limit"
        )


def change_of_velocity(before: float, after: float, limits: Limits) -> Trajectory:
    """Return the fastest change of velocity, from position and time 0 on."""
    others = [limits.bounds(k) for k in range(2, limits.order + 1)]
    rate = min_time_move(after - before, Limits.from_bounds(others), start=before)
    low, high = limits.bounds(1)
    if rate.extremes(0)[0] < low * _BEYOND or rate.extremes(0)[1] > high * _BEYOND:
        within = Limits.from_bounds(others, position=(low, high))
        rate = min_time_move(after - before, within, start=before)
    return _integral(rate)


def _integral(rate: Trajectory) -> Trajectory:
    """Return the motion whose velocity is given, from position 0."""
    states = np.column_stack([np.zeros(len(rate.states)), rate.states])
    for i in range(1, len(states)):
        states[i, 0] = advance(states[i - 1], float(rate.durations[i - 1]))[0]
    end = np.append(advance(states[-1], float(rate.durations[-1]))[0], rate.end_state)
    return Trajectory(rate.breaks, states, rate.durations, end)
