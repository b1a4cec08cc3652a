"""The program whose answer is a motion: bounds kept by hulls of its pieces, at all times."""

from __future__ import annotations

from math import factorial

import numpy as np

from ...pieces import FloatArray
from .elastic import Rows
from .maps import functional_rows, hull_functionals
from .problem import WholeProblem

MARGIN = 5e-7  # of a bound's size: room for the repair of the end state
_NEAR_ENDS = 4e-6  # of what the input can do since the start, or until the end


def hull_rows(
    problem: WholeProblem, maps: FloatArray, nodes: FloatArray, sizes: FloatArray, margin: float
) -> Rows:
    """Return the rows of Bernstein coefficients 1 … n − k of every bounded z_k on every cell."""
    n, cells = problem.order, np.diff(nodes)
    matrices, derivatives, margins = [np.empty((0, maps.shape[2]))], [], []
    for k in problem.bounded:
        rows = functional_rows(maps, cells, k, *hull_functionals(n - k))
        matrices.append(rows.reshape(-1, maps.shape[2]))
        derivatives.append(np.full(len(rows) * len(cells), k))
        reach = np.minimum(nodes[:-1], 1.0 - nodes[1:]) ** (n - k) / factorial(n - k)
        room = margin * np.minimum(sizes[k], _NEAR_ENDS / MARGIN * sizes[n] * reach)
        margins.append(np.tile(room, len(rows)))
    of = np.concatenate(derivatives).astype(int) if derivatives else np.zeros(0, dtype=int)
    return Rows(np.vstack(matrices), of, np.concatenate(margins) if margins else np.zeros(0))
