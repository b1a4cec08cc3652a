"""The largest gain of a stable system over frequency."""

from __future__ import annotations

from math import inf, nan, pi
from typing import Any, NamedTuple

import numpy as np

from ..plant.frequency_points import frequency_points
from ..shaping.pieces import FloatArray

_ZOOMS = 6
_CLOSER = np.linspace(0.0, 1.0, 33)


class PeakGain(NamedTuple):
    """max |G(jω)|, or |G(e^(jω·dt))|, and the frequency in Hz where it is reached.

    An improper system grows for ever: value inf, frequency nan.
    """

    value: float
    frequency_hz: float


def peak_gain(system: Any) -> PeakGain:
    """Return the peak gain of a stable python-control system with one input and one output.

    From points that are dense at its resonances, the largest of them zoomed in on: to 1e-12 of
    the peak where the points see it, as they do for any damping above 1e-6.
    """
    if _is_improper(system):
        return PeakGain(inf, nan)
    omega = frequency_points(system, 0.0)
    gains = gains_at(system, omega)
    k = int(gains.argmax())
    low, high = omega[max(k - 1, 0)], omega[min(k + 1, len(omega) - 1)]
    best, place = float(gains[k]), float(omega[k])
    for _ in range(_ZOOMS):
        closer = low + (high - low) * _CLOSER
        gains = gains_at(system, closer)
        k = int(gains.argmax())
        if gains[k] > best:
            best, place = float(gains[k]), float(closer[k])
        low, high = closer[max(k - 1, 0)], closer[min(k + 1, len(closer) - 1)]
    if system.isdtime(strict=True) and place > omega[-1] * (1.0 - 1e-6):
        place = float(omega[-1])
    return PeakGain(best, place / (2.0 * pi))


def gains_at(system: Any, omega: FloatArray) -> FloatArray:
    """Return |G| at frequencies in rad/s."""
    s = 1j * omega
    points = np.exp(s * system.dt) if system.isdtime(strict=True) else s
    return np.asarray(np.abs(np.atleast_1d(system(points))), dtype=float)


def _is_improper(system: Any) -> bool:
    above, below = getattr(system, "num_array", None), getattr(system, "den_array", None)
    if above is None or below is None:
        return False
    return len(np.trim_zeros(above[0, 0], "f")) > len(np.trim_zeros(below[0, 0], "f"))
