"""Many transfer problems at once: random ones on borders between cases, and scalar answers."""

from __future__ import annotations

from math import inf

import numpy as np
from move_batches import many_limits
from strategies import TransferProblem

from jounce.shaping import InfeasibleError, Limits, MotionBatch, min_time_transfers


def edge_transfers(seed, order: int, count: int) -> list[TransferProblem]:
    """Return problems with states at zero, half and full bounds, and between.

    Bounds may be missing; some starts are outside theirs, and some ends, or bound to leave them.
    """
    rng = np.random.default_rng(seed)
    return [_edge_transfer(rng, order) for _ in range(count)]


def _edge_transfer(rng: np.random.Generator, order: int) -> TransferProblem:
    bounds = [_pair(rng) for _ in range(order)]
    kinds = rng.integers(0, 6, order - 1)
    missing = {0: (-inf, inf), 1: (-inf, bounds[0][1]), 2: (bounds[0][0], inf)}
    bounds = [*(missing.get(k, pair) for k, pair in zip(kinds.tolist(), bounds, strict=False)),
              bounds[-1]]  # fmt: skip
    places = rng.choice([0.0, 1.0, -0.5, *rng.normal(size=2)], 2) * 10.0 ** rng.uniform(-2.0, 1.0)
    states = [[float(x)] for x in places]
    for state, chance, most in zip(states, (0.15, 0.05), (3.0, 1.3), strict=True):
        excess = rng.uniform(1.0, most) if rng.random() < chance else 1.0
        for pair in bounds[:-1]:
            low, high = max(pair[0], -3.0), min(pair[1], 3.0)
            anywhere = [0.0, low, high, 0.5 * low, 0.5 * high, *rng.uniform(low, high, 2)]
            state.append(float(excess * rng.choice(anywhere)))
    return TransferProblem(*map(tuple, states), tuple(bounds))


def _pair(rng: np.random.Generator) -> tuple[float, float]:
    low, high = (float(x) for x in 10.0 ** rng.uniform(-1.0, 1.0, 2))
    return (-high if rng.random() < 0.6 else -low), high


def arrays(problems) -> tuple[np.ndarray, np.ndarray, Limits]:
    """Return starts, ends and limits of problems."""
    starts, ends, bounds = zip(*((p.start, p.end, p.bounds) for p in problems), strict=True)
    return np.array(starts), np.array(ends), many_limits(bounds)


def solved(problems) -> MotionBatch:
    """Return the transfers of problems."""
    return min_time_transfers(*arrays(problems))


def one_by_one(problems) -> np.ndarray:
    """Return durations and times after which bounds are kept, NaN where there is no transfer."""
    return np.array([_answer(problem) for problem in problems]).T


def _answer(problem: TransferProblem) -> tuple[float, float]:
    try:
        transfer = problem.solve()
    except InfeasibleError:
        return np.nan, np.nan
    return transfer.duration, transfer.inside_after
