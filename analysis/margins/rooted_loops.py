"""One loop given by its roots, as often as asked for, in the form of many loops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from .factored_loop import DAMPING_FLOOR, Complex, FactoredLoop, Real, is_stable
from .many_loops import Mask, Slopes
from .turning_points import TOUCH_TOLERANCE, phase_points, stationary_points

_BESIDE = 1e-11
_FAR = 1e8
_HIGHEST = 1e90
_MOST = 600.0
_TURN = 2.0 * np.pi


class Roots:
    """What is known of a loop before any frequency is.

    Attributes
    ----------
    loop : FactoredLoop
    zeros, poles : (M,) and (N,) arrays of complex
        Those other than 0.
    power, rise : float
        The powers of s that L tends to at low and at high frequencies.
    levels : tuple of float
        ln |c| of the asymptotes c·s^power and c·s^rise.
    all : array of complex
        Zeros and poles.
    signs : array
        1 for each zero and −1 for each pole among them.
    offset : float
        Turns of what is neither s − z, s − p nor a delay.
    ends : tuple of float
        Frequencies below and above which L is its asymptote, every |L| = 1 between them.
    """

    def __init__(self, loop: FactoredLoop) -> None:
        self.loop = loop
        self.zeros, self.poles = (part[part != 0] for part in (loop.zeros, loop.poles))
        self.power = float(loop.zeros.size - self.zeros.size - loop.poles.size + self.poles.size)
        self.rise = float(loop.zeros.size - loop.poles.size)
        size = float(np.log(abs(loop.gain)))
        ratio = float(np.log(abs(self.zeros)).sum() - np.log(abs(self.poles)).sum())
        self.levels = (size + ratio, size)
        self.offset = 0.5 + 0.25 * self.power + 0.5 * (loop.gain < 0)
        self.all = np.concatenate([self.zeros, self.poles])
        self.signs = np.repeat([1.0, -1.0], [self.zeros.size, self.poles.size])
        self.ends = self._ends()

    def turned(self, omega: Real) -> Real:
        """Return the turns of all s − z less those of all s − p, and those of the samples.

        Those of each are continuous; a root on the axis is passed on its right.
        """
        left = np.arctan2(omega[..., None] - self.all.imag, abs(self.all.real))
        angles = np.where(self.all.real > 0, np.pi - left, left)
        lag = self.loop.samples / np.pi * np.arctan(omega * self.loop.scale)
        return np.asarray(angles @ self.signs / _TURN - lag)

    def _ends(self) -> tuple[float, float]:
        lag = np.full(abs(self.loop.samples), 1.0 / self.loop.scale)
        sizes = abs(np.concatenate([self.zeros, self.poles, lag]))
        corners = [
            float(np.exp(-level / slope))
            for level, slope in zip(self.levels, (self.power, self.rise), strict=True)
            if slope
        ]
        corners += [1.0 / abs(self.loop.delay)] if self.loop.delay else []
        lows = [*corners, 1.0 / float(np.sum(1.0 / sizes))] if sizes.size else corners or [1.0]
        highs = [*corners, float(sizes.sum())] if sizes.size else corners or [1.0]
        return max(min(lows) / _FAR, 1.0 / _HIGHEST), min(max(highs) * _FAR, _HIGHEST)


@dataclass(frozen=True, eq=False)
class RootedLoops:
    """B copies of one loop, with the values that `Loops` has, from roots in place of coefficients.

    No product is expanded, so that a root on the axis, or beside it, keeps every digit. What is
    asked of it means what it does of `Loops`.

    Attributes
    ----------
    roots : Roots
    count : int
        B.
    """

    roots: Roots
    count: int = 1

    def __len__(self) -> int:
        return self.count

    def take(self, rows: Any) -> RootedLoops:
        """Return some of the loops."""
        if isinstance(rows, np.ndarray):
            count = int(np.count_nonzero(rows)) if rows.dtype == bool else rows.size
        else:
            count = len(np.arange(self.count)[rows])
        return RootedLoops(self.roots, count)

    def inverse(self) -> RootedLoops:
        """Return 1/L."""
        loop = self.loop
        turned = replace(loop, zeros=loop.poles, poles=loop.zeros, gain=1.0 / loop.gain)
        turned = replace(turned, delay=-loop.delay, samples=-loop.samples)
        return RootedLoops(Roots(turned), self.count)

    @property
    def loop(self) -> FactoredLoop:
        """The loop itself, poles on the axis that a zero cancels among its hidden ones."""
        return self.roots.loop

    @property
    def zeros(self) -> Complex:
        """Those other than 0, (B, M)."""
        return np.tile(self.roots.zeros, (self.count, 1))

    @property
    def poles(self) -> Complex:
        """Those other than 0, (B, N)."""
        return np.tile(self.roots.poles, (self.count, 1))

    @property
    def delay(self) -> Real:
        """τ, (B,)."""
        return np.full(self.count, self.loop.delay)

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
        return np.full(self.count, not is_stable(self.loop.hidden))

    @property
    def beside(self) -> float:
        """How near to a root of the axis a frequency is beside it, relative."""
        return _BESIDE

    @property
    def endless(self) -> Mask:
        """Whether L stands no delay at all, (B,): |L| ≥ 1 as ω → ∞, in continuous time."""
        return np.asarray((self.limits[1] >= -TOUCH_TOLERANCE) & (self.loop.dt is None))

    @property
    def ends(self) -> tuple[Real, Real]:
        """Frequencies below and above which L is its asymptote, every |L| = 1 between them."""
        return self._rows(self.roots.ends[0]), self._rows(self.roots.ends[1])

    @property
    def limits(self) -> tuple[Real, Real]:
        """Return ln |L| at ω = 0 and ω → ∞, (B,)."""
        (low, high), power, rise = self.roots.levels, self.roots.power, self.roots.rise
        low = -np.inf * power if power else low
        return self._rows(low), self._rows(np.inf * rise if rise else high)

    @cached_property
    def turns_at_limits(self) -> tuple[Real, Real]:
        """Return the turns at ω = 0 and those of the rational part at ω → ∞, exact quarters."""
        quarters = np.rint(4.0 * self.roots.turned(np.array([0.0, np.inf])))
        low, high = self.roots.offset + 0.25 * quarters
        return self._rows(low), self._rows(high)

    def radians(self, omega: Real) -> Real:
        """Return frequencies in rad/s."""
        return self.loop.radians(omega)

    def turning_points(self) -> tuple[Real, Real]:
        """Return ω, among them all where the gain turns, and where the phase does, (B, K)."""
        loop = self.loop
        gain = stationary_points(loop.zeros, loop.poles)
        phase = phase_points(loop.zeros, loop.poles, loop.delay, (loop.samples, loop.scale))
        return self._rows(gain), self._rows(phase)

    def gain(self, omega: Real) -> Real:
        """Return ln |L(jω)| at (B, K) frequencies."""
        total = self.roots.levels[1] + self.roots.power * np.log(omega)
        apart = np.hypot(omega[..., None] - self.roots.all.imag, self.roots.all.real)
        total = total + np.log(apart) @ self.roots.signs
        return np.asarray(np.minimum(np.maximum(total, -_MOST), _MOST))

    def gain_and_turns(self, omega: Real) -> tuple[Real, Real]:
        """Return ln |L(jω)| and its turns at (B, K) frequencies."""
        turns = self.roots.turned(omega) + self.roots.offset
        return self.gain(omega), turns - omega * (self.loop.delay / _TURN)

    def slopes(self, omega: Real) -> Slopes:
        """Return everything at (B, K) frequencies."""
        s = 1j * omega
        second: Any = -s * self.loop.delay
        lag = s * self.loop.scale
        lagging = -2.0 * self.loop.samples * lag / (1.0 - lag * lag)
        share = s[..., None] / (s[..., None] - self.roots.all)
        first = self.roots.power + second + lagging + share @ self.roots.signs
        second = second + lagging * (1.0 + lag * lag) / (1.0 - lag * lag)
        second = second + (share * (1.0 - share)) @ self.roots.signs
        return Slopes(*self.gain_and_turns(omega), first, second)

    def _rows(self, values: Any) -> Any:
        return np.full((self.count, *np.shape(values)), values)


def rooted(loop: FactoredLoop) -> RootedLoops:
    """Return one loop, the poles on the axis that a zero cancels put among its hidden ones."""
    zeros, hidden = list(loop.zeros), list(loop.hidden)
    poles: list[complex] = []
    for pole in loop.poles:
        near = [z for z in zeros if pole.real == 0 and abs(z - pole) <= DAMPING_FLOOR * abs(pole)]
        if near:
            zeros.remove(near[0])
        (hidden if near else poles).append(pole)
    left, right, apart = (np.array(part, complex) for part in (zeros, poles, hidden))
    return RootedLoops(Roots(replace(loop, zeros=left, poles=right, hidden=apart)))
