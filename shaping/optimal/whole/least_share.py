"""Motions of a duration with the smallest share of the highest bound, on a grid refined."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from .maps import node_states
from .problem import WholeProblem
from .refining import refined
from .repair import Repaired, repaired
from .restriction import MARGIN, hull_rows
from .sampled import Sampled
from .warm_program import EFFORT, Effort, WarmProgram

_ROUNDS = 5
_EFFORT = 0.1 * EFFORT
_HARDLY = 5e-4  # of the share
_SAME = 1e-6  # of the largest input: inputs that are one


def gentlest(
    problem: WholeProblem,
    nodes: FloatArray,
    time: float,
    motion: Repaired,
    *,
    rest: float | None = None,
) -> Repaired:
    """Return the motion with the smallest share of the highest bound; as it came if none.

    On grids refined where the input switches, until the share hardly falls. `rest` is a node at
    which it stands still, wherever that is: the motion that came stays there for longer than it
    takes to here, `time` being shorter than its own.
    """
    problem = problem.with_share(min(needed_share(problem, motion), 1.0))
    longer = motion.time - time
    last, effort = inf, Effort(_EFFORT)
    for _ in range(_ROUNDS):
        at = None if rest is None else int(np.searchsorted(nodes, rest))
        found = _with_least_share(problem, nodes, time, motion, at, effort)
        if found is None:
            break
        share, inputs = found
        sampled = Sampled(nodes, inputs, time)
        if share < 1.0:  # else the grid is too coarse to do with as little
            gentle = (
                repaired(problem, sampled) if at is None else _waiting(problem, sampled, at, longer)
            )
            if gentle is None:
                break
            motion = gentle
        if share > last * (1.0 - _HARDLY):
            break
        last = share
        nodes = refined(
            nodes, _switching(problem, inputs, share * time**problem.order), None, inputs
        )
    return motion


def needed_share(problem: WholeProblem, motion: Repaired) -> float:
    """Return the share of the highest bound that a motion needs."""
    inputs = np.asarray(motion.states[-1], float)
    return float(max(inputs.max() / problem.upper[-1], inputs.min() / problem.lower[-1]))


def waiting_between(first: Repaired, second: Repaired, wait: float) -> Repaired:
    """Return a motion to rest, a wait, and another one from there."""
    if wait <= 0.0:
        wait, still = 0.0, first.states[:, :0]
    else:
        still = first.states[:, -1:].copy()
        still[1:] = 0.0
    return Repaired(
        np.concatenate([first.durations, [wait] * still.shape[1], second.durations]),
        np.hstack([first.states[:, :-1], still, second.states]),
        first.time + wait + second.time,
    )


def _waiting(problem: WholeProblem, motion: Sampled, at: int, wait: float) -> Repaired | None:
    """Return a motion that is at rest at a node, with a wait there, each part repaired apart."""
    place, n = np.eye(problem.order)[0] * motion.states(problem)[0, at], problem.order
    middle, nodes, inputs = motion.nodes[at], motion.nodes, motion.inputs
    before = Sampled(nodes[: at + 1] / middle, inputs[:at] * middle**n, motion.time * middle)
    left = 1.0 - middle
    after = Sampled((nodes[at:] - middle) / left, inputs[at:] * left**n, motion.time * left)
    first = repaired(replace(problem, end=place), before)
    second = repaired(replace(problem, start=place), after)
    return None if first is None or second is None else waiting_between(first, second, wait)


def _switching(problem: WholeProblem, inputs: FloatArray, unit: float) -> NDArray[np.intp]:
    """Return the cells whose input is on no bound, and another than beside them."""
    same = _SAME * float(np.abs(inputs).max())
    lower, upper = problem.lower[-1] * unit, problem.upper[-1] * unit
    free = np.minimum(np.abs(inputs - lower), np.abs(inputs - upper)) > same
    apart = np.abs(np.diff(inputs)) > same
    beside = np.append(apart, False) | np.append(False, apart)
    return np.flatnonzero(free & beside)


def _with_least_share(
    problem: WholeProblem,
    nodes: FloatArray,
    time: float,
    motion: Repaired,
    rest: int | None,
    effort: Effort,
) -> tuple[float, FloatArray] | None:
    """Return the smallest share of the highest bound that a motion on a grid needs, and its inputs.

    minimise s   subject to   s·lo_n ≤ x^(n) ≤ s·hi_n, all other bounds, both states,
                              and x^(k) = 0 for all k ≥ 1 at the node `rest`, where there is one
    """
    n = problem.order
    powers = time ** np.arange(n + 1)
    sizes = np.abs(np.asarray(motion.states, float)).max(axis=1) * powers
    sizes = np.maximum(sizes, 1e-9 * sizes.max())
    maps = node_states(nodes, n, 1)
    rows = hull_rows(problem, maps, nodes, sizes, MARGIN)
    still = np.arange(1, n) if rest is not None else np.arange(0)
    fixed = n + len(still)
    of = np.concatenate([np.arange(n), still, rows.derivative])
    stacked = np.vstack([maps[:, -1], maps[still, rest or 0], rows.matrix]) / sizes[of][:, None]
    count = len(nodes) - 1
    free = stacked[:, count:] @ (problem.start * powers[:n])
    lower, upper = (
        (side * powers)[of] / sizes[of] - free for side in (problem.lower, problem.upper)
    )
    tight = rows.margin / sizes[rows.derivative]
    lower[fixed:] += tight
    upper[fixed:] -= tight
    lower[:fixed] = -free[:fixed]
    lower[:n] += problem.end * powers[:n] / sizes[:n]
    upper[:fixed] = lower[:fixed]
    matrix = np.hstack([stacked[:, :count] * sizes[n], np.zeros((len(of), 1))])
    shares = [
        np.hstack([sign * np.eye(count), np.full((count, 1), sign * -side * powers[n] / sizes[n])])
        for sign, side in ((1.0, problem.upper[n]), (-1.0, problem.lower[n]))
    ]
    far = np.full(count, np.inf)
    program = WarmProgram(
        np.vstack([matrix, *shares]),
        np.append(np.zeros(count), 1.0),
        np.concatenate([np.arange(len(of)) < fixed, np.ones(2 * count, dtype=bool)]),
        effort,
    )
    optimum = program.solve(
        np.concatenate([lower, -far, -far]),
        np.concatenate([upper, np.zeros(2 * count)]),
        np.append(-far, 0.0),
        np.append(far, 1.0 - MARGIN),
    )
    if optimum is None:
        return None
    return optimum.value, optimum.columns[:count] * sizes[n]
