"""min_time_transfers where linear programs plan: as one by one, in whatever shape."""

import pickle
from math import isnan

import numpy as np
import pytest

from jounce.shaping import InfeasibleError, Limits, min_time_transfer, min_time_transfers

FOURTH = Limits(velocity=1.0, acceleration=(-4.0, 1.0), jerk=10.0, snap=100.0)
STOPS = Limits(velocity=1.0, acceleration=1.0, jerk=5.0, position=(-0.1, 2.0))


@pytest.mark.parametrize("limits", [FOURTH, STOPS])
def test_they_are_those_planned_one_by_one(limits):
    starts, ends = [[0.0, 0.2], [0.0, -1.0], [1.0, 0.0]], [1.0]
    batch = min_time_transfers(starts, ends, limits)
    assert batch.shape == (3,)
    assert isnan(batch.duration[1]) == isnan(batch.inside_after[1]) == (limits is STOPS)
    for i, start in enumerate(starts):
        if not batch.feasible[i]:
            with pytest.raises(InfeasibleError, match="no motion"):
                batch[i]
            continue
        alone = min_time_transfer(start, ends, limits)
        assert batch.duration[i] == alone.duration
        np.testing.assert_array_equal(batch[i].states, alone.states)
        times = np.linspace(0.0, alone.duration, 7)
        np.testing.assert_allclose(batch(times, 1)[i], alone(times, 1), rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(batch.end_state[i], alone.end_state)
        assert batch.peak(1)[i] == pytest.approx(alone.peak(1), rel=1e-12)


def test_arrays_of_bounds_and_of_states_broadcast():
    bounds = Limits(velocity=np.array([1.0, 0.5]), acceleration=2.0, jerk=10.0, snap=100.0)
    grid = min_time_transfers([[[0.0]], [[0.1]]], [1.0], bounds)
    assert grid.shape == (2, 2)
    slow = Limits(velocity=0.5, acceleration=2.0, jerk=10.0, snap=100.0)
    assert grid.duration[1, 1] == min_time_transfer(0.1, 1.0, slow).duration
    assert grid[1].duration.tolist() == grid.duration[1].tolist()
    assert grid[:, 1][0].limits == slow
    assert pickle.loads(pickle.dumps(grid)).duration.tolist() == grid.duration.tolist()
    assert grid.pieces().durations.shape[:2] == (2, 2)
    assert min_time_transfers(np.empty((0, 4)), [1.0], FOURTH).shape == (0,)
