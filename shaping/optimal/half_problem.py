"""The first half of a move as a linear program: how far it gets in a given time.

Distance is counted in units of the move's, time in units of half the closed form's duration, and
a half duration η is brought to 1: z_k(τ) = x^(k)·η^k, L_k·η^k its bound. A move can be taken odd
about its middle, where its derivatives 2, 4, … vanish, and the second half mirrors the first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from ..trajectory import Trajectory
from .linear_program import LinearProgram, Solution
from .state_maps import bernstein_rows, greville_rows, node_maps

_DIGITS = 13  # kept of a bound, so that a change of units leaves the very same program
_REDUNDANT = 3.0  # times the peaks: a bound above that is left out
_NEWTON_STEPS = 30
_CONVERGED = 1e-13
_WIDEST = 4.0  # times what changes derivative n − 1 from bound to bound in the shortest cell


@dataclass(frozen=True, eq=False)
class HalfProblem:
    """Bounds of the first half of a move over a unit distance.

    Parameters
    ----------
    lower, upper : (n + 1,) arrays
        Bounds of derivative k at index k; −inf and inf at index 0.
    peaks : (n + 1,) array
        Of the closed form, or of a better motion: the size of each derivative. Bounds well above
        are left out.
    cruising : bool
        The half must end at full velocity, all higher derivatives zero.
    """

    lower: FloatArray
    upper: FloatArray
    peaks: FloatArray
    cruising: bool = False

    @classmethod
    def make(
        cls, distance: float, limits: Limits, closed: Trajectory, *, relaxed: bool = False
    ) -> HalfProblem:
        """Return the problem of a positive distance, given its closed form.

        Derivatives 2, 4, … have opposite signs in the two halves: of bounds that differ between
        the directions a motion that is odd about its middle must keep the smaller. `relaxed`
        takes the mean of both, which any motion made odd keeps: (x(t) + R − x(T − t)) / 2.
        """
        n = limits.order
        half = 0.5 * closed.duration
        lower, upper = np.full(n + 1, -inf), np.full(n + 1, inf)
        for k, sides in enumerate(zip(limits.lower, limits.upper, strict=True), start=1):
            low, high = (side * half**k / distance for side in sides)
            if k % 2 == 0 or (k == n and not isfinite(high - low)):
                high = 0.5 * (high - low) if relaxed else min(-low, high)
                low = -high
            lower[k], upper[k] = low, high
        peaks = np.array([closed.peak(k) * half**k / distance for k in range(n + 1)])
        return cls(_rounded(lower), _rounded(upper), _rounded(peaks))

    @property
    def order(self) -> int:
        """Highest bounded derivative n."""
        return len(self.upper) - 1

    def ends(self, half: float) -> FloatArray:
        """Return what the derivatives must be at the end of a half duration; NaN where free."""
        ends = np.full(self.order + 1, np.nan)
        ends[2 : self.order : 1 if self.cruising else 2] = 0.0
        if self.cruising:
            ends[1] = self.upper[1] * half
        return ends

    def relevant(self) -> list[int]:
        """Return the derivatives below n whose bounds the peaks come near."""
        least = np.minimum(self.upper, -self.lower)[:-1]
        return [k for k in range(1, self.order) if least[k] <= _REDUNDANT * self.peaks[k]]

    def reaching(self, peaks: FloatArray) -> HalfProblem:
        """Return the problem with larger peaks where these derivatives exceed the ones it has."""
        return replace(self, peaks=np.maximum(self.peaks, _rounded(peaks)))

    def completed(self, nodes: FloatArray, inputs: FloatArray, half: float) -> HalfProblem:
        """Return the problem with the bounds that were left out although these inputs break them.

        Itself where there are none.
        """
        reached = np.abs(self._reached(nodes, inputs, half)).max(axis=1)
        least = np.minimum(self.upper, -self.lower)[:-1]
        broken = reached > least
        broken[[0, *self.relevant()]] = False
        if not broken.any():
            return self
        return self.reaching(np.append(np.where(broken, least, 0.0), 0.0))

    def levels(self, nodes: FloatArray, inputs: FloatArray, half: float) -> FloatArray:
        """Return the relevant derivatives over their bounds at the nodes of a half duration."""
        bounded = self.relevant()
        least = np.minimum(self.upper, -self.lower)[bounded]
        return self._reached(nodes, inputs, half)[bounded] / least[:, None]

    def _reached(self, nodes: FloatArray, inputs: FloatArray, half: float) -> FloatArray:
        """Return the derivatives below n at the nodes, (n, N + 1)."""
        powers = half ** np.arange(self.order)
        return np.asarray(node_maps(nodes, self.order)[:-1] @ inputs / powers[:, None])

    def units(self, shortest: float) -> FloatArray:
        """Return the size of each derivative where the shortest cell is as long as this.

        An input so large that no cell can make use of it would spoil the scaling.
        """
        units = self.peaks.copy()
        units[-1] = min(units[-1], _WIDEST * units[-2] / shortest)
        return units


def _rounded(values: FloatArray) -> FloatArray:
    return np.array([float(f"{value:.{_DIGITS - 1}e}") for value in values])


@dataclass(frozen=True, eq=False)
class Farthest:
    """How far a half gets, by what inputs, and what the bound on each derivative is worth.

    distance = Σ_k worth[k]·η^k, with worth[k] the multipliers' sum over the bounds L_k. `losses`
    estimates the distance lost on each cell by keeping to this mesh.
    """

    distance: float
    inputs: FloatArray
    worth: FloatArray
    losses: FloatArray


class HalfProgram:
    """The linear program of a half on a mesh, bounds kept between the nodes as well.

    Parameters
    ----------
    problem : HalfProblem
    nodes : (N + 1,) array
        From 0 to 1; the input is constant between them.
    """

    def __init__(self, problem: HalfProblem, nodes: FloatArray) -> None:
        n, bounded = problem.order, problem.relevant()
        self.problem, self.nodes, cells = problem, nodes, np.diff(nodes)
        maps = node_maps(nodes, n)
        self._units = problem.units(float(cells.min()))
        scales = self._units[n] / self._units
        rows = [bernstein_rows(maps, cells, k) * scales[k] for k in bounded]
        values = [greville_rows(maps, cells, k) * scales[k] for k in bounded]
        self._greville = np.vstack([np.empty((0, len(cells))), *values])
        fixed = np.flatnonzero(np.isfinite(problem.ends(1.0)))
        ends = maps[fixed, -1] * scales[fixed, None]
        self._derivative = np.repeat([*bounded, *fixed], [*map(len, rows), *[1] * len(fixed)])
        self._free = len(self._derivative) - len(fixed)
        self._program = LinearProgram(maps[0, -1] * scales[0], np.vstack([*rows, ends]))

    def solve(self, half: float) -> Farthest | None:
        """Return how far a half of duration η gets; None where the solver fails."""
        n, of = self.problem.order, self._derivative
        powers = half ** np.arange(n + 1) / self._units
        lower, upper = self.problem.lower * powers, self.problem.upper * powers
        rows = lower[of], upper[of]
        for row in rows:
            row[self._free :] = (self.problem.ends(half) / self._units)[of[self._free :]]
        inputs = float(lower[n]), float(upper[n])
        solution = self._program.solve(*rows, inputs)
        if solution is None:
            return None
        return Farthest(
            solution.value * float(self._units[0]),
            np.clip(solution.inputs, *inputs) * self._units[n],
            self._worth(solution, *rows, inputs) / half ** np.arange(n + 1),
            (self._switch_losses(solution, inputs[1]) + self._row_losses(solution, *rows))
            * float(self._units[0]),
        )

    def _switch_losses(self, solution: Solution, most: float) -> FloatArray:
        """Return what is lost where the costate changes its sign within a cell.

        Its mean over a cell is the reduced cost over the length; between the middles of the
        neighbours it is taken as linear.
        """
        cells = np.diff(self.nodes)
        middles = 0.5 * (self.nodes[1:] + self.nodes[:-1])
        mean = solution.reduced_costs / cells
        slope = np.abs(np.gradient(mean, middles))
        beyond = np.maximum(0.5 * cells - np.abs(mean) / np.maximum(slope, 1e-300), 0.0)
        return np.asarray(most * slope * beyond**2)

    def _row_losses(self, solution: Solution, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """Return what is lost where a Bernstein coefficient is at its bound, not the motion."""
        held = np.flatnonzero(solution.multipliers[: self._free])
        bounds = np.where(solution.multipliers > 0.0, upper, lower)[held]
        reached = self._greville[held] @ solution.inputs
        losses = solution.multipliers[held] * (bounds - reached)
        count = len(self.nodes) - 1
        return np.bincount(held % count, np.maximum(losses, 0.0), count).astype(float)

    def _worth(
        self, solution: Solution, lower: FloatArray, upper: FloatArray, inputs: tuple[float, float]
    ) -> FloatArray:
        """Return what the bounds of each derivative contribute to the distance."""
        free = self._free
        shares = paid(solution.multipliers[:free], lower[:free], upper[:free])
        worth = np.bincount(self._derivative[:free], shares, self.problem.order + 1).astype(float)
        worth[-1] = paid(solution.reduced_costs, *inputs).sum()
        return np.asarray(worth * self._units[0])


def paid(
    multipliers: FloatArray, lower: FloatArray | float, upper: FloatArray | float
) -> FloatArray:
    """Return each multiplier times the bound that it belongs to, which may have no other side."""
    bounds = np.where(multipliers > 0.0, upper, lower)
    return multipliers * np.where(multipliers == 0.0, 0.0, bounds)


def duration_of(worth: FloatArray, distance: float, guess: float) -> float:
    """Solve Σ_k worth[k]·η^k = distance for η > 0 by Newton's method in logarithms."""
    k = np.arange(len(worth))
    half = guess
    for _ in range(_NEWTON_STEPS):
        terms = worth * half**k
        reached = terms.sum()
        step = np.log(distance / reached) * reached / (k * terms).sum()
        half *= float(np.exp(step))
        if abs(step) < _CONVERGED:
            break
    return half
