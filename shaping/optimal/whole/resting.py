"""Motions between moving states that take much longer than they need: at rest in between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...pieces import FloatArray
from .least_share import gentlest, needed_share, waiting_between
from .problem import WholeProblem
from .repair import Repaired
from .sampled import first_nodes
from .search import Search
from .warm_program import Effort

_ROUGHLY = 0.05  # gap of each part
_EFFORT = 3e8  # for each place that is tried
_SLOWER = (6.0, 24.0, 96.0)  # times the least that both parts take
_HARDLY = 0.01  # of the share: not worth to go on for
_MODERATE = 40.0  # times that: no longer do all cells of a uniform grid matter
_CELLS = 48
_SHARES = (0.5, 0.1, 0.9)  # of the way from the first place of rest to the last


def resting(problem: WholeProblem, time: float) -> Repaired | None:
    """Return a gentle motion of a duration that comes to rest on its way; None where none is found.

    The gentler one of two: that at rest for what is left of the time, and that on a grid over all
    of it, which need not rest.
    """
    parts = _parts(problem, time)
    if parts is None:
        return None
    first, second = parts
    wait = time - first.time - second.time
    motion = waiting_between(first, second, wait)
    middle = first.time / (first.time + second.time)
    for slower in _SLOWER:
        quicker = min(time, slower * (first.time + second.time))
        nodes = np.union1d(first_nodes(problem, quicker), [middle])
        rests = gentlest(problem, nodes, quicker, motion, rest=middle)
        before, share = (needed_share(problem, each) for each in (motion, rests))
        motion = rests if share < before else motion
        if share > before * (1.0 - _HARDLY) or quicker == time:
            break
    grids = [first_nodes(problem, time)]
    if time < _MODERATE * (first.time + second.time):
        grids.append(np.linspace(0.0, 1.0, _CELLS + 1))
    moves = motion
    for nodes in grids:
        moves = gentlest(problem, nodes, time, moves)
    told = [each for each in (motion, moves) if (np.diff(_breaks(each)) > 0.0).all()]
    return min(told, key=lambda each: needed_share(problem, each), default=None)


def _breaks(motion: Repaired) -> FloatArray:
    return np.append(0.0, np.cumsum(motion.durations).astype(float))


def _parts(problem: WholeProblem, time: float) -> tuple[Repaired, Repaired] | None:
    """Return a motion to rest and one from there that together take no longer."""
    effort = Effort(_EFFORT * len(_SHARES))
    for place in _places(problem):
        still = np.eye(problem.order)[0] * place
        first = _found(replace(problem, end=still), effort)
        if first is None or first.time > time:
            continue
        second = _found(replace(problem, start=still), effort)
        if second is not None and first.time + second.time <= time:
            return first, second
    return None


def _found(problem: WholeProblem, effort: Effort) -> Repaired | None:
    search = Search(problem)
    search.run(_ROUGHLY, effort=effort)
    return search.best


def _places(problem: WholeProblem) -> list[float]:
    """Return places where it may rest, between where the start stops and where the end begins."""
    first = problem.start[0] + _braking(problem, problem.start)
    last = problem.end[0] - _braking(problem, problem.end)
    low, high = problem.lower[0], problem.upper[0]
    return [float(np.clip(first + share * (last - first), low, high)) for share in _SHARES]


def _braking(problem: WholeProblem, state: FloatArray) -> float:
    """Return about how far a state goes until it stands: half its velocity all the time."""
    sizes = np.minimum(np.abs(problem.lower), np.abs(problem.upper))
    times = [
        (np.abs(state[1:k]) / sizes[k]) ** (1.0 / np.arange(k - 1, 0, -1))
        for k in range(2, problem.order + 1)
        if 0.0 < sizes[k] < np.inf
    ]
    return float(0.5 * state[1] * sum(each.max() for each in times))
