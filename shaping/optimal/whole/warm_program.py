"""A linear program with rows added as they are broken, solved again as its bounds move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from ..linear_program import begin, loaded, run, set_options

_BROKEN = 2e-9  # beyond a bound: a row that is added
_PASSES = 40
_ITERATIONS = 1000, 2  # and per row and column: more were never of use, it may cycle
_TROUBLE = 4.0  # times as long as others take iterations that come to no end
_WAYS: tuple[dict[str, bool | int | float | str], ...] = (
    # rows and inputs are scaled already; exact steepest edges take five times as long as Devex
    {"simplex_scale_strategy": 0, "simplex_dual_edge_weight_strategy": 1},
    {"simplex_strategy": 4},
    {},
)
_COSTS = 1e3  # costs are multiplied: the solver takes a reduced cost of 1e-9 for none
_OVERHEAD = 20  # iterations that a run is worth before it begins

EFFORT = 5e9
"""Of one search below order 5: about five seconds."""

_HIGH, _MORE = 5, 4.0  # orders from there on may take four times as much


@dataclass(eq=False)
class Effort:
    """What is left to be spent on programs: entries of matrices passed over, no seconds.

    So that a search ends with the same on every machine.
    """

    left: float = EFFORT

    @classmethod
    def of(cls, order: int) -> Effort:
        """Return what one search at an order may take."""
        return cls(EFFORT * (_MORE if order >= _HIGH else 1.0))


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
    effort : Effort, optional
        With nothing left of it the solver finds none.
    high : (N,) array of bool, optional
        The columns that are at their upper bounds where the solver begins.
    """

    def __init__(
        self,
        matrix: FloatArray,
        costs: FloatArray,
        used: NDArray[np.bool_],
        effort: Effort | None = None,
        *,
        high: NDArray[np.bool_] | None = None,
    ) -> None:
        self.matrix, self.costs = matrix, costs
        self._high = high
        self._effort = effort or Effort()
        self.rows = np.flatnonzero(used)
        self._highs: Any = None

    def solve(
        self, lower: FloatArray, upper: FloatArray, least: FloatArray, most: FloatArray
    ) -> Optimum | None:
        """Return the optimum; None where the solver finds none."""
        for _ in range(_PASSES):
            if self._effort.left <= 0.0 or not self._run(lower, upper, least, most):
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
        if self._ended_well():
            return True
        for settings in _WAYS[1:]:
            if self._effort.left <= 0.0 or self._ended("kInfeasible"):
                break
            self._load(lower, upper, least, most, settings)
            if self._ended_well():
                return True
        self._highs = None
        return False

    def _ended_well(self) -> bool:
        """Run; tell whether there are columns within the bounds, and the least cost but for doubt.

        What multipliers prove is worked out without the solver.
        """
        rows, columns = len(self.rows), len(self.costs)
        size, (some, each) = rows * columns, _ITERATIONS
        limit = min(some + each * (rows + columns), 1 + self._effort.left / size)
        set_options(self._highs, {"simplex_iteration_limit": int(limit)})
        run(self._highs)
        iterations = self._highs.getInfo().simplex_iteration_count
        well = self._ended("kOptimal") or self._ended("kUnknown")
        if iterations < 0:
            iterations = limit  # it broke off
        elif not well and not self._ended("kInfeasible"):
            iterations *= _TROUBLE
        self._effort.left -= (iterations + _OVERHEAD) * size
        return well and self._highs.getNumRow() == len(self.rows)  # none of them refused

    def _ended(self, status: str) -> bool:
        return str(self._highs.getModelStatus()).endswith(status)

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
        self._highs = loaded(
            self.costs * _COSTS,
            self.matrix[self.rows],
            (lower[self.rows], upper[self.rows]),
            (least, most),
            settings,
        )
        if self._high is not None:
            begin(self._highs, self._high, len(self.rows))

    def _optimum(self) -> Optimum:
        found = self._highs.getSolution()
        reached = np.array(found.col_value)
        multipliers = np.zeros(len(self.matrix))
        multipliers[self.rows] = np.array(found.row_dual) / _COSTS
        reduced_costs = np.array(found.col_dual) / _COSTS
        return Optimum(float(self.costs @ reached), reached, multipliers, reduced_costs)
