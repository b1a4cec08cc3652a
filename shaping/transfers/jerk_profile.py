"""One profile of bounded jerk: how far it goes, and its pieces."""

from __future__ import annotations

from typing import NamedTuple

from .task import Piece, Task


class Profile(NamedTuple):
    """Acceleration rises to `p`, holds, falls to `q` (cruising where it is zero), dwells, rises."""

    duration: float
    p: float
    hold: float
    cruise: float
    q: float
    dwell: float


def travelled(task: Task, profile: Profile) -> tuple[float, float, float, float]:
    """Return the distance without the cruise, H, and the velocities before and after the fall.

    Of arrays, too.
    """
    x, v = ramp(task.v0, task.a0, profile.p, task.rise)
    x += (v + 0.5 * profile.p * profile.hold) * profile.hold
    v += profile.p * profile.hold
    slope = v + 0.5 * profile.p * (profile.p - profile.q) / task.fall
    step, w = ramp(v, profile.p, profile.q, -task.fall)
    x += step + (w + 0.5 * profile.q * profile.dwell) * profile.dwell
    after = w + profile.q * profile.dwell
    x += ramp(after, profile.q, task.a1, task.rise)[0]
    return x, slope, v, w


def ramp(v: float, a: float, end: float, jerk: float) -> tuple[float, float]:
    """Return distance and final velocity of a change of acceleration from `a` to `end`."""
    t = (end - a) / jerk
    return (v + (2.0 * a + end) / 6.0 * t) * t, v + 0.5 * (a + end) * t


def pieces(task: Task, profile: Profile, start: float, end: float) -> list[Piece]:
    """Return the pieces of a profile from position `start` to position `end`.

    The first ones are reckoned from the start, those after the fall from the end: rounding
    meets in between.
    """
    p, q = profile.p, profile.q
    rise, fall = task.rise, task.fall
    step, v = ramp(task.v0, task.a0, p, rise)
    x = start + step
    pieces: list[Piece] = [
        ((p - task.a0) / rise, (start, task.v0, task.a0, rise)),
        (profile.hold, (x, v, p, 0.0)),
    ]
    x += (v + 0.5 * p * profile.hold) * profile.hold
    v += p * profile.hold
    step, w = ramp(task.v1, task.a1, q, rise)  # backwards in time, as all that follows
    y = end + step
    rear: list[Piece] = [((task.a1 - q) / rise, (y, w, q, rise))]
    y -= (w - 0.5 * q * profile.dwell) * profile.dwell
    w -= q * profile.dwell
    rear.insert(0, (profile.dwell, (y, w, q, 0.0)))
    if profile.cruise == 0.0:
        return [*pieces, ((p - q) / fall, (x, v, p, -fall)), *rear]
    top = task.v_max
    pieces.append((p / fall, (x, v, p, -fall)))
    pieces.append((profile.cruise, (x + ramp(v, p, 0.0, -fall)[0], top, 0.0, 0.0)))
    y -= ramp(top, 0.0, q, -fall)[0]
    return [*pieces, (-q / fall, (y, top, 0.0, -fall)), *rear]
