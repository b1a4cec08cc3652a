"""Blocks of moves of one form, their pieces as arrays that stay in the processor's cache."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..derivatives import derivative_name
from ..pieces import FloatArray
from . import plans
from .many_limits import ManyLimits, flat_part

_SPOILT = 1e-11  # an excess over a bound that is more than rounding
_STATES = 2**17  # numbers in the states of the pieces made at a time


class Moves(NamedTuple):
    """What a batch keeps: distances, starts, durations and forms of one shape, and limits."""

    distances: FloatArray
    starts: FloatArray
    limits: ManyLimits
    duration: FloatArray
    forms: plans.Forms


class Block(NamedTuple):
    """Pieces of k moves of one form.

    lanes : slice or (k,) array
        Which moves of the batch these are, counted in C order.
    breaks : (m + 1, k) array
    durations : (m, k) array
        Zero for pieces that a move does not need.
    states : (n + 1, m, k) array
    starts, ends : (k,) arrays
        Positions at start and end.
    """

    lanes: plans.Lanes
    breaks: FloatArray
    durations: FloatArray
    states: FloatArray
    starts: FloatArray
    ends: FloatArray


def blocks(moves: Moves) -> Iterator[Block]:
    """Yield all moves of a batch in blocks; a move spoilt by rounding raises ValueError."""
    shape, total, order = moves.duration.shape, moves.duration.size, moves.limits.order
    most = plans.most_pieces(order, moves.forms)
    step = max(1, _STATES // (most * (order + 1)))
    for i in range(0, total, step):
        some = slice(i, i + step)
        size = min(step, total - i)
        duration, distance, start = (
            np.broadcast_to(flat_part(array, shape, some), size)
            for array in (moves.duration, moves.distances, moves.starts)
        )
        forms = np.broadcast_to(flat_part(moves.forms, shape, some), size)
        limits = moves.limits.part(shape, some)
        for lanes, durations, states in plans.pieces(distance, limits, forms):
            spoilt = spoilt_bound(states, limits.each((size,), lanes))
            if spoilt:
                k, lane = spoilt
                move = lane if isinstance(lanes, slice) else int(lanes[lane])
                raise ValueError(spoilt_text(k, index_text(i + move, shape)))
            begin = start[lanes]
            states[0] += begin
            breaks = _breaks(durations, duration[lanes])
            ends = begin + distance[lanes]
            yield Block(shift(lanes, i), breaks, durations, states, begin, ends)


def shift(lanes: plans.Lanes, first: int) -> plans.Lanes:
    """Return lanes counted from a move before them."""
    if isinstance(lanes, slice):
        return slice(lanes.start + first, lanes.stop + first)
    return lanes + first


def _breaks(durations: FloatArray, total: FloatArray) -> FloatArray:
    """Return the times between pieces, those of the second half counted from the end."""
    m = len(durations)
    breaks = np.zeros((m + 1, len(total)))
    half = m // 2 + 1
    breaks[m] = total
    for j in range(half - 1):
        np.add(breaks[j], durations[j], out=breaks[j + 1])
    for j in range(m - 1, half - 1, -1):
        np.subtract(breaks[j + 1], durations[j], out=breaks[j])
    for j in range(m):
        np.maximum(breaks[j + 1], breaks[j], out=breaks[j + 1])
    return breaks


def spoilt_bound(states: FloatArray, limits: ManyLimits) -> tuple[int, int] | None:
    """Return derivative and move of a bound that states (n + 1, m, k) break, None if they do not.

    Only rounding can do that, and takes bounds some 15 decades apart.
    """
    for k in range(1, len(states)):
        up, down = limits.rising[k - 1], limits.falling[k - 1]
        kept = states[k].max(axis=0) <= up * (1.0 + _SPOILT)
        kept &= -states[k].min(axis=0) <= down * (1.0 + _SPOILT)
        if not kept.all():
            return k, int(np.argmin(kept))
    return None


def spoilt_text(k: int, index: str) -> str:
    """Return the message about a bound on derivative k that cannot be kept."""
    return (
        f"the {derivative_name(k)} limit of move {index} cannot be kept in double precision: the "
        "limits are too many decades apart; leave out those that never bind"
    )


def index_text(move: int, shape: tuple[int, ...]) -> str:
    """Return the index of a move counted in C order."""
    return ", ".join(str(int(i)) for i in np.unravel_index(move, shape))
