"""The search for the minimum time: durations excluded from below, motions found from above.

On each grid the relaxed program's multipliers exclude durations from the last one excluded on:
the first root of their polynomial is the next, which is Newton's method from below. The
restricted program then goes the same way until there is a motion. Where both differ most the grid
is refined.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from ..proof import TaylorLink
from .costate import Multipliers
from .dead_end import DeadEnd, dead_end
from .elastic import Elastic, Found, Rows
from .first_time import taylor_chain
from .maps import fine_edges, merged_parts, node_states
from .polynomials import first_root, value
from .problem import WholeProblem
from .refining import (
    broken_inside,
    coarser,
    duality_losses,
    hull_losses,
    refined,
    worst_cells,
)
from .relaxation import MeanRows
from .relaxed_program import Relaxed, RelaxedProgram
from .repair import Repaired, repaired
from .restriction import MARGIN, hull_rows
from .sampled import Sampled, are_near, first_nodes, first_sizes
from .warm_program import Effort

_MOST_CELLS = 180
_MOST_INPUTS = 1000  # of a relaxed program: with more the simplex method takes seconds
_ROUNDS = 14
_STEPS = 40
_FOUND = 1e-7  # missing: less is left to the repair
_NEARLY = 1e-6  # missing: no more than what roundings of the solver may make
_WAIT = 3e-8  # of the duration: a step on where the repair fails
_LEAP = 4.0  # times the duration: no step on is longer, as scales are those of the first
_NEAR = 0.12  # of the range: rows that a program starts with
_DOUBTFUL = 3  # rounds after which, without a motion, start and end are looked at
_LOOK = 5e8  # effort that this may take in any case
_FAR = 3.0  # times the duration that a round starts with: how far it goes without a motion
_TOO_LONG = 300.0  # times the first duration excluded: without a motion by then the search ends
_PATIENT = 3  # rounds with the whole margin for the repair
_LESS_ROOM = 0.25  # of the margin in every later round: next to a stop it may cost much time
_NO_ROOM = 10.0  # times the margin: a state so near to a dead end that no more is missing
_LITTLE_ROOM = 0.01
_BACK = 1e-5  # of the duration: the first step back to one that a grid excludes
_STEPS_BACK = 4
_SLOW = 0.7  # of the gap: a round that leaves more does not make the grid coarser anywhere
_COARSE = 5e-3  # gap above which the relaxed program's own motion tells where to refine, too


@dataclass(frozen=True, eq=False)
class Link:
    """Durations from low to high are impossible by these multipliers."""

    low: float
    high: float
    multipliers: Multipliers


class Search:
    """What is known about the minimum time of a problem in its own units.

    Attributes
    ----------
    lower : float
        Every duration below is impossible, by the `chain`; infinite where all are.
    best : Repaired or None
        The fastest motion found.
    after : float
        Shorter durations are not asked for, and not part of the `chain`.
    later : list of Search
        For motions that take longer, on the same problem.
    """

    def __init__(
        self, problem: WholeProblem, nodes: FloatArray | None = None, *, after: float = 0.0
    ) -> None:
        self.problem, self.after = problem, after
        self.chain: list[TaylorLink | Link] = [] if after else list(taylor_chain(problem))
        self.lower = self.chain[-1].high if self.chain else after
        self.later: list[Search] = []
        self.best: Repaired | None = None
        self.guide: Sampled | None = None
        self.nodes = first_nodes(problem, self.lower) if nodes is None else nodes
        self.dead_end: DeadEnd | None = None
        self.rounds = 0
        self.effort = Effort()
        self._sizes = np.ones(problem.order + 1)
        self._margin = MARGIN

    @property
    def gap(self) -> float:
        """How far the fastest motion is from the durations excluded, relative."""
        if self.best is None or not self.lower > 0.0:
            return inf
        return max(self.best.time / self.lower - 1.0, 0.0)

    @property
    def ended(self) -> bool:
        """Whether no more comes of it: a grid too fine, too many rounds, or a dead end."""
        spent = self.rounds >= _ROUNDS or len(self.nodes) > _MOST_CELLS
        return spent or self.effort.left <= 0.0 or self.dead_end is not None

    def run(self, rtol: float, rounds: int = _ROUNDS, effort: Effort | None = None) -> None:
        """Refine until the gap is at most `rtol`, no more comes of it, or the effort is spent."""
        first = self.lower
        self.effort = effort or Effort()
        while self.lower < inf and self.gap > rtol and self.rounds < rounds:
            if self.rounds and self.effort.left <= 0.0:
                return
            self._round(rtol)
            self.rounds += 1
            if self.rounds <= _DOUBTFUL and self.best is None:
                self._look_for_dead_end()
            stuck = self.best is None and self.lower > _TOO_LONG * first
            ended = len(self.nodes) > _MOST_CELLS or self.effort.left <= 0.0
            if self.dead_end is not None or stuck or ended:
                return

    def _look_for_dead_end(self) -> None:
        """Look for one, once more where a program has just spent all effort."""
        most = max(self.effort.left, _LOOK)
        effort = Effort(most)
        self.dead_end = dead_end(self.problem, self.lower, effort)
        self.effort.left -= most - effort.left

    def _round(self, rtol: float) -> None:
        problem, n = self.problem, self.problem.order
        before, gap, self._sizes = self.lower, self.gap, self._sizes_of_guide()
        parts = parts_of(n, len(self.nodes) - 1)
        maps = node_states(self.nodes, n, parts)
        relaxed = self._exclude(maps, parts, rtol)
        if self.lower == inf or self.gap <= rtol:
            return
        coarse = merged_parts(maps, parts, n)
        margin = self._margin * _LESS_ROOM ** max(self.rounds - _PATIENT, 0)
        if problem.may_hold and self.rounds == 0:
            margin = 0.0  # a bound that is held from start to end leaves no room
        rows = hull_rows(problem, coarse, self.nodes, self._sizes, margin)
        near = self._near(rows, self.nodes)
        program = Elastic(
            problem, coarse[:, -1], rows, self._sizes, near, shrink=margin, effort=self.effort
        )
        found, motion = self._approach(program)
        if found is not None and found.missing <= _NEARLY:
            self.guide = motion
        if self.best is None and found is not None and found.missing <= _NO_ROOM * self._margin:
            self._margin *= _LITTLE_ROOM
        if self.gap > rtol and self.effort.left > 0.0:
            idle = self.lower <= before * (1.0 + 0.02 * rtol)
            slow = _SLOW * gap < self.gap < inf
            self.nodes = self._refined(relaxed, rows, found, motion, (idle, slow))

    def _sizes_of_guide(self) -> FloatArray:
        if self.guide is None:
            return first_sizes(self.problem, max(self.lower, 1e-9))
        return self.guide.sizes(self.problem)

    def _near(self, rows: Rows, edges: FloatArray) -> NDArray[np.bool_]:
        """Tell which rows the last motion comes near the bounds of: all where there is none."""
        if self.guide is None:
            return np.ones(len(rows.derivative), dtype=bool)
        problem, time = self.problem, self.guide.time
        start = problem.start * time ** np.arange(problem.order)
        values = rows.matrix @ np.concatenate([self.guide.on(edges), start])
        return are_near(problem, values, rows.derivative, time, self._sizes, _NEAR)

    def _exclude(self, maps: FloatArray, parts: int, rtol: float) -> Relaxed | None:
        """March from the last duration excluded; return what the last program tells.

        Where the grid excludes no more, that is what it tells of a shorter duration.
        """
        program = self._relaxed_program(maps, parts)
        enough = max(0.02 * rtol, 3e-4 / 10.0**self.rounds)
        last = None
        farthest = _FAR * self.lower if self.best is None else inf
        for _ in range(_STEPS):
            time = self.lower
            if farthest < time < inf:
                return last
            answer = program.solve(time)
            if answer is None:
                return last
            if not value(answer.polynomial, time) > 0.0:
                return answer if last is not None else self._told_before(program) or answer
            last = answer
            self.lower = first_root(answer.polynomial, time)
            if self.lower > time:
                self.chain.append(Link(time, self.lower, answer.multipliers))
            if self.lower == inf or self.lower <= time * (1.0 + enough):
                return last
        return last

    def _relaxed_program(self, maps: FloatArray, parts: int) -> RelaxedProgram:
        problem, edges = self.problem, fine_edges(self.nodes, parts)
        means = MeanRows.make(problem, maps, self.nodes, parts)
        near, guide = self._near(means.rows, edges), self.guide
        high = None if guide is None else guide.switched_on(edges, problem)
        program = Elastic(
            problem, maps[:, -1], means.rows, self._sizes, near, effort=self.effort, high=high
        )
        return RelaxedProgram(program, means, edges)

    def _told_before(self, program: RelaxedProgram) -> Relaxed | None:
        """Return what a program tells of the first shorter duration that it excludes."""
        back = min(max(self.gap, _BACK), 0.1)
        for _ in range(_STEPS_BACK):
            answer = program.solve(self.lower * (1.0 - back))
            if answer is None or answer.found.missing > _NEARLY:
                return answer
            back *= 4.0
            if back > 0.5:
                return None
        return None

    def _approach(self, program: Elastic) -> tuple[Found | None, Sampled | None]:
        """Go on to the first motion that the restricted program has; return the nearest one."""
        time, motion, found, waited = self.lower, None, None, _WAIT
        for _ in range(_STEPS):
            answer = program.solve(time)
            if answer is None:
                break
            here = Sampled(self.nodes, answer.inputs, time)
            if found is None or answer.missing <= found.missing:
                found, motion = answer, here
            if answer.missing <= _FOUND and self._take(here):
                break
            later = min(first_root(answer.polynomial, time), _LEAP * time)
            if answer.missing <= _NEARLY:  # what is left is the solver's
                later, waited = min(max(later, time * (1.0 + waited)), time * 1.001), 4.0 * waited
            if later <= time:
                break
            time = later
        return found, motion

    def _take(self, motion: Sampled) -> bool:
        """Repair a motion, and keep it where it is the fastest; tell whether it could be had."""
        if self.best is not None and motion.time >= self.best.time:
            return True
        found = repaired(self.problem, motion)
        if found is not None:
            self.best = found
        return found is not None

    def _refined(
        self,
        relaxed: Relaxed | None,
        rows: Rows,
        found: Found | None,
        motion: Sampled | None,
        fails: tuple[bool, bool],
    ) -> FloatArray:
        """Return a grid finer where most is lost; coarser elsewhere but where the round failed.

        `fails`: whether it excluded no more, and whether it left most of the gap.
        """
        idle, slow = fails
        problem, count = self.problem, len(self.nodes) - 1
        cells = np.empty(0, dtype=int)
        total = np.zeros(count)
        costate = None
        if relaxed is not None:
            costate = relaxed.costate
            if motion is not None:
                losses = duality_losses(problem, relaxed.means, relaxed.found, costate, motion)
                cells, total = np.union1d(cells, worst_cells(losses)), total + losses
            if self.gap > _COARSE:
                losses = duality_losses(
                    problem, relaxed.means, relaxed.found, costate, relaxed.motion
                )
                cells = np.union1d(cells, worst_cells(losses))
            if idle:
                broken = broken_inside(problem, relaxed.motion, len(relaxed.motion.inputs) // count)
                cells = np.union1d(cells, worst_cells(broken))
        if found is not None:
            losses = hull_losses(problem, rows, found, self.nodes)
            cells, total = np.union1d(cells, worst_cells(losses)), total + losses
        inputs = np.zeros(count) if motion is None else motion.inputs
        if not len(cells):
            cells = np.arange(count)
        finer = refined(self.nodes, cells.astype(int), costate, inputs)
        if idle or slow or motion is None or found is None or found.missing > _NEARLY:
            return finer
        kept = coarser(problem, motion, total)
        dropped = np.setdiff1d(self.nodes, kept)
        return np.setdiff1d(finer, dropped)


def parts_of(order: int, cells: int) -> int:
    """Return how many inputs a cell of the relaxed program has: fewer where there would be many."""
    return min(max(order, 4), max(_MOST_INPUTS // cells, 1))
