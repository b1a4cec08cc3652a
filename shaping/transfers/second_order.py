"""Transfers with bounded acceleration: speed up to a peak velocity, cruise, slow down.

The profile that goes furthest in its time accelerates at a_max to a peak velocity w, cruises
where w = v_max, and decelerates at a_min (Thompson, Section II, with any velocity at both ends):

    distance = (w² − v0²)/(2·a_max) + (w² − v1²)/(2·|a_min|) + v_max·cruise,
    w ≥ max(v0, v1).

Both roots w can be profiles, the one of the lower w the shorter: between their durations the
distance cannot be covered at all. The profiles that go the least far are those of the mirrored
task.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, sqrt
from typing import NamedTuple

from .task import ROUNDING, Piece, Task


class Profile(NamedTuple):
    """Velocity goes to its peak at full acceleration, cruises, and comes back."""

    duration: float
    peak: float
    cruise: float


class Family:
    """The profiles that go furthest in their time."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.least = max(task.v0, task.v1)
        speed = max(abs(task.v0), abs(task.v1))
        stop = speed * speed / min(task.a_max, -task.a_min)
        # an error of the distance that is mere rounding: of a stop, at the least
        self.blur = task.resolution + ROUNDING * (abs(task.distance) + stop)

    def _timed(self, peak: float, cruise: float = 0.0) -> Profile:
        task = self.task
        ramps = (peak - task.v0) / task.a_max + (task.v1 - peak) / task.a_min
        return Profile(ramps + cruise, peak, cruise)

    def travel(self, peak: float) -> tuple[float, float]:
        """Return the distance covered without a cruise, and a scale of its rounding."""
        task = self.task
        up = (peak - task.v0) * (peak + task.v0) * 0.5 / task.a_max
        down = (task.v1 - peak) * (task.v1 + peak) * 0.5 / task.a_min
        scale = max(abs(peak), abs(task.v0), abs(task.v1))
        return up + down, scale * self._timed(peak).duration

    def solutions(self) -> Iterator[Profile]:
        """Yield every profile that covers the task's distance, the shortest first."""
        task, least = self.task, self.least
        if least > task.v_max:
            return
        nearest, scale = self.travel(least)
        missing = task.distance - nearest
        if abs(missing) <= self.blur + ROUNDING * scale:
            yield self._timed(least)
            missing = 0.0
        # w² − least² = missing / lift, so that a small rise of a fast motion keeps its digits
        lift = 0.5 / task.a_max - 0.5 / task.a_min
        if not lift:
            raise OverflowError
        gain = missing / lift
        square = least * least + gain
        if abs(square) <= ROUNDING * least * least:
            square = 0.0
        if square >= 0.0:
            for peak in (-sqrt(square), sqrt(square)):
                if peak * least > 0.0:
                    peak = least + gain / (peak + least)
                if least < peak <= task.v_max:
                    yield self._timed(peak)
        yield from self._cruising()

    def _cruising(self) -> Iterator[Profile]:
        task = self.task
        if task.v_max == inf:
            return
        rest = task.distance - self.travel(task.v_max)[0]
        if task.v_max > 0.0 and rest >= 0.0:
            yield self._timed(task.v_max, rest / task.v_max)

    def lasting(self, duration: float) -> Profile | None:
        """Return the member of a given duration, None where the family has none."""
        task = self.task
        shortest = self._timed(self.least).duration
        if duration < shortest * (1.0 - ROUNDING):
            return None
        more = max(duration - shortest, 0.0)
        peak = self.least + more / (1.0 / task.a_max - 1.0 / task.a_min)
        if peak <= task.v_max:
            return Profile(duration, peak, 0.0)
        fastest = self._timed(task.v_max)
        return Profile(duration, task.v_max, max(duration - fastest.duration, 0.0))

    def limits_of_duration(self) -> Iterator[float]:
        """Yield the durations at which the family begins or ends."""
        yield self._timed(self.least).duration

    def pieces(self, profile: Profile, start: float, end: float) -> list[Piece]:
        """Return the pieces of a profile from position `start` to position `end`."""
        task, w = self.task, profile.peak
        up, down = (w - task.v0) / task.a_max, (task.v1 - w) / task.a_min
        top = start + 0.5 * (task.v0 + w) * up
        return [
            (up, (start, task.v0, task.a_max)),
            (profile.cruise, (top, w, 0.0)),
            (down, (end - 0.5 * (w + task.v1) * down, w, task.a_min)),
        ]

    def distance(self, profile: Profile) -> float:
        """Return the distance covered."""
        return self.travel(profile.peak)[0] + profile.peak * profile.cruise
