"""Moves of any order in minimum time: the fastest closed form, or a linear program's motion."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from ..limits import Limits
from ..moves import min_time_move
from ..pieces import FloatArray, evaluate
from ..rise import spline_divisor
from ..trajectory import Trajectory
from .grids import graded_grid, split_losses, split_switches
from .half_motion import Half, merged, whole_move
from .half_problem import Farthest, HalfProblem, HalfProgram, duration_of
from .smoothing import averaged_half, averaging_width, lower_order, relative_width, truncated

MAX_OPTIMAL_ORDER = 10
"""Highest order that a linear program is tried for; above it `optimal_move` is the closed form."""

_CELLS = 40
_NEGLIGIBLE = 1e-9  # a gain in duration that is not worth leaving a closed form for
_NEAR = 1e-3  # of the duration: what a closed form may lose without a warning
_SHORT = 2e-5  # of the duration: what moving averages of the lower order may cost
_LONG = 2.0  # times the ramps' time: how much cruise is left in the linear program
_STAGES = 7
_LOST = 5e-6  # of the distance, for want of a finer grid: not worth another stage
_MOST_CELLS = 150
_ROUGHLY, _SETTLED = 1e-3, 1e-7  # steps on the duration after which no other is needed
_STEPS = 8
_KEPT = 1e-12  # excess over a bound, jump at a joint
_SAME_INPUT = (1e-7, 0.0)  # of the bound: inputs of neighbours that are merged


def optimal_move(distance: float, limits: Limits, *, start: float = 0.0) -> Trajectory:
    """Return the move from rest to rest in minimum time, of any order.

    For n ≤ 3 the closed form, which is the minimum. For n ≥ 4 the faster of the closed forms and
    of a piecewise-constant x^(n) from a linear program,

        maximise x(T/2)  subject to  |x^(k)| ≤ L_k for all t,  x^(k)(T/2) = 0 for even k ≥ 2,

    with T so that x(T/2) is half the distance, and the second half the mirror image.

    Parameters
    ----------
    distance : float
        Signed distance, in the limits' distance unit. Zero gives a trajectory of duration zero.
    limits : Limits
        Bounds on any of the derivatives 1…n, n ≤ 14.
    start : float, optional
        Position at the start.

    Returns
    -------
    Trajectory
        Of order n, starting at time 0; never slower than the closed form.

    Raises
    ------
    ValueError
        As `min_time_move`.

    Warns
    -----
    RuntimeWarning
        Where the closed form is returned because the order is above 10 or the solver failed, as it
        may with limits many decades apart.

    Notes
    -----
    With bounds active below the highest the exact optimum may switch infinitely often (Wang &
    Hu): what is returned comes near it, and `certify` says how near. Where only the highest
    derivative binds it is the perfect spline itself.

    Bounds that differ between directions: the motion is made odd about its middle, so that of
    derivatives 2, 4, … the smaller magnitude counts; odd ones are used as they are.

    References
    ----------
    Wang & Hu, arXiv 2311.07039 and 2403.17675, for what the optimum looks like.

    Examples
    --------
    >>> limits = Limits(velocity=1.5, jerk=60.0, pop=122880.0)
    >>> closed = min_time_move(1.0, limits, method="closed-form")
    >>> optimal_move(1.0, limits).duration < closed.duration
    True
    """
    forward = limits.mirror() if distance < 0.0 and isinstance(limits, Limits) else limits
    move = min_time_move(abs(distance), forward, method="closed-form")
    if distance != 0.0:
        move = faster_or_warn(move, forward)
    if distance < 0.0:
        move = move.mirror()
    return move.shift(start) if start else move


def faster_or_warn(closed: Trajectory, limits: Limits) -> Trajectory:
    """Return `improved`, or the closed form itself with a warning where that cannot be had."""
    move = improved(closed, limits)
    if move is not None:
        return move
    if _is_near(closed, limits):
        return closed
    reason = (
        f"order {limits.order} is above {MAX_OPTIMAL_ORDER}"
        if limits.order > MAX_OPTIMAL_ORDER
        else "these limits are too many decades apart for the linear program"
    )
    warnings.warn(
        f"{reason}: this move is the fastest closed form, which may be slower than need be",
        RuntimeWarning,
        stacklevel=3,
    )
    return closed


def _is_near(closed: Trajectory, limits: Limits) -> bool:
    """Tell whether the bounds up to jerk, whose closed form is optimal, take nearly as long."""
    low = [k for k in range(1, 4) if limits.bounds(k)[1] < np.inf]
    if not low or not all(np.isfinite(limits.bounds(low[-1]))):
        return False
    fastest = min_time_move(
        float(closed.end_state[0]), truncated(limits, low[-1]), method="closed-form"
    )
    return closed.duration <= fastest.duration * (1.0 + _NEAR)


def improved(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return a faster move than a closed form in positive direction, or that where none is.

    None where the linear program could not be used.
    """
    if limits.order <= 3 or is_single_spline(closed, limits):
        return closed
    if limits.order > MAX_OPTIMAL_ORDER:
        return None
    with np.errstate(all="ignore"):
        move = _averaged(closed, limits) or _programmed(closed, limits)
    if move is None or move.duration < closed.duration * (1.0 - _NEGLIGIBLE):
        return move
    return closed


def is_single_spline(closed: Trajectory, limits: Limits) -> bool:
    """Tell whether one bound alone already takes this long: then the closed form is optimal."""
    distance, duration = float(closed.end_state[0]), closed.duration
    for k in range(1, limits.order + 1):
        low, high = limits.bounds(k)
        bound = high if k == 1 else max(-low, high)
        if np.isfinite(bound):
            least = (distance / bound * spline_divisor(k)) ** (1.0 / k)
            if duration <= least * (1.0 + _KEPT):
                return True
    return False


def _averaged(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return the move of the order below, smoothed, where that costs next to nothing."""
    order = lower_order(limits)
    if not order or relative_width(limits, order, closed.duration) > _SHORT:
        return None
    distance, below = float(closed.end_state[0]), truncated(limits, order)
    lower = min_time_move(distance, below, method="closed-form")
    lower = improved(lower, below) or lower
    half = averaged_half(lower, limits.order, averaging_width(limits, order))
    return _finished(half, distance, 1.0, limits)


def _programmed(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return the linear program's motion; None where it fails."""
    distance = float(closed.end_state[0])
    shorter = _without_cruise(closed, limits)
    base = closed if shorter is None else shorter
    covered = float(base.end_state[0])
    problem = HalfProblem.make(covered, limits, base)
    if shorter is not None:
        problem = replace(problem, cruising=True)
    found = _refined(problem, graded_grid(base, _CELLS))
    if found is None:
        return None
    nodes, farthest, half = found
    cruise = 0.0
    if shorter is not None:
        ahead = 0.5 * distance / covered - farthest.distance
        cruise = ahead / (float(problem.upper[1]) * half)
    bound = float(problem.upper[-1]) * half**problem.order
    moves = []
    for same in _SAME_INPUT:
        runs = merged(nodes, farthest.inputs, problem.order, same * bound)
        repaired = runs.repaired(problem.ends(half), problem.peaks)
        unit = half * 0.5 * base.duration
        moves.append(_finished(repaired, distance, unit, limits, cruise))
    few, many = moves
    if few is None or many is None:
        return few or many
    return few if few.duration <= many.duration * (1.0 + _NEGLIGIBLE) else many


def _without_cruise(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return the closed form of a move with most of a long cruise left out; None if it is short."""
    middle = int(np.searchsorted(closed.breaks, 0.5 * closed.duration)) - 1
    velocity, *higher = closed.states[middle, 1:].tolist()
    cruise = float(closed.durations[middle])
    ramps = closed.duration - cruise
    if any(higher) or velocity < limits.bounds(1)[1] or cruise <= _LONG * ramps:
        return None
    shorter = float(closed.end_state[0]) - velocity * (cruise - _LONG * ramps)
    return min_time_move(shorter, limits, method="closed-form")


def _refined(problem: HalfProblem, nodes: FloatArray) -> tuple[FloatArray, Farthest, float] | None:
    """Solve on finer and finer grids; return the last nodes, the solution and its half duration."""
    half = 1.0
    best: tuple[FloatArray, Farthest, float] | None = None
    for stage in range(_STAGES):
        program = HalfProgram(problem, nodes)
        solved = _settled(program, half, _ROUGHLY)
        if solved is None:
            break
        farthest, at, half = solved
        if stage and (farthest.losses.sum() <= _LOST or len(nodes) > _MOST_CELLS):
            farthest, at, _ = _settled(program, half, _SETTLED) or solved
            return nodes, farthest, at
        best = nodes, farthest, at
        if stage == 0:
            bound = float(problem.upper[-1]) * at**problem.order
            nodes = split_switches(nodes, farthest.inputs, bound)
        else:
            nodes = split_losses(nodes, farthest.losses)
    return best


def _settled(
    program: HalfProgram, half: float, rtol: float
) -> tuple[Farthest, float, float] | None:
    """Change the half duration until a half just reaches the middle; None where that fails.

    Returns the solution, the half duration it belongs to, and the next one.
    """
    cruising = program.problem.cruising  # then it is the cruise that takes longer or less long
    for step in range(_STEPS):
        farthest = program.solve(half)
        if farthest is None:
            return None
        at, half = half, half if cruising else duration_of(farthest.worth, 0.5, half)
        if not np.isfinite(half):
            return None
        if abs(half / at - 1.0) < rtol or step == _STEPS - 1:
            return farthest, at, half
    return None


def _finished(
    half: Half | None, distance: float, unit: float, limits: Limits, cruise: float = 0.0
) -> Trajectory | None:
    """Return the whole move; None where it cannot be had to rounding."""
    if half is None:
        return None
    move = whole_move(half, distance, unit, limits, cruise)
    return move if _is_sound(move, limits) else None


def _is_sound(move: Trajectory, limits: Limits) -> bool:
    """Tell whether bounds and joints are right but for rounding."""
    if not (np.isfinite(move.states).all() and (move.durations > 0.0).all()):
        return False
    ends = evaluate(move.states.T, move.durations, range(move.order))
    starts = np.vstack([move.states[1:], move.end_state]).T[: move.order]
    sizes = np.abs(starts).max(axis=1)
    joined = (np.abs(ends - starts).max(axis=1) <= _KEPT * sizes).all()
    return bool(joined) and move.violation(limits) <= _KEPT
