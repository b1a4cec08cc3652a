"""Moves of order 4 and more from those of orders 1 to 3, by moving averages; on arrays.

    x^(n)(t) = Σ_j (−1)^j·C(q, j)·x^(m)(t − j·w) / w^q,   q = n − m

An average over the last w keeps every bound and takes w longer; after q of them
|x^(k)| ≤ 2^(k−m−1)·(hi_m − lo_m)/w^(k−m) for k > m. Bounds may differ between the directions, as
those orders are planned exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, factorial, inf

import numpy as np

from ... import core
from ..limits import Limits
from ..move_units import Sides
from ..pieces import FloatArray, RealArray
from ..trajectory import Trajectory

ORDERS = (1, 2, 3)
"""Those that averages are taken of."""

_SAME_TIME = 1e-14  # of the shortest piece or average: breaks nearer than that are one
_MISSED = 1e-12  # of the distance: more than rounding
_ROUNDING = 1e-15  # of its peak: a derivative between two pieces that is zero but for rounding


def averaged_move(distance: float, limits: Limits) -> Trajectory | None:
    """Return the fastest move of order n from 0 that is averaged from orders 1 to 3.

    None where no order is bounded both ways, or rounding spoils it.
    """
    n, ahead = limits.order, limits if distance > 0.0 else limits.mirror()
    length = np.array([abs(distance)])
    sides: list[Sides] = [
        (np.array(low), np.array(high)) for low, high in zip(ahead.lower, ahead.upper, strict=True)
    ]
    times = {m: averaged_duration(length, sides, m).item() for m in ORDERS if m < n}
    order = min(times, key=times.__getitem__)
    if not times[order] < inf:
        return None
    lengths, states = (rows[..., 0] for rows in averaged_pieces(length, sides, order))
    if abs(states[0, -1] - length[0]) > _MISSED * length[0]:
        return None
    some = lengths > 0.0
    lengths, states = lengths[some], np.asarray(states[:, :-1][:, some], float)
    breaks = np.append(0.0, np.cumsum(lengths)).astype(float)
    end = np.append(length, np.zeros(n))
    move = Trajectory.from_arrays(
        breaks, np.ascontiguousarray(states.T), np.asarray(lengths, float), end
    )
    return move if distance > 0.0 else move.mirror()


def averaged_duration(distance: FloatArray, sides: Sequence[Sides], order: int) -> FloatArray:
    """Return how long moves take that are averaged from an order m, (K,); infinite for none.

    Parameters
    ----------
    distance : (K,) array
        At least zero.
    sides : sequence of pairs of (K,) or 0-d arrays
        Lower and upper bounds on derivatives 1…n.
    order : int
        m.
    """
    low, high = _lower_sides(sides, order)
    duration = np.empty(len(distance))
    core.move_durations(order, np.ascontiguousarray(distance), low, high, duration)
    width = least_width(sides, order)
    there = np.isfinite(sides[order - 1][1] - sides[order - 1][0])
    return np.where(there, duration + (len(sides) - order) * width, np.inf)


def most_averaged(order: int, of: int) -> int:
    """Return the largest number of pieces of a move that is averaged from order m."""
    return int(2**of * (order - of + 1) - 1)


def averaged_pieces(
    distance: FloatArray, sides: Sequence[Sides], order: int
) -> tuple[RealArray, RealArray]:
    """Return lengths (M, K) and states (n + 1, M + 1, K) from 0 of the moves that are averaged.

    Lengths are zero for pieces that a move does not need; the last state is that at the end.
    """
    lengths, inputs = _lower_pieces(distance, sides, order)
    width = np.broadcast_to(least_width(sides, order), len(distance)).astype(np.longdouble)
    lengths, inputs = averaged_inputs(lengths, inputs, width, len(sides) - order)
    return lengths.T, _states(lengths, inputs, len(sides)).transpose(0, 2, 1)


def least_width(sides: Sequence[Sides], order: int) -> FloatArray:
    """Return w, the least that keeps all bounds above derivative m, those of 1…n given."""
    with np.errstate(all="ignore"):
        range_of = sides[order - 1][1] - sides[order - 1][0]
        widths = [
            (2.0 ** (k - order - 1) * range_of / np.minimum(-low, high)) ** (1.0 / (k - order))
            for k, (low, high) in enumerate(sides[order:], start=order + 1)
        ]
    return np.asarray(np.maximum.reduce(np.broadcast_arrays(*widths)))


def _lower_sides(
    sides: Sequence[Sides], order: int
) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Return the bounds up to derivative m for the core, its own finite."""
    low, high = ([np.asarray(pair[i]).reshape(-1) for pair in sides[:order]] for i in (0, 1))
    low[-1] = np.where(np.isfinite(low[-1]), low[-1], -1.0)
    high[-1] = np.where(np.isfinite(high[-1]), high[-1], 1.0)
    return tuple(map(np.ascontiguousarray, low)), tuple(map(np.ascontiguousarray, high))


def _lower_pieces(
    distance: FloatArray, sides: Sequence[Sides], order: int
) -> tuple[RealArray, RealArray]:
    """Return lengths and inputs of the exact moves of order m, (K, P) each."""
    count, most = len(distance), 2**order - 1
    bounds = np.empty((count, order, 2))
    for k, pair in enumerate(zip(*_lower_sides(sides, order), strict=True)):
        for side, values in enumerate(pair):
            bounds[:, k, side] = values
    lengths, states = np.empty((count, most)), np.empty((count, most, order + 1))
    starts, ends = np.zeros(count), np.empty((count, order + 1))
    core.move_pieces(
        order, np.ascontiguousarray(distance), starts, bounds, most, lengths, states, ends
    )
    return lengths.astype(np.longdouble), states[..., order].astype(np.longdouble)


def averaged_inputs(
    lengths: RealArray, inputs: RealArray, width: RealArray, count: int
) -> tuple[RealArray, RealArray]:
    """Return lengths and inputs of the pieces after `count` averages, (K, M) each."""
    lanes, zero = len(lengths), np.zeros((len(lengths), 1), np.longdouble)
    edges = np.hstack([zero, np.cumsum(lengths, axis=1)])
    shifts = np.arange(count + 1)
    times = edges[:, None, :] + shifts[:, None] * width[:, None, None]
    order = np.argsort(times.reshape(lanes, -1), axis=1, kind="stable")
    shift, edge = np.divmod(order, edges.shape[1])
    steps = np.diff(shift, axis=1) * width[:, None]
    steps = steps + np.diff(np.take_along_axis(edges, edge, axis=1), axis=1)
    padded = np.hstack([zero, inputs, zero])
    total: RealArray = np.zeros(steps.shape, np.longdouble)
    for j in shifts:
        begun = np.maximum.accumulate(np.where(shift == j, edge + 1, 0), axis=1)[:, :-1]
        total += (-1) ** int(j) * comb(count, int(j)) * np.take_along_axis(padded, begun, axis=1)
    shortest = np.min(lengths, axis=1, where=lengths > 0.0, initial=np.inf)
    none = steps <= _SAME_TIME * np.minimum(shortest, width)[:, None]
    steps[none] = 0.0
    for i in range(steps.shape[1] - 1, -1, -1):  # a piece of no length is as what follows
        after = total[:, i + 1] if i + 1 < steps.shape[1] else 0.0
        total[:, i] = np.where(none[:, i], after, total[:, i])
    return steps, total / width[:, None] ** count


def _states(lengths: RealArray, inputs: RealArray, order: int) -> RealArray:
    """Return states at pieces' starts and the end, (n + 1, K, M + 1), no roundings of zero."""
    lanes, count = lengths.shape
    states: RealArray = np.zeros((order + 1, lanes, count + 1), np.longdouble)
    states[order, :, :-1] = inputs
    for k in range(order - 1, -1, -1):
        rises = sum(
            states[k + i, :, :-1] * lengths**i / factorial(i) for i in range(1, order - k + 1)
        )
        states[k, :, 1:] = np.cumsum(rises, axis=1)
        if k:
            peaks = np.abs(states[k]).max(axis=1, keepdims=True)
            states[k, np.abs(states[k]) <= _ROUNDING * peaks] = 0.0
    return states
