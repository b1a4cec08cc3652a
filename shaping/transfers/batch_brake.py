"""Bringing many starts inside their bounds at once: the formulas of `brake` on arrays."""

from __future__ import annotations

import numpy as np

from ..pieces import FloatArray
from .batch_tasks import Mask, Tasks, mirror_where
from .task import ROUNDING


def outside(tasks: Tasks) -> Mask:
    """Tell which starts cannot keep their bounds."""
    rising, falling = _bound_to_leave(tasks)
    v, a = tasks.v0, tasks.a0
    beyond = (v > tasks.v_max) | (v < tasks.v_min) | (a > tasks.a_max) | (a < tasks.a_min)
    return np.asarray(rising | falling | beyond)


def _bound_to_leave(tasks: Tasks) -> tuple[Mask, Mask]:
    v, a, rise, fall = tasks.v0, tasks.a0, tasks.rise, tasks.fall
    slack = ROUNDING * (np.abs(v) + 0.5 * a * a / np.minimum(rise, fall))
    rising = v + 0.5 * np.maximum(a, 0.0) ** 2 / fall > tasks.v_max + slack
    falling = v - 0.5 * np.minimum(a, 0.0) ** 2 / rise < tasks.v_min - slack
    return rising & (a > 0.0), falling & (a < 0.0)


def brake(tasks: Tasks) -> tuple[FloatArray, FloatArray, Tasks]:
    """Return durations (m, N) and states (m, order + 1, N) of the way inside, and what is left.

    m = 1 for order 2, else 4: acceleration into its bounds, fall, hold, rise.
    """
    if np.isinf(tasks.rise).all():
        kept = np.clip(tasks.v0, tasks.v_min, tasks.v_max)
        change = np.where(kept > tasks.v0, tasks.a_max, tasks.a_min)
        return _run(tasks, ((kept - tasks.v0) / change)[None], change[None], kept, tasks.a0)
    kept = np.clip(tasks.a0, tasks.a_min, tasks.a_max)
    jerk = np.where(kept > tasks.a0, tasks.rise, -tasks.fall)
    time = (kept - tasks.a0) / jerk
    v = tasks.v0 + 0.5 * (tasks.a0 + kept) * time
    at_hand = tasks._replace(v0=v, a0=kept)
    rising, falling = _bound_to_leave(at_hand)
    slows = rising | ((v > tasks.v_max) & ~falling)
    raises = ~slows & (falling | (v < tasks.v_min))
    sign = np.where(raises, -1.0, 1.0)
    ahead = mirror_where(raises, at_hand)
    steps, jerks, arrival = _slow(ahead)
    moves = slows | raises
    times = np.array([time, *np.where(moves, steps, 0.0)])
    values = np.array([jerk, *(jerks * sign)])
    v_end = np.where(moves, sign * ahead.v_max, v)
    return _run(tasks, times, values, v_end, np.where(moves, sign * arrival, kept))


def _slow(tasks: Tasks) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return durations and jerks (3, N) of the way down to v_max, and the acceleration there."""
    rise, fall, v_max, a_min = tasks.rise, tasks.fall, tasks.v_max, tasks.a_min
    top = tasks.v0 + 0.5 * tasks.a0 * tasks.a0 / fall
    straight = -np.sqrt(2.0 * fall * np.maximum(top - v_max, 0.0))
    gentlest = -np.sqrt(2.0 * rise * (v_max - tasks.v_min))
    turning = np.minimum(-np.sqrt((top - tasks.v_min) / (0.5 / rise + 0.5 / fall)), tasks.a0)
    direct, held = straight >= np.maximum(a_min, gentlest), a_min >= gentlest
    arrival = np.where(direct, straight, np.where(held, a_min, gentlest))
    lowest = np.where(direct, straight, np.where(held, a_min, np.maximum(turning, a_min)))
    # the velocity at which holding ends: at the bound, or where the rise has to begin
    ends = np.where(held, v_max, tasks.v_min + 0.5 * a_min * a_min / rise)
    holding = ~direct & (held | (turning < a_min))
    hold = np.where(holding, (ends - top + 0.5 * a_min * a_min / fall) / a_min, 0.0)
    times = [(tasks.a0 - lowest) / fall, hold, (arrival - lowest) / rise]
    return np.array(times), np.array([-fall, np.zeros_like(fall), rise]), arrival


def _run(
    tasks: Tasks, times: FloatArray, values: FloatArray, v_end: FloatArray, a_end: FloatArray
) -> tuple[FloatArray, FloatArray, Tasks]:
    times = np.maximum(times, 0.0)
    x, v, a = np.zeros_like(tasks.v0), tasks.v0, tasks.a0
    states = []
    for time, value in zip(times, values, strict=True):
        if np.isinf(tasks.rise).all():
            states.append([x, v, value])
            x, v = x + (v + 0.5 * value * time) * time, v + value * time
        else:
            states.append([x, v, a, value])
            x = x + (v + (0.5 * a + value * time / 6.0) * time) * time
            v, a = v + (a + 0.5 * value * time) * time, a + value * time
    left = tasks._replace(v0=v_end, a0=a_end, distance=tasks.distance - x)
    return times, np.array(states), left
