"""Wind as one of its possible courses over time, the same for the same seed."""

from __future__ import annotations

from math import ceil

import numpy as np

from ..shaping.checks import of_kind, positive, whole
from .disturbances import SampledTorque, Wind

_MOST = 10**8


def wind_realisation(wind: Wind, duration: float, dt: float, *, seed: int) -> SampledTorque:
    """Return a random course of a wind's torque, held from sample to sample.

    A sum of sines over a period of twice the duration, with normally distributed amplitudes whose
    variances are the spectrum's: Gaussian, and with the wind's spectrum up to the frequency
    1/(2·dt). What the wind has above is left out; `ServoLoop.deviations` has all of it.

    Parameters
    ----------
    wind : Wind
    duration, dt : float
        Length and spacing of the samples, positive.
    seed : int
        From 0 on.

    Examples
    --------
    >>> breeze = Wind("von_karman", 50.0, length_over_speed=5.0)
    >>> course = wind_realisation(breeze, 100.0, 0.01, seed=1)
    >>> len(course.torques), course.on
    (10000, 'load')
    """
    of_kind("wind", wind, Wind, "Wind(kind, sigma, …)")
    dt, length = positive("dt", dt), positive("duration", duration)
    if length > _MOST * dt:
        raise ValueError(f"dt = {dt!r} makes {length / dt:.3g} samples: use at most {_MOST:.0e}")
    count = ceil(length / dt * (1.0 - 1e-12))
    rng = np.random.default_rng(whole("seed", seed, 0, 2**63 - 1))
    f = np.fft.rfftfreq(2 * count, dt)
    sizes = np.sqrt(wind.spectrum(f) * f[1])
    sizes[0] = 0.0  # a constant is no part of it
    amplitudes = sizes * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    torques = count * np.fft.irfft(amplitudes, 2 * count)[:count]
    return SampledTorque(dt * np.arange(float(count)), torques, on=wind.on)
