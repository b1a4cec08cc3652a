"""A command given at times, such as one from a file, as a follower turns it into a motion."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from .averaged import averaged
from .checks import of_kind
from .derivatives import derivative_name
from .followers import CommandFollower
from .limits import Limits
from .trajectory import Trajectory
from .trajectory_checks import finite_array
from .transfers.transfer import min_time_transfer


def follow_commands(
    follower: CommandFollower,
    times: ArrayLike,
    positions: ArrayLike,
    *,
    within: Limits | None = None,
) -> Trajectory:
    """Return the motion with which a follower goes through positions commanded at times.

    At each of its samples, from the first time on, the last command that has begun is in force; the
    last one until it is reached. The follower starts at rest at the first position. Within
    limits of a higher order, as a feedforward of snap needs them, its motion is averaged once for
    each order more, over as long as the bound asks for: it lags by half of that, and keeps them.

    Parameters
    ----------
    follower : CommandFollower
        Without jerk filter or period.
    times, positions : (N,) array
        Increasing times, and positions, as `analysis.read_log(path)` reads them from a CSV file.
    within : Limits, optional
        Of the motion's order, with bounds on all derivatives above the follower's.

    Returns
    -------
    Trajectory
        From the first time on, ending at rest at the last position; within the follower's limits.

    Raises
    ------
    ValueError
        For times that do not increase, numbers that are not finite, or a derivative without bound
        between the follower's order and that of the limits.

    Examples
    --------
    >>> from jounce.shaping import Limits
    >>> follower = CommandFollower(Limits(velocity=2.0, acceleration=1.0), dt=0.5)
    >>> followed = follow_commands(follower, [10.0, 11.0], [0.0, 1.0])
    >>> followed.start_time, followed.end_time, followed([11.0, 13.0]).tolist()
    (10.0, 13.0, [0.0, 1.0])
    """
    of_kind("follower", follower, CommandFollower, "a CommandFollower(limits, dt=…)")
    at, given = finite_array("times", times), finite_array("positions", positions)
    if at.ndim != 1 or not at.size or given.shape != at.shape or not (np.diff(at) > 0.0).all():
        raise ValueError(
            f"times of shape {at.shape} with positions of shape {given.shape}: expected a row of "
            "increasing times, and one position for each"
        )
    dt = follower.dt
    samples = round((at[-1] - at[0]) / dt) + 1
    when = at[0] + dt * (np.arange(float(samples)) + 1e-9)
    held = given[np.searchsorted(at, when, side="right") - 1]
    held[-1] = given[-1]
    motion = follower.trajectory(held, initial=follower.rest(float(given[0])))
    state = motion.end_state[: follower.order].tolist()
    rest = min_time_transfer(state, float(given[-1]), follower.limits)
    whole = (motion.then(rest) if rest.duration else motion).delay(float(at[0]))
    return whole if within is None else _smoothed(whole, follower, within)


def _smoothed(motion: Trajectory, follower: CommandFollower, within: Limits) -> Trajectory:
    """Return a motion averaged so that its derivatives above the follower's keep their bounds.

    Averaged over T, the next one is at most the span of the highest over T.
    """
    of_kind("within", within, Limits, "Limits(velocity=…, …, snap=…)")
    below, above = follower.limits.bounds(follower.order)
    for k in range(follower.order + 1, within.order + 1):
        low, high = within.bounds(k)
        least = min(high, -low)
        if not 0.0 < least < inf:
            raise ValueError(
                f"{derivative_name(k)} from {low!r} to {high!r}: expected a bound in both "
                f"directions, as the {derivative_name(within.order)} has one; give it"
            )
        motion = averaged(motion, (above - below) / least)
        below, above = low, high
    return motion
