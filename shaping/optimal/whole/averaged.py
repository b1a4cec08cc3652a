"""Moves under bounds that differ between the directions, in closed form: lower orders averaged."""

from __future__ import annotations

import numpy as np

from ...closed_moves import closed_form_move
from ...limits import Limits
from ...trajectory import Trajectory
from ..smoothing import averaged, truncated
from .problem import WholeProblem
from .repair import Repaired, excess, propagated

_MOST_ORDER = 3  # whose minimum time is exact for such bounds
_MISSED = 1e-12  # of the distance


def averaged_move(distance: float, limits: Limits) -> Trajectory | None:
    """Return the fastest of the moves of orders 1 to 3 after moving averages, from 0 in order n.

    An average over the last w keeps every bound and takes w longer; after q = n − m of them
    |x^(k)| ≤ 2^(k−m−1)·(hi_m − lo_m)/w^(k−m) for k > m. None where no order is bounded both ways.
    """
    n = limits.order
    moves = []
    for order in range(1, min(_MOST_ORDER, n - 1) + 1):
        low, high = limits.bounds(order)
        if not np.isfinite(high - low):
            continue
        lower = closed_form_move(distance, truncated(limits, order))
        lengths, inputs = averaged(lower, n, _width(limits, order))
        problem = WholeProblem(
            np.zeros(n),
            np.array([distance, *[0.0] * (n - 1)]),
            np.array([-np.inf, *limits.lower]),
            np.array([np.inf, *limits.upper]),
        )
        states = propagated(problem.start, lengths, inputs)
        motion = Repaired(lengths, states, float(lengths.sum()))
        missed = abs(float(states[0, -1]) - distance)
        if missed <= _MISSED * abs(distance) and excess(problem, motion) <= _MISSED:
            moves.append(motion.trajectory(problem, 0, 0))
    return min(moves, key=lambda move: move.duration, default=None)


def _width(limits: Limits, order: int) -> float:
    low, high = limits.bounds(order)
    widths = [
        (2.0 ** (k - order - 1) * (high - low) / min(map(abs, limits.bounds(k))))
        ** (1.0 / (k - order))
        for k in range(order + 1, limits.order + 1)
    ]
    return float(max(widths))
