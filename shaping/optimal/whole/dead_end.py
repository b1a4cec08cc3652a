"""States that no motion within the bounds leaves, or leads to: proofs by a free end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .costate import Multipliers
from .elastic import Elastic
from .maps import node_states
from .polynomials import value
from .problem import WholeProblem
from .relaxation import MeanRows
from .sampled import first_sizes
from .warm_program import Effort

_CELLS = 40
_PARTS = 2
_HALVINGS = 10
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


def _leaving(
    problem: WholeProblem, longest: float, effort: Effort
) -> tuple[float, Multipliers] | None:
    n, nodes = problem.order, np.linspace(0.0, 1.0, _CELLS + 1)
    maps = node_states(nodes, n, _PARTS)
    means = MeanRows.make(problem, maps, nodes, _PARTS)
    every = np.ones(len(means.rows.derivative), dtype=bool)
    for halving in range(_HALVINGS):
        time = longest * 0.5**halving
        sizes = first_sizes(problem, time)
        program = Elastic(problem, maps[:, -1], means.rows, sizes, every, free=True, effort=effort)
        found = program.solve(time)
        if found is None or not found.missing > _CLEARLY:
            continue
        multipliers = means.multipliers(problem, found.ends, found.rows)
        if value(multipliers.polynomial(problem, multipliers.costate()), time) > 0.0:
            return time, multipliers
    return None
