"""Multipliers of a problem between states, and the polynomial in the duration that they prove.

For numbers λ_k and signed measures μ_k on [0, 1] every motion has, with z_k = x^(k)·T^k,

    Σ_k λ_k·z_k(1) + Σ_k ∫ z_k dμ_k = Σ_k p_k(0)·z_k(0) + ∫ p_{n−1}·z_n dτ,
    p_k' = −p_{k−1} − μ_k,  p_k(1) = λ_k,  p_{−1} = 0,

so that none within the bounds takes a time T at which c(T) > 0,

    c(T) = Σ_k T^k·[λ_k b_k + lo_k·|μ_k⁺| − hi_k·|μ_k⁻| − p_k(0)·a_k] − T^n·[hi_n ∫p⁺ − lo_n ∫p⁻].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...pieces import FloatArray, RealArray
from ..bernstein import elevation, signed_areas
from .problem import WholeProblem

_MARGIN = 1e-13  # of the sum of sizes of all terms, taken off


@dataclass(frozen=True, eq=False)
class Costate:
    """What multipliers give: p on each cell, its signed areas, p_k at the start.

    Parameters
    ----------
    pieces : (d + 1, N) array
        Bernstein coefficients of p_{n−1} times the cells' lengths over d + 1.
    positive, negative : (N,) arrays
        Bounds on ∫ max(p, 0) and ∫ max(−p, 0) over each cell.
    begin : (n,) array
        p_k(0).
    size : float
        Of what was summed to get them.
    """

    pieces: RealArray
    positive: FloatArray
    negative: FloatArray
    begin: FloatArray
    sizes: FloatArray


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Multipliers on a grid of N cells from 0 to 1.

    Parameters
    ----------
    cells : (N,) array
        Lengths of the cells.
    ends : (n,) array
        λ_k.
    atoms : mapping of k to (N,) array
        Of μ_k at the cells' right ends.
    densities : mapping of k to (d + 1, N) array
        Bernstein coefficients of the density of μ_k on each cell.
    """

    cells: FloatArray
    ends: FloatArray
    atoms: dict[int, FloatArray]
    densities: dict[int, FloatArray]

    def costate(self) -> Costate:
        """Return p = p_{n−1}, integrated from the end in extended precision."""
        h = self.cells.astype(np.longdouble)
        below: RealArray = np.zeros((1, len(h)), dtype=np.longdouble)
        spread: RealArray = below
        begin, sizes = np.zeros(len(self.ends)), np.zeros(len(self.ends))
        for k, final in enumerate(self.ends.tolist()):
            jumps = self.atoms.get(k, np.zeros(len(h))).astype(np.longdouble)
            density = self.densities.get(k, np.zeros((1, len(h))))
            below = _integrated(_sum(below, density), h, jumps, final)
            spread = _integrated(_sum(spread, np.abs(density)), h, np.abs(jumps), abs(final))
            begin[k], sizes[k] = float(below[0, 0]), float(spread[0, 0])
        pieces = below * h / len(below)
        positive, negative = signed_areas(pieces)
        return Costate(
            pieces, np.asarray(positive, float), np.asarray(negative, float), begin, sizes
        )

    def masses(self) -> tuple[FloatArray, FloatArray]:
        """Return |μ_k⁺| and |μ_k⁻|, (n,) each."""
        positive, negative = np.zeros((2, len(self.ends)))
        for k, atoms in self.atoms.items():
            density = self.densities[k] * (self.cells / len(self.densities[k]))
            positive[k] = np.maximum(atoms, 0.0).sum() + np.maximum(density, 0.0).sum()
            negative[k] = np.maximum(-atoms, 0.0).sum() + np.maximum(-density, 0.0).sum()
        return positive, negative

    def polynomial(self, problem: WholeProblem, costate: Costate) -> FloatArray:
        """Return the coefficients of c(T), rounding taken off."""
        n = problem.order
        positive, negative = self.masses()
        lower, upper = (
            np.where(positive > 0.0, problem.lower[:n], 0.0),
            np.where(negative > 0.0, problem.upper[:n], 0.0),
        )
        up, down = float(costate.positive.sum()), float(costate.negative.sum())
        terms = np.zeros((4, n + 1))
        terms[0, :n], terms[1, :n] = self.ends * problem.end, -costate.begin * problem.start
        terms[2, :n], terms[3, :n] = lower * positive, -upper * negative
        terms[2, n], terms[3, n] = -problem.upper[n] * up, problem.lower[n] * down
        sizes = np.abs(terms).sum(axis=0)
        sizes[:n] += costate.sizes * np.abs(problem.start)
        sizes[n] += costate.sizes[-1] * (problem.upper[n] - problem.lower[n])
        return np.asarray(terms.sum(axis=0) - _MARGIN * sizes)

    def slopes(self, problem: WholeProblem, time: float) -> FloatArray:
        """Return dT/dlo_k and dT/dhi_k of the root T of c(T), (2, n + 1)."""
        n, costate = problem.order, self.costate()
        masses = np.zeros((2, n + 1))
        masses[:, :n] = self.masses()
        masses[:, n] = costate.negative.sum(), costate.positive.sum()
        powers = time ** np.arange(n + 1)
        slope = float(np.arange(n + 1) @ (self.polynomial(problem, costate) * powers)) / time
        return masses * [[-1.0], [1.0]] * powers / slope


def _sum(left: RealArray, right: RealArray) -> RealArray:
    """Add polynomials of different degrees."""
    degree = max(len(left), len(right)) - 1
    total: RealArray = np.zeros((degree + 1, left.shape[1]), dtype=np.longdouble)
    for part in (left, right):
        raised = part if len(part) > degree else elevation(len(part) - 1, degree) @ part
        total = total + raised
    return total


def _integrated(slope: RealArray, h: RealArray, jumps: RealArray, final: float) -> RealArray:
    """Return ∫ slope from each time to the end, plus jumps at cells' right ends and `final`."""
    steps = slope * (h / len(slope))
    rise = steps.sum(axis=0) + jumps
    after = np.append(np.cumsum(rise[::-1])[::-1][1:], 0.0) + final + jumps
    within = np.cumsum(steps[::-1], axis=0)[::-1]
    return np.concatenate([after + within, after[None, :]])
