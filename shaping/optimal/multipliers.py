"""Multipliers of the half problem, and the bound that they prove, free of any solver's errors.

For numbers λ_k and signed measures μ_k (atoms at nodes, densities linear between them) every
motion of the half 0…1 that starts at rest, with z_k(1) = 0 where λ_k ≠ 0, has

    z_0(1) = ∫ p·z_n dτ + Σ_k ∫ z_k dμ_k,   q_0 = 1,  q_k(1) = −λ_k,  −q_k' = q_{k−1} − μ_k,

with p = q_{n−1}. So z_0(1) is at most Σ_k L_k·η^k·(mass of μ_k), with ∫|p| for k = n, whatever
the multipliers are (weak duality): they may come from anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from ..pieces import FloatArray, RealArray
from .bernstein import signed_areas

_OPERATIONS = 400  # more than the roundings in a row that a value goes through within a cell


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Multipliers on a mesh of N cells.

    Parameters
    ----------
    cells : (N,) array
        Lengths of the cells; their sum is 1 but for rounding.
    ends : (n,) array
        λ_k, zero where the end is free.
    atoms, densities : (n, N + 1) arrays
        Of μ_k at the nodes; row 0 is not used.
    """

    cells: FloatArray
    ends: FloatArray
    atoms: FloatArray
    densities: FloatArray

    def costates(self) -> tuple[RealArray, RealArray]:
        """Return p on each cell, and a bound on the rounding in it.

        Returns
        -------
        coefficients : (d + 1, N) array
            Of powers of σ, which runs from 0 at the cell's right end to 1 at its left.
        rounding : (N,) array
            More than the error of p anywhere on the cell.
        """
        n, count = self.atoms.shape[0], len(self.cells)
        h = self.cells.astype(np.longdouble)
        q = np.ones((1, count), dtype=np.longdouble)
        size = np.ones((1, count), dtype=np.longdouble)
        for k in range(1, n):
            density = np.array([self.densities[k, 1:], self.densities[k, :-1]], np.longdouble)
            slope = np.array([density[0], density[1] - density[0]])
            steep = np.array([np.abs(density[0]), np.abs(density[0]) + np.abs(density[1])])
            start = np.longdouble(-self.ends[k]), np.abs(np.longdouble(self.ends[k]))
            jumps = self.atoms[k, 1:].astype(np.longdouble)
            q = _integrated(_sum(q, -slope), h, start[0], -jumps)
            size = _integrated(_sum(size, steep), h, start[1], np.abs(jumps))
        steps = n * (count + 8) + _OPERATIONS
        return q, size.sum(axis=0) * (steps * np.finfo(np.longdouble).eps)

    def merged(self, parts: int) -> Multipliers:
        """Return the same on cells each of which was cut into `parts`, densities linear on it."""
        every = slice(None, None, parts)
        cells = np.add.reduceat(self.cells, np.arange(0, len(self.cells), parts))
        return Multipliers(cells, self.ends, self.atoms[:, every], self.densities[:, every])

    def sizes(self, k: int, parts: int) -> FloatArray:
        """Return about how much of μ_k there is around every `parts`-th node."""
        halves = np.concatenate([[0.0], 0.5 * self.cells, [0.0]])
        every = self.densities[k] * (halves[:-1] + halves[1:]) + self.atoms[k]
        edges = np.maximum(np.arange(0, len(every), parts) - parts // 2, 0)
        return np.asarray(np.add.reduceat(every, edges))

    def masses(self) -> tuple[FloatArray, FloatArray]:
        """Return bounds on the positive and the negative mass of each μ_k, (n,) each."""
        halves = np.concatenate([[0.0], 0.5 * self.cells, [0.0]])
        weights = self.densities * (halves[:-1] + halves[1:])
        parts = np.stack([self.atoms, weights])
        rounding = 1.0 + 1e-15 * (len(self.cells) + 10)
        positive = np.maximum(parts, 0.0).sum(axis=(0, 2)) * rounding
        negative = np.maximum(-parts, 0.0).sum(axis=(0, 2)) * rounding
        return positive, negative


def _sum(left: RealArray, right: RealArray) -> RealArray:
    """Add polynomials of different degrees."""
    total = np.zeros((max(len(left), len(right)), left.shape[1]), dtype=np.longdouble)
    total[: len(left)] += left
    total[: len(right)] += right
    return total


def _integrated(
    slope: RealArray, h: RealArray, start: np.longdouble, jumps: RealArray
) -> RealArray:
    """Integrate polynomials in σ from the last cell to the first.

    `jumps` are added at each cell's right end, `start` at the last one's besides.
    """
    powers = slope * h / np.arange(1, len(slope) + 1)[:, None]
    rise = powers.sum(axis=0) + jumps
    after = np.cumsum(rise[::-1])[::-1]
    constant = np.append(after[1:], 0.0) + start + jumps
    return np.concatenate([constant[None, :], powers])


def signed_integrals(
    coefficients: RealArray, cells: FloatArray, rounding: RealArray
) -> tuple[RealArray, RealArray]:
    """Return upper bounds on ∫ max(p, 0) and ∫ max(−p, 0) over each cell, (N,) each.

    `signed_areas` of the Bernstein form.
    """
    d = len(coefficients) - 1
    upper, lower = (
        np.array([[comb(m, i) for i in range(d + 1)] for m in row], np.longdouble)
        for row in (range(d + 1), [d] * (d + 1))
    )
    positive, negative = signed_areas(upper / lower @ coefficients * cells / (d + 1))
    doubt = rounding * cells
    return positive + doubt, negative + doubt
