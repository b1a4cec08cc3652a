"""An open-loop transfer as zeros, poles, gain and delay, and its values on the imaginary axis."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Real = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

LOWEST, HIGHEST = 1e-100, 1e100
"""Scaled frequencies that stand for the limits ω = 0 and ω → ∞."""

DAMPING_FLOOR = 1e-10
"""A closed-loop pole whose damping ratio is not above this counts as undamped."""


@dataclass(frozen=True, eq=False)
class FactoredLoop:
    """L = gain·Π(s − zeros)/Π(s − poles)·e^(−s·delay), in units of `scale` rad/s.

    `closed` are the roots of 1 + L without the delay; `hidden` the modes that no chain of
    coefficients joins to both input and output: they count in stability alone.

    A loop that is discrete in time, with a sampling time `dt` in seconds, is kept on the plane of
    w = (z − 1)/(z + 1), whose imaginary axis is the unit circle: with s = w all of this holds,
    and ω stands for (2/dt)·arctan(ω·scale) rad/s. The limit ω → ∞ is half the sampling frequency.
    Whole `samples` of delay are a factor z^(−samples) = ((1 − w)/(1 + w))^samples of their own, so
    that the longest is no polynomial; `closed` are the roots of 1 + L with it.
    """

    zeros: Complex
    poles: Complex
    gain: float
    closed: Complex
    hidden: Complex
    scale: float = 1.0
    delay: float = 0.0
    dt: float | None = None
    samples: int = 0

    def radians(self, omega: Real) -> Real:
        """Return scaled frequencies in rad/s; at the limits 0, and inf or half the sampling's."""
        return radians(omega, self.scale, self.dt)

    def hertz(self, omega: float) -> float:
        """Return a scaled frequency in Hz."""
        return float(self.radians(np.array(omega))) / (2 * np.pi)

    def log_gain(self, omega: Real) -> Real:
        """Return ln |L(jω)|, kept finite on zeros and poles of the axis."""
        s = 1j * omega[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            total = np.log(abs(self.gain)) + np.log(abs(s - self.zeros)).sum(axis=1)
            total = total - np.log(abs(s - self.poles)).sum(axis=1)
        # Held where exp gives a huge but finite number, and 0; fmin takes nan for a pole.
        return np.asarray(np.fmax(np.fmin(total, 600.0), -800.0))

    def phase(self, omega: Real) -> Real:
        """Return the continuous arg L(jω) in rad, with jumps of π only at roots on the axis."""
        turn = _arguments(omega, self.zeros) - _arguments(omega, self.poles)
        lag = omega * self.delay + 2.0 * self.samples * np.arctan(omega * self.scale)
        return np.asarray(turn + (np.pi if self.gain < 0 else 0.0) - lag)

    def values(self, omega: Real) -> Complex:
        """Return L(jω)."""
        return np.asarray(np.exp(self.log_gain(omega) + 1j * self.phase(omega)))

    def at(self, s: Complex) -> Complex:
        """Return L(s) anywhere."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            logs = np.log(s[:, None] - self.zeros).sum(axis=1)
            logs = logs - np.log(s[:, None] - self.poles).sum(axis=1) - s * self.delay
            return np.asarray(self.gain * np.exp(logs))

    def closed_loop_poles(self) -> Complex:
        """Return every pole of the closed loop without its delay, the slowest decay first.

        In rad/s; of a discrete loop as z.
        """
        poles = np.concatenate([self.closed, self.hidden]) * self.scale
        if self.dt is None:
            return np.asarray(poles[np.argsort(-poles.real, kind="stable")])
        poles = (1 + poles) / (1 - poles)
        return np.asarray(poles[np.argsort(-abs(poles), kind="stable")])


def radians(omega: Real, scale: Any, dt: Any) -> Real:
    """Return frequencies in units of `scale` in rad/s, with `dt` those of the plane of w."""
    scaled = np.where(omega == HIGHEST, np.inf, omega * scale)
    real = scaled if dt is None else 2.0 / dt * np.arctan(scaled)
    return np.asarray(np.where(omega == LOWEST, 0.0, real))


def is_stable(poles: Complex) -> bool:
    """Whether every pole has a damping ratio above `DAMPING_FLOOR`."""
    return bool(np.all(-poles.real > DAMPING_FLOOR * abs(poles)))


def _arguments(omega: Real, roots: Complex) -> Real:
    """Sum of arg(jω − r) over the roots."""
    angle = np.arctan2(omega[:, None] - roots.imag, abs(roots.real))
    return np.asarray(np.where(roots.real > 0, np.pi - angle, angle).sum(axis=1))
