"""The motions of a stretch by linear programs alone: of any order, within bounds of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from math import ldexp

import numpy as np

from ..limits import Limits
from ..optimal.whole.problem import WholeProblem, power_of_two
from ..optimal.whole.repair import repaired
from ..optimal.whole.sampled import Sampled
from ..pieces import FloatArray
from ..trajectory import Motion, Trajectory
from .legs import PlannedLegs, States, on_line
from .program import COARSE, FINE, Iterate, Program, Stretch
from .route import Leg, reach_along

_REFINED = 3
_TRIED, _STEP = 4, 1.4  # durations to begin with, each so much longer
_NEVER = -1.0  # no two inputs are one: the repair may need them all
_LONGER = (0.0, 1e-5, 1e-4, 1e-3, 1e-2)  # tried where no motion keeps all bounds exactly


def settled(
    stretch: Stretch, durations: Sequence[float], first: FloatArray, last: FloatArray
) -> PlannedLegs | None:
    """Return motions over the legs of a stretch between its first and last state, or None.

    Durations and states are those of `approximations`, without margins and on meshes that are
    refined where inputs switch; of these durations the motions are then found exactly, each with
    a small share of its highest bound.
    """
    program = Program(stretch, durations)
    at = _begun(program, durations)
    if at is None:
        return None
    for stage in COARSE[1:]:
        at = program.solve(at, stage._replace(margin=0.0)) or at
    for number, stage in enumerate(FINE):
        found = program.solve(at, stage._replace(margin=0.0))
        if found is None:
            break
        at = found
        if number < _REFINED:
            program.refine(at)
    for longer in _LONGER:
        found = program.settled(at, 1.0 + longer)
        legs = None if found is None else _exact(program, found, first, last)
        if legs is not None:
            return legs
    return None


def _begun(program: Program, durations: Sequence[float]) -> Iterate | None:
    """Return what the first program finds from these durations, or from longer ones."""
    at = program.first(durations)
    for _ in range(_TRIED):
        found = program.solve(at, COARSE[0]._replace(margin=0.0))
        if found is not None:
            return found
        at = at._replace(lengths=at.lengths * _STEP)
    return None


def _exact(
    program: Program, found: Iterate, first: FloatArray, last: FloatArray
) -> PlannedLegs | None:
    """Return the motions of all legs, their ends exact; None where one breaks a bound."""
    stretch = program.stretch
    states: States = program.states(found.inputs)
    states[0], states[-1] = first, last
    durations = (found.lengths * stretch.time).tolist()
    motions, used = [], 0
    meshes = iter(program.meshes)
    for number, leg in enumerate(stretch.legs):
        along: list[Trajectory] = []
        for way in range(len(leg.limits)):
            edges = next(meshes)
            levels = found.levels[used : used + len(edges) - 1] * program.size(number, way)
            used += len(levels)
            ends = states[number], states[number + 1]
            problem = _problem(leg, way, *ends, stretch.limits)
            motion = _repaired(problem, edges, levels, durations[number])
            if motion is None:
                return None
            along.append(motion)
        motions.append(_of_axes(leg, along, states[number][0]))
    return PlannedLegs(tuple(durations), tuple(motions))


def _problem(
    leg: Leg, number: int, start: FloatArray, end: FloatArray, limits: Sequence[Limits]
) -> WholeProblem:
    """Return the problem along a way of a leg: on a line as seen from its start."""
    way, one = leg.way[:, number], leg.limits[number]
    n, place = one.order, start[0] * (leg.kind == "straight")
    begin, finish = ((way @ state.T)[:n] for state in (start, end))
    begin[0], finish[0] = way @ (start[0] - place), way @ (end[0] - place)
    low, high = reach_along(way, place, limits)
    return WholeProblem(begin, finish, np.array([low, *one.lower]), np.array([high, *one.upper]))


def _repaired(
    problem: WholeProblem, edges: FloatArray, levels: FloatArray, duration: float
) -> Trajectory | None:
    """Return the motion with these inputs, in the time of the leg, with its end made exact."""
    time = power_of_two(duration)
    size = problem.length_in(duration)
    length = power_of_two(size) if size > 0.0 else 0
    own = problem.scaled(length, time)
    motion = Sampled(edges, np.ldexp(levels, -length), ldexp(duration, -time))
    with np.errstate(all="ignore"):
        found = repaired(own, motion, same=_NEVER)
    return None if found is None else found.trajectory(problem, length, time)


def _of_axes(leg: Leg, along: list[Trajectory], place: FloatArray) -> tuple[Motion, ...]:
    if leg.kind == "straight":
        return on_line(along[0], leg.way[:, 0], place)
    return tuple(along)
