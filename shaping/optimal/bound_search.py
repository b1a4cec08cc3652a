"""The search for multipliers that prove a lower bound on the duration: evaluate, refine, again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray
from ..trajectory import Trajectory
from .half_problem import HalfProblem, duration_of
from .mesh import refined
from .multipliers import Multipliers, signed_integrals
from .relaxation import RelaxedProgram

_ROUNDS = 10
_MOST_CELLS = 260
_PATIENCE = 4
_FAR = 0.95  # of a bound known before: what the second round must come to
_STALLED = 0.02  # of the gap: progress in a round below which it counts as idle
_ROUNDING = 1e-13
_CLOSE = 0.7  # of an extreme: where a derivative is farther from it no multiplier is of use


@dataclass(frozen=True, eq=False)
class HalfBound:
    """A half duration that multipliers prove to be the least, in the problem's units.

    Attributes
    ----------
    half : float
        0 where they prove nothing.
    terms : (2, n + 1) array
        What lower and upper bounds of derivative k contribute to the distance in that time.
    multipliers : Multipliers
    cruise : float
        Time from their end to the middle.
    """

    half: float
    terms: FloatArray
    multipliers: Multipliers
    cruise: float


class BoundSearch:
    """Better and better multipliers; half durations in the problem's units.

    A motion known to be good shows where: it loses distance against the bound wherever a
    multiplier is not zero and its bound not active. The mesh is its first `span`. Where that
    leaves out a cruise, the half covers a `distance` above one half.
    """

    def __init__(
        self,
        problem: HalfProblem,
        motion: Trajectory,
        best: float,
        *,
        distance: float,
        span: float,
    ) -> None:
        self.problem, self.motion, self.best = problem, motion, best
        self.distance, self.span = distance, span
        self.kept: Multipliers | None = None

    def run(self, nodes: FloatArray, half: float, target: float) -> None:
        """Solve and refine until `half` is proven to `target`, or no more comes of it."""
        parts = 3 if self.problem.order < 6 else 2
        at, reached, idle = 1.0 if self.problem.cruising else half, 0.0, 0
        for trial in range(_ROUNDS):
            multipliers = RelaxedProgram(self.problem, nodes, parts, self._near(nodes)).solve(at)
            if multipliers is None:  # which may take another way with more rows
                multipliers = RelaxedProgram(self.problem, nodes, parts).solve(at)
            if multipliers is None:
                return
            found, waste, slack = self._take(multipliers, parts)
            idle = idle + 1 if found - reached < _STALLED * (half - found) else 0
            reached = max(reached, found)
            hopeless = idle == _PATIENCE or (trial and reached < _FAR * self.best)
            if half <= self.best * (1.0 + target) or hopeless:
                return
            at = 1.0 if self.problem.cruising else self.best
            nodes = refined(nodes, multipliers, waste, slack)
            if len(nodes) > _MOST_CELLS:
                return

    def _near(self, nodes: FloatArray) -> NDArray[np.bool_]:
        """Tell at which nodes, or next to which, a derivative comes near the motion's extremes."""
        values = self.motion.evaluate(nodes * self.span)[: self.problem.order]
        near: NDArray[np.bool_] = values >= _CLOSE * values.max(axis=1, keepdims=True)
        near |= values <= _CLOSE * values.min(axis=1, keepdims=True)
        beside = near.copy()
        beside[:, 1:] |= near[:, :-1]
        beside[:, :-1] |= near[:, 1:]
        return beside

    def _take(self, multipliers: Multipliers, parts: int) -> tuple[float, FloatArray, FloatArray]:
        """Return the bound, and what the motion loses against it, see `refined`."""
        coefficients, rounding = multipliers.costates()
        up, down = signed_integrals(coefficients, multipliers.cells, rounding)
        half = self._bound(multipliers, float(up.sum()), float(down.sum())).half
        if half > self.best:
            self.best, self.kept = half, multipliers.merged(parts)
        times = np.concatenate([[0.0], np.cumsum(multipliers.cells)])
        waste = self._waste(times, np.asarray(up, float), np.asarray(down, float))
        return half, waste, self._slack(times, multipliers, parts)

    def found(self) -> HalfBound | None:
        """Return the best bound found, None where there is no better one than that at first."""
        if self.kept is None:
            return None
        coefficients, rounding = self.kept.costates()
        up, down = signed_integrals(coefficients, self.kept.cells, rounding)
        return self._bound(self.kept, float(up.sum()), float(down.sum()))

    def _bound(self, multipliers: Multipliers, up: float, down: float) -> HalfBound:
        """Return what multipliers prove, ∫p⁺ and ∫p⁻ being `up` and `down`.

        R/2 = Σ_k worth[k]·η^k, or with a cruise R/2 = Σ_k worth[k] + L_1·(η − 1): velocity is at
        most L_1 after the first 1, and η is known to be more.
        """
        positive, negative = multipliers.masses()
        masses = np.array([np.append(-negative, -down), np.append(positive, up)])
        bounds = np.array([self.problem.lower, self.problem.upper])
        worth = masses * np.where(masses == 0.0, 0.0, bounds)
        end = float(multipliers.cells.sum())
        if self.problem.cruising:
            ahead = self.distance - float(worth.sum())
            worth[1, 1] += ahead
            cruise = max(ahead / float(self.problem.upper[1]), 0.0)
            return HalfBound(end + cruise if ahead > 0.0 else 0.0, worth, multipliers, cruise)
        half = duration_of(worth.sum(axis=0), self.distance, self.best)
        terms = worth * half ** np.arange(worth.shape[1])
        sound = terms.sum() <= self.distance * (1.0 + _ROUNDING)
        return HalfBound(half * end if sound else 0.0, terms, multipliers, 0.0)

    def _waste(self, times: FloatArray, up: FloatArray, down: FloatArray) -> FloatArray:
        middles = 0.5 * (times[1:] + times[:-1]) * self.span
        inputs = self.motion(middles, self.problem.order) / self.motion.peak(self.problem.order)
        return np.asarray(
            np.maximum(up + down - (up - down) * inputs, 0.0) * self.problem.upper[-1]
        )

    def _slack(self, times: FloatArray, multipliers: Multipliers, parts: int) -> FloatArray:
        at = times[::parts] * self.span
        lost = np.zeros(len(at))
        for k in self.problem.relevant():
            sizes = multipliers.sizes(k, parts)
            share = np.sign(sizes) * self.motion(at, k) / self.motion.peak(k)
            lost += np.abs(sizes) * np.maximum(1.0 - share, 0.0) * self.problem.upper[k]
        halves = 0.5 * lost
        return np.asarray(halves[1:] + halves[:-1])
