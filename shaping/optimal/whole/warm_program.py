"""A linear program with rows added as they are broken, solved again as its bounds move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from ..linear_program import loaded

_BROKEN = 2e-9  # beyond a bound: a row that is added
_PASSES = 40
_ITERATIONS = 6  # per row and column: more were never of use, the simplex method may cycle
_WAYS: tuple[dict[str, bool | int | float | str], ...] = (
    {"simplex_scale_strategy": 0},  # rows and inputs are scaled already
    {"simplex_strategy": 4},
    {"solver": "ipm", "run_crossover": "on"},
)


@dataclass(frozen=True, eq=False)
class Optimum:
    """Least cost, the columns that reach it, the rows' multipliers, the columns' reduced costs."""

    value: float
    columns: FloatArray
    multipliers: FloatArray
    reduced_costs: FloatArray


class WarmProgram:
    """Minimise costs·x, lower ≤ matrix·x ≤ upper, columns between bounds.

    Parameters
    ----------
    matrix : (m, N) array
    costs : (N,) array
    used : (m,) array of bool
        The rows to start with; the others count as soon as they are broken.
    """

    def __init__(self, matrix: FloatArray, costs: FloatArray, used: NDArray[np.bool_]) -> None:
        self.matrix, self.costs = matrix, costs
        self.rows = np.flatnonzero(used)
        self._highs: Any = None

    def solve(
        self, lower: FloatArray, upper: FloatArray, least: FloatArray, most: FloatArray
    ) -> Optimum | None:
        """Return the optimum; None where the solver finds none."""
        for _ in range(_PASSES):
            if not self._run(lower, upper, least, most):
                return None
            optimum = self._optimum()
            reached = self.matrix @ optimum.columns
            broken = (reached < lower - _BROKEN) | (reached > upper + _BROKEN)
            broken[self.rows] = False
            if not broken.any():
                return optimum
            self._add(np.flatnonzero(broken), lower, upper)
        return None

    def _run(
        self, lower: FloatArray, upper: FloatArray, least: FloatArray, most: FloatArray
    ) -> bool:
        if self._highs is None:
            self._load(lower, upper, least, most, _WAYS[0])
        else:
            self._move_bounds(lower, upper, least, most)
        self._highs.run()
        if self._solved():
            return True
        for settings in _WAYS[1:]:
            if self._infeasible():
                break
            self._load(lower, upper, least, most, settings)
            self._highs.run()
            if self._solved():
                return True
        self._highs = None
        return False

    def _solved(self) -> bool:
        return str(self._highs.getModelStatus()).endswith("kOptimal")

    def _infeasible(self) -> bool:
        return str(self._highs.getModelStatus()).endswith("kInfeasible")

    def _move_bounds(
        self, lower: FloatArray, upper: FloatArray, least: FloatArray, most: FloatArray
    ) -> None:
        rows, columns = len(self.rows), len(self.costs)
        at = np.arange(max(rows, columns), dtype=np.int32)
        self._highs.changeRowsBounds(rows, at[:rows], lower[self.rows], upper[self.rows])
        self._highs.changeColsBounds(columns, at[:columns], least, most)

    def _add(self, rows: NDArray[np.intp], lower: FloatArray, upper: FloatArray) -> None:
        width = len(self.costs)
        starts = np.arange(0, width * len(rows), width, dtype=np.int32)
        indices = np.tile(np.arange(width, dtype=np.int32), len(rows))
        values = self.matrix[rows].ravel()
        self._highs.addRows(
            len(rows), lower[rows], upper[rows], len(values), starts, indices, values
        )
        self.rows = np.concatenate([self.rows, rows])

    def _load(
        self,
        lower: FloatArray,
        upper: FloatArray,
        least: FloatArray,
        most: FloatArray,
        settings: dict[str, bool | int | float | str],
    ) -> None:
        size = len(self.rows) + len(self.costs)
        self._highs = loaded(
            self.costs,
            self.matrix[self.rows],
            (lower[self.rows], upper[self.rows]),
            (least, most),
            {"simplex_iteration_limit": _ITERATIONS * size, **settings},
        )

    def _optimum(self) -> Optimum:
        found = self._highs.getSolution()
        reached = np.array(found.col_value)
        multipliers = np.zeros(len(self.matrix))
        multipliers[self.rows] = found.row_dual
        return Optimum(float(self.costs @ reached), reached, multipliers, np.array(found.col_dual))
