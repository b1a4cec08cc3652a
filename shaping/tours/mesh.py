"""One motion over a leg on a mesh, in the time of the leg: what is linear in it, and finer ones."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..optimal.whole.maps import functional_rows, hull_functionals, node_states
from ..pieces import FloatArray

_FEWEST = 8
_ON_RAMPS = 6
_BEYOND = 1.2  # times the ramps' time: how far their cells go
_SHORT = 0.4  # of the leg: where they are short
_MIDDLE = 0.45
_APART = 1e-3  # of the range: inputs that differ
_SHORTEST = 2e-3  # of the leg: a cell that is not cut
_SLIVER = 0.05  # of a cell: a switch nearer to its end is there


def first_cells(n: int, ramps: float) -> FloatArray:
    """Return the edges of the mesh to begin with, on whose cells derivative n is constant.

    They are equal, or where `ramps`, a share of the leg, are short, along these at both ends and
    longer and longer between; from order 4 on, where no exact plan follows, those at both ends
    are cut twice.
    """
    reach = _BEYOND * ramps
    if reach < _SHORT:
        edges = np.linspace(0.0, reach, _ON_RAMPS + 1)
        doubled = reach * 2.0 ** np.arange(1, 60)
        edges = np.append(edges, doubled[doubled < _MIDDLE])
    else:
        edges = np.linspace(0.0, 1.0, max(_FEWEST, 2 * n) + 1)
    short = edges[1] * np.array([0.25, 0.5] if n > 3 else [])
    half = np.append(edges[edges <= 0.5], short)
    return np.union1d(half, 1.0 - half)


def mesh_rows(n: int, edges: FloatArray) -> tuple[FloatArray, FloatArray, NDArray[np.intp]]:
    """Return what the states and the highest derivatives of the cells lead to.

    On a leg of duration 1, from n states at its start and the derivative n along the cells.

    Returns
    -------
    end : (n, n + cells) array
        State at the end.
    bounded : (rows, n + cells) array
        Values between whose extremes a derivative stays: the Bernstein coefficients of position
        and every derivative on every cell, all of one after those of the one below.
    derivative : (rows,) array
        Which derivative each is of.
    """
    return _mesh_rows(n, tuple(edges.tolist()))


@lru_cache(maxsize=512)
def _mesh_rows(n: int, edges: tuple[float, ...]) -> tuple[FloatArray, FloatArray, NDArray[np.intp]]:
    nodes = np.array(edges)
    cells = len(nodes) - 1
    maps = node_states(nodes, n, 1)
    rows = [
        functional_rows(maps, np.diff(nodes), k, *hull_functionals(n - k)).reshape(-1, cells + n)
        for k in range(n)
    ]
    rows.append(np.eye(cells, cells + n))
    of = np.repeat(np.arange(n + 1), [len(each) for each in rows])
    starts_first = np.roll(np.arange(cells + n), n)
    return maps[:, -1][:, starts_first], np.vstack(rows)[:, starts_first], of


def finer(edges: FloatArray, inputs: FloatArray) -> FloatArray:
    """Return a mesh on which cells with an input between those beside them can switch inside.

    The new edge is where a switch from one to the other keeps the area. Where such a switch is
    at an edge already, the cells beside it are cut.
    """
    same = _APART * float(np.ptp(inputs))
    before, after = inputs[:-2], inputs[2:]
    inner = inputs[1:-1]
    cells = np.diff(edges)
    long = cells[1:-1] > _SHORTEST
    between = np.minimum(np.abs(inner - before), np.abs(inner - after)) > same
    between &= (inner - before) * (after - inner) > 0.0
    found = np.flatnonzero(between & long)
    shares = (inner - after)[found] / (before - after)[found]
    kept = (shares > _SLIVER) & (shares < 1.0 - _SLIVER)
    switches = edges[1 + found[kept]] + shares[kept] * cells[1 + found[kept]]
    ends = np.array([0, len(cells) - 1])
    beside = np.minimum([1, len(cells) - 2], len(cells) - 1)
    cut = ends[(np.abs(inputs[ends] - inputs[beside]) > same) & (cells[ends] > _SHORTEST)]
    return np.union1d(edges, np.append(switches, 0.5 * (edges[cut] + edges[cut + 1])))
