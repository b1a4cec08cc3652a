"""The fastest plan of a task, the durations that it can take, and its plan of a given duration."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from math import copysign, inf, isnan, nan
from typing import Any, Protocol

from . import second_order, third_order
from .task import ROUNDING, Piece, Task, taylor
from .velocity_change import Change, change_velocity

Pieces = list[Piece]


class Family(Protocol):
    """Profiles that go furthest in their time: what those of order 2 and 3 have in common.

    An error of the distance up to `blur` is mere rounding.
    """

    blur: float

    def solutions(self) -> Iterator[Any]:
        """Yield every profile that covers the task's distance."""

    def lasting(self, duration: float) -> Any:
        """Return the profile of a given duration, None where there is none."""

    def limits_of_duration(self) -> Iterator[float]:
        """Yield the durations at which the family begins or ends."""

    def distance(self, profile: Any) -> float:
        """Return the distance that a profile covers."""

    def pieces(self, profile: Any, start: float, end: float) -> Pieces:
        """Return the pieces of a profile from position `start` to position `end`."""


def families(task: Task) -> tuple[Family, Family]:
    """Return the families of the profiles that go furthest up and, mirrored, furthest down."""
    make: Callable[[Task], Family] = second_order.Family if task.rise == inf else third_order.Family
    return make(task), make(task.mirror())


def fastest(task: Task, start: float, end: float) -> Pieces | None:
    """Return the pieces of the minimum-time plan, None where there is none.

    The quickest change from (v0, a0) to (v1, a1) covers a distance d. Where the durations of such
    changes have no gap, which takes accelerations of one sign, the distances that can be covered
    grow continuously from d both ways, and the sign of what is missing tells the family.
    """
    up, down = families(task)
    falls = task.distance < change_velocity(task).distance
    best: tuple[Family, Any] | None = None
    for family in (down, up) if falls else (up, down):
        found = min(family.solutions(), key=_duration, default=None)
        if found is not None and (best is None or found.duration < best[1].duration):
            best = family, found
        if best is not None and task.a0 * task.a1 <= 0.0:
            break
    if best is None:
        return None
    family, profile = best
    if family is up:
        return up.pieces(profile, start, end)
    return mirrored(down.pieces(profile, -start, -end))


def _duration(profile: Any) -> float:
    return float(profile.duration)


def mirrored(pieces: Pieces) -> Pieces:
    """Return the pieces of the motion in the opposite direction."""
    return [(duration, tuple(-value for value in row)) for duration, row in pieces]


def possible_durations(task: Task) -> list[tuple[float, float]]:
    """Return the intervals of durations in which the task can be done, in increasing order.

    For a given duration the distances that can be covered are an interval, from the furthest
    down to the furthest up, so that the possible durations change only where one of the two
    families covers the task's distance, begins or ends.
    """
    both = families(task)
    solutions = [p.duration for family in both for p in family.solutions()]
    marks = sorted({*solutions, *(t for family in both for t in family.limits_of_duration())})
    intervals: list[tuple[float, float]] = []
    edges = [*marks, 2.0 * marks[-1] + 1.0] if marks else []
    for left, right in pairwise(edges):
        if right == edges[-1]:
            right = inf
        middle = 0.5 * (left + right) if right < inf else edges[-1]
        if _covers(task, middle, *both):
            intervals.append((left, right))
        elif left in solutions and not (intervals and intervals[-1][1] == left):
            intervals.append((left, left))
    return _merged(intervals)


def _covers(task: Task, duration: float, up: Family, down: Family) -> bool:
    """Tell whether the task's distance can be covered in a duration."""
    highest, lowest = up.lasting(duration), down.lasting(duration)
    if highest is None or lowest is None:
        return False
    return -down.distance(lowest) <= task.distance <= up.distance(highest)


def _merged(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    merged: list[tuple[float, float]] = []
    for low, high in intervals:
        if merged and low <= merged[-1][1] * (1.0 + ROUNDING):
            merged[-1] = merged[-1][0], high
        else:
            merged.append((low, high))
    return merged


def lasting(task: Task, duration: float, start: float, end: float) -> Pieces | None:
    """Return a plan of the given duration, None where there is none.

    If possible it goes to one velocity, keeps it, and goes to the end's; else it is a weighted
    mean of the motions that go furthest up and furthest down in this time, which keeps every
    bound as they do.
    """
    plan = by_cruising(task, duration, start, end)
    if plan is not None:
        return plan
    up, down = families(task)
    highest, lowest = up.lasting(duration), down.lasting(duration)
    if highest is None or lowest is None:
        return None
    top, bottom = up.distance(highest), -down.distance(lowest)
    # of speeds up to one, in the task's own units
    slack = up.blur + 16.0 * ROUNDING * (abs(top) + abs(bottom) + duration)
    if not bottom - slack <= task.distance <= top + slack:
        return None
    weight = (task.distance - bottom) / (top - bottom) if top > bottom else 1.0
    return _mean(
        up.pieces(highest, start, start + top),
        mirrored(down.pieces(lowest, -start, -start - bottom)),
        min(max(weight, 0.0), 1.0),
    )


def _mean(first: Pieces, second: Pieces, weight: float) -> Pieces:
    """Return the motion weight·first + (1 − weight)·second."""
    first, second = ([piece for piece in pieces if piece[0] > 0.0] for pieces in (first, second))
    mean: Pieces = []
    while first and second:
        (t1, row1), (t2, row2) = first[0], second[0]
        t = t1 if t1 <= t2 * (1.0 + ROUNDING) else t2
        row = tuple(weight * x + (1.0 - weight) * y for x, y in zip(row1, row2, strict=True))
        mean.append((t, row))
        first, second = _without(first, t), _without(second, t)
    return mean


def _without(pieces: Pieces, time: float) -> Pieces:
    """Return the pieces from `time` on, no later than the end of the first."""
    duration, row = pieces[0]
    if duration <= time * (1.0 + ROUNDING):
        return pieces[1:]
    return [(duration - time, taylor(row, time)), *pieces[1:]]


def by_cruising(task: Task, duration: float, start: float, end: float) -> Pieces | None:
    """Return the plan of a duration that goes to one velocity, keeps it, and goes to the end's.

    The distance grows with that velocity. None where no velocity suits: the changes of velocity
    alone take longer than the duration, or none of them covers the distance.
    """
    velocity = _cruising_velocity(task, duration)
    if velocity is None:
        return None
    first, last = _changes(task, velocity)
    cruise = max(duration - first.duration - last.duration, 0.0)
    resting = (0.0,) if task.rise == inf else (0.0, 0.0)
    return [
        *first.pieces(start),
        (cruise, (start + first.distance, velocity, *resting)),
        *last.pieces(end - last.distance),
    ]


def _changes(task: Task, velocity: float) -> tuple[Change, Change]:
    """Return the changes from the start to a velocity kept, and from that to the end."""
    first = change_velocity(task._replace(v1=velocity, a1=0.0))
    return first, change_velocity(task._replace(v0=velocity, a0=0.0))


def _cruising_velocity(task: Task, duration: float) -> float | None:
    """Return the velocity to cruise at so as to cover the distance in the duration."""

    def error(velocity: float) -> float:
        """Return the excess of the distance; NaN where the changes take too long."""
        first, last = _changes(task, velocity)
        cruise = duration - first.duration - last.duration
        if cruise < -ROUNDING * duration or last.leaves_bounds():
            return nan
        return first.distance + last.distance + velocity * cruise - task.distance

    speed = max(abs(task.v0), abs(task.v1))
    slack = task.resolution + 64.0 * ROUNDING * (abs(task.distance) + speed * duration)
    nearest = [_settling(task.v0, task.a0, task), _settling(task.v1, -task.a1, task)]
    known = [(v, e) for v in nearest if not isnan(e := error(v))]
    if not known:
        return None
    below = [pair for pair in known if pair[1] <= 0.0]
    above = [pair for pair in known if pair[1] >= 0.0]
    low = max(below) if below else _beyond(min(above)[0], task.v_min, error)
    high = min(above) if above else _beyond(max(below)[0], task.v_max, error)
    velocity, left = _bracketed(error, low, high)
    return velocity if abs(left) <= slack else None


def _settling(velocity: float, acceleration: float, task: Task) -> float:
    """Return the velocity reached when acceleration goes to zero as fast as it can."""
    jerk = task.fall if acceleration > 0.0 else -task.rise
    gain = 0.5 * acceleration * acceleration / jerk if acceleration else 0.0
    return min(max(velocity + gain, task.v_min), task.v_max)


def _beyond(velocity: float, bound: float, error: Callable[[float], float]) -> tuple[float, float]:
    """Return a velocity towards a bound at which the error has changed sign, or is not known."""
    if abs(bound) < inf:
        return bound, error(bound)
    step = copysign(max(abs(velocity), 1.0), bound)
    before = error(velocity)
    while error(velocity + step) * before > 0.0:
        step *= 2.0
    return velocity + step, error(velocity + step)


def _bracketed(
    error: Callable[[float], float], low: tuple[float, float], high: tuple[float, float]
) -> tuple[float, float]:
    """Return where an increasing function is nearest to zero; at one end it may be NaN (far)."""
    best = min((pair for pair in (low, high) if not isnan(pair[1])), key=lambda p: abs(p[1]))
    unknown_is_high = isnan(high[1])
    for k in range(200):
        middle = 0.5 * (low[0] + high[0])
        if k % 3 and not isnan(low[1] + high[1]) and high[1] > low[1]:
            secant = low[0] - low[1] * (high[0] - low[0]) / (high[1] - low[1])
            middle = secant if low[0] < secant < high[0] else middle
        if not low[0] < middle < high[0]:
            break
        at = middle, error(middle)
        if isnan(at[1]):
            low, high = (low, at) if unknown_is_high else (at, high)
            continue
        if abs(at[1]) < abs(best[1]):
            best = at
        if at[1] == 0.0:
            break
        low, high = (at, high) if at[1] < 0.0 else (low, at)
    return best
