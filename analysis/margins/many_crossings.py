"""Where the gains of many loops cross 1, and which of them are stable.

Between the frequencies where its gain or its phase turns both are monotone, so that each piece
holds at most one crossing of a level: it is bracketed, and solved for on L(jω) itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from .factored_loop import DAMPING_FLOOR, Real
from .many_loops import Loops, Mask
from .many_turning_points import packed
from .rooted_loops import RootedLoops
from .turning_points import TOUCH_TOLERANCE

AnyLoops = Loops | RootedLoops
Kind = TypeVar("Kind", bound=AnyLoops)

Function = Callable[[Any, Real], tuple[Real, Real]]

_LIGHT = 0.3
_NEAR = 0.1
_SAME = 1e-12
_STEPS = 100
_LAST_STEP = 1e-10
_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class Pieces(Generic[Kind]):
    """The frequency axis of B loops in pieces on which gain and phase are monotone.

    Attributes
    ----------
    loops : Loops or RootedLoops
    omega, gain, turns : (B, K) arrays
        Frequencies, ascending, the last one repeated; ln |L|, 0 on a crossover, and turns there.
    crossing : (B, K) array of bool
        Where |L| = 1.
    """

    loops: Kind
    omega: Real
    gain: Real
    turns: Real
    crossing: Mask

    def take(self, rows: Any) -> Pieces[Kind]:
        """Return those of some of the loops."""
        loops: Any = self.loops.take(rows)
        return Pieces(loops, *(getattr(self, field.name)[rows] for field in fields(self)[1:]))

    @cached_property
    def jumping(self) -> Mask:
        """Which pieces hold a zero or pole on the axis, where the phase jumps, (B, K − 1)."""
        holding = np.zeros((len(self.omega), self.omega.shape[1] - 1), dtype=bool)
        for place in beside_axis(self.loops)[0].T:
            above = self.omega > place[:, None]
            holding |= above[:, 1:] & ~above[:, :-1]
        return holding

    @cached_property
    def crossovers(self) -> tuple[Real, Real]:
        """Return ω, nan for none, and turns at all |L| = 1, 0 and ∞ included, (B, C)."""
        omega = np.where(self.crossing, self.omega, np.nan)
        limits = [
            np.where(abs(limit) <= TOUCH_TOLERANCE, place, np.nan)[:, None]
            for limit, place in zip(self.loops.limits, (0.0, np.inf), strict=True)
        ]
        low, high = self.loops.turns_at_limits
        turns = np.concatenate([low[:, None], self.turns, high[:, None]], axis=1)
        return np.concatenate([limits[0], omega, limits[1]], axis=1), turns


OnePieces = Pieces[RootedLoops]


def pieces_of(loops: Kind) -> Pieces[Kind]:
    """Return the frequency axis of each loop in monotone pieces, split at crossovers."""
    omega = _edges(loops)
    gain = _with_limits(loops, omega, loops.gain(omega))
    inside = (omega > omega[:, :1]) & (omega < omega[:, -1:])
    sides = np.sign(gain)
    turning = np.zeros_like(inside)
    turning[:, 1:-1] = sides[:, :-2] == sides[:, 2:]
    near = abs(gain) <= TOUCH_TOLERANCE
    touching = inside & turning & near
    # A limit of 1 is told as a crossover itself, what rounding makes of it is none beside it.
    sides[touching | (~inside & near)] = 0.0
    changes = sides[:, :-1] * sides[:, 1:] < 0
    found = _gain_crossings(loops, omega, gain, changes)
    merged = np.concatenate([omega, found], axis=1)
    order = np.argsort(merged, axis=1)
    crossing = np.concatenate([touching | (inside & (sides == 0.0)), np.isfinite(found)], axis=1)
    merged, crossing = (np.take_along_axis(part, order, axis=1) for part in (merged, crossing))
    merged = np.where(np.isfinite(merged), merged, omega[:, -1:])
    gain, turns = loops.gain_and_turns(merged)
    gain = np.where(crossing, 0.0, _with_limits(loops, merged, gain))
    return Pieces(loops, merged, gain, turns, crossing)


def stable(pieces: Pieces[Any]) -> Mask:
    """Return which closed loops are stable, (B,): Nyquist's criterion, counted without a grid.

    L encircles −1 as often as it passes the axis beyond it. Where |L| > 1 from one frequency to
    another, how often is the difference of the whole turns at the two; poles on the axis are
    passed on their right.
    """
    loops = pieces.loops
    low, high = loops.turns_at_limits
    whole = np.floor(pieces.turns)
    # On the real axis at either end of the contour, half of a passage belongs to its other half.
    for column, end in ((0, low - 0.25 * loops.power), (-1, high - 0.25 * loops.rise)):
        whole[:, column] = np.where(end == np.floor(end), end - 0.5, np.floor(end))
    beyond = pieces.gain[:, :-1] + pieces.gain[:, 1:] > 0
    encirclements = 2.0 * (np.diff(whole, axis=1) * beyond).sum(axis=1)
    unstable = (loops.poles.real > 0).sum(axis=1) - encirclements
    omega, turns = pieces.crossovers
    distance = 2.0 * np.pi * abs(turns - np.rint(turns))
    on_axis = ~np.isnan(omega) & (distance <= DAMPING_FLOOR)
    endless = (loops.delay > 0) & loops.endless
    return np.asarray((unstable == 0) & ~on_axis.any(axis=1) & ~endless & ~loops.hidden)


def solve(function: Function, low: Real, high: Real, start: Real, rising: Mask) -> Real:
    """Return the root of a function of ln ω in each bracket, (M,): Newton's, within brackets.

    Parameters
    ----------
    function : callable
        (rows, x) to values and slopes, `rows` saying which of the M functions.
    low, high, start : (M,) arrays
        Brackets, and where to begin.
    rising : (M,) array of bool
        Whether the function is negative at `low` and positive at `high`.
    """
    low, high, x = low.copy(), high.copy(), start.copy()
    before = np.full(len(x), np.inf)
    rows = np.arange(len(x))
    for _ in range(_STEPS):
        if not rows.size:
            break
        here = x[rows]
        value, slope = function(rows, here)
        below = (value < 0.0) == rising[rows]
        low[rows], high[rows] = np.where(below, here, low[rows]), np.where(below, high[rows], here)
        step = -value / slope
        target = here + step
        last = abs(step) <= _LAST_STEP
        good = (target >= low[rows]) & (target <= high[rows]) & (abs(value) < 0.8 * before[rows])
        middle = 0.5 * (low[rows] + high[rows])
        target = np.where(last, np.clip(target, low[rows], high[rows]), target)
        x[rows] = np.where(value == 0.0, here, np.where(last | good, target, middle))
        before[rows] = abs(value)
        rows = rows[~last & (value != 0.0) & (abs(x[rows] - here) > _ROUNDING)]
    return x


def within(low: Real, high: Real, at_low: Real, at_high: Real) -> Real:
    """Return where a straight line between the ends of each bracket is zero."""
    share = at_low / (at_low - at_high)
    return low + np.clip(share, 0.02, 0.98) * (high - low)


def _gain_crossings(loops: AnyLoops, omega: Real, gain: Real, changes: Mask) -> Real:
    """Return the crossovers between edges, (B, K − 1), nan where there is none."""
    found = np.full(changes.shape, np.nan)
    rows, columns = np.nonzero(changes)
    some = loops.take(rows)
    low, high = np.log(omega[rows, columns]), np.log(omega[rows, columns + 1])
    at_low, at_high = gain[rows, columns], gain[rows, columns + 1]

    def excess(which: Any, logs: Real) -> tuple[Real, Real]:
        slopes = some.take(which).slopes(np.exp(logs)[:, None])
        return slopes.gain[:, 0], slopes.first[:, 0].real

    start = within(low, high, at_low, at_high)
    found[rows, columns] = np.exp(solve(excess, low, high, start, at_low < 0.0))
    return found[:, changes.any(axis=0)]


def _with_limits(loops: AnyLoops, omega: Real, gain: Real) -> Real:
    """Return the gain with its limits at the first and last frequency, where they are finite."""
    low, high = loops.limits
    first = (omega == omega[:, :1]) & (loops.power == 0)[:, None]
    last = (omega == omega[:, -1:]) & (loops.rise == 0)[:, None]
    return np.where(first, low[:, None], np.where(last, high[:, None], gain))


def _edges(loops: AnyLoops) -> Real:
    """Return frequencies between which gain and phase are monotone, (B, K), the ends included."""
    low, high = (end[:, None] for end in loops.ends)
    of_gain, of_phase = loops.turning_points()
    inner = np.concatenate(
        [
            _polished(loops, np.concatenate([of_gain, _resonances(loops)], axis=1), of_phase=False),
            _polished(loops, of_phase, of_phase=True),
        ],
        axis=1,
    )
    inner = np.sort(inner, axis=1)
    inner[:, 1:] = np.where(np.diff(inner) <= _SAME * inner[:, 1:], np.nan, inner[:, 1:])
    axis, near = beside_axis(loops)
    for place, off in zip(axis.T, near.T, strict=True):
        inner = np.where(abs(inner - place[:, None]) < off[:, None], np.nan, inner)
    inner = np.concatenate([inner, axis - near, axis + near], axis=1)
    inner = packed(np.where((inner > low) & (inner < high), inner, np.nan))
    return np.concatenate([low, np.where(np.isfinite(inner), inner, high), high], axis=1)


def beside_axis(loops: AnyLoops) -> tuple[Real, Real]:
    """Return ω of the zeros and poles on the axis, each once, else nan, and how far is beside.

    Nothing but the root lies so near: a quarter of the way to the next one, at the most.
    """
    found = np.concatenate([loops.zeros, loops.poles], axis=1)
    axis = packed(np.where((found.real == 0.0) & (found.imag > 0.0), found.imag, np.nan))
    if axis.shape[1] > 1:
        axis[:, 1:] = np.where(np.diff(axis, axis=1) == 0.0, np.nan, axis[:, 1:])
        axis = packed(axis)
    gaps = np.diff(axis, axis=1)
    none = np.full((len(axis), min(1, axis.shape[1])), np.nan)
    sides = [np.concatenate(part, axis=1) for part in ([none, gaps], [gaps, none])]
    return axis, np.fmin(loops.beside * axis, 0.25 * np.fmin(*sides))


def _resonances(loops: AnyLoops) -> Real:
    """Return ω of lightly damped zeros and poles, nan for none.

    Their peaks are too narrow for roots of a polynomial whose other roots are decades away.
    """
    found = np.concatenate([loops.zeros, loops.poles], axis=1)
    light = (found.imag > 0.0) & (abs(found.real) <= _LIGHT * found.imag)
    return packed(np.where(light, found.imag, np.nan))


def _polished(loops: AnyLoops, omega: Real, *, of_phase: bool) -> Real:
    """Return frequencies after Newton steps towards where the gain or the phase turns."""
    for _ in range(2):
        slopes = loops.slopes(omega)
        first, second = (
            part.imag if of_phase else part.real for part in (slopes.first, slopes.second)
        )
        step = -first / second
        omega = np.where(abs(step) < _NEAR, omega * np.exp(step), omega)
    return omega
