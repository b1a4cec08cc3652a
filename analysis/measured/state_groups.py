"""A system's response at very many frequencies: its states in groups that hang on earlier ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .rational_fits import Complex


@dataclass(frozen=True, eq=False)
class StateGroups:
    """States x' = A·x + b·u, y = c·x + d·u of one input and output, dependencies first.

    A chain of elements has a group of one or two states for each of them, solved for at all
    frequencies at once,

        (z − A_gg)·x_g = b_g + A_ge·x_e,    e: the groups before,

    as exactly as by elimination of the whole.

    Parameters
    ----------
    matrix, column, row, through : arrays and float
        A, b, c and d.
    ends : tuple of int
        Number of states up to the end of each group.
    """

    matrix: Complex
    column: Complex
    row: Complex
    through: float
    ends: tuple[int, ...]

    def at(self, places: Complex) -> Complex:
        """Return the response at places of the complex plane, (N,)."""
        states = np.empty((len(self.column), len(places)), dtype=complex)
        first = 0
        for end in self.ends:
            right = self.matrix[first:end, :first] @ states[:first]
            right += self.column[first:end, None]
            states[first:end] = _solved(self.matrix[first:end, first:end], right, places)
            first = end
        return np.asarray(self.row @ states + self.through)


def state_groups(system: Any) -> StateGroups:
    """Return a state-space system of one input and one output, its states in groups."""
    a, b, c, d = (np.asarray(each, complex) for each in (system.A, system.B, system.C, system.D))
    groups = _groups(a)
    order = np.array([state for group in groups for state in group], dtype=np.intp)
    ends = tuple(np.cumsum([len(group) for group in groups]).tolist())
    return StateGroups(a[np.ix_(order, order)], b[order, 0], c[0, order], float(d[0, 0].real), ends)


def _groups(matrix: Complex) -> list[list[int]]:
    """Return the states in groups of those that hang on each other, dependencies first.

    Such states hang on the same ones, and on more than those before them do.
    """
    reach = np.eye(len(matrix)) + (matrix != 0.0) > 0.0
    for _ in range(len(matrix).bit_length()):
        reach = reach @ reach
    by_reach: dict[bytes, list[int]] = {}
    for state in np.argsort(reach.sum(axis=1), kind="stable").tolist():
        by_reach.setdefault(reach[state].tobytes(), []).append(state)
    return list(by_reach.values())


def _solved(matrix: Complex, right: Complex, places: Complex) -> Complex:
    """Return (z − A)⁻¹·right at each place, (n, N)."""
    if len(matrix) == 1:
        return np.asarray(right / (places - matrix[0, 0]))
    if len(matrix) == 2:
        (a, b), (c, d) = matrix
        first, second = places - a, places - d
        top, below = right
        factor = 1.0 / (first * second - b * c)
        return np.stack([(second * top + b * below) * factor, (c * top + first * below) * factor])
    inner = places[:, None, None] * np.eye(len(matrix)) - matrix
    return np.asarray(np.linalg.solve(inner, right.T[:, :, None])[:, :, 0].T)
