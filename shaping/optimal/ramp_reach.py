"""How far a ramp onto the velocity bound comes at most in its time, by what multipliers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ldexp

import numpy as np

from ..pieces import FloatArray
from .proof import Ramp
from .whole.costate import Multipliers
from .whole.farthest import farthest
from .whole.planner import Plan
from .whole.problem import WholeProblem
from .whole.search import Link as Excluded
from .whole.warm_program import EFFORT, Effort

_EFFORT = 0.06 * EFFORT
_LAST = 3  # links of a ramp's proof: each by multipliers that may tell most
_CUTS = (0.6, 0.7, 0.8, 0.9, 1.0)  # of its time: where they may end
_ROUNDING = 1e-12  # of the time

_Told = Callable[[Plan, WholeProblem], list[tuple[Multipliers, float]]]


@dataclass(frozen=True, eq=False)
class Reach:
    """How far a motion comes that starts as a ramp does, and by what multipliers.

    Parameters
    ----------
    time : float
    multipliers : Multipliers
        With λ = (1, 0, …, 0).
    terms : (n + 1,) array
        Of degree k in the time: their sum is the farthest.
    masses : (2, n + 1) array
        What terms a unit of each lower and upper bound makes.
    """

    time: float
    multipliers: Multipliers
    terms: FloatArray
    masses: FloatArray

    @property
    def ramp(self) -> Ramp:
        """What a proof keeps of it."""
        of = self.multipliers
        return Ramp(
            self.time,
            tuple(of.cells.tolist()),
            tuple((k, tuple(row.tolist())) for k, row in of.atoms.items()),
            tuple((k, tuple(map(tuple, rows.tolist()))) for k, rows in of.densities.items()),
        )


def reach(plan: Plan, order: int, told: _Told) -> Reach:
    """Return how far a ramp comes at most, by what multipliers tell most.

    Bounds above derivative `order` do not count. Multipliers of a velocity held all along tell the
    least.
    """
    problem, one = plan.search.problem.below(order), np.ones(1)
    held = Multipliers(one, np.eye(order)[0], {1: 0.0 * one}, {1: -np.ones((1, 1))})
    found = (*told(plan, problem), (held, 1.0))
    reaches = [_reach_by(*each, problem, plan) for each in found]
    speed = float(plan.problem.upper[1])
    return min(reaches, key=lambda each: float(each.terms.sum()) - speed * each.time)


def told_by_links(plan: Plan, problem: WholeProblem) -> list[tuple[Multipliers, float]]:
    """Return multipliers of a plan's proof, each up to shares of its time."""
    excluded = [link.multipliers for link in plan.search.chain if isinstance(link, Excluded)]
    return [
        _cut(each, share, problem)
        for each in [each for each in excluded if len(each.ends) == problem.order][-_LAST:]
        for share in _CUTS
        if each.ends[0] > 0.0
    ]


def told_by_farthest(plan: Plan, problem: WholeProblem) -> list[tuple[Multipliers, float]]:
    """Return multipliers of the motion that comes farthest, in all of its time."""
    with np.errstate(all="ignore"):
        found = farthest(problem, plan.search.nodes, plan.search.lower, Effort(_EFFORT))
    return [] if found is None else [_cut(found, 1.0, problem)]


def _cut(given: Multipliers, share: float, problem: WholeProblem) -> tuple[Multipliers, float]:
    """Return multipliers up to a share of the time, with λ = (1, 0, …, 0) there, and that time.

    As far as atoms may they take over the p_k that end there.
    """
    count = max(int(np.searchsorted(np.cumsum(given.cells), share * (1.0 - _ROUNDING))) + 1, 1)
    count = min(count, len(given.cells))
    length, scale = float(given.cells[:count].sum()), 1.0 / given.ends[0]
    atoms = {k: row[:count] * scale / length**k for k, row in given.atoms.items()}
    for k, row in atoms.items():
        row[-1] += given.ends[k] * scale if k and count == len(given.cells) else 0.0
        side = problem.lower[k] if row[-1] > 0.0 else problem.upper[k]
        row[-1] *= np.isfinite(side)
    densities = {
        k: rows[:, :count] * scale * length / length**k for k, rows in given.densities.items()
    }
    ends = np.eye(problem.order)[0]
    return Multipliers(given.cells[:count] / length, ends, atoms, densities), length


def _reach_by(multipliers: Multipliers, length: float, problem: WholeProblem, plan: Plan) -> Reach:
    n, time = problem.order, plan.search.lower * length
    costate, powers = multipliers.costate(), time ** np.arange(n + 1.0)
    terms = -multipliers.polynomial(problem, costate) * powers
    terms[0] += problem.end[0]
    masses = np.zeros((2, n + 1))
    masses[:, :n] = multipliers.masses()
    masses[:, n] = costate.negative.sum(), costate.positive.sum()
    real = ldexp(time, plan.time)
    return Reach(
        real,
        multipliers,
        np.ldexp(terms, plan.length),
        masses * [[-1.0], [1.0]] * real ** np.arange(n + 1.0),
    )
