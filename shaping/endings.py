"""Motions whose end, in state and time, is as asked for to the last bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .trajectory import Trajectory


def ended(motion: Trajectory, state: Sequence[float]) -> Trajectory:
    """Return a motion that ends in a state, position first: it missed that by rounding."""
    end = motion.end_state.copy()
    end[: len(state)] = state
    return Trajectory.from_arrays(
        motion.breaks, motion.states, motion.durations, end, motion.coasting
    )


def slowed_to(motion: Trajectory, duration: float) -> Trajectory:
    """Return a motion from time 0 on, slowed down as a whole to last a duration."""
    slower = motion.stretch(duration / motion.duration)
    breaks = np.minimum(slower.breaks, duration)
    breaks[-1] = duration
    return Trajectory.from_arrays(
        breaks, slower.states, slower.durations, slower.end_state, slower.coasting
    )
