"""Designing a multisine: a periodic excitation with power on chosen lines alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shaping import Limits, Trajectory
from ...shaping.checks import finite, positive, whole
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import real_array, shown
from ...shaping.told import Told
from .rational_fits import Real


@dataclass(frozen=True, eq=False, repr=False)
class Multisine(Told, Frozen):
    """One period of an excitation, w = Σ A·cos(2π·f·t + φ) over its lines, held a sample long.

    Attributes
    ----------
    values : (period,) array
        Torque or force, from sample to sample.
    frequency_hz : (N,) array
        The lines that hold power.
    dt : float
    crest_factor : float
        Peak over rms.
    inertia : float or None
        Of the axis whose motion was bounded.
    """

    values: Real
    frequency_hz: Real
    dt: float
    crest_factor: float
    inertia: float | None = None

    def repeated(self, periods: int) -> Real:
        """Return so many periods, one after the other."""
        return np.tile(self.values, whole("periods", periods, 1, 10**6))

    def motion(self, inertia: float | None = None) -> Trajectory:
        """Return the periodic motion of a free inertia under one period, in open loop."""
        mass = positive("inertia", self.inertia if inertia is None else inertia)  # type: ignore[arg-type]
        acceleration = self.values / mass
        gained = np.concatenate([[0.0], np.cumsum(acceleration) * self.dt])[:-1]
        velocity = gained - (gained + 0.5 * self.dt * acceleration).mean()
        steps = velocity * self.dt + 0.5 * self.dt**2 * acceleration
        position = np.concatenate([[0.0], np.cumsum(steps)])[:-1]
        breaks = self.dt * np.arange(len(acceleration) + 1)
        return Trajectory(breaks, np.stack([position, velocity, acceleration], axis=1))


def multisine(
    dt: float,
    period: int,
    *,
    band_hz: tuple[float, float],
    torque: float,
    odd: bool = False,
    left_out: bool = False,
    limits: Limits | None = None,
    inertia: float | None = None,
    weight: Any = None,
    tries: int = 50,
    seed: int = 0,
) -> Multisine:
    """Return a random-phase multisine of the largest size that keeps its bounds.

    Parameters
    ----------
    dt : float
        Sample time.
    period : int
        Samples in a period; lines are 1/(period·dt) apart.
    band_hz : (float, float)
        First and last frequency with power.
    torque : float
        Bound of |w|.
    odd : bool, optional
        Odd lines alone: what even nonlinearities make then falls between.
    left_out : bool, optional
        One random line of each group of three is left without power: what is found there is
        nonlinear distortion.
    limits : Limits, optional
        Of the motion, velocity and acceleration among them; needs the inertia.
    inertia : float, optional
        Of the free axis that moves.
    weight : callable, optional
        From frequencies in Hz to relative amplitudes of the lines. Default: all equal.
    tries : int, optional
        Random phases that are drawn, of which those with the lowest crest factor are taken.
    seed : int, optional
        Another one gives another realisation.

    Returns
    -------
    Multisine

    Raises
    ------
    ValueError
        For a band without lines, or limits without inertia.

    Examples
    --------
    >>> wave = multisine(1e-3, 1000, band_hz=(5.0, 200.0), torque=2.0, odd=True)
    >>> float(abs(wave.values).max()), len(wave.frequency_hz)
    (2.0, 98)
    """
    dt, torque = positive("dt", dt), positive("torque", torque)
    period = whole("period", period, 8, 10**8)
    if limits is not None and inertia is None:
        raise ValueError("limits without inertia: expected both; give inertia=… of the free axis")
    rng = np.random.default_rng(seed)
    lines = _lines(dt, period, band_hz, odd=odd)
    if left_out:
        lines = _thinned(lines, rng)
    hertz = lines / (period * dt)
    amplitude = np.ones(len(lines)) if weight is None else _weighted(weight, hertz)
    values = min(
        (_wave(lines, amplitude, period, rng) for _ in range(whole("tries", tries, 1, 10**5))),
        key=_crest,
    )
    values *= torque / abs(values).max()
    wave = Multisine(values, hertz, dt, _crest(values), inertia)
    if limits is None:
        return wave
    share = 1.0 / (1.0 + wave.motion().violation(limits))
    return Multisine(values * share, hertz, dt, wave.crest_factor, inertia)


def _lines(dt: float, period: int, band_hz: tuple[float, float], *, odd: bool) -> Any:
    if not isinstance(band_hz, Sequence) or len(band_hz) != 2:
        raise TypeError(
            f"band_hz = {shown(band_hz)}: expected the lowest and highest, (5.0, 200.0)"
        )
    low, high = (finite("band_hz", edge) for edge in band_hz)
    every = np.arange(1, (period + 1) // 2)
    hertz = every / (period * dt)
    inside = (hertz >= low * (1 - 1e-12)) & (hertz <= high * (1 + 1e-12))
    lines = every[inside & ((every % 2 == 1) | (not odd))]
    if len(lines) < 2:
        raise ValueError(
            f"band_hz = {low:g} to {high:g} holds {len(lines)} lines of {1 / (period * dt):g} Hz "
            f"distance below {0.5 / dt:g} Hz: expected two or more; make the period longer"
        )
    return lines


def _weighted(weight: Any, hertz: Real) -> Real:
    """Return the relative amplitudes of the lines."""
    if not callable(weight):
        raise TypeError(
            f"weight = {shown(weight)}: expected a function from frequencies in Hz to relative "
            "amplitudes, such as lambda f: 1 / f"
        )
    found = real_array("weight(frequencies)", weight(hertz))
    if found.shape != hertz.shape or not np.isfinite(found).all() or not found.any():
        raise ValueError(
            f"weight of {len(hertz)} frequencies gives {shown(found)}: expected as many finite "
            "amplitudes, not all 0"
        )
    return found


def _thinned(lines: Any, rng: np.random.Generator) -> Any:
    kept = np.ones(len(lines), dtype=bool)
    for start in range(0, len(lines) - 2, 3):
        kept[start + rng.integers(3)] = False
    return lines[kept]


def _wave(lines: Any, amplitude: Real, period: int, rng: np.random.Generator) -> Real:
    spectrum = np.zeros(period // 2 + 1, dtype=complex)
    spectrum[lines] = amplitude * np.exp(2j * np.pi * rng.random(len(lines)))
    return np.fft.irfft(spectrum, period)


def _crest(values: Real) -> float:
    return float(abs(values).max() / np.sqrt((values**2).mean()))
