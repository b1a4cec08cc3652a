"""States that no motion within the bounds leaves, or leads to: proofs by a free end."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from .costate import Multipliers
from .elastic import Elastic, Found
from .maps import node_states
from .polynomials import value
from .problem import WholeProblem
from .relaxation import MeanRows
from .sampled import first_sizes
from .warm_program import Effort

_CELLS = 40
_PARTS = 2
_HALVINGS = 10
_BISECTIONS = 10
_SHORTEST = 1e-4  # of the time in which a bound is broken
_CLEARLY = 1e-7  # of the sizes: an excess below is the solver's


@dataclass(frozen=True, eq=False)
class DeadEnd:
    """No motion of this duration or longer leaves the start within the bounds.

    Attributes
    ----------
    time : float
    multipliers : Multipliers
        With λ = 0, of the problem from its start on, or run backwards from its end.
    backwards : bool
        Whether it is the end that cannot be reached.
    """

    time: float
    multipliers: Multipliers
    backwards: bool


def dead_end(problem: WholeProblem, longest: float, effort: Effort) -> DeadEnd | None:
    """Return the proof that start or end is one, in up to `longest`; None where none is found."""
    for backwards in (False, True):
        seen = problem.reversed() if backwards else problem
        if not seen.start[1:].any():
            continue  # at rest it can stay
        found = _leaving(seen, longest, effort)
        if found is not None:
            return DeadEnd(found[0], found[1], backwards)
    return None


def kept_until(problem: WholeProblem, dead: DeadEnd) -> float:
    """Return about how long a motion from a dead end can keep the bounds."""
    leaving = _Leaving(problem.reversed() if dead.backwards else problem, Effort())
    low, high = _SHORTEST * dead.time, dead.time
    for _ in range(_BISECTIONS):
        middle = sqrt(low * high)
        found = leaving.solve(middle)
        broken = found is not None and found.missing > _CLEARLY
        low, high = (low, middle) if broken else (middle, high)
    return high


class _Leaving:
    """The program of a motion that leaves the start, bounds given way to alike."""

    def __init__(self, problem: WholeProblem, effort: Effort) -> None:
        n, nodes = problem.order, np.linspace(0.0, 1.0, _CELLS + 1)
        self.problem, self._effort = problem, effort
        self._maps = node_states(nodes, n, _PARTS)
        self.means = MeanRows.make(problem, self._maps, nodes, _PARTS)
        self._every = np.ones(len(self.means.rows.derivative), dtype=bool)

    def solve(self, time: float) -> Found | None:
        """Return by how much bounds are broken in a time at the least; None if the solver fails."""
        sizes = first_sizes(self.problem, time)
        ends, rows = self._maps[:, -1], self.means.rows
        program = Elastic(
            self.problem, ends, rows, sizes, self._every, free=True, effort=self._effort
        )
        return program.solve(time)


def _leaving(
    problem: WholeProblem, longest: float, effort: Effort
) -> tuple[float, Multipliers] | None:
    leaving = _Leaving(problem, effort)
    for halving in range(_HALVINGS):
        time = longest * 0.5**halving
        found = leaving.solve(time)
        if found is None or not found.missing > _CLEARLY:
            continue
        multipliers = leaving.means.multipliers(problem, found.ends, found.rows)
        if value(multipliers.polynomial(problem, multipliers.costate()), time) > 0.0:
            return time, multipliers
    return None
