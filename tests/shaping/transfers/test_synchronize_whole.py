"""Axes of order 4 and above, and within stops, that move at their ends: durations all can take."""

import numpy as np
import pytest
from sampled_motions import least_share

from jounce.shaping import InfeasibleError, Limits, min_time_transfer, synchronize

FOURTH = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, snap=40.0)
STOPS = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, position=(-0.5, 1.6))
PASSING = ((0.0, 0.9), (1.0, 0.9), FOURTH)
"""It takes 1.04 to 1.40 if it passes at once, and 2.90 or more if it turns back first."""


def assert_soonest(problems):
    """Check the motions; by linear programs, that for shorter durations some axis has none."""
    axes = synchronize(problems)
    own = max(min_time_transfer(*problem).duration for problem in problems)
    for axis, (start, end, limits) in zip(axes, problems, strict=True):
        n = limits.order
        assert axis.duration == pytest.approx(axes.duration, rel=1e-13)
        assert axis.violation(limits) <= 1e-9
        for state, given in ((axis.start_state, start), (axis.end_state, end)):
            np.testing.assert_allclose(state[:n], [*np.atleast_1d(given), *[0.0] * n][:n])
    if axes.duration > own * 1.001:
        for tried in np.linspace(own, 0.99 * axes.duration, 4).tolist():
            assert any(least_share(*problem, tried, 80) > 1.0 for problem in problems)
    return axes.duration, own


@pytest.mark.parametrize("distance", [0.3, 0.5, 1.5])
def test_a_slow_axis_in_the_blocked_interval_of_another(distance):
    duration, own = assert_soonest([PASSING, (0.0, distance, FOURTH)])
    blocked = 1.41 < own < 2.9
    assert duration == pytest.approx(2.9 if blocked else own, rel=2e-4)


def test_two_axes_of_different_blocked_intervals():
    other = ((0.0, 0.7), (1.3, 0.7, 0.1), Limits(1.0, (-0.8, 1.2), 4.0, (-30.0, 50.0)))
    duration, own = assert_soonest([PASSING, other])
    assert duration > 1.5 * own


def test_axes_within_stops_of_order_3_are_tied_as_well():
    duration, own = assert_soonest([((0.0, 0.8), (0.8, 0.8), STOPS), (0.0, 0.5, FOURTH)])
    assert duration > 1.2 * own


def test_both_may_wait_at_rest_within_stops():
    still, moving = synchronize([(0.0, 0.1, STOPS), (0.0, 1.5, STOPS)])
    assert still.duration == moving.duration == min_time_transfer(0.0, 1.5, STOPS).duration
    assert still.violation(STOPS) <= 1e-12


def test_on_a_line_bounds_on_position_are_refused():
    with pytest.raises(ValueError, match="have a bound on position: only min_time"):
        synchronize([(0.0, 1.0, STOPS), (0.0, 0.5, STOPS)], "straight-line")


def test_an_axis_without_any_motion_is_named():
    with pytest.raises(InfeasibleError, match=r"axis 1: no motion within the limits") as error:
        synchronize([(0.0, 1.0, STOPS), ((1.5, 0.9), 0.0, STOPS)])
    assert error.value.bound == "position"
    assert error.value.time > 0.0


@pytest.mark.parametrize("dt", [0.05, 0.8])
def test_a_whole_number_of_samples_jumps_a_blocked_interval(dt):
    transfer = min_time_transfer(*PASSING, round_to=dt)
    count = round(transfer.duration / dt)
    assert transfer.duration == count * dt
    assert transfer.violation(FOURTH) == 0.0
    shorter = [i * dt for i in range(1, count) if i * dt > 1.0]
    assert all(least_share(*PASSING, tried, 80) > 1.0 for tried in shorter)


def test_many_samples_of_a_long_blocked_interval_are_jumped_at_once():
    """It passes in 1, or comes back after 19: it cannot stop in time."""
    limits = Limits(velocity=1.0, acceleration=0.2, jerk=4.0, snap=40.0)
    lower = Limits(velocity=1.0, acceleration=0.2)
    start, end = (0.0, 1.0), (1.0, 1.0)
    assert min_time_transfer(start, end, limits).duration == pytest.approx(1.0, rel=1e-4)
    rounded = min_time_transfer(start, end, limits, round_to=0.08).duration
    least = min_time_transfer(start, end, lower, round_to=0.08).duration
    assert least <= rounded <= least + 0.24
    assert rounded / 0.08 == pytest.approx(round(rounded / 0.08), rel=1e-14)
