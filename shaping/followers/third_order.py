"""Following with bounded jerk: a minimum-time motion, planned anew when the command changes.

Seen from the command, which moves at its own constant velocity, the motion is one to rest at
zero. The plan is kept as long as the commands stay on that course.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..pieces import FloatArray
from ..transfers.batch_tasks import inside
from ..transfers.task import Task
from .approach import courses, follow_course


def follow(
    start: tuple[float, float, float],
    commands: FloatArray,
    velocities: FloatArray,
    bounds: Task,
    dt: float,
    period: float | None = None,
) -> FloatArray:
    """Return position, velocity, acceleration and jerk (4, N) at the end of each sample.

    As `second_order.follow`; the bounds are those of a task. The jerk is the one in force when
    the sample ends.
    """
    state: tuple[float, ...] = start
    rows = np.empty((4, len(commands)))
    for i, j in pairwise(courses(commands, velocities, dt).tolist()):
        velocity = float(velocities[i])
        rows[:, i:j] = follow_course(state, commands[i:j], velocity, bounds, dt, period)
        state = tuple(rows[:3, j - 1].tolist())
    rows[1] = inside(rows[1], bounds.v_min, bounds.v_max)
    return rows
