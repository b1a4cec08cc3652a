"""A command given at times, such as one from a file, as a follower turns it into a motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .checks import of_kind
from .followers import CommandFollower
from .trajectory import Trajectory
from .trajectory_checks import finite_array
from .transfers.transfer import min_time_transfer


def follow_commands(
    follower: CommandFollower, times: ArrayLike, positions: ArrayLike
) -> Trajectory:
    """Return the motion with which a follower goes through positions commanded at times.

    At each of its samples, from the first time on, the last command that has begun is in force; the
    last one until it is reached. The follower starts at rest at the first position.

    Parameters
    ----------
    follower : CommandFollower
        Without jerk filter or period.
    times, positions : (N,) array
        Increasing times, and positions, as `analysis.read_log(path)` reads them from a CSV file.

    Returns
    -------
    Trajectory
        From the first time on, ending at rest at the last position; within the follower's limits.

    Raises
    ------
    ValueError
        For times that do not increase, or numbers that are not finite.

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
    return (motion.then(rest) if rest.duration else motion).delay(float(at[0]))
