"""Phase, delay and gain margins of many stable loops."""

from __future__ import annotations

from typing import Any

import numpy as np

from .factored_loop import Real
from .many_crossings import Pieces, solve, within
from .turning_points import TOUCH_TOLERANCE

SAME = 1e-13
"""Values this near, relative to one another, are equal but for rounding."""

_DECIBELS = 20.0 / np.log(10.0)


def least(margins: Real, places: Real) -> tuple[Real, Real]:
    """Return the smallest margin in each row, and the lowest place that has it.

    Both are (B, K); inf and nan where all margins are inf.
    """
    value = margins.min(axis=1, initial=np.inf)
    equal = margins <= value[:, None] * (1.0 + SAME)
    place = np.where(equal, places, np.inf).min(axis=1, initial=np.inf)
    return value, np.where(np.isfinite(value), place, np.nan)


def phase_and_delay(pieces: Pieces[Any]) -> dict[str, Real]:
    """Return phase and delay margins by name, angles in degrees, the rest in the loops' units."""
    omega, turns = pieces.crossovers
    none = np.isnan(omega)
    angle, crossover = least(np.where(none, np.inf, abs(turns - np.rint(turns))), omega)
    lag = 2.0 * np.pi * (turns - np.floor(turns)) / pieces.loops.radians(omega)
    delay, at_delay = least(np.where(none, np.inf, lag), omega)
    endless = pieces.loops.endless
    return {
        "phase_margin_deg": 360.0 * angle,
        "crossover_hz": crossover,
        "delay_margin_s": np.where(endless, 0.0, delay),
        "delay_margin_hz": np.where(endless, np.inf, at_delay),
    }


def gain_margins(pieces: Pieces[Any]) -> tuple[dict[str, Real], tuple[Real, Real]]:
    """Return both gain margins by name, and ln |L| and ω at the phase crossovers they are from.

    In a monotone piece on one side of |L| = 1, the nearest to 1 of the gains where L is real and
    negative is that of the first whole turn, counted from the end whose gain is nearer to 1.
    """
    parts = zip(_inside(pieces), at_edges(pieces), at_limits(pieces), strict=True)
    gain, omega = (np.concatenate(part, axis=1) for part in parts)
    return gain_margins_at(gain, omega), (gain, omega)


def gain_margins_at(gain: Real, omega: Real) -> dict[str, Real]:
    """Return both gain margins by name, of ln |L|, nan for none, and ω of phase crossovers."""
    margins: dict[str, Real] = {}
    for name, sign in (("lower", 1.0), ("upper", -1.0)):
        sizes = np.where(sign * gain > 0.0, sign * gain * _DECIBELS, np.inf)
        value, place = least(sizes, omega)
        margins |= {f"{name}_gain_margin_db": value, f"{name}_gain_margin_hz": place}
    return margins


def at_limits(pieces: Pieces[Any]) -> tuple[Real, Real]:
    """Return gain, nan for none, and ω of L real and negative at ω = 0 and ω → ∞.

    Behind a delay the phase comes by again and again, while the gain tends to its limit.
    """
    loops = pieces.loops
    low, high = (turns == np.floor(turns) for turns in loops.turns_at_limits)
    finite = (low & (loops.power == 0), (high | (loops.delay > 0)) & (loops.rise == 0))
    gains = [
        np.where(some, limit, np.nan) for some, limit in zip(finite, loops.limits, strict=True)
    ]
    places = np.broadcast_to([0.0, np.inf], (len(loops), 2))
    return np.stack(gains, axis=1), places


def at_edges(pieces: Pieces[Any]) -> tuple[Real, Real]:
    """Return gain, nan for none, and ω where the phase turns just on −180 degrees."""
    inside = (pieces.omega > pieces.omega[:, :1]) & (pieces.omega < pieces.omega[:, -1:])
    touching = 2.0 * np.pi * abs(pieces.turns - np.rint(pieces.turns)) <= TOUCH_TOLERANCE
    inside[:, 1:] &= ~pieces.jumping
    inside[:, :-1] &= ~pieces.jumping
    some = inside & touching
    columns = some.any(axis=0)
    return np.where(some, pieces.gain, np.nan)[:, columns], pieces.omega[:, columns]


def _inside(pieces: Pieces[Any]) -> tuple[Real, Real]:
    """Return gain, nan for none, and ω of the phase crossover of each piece nearest |L| = 1."""
    turns = with_limits(pieces)
    from_low = abs(pieces.gain[:, :-1]) <= abs(pieces.gain[:, 1:])
    low, high = turns[:, :-1], turns[:, 1:]
    start, stop = np.where(from_low, low, high), np.where(from_low, high, low)
    up = stop > start
    level = np.where(up, np.floor(start) + 1.0, np.ceil(start) - 1.0)
    some = np.where(up, level < stop, level > stop)
    endless = (pieces.omega == pieces.omega[:, -1:])[:, 1:] & (pieces.loops.delay > 0)[:, None]
    some &= (from_low | ~endless) & ~pieces.jumping
    gain, omega = np.full(some.shape, np.nan), np.full(some.shape, np.nan)
    rows, columns = np.nonzero(some)
    omega[rows, columns] = found = level_crossings(pieces, rows, columns, level[rows, columns])
    gain[rows, columns] = pieces.loops.take(rows).gain(found[:, None])[:, 0]
    return gain, omega


def with_limits(pieces: Pieces[Any]) -> Real:
    """Return the turns with their limits at the ends, which L comes near but does not reach."""
    low, high = pieces.loops.turns_at_limits
    turns = pieces.turns.copy()
    turns[:, 0] = low
    last = pieces.omega == pieces.omega[:, -1:]
    return np.where(last & (pieces.loops.delay == 0)[:, None], high[:, None], turns)


def level_crossings(pieces: Pieces[Any], rows: Any, columns: Any, level: Real) -> Real:
    """Return ω where the turns reach a level within a piece, (M,)."""
    some = pieces.loops.take(rows)
    low, high = (np.log(pieces.omega[rows, columns + k]) for k in (0, 1))
    at_low, at_high = (pieces.turns[rows, columns + k] - level for k in (0, 1))

    def excess(which: Any, logs: Real) -> tuple[Real, Real]:
        slopes = some.take(which).slopes(np.exp(logs)[:, None])
        return slopes.turns[:, 0] - level[which], slopes.first[:, 0].imag / (2.0 * np.pi)

    rising = at_high > at_low
    return np.exp(solve(excess, low, high, within(low, high, at_low, at_high), rising))
