"""Problems between any states under any bounds: published brackets, and random ones."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from pathlib import Path

import numpy as np

from jounce.shaping import Limits, Transfer, min_time_transfer


@dataclass(frozen=True)
class Bracketed:
    """A problem of data/minimum_time2.json; see data/README.md."""

    name: str
    start: tuple[float, ...]
    end: tuple[float, ...]
    limits: Limits
    least: float
    most: float

    def solve(self, **options) -> Transfer:
        """Return the transfer."""
        return min_time_transfer(self.start, self.end, self.limits, **options)


@lru_cache(maxsize=1)
def bracketed() -> tuple[Bracketed, ...]:
    """Return all problems; the least duration of those without a motion is infinite."""
    text = (Path(__file__).parent / "data" / "minimum_time2.json").read_text(encoding="utf-8")
    return tuple(map(_problem, json.loads(text)["problems"]))


def _problem(entry: dict) -> Bracketed:
    pairs = [
        (-inf if low is None else float(low), inf if high is None else float(high))
        for low, high in zip(entry["lower"], entry["upper"], strict=True)
    ]
    limits = Limits.from_bounds(pairs[1:], position=pairs[0])
    times = (entry["T_lower"], entry["T_upper"]) if entry["feasible"] else (inf, inf)
    return Bracketed(entry["name"], tuple(entry["start"]), tuple(entry["end"]), limits, *times)


def solvable() -> list[Bracketed]:
    """Return the problems that have a motion."""
    return [problem for problem in bracketed() if problem.least < inf]


def impossible() -> list[Bracketed]:
    """Return those that have none."""
    return [problem for problem in bracketed() if problem.least == inf]


def random_problem(seed: int, order: int, *, moving: bool = True) -> Bracketed:
    """Return random states well inside random bounds, those of both directions up to 4 apart."""
    rng = np.random.default_rng((seed, order))
    scale = 10.0 ** rng.uniform(-0.3, 0.6, order) * 4.0 ** np.arange(order)
    pairs = [(-s * rng.uniform(0.5, 2.0), s * rng.uniform(0.5, 2.0)) for s in scale]
    for k in range(order - 1):
        if rng.random() < 0.2:
            pairs[k] = (-inf, inf)
    inside = [0.2 * s * rng.uniform(-1.0, 1.0) if moving else 0.0 for s in scale[: order - 1]]
    ends = [0.2 * s * rng.uniform(-1.0, 1.0) if moving else 0.0 for s in scale[: order - 1]]
    start, end = (0.0, *inside), (float(rng.uniform(-2.0, 2.0)), *ends)
    return Bracketed(f"random-{seed}", start, end, Limits.from_bounds(pairs), 0.0, inf)


def reversed_in_time(problem: Bracketed) -> Bracketed:
    """Return the problem run backwards: odd derivatives and their bounds change sign."""
    limits = problem.limits
    pairs = [limits.bounds(k) for k in range(limits.order + 1)]
    turned = [(-high, -low) if k % 2 else (low, high) for k, (low, high) in enumerate(pairs)]
    ends = problem.end, problem.start
    start, end = (tuple((-1.0) ** k * x for k, x in enumerate(state)) for state in ends)
    other = Limits.from_bounds(turned[1:], position=turned[0])
    return Bracketed(problem.name, start, end, other, problem.least, problem.most)
