"""The fastest change of velocity and acceleration, wherever it ends."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

from .jerk_profile import ramp
from .task import ROUNDING, Piece, Task


class Change(NamedTuple):
    """Accelerations reached by constant jerk, and in between held: a0 → peak, hold, peak → a1."""

    task: Task
    duration: float
    distance: float
    peak: float
    hold: float
    jerk: float
    """Of the way to the peak; zero for order 2."""
    back: float
    """Jerk of the way from the peak."""

    def mirror(self) -> Change:
        """Return the same change in the opposite direction."""
        task, time, distance, peak, hold, jerk, back = self
        return Change(task.mirror(), time, -distance, -peak, hold, -jerk, -back)

    def leaves_bounds(self) -> bool:
        """Tell whether the velocity passes its bound where the acceleration crosses zero."""
        task = self.task
        if self.peak * task.a1 >= 0.0:
            return False
        turn = task.v1 - 0.5 * task.a1 * task.a1 / self.back
        slack = ROUNDING * (abs(turn) + abs(task.v1))
        return not task.v_min - slack <= turn <= task.v_max + slack

    def pieces(self, start: float) -> list[Piece]:
        """Return the pieces of the change from position `start`."""
        task = self.task
        if task.rise == inf:
            return [(self.hold, (start, task.v0, self.peak))]
        step, v = ramp(task.v0, task.a0, self.peak, self.jerk)
        x = start + step
        first = ((self.peak - task.a0) / self.jerk, (start, task.v0, task.a0, self.jerk))
        held = (self.hold, (x, v, self.peak, 0.0))
        x += (v + 0.5 * self.peak * self.hold) * self.hold
        v += self.peak * self.hold
        return [first, held, ((task.a1 - self.peak) / self.back, (x, v, self.peak, self.back))]


def change_velocity(task: Task) -> Change:
    """Return the fastest change from (v0, a0) to (v1, a1); the task's distance plays no part.

    With jerk r to the peak and −f from it, κ·p² = v1 − v0 + a0²/(2r) + a1²/(2f), κ as in
    `third_order`; a hold replaces what p lacks where it is bounded. Between accelerations of one
    sign a straight ramp can be much shorter than any way round.
    """
    gain = task.v1 - task.v0
    if task.rise == inf:
        peak = task.a_max if gain >= 0.0 else task.a_min
        hold = gain / peak
        return Change(task, hold, 0.5 * (task.v0 + task.v1) * hold, peak, hold, 0.0, 0.0)
    a0, a1 = task.a0, task.a1
    jerk, back = (task.rise, -task.fall) if a1 >= a0 else (-task.fall, task.rise)
    straight = 0.5 * (a1 - a0) * (a1 + a0) / jerk
    squares = (a0 * a0 + a1 * a1) / min(task.rise, task.fall)
    if abs(gain - straight) <= ROUNDING * (abs(task.v0) + abs(task.v1) + squares):
        duration = (a1 - a0) / jerk
        return Change(task, duration, ramp(task.v0, a0, a1, jerk)[0], a1, 0.0, jerk, back)
    if gain > straight:
        return _by_rising(task)
    return _by_rising(task.mirror()).mirror()


def _by_rising(task: Task) -> Change:
    """Return the change whose acceleration first rises."""
    rise, fall, a0, a1 = task.rise, task.fall, task.a0, task.a1
    kappa = 0.5 / rise + 0.5 / fall
    square = (task.v1 - task.v0 + 0.5 * a0 * a0 / rise + 0.5 * a1 * a1 / fall) / kappa
    peak, hold = max(sqrt(max(square, 0.0)), a0, a1), 0.0
    if peak > task.a_max >= max(a0, a1):
        hold = kappa * (square - task.a_max**2) / task.a_max
        peak = task.a_max
    distance, v = ramp(task.v0, a0, peak, rise)
    distance += (v + 0.5 * peak * hold) * hold
    distance += ramp(v + peak * hold, peak, a1, -fall)[0]
    duration = (peak - a0) / rise + hold + (peak - a1) / fall
    return Change(task, duration, distance, peak, hold, rise, -fall)
