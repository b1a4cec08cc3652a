"""Transfers onto a target that moves at constant velocity, and on with it."""

from __future__ import annotations

import numpy as np

from ..checks import finite, state_numbers
from ..limits import Limits, check_plain, of_one
from ..real_numbers import shown
from ..trajectory import Trajectory
from .problem import State, Transfer, checked_numbers
from .transfer import min_time_transfer


def tracking_transfer(start: State, target: State, limits: Limits) -> Transfer:
    """Return the fastest motion onto a moving target, target(t) = position + velocity·t.

    After its end the trajectory coasts on with the target: `transfer(t)` is the target from there
    on, as sidereal tracking and constant-velocity scans need it.

    Parameters
    ----------
    start : (position, velocity[, acceleration])
        At time 0, as in `min_time_transfer`.
    target : (position, velocity)
        At time 0, such as (ramp.offset, ramp.rate) of a `plant.Ramp`.
    limits : Limits
        Of order 2 to 10; the velocity bound holds for the axis, not relative to the target.

    Returns
    -------
    Transfer
        Starting at time 0, of minimum time: it is `min_time_transfer` seen from the target.

    Raises
    ------
    InfeasibleError, ValueError
        As in `min_time_transfer`, or for a target as fast as the velocity bound or faster, which
        is never caught up with.

    Examples
    --------
    >>> onto = tracking_transfer(0.0, (1.0, 0.5), Limits(velocity=2.0, acceleration=1.0, jerk=4.0))
    >>> later = onto.duration + 10.0
    >>> bool(abs(onto(later) - (1.0 + 0.5 * later)) < 1e-12)
    True
    """
    check_plain(of_one(limits))
    x, v, *others = *checked_numbers("start", start, limits), 0.0
    numbers = state_numbers("target", target)
    if len(numbers) != 2:
        raise ValueError(f"target = {shown(target)}: expected (position, velocity) at time 0")
    position, velocity = (
        finite("target position", numbers[0]),
        finite("target velocity", numbers[1]),
    )
    low, high = limits.bounds(1)
    if not low < velocity < high:
        raise ValueError(
            f"target velocity = {velocity!r} with limits from {low!r} to {high!r}: the axis cannot "
            "catch up with it; raise the velocity limit"
        )
    bounds = [limits.bounds(k) for k in range(2, limits.order + 1)]
    seen = Limits.from_bounds([(low - velocity, high - velocity), *bounds])
    begin = (x - position, v - velocity, *others)[: limits.order]
    relative = min_time_transfer(begin, 0.0, seen)
    moved = _moving(relative.trajectory, position, velocity)
    return Transfer(moved, limits, relative.inside_after)


def _moving(trajectory: Trajectory, position: float, velocity: float) -> Trajectory:
    """Return a motion as seen by one from whom the given frame moves away."""
    states, end = trajectory.states.copy(), trajectory.end_state.copy()
    states[:, 0] += position + velocity * trajectory.breaks[:-1]
    end[0] = position + velocity * trajectory.end_time
    states[:, 1] += velocity
    end[1] = velocity
    return Trajectory(trajectory.breaks, states, np.asarray(trajectory.durations), end, 1)
