"""Both linear programs of a grid: an end that is missed at a cost, or bounds that are.

    minimise Σ_k w_k·|e_k|   subject to   z_k(1) + e_k = b_k·T^k,   lo_k·T^k ≤ row ≤ hi_k·T^k

The matrix does not depend on the duration T. What multipliers make of the bounds is a polynomial
in T: where it is positive there is no motion on the grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from .problem import WholeProblem
from .warm_program import Effort, WarmProgram

_WEIGHT = 3.0  # of a derivative's error at the end, position's being 1
_BROKEN = 100.0  # of what all bounds give way by, where the end is not free


@dataclass(frozen=True, eq=False)
class Rows:
    """Linear functionals of derivatives below n: bounds apply to each.

    Parameters
    ----------
    matrix : (m, columns + n) array
        Of inputs, and of the start's derivatives.
    derivative : (m,) array of int
    margin : (m,) array
        By how much of z_k in unit time bounds are tightened, see `Elastic`.
    """

    matrix: FloatArray
    derivative: NDArray[np.intp]
    margin: FloatArray

    def twice(self) -> Rows:
        """Return every row twice, the second after all of the first."""
        both = np.concatenate([self.derivative, self.derivative])
        margins = np.concatenate([self.margin, self.margin])
        return Rows(np.vstack([self.matrix, self.matrix]), both, margins)


@dataclass(frozen=True, eq=False)
class Found:
    """What a program found: how much is missing, by what inputs, and its multipliers in z_k."""

    missing: float
    inputs: FloatArray
    ends: FloatArray
    rows: FloatArray
    polynomial: FloatArray
    reached: FloatArray


class Elastic:
    """The linear program of a problem on a grid.

    Parameters
    ----------
    problem : WholeProblem
    ends : (n, columns + n) array
        Maps to the end state.
    rows : Rows
    sizes : (n + 1,) array
        Of z_k: what rows and inputs are scaled by.
    near : (m,) array of bool
        The rows to start with.
    free : bool
        The end is free, and it is the bounds of the rows that give way, all by the same.
    weight : float
        Of a derivative's error at the end, position's being 1.
    shrink : float
        Of the highest derivative's bounds: what they are tightened by.
    effort : Effort, optional
        What may be spent on it.
    high : (N,) array of bool, optional
        The inputs at their upper bounds, where the solver begins; all others are at their lower.
    """

    def __init__(
        self,
        problem: WholeProblem,
        ends: FloatArray,
        rows: Rows,
        sizes: FloatArray,
        near: NDArray[np.bool_],
        *,
        free: bool = False,
        weight: float = _WEIGHT,
        shrink: float = 0.0,
        effort: Effort | None = None,
        high: NDArray[np.bool_] | None = None,
    ) -> None:
        n = problem.order
        self._way = np.zeros(len(rows.derivative))
        if free:  # one row for each side, as both give way to the inside
            self._way = np.repeat([1.0, -1.0], len(rows.derivative))
            rows, near = rows.twice(), np.concatenate([near, near])
        self.problem, self.sizes, self.rows = problem, sizes, rows
        self.shrink = 1.0 - shrink
        fixed = [] if free else list(range(n))
        self._of = np.concatenate([np.array(fixed, dtype=int), rows.derivative])
        self._fixed = len(fixed)
        stacked = np.vstack([ends[fixed], rows.matrix])
        self._scale = 1.0 / sizes[self._of]
        count = stacked.shape[1] - n
        self._given = -stacked[:, count:] * problem.start * self._scale[:, None]
        inputs = stacked[:, :count] * (sizes[n] * self._scale)[:, None]
        held = np.vstack([np.eye(n)[fixed], np.zeros((len(rows.derivative), n))])
        slack = np.concatenate([np.zeros(len(fixed)), np.where(self._way < 0.0, -1.0, 1.0)])[
            :, None
        ]
        weights = np.full(n, weight)
        weights[0] = 1.0
        costs = [*weights, *weights, *[1.0 if free else _BROKEN] * 2]
        matrix = np.hstack([inputs, held, -held, slack, -slack])
        self._costs = np.concatenate([np.zeros(count), costs])
        self._count = count
        used = np.concatenate([np.ones(len(fixed), dtype=bool), near])
        if high is not None:
            high = np.append(high, np.zeros(len(costs), dtype=bool))
        self._program = WarmProgram(matrix, self._costs, used, effort, high=high)
        self._path = inputs[self._fixed :]

    def solve(self, time: float) -> Found | None:
        """Return what is missing at a duration; None where the solver fails."""
        n, problem = self.problem.order, self.problem
        powers = np.array(time ** np.arange(n + 1))
        free: FloatArray = self._given @ powers[:n]
        tight = self.rows.margin * self._scale[self._fixed :]
        lower = self._sides(problem.lower, powers) + free
        upper = self._sides(problem.upper, powers) + free
        lower[self._fixed :] += tight
        upper[self._fixed :] -= tight
        lower[self._fixed :][self._way < 0.0] = -np.inf
        upper[self._fixed :][self._way > 0.0] = np.inf
        ends = problem.end * powers[:n] / self.sizes[:n]
        lower[: self._fixed] = upper[: self._fixed] = (ends + free[:n])[: self._fixed]
        least, most = (np.zeros(len(self._costs)), np.full(len(self._costs), np.inf))
        unit = powers[n] / self.sizes[n] * self.shrink
        least[: self._count], most[: self._count] = problem.lower[n] * unit, problem.upper[n] * unit
        optimum = self._program.solve(lower, upper, least, most)
        if optimum is None:
            return None
        inputs = np.clip(optimum.columns, least, most)[: self._count]
        duals = optimum.multipliers * self._scale
        return Found(
            optimum.value,
            inputs * self.sizes[n],
            duals[: self._fixed],
            self._joined(duals[self._fixed :]),
            self._polynomial(optimum.multipliers, optimum.reduced_costs),
            (self._path @ inputs - free[self._fixed :]) / self._scale[self._fixed :],
        )

    def _joined(self, duals: FloatArray) -> FloatArray:
        """Return one multiplier for each row that was given."""
        return np.asarray(duals.reshape(2, -1).sum(axis=0) if self._way.any() else duals)

    def _sides(self, side: FloatArray, powers: FloatArray) -> FloatArray:
        return np.asarray((side * powers)[self._of] * self._scale)

    def _polynomial(self, multipliers: FloatArray, reduced_costs: FloatArray) -> FloatArray:
        """Return the coefficients of what the multipliers make of the bounds at any duration."""
        n, fixed = self.problem.order, self._fixed
        total = np.zeros(n + 1)
        total[:n] = multipliers @ self._given
        total[:fixed] += multipliers[:fixed] * self.problem.end[:fixed] / self.sizes[:fixed]
        path, of = multipliers[fixed:], self._of[fixed:]
        scale = self._scale[fixed:]
        total += np.bincount(of, self._paid(path * scale, of), n + 1)
        total[0] += np.abs(path * scale) @ self.rows.margin
        costs = reduced_costs[: self._count] / self.sizes[n] * self.shrink
        total[n] += self._paid(costs, np.full(len(costs), n)).sum()
        return total

    def _paid(self, multipliers: FloatArray, of: NDArray[np.intp]) -> FloatArray:
        bounds = np.where(multipliers > 0.0, self.problem.lower[of], self.problem.upper[of])
        return multipliers * np.where(multipliers == 0.0, 0.0, bounds)
