"""Searches that begin with what fewer derivatives tell, where the highest bounds hardly matter.

Without the bounds above derivative m a motion takes no longer: what excludes durations then
excludes them of the whole problem. From above, a motion of order m runs through q = n − m moving
averages of width w,

    x(t) = A^q y(t),  (A y)(t) = 1/w ∫ y(s) ds over s = t − w … t,

which keep every bound. As x^(m) = 0 before and after, A^q is a matrix at the start and another at
the end: y goes between the states that they lead from. What x^(m), …, x^(n−1) are at start and end
is brought to zero by q pieces, and from zero.
"""

from __future__ import annotations

from math import factorial, inf

import numpy as np

from ...batches.averages import averaged_inputs, least_width
from ...pieces import FloatArray, RealArray
from ..mesh import apart
from .problem import WholeProblem
from .repair import EXCESS, MISSED, ROUNDING, Repaired, effects, excess, propagated
from .sampled import Sampled
from .search import Search
from .warm_program import EFFORT, Effort

_SHORT = 0.04  # of the duration: averages that take longer tell little
_SHORTEST = 1e-7  # of the duration: averages are no shorter, and joints no nearer
_NEXT_TO_NOTHING = 2e-3  # of the duration: then a search that takes long finds no more
_LITTLE = 0.1  # of the effort, that is left for it
_SHARE = 0.5  # of the effort: each search with fewer derivatives takes no more
_PART = 0.25  # of the gap asked for: that of fewer derivatives
_RAMPS = 0.1  # of the time: those within the least of the highest bound that is tried
_LESS, _TRIED = 8.0, 4  # times as much of it each time
_QUICKER, _SLOWER, _STEPS = 0.125, 1.1, 100  # widths of a piece that is tried first; the next ones
_CORRECTIONS = 3  # so that zero is zero
_ATTEMPTS = 20  # so that the end is exact: roundings of each are others

_Pieces = tuple[RealArray, RealArray]


def begun(search: Search, rtol: float, effort: Effort) -> Search:
    """Return a search to be run; where fewer derivatives tell that there is no motion, theirs."""
    problem = search.problem
    order, width = _fewer(problem)
    ramps = (problem.order - order) * width
    if not ramps <= _SHORT * search.lower < inf:
        return search
    part = _share_of(effort)
    below = begun(Search(problem.below(order), after=search.after), _PART * rtol, part)
    below.run(_PART * rtol, effort=part)
    effort.left += part.left
    if below.lower == inf or below.dead_end is not None:
        return below
    search.chain, search.lower = below.chain, below.lower
    motion = _averaged(problem, below, max(width, _SHORTEST * below.lower), rtol, effort)
    if motion is not None:
        search.best, search.guide = motion, _sampled(motion)
        search.nodes = search.guide.nodes
    if ramps <= _NEXT_TO_NOTHING * below.lower:
        effort.left = min(effort.left, _LITTLE * EFFORT)
    return search


def _share_of(effort: Effort) -> Effort:
    """Return what a search with fewer derivatives may take of it, taken off it."""
    part = Effort(_SHARE * effort.left)
    effort.left -= part.left
    return part


def with_less(problem: WholeProblem, time: float) -> list[WholeProblem]:
    """Return the problem with less and less little of a highest bound that hardly matters.

    With the least of it the ramps take a tenth of the time: a motion of a duration within less of
    the bound is one within all of it, and gentle.
    """

    def ramps(share: float) -> float:
        order, width = _fewer(problem.with_share(share))
        return (problem.order - order) * width

    if not ramps(1.0) <= _SHORT * time:
        return []
    shares = [1.0]
    while ramps(shares[-1] / _LESS) <= _RAMPS * time:
        shares.append(shares[-1] / _LESS)
    return [problem.with_share(share) for share in shares[:0:-1][:_TRIED]]


def _fewer(problem: WholeProblem) -> tuple[int, float]:
    """Return the order from which averages take the least time, and their width."""
    n, sides = problem.order, list(zip(problem.lower[1:], problem.upper[1:], strict=True))
    widths = {
        m: float(least_width(sides, m))
        for m in range(2, n)
        if -inf < problem.lower[m] < 0.0 < problem.upper[m] < inf
    }
    order = min(widths, key=lambda m: (n - m) * widths[m], default=n)
    return order, widths.get(order, inf)


def _averaged(
    problem: WholeProblem, below: Search, width: float, rtol: float, effort: Effort
) -> Repaired | None:
    """Return a motion near that of fewer derivatives; None where there is none."""
    n, m = problem.order, below.problem.order
    signs = (-1.0) ** np.arange(n)
    onto, off = (_stop(seen, m, width) for seen in (problem, problem.reversed()))
    if below.best is None or onto is None or off is None:
        return None
    after = propagated(problem.start, *onto)[:n, -1]
    before = signs * propagated(signs * problem.end, *off)[:n, -1]
    start, end = (
        np.linalg.solve(_average(m, n - m, w), np.asarray(state[:m], float))
        for state, w in ((after, -width), (before, width))
    )
    beside = (n - m) * width + float(onto[0].sum() + off[0].sum())
    between = Search(
        WholeProblem(start, end, below.problem.lower, below.problem.upper),
        below.nodes,
        after=max(below.lower - beside, 0.0),
    )
    between.guide = below.guide
    part = _share_of(effort)
    between.run(_PART * rtol, effort=part)
    effort.left += part.left
    if between.best is None:
        return None
    return _joined(problem, between.best, width, onto, off)


def _joined(
    problem: WholeProblem, between: Repaired, width: float, onto: _Pieces, off: _Pieces
) -> Repaired | None:
    """Return a motion's averages with the pieces before and after; None where rounding spoils it.

    What the end misses goes into the inputs before they are averaged.
    """
    n, m = problem.order, len(between.states) - 1
    levels, widths = between.states[m, :-1], np.array([width], np.longdouble)
    back = np.linalg.pinv(np.asarray(effects(between.durations, m), float))
    for _ in range(_ATTEMPTS):
        lengths, inputs = averaged_inputs(between.durations[None], levels[None], widths, n - m)
        inputs[np.abs(inputs) <= ROUNDING * np.abs(inputs).max()] = 0.0
        some = lengths[0] > 0.0
        durations = np.concatenate([onto[0], lengths[0, some], off[0][::-1]])
        inputs = np.concatenate([onto[1], inputs[0, some], (-1.0) ** n * off[1][::-1]])
        states = propagated(problem.start, durations, inputs, still=m)
        missed = problem.end - states[:n, -1]
        if (np.abs(missed) <= MISSED * np.abs(states[:n]).max(axis=1)).all():
            found = Repaired(durations, states, float(durations.sum()))
            return found if excess(problem, found) <= EXCESS else None
        levels = levels + back @ missed[:m]
    return None


def _average(order: int, count: int, width: float) -> FloatArray:
    """Return what averages make of a state where x^(m) = 0: over the time before for w < 0."""
    one = sum(np.eye(order, k=j) * (width**j / factorial(j + 1)) for j in range(order))
    return np.linalg.matrix_power(np.asarray(one), count)


def _stop(problem: WholeProblem, order: int, width: float) -> _Pieces | None:
    """Return pieces that bring the start's derivatives from `order` on to zero, None for none."""
    state: RealArray = problem.start[order:].astype(np.longdouble)
    count = len(state)
    pieces = np.ones(count, np.longdouble)
    if not state.any():
        return pieces[:0], pieces[:0]
    back = np.linalg.inv(np.asarray(effects(pieces, count), float))
    for time in _QUICKER * width * _SLOWER ** np.arange(_STEPS):
        inputs: RealArray = 0.0 * pieces
        for _ in range(_CORRECTIONS):
            missed = propagated(state * time ** np.arange(count), pieces, inputs)[:count, -1]
            inputs = inputs - back @ missed
        inputs = inputs / time**count
        if problem.lower[-1] <= inputs.min() and inputs.max() <= problem.upper[-1]:
            return pieces * time, inputs
    return None


def _sampled(motion: Repaired) -> Sampled:
    """Return a motion in unit time, on its pieces but for the shortest."""
    n, time = len(motion.states) - 1, motion.time
    breaks = np.append(0.0, np.cumsum(motion.durations)).astype(float) / time
    breaks[-1] = 1.0
    pieces = Sampled(breaks, np.asarray(motion.states[n, :-1], float) * time**n, time)
    nodes = breaks[apart(breaks, _SHORTEST)]
    return Sampled(nodes, pieces.on(nodes), time)
