"""Sampling of responses: fine while fast modes live, coarse in a slow tail."""

import numpy as np
import pytest

from jounce.analysis.sampling import Clock, clock_for, followed, thinned


def exponentials(dt, duration):
    time = dt * np.arange(int(duration / dt) + 1)
    return time, np.array([np.exp(-time), np.exp(-1e-3 * time)])


def test_a_slow_mode_is_followed_to_its_end_without_losing_the_fast_one():
    clock = clock_for(np.array([-1.0, -1e-3]), np.log(1e4))
    time, values = followed(exponentials, clock)
    assert np.all(np.diff(time) > 0)
    assert time[1] <= 0.01
    assert time[-1] == pytest.approx(1e3 * np.log(1e4), rel=1e-2)
    assert len(time) < 10_000
    np.testing.assert_array_equal(values, np.array([np.exp(-time), np.exp(-1e-3 * time)]))


def test_without_a_slow_mode_the_grid_is_uniform():
    clock = clock_for(np.array([-1.0 + 2.0j, -1.0 - 2.0j]), 5.0, lead=3.0)
    assert clock.horizon == clock.fast == pytest.approx(8.0)
    time, _ = followed(exponentials, clock)
    np.testing.assert_allclose(np.diff(time), clock.step, rtol=1e-9)


def test_the_quickest_input_sets_the_step_and_samples_are_bounded():
    poles = np.array([-1.0])
    assert clock_for(poles, 5.0, quickest=0.1).step == pytest.approx(0.001)
    long = clock_for(poles, 5.0, lead=1e9)
    assert long.fast / long.step <= 1e6 * (1 + 1e-12)


@pytest.mark.parametrize("most", [1, 3, 10, 100])
def test_thinned_keeps_the_first_and_at_most_so_many(most):
    time = np.arange(37.0)
    kept, rows = thinned((time, np.vstack([time, -time])), most)
    assert 1 <= kept.size <= most
    assert kept[0] == 0.0
    np.testing.assert_array_equal(rows, [kept, -kept])
    assert isinstance(clock_for(np.array([-1.0]), 1.0), Clock)
