"""Loops given by their roots, in the form of many loops given by coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .factored_loop import DAMPING_FLOOR, Complex, FactoredLoop, Real, is_stable, radians
from .many_loops import Mask, Slopes
from .turning_points import TOUCH_TOLERANCE, turning_points

_BESIDE = 1e-11
_FAR = 1e8
_HIGHEST = 1e90
_MOST = 600.0
_TURN = 2.0 * np.pi


class Roots:
    """What is known of R loops before any frequency is: all alike, but for where their roots lie.

    Attributes
    ----------
    loops : (R,) array of FactoredLoop
        With as many zeros and poles, at 0 and elsewhere, and samples of delay each.
    zeros, poles : (R, M) and (R, N) arrays of complex
        Those other than 0.
    power, rise : float
        The powers of s that L tends to at low and at high frequencies.
    delay, scale : (R, 1) arrays
        As a loop has them.
    levels : two (R,) arrays
        ln |c| of the asymptotes c·s^power and c·s^rise.
    all : (M + N, R, 1) array of complex
        Zeros and poles.
    signs : (M + N, 1, 1) array
        1 for each zero and −1 for each pole among them.
    offset : (R,) array
        Turns of what is neither s − z, s − p nor a delay.
    ends : two (R,) arrays
        Frequencies below and above which L is its asymptote, every |L| = 1 between them.
    """

    def __init__(self, loops: Sequence[FactoredLoop]) -> None:
        self.loops = np.empty(len(loops), dtype=object)
        self.loops[:] = loops
        found = [[part[part != 0] for part in (each.zeros, each.poles)] for each in loops]
        self.zeros, self.poles = (np.array([each[k] for each in found]) for k in (0, 1))
        first, (_, m), (_, n) = loops[0], self.zeros.shape, self.poles.shape
        self.samples, self.is_discrete = first.samples, first.dt is not None
        self.power = float(first.zeros.size - m - first.poles.size + n)
        self.rise = float(first.zeros.size - first.poles.size)
        self.delay, self.scale = (
            np.array([[getattr(each, name)] for each in loops]) for name in ("delay", "scale")
        )
        gains = np.array([each.gain for each in loops])
        size, logs = np.log(abs(gains)), [np.log(abs(part)) for part in (self.zeros, self.poles)]
        self.levels = (size + (_total(logs[0].T) - _total(logs[1].T)), size)
        self.offset = 0.5 + 0.25 * self.power + 0.5 * (gains < 0)
        self.all = np.concatenate([self.zeros, self.poles], axis=1).T[..., None]
        self.signs = np.repeat([1.0, -1.0], [m, n])[:, None, None]
        self.ends = self._ends()

    def take(self, rows: Any) -> Roots:
        """Return those of some of the loops."""
        some = copy(self)
        for name in ("loops", "zeros", "poles", "delay", "scale", "offset"):
            setattr(some, name, getattr(self, name)[rows])
        some.all = self.all[:, rows]
        some.levels, some.ends = ((low[rows], high[rows]) for low, high in (self.levels, self.ends))
        return some

    def turned(self, omega: Real) -> Real:
        """Return the turns of all s − z less those of all s − p, and those of the samples.

        Those of each are continuous; a root on the axis is passed on its right.
        """
        left = np.arctan2(omega - self.all.imag, abs(self.all.real))
        angles = np.where(self.all.real > 0, np.pi - left, left)
        lag = self.samples / np.pi * np.arctan(omega * self.scale)
        return np.asarray(_total(self.signs * angles) / _TURN - lag)

    def _ends(self) -> tuple[Real, Real]:
        lag = np.tile(1.0 / self.scale, abs(self.samples))
        sizes = np.concatenate([abs(self.zeros), abs(self.poles), lag], axis=1)
        corners = [
            np.exp(-level / slope)
            for level, slope in zip(self.levels, (self.power, self.rise), strict=True)
            if slope
        ]
        if self.delay.any():
            corners.append(1.0 / abs(self.delay[:, 0]))
        if sizes.shape[1]:
            lows, highs = [*corners, 1.0 / _total(1.0 / sizes.T)], [*corners, _total(sizes.T)]
        else:
            lows = highs = corners or [np.ones(len(self.scale))]
        low, high = np.min(lows, axis=0) / _FAR, np.max(highs, axis=0) * _FAR
        return np.maximum(low, 1.0 / _HIGHEST), np.minimum(high, _HIGHEST)


def _total(terms: Any) -> Any:
    """Return the sum over the first axis, one after the other, whatever the others are."""
    if not len(terms):
        return np.zeros(terms.shape[1:])
    return np.add.accumulate(terms, axis=0)[-1]


@dataclass(frozen=True, eq=False)
class RootedLoops:
    """B loops, or B copies of one, with the values of `Loops`, from roots and not coefficients.

    No product is expanded, so that a root on the axis, or beside it, keeps every digit. What is
    asked of it means what it does of `Loops`.

    Attributes
    ----------
    roots : Roots
        Of B loops, or of one.
    count : int
        B.
    """

    roots: Roots
    count: int = 1

    def __len__(self) -> int:
        return self.count

    def take(self, rows: Any) -> RootedLoops:
        """Return some of the loops."""
        if len(self.roots.loops) > 1:
            some = self.roots.take(rows)
            return RootedLoops(some, len(some.loops))
        if isinstance(rows, np.ndarray):
            count = int(np.count_nonzero(rows)) if rows.dtype == bool else rows.size
        else:
            count = len(np.arange(self.count)[rows])
        return RootedLoops(self.roots, count)

    def inverse(self) -> RootedLoops:
        """Return 1/L."""
        return RootedLoops(Roots([_turned(loop) for loop in self.roots.loops]), self.count)

    @property
    def loop(self) -> FactoredLoop:
        """The one loop, poles on the axis that a zero cancels among its hidden ones."""
        loop: FactoredLoop = self.roots.loops[0]
        return loop

    @property
    def zeros(self) -> Complex:
        """Those other than 0, (B, M)."""
        return self._each(self.roots.zeros)

    @property
    def poles(self) -> Complex:
        """Those other than 0, (B, N)."""
        return self._each(self.roots.poles)

    @property
    def delay(self) -> Real:
        """τ, (B,)."""
        return self._each(self.roots.delay[:, 0])

    @property
    def power(self) -> Real:
        """The power of s that L tends to at low frequencies, (B,)."""
        return np.full(self.count, self.roots.power)

    @property
    def rise(self) -> Real:
        """The power of s that L tends to at high frequencies, (B,)."""
        return np.full(self.count, self.roots.rise)

    @property
    def hidden(self) -> Mask:
        """Whether there is a mode that no feedback can move and that does not die, (B,)."""
        return self._each(np.array([not is_stable(each.hidden) for each in self.roots.loops]))

    @property
    def beside(self) -> float:
        """How near to a root of the axis a frequency is beside it, relative."""
        return _BESIDE

    @property
    def endless(self) -> Mask:
        """Whether L stands no delay at all, (B,): |L| ≥ 1 as ω → ∞, in continuous time."""
        return np.asarray((self.limits[1] >= -TOUCH_TOLERANCE) & (not self.roots.is_discrete))

    @property
    def ends(self) -> tuple[Real, Real]:
        """Frequencies below and above which L is its asymptote, every |L| = 1 between them."""
        return self._each(self.roots.ends[0]), self._each(self.roots.ends[1])

    @property
    def limits(self) -> tuple[Real, Real]:
        """Return ln |L| at ω = 0 and ω → ∞, (B,)."""
        (low, high), power, rise = self.roots.levels, self.roots.power, self.roots.rise
        low = np.full_like(low, -np.inf * power) if power else low
        return self._each(low), self._each(np.full_like(high, np.inf * rise) if rise else high)

    @cached_property
    def turns_at_limits(self) -> tuple[Real, Real]:
        """Return the turns at ω = 0 and those of the rational part at ω → ∞, exact quarters."""
        low, high = (
            self.roots.offset + 0.25 * np.rint(4.0 * self.roots.turned(np.array([[end]]))[:, 0])
            for end in (0.0, np.inf)
        )
        return self._each(low), self._each(high)

    def radians(self, omega: Real) -> Real:
        """Return frequencies of all loops, (B, K), or of the one in rad/s."""
        if len(self.roots.loops) == 1:
            return self.loop.radians(omega)
        dt = np.array([[loop.dt] for loop in self.roots.loops]) if self.roots.is_discrete else None
        return radians(omega, self.roots.scale, dt)

    def turning_points(self) -> tuple[Real, Real]:
        """Return ω, among them all where the gain turns, and where the phase does, (B, K)."""
        gain, phase = turning_points(list(self.roots.loops))
        return self._each(_filled(gain)), self._each(_filled(phase))

    def gain(self, omega: Real) -> Real:
        """Return ln |L(jω)| at (B, K) frequencies."""
        total = self.roots.levels[1][:, None] + self.roots.power * np.log(omega)
        apart = np.hypot(omega - self.roots.all.imag, self.roots.all.real)
        total = total + _total(self.roots.signs * np.log(apart))
        return np.asarray(np.minimum(np.maximum(total, -_MOST), _MOST))

    def gain_and_turns(self, omega: Real) -> tuple[Real, Real]:
        """Return ln |L(jω)| and its turns at (B, K) frequencies."""
        turns = self.roots.turned(omega) + self.roots.offset[:, None]
        return self.gain(omega), turns - omega * (self.roots.delay / _TURN)

    def slopes(self, omega: Real) -> Slopes:
        """Return everything at (B, K) frequencies."""
        s, roots = 1j * omega, self.roots
        second: Any = -s * roots.delay
        lag = s * roots.scale
        lagging = -2.0 * roots.samples * lag / (1.0 - lag * lag)
        share = s / (s - roots.all)
        first = roots.power + second + lagging + _total(roots.signs * share)
        second = second + lagging * (1.0 + lag * lag) / (1.0 - lag * lag)
        second = second + _total(roots.signs * (share * (1.0 - share)))
        return Slopes(*self.gain_and_turns(omega), first, second)

    def _each(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return what the roots have of each loop, or of the one, for all B."""
        return np.broadcast_to(values, (self.count, *values.shape[1:]))


def _turned(loop: FactoredLoop) -> FactoredLoop:
    """Return 1/L."""
    turned = replace(loop, zeros=loop.poles, poles=loop.zeros, gain=1.0 / loop.gain)
    return replace(turned, delay=-loop.delay, samples=-loop.samples)


def _filled(rows: list[Real]) -> Real:
    """Return rows of different lengths as one array, nan at their ends."""
    filled = np.full((len(rows), max(row.size for row in rows)), np.nan)
    for k, row in enumerate(rows):
        filled[k, : row.size] = row
    return filled


def rooted(*loops: FactoredLoop) -> RootedLoops:
    """Return loops that are alike, the poles on the axis that a zero cancels hidden."""
    return RootedLoops(Roots(list(map(without_cancelled, loops))), len(loops))


def alike(loop: FactoredLoop) -> tuple[Any, ...]:
    """Return what loops must have in common to be looked at together."""
    at_zero = [int(np.count_nonzero(part == 0)) for part in (loop.zeros, loop.poles)]
    timing = loop.samples, loop.dt is None, loop.delay > 0.0
    return loop.zeros.size, loop.poles.size, *at_zero, *timing


def without_cancelled(loop: FactoredLoop) -> FactoredLoop:
    """Return a loop with the poles on the axis that a zero cancels among its hidden ones."""
    zeros, hidden = list(loop.zeros), list(loop.hidden)
    poles: list[complex] = []
    for pole in loop.poles:
        near = [z for z in zeros if pole.real == 0 and abs(z - pole) <= DAMPING_FLOOR * abs(pole)]
        if near:
            zeros.remove(near[0])
        (hidden if near else poles).append(pole)
    left, right, apart = (np.array(part, complex) for part in (zeros, poles, hidden))
    return replace(loop, zeros=left, poles=right, hidden=apart)
