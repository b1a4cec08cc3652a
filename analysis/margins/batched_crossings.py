"""Where the gains of many loops cross 1, and which of them are stable.

Between the frequencies where its gain or its phase turns both are monotone, so that each piece
holds at most one crossing of a level: it is bracketed, and solved for on L(jω) itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from .batched_loops import BESIDE, Loops, Mask
from .batched_roots import product, roots, summed
from .crossings import TOUCH_TOLERANCE
from .factored_loop import DAMPING_FLOOR, Real

Function = Callable[[Any, Real], tuple[Real, Real]]

_REAL = 1e-2
_LIGHT = 0.3
_NEAR = 0.1
_STEPS = 100
_LAST_STEP = 1e-10
_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class Pieces:
    """The frequency axis of B loops in pieces on which gain and phase are monotone.

    Attributes
    ----------
    loops : Loops
    omega, gain, turns : (B, K) arrays
        Frequencies, ascending, the last one repeated; ln |L|, 0 on a crossover, and turns there.
    crossing : (B, K) array of bool
        Where |L| = 1.
    """

    loops: Loops
    omega: Real
    gain: Real
    turns: Real
    crossing: Mask

    def take(self, rows: Any) -> Pieces:
        """Return those of some of the loops."""
        parts = [getattr(self, field.name)[rows] for field in fields(self)[1:]]
        return Pieces(self.loops.take(rows), *parts)

    @cached_property
    def axis(self) -> Real:
        """Frequencies of zeros and poles on the axis, else nan, (B, R)."""
        return _on_axis(self.loops)

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


def pieces_of(loops: Loops) -> Pieces:
    """Return the frequency axis of each loop in monotone pieces, split at crossovers."""
    omega = _edges(loops)
    gain = _with_limits(loops, omega, loops.gain(omega))
    inside = (omega > omega[:, :1]) & (omega < omega[:, -1:])
    sides = np.sign(gain)
    turning = np.zeros_like(inside)
    turning[:, 1:-1] = sides[:, :-2] == sides[:, 2:]
    touching = inside & turning & (abs(gain) <= TOUCH_TOLERANCE)
    sides[touching] = 0.0
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


def stable(pieces: Pieces) -> Mask:
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
    endless = (loops.delay > 0) & (loops.limits[1] >= -TOUCH_TOLERANCE)
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


def _gain_crossings(loops: Loops, omega: Real, gain: Real, changes: Mask) -> Real:
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


def _with_limits(loops: Loops, omega: Real, gain: Real) -> Real:
    """Return the gain with its limits at the first and last frequency, where they are finite."""
    low, high = loops.limits
    first = (omega == omega[:, :1]) & (loops.power == 0)[:, None]
    last = (omega == omega[:, -1:]) & (loops.rise == 0)[:, None]
    return np.where(first, low[:, None], np.where(last, high[:, None], gain))


def _edges(loops: Loops) -> Real:
    """Return frequencies between which gain and phase are monotone, (B, K), the ends included."""
    low, high = (end[:, None] for end in loops.ends)
    of_gain, of_phase = (_real_roots(row) for row in _turning(loops))
    axis = _on_axis(loops)
    points = [
        _polished(loops, np.concatenate([of_gain, _resonances(loops)], axis=1), of_phase=False),
        _polished(loops, of_phase, of_phase=True),
        *(axis * (1.0 - BESIDE), axis * (1.0 + BESIDE)),
    ]
    inner = np.concatenate(points, axis=1)
    inner = _packed(np.where((inner > low) & (inner < high), inner, np.nan))
    return np.concatenate([low, np.where(np.isfinite(inner), inner, high), high], axis=1)


def _turning(loops: Loops) -> tuple[Real, Real]:
    """Return polynomials in ω², of all frequencies where the gain turns, and where the phase."""
    (n, n_turn), (d, d_turn) = (_squares(part) for part in (loops.numerator, loops.denominator))
    of_gain = product(n, d, lambda i, j: loops.power + (i - j))
    of_phase = summed(
        product(n_turn, d),
        product(-d_turn, n),
        -loops.delay[:, None] * product(n, d),
    )
    return of_gain, of_phase


def _squares(rows: Real) -> tuple[Real, Real]:
    """Return |P|² and |P|²·d(arg P)/dω as polynomials of x = ω².

    With P = e(x) + jω·o(x) they are e² + x·o² and e·o + 2x·(o'e − o·e').
    """
    signs = (-1.0) ** np.arange(rows.shape[1])
    even, odd = rows[:, 0::2] * signs[: -(-rows.shape[1] // 2)], rows[:, 1::2]
    odd = odd * signs[: odd.shape[1]]
    shifted = np.concatenate([np.zeros((len(rows), 1)), product(odd, odd)], axis=1)
    turn = product(odd, even, lambda i, j: 1.0 + 2.0 * (i - j))
    return summed(product(even, even), shifted), turn


def _real_roots(rows: Real) -> Real:
    """Return ω of the positive real roots in ω², nan for none."""
    squares = roots(rows)
    real = (squares.real > 0.0) & (abs(squares.imag) <= _REAL * squares.real)
    return _packed(np.sqrt(np.where(real, squares.real, np.nan)))


def _resonances(loops: Loops) -> Real:
    """Return ω of lightly damped zeros and poles, nan for none.

    Their peaks are too narrow for roots of a polynomial whose other roots are decades away.
    """
    found = np.concatenate([loops.zeros, loops.poles], axis=1)
    light = (found.imag > 0.0) & (abs(found.real) <= _LIGHT * found.imag)
    return _packed(np.where(light, found.imag, np.nan))


def _packed(omega: Real) -> Real:
    """Return rows with all nan at their ends, and no column of nothing else."""
    omega = np.sort(omega, axis=1)
    return omega[:, np.isfinite(omega).any(axis=0)]


def _polished(loops: Loops, omega: Real, *, of_phase: bool) -> Real:
    """Return frequencies after Newton steps towards where the gain or the phase turns."""
    for _ in range(2):
        slopes = loops.slopes(omega)
        first, second = (
            part.imag if of_phase else part.real for part in (slopes.first, slopes.second)
        )
        step = -first / second
        omega = np.where(abs(step) < _NEAR, omega * np.exp(step), omega)
    return omega


def _on_axis(loops: Loops) -> Real:
    found = np.concatenate([loops.zeros, loops.poles], axis=1)
    return _packed(np.where((found.real == 0.0) & (found.imag > 0.0), found.imag, np.nan))
