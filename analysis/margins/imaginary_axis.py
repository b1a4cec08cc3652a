"""Roots that belong on the imaginary axis, set there."""

from typing import Any

import numpy as np

from .factored_loop import Complex

_BESIDE = 1e-13
_MEAN = 1e-12
_MOST = 3


def set_on_axis(found: Complex) -> Complex:
    """Return rows of roots, those of a damping ratio below 1e-13 on the axis, (B, M).

    Rounding parts a root of multiplicity m by ε^(1/m), to both sides of the axis, and leaves the
    mean of the m where they were: doubles and triples of which it lies on the axis are put there.
    """
    beside = (abs(found.real) <= _BESIDE * abs(found)) & np.isfinite(found)
    found = np.where(beside, 1j * found.imag, found)
    for count in range(2, _MOST + 1):
        width = 8.0 * np.finfo(float).eps ** (1.0 / count)
        near = (abs(found.real) <= width * abs(found)) & (found.real != 0) & np.isfinite(found)
        [rows] = np.nonzero(near.sum(axis=1) >= count)
        if rows.size:
            found[rows] = _gathered(found[rows], near[rows], count, width)
    return found


def _gathered(found: Complex, near: Any, count: int, width: float) -> Complex:
    """Return roots, those near the axis at their mean if there are so many beside one another."""
    some = np.where(near, found, np.inf)
    with np.errstate(invalid="ignore"):
        together = abs(some[:, :, None] - some[:, None, :]) <= 2.0 * width * abs(some)[:, :, None]
    together &= near[:, :, None] & near[:, None, :]
    mean = np.where(together, found[:, None, :], 0.0).sum(axis=2) / count
    good = (together.sum(axis=2) == count) & (abs(mean.real) <= _MEAN * abs(mean))
    return np.where(good, 1j * mean.imag, found)
