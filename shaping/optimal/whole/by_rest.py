"""A grid where no motion was found: short cells where two motions, to rest and from it, have them.

Long motions between moving states have ramps at their ends that a grid of the whole is too coarse
for; a motion that comes to rest half way, and one that goes on from there, are found more easily.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...pieces import FloatArray
from ..mesh import apart
from .problem import WholeProblem
from .search import Search
from .warm_program import Effort

_ROUGHLY = 0.1
_ROUNDS = 5
_APART = 1e-6


def grid_by_rest(problem: WholeProblem, time: float, effort: Effort) -> FloatArray | None:
    """Return a grid of a motion that takes about `time`; None where the two are not found.

    Cells at both ends are as long, in time, as those of the two motions.
    """
    if not ((problem.lower[1:] < 0.0) & (problem.upper[1:] > 0.0)).all():
        return None
    half_way = np.zeros(problem.order)
    half_way[0] = 0.5 * (problem.start[0] + problem.end[0])
    there = _rough(replace(problem, end=half_way), effort)
    onward = _rough(replace(problem, start=half_way), effort)
    if there.best is None or onward.best is None:
        return None
    begun = there.nodes * there.best.time / time
    left = 1.0 - (1.0 - onward.nodes) * onward.best.time / time
    nodes = np.concatenate([begun[begun < 0.5], left[left > 0.5]])
    return np.asarray(nodes[apart(nodes, _APART)])


def _rough(problem: WholeProblem, effort: Effort) -> Search:
    search = Search(problem)
    search.run(_ROUGHLY, _ROUNDS, effort)
    return search
