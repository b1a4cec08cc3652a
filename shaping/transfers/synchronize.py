"""Several axes at once: started, ended or both together, or kept on a straight line."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import Literal

from ..checks import in_range
from ..derivatives import derivative_name
from ..limits import Limits
from ..trajectory import Trajectory
from .infeasible import InfeasibleError, unreachable
from .problem import Problem, State, Transfer
from .task import ROUNDING
from .transfer import min_time_transfer

Mode = Literal["start", "end", "both", "straight-line"]
Axis = Transfer | tuple[State, State, Limits]

_ALIKE = 1e-9  # relative difference of two axes' speeds along the line that is rounding


def synchronize(transfers: Iterable[Axis], mode: Mode = "both") -> tuple[Trajectory, ...]:
    """Return the transfers of several axes, tied together in time.

    Parameters
    ----------
    transfers : iterable of Transfer or (start, end, limits)
        One per axis, as `min_time_transfer` returns or takes it. Units may differ between axes
        but for that of time.
    mode : "start", "end", "both" or "straight-line"
        "start": all start at time 0, each takes its own minimum time. "end": all end together,
        the faster ones waiting at rest first. "both": all take the shortest duration that every
        axis can take. "straight-line": one profile for all, so that the axes stay on the line
        from start to end even where that is slower; the axes' limits all hold.

    Returns
    -------
    tuple of Trajectory
        In the order given.

    Raises
    ------
    InfeasibleError
        For an end that an axis cannot reach, or axes that have no duration in common.
    ValueError
        For an unknown mode, no axis at all, "end" with an axis that must wait but moves at its
        start, or "straight-line" with velocities or accelerations off the line.

    Notes
    -----
    The durations that an axis can take need not be an interval: one that moves at its start and
    end may be able to pass quickly, or to turn back and pass again, and take no time in between.
    "both" takes the shortest duration that lies in an interval of every axis. An axis with time to
    spare goes to a lower velocity, keeps it, and goes to its end; where the time is too short
    for that, its motion is a weighted mean of those that go furthest up and furthest down in
    that time.

    Examples
    --------
    >>> pan, tilt = synchronize([
    ...     (0.0, 90.0, Limits(velocity=30.0, acceleration=20.0)),
    ...     (0.0, 10.0, Limits(velocity=30.0, acceleration=20.0)),
    ... ])
    >>> pan.duration, tilt.duration, round(tilt.peak("velocity"), 3)
    (4.5, 4.5, 2.28)
    """
    if mode not in ("start", "end", "both", "straight-line"):
        raise ValueError(f"mode = {mode!r}: expected 'start', 'end', 'both' or 'straight-line'")
    if isinstance(transfers, Transfer) or not isinstance(transfers, Iterable):
        raise TypeError(f"transfers = {transfers!r}: expected a list with one entry per axis")
    axes = [_planned(number, axis) for number, axis in enumerate(transfers)]
    if not axes:
        raise ValueError("transfers is empty: expected at least one axis")
    if mode == "straight-line":
        return _straight_line(axes)
    if mode == "start":
        return tuple(axes)
    if mode == "end":
        return _ending_together(axes)
    return in_range(lambda: _both(axes))


def _planned(number: int, axis: Axis) -> Transfer:
    if isinstance(axis, Transfer):
        return axis
    if isinstance(axis, tuple | list) and len(axis) == 3:
        try:
            return min_time_transfer(*axis)
        except InfeasibleError as error:
            raise InfeasibleError(f"axis {number}: {error}", error.bound, error.nearest) from None
        except ValueError as error:
            raise ValueError(f"axis {number}: {error}") from None
    raise TypeError(
        f"axis {number} = {axis!r}: expected what min_time_transfer returns, or "
        "(start, end, limits)"
    )


def _ending_together(axes: list[Transfer]) -> tuple[Trajectory, ...]:
    latest = max(axis.duration for axis in axes)
    for number, axis in enumerate(axes):
        waits = axis.duration < latest * (1.0 - ROUNDING)
        if waits and any(axis.start_state[1 : axis.order] != 0.0):
            raise ValueError(
                f"axis {number} moves at its start and cannot wait: use mode='both', or start it "
                "at rest"
            )
    return tuple(axis.delay(latest - axis.duration) for axis in axes)


def _both(axes: list[Transfer]) -> tuple[Trajectory, ...]:
    problems = [Problem(*_ends(axis), axis.limits) for axis in axes]
    duration = _common_duration([problem.possible_durations() for problem in problems])
    together = []
    for axis, problem in zip(axes, problems, strict=True):
        slowest = axis.duration >= duration * (1.0 - ROUNDING)
        plan = axis if slowest else problem.lasting(duration)
        if plan is None:
            raise unreachable(*problem.end[1:], problem.limits)
        together.append(plan)
    return tuple(together)


def _ends(axis: Transfer) -> tuple[list[float], list[float]]:
    return axis.start_state[: axis.order].tolist(), axis.end_state[: axis.order].tolist()


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
        if duration <= high * (1.0 + ROUNDING):
            return low if low > duration * (1.0 + ROUNDING) else duration
    return inf


def _straight_line(axes: list[Transfer]) -> tuple[Trajectory, ...]:
    """Return the motion along the line, as one profile from 0 to 1 scaled to each axis.

    Derivative k of axis i is R_i·s^(k), so that the bounds of s^(k) are the tightest of the
    axes' bounds over R_i.
    """
    order = axes[0].order
    if any(axis.order != order for axis in axes):
        raise ValueError(
            f"axes of orders {[axis.order for axis in axes]}: expected limits of one order for "
            "all axes of a straight line"
        )
    spans = [float(axis.end_state[0] - axis.start_state[0]) for axis in axes]
    longest = max(range(len(axes)), key=lambda i: abs(spans[i]))
    for number, (axis, span) in enumerate(zip(axes, spans, strict=True)):
        _check_on_line(number, axis, span, axes[longest], spans[longest])
    if spans[longest] == 0.0:
        return tuple(axes)
    bounds = []
    for k in range(1, order + 1):
        sides = [
            sorted(bound / span for bound in axis.limits.bounds(k))
            for axis, span in zip(axes, spans, strict=True)
            if span != 0.0
        ]
        bounds.append((max(low for low, _ in sides), min(high for _, high in sides)))
    begin, finish = (
        [fraction, *(state[1:order] / spans[longest]).tolist()]
        for fraction, state in (
            (0.0, axes[longest].start_state),
            (1.0, axes[longest].end_state),
        )
    )
    profile = min_time_transfer(begin, finish, Limits.from_bounds(bounds))
    return tuple(
        profile.scale(span).shift(float(axis.start_state[0]))
        for axis, span in zip(axes, spans, strict=True)
    )


def _check_on_line(
    number: int, axis: Transfer, span: float, leader: Transfer, longest: float
) -> None:
    """Refuse an axis whose velocity or acceleration at an end leads off the line."""
    share = span / longest if longest else 0.0
    for name in ("start", "end"):
        own, leading = getattr(axis, f"{name}_state"), getattr(leader, f"{name}_state")
        for k in range(1, axis.order):
            expected = share * leading[k]
            if abs(own[k] - expected) > _ALIKE * max(abs(own[k]), abs(expected)):
                raise ValueError(
                    f"axis {number}: {name} {derivative_name(k)} = {float(own[k])!r} leads off the "
                    f"straight line: expected {float(expected)!r}, in proportion to its distance; "
                    "use mode='both', or start and end at rest"
                )
