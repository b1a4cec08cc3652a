"""Plans between any states: searched in own units, and told in the caller's."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, ldexp

import numpy as np

from ...checks import range_error
from ...limits import Limits
from ...pieces import FloatArray
from ...trajectory import Trajectory
from ..proof import CostateLink, Link, Proof, Slopes, TaylorLink
from . import search as searching
from .by_rest import grid_by_rest
from .costate import Multipliers
from .detour import detour
from .first_time import taylor_chain, taylor_slopes
from .flight import near_flight
from .problem import WholeProblem, power_of_two
from .repair import Repaired
from .search import Search
from .short_ramps import begun
from .warm_program import EFFORT, Effort

Numbers = tuple[float, ...]

DEFAULT_RTOL = 1e-4
"""Gap between a plan and its proof that is asked for by default."""

ROUGHLY_RTOL = 0.5
"""Gap that is asked for where only a motion is sought, or the proof that there is none."""

_FIRST_ROUNDS = 4
_LITTLE = 0.1  # of the effort, where only a motion is sought

HIGHEST_ORDER = 10
"""Highest order that is planned over the whole horizon."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What is known about the minimum time of a problem.

    Attributes
    ----------
    problem : WholeProblem
    search : Search
    length, time : int
        Its units are 2^length and 2^time of the caller's.
    """

    problem: WholeProblem
    search: Search
    length: int
    time: int

    @property
    def trajectory(self) -> Trajectory | None:
        """The fastest motion found."""
        return None if self.search.best is None else self.told(self.search.best)

    def told(self, motion: Repaired) -> Trajectory:
        """Return a motion of the search's problem in the caller's units and direction."""
        if not self.problem.backward:
            return motion.trajectory(self.problem, self.length, self.time)
        return motion.trajectory(self.problem.mirrored(), self.length, self.time).mirror()

    def told_value(self, derivative: int, value: float) -> float:
        """Return a derivative in the search's units and direction in the caller's."""
        far = ldexp(
            -value if self.problem.backward else value, self.length - derivative * self.time
        )
        return far if derivative else float(self.problem.start[0]) + far

    @property
    def lower_bound(self) -> float:
        """No motion takes less; infinite where there is none."""
        return inf if self.impossible else ldexp(self.search.lower, self.time)

    @property
    def impossible(self) -> bool:
        """Whether it is proven that there is no motion at all."""
        return self.search.lower == inf or self.search.dead_end is not None

    @property
    def proof(self) -> Proof:
        """The proof of the lower bound."""
        sign = -1 if self.problem.backward else 1
        links: list[Link] = [_outside(link, self.time, sign) for link in self.search.chain]
        if self.problem.at_rest and links:
            links = links[-1:]
        dead = self.search.dead_end
        if dead is not None:
            at = ldexp(dead.time, self.time)
            free = "end" if dead.backwards else "start"
            links.append(_costate_link(at, inf, dead.multipliers, sign, free))
        seen = self.problem.scaled(0, 0)
        start, end, lower, upper = (
            tuple(map(float, x)) for x in (seen.start, seen.end, seen.lower, seen.upper)
        )
        return Proof(start, end, lower, upper, tuple(links), self.lower_bound)

    @property
    def slopes(self) -> Slopes:
        """dT/d(lower bound), dT/d(upper bound) by the last link, position first; or zeros."""
        found = self._slopes()
        if self.problem.backward:
            found = -found[::-1]
        powers = self.time - self.length + self.time * np.arange(found.shape[1])
        with np.errstate(over="ignore", under="ignore"):
            found = np.ldexp(found, powers)
        return tuple((low, high) for low, high in (found.T + 0.0).tolist())

    @property
    def sensitivities(self) -> Numbers:
        """dT/dL_k·L_k/T by the last link, velocity first, both sides changed alike."""
        found, problem = self._slopes(), self.search.problem
        bounds = np.where(found == 0.0, 0.0, [problem.lower, problem.upper])
        shares = (found * bounds).sum(axis=0)[1:] / self.search.lower
        return tuple((shares + 0.0).tolist())

    def _slopes(self) -> FloatArray:
        """Return both rows of slopes in the search's units."""
        search = self.search
        link = search.chain[-1] if search.chain else None
        if isinstance(link, TaylorLink):
            return taylor_slopes(search.problem, link)
        if link is None:
            return np.zeros((2, search.problem.order + 1))
        found, order = np.zeros((2, search.problem.order + 1)), len(link.multipliers.ends)
        below = search.problem.below(order)
        found[:, : order + 1] = link.multipliers.slopes(below, search.lower)
        return found

    def refined(self, rtol: float, effort: Effort | None = None) -> Plan:
        """Return the plan after a longer search."""
        further = copy(self.search)
        further.chain = list(further.chain)
        further.run(rtol, effort=effort)
        return replace(self, search=further)


def planned(
    start: Numbers,
    end: Numbers,
    limits: Limits,
    rtol: float = DEFAULT_RTOL,
    *,
    effort: float | None = None,
) -> Plan:
    """Return a plan between two states, those of order n with n numbers each."""
    lower, upper = (
        (side, *sides)
        for side, sides in zip(limits.position, (limits.lower, limits.upper), strict=True)
    )
    most = Effort.of(limits.order).left if effort is None else effort
    return _planned(start, end, lower, upper, rtol, most)


def roughly_planned(problem: WholeProblem, effort: Effort) -> Plan:
    """Return a plan of a problem whose numbers are the caller's, near its minimum or not.

    What it takes counts in any case, whether it was made before or not.
    """
    numbers = (tuple(map(float, side)) for side in vars(problem).values())
    most = min(_LITTLE * EFFORT, effort.left)
    plan = _planned(*numbers, ROUGHLY_RTOL, most)
    effort.left -= most - plan.search.effort.left
    return plan


@lru_cache(maxsize=32)
def _planned(
    start: Numbers,
    end: Numbers,
    lower: Numbers,
    upper: Numbers,
    rtol: float,
    effort: float,
) -> Plan:
    problem = WholeProblem(*(np.array(numbers) for numbers in (start, end, lower, upper)))
    with np.errstate(all="ignore"):
        chain = taylor_chain(problem)
        first = chain[-1].high if chain else 0.0
        time = power_of_two(first) if 0.0 < first < inf else 0
        size = problem.length_in(ldexp(1.0, time))
        if not 0.0 < size < inf:
            raise range_error()
        length = power_of_two(size)
        inner = (problem.mirrored() if problem.backward else problem).scaled(length, time)
        most = Effort(effort)
        search = begun(Search(inner), rtol, most)
        if search.best is None and 0.0 < search.lower < inf:
            search.best = near_flight(inner, search.lower)
        _run(search, rtol, most)
        if search.best is None and search.lower < inf and search.dead_end is None:
            search.best = detour(inner, search.lower)
    return Plan(problem, search, length, time)


def _run(search: Search, rtol: float, effort: Effort) -> None:
    """Search; where some rounds find no motion, on a grid that has short cells where it needs."""
    search.run(rtol, _FIRST_ROUNDS, effort)
    open_still = search.best is None and search.lower < inf and search.dead_end is None
    if open_still and not search.problem.at_rest:
        grid = grid_by_rest(search.problem, search.lower, effort)
        search.nodes = search.nodes if grid is None else grid
    search.run(rtol, effort=effort)


def _outside(link: TaylorLink | searching.Link, time: int, sign: int) -> Link:
    """Return a link with its durations in the caller's units; of the mirror image for sign −1."""
    low, high = ldexp(link.low, time), ldexp(link.high, time)
    if isinstance(link, TaylorLink):
        return replace(link, low=low, high=high, sign=sign * link.sign)
    return _costate_link(low, high, link.multipliers, sign)


def _costate_link(
    low: float, high: float, multipliers: Multipliers, sign: int, free: str = ""
) -> CostateLink:
    return CostateLink(
        low,
        high,
        tuple(multipliers.cells.tolist()),
        tuple((sign * multipliers.ends).tolist()),
        tuple((k, tuple((sign * row).tolist())) for k, row in multipliers.atoms.items()),
        tuple(
            (k, tuple(tuple((sign * row).tolist()) for row in rows))
            for k, rows in multipliers.densities.items()
        ),
        free,
    )
