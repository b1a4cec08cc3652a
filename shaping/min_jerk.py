"""The minimum-jerk (quintic) move."""

from __future__ import annotations

from math import isfinite

from .checks import finite, positive
from .trajectory import Trajectory, point, within_range


def min_jerk_move(
    distance: float,
    *,
    duration: float | None = None,
    average_velocity: float | None = None,
    max_velocity: float | None = None,
    start: float = 0.0,
) -> Trajectory:
    """Return the move from rest to rest with the least integral of squared jerk.

        x(t) = x₀ + R·(10 s³ − 15 s⁴ + 6 s⁵),   s = t/T
        peak velocity = 15/8 · |R|/T

    Parameters
    ----------
    distance : float
        Signed distance R. Zero gives a trajectory of duration zero.
    duration : float, optional
        T > 0.
    average_velocity : float, optional
        |R|/T > 0.
    max_velocity : float, optional
        Peak velocity, 15/8·|R|/T > 0.
    start : float, optional
        Position x₀ at the start.

    Returns
    -------
    Trajectory
        One piece of order 5, both end points included, starting at time 0. Acceleration is
        zero at both ends, jerk is not.

    Raises
    ------
    ValueError
        Unless exactly one of duration, average_velocity and max_velocity is given, or where a
        value is not finite or not positive.

    References
    ----------
    Flash & Hogan, 1985; "Trajectory generation with a minimum jerk trajectory" (which prints
    the exact ratio 15/8 as 1.87).

    Examples
    --------
    >>> move = min_jerk_move(180.0, average_velocity=20.0)
    >>> move.duration, move.peak("velocity")
    (9.0, 37.5)
    """
    distance, start = finite("distance", distance), finite("start", start)
    given = {
        name: value
        for name, value in (
            ("duration", duration),
            ("average_velocity", average_velocity),
            ("max_velocity", max_velocity),
        )
        if value is not None
    }
    if len(given) != 1:
        raise ValueError(
            f"got {', '.join(given) or 'none'} of duration, average_velocity and max_velocity: "
            "give exactly one"
        )
    [(name, value)] = given.items()
    value = positive(name, value)
    if distance == 0.0:
        return point(start, 5)
    factor = {"duration": None, "average_velocity": 1.0, "max_velocity": 1.875}[name]
    time = value if factor is None else factor * (abs(distance) / value)
    return within_range(lambda: _quintic(start, distance, time))


def _quintic(start: float, distance: float, time: float) -> Trajectory:
    if not (time**3):
        raise OverflowError
    jerk = 60.0 * distance / time**3
    state = [start, 0.0, 0.0, jerk, -6.0 * jerk / time, 12.0 * jerk / time**2]
    if not all(map(isfinite, state)):
        raise OverflowError
    return Trajectory([0.0, time], [state], None, [start + distance, 0.0, 0.0, 0.0, 0.0, 0.0])
