"""What inputs and start do to the states on a grid: at nodes, between them, and on average.

A column for each input x^(n)·T^n, constant on a part of a cell, and one for each derivative of
the start, a_q·T^q; rows give z_k = x^(k)·T^k. Time runs from 0 to 1.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb, factorial

import numpy as np

from ...pieces import INVERSE_FACTORIALS, FloatArray


def node_states(nodes: FloatArray, order: int, parts: int) -> FloatArray:
    """Return the maps S[k, i] to z_k at node i, shape (n, N + 1, parts·N + n).

        z_k(τ_i) = Σ_j w_j·[(τ_i − s_j)₊^m − (τ_i − s_{j+1})₊^m] / m! + Σ_q a_q T^q τ_i^(q−k)/(q−k)!

    with m = n − k and s the edges of the parts.
    """
    edges = fine_edges(nodes, parts)
    since = np.maximum(nodes[:, None] - edges, 0.0)
    count = len(edges) - 1
    maps = np.zeros((order, len(nodes), count + order))
    power = np.ones_like(since)
    for k in range(order - 1, -1, -1):
        power = power * since
        maps[k, :, :count] = (power[:, :-1] - power[:, 1:]) * INVERSE_FACTORIALS[order - k]
        for q in range(k, order):
            maps[k, :, count + q] = nodes ** (q - k) * INVERSE_FACTORIALS[q - k]
    return maps


def fine_edges(nodes: FloatArray, parts: int) -> FloatArray:
    """Return the nodes with every cell cut into equal parts."""
    if parts == 1:
        return nodes
    at = np.arange(parts * (len(nodes) - 1) + 1) / parts
    return np.interp(at, np.arange(len(nodes)), nodes)


def merged_parts(maps: FloatArray, parts: int, order: int) -> FloatArray:
    """Return the maps with one input per cell."""
    count = maps.shape[2] - order
    inputs = maps[:, :, :count].reshape(*maps.shape[:2], count // parts, parts).sum(axis=3)
    return np.concatenate([inputs, maps[:, :, count:]], axis=2)


def functional_rows(
    maps: FloatArray, cells: FloatArray, k: int, state: FloatArray, own: FloatArray
) -> FloatArray:
    """Return the maps to linear functionals of z_k on each cell, shape (q, N, columns).

    Parameters
    ----------
    maps : (n, N + 1, columns) array
        Of `node_states`.
    state : (q, m) array
        What the functionals give of σ^i/i!, σ from 0 to 1 on the cell.
    own : (q, parts) array
        What they give of the response to the cell's own inputs, see `part_responses`.
    """
    n, count = len(maps), len(cells)
    powers = cells ** np.arange(n - k)[:, None]
    weights = state[:, None, :] * powers.T
    rows = np.matmul(weights.transpose(1, 0, 2), maps[k:, :-1].transpose(1, 0, 2)).transpose(
        1, 0, 2
    )
    parts = own.shape[1]
    each = np.arange(count)
    for p in range(parts):
        rows[:, each, parts * each + p] += own[:, p, None] * cells ** (n - k)
    return np.asarray(rows)


@lru_cache(maxsize=128)
def hull_functionals(m: int) -> tuple[FloatArray, FloatArray]:
    """Return the functionals "Bernstein coefficient 1 … m" of a polynomial of degree m."""
    basis = np.array([[comb(j, i) / comb(m, i) for i in range(m + 1)] for j in range(1, m + 1)])
    basis = basis * INVERSE_FACTORIALS[: m + 1]
    return basis[:, :m], basis[:, m:]


@lru_cache(maxsize=128)
def point_functionals(m: int) -> tuple[FloatArray, FloatArray]:
    """Return the functionals "value at j/m", j = 1 … m."""
    points = np.arange(1, m + 1)[:, None] / m
    basis = points ** np.arange(m + 1) * INVERSE_FACTORIALS[: m + 1]
    return basis[:, :m], basis[:, m:]


@lru_cache(maxsize=128)
def mean_functionals(m: int, degree: int, parts: int) -> tuple[FloatArray, FloatArray]:
    """Return the functionals "mean under B_{j,d}", j = 0 … d, of a cell with `parts` inputs."""
    d = degree
    state = np.array([[_moment(j, d, i) / factorial(i) for i in range(m)] for j in range(d + 1)])
    return state, part_responses(m, degree, parts)


def _moment(j: int, d: int, i: int) -> float:
    """Return (d + 1)·∫ B_{j,d}(σ)·σ^i dσ = Π_{r<i} (j + 1 + r)/(d + 2 + r)."""
    product = 1.0
    for r in range(i):
        product *= (j + 1 + r) / (d + 2 + r)
    return product


def part_responses(m: int, degree: int, parts: int) -> FloatArray:
    """Return the means under B_{j,d} of the m-fold integral of a unit input on each part.

    By Gauss's rule on every part, on which all are polynomials.
    """
    d = degree
    points, weights = np.polynomial.legendre.leggauss(m + d)
    own = np.zeros((d + 1, parts))
    for piece in range(parts):
        at = (piece + 0.5 * (points + 1.0)) / parts
        hats = np.array([(d + 1) * comb(d, j) * at**j * (1 - at) ** (d - j) for j in range(d + 1)])
        for p in range(parts):
            begun, over = (np.maximum(at - edge / parts, 0.0) ** m for edge in (p, p + 1))
            own[:, p] += hats @ (0.5 * weights / parts * (begun - over) / factorial(m))
    return own
