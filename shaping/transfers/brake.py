"""Bringing a state outside its bounds, or bound to leave them, inside as fast as possible."""

from __future__ import annotations

from math import inf, sqrt

from .task import ROUNDING, Piece, Task

Steps = list[tuple[float, float]]
"""Durations and jerks (accelerations for order 2)."""


def inside(value: float, low: float, high: float) -> float:
    """Return a value with an excess over its bounds that is mere rounding cut off."""
    if high < value <= high + ROUNDING * abs(high):
        return high
    if low > value >= low - ROUNDING * abs(low):
        return low
    return value


def brake(task: Task, start: float) -> tuple[list[Piece], Task, float]:
    """Bring (v0, a0) to where its bounds can be kept for good.

    With bounded jerk that is where besides the bounds themselves

        v + a²/(2·fall) ≤ v_max for a > 0,    v − a²/(2·rise) ≥ v_min for a < 0.

    Returns
    -------
    pieces : list
        How to get there from position `start`; none where the state is there already.
    task : Task
        What is left to do.
    position : float
        Where it begins.
    """
    v, a = inside(task.v0, task.v_min, task.v_max), inside(task.a0, task.a_min, task.a_max)
    if task.rise == inf:
        kept = min(max(v, task.v_min), task.v_max)
        change = task.a_max if kept > v else task.a_min
        steps = [((kept - v) / change, change)]
        return _run(task, steps, start, kept, 0.0)
    steps = []
    kept = min(max(a, task.a_min), task.a_max)
    if kept != a:
        jerk = task.rise if kept > a else -task.fall
        time = (kept - a) / jerk
        steps.append((time, jerk))
        v, a = v + 0.5 * (a + kept) * time, kept
    slack = ROUNDING * (abs(v) + 0.5 * a * a / min(task.rise, task.fall))
    rising_over = a > 0.0 and v + 0.5 * a * a / task.fall > task.v_max + slack
    falling_under = a < 0.0 and v - 0.5 * a * a / task.rise < task.v_min - slack
    at_hand = task._replace(v0=v, a0=a)
    if rising_over or (v > task.v_max and not falling_under):
        more, a = _slow(at_hand)
        steps, v = steps + more, task.v_max
    elif falling_under or v < task.v_min:
        more, a = _slow(at_hand.mirror())
        steps, v, a = steps + [(time, -jerk) for time, jerk in more], task.v_min, -a
    return _run(task, steps, start, v, a)


def _slow(task: Task) -> tuple[Steps, float]:
    """Return the way down to v_max, and the acceleration there.

    Fall, hold, and rise where v_min would be passed else. Falling, v = top − a²/(2·fall); the
    last rise follows v = v_min + a²/(2·rise).
    """
    rise, fall, v_max, a_min = task.rise, task.fall, task.v_max, task.a_min
    top = task.v0 + 0.5 * task.a0 * task.a0 / fall
    arrival = -sqrt(2.0 * fall * max(top - v_max, 0.0))
    gentlest = -sqrt(2.0 * rise * (v_max - task.v_min))  # arriving with more passes v_min
    if arrival >= max(a_min, gentlest):
        return [((task.a0 - arrival) / fall, -fall)], arrival
    if a_min >= gentlest:
        velocity = top - 0.5 * a_min * a_min / fall
        return [((task.a0 - a_min) / fall, -fall), ((v_max - velocity) / a_min, 0.0)], a_min
    lowest = min(-sqrt((top - task.v_min) / (0.5 / rise + 0.5 / fall)), task.a0)
    steps = [((task.a0 - max(lowest, a_min)) / fall, -fall)]
    if lowest < a_min:
        gap = top - 0.5 * a_min * a_min / fall - (task.v_min + 0.5 * a_min * a_min / rise)
        steps.append((-gap / a_min, 0.0))
        lowest = a_min
    return [*steps, ((gentlest - lowest) / rise, rise)], gentlest


def _run(
    task: Task, steps: Steps, start: float, v_end: float, a_end: float
) -> tuple[list[Piece], Task, float]:
    """Return the pieces of the steps, the task left at the state they end in, and the position."""
    x, v, a = start, task.v0, task.a0
    pieces: list[Piece] = []
    for time, value in steps:
        if time <= 0.0:
            continue
        if task.rise == inf:
            pieces.append((time, (x, v, value)))
            x, v = x + (v + 0.5 * value * time) * time, v + value * time
        else:
            pieces.append((time, (x, v, a, value)))
            x += (v + (0.5 * a + value * time / 6.0) * time) * time
            v, a = v + (a + 0.5 * value * time) * time, a + value * time
    left = task._replace(v0=v_end, a0=a_end, distance=task.distance - (x - start))
    return pieces, left, x
