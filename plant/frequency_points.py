"""Frequencies at which a loop is looked at: spread over its own, and dense at its resonances."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import control

_PER_DECADE = 120
_BEYOND = 1e3
_FARTHEST = 1e6
_LIGHT = 0.3  # damping ratio below which a root makes a resonance of its own
_BESIDE = np.sinh(np.linspace(-6.0, 6.0, 61))


def frequency_points(
    system: control.StateSpace | control.TransferFunction, delay: float
) -> NDArray[np.float64]:
    """Return frequencies in rad/s, ascending, from far below to far above those of a loop.

    Those of its poles and zeros and of the delay count; of a discrete loop they end at half the
    sampling frequency. Undamped ones are passed close by on both sides: there G is 0 or infinite.
    """
    poles, zeros = _roots(system)
    farthest = _FARTHEST * abs(poles).max(initial=0.0) or np.inf
    roots = np.concatenate([poles, zeros[abs(zeros) < farthest]])  # beyond, they are rounding
    if system.isdtime(strict=True):
        with np.errstate(divide="ignore"):
            roots = np.log(roots[roots != 0.0].astype(complex)) / system.dt
    own = abs(roots)
    least = 1e-9 * own.max(initial=0.0)
    own = own[own > least]
    ends = [pi / system.dt] if system.isdtime(strict=True) else []
    centers = np.concatenate([own, ends, [1.0 / delay] if delay else []])
    if not centers.size:
        centers = np.ones(1)
    top = ends[0] if ends else centers.max() * _BEYOND
    bottom = centers.min() / _BEYOND
    count = max(2, int(_PER_DECADE * np.log10(top / bottom)))
    points = [np.geomspace(bottom, top, count)]
    for root in roots[(roots.imag > 0.0) & (abs(roots.real) < _LIGHT * abs(roots))]:
        least_width = 1e-6 * abs(root)
        around = root.imag + max(abs(root.real), least_width) * _BESIDE
        points.append(around if abs(root.real) > least_width else around[_BESIDE != 0.0])
    omega = np.unique(np.concatenate(points))
    return np.asarray(omega[(omega >= bottom) & (omega <= top)])


def _roots(system: Any) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return poles and zeros, those of polynomials without a word on coefficients of rounding."""
    if hasattr(system, "den_array"):
        below, above = system.den_array[0, 0], system.num_array[0, 0]
        return np.roots(below).astype(complex), np.roots(above).astype(complex)
    return system.poles(), system.zeros()
