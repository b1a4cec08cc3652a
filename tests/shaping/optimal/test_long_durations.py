"""Durations far above the least, and of motions long against their ramps: exact and gentle."""

from math import factorial

import numpy as np
import pytest
from sampled_motions import least_share
from tiers import some

from jounce.shaping import InfeasibleError, Limits, min_time_move, min_time_transfer

LIMITS = Limits(velocity=(-2.0, 1.0), acceleration=(-10.0, 1.0), jerk=100.0, snap=1e4)
STAGE = Limits(
    velocity=2.0,
    acceleration=(-4.0, 1.0),
    jerk=20.0,
    snap=(-300.0, 200.0),
    position=(-0.2, 1.1),
)
SYMMETRIC = Limits(velocity=2.0, acceleration=4.0, jerk=20.0, snap=200.0)
MOVING = (0.0, 0.3, 0.1), (1.0, -0.2, 0.0)


def share(motion, limits):
    (low, high), (least, most) = motion.extremes(limits.order), limits.bounds(limits.order)
    return max(high / most, low / least)


def assert_exact(motion, end, limits, duration):
    assert motion.duration == pytest.approx(duration, rel=1e-13)
    assert motion.violation(limits) <= 1e-12
    np.testing.assert_allclose(motion.end_state[: len(end)], end, rtol=1e-13, atol=1e-13)
    assert_joined(motion, limits)


def assert_joined(motion, limits):
    """Each piece ends in position and velocity where the next one begins."""
    ends = [
        [sum(row[k + i] * d**i / factorial(i) for i in range(len(row) - k)) for k in range(2)]
        for row, d in zip(motion.states, motion.durations, strict=True)
    ]
    begins = [*motion.states[1:, :2], motion.end_state[:2]]
    np.testing.assert_allclose(ends, begins, rtol=1e-9, atol=1e-9 * limits.bounds(1)[1])


@pytest.mark.parametrize("duration", some([8.0, 100.0, 1e4, 1e7], 1))
def test_a_stage_in_motion_rests_for_as_long_as_it_may(duration):
    start, end = MOVING
    motion = min_time_transfer(start, end, STAGE, duration=duration)
    assert_exact(motion, end, STAGE, duration)
    assert share(motion, STAGE) <= 1.02 * least_share(start, end, STAGE, 8.0)


def test_a_motion_that_is_free_to_go_anywhere_is_ever_gentler():
    free = Limits(velocity=2.0, acceleration=(-4.0, 1.0), jerk=20.0, snap=(-300.0, 200.0))
    start, end = MOVING
    for duration in (8.0, 32.0):
        motion = min_time_transfer(start, end, free, duration=duration)
        assert share(motion, free) <= 1.01 * least_share(start, end, free, duration)


@pytest.mark.slow
@pytest.mark.parametrize("distance", some([300.0, 1e8, -1e4], 1))
@pytest.mark.parametrize("factor", some([1.05, 2.0], 1))
def test_a_long_move_is_as_slow_as_asked_and_gentle(distance, factor):
    duration = factor * min_time_move(distance, LIMITS).duration
    move = min_time_move(distance, LIMITS, start=3.0, duration=duration)
    assert_exact(move, (distance + 3.0, 0.0, 0.0, 0.0), LIMITS, duration)
    assert share(move, LIMITS) < factor**-4.0


@pytest.mark.slow
@pytest.mark.parametrize("factor", some([1.0 + 1e-9, 1.01, 1.5, 50.0], 1))
@pytest.mark.parametrize("way", some([1.0, -1.0], 1))
def test_a_long_transfer_cruises_slower_and_is_exact(factor, way):
    start, end = (0.0, 0.1, 0.0, 0.0), (way * 1e3, 0.2, -0.1, 0.0)
    duration = factor * min_time_transfer(start, end, LIMITS).duration
    motion = min_time_transfer(start, end, LIMITS, duration=duration)
    assert_exact(motion, end, LIMITS, duration)
    if factor > 1.1:
        assert share(motion, LIMITS) < 0.1


def test_what_is_shorter_is_proven_impossible():
    for start in (0.0, (0.0, 0.1)):
        with pytest.raises(InfeasibleError, match=r"every one below 1000\.\d+ is proven"):
            min_time_transfer(start, 1e3, LIMITS, duration=1000.3)


@pytest.mark.slow
def test_a_long_move_takes_whole_samples():
    rounded = min_time_move(1e3, LIMITS, round_to=0.25)
    assert rounded.duration == 1000.75
    assert rounded.violation(LIMITS) <= 1e-12


def test_a_move_slowed_down_lasts_and_ends_to_the_last_bit():
    averaged = {"limits": LIMITS, "method": "closed-form"}
    for dt in (0.1, 0.3, 0.7):
        move = min_time_move(13.0, round_to=dt, **averaged)
        assert move.duration == round(move.duration / dt) * dt
    begin, end = 0.7, 0.123456789
    motion = min_time_transfer(begin, end, SYMMETRIC)
    assert motion.end_state.tolist() == [end, 0.0, 0.0, 0.0, 0.0]


def test_who_stands_can_stand_longer():
    for limits in (LIMITS, STAGE, Limits(velocity=1.0, acceleration=1.0)):
        still = min_time_transfer(1, 1, limits, duration=3.0)
        assert (still.duration, still.peak(1), float(still(1.5))) == (3.0, 0.0, 1.0)
        assert min_time_transfer(1, 1, limits, round_to=0.5).duration == 0.0
    both = min_time_transfer(1.0, 1.0, STAGE, duration=1.1, round_to=0.25)
    assert both.duration == 1.25
