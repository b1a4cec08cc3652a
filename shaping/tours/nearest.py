"""When motions of several axes are nearest to a place, and how far from it they go."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.polynomial import polynomial

from ..pieces import INVERSE_FACTORIALS, FloatArray
from ..trajectory import Trajectory


def approaches(
    axes: Sequence[Trajectory], place: FloatArray, begin: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Return the times at which the distance from a place may be extreme, and those distances.

    They are the zeros of its square's derivative, a polynomial on every piece, and the ends.
    """
    inside = [one.breaks[(one.breaks > begin) & (one.breaks < end)] for one in axes]
    edges = np.unique(np.concatenate([[begin, end], *inside]))
    times = [edges]
    for left, right in itertools.pairwise(edges):
        times.append(_stationary(axes, place, float(left), float(right)))
    found = np.sort(np.concatenate(times))
    off = [one(found) - x for one, x in zip(axes, place.tolist(), strict=True)]
    return found, np.asarray(np.linalg.norm(off, axis=0))


def _stationary(
    axes: Sequence[Trajectory], place: FloatArray, left: float, right: float
) -> FloatArray:
    slope = np.zeros(1)
    for one, x in zip(axes, place.tolist(), strict=True):
        state = one.evaluate(left)
        state[0] -= x
        powers = (right - left) ** np.arange(len(state))
        off = state * powers * INVERSE_FACTORIALS[: len(state)]
        slope = polynomial.polyadd(slope, polynomial.polymul(off, polynomial.polyder(off)))
    roots = polynomial.polyroots(polynomial.polytrim(slope, np.abs(slope).max() * 1e-15))
    real = roots.real[np.abs(roots.imag) < 1e-6]
    return left + (right - left) * real[(real > 0.0) & (real < 1.0)]
