"""Several axes at once: started, ended or both together, or kept on a straight line."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import Literal

from ... import core
from ..checks import one_of
from ..limits import Limits
from ..real_numbers import shown
from ..trajectory import Motion
from .axes import Axis, as_axis
from .infeasible import InfeasibleError
from .problem import Problem, State, Transfer
from .straight_line import straight_line

_ROUNDING = 16.0 * 2.0**-52
Mode = Literal["start", "end", "both", "straight-line"]
Given = Motion | tuple[State, State, Limits]


def synchronize(transfers: Iterable[Given], mode: Mode = "both") -> tuple[Motion, ...]:
    """Return the transfers of several axes, tied together in time.

    Parameters
    ----------
    transfers : iterable of Trajectory, Transfer or (start, end, limits)
        One per axis: what `min_time_transfer`, `min_time_move`, `s_curve_move` or another shaper
        returns, or what the first two are planned with (from rest to rest at other orders than 2
        and 3). Orders and kinds may be mixed. Units may differ between axes but for that of time.
    mode : "start", "end", "both" or "straight-line"
        "start": all start at time 0, each takes its own minimum time. "end": all end together,
        the faster ones waiting at rest first. "both": all take the shortest duration that every
        axis can take. "straight-line": one profile for all, so that the axes stay on the line
        from start to end even where that is slower; the axes' limits all hold. Of an axis whose
        limits are not known (a move, an S-curve) the peaks of its motion hold.

    Returns
    -------
    tuple of Trajectory or Transfer
        In the order given; what was planned within known limits is a transfer.

    Raises
    ------
    InfeasibleError
        For an end that an axis cannot reach, or axes that have no duration in common.
    ValueError
        For an unknown mode, no axis at all, "end" with an axis that must wait but moves at its
        start, or "straight-line" with velocities or accelerations off the line, or with a motion
        not from rest to rest whose limits are not known or not all of one order.

    Notes
    -----
    The durations that an axis can take need not be an interval: one that moves at its start and
    end may be able to pass quickly, or to turn back and pass again, and take no time in between.
    "both" takes the shortest duration that lies in an interval of every axis. An axis with time to
    spare goes to a lower velocity, keeps it, and goes to its end; where the time is too short
    for that, its motion is a weighted mean of those that go furthest up and furthest down in
    that time. A move of order 1, 4 or more, or an S-curve, has no limits to plan anew within: from
    rest to rest it is slowed down as a whole, x(t) → x(t/c), which divides derivative k by c^k,
    and otherwise it keeps its own duration.

    The profile of a "straight-line" of moves is the motion of one of the axes, slowed down until
    the others keep their bounds, or `min_time_move` within the bounds of all, if that is faster.

    Examples
    --------
    >>> pan, tilt = synchronize([
    ...     (0.0, 90.0, Limits(velocity=30.0, acceleration=20.0)),
    ...     (0.0, 10.0, Limits(velocity=30.0, acceleration=20.0)),
    ... ])
    >>> pan.duration, tilt.duration, round(tilt.peak("velocity"), 3)
    (4.5, 4.5, 2.28)
    """
    one_of("mode", mode, ("start", "end", "both", "straight-line"))
    if type(transfers) is not list:
        if isinstance(transfers, Motion) or not isinstance(transfers, Iterable):
            told = f"transfers = {shown(transfers)}: expected a list with one entry per axis"
            raise TypeError(told)
        transfers = list(transfers)
    if mode == "both":
        together = _in_the_core(transfers)
        if together is not None:
            return together
    axes = [as_axis(number, given) for number, given in enumerate(transfers)]
    if not axes:
        raise ValueError("transfers is empty: expected at least one axis")
    if mode == "straight-line":
        return straight_line(axes)
    if mode == "start":
        return tuple(axis.motion for axis in axes)
    if mode == "end":
        return _ending_together(axes)
    return _both(axes)


def _in_the_core(transfers: list[Given]) -> tuple[Transfer, ...] | None:
    """Return transfers as they were planned, slowed down to one duration; None for others."""
    own = [one for one in transfers if type(one) is Transfer and "_motion" in one.__dict__]
    if not len(own) == len(transfers) > 0:
        return None
    motions = tuple([one.__dict__["_motion"] for one in own])
    limits = [one.__dict__["limits"] for one in own]
    found = core.together(motions, tuple([each.flat for each in limits]))
    if isinstance(found, int):
        return None
    return tuple(
        [
            one if motion is before else Transfer.of(motion, each)
            for one, before, motion, each in zip(own, motions, found, limits, strict=True)
        ]
    )


def _ending_together(axes: list[Axis]) -> tuple[Motion, ...]:
    latest = max(axis.motion.duration for axis in axes)
    for axis in axes:
        waits = axis.motion.duration < latest * (1.0 - _ROUNDING)
        if waits and any([*axis.motion.start_state[1 : axis.order], axis.motion.coasting_in()[1]]):
            raise ValueError(
                f"axis {axis.number} moves at its start and cannot wait: use mode='both', or start "
                "it at rest"
            )
    return tuple(axis.motion.delay(latest - axis.motion.duration) for axis in axes)


def _both(axes: list[Axis]) -> tuple[Motion, ...]:
    problems = [_problem(axis) for axis in axes]
    duration = _common_duration(
        [_durations(axis, problem) for axis, problem in zip(axes, problems, strict=True)]
    )
    return tuple(
        _lasting(axis, problem, duration) for axis, problem in zip(axes, problems, strict=True)
    )


def _problem(axis: Axis) -> Problem | None:
    """Return the problem that a transfer solves, None for another motion."""
    if axis.limits is None or axis.order not in (2, 3):
        return None
    states = (axis.motion.start_state, axis.motion.end_state)
    start, end = (state[: axis.order].tolist() for state in states)
    return Problem(start, end, axis.limits)


def _durations(axis: Axis, problem: Problem | None) -> list[tuple[float, float]]:
    """Return the intervals of durations that an axis can take."""
    if problem is not None:
        return problem.possible_durations()
    return [(axis.motion.duration, inf if axis.rests else axis.motion.duration)]


def _lasting(axis: Axis, problem: Problem | None, duration: float) -> Motion:
    own = axis.motion.duration
    if own >= duration * (1.0 - _ROUNDING):
        return axis.motion
    if problem is None:
        return axis.motion.stretch(duration / own) if own else axis.motion.until(duration)
    return problem.lasting(duration)


def _common_duration(possible: list[list[tuple[float, float]]]) -> float:
    """Return the shortest duration that lies in an interval of every axis."""
    duration = 0.0
    while True:
        following = max(_next_possible(intervals, duration) for intervals in possible)
        if following == inf:
            raise InfeasibleError(
                "the axes have no duration in common: each can only take those of "
                f"{possible}; start or end one of them with less velocity",
                "velocity",
                0.0,
            )
        if following <= duration:
            return duration
        duration = following


def _next_possible(intervals: list[tuple[float, float]], duration: float) -> float:
    """Return the shortest possible duration that is no shorter than the one given."""
    for low, high in intervals:
        if duration <= high * (1.0 + _ROUNDING):
            return low if low > duration * (1.0 + _ROUNDING) else duration
    return inf
