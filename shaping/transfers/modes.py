"""Motions of several axes from a state on, tied together in time: the ways of `synchronize`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Literal

from ..trajectory import Motion
from .axes import Axis
from .infeasible import InfeasibleError
from .problem import Problem
from .s_curve import lasting, longest

if TYPE_CHECKING:
    from .whole_transfer import WholeProblem

_ROUNDING = 16.0 * 2.0**-52
Following = Callable[[float], float]
Mode = Literal["start", "end", "both", "straight-line"]
MODES = ("start", "end", "both", "straight-line")


def ending_together(axes: list[Axis]) -> list[Motion]:
    """Return the motions, the faster ones after a wait."""
    latest = max(axis.motion.duration for axis in axes)
    for axis in axes:
        if axis.motion.duration < latest * (1.0 - _ROUNDING) and not axis.waits:
            raise ValueError(
                f"axis {axis.number} moves at its start and cannot wait: use mode='both', or start "
                "it at rest"
            )
    waits = [latest - axis.motion.duration for axis in axes]
    return [a.motion.delay(wait) if wait else a.motion for a, wait in zip(axes, waits, strict=True)]


def both_together(axes: list[Axis]) -> list[Motion]:
    """Return motions of the shortest duration that every axis can take."""
    problems = [_problem(axis) for axis in axes]
    duration = _common_duration(
        [_following(axis, problem) for axis, problem in zip(axes, problems, strict=True)]
    )
    return [_lasting(axis, problem, duration) for axis, problem in zip(axes, problems, strict=True)]


def _problem(axis: Axis) -> Problem | WholeProblem | None:
    """Return the problem that a transfer solves, None for another motion."""
    if axis.limits is None or axis.order < 2:
        return None
    exact = axis.order < 4 and axis.limits.plain
    if axis.rests and not exact:
        return None
    states = (axis.motion.start_state, axis.motion.end_state)
    start, end = (state[: axis.order].tolist() for state in states)
    if exact:
        return Problem(start, end, axis.limits)
    from .whole_transfer import WholeProblem  # which loads linear programs

    return WholeProblem(start, end, axis.limits)


def _following(axis: Axis, problem: Problem | WholeProblem | None) -> Following:
    """Return the function from a duration to the shortest possible one that is no shorter."""
    own = axis.motion.duration
    intervals = [(own, own)]
    if isinstance(problem, Problem):
        intervals = problem.possible_durations()
    elif problem is not None:
        return problem.next_duration
    elif axis.rests:
        intervals = [(own, inf)]
    elif axis.slows:
        intervals = [(own, longest(axis.motion))]
    return partial(_next_possible, intervals)


def _lasting(axis: Axis, problem: Problem | WholeProblem | None, duration: float) -> Motion:
    own = axis.motion.duration
    if own >= duration * (1.0 - _ROUNDING):
        return axis.motion
    if problem is not None:
        return problem.lasting(duration)
    if axis.rests:
        return axis.motion.stretch(duration / own) if own else axis.motion.until(duration)
    slower = lasting(axis.motion, duration)
    if slower is None:
        raise InfeasibleError(
            f"axis {axis.number} has no S-curve of duration {duration!r} from its state: expected "
            f"one near {own!r}; give it limits in place of its rates, or use mode='start'",
            "velocity",
            0.0,
        )
    return slower


def _common_duration(possible: list[Following]) -> float:
    """Return the shortest duration that every axis can take."""
    duration = 0.0
    while True:
        nexts = [following(duration) for following in possible]
        if inf in nexts:
            raise InfeasibleError(
                f"the axes have no duration in common: axis {nexts.index(inf)} can take none of "
                f"{duration!r} or more; start or end one of them with less velocity",
                "velocity",
                0.0,
            )
        if max(nexts) <= duration * (1.0 + _ROUNDING):
            return max(nexts)
        duration = max(nexts)


def _next_possible(intervals: list[tuple[float, float]], duration: float) -> float:
    """Return the shortest possible duration that is no shorter than the one given."""
    for low, high in intervals:
        if duration <= high * (1.0 + _ROUNDING):
            return low if low > duration * (1.0 + _ROUNDING) else duration
    return inf
