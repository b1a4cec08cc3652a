"""Matrices in units of the states, powers of two, in which rows and columns match."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import core
from ..shaping.pieces import FloatArray


def balanced(a: Any) -> tuple[FloatArray, FloatArray]:
    """Return D⁻¹·A·D and the diagonal of D, exact but for overflow.

    Parameters
    ----------
    a : (n, n) array

    References
    ----------
    Parlett and Reinsch, Numerische Mathematik 13 (1969) 293-304, with Euclidean norms.

    Examples
    --------
    >>> balanced([[0.0, 1024.0], [1.0, 0.0]])[0].tolist()
    [[0.0, 32.0], [32.0, 0.0]]
    """
    matrix = np.array(a, dtype=float, order="C")
    scale = np.ones(len(matrix))
    core.balance(matrix, scale)
    return matrix, scale


def balanced_norm(a: FloatArray) -> float:
    """Return the largest sum of magnitudes of a column, after balancing."""
    return float(np.abs(balanced(a)[0]).sum(axis=0).max(initial=0.0))
