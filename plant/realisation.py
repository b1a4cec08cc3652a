"""Wind and noise as one of their possible courses over time, the same for the same seed."""

from __future__ import annotations

from math import ceil

import numpy as np

from ..shaping.checks import of_kind, positive, whole
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import shown
from .disturbances import SampledTorque, Wind
from .spectrum import Folded, Spectrum

_MOST = 10**8


def wind_realisation(
    wind: Wind | Spectrum, duration: float, dt: float, *, seed: int
) -> SampledTorque:
    """Return a random course of a wind's torque, or of one of a spectrum, held between samples.

    A sum of sines over a period of twice the duration, with normally distributed amplitudes whose
    variances are the spectrum's: Gaussian, and with the wind's spectrum up to the frequency
    1/(2·dt). What the wind has above is left out; `ServoLoop.deviations` has all of it.

    Parameters
    ----------
    wind : Wind or Spectrum
    duration, dt : float
        Length and spacing of the samples, positive.
    seed : int
        From 0 on.

    Returns
    -------
    SampledTorque

    Examples
    --------
    >>> breeze = Wind("von_karman", 50.0, length_over_speed=5.0)
    >>> course = wind_realisation(breeze, 100.0, 0.01, seed=1)
    >>> len(course.torques), course.on
    (10000, 'load')
    """
    of_kind("wind", wind, Wind | Spectrum, "Wind(kind, sigma, …) or Spectrum(…)")  # type: ignore[arg-type]
    dt, length = positive("dt", dt), positive("duration", duration)
    if length > _MOST * dt:
        raise ValueError(
            f"dt = {shown(dt)} makes {length / dt:.3g} samples: use at most {_MOST:.0e}"
        )
    count = ceil(length / dt * (1.0 - 1e-12))
    torques = _course(wind, count, dt, seed)
    return SampledTorque(dt * np.arange(float(count)), torques, on=wind.on)


def noise_realisation(noise: Spectrum, samples: int, dt: float, *, seed: int) -> FloatArray:
    """Return random errors of an encoder at its samples, for `ServoLoop.respond(…, noise=…)`.

    As `wind_realisation`, with what is above half the sample rate folded down, as samples see it:
    their variance is that of the whole spectrum.

    Parameters
    ----------
    noise : Spectrum
        Of the measured position.
    samples : int
        How many, as `respond` asks for: one each dt before the end of the response.
    dt : float
        Sample time in s, positive.
    seed : int
        From 0 on.

    Returns
    -------
    (samples,) array
        In the unit of the measured position.

    Raises
    ------
    ValueError, TypeError
        For a spectrum, number of samples, sample time or seed of another kind.

    Examples
    --------
    >>> errors = noise_realisation(Spectrum([1.0, 500.0], [1e-14, 1e-14]), 1000, 1e-3, seed=1)
    >>> errors.shape
    (1000,)
    """
    of_kind("noise", noise, Spectrum, "Spectrum(frequencies_hz, densities)")
    count = whole("samples", samples, 1, _MOST)
    return _course(Folded(noise, positive("dt", dt)), count, dt, seed)


def _course(random: Wind | Spectrum | Folded, count: int, dt: float, seed: int) -> FloatArray:
    """Return a course of a spectrum at samples."""
    rng = np.random.default_rng(whole("seed", seed, 0, 2**63 - 1))
    f = np.fft.rfftfreq(2 * count, dt)
    sizes = np.sqrt(random.spectrum(f) * f[1])
    sizes[0] = 0.0  # a constant is no part of it
    amplitudes = sizes * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    return np.asarray(count * np.fft.irfft(amplitudes, 2 * count)[:count])
