"""Many transfers of order 2 at once: the formulas of `second_order` on arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..pieces import FloatArray
from .batch_tasks import Mask, Profiles, Tasks, mirror_where
from .second_order import Profile
from .task import ROUNDING

_profile: Any = Profile  # of arrays


def fastest(tasks: Tasks) -> tuple[Tasks, Profiles, Mask]:
    """Return the tasks, some of them mirrored, their shortest profiles, and which are mirrored.

    The quickest change from v0 to v1 covers a distance d. From there on the distance that can be
    covered grows continuously either way, so that the sign of what is missing tells the
    family; in it the higher of the two peaks is the one that lies beyond both velocities.
    """
    straight = tasks.v1 - tasks.v0
    straight = straight / np.where(straight >= 0.0, tasks.a_max, tasks.a_min)
    missing = tasks.distance - 0.5 * (tasks.v0 + tasks.v1) * straight
    falls = missing < 0.0
    tasks = mirror_where(falls, tasks)
    v0, v1, up, down, top = tasks.v0, tasks.v1, tasks.a_max, -tasks.a_min, tasks.v_max
    missing, least = np.abs(missing), np.maximum(v0, v1)
    speed = np.maximum(np.abs(v0), np.abs(v1))
    slack = np.abs(tasks.distance) + speed * (speed / np.minimum(up, down) + straight)
    missing = np.where(missing <= tasks.resolution + ROUNDING * slack, 0.0, missing)
    gain = missing / (0.5 / up + 0.5 / down)
    root = np.sqrt(least * least + gain)
    # of a small rise of a fast motion, more digits
    peak = np.where(least > 0.0, least + gain / (root + least), np.where(gain > 0.0, root, least))
    cruises = peak > top
    peak = np.minimum(peak, top)
    rise, fall = (peak - v0) / up, (peak - v1) / down
    rest = tasks.distance - 0.5 * ((v0 + peak) * rise + (v1 + peak) * fall)
    cruise = np.where(cruises, np.maximum(rest, 0.0) / top, 0.0)
    return tasks, _profile(rise + cruise + fall, peak, cruise), falls


def pieces(tasks: Tasks, profiles: Profiles) -> tuple[FloatArray, FloatArray]:
    """Return durations (3, N) and states (3, 3, N) of the pieces, positions from the start on."""
    w, v0, v1 = profiles.peak, tasks.v0, tasks.v1
    up, down = (w - v0) / tasks.a_max, (v1 - w) / tasks.a_min
    nothing = np.zeros_like(w)
    top = 0.5 * (v0 + w) * up
    durations = np.array([np.maximum(up, 0.0), profiles.cruise, np.maximum(down, 0.0)])
    states = np.array(
        [
            [nothing, v0, tasks.a_max + nothing],
            [top, w, nothing],
            [tasks.distance - 0.5 * (w + v1) * down, w, tasks.a_min + nothing],
        ]
    )
    return durations, states
