"""One motion over a leg on a mesh of equal cells, in the time of the leg: what is linear in it."""

from __future__ import annotations

from functools import lru_cache
from math import comb, factorial

import numpy as np

from ..pieces import FloatArray

CELLS = 8
"""Cells of a leg, along each of which the highest derivative is constant."""


@lru_cache(maxsize=16)
def mesh_rows(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the states and the highest derivatives of the cells lead to.

    On a leg of duration 1, from n states at its start and the derivative n along the cells.

    Returns
    -------
    end : (n, n + CELLS) array
        State at the end.
    bounded : (rows, n + CELLS) array
        Values between whose extremes a derivative stays: the Bernstein coefficients of every
        derivative on every cell.
    derivative : (rows,) array
        Which derivative each is of.
    """
    states, dt = _states(n), 1.0 / CELLS
    rows, kinds = [], []
    for cell in range(CELLS):
        taylor = np.vstack([states[cell], np.eye(n + CELLS)[n + cell]])
        for r in range(1, n + 1):
            q = n - r
            for j in range(1, q + 1) if q else (0,):
                weights = [comb(j, i) / comb(q, i) * dt**i / factorial(i) for i in range(j + 1)]
                rows.append(weights @ taylor[r : r + j + 1])
                kinds.append(r)
    return states[-1], np.array(rows), np.array(kinds)


def _states(n: int) -> FloatArray:
    """Return the states at the cells' edges, (CELLS + 1, n, n + CELLS)."""
    dt = 1.0 / CELLS
    step = [
        [dt ** (j - i) / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)
    ]
    gain = [dt ** (n - i) / factorial(n - i) for i in range(n)]
    states = np.zeros((CELLS + 1, n, n + CELLS))
    states[0, :, :n] = np.eye(n)
    for cell in range(CELLS):
        states[cell + 1] = np.array(step) @ states[cell]
        states[cell + 1, :, n + cell] += gain
    return states
