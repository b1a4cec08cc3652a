"""What the inputs of the cells do to the states: at the nodes, between them, and on average."""

from __future__ import annotations

from math import comb

import numpy as np

from ..pieces import INVERSE_FACTORIALS, FloatArray


def node_maps(nodes: FloatArray, order: int) -> FloatArray:
    """Return the maps S[k, i, j] from inputs u_j to derivative k at node i.

        x^(k)(t_i) = Σ_j u_j·[(t_i − t_j)₊^m − (t_i − t_{j+1})₊^m] / m!,   m = n − k

    Parameters
    ----------
    nodes : (N + 1,) array
        Increasing from 0; x^(n) = u_j between nodes j and j + 1.
    order : int
        n.

    Returns
    -------
    (n + 1, N + 1, N) array
        For k = n the input just after the node; after the last node zero.
    """
    since = np.maximum(nodes[:, None] - nodes[None, :], 0.0)
    maps = np.zeros((order + 1, len(nodes), len(nodes) - 1))
    power = np.ones_like(since)
    for k in range(order - 1, -1, -1):
        power = power * since
        maps[k] = (power[:, :-1] - power[:, 1:]) * INVERSE_FACTORIALS[order - k]
    np.fill_diagonal(maps[order], 1.0)
    return maps


def bernstein_rows(maps: FloatArray, cells: FloatArray, k: int) -> FloatArray:
    """Return the maps to the Bernstein coefficients 1…d of derivative k on every cell.

    Its values on a cell lie between the least and the greatest of them; coefficient 0 is the
    last one of the cell before.

    Returns
    -------
    (d·N, N) array
        d = n − k, the first coefficient of every cell, then the second, …
    """
    taylor = _taylor(maps, cells, k)
    d = len(taylor) - 1
    basis = np.array([[comb(j, i) / comb(d, i) for i in range(d + 1)] for j in range(1, d + 1)])
    return np.tensordot(basis, taylor, axes=1).reshape(-1, len(cells))


def greville_rows(maps: FloatArray, cells: FloatArray, k: int) -> FloatArray:
    """Return the maps to derivative k at the points j/d of every cell, as `bernstein_rows`."""
    taylor = _taylor(maps, cells, k)
    d = len(taylor) - 1
    points = np.arange(1, d + 1)[:, None] / d
    return np.tensordot(points ** np.arange(d + 1), taylor, axes=1).reshape(-1, len(cells))


def hat_rows(maps: FloatArray, cells: FloatArray, k: int) -> FloatArray:
    """Return the maps to the means of derivative k under the hat function of every node.

    Returns
    -------
    (N + 1, N) array
        ∫ hat_i·x^(k) dt / ∫ hat_i dt, hat_i linear on every cell, 1 at node i and 0 at others.
    """
    taylor = _taylor(maps, cells, k) * cells[:, None]
    i = np.arange(len(taylor))
    falling = np.tensordot(1.0 / ((i + 1) * (i + 2)), taylor, axes=1)
    rising = np.tensordot(1.0 / (i + 2), taylor, axes=1)
    rows = np.zeros((len(cells) + 1, len(cells)))
    rows[:-1] += falling
    rows[1:] += rising
    return rows / hat_areas(cells)[:, None]


def hat_areas(cells: FloatArray) -> FloatArray:
    """Return ∫ hat_i dt, shape (N + 1,)."""
    halves = np.concatenate([[0.0], 0.5 * cells, [0.0]])
    return np.asarray(halves[:-1] + halves[1:])


def _taylor(maps: FloatArray, cells: FloatArray, k: int) -> FloatArray:
    """Return x^(k+i)(t_j)·h_j^i / i! as maps, shape (d + 1, N, N)."""
    i = np.arange(len(maps) - k)
    factors = cells[None, :] ** i[:, None] * INVERSE_FACTORIALS[: len(i), None]
    return np.asarray(maps[k:, :-1] * factors[:, :, None])
