"""Where one loop passes the negative real axis, which way, and at which gain."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from .factored_loop import Real
from .many_crossings import OnePieces
from .many_gain_and_phase import level_crossings, with_limits


class Passages(NamedTuple):
    """Places where L(jω) is real and negative, ω rising, (K,) arrays.

    Attributes
    ----------
    omega, gain : arrays
        ω, 0 and inf at the limits, and ln |L| there: inf on a pole of the axis, −inf on a zero.
    turns : array
        By how many whole turns the phase rises there; ½ where half of the passage belongs to
        negative frequencies.
    inside : array of bool
        Whether ω is neither a limit nor a root on the axis.
    """

    omega: Real
    gain: Real
    turns: Real
    inside: Any


def passages(pieces: OnePieces) -> Passages:
    """Return the passages of a loop that can limit a gain, in no order.

    Where the phase falls through −180 degrees oftener than it ever rises there, as behind a long
    delay, those from the middle of a piece are left out: |L| only has values between there, and
    a gain for which they count leaves no loop stable.
    """
    whole = np.floor(with_limits(pieces)[0])
    rising = np.maximum(np.diff(whole), 0.0).sum() + abs(pieces.loops.power[0])
    most = 2 + int(rising)
    last = len(whole) - 2 if pieces.loops.delay[0] else None
    rows = [
        (column, level, share)
        for column, ends in enumerate(pairwise(whole.tolist()))
        for level, share in _levels(*ends, most, column == last)
    ]
    columns = np.array([row[0] for row in rows], dtype=int)
    level, share = (np.array([row[k] for row in rows], dtype=float) for k in (1, 2))
    found, arcs = _placed(pieces, columns, level, share), _on_arcs(pieces, whole)
    joined = (np.concatenate(parts) for parts in zip(found, arcs, strict=True))
    return Passages(*joined)


def whole_turns(pieces: OnePieces) -> Real:
    """Return how many whole turns lie below each edge, (K,).

    Poles and zeros at ω = 0 and ∞ are passed on their right; on the real axis at either end of
    the contour, half of a passage belongs to its other half. Behind a delay there is no other
    end.
    """
    loops = pieces.loops
    low, high = (turns[0] for turns in loops.turns_at_limits)
    whole: Real = np.floor(pieces.turns[0])
    whole[0] = below(low - 0.25 * loops.power[0])
    if not loops.delay[0]:
        whole[-1] = below(high - 0.25 * loops.rise[0])
    return whole


def below(end: Real) -> Real:
    """Return the whole turns below an end of the contour."""
    return np.asarray(np.where(end == np.floor(end), end - 0.5, np.floor(end)))


def _on_arcs(pieces: OnePieces, whole: Real) -> Passages:
    """Return the passages around zeros and poles at ω = 0 and ω → ∞, at the limits of the gain."""
    ends = whole_turns(pieces)
    arcs = ((0.0, 0, ends[0], whole[0]), (np.inf, 1, whole[-1], ends[-1]))
    rows = [
        (place, float(pieces.loops.limits[side][0]), share)
        for place, side, start, end in arcs
        for _, share in _levels(start, end, pieces.omega.size, False)
    ]
    omega, gain, turns = np.array(rows).reshape(-1, 3).T
    return Passages(omega, gain, turns, np.zeros(len(rows), dtype=bool))


def _levels(start: float, end: float, most: int, endless: bool) -> list[tuple[float, float]]:
    """Return whole turns passed on the way from start to end, and what share of each, signed."""
    low, high = sorted((start, end))
    count = int(np.ceil(high) - np.floor(low))
    first = np.floor(low) + 1.0 + np.arange(min(count, most))
    last = np.ceil(high) - np.arange(min(count, most))
    kept = last if endless else np.unique(np.concatenate([first, last]))
    share = np.minimum(high, kept) - np.maximum(low, kept - 1.0)
    signed = share * np.sign(end - start)
    return list(zip(kept[share > 0].tolist(), signed[share > 0].tolist(), strict=True))


def _placed(pieces: OnePieces, columns: Any, level: Real, share: Real) -> Passages:
    loops = pieces.loops
    turns, gain = with_limits(pieces)[0], pieces.gain[0].copy()
    gain[0], gain[-1] = (limit[0] for limit in loops.limits)
    omega = pieces.omega[0].copy()
    omega[0], omega[-1] = 0.0, np.inf
    low, high = turns[columns], turns[columns + 1]
    inside = (np.minimum(low, high) < level) & (level < np.maximum(low, high))
    at_low = abs(level - low) <= abs(level - high)
    nearer = np.where(at_low, columns, columns + 1)
    place, size = omega[nearer], gain[nearer]
    some = np.flatnonzero(inside)
    zeros = np.zeros(some.size, dtype=int)
    found = level_crossings(pieces, zeros, columns[some], level[some])
    place[some] = found
    size[some] = loops.take(zeros).gain(found[:, None])[:, 0]
    # Across a pole on the axis the phase falls, across a zero it rises.
    jumping = pieces.jumping[0][columns]
    size = np.where(jumping, np.where(share < 0.0, np.inf, -np.inf), size)
    limits = (place == 0.0) | np.isinf(place)
    return Passages(place, size, share, ~limits & ~jumping)
