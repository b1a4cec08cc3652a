"""The multipliers that tell how far a motion comes from its start in a time, by one program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...pieces import FloatArray
from .costate import Multipliers
from .elastic import Elastic
from .maps import node_states
from .problem import WholeProblem
from .relaxation import MeanRows
from .sampled import first_sizes
from .search import parts_of
from .warm_program import Effort


def farthest(
    problem: WholeProblem, nodes: FloatArray, time: float, effort: Effort
) -> Multipliers | None:
    """Return multipliers with λ = (λ_0, 0, …, 0), λ_0 > 0; None where the program tells nothing.

    Of the program whose end is out of reach, and misses its derivatives at no cost.
    """
    n, parts = problem.order, parts_of(problem.order, len(nodes) - 1)
    end = np.zeros(n)
    end[0] = problem.start[0] + max(float(problem.upper[1]), float(problem.start[1])) * time
    maps = node_states(nodes, n, parts)
    means = MeanRows.make(problem, maps, nodes, parts)
    every = np.ones(len(means.rows.derivative), dtype=bool)
    program = Elastic(
        replace(problem, end=end),
        maps[:, -1],
        means.rows,
        first_sizes(problem, time),
        every,
        weight=0.0,
        effort=effort,
    )
    found = program.solve(time)
    if found is None or not found.ends[0] > 0.0:
        return None
    return means.multipliers(problem, found.ends * np.eye(n)[0], found.rows)
