"""How far a move is from the minimum time: a rigorous lower bound, and what each limit costs."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from math import inf, ldexp
from pathlib import Path

import numpy as np

from ..checks import in_range, positive
from ..closed_moves import closed_form_move
from ..derivatives import derivative_name
from ..limits import Limits, of_one
from ..pieces import FloatArray, evaluate
from ..told import Told
from ..trajectory import Motion, Trajectory, as_trajectory
from .bound_search import BoundSearch
from .half_problem import HalfProblem
from .mesh import graded_mesh, with_touches
from .minimum_time import MAX_OPTIMAL_ORDER, improved, spline_durations, without_cruise
from .own_units import of_order_one
from .proof import Proof
from .proof_check import holds
from .smoothing import even_are_symmetric, lower_order, relative_width, truncated
from .whole.outcome import check_whole
from .whole.planner import HIGHEST_ORDER, Plan, planned

_ROUNDING = 1e-12  # of the lower bound, taken off it
_NEXT_TO_NOTHING = 0.5  # of the gap asked for
_AT_REST = 1e-9  # of a derivative's peak
_LONG = 6.0  # times the time of the ramps: cruise left in, as velocity may dip after a ramp
_CELLS = 40
_LOW_ORDER_TARGET = 1e-9
_TARGETS = (1.0, 0.5, 0.2)  # of the gap asked for: searches, the next where one was not enough


@dataclass(frozen=True, repr=False)
class Certificate(Told):
    """A proof of how near a motion is to the minimum time under its limits.

    Attributes
    ----------
    duration : float
        Of the motion.
    lower_bound : float
        No motion between these states within the limits is faster.
    gap : float
        duration / lower_bound − 1.
    sensitivities : tuple of float
        dT/dL_k·L_k/T of the lower bound, velocity first, both sides of a bound changed alike: −0.2
        for jerk says that raising its limit by 1 % saves 0.2 %. From rest to rest, positions
        free, Σ_k k·sensitivity_k = −1; all zero where nothing is proven.
    rtol : float
        The gap that was asked for.
    proof : Proof or None
        The proof as data; None where `lower_bound` rests on the half horizon, or is zero.
    """

    duration: float
    lower_bound: float
    gap: float
    sensitivities: tuple[float, ...]
    rtol: float
    proof: Proof | None = None

    @property
    def reached(self) -> bool:
        """Whether the gap is as small as was asked for; the bound holds in any case."""
        return self.gap <= self.rtol

    def check(self) -> bool:
        """Tell whether the proof holds, by rational arithmetic alone (`proof_check`)."""
        proof = self.proof
        if proof is None:
            return self.lower_bound == 0.0
        if not 0.0 < self.lower_bound <= proof.lower_bound:
            return False
        gap = self.duration / self.lower_bound - 1.0
        return self.gap >= gap - _ROUNDING and holds(proof)

    def save(self, path: str | Path) -> None:
        """Write the certificate with its proof to a file of JSON."""
        own = {name: value for name, value in vars(self).items() if name != "proof"}
        own["gap"] = None if self.gap == inf else self.gap
        proof = None if self.proof is None else json.loads(self.proof.text())
        Path(path).write_text(json.dumps({**own, "proof": proof}), encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Certificate:
        """Return the certificate that `save` wrote.

        Raises
        ------
        ValueError
            For a file that is none.
        """
        text = Path(path).read_text(encoding="utf-8")
        try:
            data = json.loads(text)
            proof = data["proof"]
            return cls(
                float(data["duration"]),
                float(data["lower_bound"]),
                inf if data["gap"] is None else float(data["gap"]),
                tuple(map(float, data["sensitivities"])),
                float(data["rtol"]),
                None if proof is None else Proof.from_text(json.dumps(proof)),
            )
        except (KeyError, TypeError, AttributeError, ValueError):
            raise ValueError(
                f"{str(path)!r} holds no certificate: expected what certificate.save wrote"
            ) from None


def certify(trajectory: Motion, limits: Limits, *, rtol: float = 1e-4) -> Certificate:
    """Prove how much faster a motion between its two states could be at most.

    From rest to rest, positions free and bounds on even derivatives the same in both directions,
    for any multipliers λ and measures μ_k every motion within the limits has

        R/2 ≤ L_n·∫|p| dt + Σ_k L_k·‖μ_k‖ = Σ_k c_k·L_k·(T/2)^k

    with p the costate that they give (weak duality); the root T is a lower bound. A linear
    program proposes the multipliers, on meshes refined until the gap is at most `rtol` or no
    longer shrinks; the bound is then evaluated from them alone, in extended precision, with a
    margin for rounding. No error of the solver can make it wrong. Between any states, under any
    bounds, the like holds over the whole horizon: each set of multipliers excludes the durations
    for which a polynomial is positive, and a chain of them covers all from zero to the bound.

    Parameters
    ----------
    trajectory : Trajectory
        Within the limits; its start and end are the states that are meant.
    limits : Limits
        Of order 2 to 10 unless the motion is from rest to rest, positions free. Above order 10 of
        bounds that differ between the directions the mean counts for even derivatives: the lower
        bound is then true but need not be near. It is 0 where no derivative is bounded in both
        directions and velocity not in that of the move.
    rtol : float, optional
        Gap to be reached. It cannot be less than what the move itself is slower than need be.

    Returns
    -------
    Certificate
        `reached` tells whether the gap came down to `rtol`.

    Raises
    ------
    ValueError
        For a motion that breaks its limits by more than 1e-9 or jumps in a derivative that is
        bounded, one between moving states under limits of other orders, or an rtol that is not
        positive.

    Notes
    -----
    Moves of `min_time_move` come to a gap of 1e-5…1e-4, with limits many decades apart to 1e-3, in
    0.05 to 0.5 s; some take 1.5 s, and up to 15 s from order 8 on where the gap asked for is out of
    reach. Ramps of 1e-2 to 1e-4 of the duration may be too short for the program at orders 6 and
    above: the gap is then about as large as they are. Above order 10 the bounds up to derivative 10
    count. For n ≤ 3 and for perfect splines the gap is that of rounding and of the solver's
    tolerance, some 1e-9, but not where bounds of even derivatives differ between the directions.

    References
    ----------
    Weak duality of linear programs in function space; Wang & Hu, arXiv 2311.07039, for the
    problem.

    Examples
    --------
    >>> limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    >>> from jounce.shaping import min_time_move
    >>> proof = certify(min_time_move(1.0, limits), limits)
    >>> proof.reached
    True
    >>> [round(s, 3) for s in proof.sensitivities]
    [-0.375, -0.125, -0.125]
    """
    rtol = positive("rtol", rtol)
    move, limits = as_trajectory(trajectory), of_one(limits)
    _check(move, limits)
    rests = _at_rest(move, limits.order)
    by_half = rests and limits.plain and even_are_symmetric(limits)
    if by_half or (rests and not 2 <= limits.order <= HIGHEST_ORDER):
        return _by_half(move, limits, rtol)
    check_whole(limits)
    return in_range(lambda: _by_whole(move, limits, rtol, rests))


def _by_half(given: Trajectory, limits: Limits, rtol: float) -> Certificate:
    move, limits, time = of_order_one(given, limits)
    distance = float(move.end_state[0] - move.start_state[0])
    if distance < 0.0:
        move, limits = move.mirror(), limits.mirror()
    if distance == 0.0:
        gap = inf if move.duration > 0.0 else 0.0
        return Certificate(given.duration, 0.0, gap, (0.0,) * limits.order, rtol)
    lower, terms = in_range(lambda: _bounds(move, abs(distance), limits, rtol))
    if not lower > 0.0:
        return Certificate(given.duration, 0.0, inf, (0.0,) * limits.order, rtol)
    gap = max(move.duration / lower - 1.0, 0.0)
    return Certificate(given.duration, ldexp(lower, time), gap, _sensitivities(terms, limits), rtol)


def _by_whole(move: Trajectory, limits: Limits, rtol: float, rests: bool) -> Certificate:
    """Return the certificate of a search, of fewer derivatives where the highest ones spoil it."""
    n, best = limits.order, None
    for order in range(n, 1, -1):
        below = limits if order == n else truncated(limits, order)
        if below.order < order or not all(np.isfinite(below.bounds(order))):
            continue
        start, end = (
            (float(state[0]), *(0.0 if rests else float(x) for x in state[1:order]))
            for state in (move.start_state, move.end_state)
        )
        found = _of_plan(move.duration, planned(start, end, below), rtol, n)
        best = found if best is None or found.lower_bound > best.lower_bound else best
        if best.reached:
            break
    assert best is not None
    return best


def _of_plan(duration: float, plan: Plan, rtol: float, order: int) -> Certificate:
    for target in _TARGETS:
        if duration <= plan.lower_bound * (1.0 + rtol) or plan.search.gap <= target * rtol:
            break
        if duration > plan.lower_bound * (1.0 + plan.search.gap) * (1.0 + rtol):
            break  # it is the motion that is slow
        plan = plan.refined(target * rtol)
    lower = plan.lower_bound
    if not 0.0 < lower <= duration * (1.0 + _AT_REST):
        gap = inf if duration > 0.0 else 0.0
        return Certificate(duration, 0.0, gap, (0.0,) * order, rtol)
    shares = (*plan.sensitivities[1:], *[0.0] * order)[:order]
    return Certificate(duration, lower, max(duration / lower - 1.0, 0.0), shares, rtol, plan.proof)


def _at_rest(trajectory: Trajectory, order: int) -> bool:
    return all(
        abs(float(state[k])) <= _AT_REST * trajectory.peak(k)
        for state in (trajectory.start_state, trajectory.end_state)
        for k in range(1, min(order, trajectory.order))
    )


def _check(trajectory: Trajectory, limits: Limits) -> None:
    """Refuse a motion that is not within the limits."""
    jump = _lowest_jump(trajectory)
    if len(trajectory.states) and jump < limits.order:
        name, highest = derivative_name(jump), derivative_name(limits.order)
        raise ValueError(
            f"{name} jumps, so that {highest} is unbounded: certify this move under limits up "
            f"to the derivative after {name} at most"
            if jump
            else "position jumps: certify takes continuous motions"
        )
    excess = trajectory.violation(limits)
    if excess > _AT_REST:
        raise ValueError(
            f"the trajectory exceeds a limit by {100.0 * excess:.3g} %: certify a move within "
            "its limits"
        )


def _lowest_jump(trajectory: Trajectory) -> int:
    """Return the lowest derivative that jumps between two pieces, or after the last."""
    ends = evaluate(trajectory.states.T, trajectory.durations, range(trajectory.order + 1)).T
    after = np.vstack([trajectory.states[1:], trajectory.end_state])
    jumps = np.abs(ends - after).max(axis=0, initial=0.0)
    for k in range(trajectory.order):
        if jumps[k] > _AT_REST * trajectory.peak(k):
            return k
    return trajectory.order


def _bounds(
    trajectory: Trajectory, distance: float, limits: Limits, rtol: float
) -> tuple[float, FloatArray]:
    """Return the best lower bound found and the terms c_k·L_k·(T/2)^k, index k, that make it."""
    alone = spline_durations(distance, limits)  # each bound by itself
    lower = float(alone.max()) * (1.0 - _ROUNDING)
    terms = np.eye(limits.order + 1)[alone.argmax()] if lower > 0.0 else 0.0 * alone
    target = rtol if limits.order > 3 else min(rtol, _LOW_ORDER_TARGET)
    order = _two_sided(limits)
    aim = _NEXT_TO_NOTHING * target
    while order > 1 and trajectory.duration > lower * (1.0 + target):
        limits = truncated(limits, order)
        order = lower_order(limits)
        if order and relative_width(limits, order, trajectory.duration) <= aim:
            continue
        found, better, fastest = _programmed(trajectory, distance, limits, lower, target)
        if found > lower:
            lower, terms[:] = found, 0.0
            terms[: len(better)] = better
        gap = trajectory.duration / lower - 1.0
        if not order or relative_width(limits, order, trajectory.duration) > gap:
            break
        if fastest / lower - 1.0 <= _NEXT_TO_NOTHING * gap:
            break  # nor can fewer bounds prove more than what `fastest` takes
    return lower, terms


def _programmed(
    trajectory: Trajectory, distance: float, limits: Limits, lower: float, target: float
) -> tuple[float, FloatArray, float]:
    """Return the best bound that linear programs lead to, its terms, and the fastest motion known.

    `lower` is a bound already.
    """
    closed = closed_form_move(distance, limits)
    motion: Trajectory = trajectory
    same_order = trajectory.order == limits.order
    if not (same_order and trajectory.duration < closed.duration * (1.0 - _AT_REST)):
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
    with np.errstate(all="ignore"):
        nodes = graded_mesh(shorter or motion, _CELLS)
        nodes = with_touches(nodes, motion, problem.relevant(), search.span)
        fastest = min(trajectory.duration, motion.duration)
        search.run(nodes, fastest / unit, target)
    return search.best * unit if search.terms.any() else lower, search.terms, fastest


def _two_sided(limits: Limits) -> int:
    """Return the highest derivative that a program is tried for and is bounded both ways, or 0."""
    finite = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    orders = np.flatnonzero(finite[:MAX_OPTIMAL_ORDER]) + 1
    return int(orders[-1]) if orders.size else 0


def _sensitivities(terms: FloatArray, limits: Limits) -> tuple[float, ...]:
    """Return dT/dL_k·L_k/T from R/2 = Σ_k terms[k], of degree k in T each."""
    k = np.arange(limits.order + 1)
    return tuple((0.0 - terms / (k * terms).sum())[1:].tolist())
