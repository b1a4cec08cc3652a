"""Polynomials on cells in Bernstein form: between the least and greatest of their coefficients."""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np

from ..pieces import FloatArray, RealArray

_PARTS = 8
_LEVELS = 8
_UNDECIDED = 1e-10  # of the whole integral: what is left uncertain about the sign of p


@lru_cache(maxsize=256)
def elevation(low: int, high: int) -> FloatArray:
    """Return the matrix from coefficients of degree `low` to those of degree `high`."""
    rows = [
        [
            comb(low, i) * comb(high - low, j - i) / comb(high, j) if j - i >= 0 else 0.0
            for i in range(low + 1)
        ]
        for j in range(high + 1)
    ]
    return np.array(rows)


def signed_areas(pieces: RealArray) -> tuple[RealArray, RealArray]:
    """Return upper bounds on ∫ max(p, 0) and ∫ max(−p, 0) over each cell, (N,) each.

    A cell is cut into eighths until its coefficients have one sign or what remains in doubt is
    nothing beside the whole.

    Parameters
    ----------
    pieces : (d + 1, N) array
        Bernstein coefficients of p on every cell, times the cell's length over d + 1: their sum
        is the integral.
    """
    count = pieces.shape[1]
    owner = np.arange(count)
    positive: RealArray = np.zeros(count, pieces.dtype)
    negative: RealArray = np.zeros(count, pieces.dtype)
    whole = np.abs(pieces.sum(axis=0)).sum()
    for level in range(_LEVELS + 1):
        up, down = np.maximum(pieces, 0.0).sum(axis=0), np.maximum(-pieces, 0.0).sum(axis=0)
        mixed = np.minimum(up, down) > 0.0
        if np.minimum(up, down).sum() <= _UNDECIDED * whole or level == _LEVELS:
            mixed[:] = False
        np.add.at(positive, owner[~mixed], up[~mixed])
        np.add.at(negative, owner[~mixed], down[~mixed])
        if not mixed.any():
            break
        pieces, owner = _cut(pieces[:, mixed]), np.tile(owner[mixed], _PARTS)
    return positive, negative


def _cut(pieces: RealArray) -> RealArray:
    """Return the forms of the first eighths of all cells, then of the next, times their length."""
    d = len(pieces) - 1
    parts = (_eighths(d) @ pieces).reshape(_PARTS, d + 1, -1)
    return parts.transpose(1, 0, 2).reshape(d + 1, -1)


@lru_cache(maxsize=64)
def _eighths(d: int) -> RealArray:
    """Return the matrix to an eighth of the coefficients on all eighths: exact numbers."""
    left = np.array([[comb(i, j) / 2.0 ** (i + 1) for j in range(d + 1)] for i in range(d + 1)])
    halves = (left, left[::-1, ::-1])
    return np.vstack([c @ b @ a for a in halves for b in halves for c in halves]).astype(
        np.longdouble
    )
