"""Motions changed under way: what was, up to a time, and what follows it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from ..trajectory import Motion, Trajectory
from .s_curve_rates import Piece


def before(motion: Motion, time: float) -> Trajectory:
    """Return a motion up to a time; a point in its way to the start where it has not begun."""
    if time >= motion.start_time:
        return motion.until(time)
    x, v = motion.coasting_in()
    end = np.zeros(motion.order + 1)
    end[0], end[1] = x + v * (time - motion.start_time), v
    return Trajectory([time], np.empty((0, len(end))), end_state=end)


def spliced(first: Motion, second: Motion) -> Trajectory:
    """Return one motion and, when it ends, another that begins at time 0 and where it ends.

    The highest derivative below the order may step, as by jerk percent.
    """
    breaks = first.end_time + second.breaks
    more = max(first.order, second.order) - np.array([first.order, second.order])
    early, late = (
        np.pad(motion.states, ((0, 0), (0, int(zeros))))
        for motion, zeros in zip((first, second), more, strict=True)
    )
    return Trajectory.from_arrays(
        np.append(first.breaks, breaks[1:]),
        np.vstack([early, late]),
        np.append(first.durations, second.durations),
        np.pad(second.end_state, (0, int(more[1]))),
    )


def of_pieces(pieces: Sequence[Piece], end: Sequence[float]) -> Trajectory:
    """Return the pieces of an S-curve, from time 0 on, to their end; OverflowError beyond range."""
    pieces = [piece for piece in pieces if piece[0] > 0.0]
    durations = np.array([duration for duration, _ in pieces])
    breaks = np.array([0.0, *accumulate(durations.tolist())])
    states = np.array([row for _, row in pieces]).reshape(len(pieces), 4)
    if not (np.isfinite(breaks).all() and np.isfinite(states).all()):
        raise OverflowError
    return Trajectory.from_arrays(breaks, states, durations, np.array([*end, 0.0, 0.0]))
