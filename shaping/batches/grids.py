"""Values of many moves on one time grid."""

from __future__ import annotations

import numpy as np

from ..pieces import FloatArray, evaluate
from .blocks import Block
from .plans import Lanes

_POINTS = 8192  # evaluated at a time, so that the work stays in the cache


def fill(out: FloatArray, block: Block, times: FloatArray, derivatives: range) -> None:
    """Put derivatives of a block's moves at increasing times in place.

    Parameters
    ----------
    out : (len(derivatives), N, T) array
        Of all moves of the batch.
    block : Block
    times : (T,) array
    derivatives : range
        Consecutive derivatives wanted.
    """
    total, step = len(block.starts), max(1, _POINTS // max(1, len(times)))
    states, origins, longest = _with_rest(block)
    edges = np.searchsorted(times, block.breaks.T)  # (k, m + 1)
    for i in range(0, total, step):
        some = slice(i, min(i + step, total))
        lanes = _lanes(block.lanes, some)
        rows = states[:, some].reshape(len(states), -1)
        for j in range(0, len(times), _POINTS):
            part = slice(j, min(j + _POINTS, len(times)))
            ends = np.clip(edges[some], part.start, part.stop)
            points = np.diff(ends, axis=1, prepend=part.start, append=part.stop).ravel()
            tau = np.tile(times[part], some.stop - i)
            tau -= np.repeat(origins[some].ravel(), points)
            np.minimum(tau, np.repeat(longest[some].ravel(), points), out=tau)
            values = evaluate(np.repeat(rows, points, axis=1), tau, derivatives)
            out[:, lanes, part] = values.reshape(len(derivatives), some.stop - i, -1)


def _lanes(lanes: Lanes, some: slice) -> Lanes:
    if isinstance(lanes, slice):
        return slice(lanes.start + some.start, lanes.start + some.stop)
    return lanes[some]


def _with_rest(block: Block) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return states (n + 1, k, m + 2), origins and longest times (k, m + 2), rest included."""
    m, count = block.durations.shape
    states = np.zeros((len(block.states), count, m + 2))
    states[..., 1:-1] = block.states.transpose(0, 2, 1)
    states[0, :, 0], states[0, :, -1] = block.starts, block.ends
    origins = np.empty((count, m + 2))
    origins[:, 0] = 0.0
    origins[:, 1:] = block.breaks.T
    longest = np.full((count, m + 2), np.inf)
    longest[:, 1:-1] = block.durations.T
    return states, origins, longest
