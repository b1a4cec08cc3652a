"""A motion averaged over the time before: one order more, within the same bounds."""

from __future__ import annotations

import numpy as np

from .checks import positive
from .pieces import FloatArray
from .trajectory import Motion, Trajectory, as_trajectory, sum_of, within_range


def averaged(motion: Motion, window: float) -> Trajectory:
    """Return the mean of a motion over the last `window` seconds, exact.

        x̄(t) = 1/T·∫_{t − T}^t x(s) ds,   x̄^(k)(t) = (x^(k−1)(t) − x^(k−1)(t − T))/T

    All bounds that the motion keeps it keeps, and its derivative n + 1 is bounded, too, by the span
    of derivative n over T. It lags by T/2 where the velocity is constant, and ends T later.

    Parameters
    ----------
    motion : Trajectory or what has one
        Of order n, coasting outside.
    window : float
        T, from 1e-9 to 1e9 of the motion's duration.

    Raises
    ------
    ValueError
        For another window.

    Examples
    --------
    >>> from jounce.shaping import Limits, min_time_move
    >>> smooth = averaged(min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0)), 0.5)
    >>> smooth.order, smooth.duration, smooth.peak("acceleration"), smooth.peak("jerk")
    (3, 2.0, 2.0, 4.0)
    """
    given, window = as_trajectory(motion, "motion"), positive("window", window)
    length = given.duration
    if length and not 1e-9 <= window / length <= 1e9:
        raise ValueError(
            f"window = {window!r}: expected 1e-9 to 1e9 times the motion's duration, {length!r}"
        )
    return within_range(lambda: _averaged(given, window))


def _averaged(motion: Trajectory, window: float) -> Trajectory:
    position, velocity = motion.coasting_in()
    moved = motion.shift(-position)
    rate = sum_of([moved, moved.delay(window)], [1.0 / window, -1.0 / window])
    passed = np.append(0.0, np.cumsum(_distances(rate)))
    start = position - 0.5 * velocity * window
    end = np.append(start + passed[-1], rate.end_state)
    states = np.hstack([start + passed[:-1, None], rate.states])
    return Trajectory(rate.breaks, states, rate.durations, end)


def _distances(rate: Trajectory) -> FloatArray:
    """Return the integral of a rate over each of its pieces."""
    term, total = rate.durations, np.zeros(len(rate.durations))
    for k, column in enumerate(rate.states.T):
        total = total + term * column
        term = term * rate.durations / (k + 2.0)
    return total
