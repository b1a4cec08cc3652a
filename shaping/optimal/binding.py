"""Which limit holds a motion back, piece by piece."""

from __future__ import annotations

import numpy as np

from ..checks import positive
from ..limits import Limits, of_one
from ..pieces import extrema
from ..trajectory import Motion, as_trajectory
from .own_units import of_order_one

BINDING_RTOL = 1e-3
"""How near to its bound, relative, a derivative counts as at it."""


def binding_limits(
    trajectory: Motion, limits: Limits, *, rtol: float = BINDING_RTOL
) -> tuple[tuple[int, ...], ...]:
    """Return the derivatives that are at a bound all along each piece.

    Parameters
    ----------
    trajectory : Trajectory
    limits : Limits
    rtol : float, optional
        How near to its bound a derivative counts as at it, relative to the bound, or to its own
        peak where that is zero, position to the distance between its extremes; below 1. An optimal
        move of order 4 or more comes as near as the default where its true minimum would stay at
        the bound.

    Returns
    -------
    tuple of m tuples of int
        For each piece the numbers of the derivatives (0 position, 1 velocity, …) that stay at one
        of their bounds from its start to its end, lowest first; empty where none does,
        as on a piece on which the input is between its bounds.

    Raises
    ------
    ValueError
        For an rtol that is not between 0 and 1.
    TypeError
        For anything but a Trajectory and Limits.

    Examples
    --------
    >>> from jounce.shaping import min_time_move
    >>> limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    >>> binding_limits(min_time_move(1.0, limits), limits)
    ((3,), (2,), (3,), (1,), (3,), (2,), (3,))
    """
    trajectory, limits, _ = of_order_one(as_trajectory(trajectory), of_one(limits))
    rtol = positive("rtol", rtol)
    if rtol >= 1.0:
        raise ValueError(
            f"rtol = {rtol!r}: expected less than 1, at which everything is at a bound"
        )
    held: list[list[int]] = [[] for _ in trajectory.states]
    for k in range(min(limits.order, trajectory.order) + 1 if held else 0):
        low, high = extrema(trajectory.durations, trajectory.states[:, k:].T)
        lower, upper = limits.bounds(k)
        least, most = float(low.min()), float(high.max())
        sizes = [most - least if k == 0 else abs(x) or max(-least, most) for x in (lower, upper)]
        at = (low >= upper - rtol * sizes[1]) | (high <= lower + rtol * sizes[0])
        for i in np.flatnonzero(at):
            held[i].append(k)
    return tuple(tuple(derivatives) for derivatives in held)
