"""A linear loop behind a jerk filter, as one system."""

from __future__ import annotations

import numpy as np

from ..shaping import JerkFilter, Trajectory
from ..shaping.pieces import FloatArray
from .models import StateModel


def filter_outputs(jerk_filter: JerkFilter, trajectory: Trajectory) -> FloatArray:
    """Return the matrix from the lags of a filter's copies to r, r_rate, r_acceleration.

    There is a copy for each derivative of the trajectory that is free of impulses, up to the
    acceleration; what is missing is the derivative of the last copy's output.
    """
    m = jerk_filter.order
    direct = min(2, trajectory.lowest_jump())
    if m <= 2 - direct:
        raise ValueError(
            f"a jerk filter of order {m} behind a trajectory whose derivative {direct} jumps has "
            f"no finite acceleration: use order {3 - direct} or more, or bound the acceleration"
        )
    outputs = np.zeros((3, (direct + 1) * m))
    for i in range(3):
        copy = min(i, direct)
        outputs[i, copy * m : (copy + 1) * m] = jerk_filter.derivative_weights(i - copy)[1:]
    return outputs


def behind_filter(
    loop: StateModel, jerk_filter: JerkFilter, trajectory: Trajectory, outputs: FloatArray
) -> tuple[StateModel, int, FloatArray]:
    """Return the loop behind the filter's copies, how many there are, and the initial state."""
    a, b = jerk_filter.state_space()
    lags, n = outputs.shape[1], loop.nstates
    copies = lags // jerk_filter.order
    full = np.zeros((lags + n, lags + n))
    full[:lags, :lags] = np.kron(np.eye(copies), a)
    full[lags:, :lags] = loop.B @ outputs
    full[lags:, lags:] = loop.A
    drive = np.vstack([np.kron(np.eye(copies), b), np.zeros((n, copies))])
    out = np.hstack([loop.D @ outputs, loop.C])
    start = [jerk_filter.steady_state(trajectory, k) for k in range(copies)]
    initial = np.concatenate([*start, np.zeros(n)])
    return StateModel(full, drive, out, np.zeros((len(out), copies))), copies, initial
