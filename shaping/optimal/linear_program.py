"""A linear program over the inputs of the cells, solved by HiGHS, again as its bounds move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray

Range = tuple[float, float]
Sides = tuple[FloatArray, FloatArray]

_TOLERANCE = 1e-9
_SMALLEST = 1e-12  # coefficients below it are dropped; as HiGHS comes it drops those below 1e-9
_ITERATIONS = 20  # per column: more were never of use, the simplex method may cycle for ever
_MOST_ITERATIONS = 5000
_SECONDS = 20.0  # of one run, a hundred times the usual: with inputs of 1e8 it may never end
SETTINGS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "threads": 1,
    "presolve": "off",  # takes longer than it saves: the rows are dense
    "solver": "simplex",
    "primal_feasibility_tolerance": _TOLERANCE,
    "dual_feasibility_tolerance": _TOLERANCE,
    "small_matrix_value": _SMALLEST,
}
_OTHER_WAYS: tuple[dict[str, bool | int | float | str], ...] = (
    {"simplex_strategy": 4},
    {"simplex_strategy": 1, "presolve": "on"},
)
"""Tried one after the other where the dual simplex method ends without an answer."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Inputs (N,), the value reached, and what each row's bound is worth (its multiplier)."""

    value: float
    inputs: FloatArray
    multipliers: FloatArray
    reduced_costs: FloatArray


class LinearProgram:
    """Maximise objective·u subject to lower ≤ matrix·u ≤ upper, and bounds alike on every u.

    Parameters
    ----------
    objective : (N,) array
    matrix : (m, N) array
    """

    def __init__(self, objective: FloatArray, matrix: FloatArray) -> None:
        self.objective, self.matrix = objective, matrix
        self._highs: Any = None

    def solve(self, lower: FloatArray, upper: FloatArray, inputs: Range) -> Solution | None:
        """Return the optimum, or None where the solver finds none.

        A second call starts from where the last one ended.
        """
        if self._highs is None:
            self._highs = _started(self.objective, self.matrix, lower, upper, inputs)
        else:
            self._move_bounds(lower, upper, inputs)
        run(self._highs)
        if not self._solved():
            return self._solve_otherwise(lower, upper, inputs)
        return self._solution()

    def _move_bounds(self, lower: FloatArray, upper: FloatArray, inputs: Range) -> None:
        rows, columns = self.matrix.shape
        least, most = (np.full(columns, side) for side in inputs)
        self._highs.changeRowsBounds(rows, np.arange(rows, dtype=np.int32), lower, upper)
        self._highs.changeColsBounds(columns, np.arange(columns, dtype=np.int32), least, most)

    def _solve_otherwise(
        self, lower: FloatArray, upper: FloatArray, inputs: Range
    ) -> Solution | None:
        for settings in _OTHER_WAYS:
            self._highs = _started(self.objective, self.matrix, lower, upper, inputs)
            set_options(self._highs, settings)
            run(self._highs)
            if self._solved():
                solution = self._solution()
                self._highs = None
                return solution
        self._highs = None
        return None

    def _solved(self) -> bool:
        return str(self._highs.getModelStatus()).endswith("kOptimal")

    def _solution(self) -> Solution:
        found = self._highs.getSolution()
        reached = np.array(found.col_value)
        return Solution(
            float(self.objective @ reached),
            reached,
            -np.array(found.row_dual),  # HiGHS minimises
            -np.array(found.col_dual),
        )


def _started(
    objective: FloatArray,
    matrix: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    inputs: Range,
) -> Any:
    """Return HiGHS with the program loaded."""
    limit = min(_ITERATIONS * len(objective), _MOST_ITERATIONS)
    least, most = (np.full(len(objective), side) for side in inputs)
    settings = {"simplex_iteration_limit": limit}
    return loaded(-objective, matrix, (lower, upper), (least, most), settings)


def loaded(
    costs: FloatArray,
    matrix: FloatArray,
    rows: Sides,
    columns: Sides,
    settings: Mapping[str, bool | int | float | str],
) -> Any:
    """Return HiGHS with a program: minimise costs·x, bounds on matrix·x and on x given.

    The arrays go over as they are: an `HighsLp` takes them number by number, for milliseconds.
    """
    import highspy

    library: Any = highspy  # its stubs leave the class out
    highs = library._Highs()  # Highs itself prints a banner before it can be told not to
    set_options(highs, SETTINGS)
    set_options(highs, settings)
    used = np.abs(matrix) > _SMALLEST
    starts = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    highs.passModel(
        matrix.shape[1],
        matrix.shape[0],
        int(starts[-1]),
        int(library.MatrixFormat.kRowwise),
        int(library.ObjSense.kMinimize),
        0.0,
        costs,
        *columns,
        *rows,
        starts.astype(np.int32),
        np.nonzero(used)[1].astype(np.int32),
        matrix[used],
        np.zeros(matrix.shape[1], dtype=np.int32),
    )
    return highs


def begin(highs: Any, high: NDArray[np.bool_], rows: int) -> None:
    """Let HiGHS begin with each column at its lower or upper bound, whatever the rows are then."""
    import highspy

    status = highspy.HighsBasisStatus
    basis = highspy.HighsBasis()
    basis.col_status = [status.kUpper if up else status.kLower for up in high.tolist()]
    basis.row_status = [status.kBasic] * rows
    highs.setBasis(basis)


def run(highs: Any) -> None:
    """Run HiGHS, whose limit is on the seconds of all runs, for some seconds at most."""
    set_options(highs, {"time_limit": highs.getRunTime() + _SECONDS})
    highs.run()


def set_options(highs: Any, settings: Mapping[str, bool | int | float | str]) -> None:
    """Set options of HiGHS by name."""
    for name, value in settings.items():
        highs.setOptionValue(name, value)
