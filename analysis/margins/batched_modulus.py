"""min |1 + L| of many loops, by branch and bound.

On a piece of the axis where gain and phase are monotone L stays within a sector of a ring, whose
distance from −1 is a lower bound. Pieces that may hold less than the least value known are
halved until the sector is small; then the minimum that lies inside is solved for.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .batched_crossings import Pieces, solve
from .batched_loops import Loops, Slopes
from .batched_margins import SAME, least
from .factored_loop import Real

SMALL = 0.1
"""Size of a sector, relative to its distance from −1, at which it is no longer halved."""

_WIDEST = 0.3
_TURN = 2.0 * np.pi
_ROUNDS = 200
_GRIP = 1e-12
_NARROW = 1e-13


Ends = tuple[Real, Real]


class _Sectors(NamedTuple):
    """Intervals of ln ω of loops `rows`, and gain and turns at both ends, (M,) each."""

    rows: Any
    logs: Ends
    gains: Ends
    turns: Ends

    def where(self, some: Any) -> _Sectors:
        ends = [(low[some], high[some]) for low, high in self[1:]]
        return _Sectors(self.rows[some], *ends)

    def halves(self, middle: Real, gain: Real, turns: Real) -> _Sectors:
        """Return both halves of each, given what is in the middle."""
        ends = [
            (np.concatenate([low, inner]), np.concatenate([inner, high]))
            for (low, high), inner in zip(self[1:], (middle, gain, turns), strict=True)
        ]
        return _Sectors(np.concatenate([self.rows, self.rows]), *ends)


def modulus(pieces: Pieces, crossings: Ends) -> Ends:
    """Return min |1 + L| and ω of each loop, (B,), 0 and inf where it is a limit.

    Parameters
    ----------
    pieces : Pieces
    crossings : (B, K) and (B, K) arrays
        ln |L| at phase crossovers, nan for none, and ω: the minimum does not exceed |1 − |L||.
    """
    loops = pieces.loops
    limits, places = _at_limits(loops)
    ends = (pieces.omega == pieces.omega[:, :1]) | (pieces.omega == pieces.omega[:, -1:])
    found = np.where(ends, np.inf, distance(pieces.gain, pieces.turns))
    real = np.where(np.isnan(crossings[0]), np.inf, abs(np.expm1(crossings[0])))
    known, place = least(
        np.concatenate([limits, found, real], axis=1),
        np.concatenate([places, pieces.omega, crossings[1]], axis=1),
    )
    small = _small_sectors(loops, _sectors(pieces), known, place)
    rows, values, omega = _minima(loops, small)
    better = values <= known[rows] * (1.0 + SAME)
    rows, values, omega = rows[better], values[better], omega[better]
    descending = np.argsort(-values, kind="stable")  # of several the last assigned stays
    rows = rows[descending]
    known[rows], place[rows] = values[descending], omega[descending]
    limit, at_limit = least(limits, places)
    reached = limit <= known * (1.0 + SAME)
    return np.where(reached, limit, known), np.where(reached, at_limit, place)


def distance(gain: Real, turns: Real) -> Real:
    """Return |1 + L|, with |1 + L|² = (1 − |L|)² + 4·|L|·sin²(δ/2), δ the angle from −1."""
    half = np.sin(np.pi * (turns - np.rint(turns)))
    return np.hypot(np.expm1(gain), 2.0 * np.exp(0.5 * gain) * half)


def _at_limits(loops: Loops) -> tuple[Real, Real]:
    """Return |1 + L| at ω = 0 and ω → ∞, and these places, (B, 2).

    Behind a delay L comes by −|L| again and again, while the gain tends to its limit.
    """
    low, high = loops.turns_at_limits
    high = np.where(loops.delay > 0, 0.0, high)
    values = [
        np.where(limit < np.inf, distance(np.fmin(limit, 300.0), turns), np.inf)
        for limit, turns in zip(loops.limits, (low, high), strict=True)
    ]
    return np.stack(values, axis=1), np.broadcast_to([0.0, np.inf], (len(loops), 2))


def _sectors(pieces: Pieces) -> _Sectors:
    logs = np.log(pieces.omega)
    rows, columns = np.nonzero(logs[:, 1:] > logs[:, :-1])
    ends = [
        (part[rows, columns], part[rows, columns + 1]) for part in (logs, pieces.gain, pieces.turns)
    ]
    return _Sectors(rows, *ends)


def _nearest(sectors: _Sectors) -> Real:
    """Return the distance of each sector from −1."""
    turns = sectors.turns
    off = np.minimum(*(abs(end - np.rint(end)) for end in turns))
    passed = np.floor(np.maximum(*turns)) >= np.ceil(np.minimum(*turns))
    off = np.where(passed, 0.0, off)
    across = np.log(np.maximum(np.cos(_TURN * off), 0.0))
    inside = np.minimum(np.maximum(across, np.minimum(*sectors.gains)), np.maximum(*sectors.gains))
    return distance(inside, off)


def _small_sectors(loops: Loops, sectors: _Sectors, known: Real, place: Real) -> _Sectors:
    """Return the sectors that may hold less than is known, halved until they are small.

    The least values known, and their places, are kept up to date.
    """
    found = [sectors.where(slice(0, 0))]
    for _ in range(_ROUNDS):
        size, bar = np.exp(np.maximum(*sectors.gains)), known[sectors.rows]
        sectors = sectors.where(_nearest(sectors) < bar - _GRIP * np.minimum(size, 1.0) * bar)
        if not sectors.rows.size:
            break
        size, bar = np.exp(np.maximum(*sectors.gains)), known[sectors.rows]
        (low, high), gains, turns = sectors[1:]
        spread = -np.expm1(-abs(gains[1] - gains[0])) + _TURN * abs(turns[1] - turns[0])
        small = spread <= np.minimum(SMALL * bar / size, _WIDEST)
        found.append(sectors.where(small))
        sectors = sectors.where(~small & (high - low > _NARROW))
        middle = 0.5 * (sectors.logs[0] + sectors.logs[1])
        gain, turn = (
            part[:, 0] for part in loops.take(sectors.rows).gain_and_turns(np.exp(middle)[:, None])
        )
        value = distance(gain, turn)
        np.minimum.at(known, sectors.rows, value)
        best = value == known[sectors.rows]
        place[sectors.rows[best]] = np.exp(middle[best])
        sectors = sectors.halves(middle, gain, turn)
    return _joined(found)


def _joined(parts: list[_Sectors]) -> _Sectors:
    ends = [
        (
            np.concatenate([part[k][0] for part in parts]),
            np.concatenate([part[k][1] for part in parts]),
        )
        for k in (1, 2, 3)
    ]
    return _Sectors(np.concatenate([part.rows for part in parts]), *ends)


def _minima(loops: Loops, sectors: _Sectors) -> tuple[Any, Real, Real]:
    """Return rows, values and ω of the minima inside of sectors, where the slope changes sign."""
    some = loops.take(sectors.rows)
    low, high = (_slope(some.slopes(np.exp(end)[:, None]))[0][:, 0] for end in sectors.logs)
    inside = (low < 0.0) & (high > 0.0)
    sectors, some = sectors.where(inside), some.take(inside)

    def slope(which: Any, logs: Real) -> tuple[Real, Real]:
        first, second = _slope(some.take(which).slopes(np.exp(logs)[:, None]))
        return first[:, 0], second[:, 0]

    low, high = sectors.logs
    rising = np.ones(low.shape, dtype=bool)
    omega = np.exp(solve(slope, low, high, 0.5 * (low + high), rising))
    values = distance(*(part[:, 0] for part in some.gain_and_turns(omega[:, None])))
    return sectors.rows, values, omega


def _slope(at: Slopes) -> tuple[Real, Real]:
    """First two derivatives of ½·|1 + L|² by ln ω."""
    off = at.turns - np.rint(at.turns)
    value = -np.exp(at.gain) * (np.cos(_TURN * off) + 1j * np.sin(_TURN * off))
    first = at.first * value
    second = (at.second + at.first * at.first) * value
    other = np.conj(1.0 + value)
    return (first * other).real, (second * other).real + abs(first) ** 2
