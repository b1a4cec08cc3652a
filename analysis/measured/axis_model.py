"""The sampled response of an axis of low order by its numbers, and first guesses of them.

With modes of gain g_k = a_k·b_k (motor shape times load shape) and h_k = a_k²,

    F_lm = (1/s² + Σ g_k/D_k)/J,   F_mm = (1/s² + Σ h_k/D_k)/J,   D_k = s² + 2ζ_k·ω_k·s + ω_k²,
    G = F_lm/(1 + (v·s + k)·F_mm),

friction v and spring k acting on the motor.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import NamedTuple

import numpy as np

from .measured_response import MeasuredResponse
from .rational_fits import Complex, Mask, Real
from .vector_fit import mode_poles, real_least_squares, residues

_ALIASES = np.arange(-4, 5)
_REACHES = (3.0, 6.0, 12.0, 24.0)  # times the first line, where friction and spring are seen
_DELAYS = np.linspace(0.0, 2.0, 5)  # samples: first guesses
_MOTOR_SHAPES = 1.0  # standard deviation of ln(h/|g|), which data hardly tell

RIGID, PER_MODE = 4, 4
"""How many numbers stand before those of the modes, and how many each mode has."""


class Free(NamedTuple):
    """What acts on the motor besides its mass."""

    friction: bool
    spring: bool


@dataclass(frozen=True, eq=False)
class AxisModel:
    """An axis with so many modes against a measured plant.

    Its numbers x are ln 1/J, v/J, k/J and the delay, then ln ω, ζ, g and ln h of each mode.

    Attributes
    ----------
    measured : MeasuredResponse
    count : int
        Of modes.
    free : Free
    delay : float or None
        Where it is known.
    at_motor : bool
        Whether the sensor is there, so that h = g.
    """

    measured: MeasuredResponse
    count: int
    free: Free
    delay: float | None
    at_motor: bool

    @property
    def step(self) -> float:
        """Sample time, or a time that is short for the lines."""
        return self.measured.dt or 0.05 / float(self.measured.frequency_hz[-1])

    @property
    def edges(self) -> tuple[float, float]:
        """Least and largest ln ω of a mode: what lies far beyond the lines is not to be told."""
        low, high = np.log(2.0 * pi * self.measured.frequency_hz[[0, -1]]).tolist()
        return low - 1.0, high + 1.0

    @property
    def shaped(self) -> bool:
        """Whether motor shapes are numbers of their own."""
        return any(self.free) and not self.at_motor

    @cached_property
    def fitted(self) -> Mask:
        """Which of the numbers are fitted, as an array of bool."""
        own = [True, self.free.friction, self.free.spring, self.delay is None]
        return np.array(own + [True, True, True, self.shaped] * self.count)

    def response(self, x: Real) -> Complex:
        """Return the response on the lines, held, delayed and sampled.

        What the double integrator makes of it is exact, the rest a sum over a few aliases.
        """
        s: Complex = np.asarray(2j * pi * self.measured.frequency_hz)
        dt = self.measured.dt
        if dt is None:
            return np.asarray(self._continuous(s, x) * np.exp(-s * x[3]))
        steep = np.exp(x[0]) * (1.0 + x[RIGID + 2 :: PER_MODE].sum())
        shifted: Complex = s + 2j * pi / dt * _ALIASES[:, None]
        rest = self._continuous(shifted, x) - steep / shifted**2
        hold = (1.0 - np.exp(-s * dt)) / (shifted * dt) * np.exp(-shifted * x[3])
        return np.asarray(steep * _held_double_integrator(s, dt, x[3]) + (rest * hold).sum(axis=0))

    def _continuous(self, s: Complex, x: Real) -> Complex:
        free = 1.0 / s**2
        through, own = free.copy(), free
        for log_omega, zeta, gain, log_motor in x[RIGID:].reshape(-1, PER_MODE).tolist():
            omega = np.exp(log_omega)
            swing = 1.0 / (s * (s + 2.0 * zeta * omega) + omega**2)
            through += gain * swing
            own = own + (gain if self.at_motor else np.exp(log_motor)) * swing
        if not any(self.free):
            return np.asarray(np.exp(x[0]) * through)
        return np.asarray(np.exp(x[0]) * through / (1.0 + (x[1] * s + x[2]) * own))

    def residual(self, x: Real) -> Real:
        """Return what is left in standard deviations: real and imaginary parts, then of shapes."""
        off = (self.response(x) - self.measured.response) / self.measured.fits.sigma * np.sqrt(2.0)
        shapes = x[RIGID:].reshape(-1, PER_MODE)
        prior = shapes[:, 3] - np.log(abs(shapes[:, 2]) + 1e-12)
        return np.concatenate([off.real, off.imag, prior / _MOTOR_SHAPES * self.shaped])

    def starts(self) -> list[Real]:
        """Return first guesses, the best first: of the low lines that are used, then of delays."""
        delays = [self.delay] if self.delay is not None else (_DELAYS * self.step).tolist()
        usual = delays[len(delays) // 2]
        reaches = _REACHES if any(self.free) else _REACHES[:1]
        tried = {reach: self._guesses(usual, reach) for reach in reaches}
        reach = min(reaches, key=lambda each: min(map(self._off, tried[each])))
        others = [x for delay in delays if delay != usual for x in self._guesses(delay, reach)]
        return sorted([*tried[reach], *others], key=self._off)

    def _off(self, x: Real) -> float:
        return float((self.residual(x) ** 2).sum())

    def _guesses(self, delay: float, reach: float) -> list[Real]:
        """Return numbers by vector fitting, with a delay, friction and spring taken out."""
        s: Complex = np.asarray(2j * pi * self.measured.frequency_hz)
        behind = np.exp(-s * delay)
        if self.measured.dt is not None:
            behind = behind * (1.0 - np.exp(-s * self.step)) / (s * self.step)
        response = self.measured.response / behind
        weight = abs(behind) / self.measured.fits.sigma
        inertia, friction, spring = self._held_by(s, response, weight, reach)
        holds = friction * s + spring
        if self.at_motor:
            share = 1.0 - holds * response
            share = np.where(abs(share) > 1e-9, share, 1e-9)
            moving, weight = response / share, weight * abs(share) ** 2
        else:
            rigid = 1.0 + holds / (inertia * s**2)
            moving, weight = response * rigid, weight / np.maximum(abs(rigid), 1e-9)
        shape = (1.0 / s**2)[:, None]
        found = []
        for surplus in (0, 3) if self.count else (0,):
            poles = mode_poles(s, moving, weight, shape, self.count, surplus=surplus)
            size, gains = residues(s, moving, weight, shape, poles)
            size = size if size > 0.0 else 1.0 / inertia
            x = [np.log(size), friction / inertia, spring / inertia, delay]
            for pole, gain in zip(poles, gains / size, strict=True):
                damping = float(np.clip(-pole.real / abs(pole), 1e-4, 0.9))
                gain = max(gain, 1e-6) if self.at_motor else gain
                x += [
                    float(np.clip(np.log(abs(pole)), *self.edges)),
                    damping,
                    gain,
                    np.log(abs(gain) + 1e-9),
                ]
            found.append(np.array(x))
        return found

    def _held_by(
        self, s: Complex, response: Complex, weight: Real, reach: float
    ) -> tuple[float, float, float]:
        """Return inertia, friction and spring by 1/G = J·s² + v·s + k on the lowest lines."""
        low = np.flatnonzero(s.imag <= reach * s.imag[0])
        low = np.arange(max(6, len(low))) if len(low) < 6 else low
        terms = [
            (2, True),
            (1, self.free.friction),
            (0, self.free.spring),
            (3, len(low) > 16),
            (4, len(low) > 12),
        ]
        powers = [power for power, some in terms if some]
        rows = np.stack([s[low] ** power for power in powers], axis=1)
        by = (weight * abs(response) ** 2)[low]
        solved = real_least_squares(rows * by[:, None], by / response[low])
        numbers = dict(zip(powers, solved.tolist(), strict=True))
        inertia = numbers[2]
        if not inertia > 0.0:
            inertia = float(np.median(abs(1.0 / response[low] / s[low] ** 2)))
        return inertia, max(numbers.get(1, 0.0), 0.0), max(numbers.get(0, 0.0), 0.0)


def _held_double_integrator(s: Complex, dt: float, delay: float) -> Complex:
    """Return 1/s² behind a hold and a delay, sampled; the delay is d samples less λ."""
    whole = np.floor(delay / dt)
    rest = (whole + 1.0) * dt - delay
    q = np.exp(-s * dt)
    parts = dt**2 * q * (1.0 + q) / (1.0 - q) ** 2 + 2.0 * dt * rest * q / (1.0 - q) + rest**2
    return np.asarray(0.5 * np.exp(-s * (whole + 1.0) * dt) * parts)
