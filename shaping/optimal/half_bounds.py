"""Proofs for moves from rest to rest: the best of multipliers of their first half, mirrored."""

from __future__ import annotations

from dataclasses import replace
from math import inf, ldexp

import numpy as np

from ..closed_moves import closed_form_move
from ..limits import Limits
from ..pieces import FloatArray
from ..trajectory import Trajectory
from .bound_search import BoundSearch, HalfBound
from .half_problem import HalfProblem
from .mesh import graded_mesh, with_touches
from .minimum_time import MAX_OPTIMAL_ORDER, improved, without_cruise
from .own_units import of_order_one
from .proof import CostateLink, MirroredLink, Numbers, Proof, Proven, Slopes
from .quick_bounds import spline_durations, spline_link, spline_terms
from .smoothing import lower_order, relative_width, truncated

_ROUNDING = 1e-12  # of the lower bound, taken off it
_SLOWER = 1e-9  # than another motion, relative
_NEXT_TO_NOTHING = 0.5  # of the gap asked for
_LONG = 6.0  # times the time of the ramps: cruise left in, as velocity may dip after a ramp
_CELLS = 40
_LOW_ORDER_TARGET = 1e-9

_ENDS = (slice(None, -1), slice(1, None))  # of cells, in an array of nodes

_Found = tuple[float, FloatArray, CostateLink | MirroredLink]


def proven_by_half(given: Trajectory, limits: Limits, rtol: float) -> Proven | None:
    """Return the best bound found on the duration of moves like this; None for none.

    Of bounds on even derivatives that differ between the directions the mean counts.
    """
    move, own, time = of_order_one(given, limits)
    distance = float(move.end_state[0] - move.start_state[0])
    if distance == 0.0:
        return None
    ahead = own
    if distance < 0.0:
        move, ahead = move.mirror(), own.mirror()
    found = _best(move, abs(distance), ahead, rtol)
    if found is None:
        return None
    lower, terms, link = found
    lower = ldexp(lower, time)
    slopes = _slopes(terms, limits if distance > 0.0 else limits.mirror(), lower)
    if distance < 0.0:
        slopes, link = tuple((-high, -low) for low, high in slopes), _opposite(link)
    shares = 0.0 - terms.sum(axis=0) / float((np.arange(terms.shape[1]) * terms).sum())
    proof = _proof(given, limits, replace(link, high=lower))
    return Proven(lower, tuple(shares[1:].tolist()), slopes, proof)


def _proof(move: Trajectory, limits: Limits, link: CostateLink | MirroredLink) -> Proof:
    """Return the proof under the bounds up to the order of its multipliers."""
    order, rest = len(link.ends), (0.0,) * (len(link.ends) - 1)
    distance = float(move.end_state[0] - move.start_state[0])
    lower, upper = (
        (free, *sides[:order])
        for free, sides in zip((-inf, inf), (limits.lower, limits.upper), strict=True)
    )
    return Proof((0.0, *rest), (distance, *rest), lower, upper, (link,), link.high)


def _opposite(link: CostateLink | MirroredLink) -> CostateLink | MirroredLink:
    """Return the multipliers of the opposite direction."""
    atoms = tuple((k, _negative(row)) for k, row in link.atoms)
    densities = tuple((k, tuple(map(_negative, rows))) for k, rows in link.densities)
    return replace(link, ends=_negative(link.ends), atoms=atoms, densities=densities)


def _negative(row: Numbers) -> Numbers:
    return tuple(-value for value in row)


def _slopes(terms: FloatArray, limits: Limits, time: float) -> Slopes:
    """Return dT/d(bound) from R/2 = Σ_k terms[:, k], of degree k in T each.

    Of even derivatives the terms of both sides are of their mean.
    """
    scale = time / float((np.arange(terms.shape[1]) * terms).sum())
    found = [(0.0, 0.0)]
    for k, (below, above) in enumerate(terms.T[1:].tolist(), start=1):
        low, high = limits.bounds(k)
        if k % 2 == 0:
            each = (below + above) / (high - low) * scale
            found.append((each, 0.0 - each))
        else:
            lowered = below / -low * scale if below else 0.0
            found.append((lowered, 0.0 - above / high * scale))
    return tuple(found)


def _best(move: Trajectory, distance: float, limits: Limits, rtol: float) -> _Found | None:
    """Return the best bound found, the terms of lower and upper bounds that make it, its link."""
    best = _spline(distance, limits)
    target = rtol if limits.order > 3 else min(rtol, _LOW_ORDER_TARGET)
    order = _two_sided(limits)
    aim = _NEXT_TO_NOTHING * target
    while order > 1 and (best is None or move.duration > best[0] * (1.0 + target)):
        limits = truncated(limits, order)
        order = lower_order(limits)
        if order and relative_width(limits, order, move.duration) <= aim:
            continue
        lower = best[0] if best else 0.0
        found, fastest = _programmed(move, distance, limits, lower, target)
        if found is not None and found[0] > lower:
            best, lower = found, found[0]
        gap = move.duration / lower - 1.0
        if not order or relative_width(limits, order, move.duration) > gap:
            break
        if fastest / lower - 1.0 <= _NEXT_TO_NOTHING * gap:
            break  # nor can fewer bounds prove more than what `fastest` takes
    return best


def _spline(distance: float, limits: Limits) -> _Found | None:
    """Return the best bound by one derivative alone."""
    alone = spline_durations(distance, limits)
    lower, k = float(alone.max()) * (1.0 - _ROUNDING), int(alone.argmax())
    if not lower > 0.0:
        return None
    terms = np.zeros((2, limits.order + 1))
    terms[:, k] = spline_terms(k, limits)
    return lower, terms, spline_link(k)


def _programmed(
    trajectory: Trajectory, distance: float, limits: Limits, lower: float, target: float
) -> tuple[_Found | None, float]:
    """Return the best bound that linear programs lead to, and the fastest duration known.

    `lower` is a bound already.
    """
    closed = closed_form_move(distance, limits)
    motion: Trajectory = trajectory
    same_order = trajectory.order == limits.order
    if not (same_order and trajectory.duration < closed.duration * (1.0 - _SLOWER)):
        motion = improved(closed, limits) or closed
    shorter = without_cruise(closed, limits, _LONG)
    if shorter is not None and shorter.duration > lower:
        shorter = None  # the cruise must be known to begin before the end
    base = closed if shorter is None else shorter
    covered = float(base.end_state[0])
    problem = HalfProblem.make(covered, limits, base, relaxed=True)
    reached = [
        motion.peak(k) * (0.5 * base.duration) ** k / covered for k in range(len(problem.peaks))
    ]
    problem = replace(problem.reaching(np.array(reached)), cruising=shorter is not None)
    unit = base.duration * (1.0 - _ROUNDING)
    search = BoundSearch(
        problem,
        motion,
        lower / unit,
        distance=0.5 if shorter is None else 0.5 * distance / covered,
        span=0.5 * (motion.duration if shorter is None else unit),
    )
    fastest = min(trajectory.duration, motion.duration)
    with np.errstate(all="ignore"):
        nodes = graded_mesh(shorter or motion, _CELLS)
        nodes = with_touches(nodes, motion, problem.relevant(), search.span)
        search.run(nodes, fastest / unit, target)
        found = search.found()
    if found is None:
        return None, fastest
    return (found.half * unit, found.terms, _link(found)), fastest


def _link(found: HalfBound) -> MirroredLink:
    half = found.multipliers
    used = [k for k in range(1, len(half.ends)) if half.atoms[k].any() or half.densities[k].any()]
    return MirroredLink(
        0.0,
        0.0,
        tuple(half.cells.tolist()),
        (1.0, *(0.0 - half.ends[1:]).tolist()),
        tuple((k, tuple((0.0 - half.atoms[k, 1:]).tolist())) for k in used),
        tuple(
            (k, tuple(tuple((0.0 - half.densities[k, at]).tolist()) for at in _ENDS)) for k in used
        ),
        2.0 * found.cruise,
    )


def _two_sided(limits: Limits) -> int:
    """Return the highest derivative that a program is tried for and is bounded both ways, or 0."""
    finite = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    orders = np.flatnonzero(finite[:MAX_OPTIMAL_ORDER]) + 1
    return int(orders[-1]) if orders.size else 0
