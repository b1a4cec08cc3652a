"""min |1 + L| of many loops, and what is measured like it, by branch and bound.

On a piece of the axis where gain and phase are monotone L stays within a sector of a ring, whose
distance from −1 is a lower bound. Pieces that may hold less than the least value known are
divided until the sector is small; then the minimum that lies inside is solved for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .factored_loop import Real
from .many_crossings import AnyLoops, Pieces, solve
from .many_gain_and_phase import SAME, least
from .many_loops import Slopes

SMALL = 0.1
"""Size of a sector, relative to its distance from −1, at which it is no longer divided."""

_WIDEST = 0.3
_PARTS, _FEW = 8, 500  # of few sectors it is the calls that take time, not the places
_TURN = 2.0 * np.pi
_ROUNDS = 200
_GRIP = 1e-12
_NARROW = 1e-13
_LARGEST = 300.0  # nepers: twice that exp would not give


Ends = tuple[Real, Real]


class Measure(NamedTuple):
    """What is minimised: of ln |L| and turns, over sectors, and along the axis.

    Attributes
    ----------
    value : callable
        (gain, turns) to the value.
    nearest : callable
        (least gain, largest gain, least angle from −1 in turns) to the least value of a sector.
    size : callable
        Largest gain to the size of a sector, relative to that of its gain and turns.
    slope : callable
        Slopes to the first two derivatives by ln ω of a function that grows with the value.
    """

    value: Callable[[Real, Real], Real]
    nearest: Callable[[Real, Real, Real], Real]
    size: Callable[[Real], Real]
    slope: Callable[[Slopes], tuple[Real, Real]]


class _Sectors(NamedTuple):
    """Intervals of ln ω of loops `rows`, and gain and turns at both ends, (M,) each."""

    rows: Any
    logs: Ends
    gains: Ends
    turns: Ends

    def where(self, some: Any) -> _Sectors:
        ends = [(low[some], high[some]) for low, high in self[1:]]
        return _Sectors(self.rows[some], *ends)

    def split(self, logs: Real, gain: Real, turns: Real) -> _Sectors:
        """Return the parts of each, given what is at (M, P − 1) places within."""
        ends = []
        for (low, high), inner in zip(self[1:], (logs, gain, turns), strict=True):
            edges = np.concatenate([low[:, None], inner, high[:, None]], axis=1)
            ends.append((edges[:, :-1].ravel(), edges[:, 1:].ravel()))
        return _Sectors(np.repeat(self.rows, logs.shape[1] + 1), *ends)


def distance(gain: Real, turns: Real) -> Real:
    """Return |1 + L|, with |1 + L|² = (1 − |L|)² + 4·|L|·sin²(δ/2), δ the angle from −1."""
    half = np.sin(np.pi * (turns - np.rint(turns)))
    return np.hypot(np.expm1(gain), 2.0 * np.exp(0.5 * gain) * half)


def _nearest_distance(low: Real, high: Real, off: Real) -> Real:
    across = np.log(np.maximum(np.cos(_TURN * off), 0.0))
    return distance(np.minimum(np.maximum(across, low), high), off)


def _slope_of_distance(at: Slopes) -> tuple[Real, Real]:
    """First two derivatives of ½·|1 + L|² by ln ω."""
    off = at.turns - np.rint(at.turns)
    value = -np.exp(at.gain) * (np.cos(_TURN * off) + 1j * np.sin(_TURN * off))
    first = at.first * value
    second = (at.second + at.first * at.first) * value
    other = np.conj(1.0 + value)
    return (first * other).real, (second * other).real + abs(first) ** 2


DISTANCE = Measure(distance, _nearest_distance, np.exp, _slope_of_distance)


def quotient(gain: Real, turns: Real) -> Real:
    """Return |(1 + L)/(1 − L)|, which is |tanh(l/2)| with −L = e^l."""
    half = np.pi * (turns - np.rint(turns))
    x = np.sinh(0.5 * np.clip(gain, -_LARGEST, _LARGEST)) ** 2
    return np.asarray(np.sqrt((x + np.sin(half) ** 2) / (x + np.cos(half) ** 2)))


def _nearest_quotient(low: Real, high: Real, off: Real) -> Real:
    farther = np.maximum(abs(low), abs(high))
    nearer = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(abs(low), abs(high)))
    return np.minimum(quotient(nearer, off), quotient(farther, off))


def _slope_of_quotient(at: Slopes) -> tuple[Real, Real]:
    """First two derivatives of ln |tanh(l/2)| by ln ω."""
    log = np.clip(at.gain, -_LARGEST, _LARGEST) + 1j * _TURN * (at.turns - np.rint(at.turns))
    share = at.first / np.sinh(log)
    return share.real, (at.second / np.sinh(log) - share * share * np.cosh(log)).real


QUOTIENT = Measure(quotient, _nearest_quotient, np.ones_like, _slope_of_quotient)


def modulus(pieces: Pieces[Any], crossings: Ends, measure: Measure = DISTANCE) -> Ends:
    """Return the least value and its ω of each loop, (B,), 0 and inf where it is a limit.

    Parameters
    ----------
    pieces : Pieces
    crossings : (B, K) and (B, K) arrays
        ln |L| at phase crossovers, nan for none, and ω.
    measure : Measure, optional
        Default: |1 + L|.
    """
    loops = pieces.loops
    limits, places = _at_limits(loops, measure)
    ends = (pieces.omega == pieces.omega[:, :1]) | (pieces.omega == pieces.omega[:, -1:])
    found = np.where(ends, np.inf, measure.value(pieces.gain, pieces.turns))
    real = np.where(np.isnan(crossings[0]), np.inf, measure.value(crossings[0], np.zeros(1)))
    known, place = least(
        np.concatenate([limits, found, real], axis=1),
        np.concatenate([places, pieces.omega, crossings[1]], axis=1),
    )
    small = _small_sectors(loops, _sectors(pieces), (known, place), measure)
    rows, values, omega = _minima(loops, small, measure)
    better = values <= known[rows] * (1.0 + SAME)
    rows, values, omega = rows[better], values[better], omega[better]
    descending = np.argsort(-values, kind="stable")  # of several the last assigned stays
    rows = rows[descending]
    known[rows], place[rows] = values[descending], omega[descending]
    limit, at_limit = least(limits, places)
    reached = limit <= known * (1.0 + SAME)
    return np.where(reached, limit, known), np.where(reached, at_limit, place)


def _at_limits(loops: AnyLoops, measure: Measure) -> tuple[Real, Real]:
    """Return the value at ω = 0 and ω → ∞, and these places, (B, 2).

    Behind a delay L comes by −|L| again and again, while the gain tends to its limit.
    """
    low, high = loops.turns_at_limits
    high = np.where(loops.delay != 0, 0.0, high)
    values = [
        np.where(limit < np.inf, measure.value(np.fmin(limit, _LARGEST), turns), np.inf)
        for limit, turns in zip(loops.limits, (low, high), strict=True)
    ]
    return np.stack(values, axis=1), np.broadcast_to([0.0, np.inf], (len(loops), 2))


def _sectors(pieces: Pieces[Any]) -> _Sectors:
    logs = np.log(pieces.omega)
    rows, columns = np.nonzero(logs[:, 1:] > logs[:, :-1])
    ends = [
        (part[rows, columns], part[rows, columns + 1]) for part in (logs, pieces.gain, pieces.turns)
    ]
    return _Sectors(rows, *ends)


def _nearest(sectors: _Sectors, measure: Measure = DISTANCE) -> Real:
    """Return the least value over each sector."""
    turns = sectors.turns
    off = np.minimum(*(abs(end - np.rint(end)) for end in turns))
    passed = np.floor(np.maximum(*turns)) >= np.ceil(np.minimum(*turns))
    gains = sectors.gains
    return measure.nearest(np.minimum(*gains), np.maximum(*gains), np.where(passed, 0.0, off))


def _small_sectors(loops: AnyLoops, sectors: _Sectors, best: Ends, measure: Measure) -> _Sectors:
    """Return the sectors that may hold less than is known, divided until they are small.

    The least values known, and their places, are kept up to date.
    """
    known, place = best
    found = [sectors.where(slice(0, 0))]
    for _ in range(_ROUNDS):
        size, bar = measure.size(np.maximum(*sectors.gains)), known[sectors.rows]
        sectors = sectors.where(
            _nearest(sectors, measure) < bar - _GRIP * np.minimum(size, 1.0) * bar
        )
        if not sectors.rows.size:
            break
        size, bar = measure.size(np.maximum(*sectors.gains)), known[sectors.rows]
        (low, high), gains, turns = sectors[1:]
        spread = -np.expm1(-abs(gains[1] - gains[0])) + _TURN * abs(turns[1] - turns[0])
        small = spread <= np.minimum(SMALL * bar / size, _WIDEST)
        found.append(sectors.where(small))
        sectors = sectors.where(~small & (high - low > _NARROW))
        (low, high), parts = sectors.logs, _PARTS if sectors.rows.size < _FEW else 2
        inner = low[:, None] + np.multiply.outer(high - low, np.arange(1, parts) / parts)
        gain, turn = loops.take(sectors.rows).gain_and_turns(np.exp(inner))
        value = measure.value(gain, turn)
        np.minimum.at(known, sectors.rows, value.min(axis=1))
        at, column = np.nonzero(value == known[sectors.rows][:, None])
        place[sectors.rows[at]] = np.exp(inner[at, column])
        sectors = sectors.split(inner, gain, turn)
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


def _minima(loops: AnyLoops, sectors: _Sectors, measure: Measure) -> tuple[Any, Real, Real]:
    """Return rows, values and ω of the minima inside of sectors, where the slope changes sign."""
    some = loops.take(sectors.rows)
    low, high = (measure.slope(some.slopes(np.exp(end)[:, None]))[0][:, 0] for end in sectors.logs)
    inside = (low < 0.0) & (high > 0.0)
    sectors, some = sectors.where(inside), some.take(inside)

    def slope(which: Any, logs: Real) -> tuple[Real, Real]:
        first, second = measure.slope(some.take(which).slopes(np.exp(logs)[:, None]))
        return first[:, 0], second[:, 0]

    low, high = sectors.logs
    rising = np.ones(low.shape, dtype=bool)
    omega = np.exp(solve(slope, low, high, 0.5 * (low + high), rising))
    values = measure.value(*(part[:, 0] for part in some.gain_and_turns(omega[:, None])))
    return sectors.rows, values, omega
