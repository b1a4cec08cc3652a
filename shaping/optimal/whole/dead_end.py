"""States that no motion within the bounds leaves, or leads to: proofs by a free end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .costate import Multipliers
from .elastic import Elastic
from .maps import node_states
from .polynomials import last_root, value
from .problem import WholeProblem
from .relaxation import MeanRows
from .sampled import first_sizes
from .warm_program import Effort

_CELLS = 40
_PARTS = 2
_HALVINGS = 10
_STEPS = 10
_HARDLY = 5e-3  # relative: a step that is the last
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
    sides = [
        (backwards, _Leaving(seen, effort))
        for backwards, seen in enumerate((problem, problem.reversed()))
        if seen.start[1:].any()  # at rest it can stay
    ]
    for halving in range(_HALVINGS):
        time = longest * 0.5**halving
        for backwards, leaving in sides:
            multipliers = leaving.excluded(time)
            if multipliers is not None:
                return DeadEnd(time, multipliers, bool(backwards))
    return None


def kept_until(problem: WholeProblem, dead: DeadEnd, effort: Effort) -> float:
    """Return about how long a motion from a dead end can keep the bounds.

    By Newton's method from above: multipliers exclude down to a root of their polynomial.
    """
    leaving = _Leaving(problem.reversed() if dead.backwards else problem, effort)
    time = dead.time
    multipliers: Multipliers | None = dead.multipliers
    for _ in range(_STEPS):
        if multipliers is None:
            break
        polynomial = multipliers.polynomial(leaving.problem, multipliers.costate())
        before, time = time, max(last_root(polynomial, time), _SHORTEST * dead.time)
        if time >= before * (1.0 - _HARDLY):
            break
        multipliers = leaving.excluded(time)
    return time


class _Leaving:
    """The program of a motion that leaves the start, bounds given way to alike."""

    def __init__(self, problem: WholeProblem, effort: Effort) -> None:
        n, nodes = problem.order, np.linspace(0.0, 1.0, _CELLS + 1)
        self.problem, self._effort = problem, effort
        self._maps = node_states(nodes, n, _PARTS)
        self.means = MeanRows.make(problem, self._maps, nodes, _PARTS)
        self._every = np.ones(len(self.means.rows.derivative), dtype=bool)

    def excluded(self, time: float) -> Multipliers | None:
        """Return multipliers that prove that bounds are broken by a time; None if none are found.

        Bounds give way by the least that it takes.
        """
        problem, rows, ends = self.problem, self.means.rows, self._maps[:, -1]
        sizes = first_sizes(problem, time)
        program = Elastic(problem, ends, rows, sizes, self._every, free=True, effort=self._effort)
        found = program.solve(time)
        if found is None or not found.missing > _CLEARLY:
            return None
        multipliers = self.means.multipliers(problem, found.ends, found.rows)
        proven = value(multipliers.polynomial(problem, multipliers.costate()), time) > 0.0
        return multipliers if proven else None
