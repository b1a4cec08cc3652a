"""Moves of order 4 and more in minimum time: the best of closed forms and a linear program.

    maximise x(T/2)  subject to  |x^(k)| ≤ L_k for all t,  x^(k)(T/2) = 0 for even k ≥ 2,

with x^(n) constant on the cells of a mesh and T so that x(T/2) is half the distance; the second
half is the mirror image. What the optimum looks like: Wang & Hu, arXiv 2311.07039 and
2403.17675.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..closed_moves import closed_form_move
from ..limits import Limits
from ..pieces import FloatArray, evaluate
from ..trajectory import Trajectory
from ..warned import warn_caller
from .half_motion import Half, merged, whole_move
from .half_problem import Farthest, HalfProblem, HalfProgram, duration_of
from .mesh import graded_mesh, split_losses, split_sudden, split_switches
from .quick_bounds import least_duration, spline_durations
from .smoothing import averaged_half, averaging_width, lower_order, relative_width, truncated

MAX_OPTIMAL_ORDER = 10
"""Highest order that a linear program is tried for; above it a move is the closed form."""

_CELLS = 40
_NEGLIGIBLE = 1e-7  # a gain in duration that is not worth leaving a closed form for
_NEAR = 1e-3  # of the duration: what a closed form may lose without a warning
_SHORT = 2e-5  # of the duration: what moving averages of a lower order may cost
_NOT_LONG = 2e-4  # the same where the linear program is tried as well
_LENGTHENED = 0.1  # the same where that fails
_LONG = 2.0  # times the ramps' time: how much cruise is left in the linear program
_STAGES = 9
_LOST = 5e-6  # of the distance, for want of a finer mesh: not worth another stage
_FORESEEN = 3.0  # times what was estimated to be lost: gaining more, the estimate is no use
_MOST_CELLS = 150
_ROUGHLY, _SETTLED = 1e-3, 1e-7  # steps on the duration after which no other is needed
_STEPS = 8
_KEPT = 1e-12  # excess over a bound, jump at a joint
_SAME_INPUT = (1e-7, 0.0)  # of the bound: inputs of neighbours that are merged


def faster_or_warn(closed: Trajectory, limits: Limits) -> Trajectory:
    """Return `improved`, or the closed form itself with a warning where that cannot be had."""
    move = improved(closed, limits)
    if move is not None:
        return move
    lost = closed.duration / least_duration(float(closed.end_state[0]), limits) - 1.0
    if lost <= _NEAR:
        return closed
    reason = (
        f"order {limits.order} is above {MAX_OPTIMAL_ORDER}"
        if limits.order > MAX_OPTIMAL_ORDER
        else "these limits are too far apart for the linear program"
    )
    warn_caller(
        f"{reason}: this move is the fastest closed form, which may be "
        + (f"up to {100.0 * lost:.2g} % " if lost < 1.0 else "")
        + "slower than need be"
    )
    return closed


def improved(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return a faster move than a closed form in positive direction, or that where none is.

    None where the linear program could not be used.
    """
    if limits.order <= 3 or _is_single_spline(closed, limits):
        return closed
    if limits.order > MAX_OPTIMAL_ORDER:
        return None
    with np.errstate(all="ignore"):
        move = _averaged(closed, limits, _SHORT) or _programmed_or_averaged(closed, limits)
    if move is None or move.duration < closed.duration * (1.0 - _NEGLIGIBLE):
        return move
    return closed


def _is_single_spline(closed: Trajectory, limits: Limits) -> bool:
    """Tell whether one bound alone already takes this long: then the closed form is optimal."""
    least = spline_durations(float(closed.end_state[0]), limits).max()
    return bool(closed.duration <= least * (1.0 + _KEPT))


def _averaged(closed: Trajectory, limits: Limits, most: float) -> Trajectory | None:
    """Return the move of a lower order, smoothed, where that costs no more than `most`."""
    order = lower_order(limits)
    if not order or relative_width(limits, order, closed.duration) > most:
        return None
    distance, below = float(closed.end_state[0]), truncated(limits, order)
    lower = closed_form_move(distance, below)
    lower = improved(lower, below) or lower
    half = averaged_half(lower, limits.order, averaging_width(limits, order))
    return _finished(half, distance, 1.0, limits)


def _programmed_or_averaged(closed: Trajectory, limits: Limits) -> Trajectory | None:
    """Return the faster one of both motions where they may be near, or the first fails."""
    move = _programmed(closed, limits)
    failed = move is None or move.duration >= closed.duration
    other = _averaged(closed, limits, _LENGTHENED if failed else _NOT_LONG)
    if other is not None and other.duration < (closed if move is None else move).duration:
        return other
    return move


def _programmed(closed: Trajectory, limits: Limits, left: float = _LONG) -> Trajectory | None:
    """Return the linear program's motion; None where it fails."""
    distance = float(closed.end_state[0])
    shorter = without_cruise(closed, limits, left)
    base = closed if shorter is None else shorter
    covered = float(base.end_state[0])
    problem = HalfProblem.make(covered, limits, base)
    problem = replace(problem, cruising=shorter is not None)
    found = _refined(problem, graded_mesh(base, _CELLS))
    if found is None:
        return None
    nodes, farthest, half = found
    cruise = 0.0
    if shorter is not None:
        ahead = 0.5 * distance / covered - farthest.distance
        cruise = ahead / (float(problem.upper[1]) * half)
        if cruise < 0.0:  # more was cut out than there is
            return _programmed(closed, limits, np.inf)
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


def without_cruise(closed: Trajectory, limits: Limits, left: float) -> Trajectory | None:
    """Return the closed form of a move with less of a long cruise; None if it is short.

    `left` times the time of the ramps is left.
    """
    middle = int(np.searchsorted(closed.breaks, 0.5 * closed.duration)) - 1
    velocity, *higher = closed.states[middle, 1:].tolist()
    cruise = float(closed.durations[middle])
    ramps = closed.duration - cruise
    if any(higher) or velocity < limits.bounds(1)[1] or cruise <= left * ramps:
        return None
    shorter = float(closed.end_state[0]) - velocity * (cruise - left * ramps)
    return closed_form_move(shorter, limits)


def _refined(problem: HalfProblem, nodes: FloatArray) -> tuple[FloatArray, Farthest, float] | None:
    """Solve on finer meshes; return the last nodes, the solution and its half duration."""
    half, lost = 1.0, 0.0
    best: tuple[FloatArray, Farthest, float] | None = None
    for stage in range(_STAGES):
        before, program = half, HalfProgram(problem, nodes)
        solved = _settled(program, half, _ROUGHLY)
        if solved is None:
            break
        farthest, at, half = solved
        complete = problem.completed(nodes, farthest.inputs, at)
        if complete is not problem:
            return _refined(complete, nodes)
        unforeseen = 0.5 * (before / half - 1.0) - _FORESEEN * lost
        lost = float(farthest.losses.sum())
        if stage and (max(lost, unforeseen) <= _LOST or len(nodes) > _MOST_CELLS):
            farthest, at, _ = _settled(program, half, _SETTLED) or solved
            return nodes, farthest, at
        best = nodes, farthest, at
        nodes = _split(problem, nodes, farthest, at, stage)
    return best


def _split(
    problem: HalfProblem, nodes: FloatArray, farthest: Farthest, half: float, stage: int
) -> FloatArray:
    """Return a finer mesh."""
    bound = float(problem.upper[-1]) * half**problem.order
    if stage == 0:
        return split_switches(nodes, farthest.inputs, bound)
    levels = problem.levels(nodes, farthest.inputs, half)
    finer = split_sudden(nodes, farthest.inputs, bound, levels)
    if farthest.losses.sum() <= _LOST:
        return finer
    return np.union1d(finer, split_losses(nodes, farthest.losses))


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
