"""A motion between states so near that the first durations tell nothing: on, round and back."""

from __future__ import annotations

from math import ldexp

import numpy as np

from .problem import WholeProblem, power_of_two
from .repair import Repaired
from .search import Search
from .warm_program import EFFORT, Effort

_MUCH = 100.0  # times the least duration: what the states take to vanish
_FIRST = 0.125  # of that: where the search begins
_ROUGHLY = 1e-3
_EFFORT = 0.1 * EFFORT


def detour(problem: WholeProblem, least: float) -> Repaired | None:
    """Return a motion that takes about what its states take to come to rest, or None.

    In units of that time, and from a share of it on: shorter ones are not looked for.
    """
    time = _vanishing(problem)
    if not _MUCH * least < time < np.inf:
        return None
    unit = power_of_two(time)
    length = power_of_two(problem.length_in(time))
    search = Search(problem.scaled(length, unit), after=_FIRST * ldexp(time, -unit))
    search.run(_ROUGHLY, effort=Effort(_EFFORT))
    found = search.best
    if found is None:
        return None
    powers = length - unit * np.arange(problem.order + 1)
    states = np.ldexp(found.states, powers[:, None])
    states[0] += problem.start[0]
    return Repaired(np.ldexp(found.durations, unit), states, ldexp(found.time, unit))


def _vanishing(problem: WholeProblem) -> float:
    """Return about the time that the derivatives at both ends take to vanish."""
    n = problem.order
    bounds = np.minimum(np.abs(problem.lower), np.abs(problem.upper))
    sizes = np.maximum(np.abs(problem.start), np.abs(problem.end))
    pairs = [(k, m) for k in range(1, n) for m in range(k + 1, n + 1) if bounds[m] > 0.0]
    return max((float((sizes[k] / bounds[m]) ** (1.0 / (m - k))) for k, m in pairs), default=0.0)
