"""Where the closed loop of one loop first falls by 3 dB, by branch and bound."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .factored_loop import Real
from .many_crossings import OnePieces, solve
from .many_loops import Slopes
from .many_modulus import distance

_SPREAD = 0.1
_NARROW = 1e-14
_TURN = 2.0 * np.pi
_LEAST = 1e-50


def bandwidth(inverse: OnePieces) -> float:
    """Return the lowest ω where |T| falls to |T(0)|/√2, nan where it never does or T(0) = 0.

    With 1/T = 1 + 1/L, which on a monotone piece stays within a sector whose farthest corner
    from −1 bounds it.

    Parameters
    ----------
    inverse : Pieces
        Those of 1/L, one loop, stable.
    """
    gain, turns = (part[0] for part in (inverse.gain, inverse.turns))
    limit, at_zero = inverse.loops.limits[0][0], inverse.loops.turns_at_limits[0][0]
    start = float(distance(np.fmin(limit, 300.0), at_zero))
    if start > 1.0 / _LEAST:
        return math.nan
    level = start * math.sqrt(2.0)
    edges = np.stack([np.log(inverse.omega[0]), gain, turns])
    while True:
        edges = _up_to_first(edges, level)
        wide = _may_pass(edges, level) & (np.diff(edges[0]) > _NARROW)
        if not wide.any():
            return _solved(inverse, edges, level)
        middle = 0.5 * (edges[0, :-1] + edges[0, 1:])[wide]
        values = inverse.loops.gain_and_turns(np.exp(middle)[None])
        inner = np.stack([middle, *(value[0] for value in values)])
        edges = np.insert(edges, np.flatnonzero(wide) + 1, inner, axis=1)


def _up_to_first(edges: Real, level: float) -> Real:
    """Return the edges up to the first at which 1/T has passed the level."""
    [passed] = np.nonzero(distance(edges[1], edges[2]) >= level)
    return edges[:, : passed[0] + 1] if passed.size else edges


def _may_pass(edges: Real, level: float) -> Any:
    """Whether 1/T may pass the level in a sector too large to say that it does so but once."""
    gains, turns = edges[1], edges[2]
    off = abs(turns - np.rint(turns))
    largest = np.maximum(off[:-1], off[1:])
    across = np.floor(turns[:-1] - 0.5) != np.floor(turns[1:] - 0.5)
    high = np.maximum(gains[:-1], gains[1:])
    low = np.minimum(gains[:-1], gains[1:])
    largest = np.where(across, 0.5, largest)
    farthest = np.maximum(distance(high, largest), distance(low, largest))
    spread = high - low + _TURN * abs(np.diff(turns))
    return (farthest > level) & (spread > _SPREAD)


def _solved(inverse: OnePieces, edges: Real, level: float) -> float:
    """Return where the level is passed in the last interval."""
    if distance(edges[1, -1:], edges[2, -1:])[0] < level:
        return math.nan
    loops = inverse.loops

    def excess(_: Any, logs: Real) -> tuple[Real, Real]:
        at = loops.slopes(np.exp(logs)[None])
        value, slope = _log_distance(at)
        return value[0] - math.log(level), slope[0]

    low, high = edges[0, -2:-1], edges[0, -1:]
    found = solve(excess, low, high, 0.5 * (low + high), np.array([True]))
    return float(np.exp(found[0]))


def _log_distance(at: Slopes) -> tuple[Real, Real]:
    """Ln |1 + 1/L| and its derivative by ln ω."""
    off = at.turns - np.rint(at.turns)
    value = -np.exp(at.gain) * np.exp(1j * _TURN * off)
    return np.log(distance(at.gain, at.turns)), (at.first * value / (1.0 + value)).real
