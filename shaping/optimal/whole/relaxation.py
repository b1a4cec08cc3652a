"""The program whose multipliers are a proof: bounds kept at nodes and on average.

Every cell has several inputs, and the densities of derivative k are of degree max(1, k − 1) on
each, continuous: so the costate can vanish along arcs on which a derivative is held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...pieces import FloatArray
from .costate import Multipliers
from .elastic import Rows
from .maps import functional_rows, mean_functionals
from .problem import WholeProblem


@dataclass(frozen=True, eq=False)
class MeanRows:
    """Rows of bounded derivatives: per derivative those at nodes 1 … N, then the means.

    Attributes
    ----------
    rows : Rows
    cells : (m,) array
        Where on the grid each row is: the number of a cell.
    """

    rows: Rows
    cells: FloatArray
    lengths: FloatArray

    @classmethod
    def make(
        cls, problem: WholeProblem, maps: FloatArray, nodes: FloatArray, parts: int
    ) -> MeanRows:
        """Return the rows of a grid, nodes' bounds relaxed by `slack` of the sizes."""
        n, lengths = problem.order, np.diff(nodes)
        count, width = len(lengths), maps.shape[2]
        matrices, derivatives, cells = [np.empty((0, width))], [], []
        for k in problem.bounded:
            means = functional_rows(maps, lengths, k, *mean_functionals(n - k, degree(k), parts))
            shared = np.zeros((count + 1, width))
            shared[:-1] += lengths[:, None] * means[0]
            shared[1:] += lengths[:, None] * means[-1]
            around = np.append(lengths, 0.0) + np.append(0.0, lengths)
            inner = means[1:-1].reshape(-1, width)
            matrices += [maps[k, 1:], shared / around[:, None], inner]
            each = np.arange(count)
            cells += [each, np.append(each, count - 1), np.tile(each, degree(k) - 1)]
            derivatives.append(np.full(count + count + 1 + len(inner), k))
        of = np.concatenate(derivatives).astype(int) if derivatives else np.zeros(0, dtype=int)
        where = np.concatenate(cells) if cells else np.zeros(0, dtype=int)
        return cls(Rows(np.vstack(matrices), of, np.zeros(len(of))), where, lengths)

    def multipliers(self, problem: WholeProblem, ends: FloatArray, rows: FloatArray) -> Multipliers:
        """Return the multipliers that a program's make."""
        n, lengths = problem.order, self.lengths
        count, at = len(lengths), 0
        lower = np.where(np.isfinite(problem.lower[:-1]), np.inf, 0.0)[self.rows.derivative]
        upper = np.where(np.isfinite(problem.upper[:-1]), np.inf, 0.0)[self.rows.derivative]
        rows = np.clip(rows, -upper, lower)
        final = np.zeros(n)
        final[: len(ends)] = ends
        atoms: dict[int, FloatArray] = {}
        densities: dict[int, FloatArray] = {}
        for k in problem.bounded:
            d = degree(k)
            atoms[k] = rows[at : at + count]
            at += count
            around = (np.append(lengths, 0.0) + np.append(0.0, lengths)) / (d + 1)
            shared = rows[at : at + count + 1] / around
            at += count + 1
            inner = rows[at : at + count * (d - 1)].reshape(d - 1, count) / lengths * (d + 1)
            at += count * (d - 1)
            densities[k] = np.vstack([shared[:-1], inner, shared[1:]])
        return Multipliers(lengths, final, atoms, densities)


def degree(k: int) -> int:
    """Return the degree of the densities of derivative k."""
    return max(1, k - 1)
