"""The half problem with its bounds kept at nodes and on average: its multipliers make the proof.

Each cell is cut into a few with inputs of their own: with one alone the costate could swing from
side to side within the cell, its mean zero, and prove little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray
from .half_problem import HalfProblem
from .linear_program import LinearProgram, Solution
from .multipliers import Multipliers
from .state_maps import hat_areas, hat_rows, node_maps


class RelaxedProgram:
    """The linear program of a half, bounds kept at the nodes and in the mean around each node.

    Parameters
    ----------
    problem : HalfProblem
    nodes : (N + 1,) array
        From 0 to 1.
    parts : int
        Into how many every cell is cut; the input is constant on each part.
    near : (n, N + 1) array of bool, optional
        At which nodes the bound on derivative k counts, all by default. Leaving out those that a
        good motion keeps far from loses nothing: their multipliers are zero.
    """

    def __init__(
        self,
        problem: HalfProblem,
        nodes: FloatArray,
        parts: int,
        near: NDArray[np.bool_] | None = None,
    ) -> None:
        n = problem.order
        self.problem, self.nodes, self.parts = problem, nodes, parts
        fine = np.interp(
            np.arange(parts * len(nodes) - parts + 1) / parts, np.arange(len(nodes)), nodes
        )
        self._cells = np.diff(fine)
        self._maps = node_maps(fine, n)
        self._units = problem.units(float(self._cells.min()))
        self._scales = self._units[n] / self._units
        self._hats = np.array([np.interp(fine, nodes, hat) for hat in np.eye(len(nodes))])
        areas = hat_areas(self._cells)
        self._areas = self._hats @ areas
        means = self._hats * areas / self._areas[:, None]
        even = self._even()
        self._near = np.ones((n, len(nodes)), dtype=bool) if near is None else near
        rows = [self._maps[even, -1] * self._scales[even, None]]
        for k in problem.relevant():
            near_k = self._near[k]
            rows.append(self._maps[k, parts::parts][near_k[1:]] * self._scales[k])
            rows.append(means[near_k] @ hat_rows(self._maps, self._cells, k) * self._scales[k])
        self._program = LinearProgram(self._maps[0, -1] * self._scales[0], np.vstack(rows))

    def solve(self, half: float) -> Multipliers | None:
        """Return the multipliers at a half duration η; None where the solver fails."""
        n = self.problem.order
        powers = half ** np.arange(n + 1) / self._units
        lower, upper = self.problem.lower * powers, self.problem.upper * powers
        of = np.repeat(self.problem.relevant(), self._counts()).astype(int)
        fixed = np.zeros(len(self._even()))
        solution = self._program.solve(
            np.concatenate([fixed, lower[of]]),
            np.concatenate([fixed, upper[of]]),
            (float(lower[n]), float(upper[n])),
        )
        return None if solution is None else self._multipliers(solution)

    def _even(self) -> list[int]:
        """Return the derivatives that vanish at the end: none where a cruise may begin earlier."""
        return [] if self.problem.cruising else list(range(2, self.problem.order, 2))

    def _counts(self) -> list[int]:
        """Return how many rows belong to each relevant derivative."""
        near = self._near[self.problem.relevant()]
        return [int(count) for count in near[:, 1:].sum(axis=1) + near.sum(axis=1)]

    def _multipliers(self, solution: Solution) -> Multipliers:
        n = self.problem.order
        bounded, even = self.problem.relevant(), self._even()
        ends = np.zeros(n)
        ends[even] = solution.multipliers[: len(even)]
        atoms, densities = np.zeros((2, n, len(self._cells) + 1))
        rows = np.split(solution.multipliers[len(even) :], np.cumsum(self._counts()[:-1]))
        for k, row in zip(bounded, rows, strict=False):
            open_up, open_down = np.isinf(self.problem.upper[k]), np.isinf(self.problem.lower[k])
            row = np.clip(row, 0.0 if open_down else None, 0.0 if open_up else None)
            near = self._near[k]
            count = near[1:].sum()
            atoms[k, self.parts :: self.parts][near[1:]] = row[:count]
            densities[k] = (row[count:] / self._areas[near]) @ self._hats[near]
        weights = self._units[0] / self._units[:n]
        return Multipliers(
            self._cells, ends * weights, atoms * weights[:, None], densities * weights[:, None]
        )
