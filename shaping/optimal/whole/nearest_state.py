"""The nearest state to a dead end that is none: one number of it changed, by linear programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf

import numpy as np

from .maps import node_states
from .problem import WholeProblem
from .restriction import hull_rows
from .sampled import first_sizes
from .warm_program import Effort, WarmProgram

_CELLS = 48
_GRADED = 2.0  # cells are short where the motion begins
_LONGER = (1.0, 3.0, 9.0, 27.0)  # times the time in which no bound is kept
_ANY = tuple(2.0**i for i in range(-6, 7))
_TRIED = (1.0, 0.25, 4.0, 0.05)  # durations of a motion to rest
_SHRINK = 2e-3  # of the highest bound: so that what is found is inside
_HARDLY = 0.01  # less, relative: then a longer time is of no use
_NOTHING = 1e-7  # of its size: a value that is zero


def nearest_starts(
    problem: WholeProblem, time: float, effort: Effort
) -> Iterator[tuple[int, float]]:
    """Yield numbers of starts from which a motion comes to rest within the bounds, nearest first.

    Each is a derivative and the value that it can have there, all others being as they are; near
    is what changes by a small share of its range.

    Parameters
    ----------
    problem : WholeProblem
        Whose start no motion leaves within the bounds.
    time : float
        In which one is broken at the latest.
    """
    found: list[tuple[float, int, float]] = []
    free = not np.isfinite([problem.lower[0], problem.upper[0]]).any()
    for k in range(int(free), problem.order):
        times = [time * longer for longer in _LONGER]
        change = _least_change(problem, k, times, effort, onto=False)
        if change < inf:
            size = abs(float(problem.start[k])) + abs(change)
            share = abs(change) / min(float(problem.upper[k] - problem.lower[k]), 4.0 * size)
            found.append((share, k, _changed(problem, k, change)))
    for _, k, value in sorted(found):
        yield k, value


def nearest_end(problem: WholeProblem, derivative: int, effort: Effort) -> float | None:
    """Return the nearest value of a derivative at the end to which a motion leads; None if none."""
    seen = problem.reversed()
    change = _least_change(seen, derivative, _ANY, effort, onto=True)
    sign = -1.0 if derivative % 2 else 1.0
    return None if change == inf else sign * _changed(seen, derivative, change)


def comes_to_rest(problem: WholeProblem, effort: Effort) -> bool:
    """Tell whether a motion is found from the start to rest within the bounds, in about unit time.

    That none is found proves nothing.
    """
    if not problem.start[1:].any():
        return True
    highest, most = problem.order - 1, float(problem.upper[-1] - problem.lower[-1])
    return any(
        abs(_change(problem, highest, time, effort, onto=False)) <= _NOTHING * most * time
        for time in _TRIED
    )


def _changed(problem: WholeProblem, derivative: int, change: float) -> float:
    start = float(problem.start[derivative])
    value = start + change
    return 0.0 if abs(value) <= _NOTHING * (abs(start) + abs(change)) else value


def _least_change(
    problem: WholeProblem, derivative: int, times: Iterable[float], effort: Effort, *, onto: bool
) -> float:
    least = inf
    for time in times:
        last, change = least, _change(problem, derivative, time, effort, onto=onto)
        least = min(least, change, key=abs)
        if least < inf and abs(least) > (1.0 - _HARDLY) * abs(last):
            break
    return least


def _change(
    problem: WholeProblem, derivative: int, time: float, effort: Effort, *, onto: bool
) -> float:
    """Return the least change of a derivative at the start; infinite where there is none.

    minimise |e|   subject to   x^(k)(0) = a_k + e for this k, all bounds, and at the end rest
    anywhere, or the state there where the motion is to come `onto` it.
    """
    n, nodes = problem.order, np.linspace(0.0, 1.0, _CELLS + 1) ** _GRADED
    maps, sizes = node_states(nodes, n, 1), first_sizes(problem, time)
    rows = hull_rows(problem, maps, nodes, sizes, 0.0)
    powers = time ** np.arange(n + 1)
    given = np.arange(0 if onto else 1, n)
    of = np.concatenate([given, rows.derivative, [derivative]])
    own = np.zeros((1, _CELLS + n))
    own[0, _CELLS + derivative] = 1.0
    stacked = np.vstack([maps[given, -1], rows.matrix, own]) / sizes[of][:, None]
    free = stacked[:, _CELLS:] @ (problem.start * powers[:n])
    changed = stacked[:, _CELLS + derivative, None] * sizes[derivative]
    matrix = np.hstack([stacked[:, :_CELLS] * sizes[n], changed, -changed])
    lower, upper = (
        (side * powers)[of] / sizes[of] - free for side in (problem.lower, problem.upper)
    )
    goal = problem.end * powers[:n] / sizes[:n] * onto
    lower[: len(given)] = upper[: len(given)] = goal[given] - free[: len(given)]
    least, most = (
        np.full(_CELLS, side[n] * powers[n] / sizes[n] * (1.0 - _SHRINK))
        for side in (problem.lower, problem.upper)
    )
    costs, every = np.append(np.zeros(_CELLS), [1.0, 1.0]), np.ones(len(matrix), dtype=bool)
    program = WarmProgram(matrix, costs, every, effort)
    optimum = program.solve(lower, upper, np.append(least, [0.0, 0.0]), np.append(most, [inf, inf]))
    if optimum is None:
        return inf
    up, down = optimum.columns[-2:]
    return float((up - down) * sizes[derivative] / powers[derivative])
