"""Moves and transfers of given duration, and of a whole number of samples."""

import numpy as np
import pytest
from sampled_motions import least_share
from tiers import some

from jounce.shaping import InfeasibleError, Limits, min_time_move, min_time_transfer

LIMITS = [
    Limits(velocity=2.0),
    Limits(acceleration=3.0),
    Limits(velocity=2.0, acceleration=3.0),
    Limits(velocity=(-1.0, 2.0), acceleration=(-5.0, 3.0)),
    Limits(jerk=20.0),
    Limits(velocity=2.0, acceleration=3.0, jerk=20.0),
    Limits(acceleration=(-2.0, 5.0), jerk=(-20.0, 9.0)),
    Limits(velocity=2.0, acceleration=3.0, jerk=20.0, snap=300.0),
]


@pytest.mark.parametrize("limits", LIMITS, ids=repr)
def test_a_duration_that_is_not_possible_is_told_in_one_way_at_every_order(limits):
    with pytest.raises(InfeasibleError, match=r"^duration = 1e-06 is "):
        min_time_move(1.0, limits, duration=1e-6)
    if limits.order > 1:
        with pytest.raises(InfeasibleError, match=r"^duration = 1e-06 is "):
            min_time_transfer((0.0, 0.5), 1.0, limits, duration=1e-6)


def assert_keeps(motion, limits, distance, duration):
    times = np.linspace(0.0, motion.duration, 4001)
    assert motion.duration == pytest.approx(duration, rel=1e-14)
    assert motion.end_state[0] - motion.start_state[0] == pytest.approx(distance, rel=1e-12)
    for k in range(1, limits.order + 1):
        low, high = limits.bounds(k)
        values = motion(times, k)
        assert values.max() <= high * (1.0 + 1e-12)
        assert values.min() >= low * (1.0 + 1e-12)
    area = np.trapezoid(motion(times, 1), times) if limits.order > 1 else distance
    assert area == pytest.approx(distance, rel=1e-3)


@pytest.mark.parametrize("limits", LIMITS, ids=repr)
@pytest.mark.parametrize("distance", [3.0, -0.7, 1e-3])
@pytest.mark.parametrize("factor", some([1.0, 1.0 + 1e-9, 1.3, 7.0], 2))
def test_a_move_lasts_as_long_as_asked(limits, distance, factor):
    least = min_time_move(distance, limits).duration
    move = min_time_move(distance, limits, duration=factor * least)
    assert_keeps(move, limits, distance, factor * least)


@pytest.mark.parametrize("limits", LIMITS, ids=repr)
@pytest.mark.parametrize("dt", [1e-3, 0.02, 0.7])
def test_a_rounded_move_is_the_next_whole_number_of_samples(limits, dt):
    least = min_time_move(1.0, limits).duration
    move = min_time_move(1.0, limits, round_to=dt)
    samples = round(move.duration / dt)
    assert_keeps(move, limits, 1.0, samples * dt)
    assert (samples - 1) * dt < least <= samples * dt * (1.0 + 1e-14)


def test_a_whole_number_of_samples_is_not_made_one_longer():
    limits = Limits(acceleration=4.0)  # 1 in exactly 1 s
    for dt in (0.1, 0.01, 0.001, 1.0 / 3.0):
        assert min_time_move(1.0, limits, round_to=dt).duration == pytest.approx(1.0, rel=1e-15)
    both = min_time_move(1.0, limits, duration=1.23, round_to=0.1)
    assert both.duration == pytest.approx(1.3, rel=1e-15)


def test_a_point_waits():
    still = min_time_move(0.0, Limits(velocity=1.0), start=2.0, duration=3.0)
    assert (still.duration, float(still(1.5)), still.peak(1)) == (3.0, 2.0, 0.0)


def test_a_move_of_order_2_that_lasts_longer_has_the_least_acceleration():
    """D = aT²/4 without a cruise, D = V(T − V/a) with one."""
    free = min_time_move(1.0, Limits(velocity=9.0, acceleration=4.0), duration=2.0)
    assert free.peak("acceleration") == pytest.approx(1.0, rel=1e-12)
    assert len(free.durations) == 2
    cruises = min_time_move(1.0, Limits(velocity=0.8, acceleration=4.0), duration=2.0)
    assert cruises.peak("acceleration") == pytest.approx(0.8 / (2.0 - 1.0 / 0.8), rel=1e-12)
    assert cruises.peak("velocity") == pytest.approx(0.8, rel=1e-12)


def share(motion, limits):
    (low, high), (least, most) = motion.extremes(limits.order), limits.bounds(limits.order)
    return max(high / most, low / least)


@pytest.mark.parametrize("limits", [one for one in LIMITS if one.order in (2, 3)], ids=repr)
@pytest.mark.parametrize("factor", [1.05, 2.0])
def test_no_move_needs_a_smaller_share_of_the_highest_bound(limits, factor):
    duration = factor * min_time_move(1.0, limits).duration
    needed = share(min_time_move(1.0, limits, duration=duration), limits)
    sampled = least_share(0.0, 1.0, limits, duration)
    assert needed <= sampled * (1.0 + 1e-6)
    assert needed == pytest.approx(sampled, rel=0.02)


@pytest.mark.parametrize("duration", [1.2, 3.5, 20.0])
def test_no_transfer_needs_a_smaller_share_of_the_highest_bound(duration):
    limits = Limits(velocity=2.0, acceleration=(-1.0, 1.5), jerk=(-5.0, 3.0))
    start, end = (0.0, 1.0), (1.0, 1.0, 0.2)
    motion = min_time_transfer(start, end, limits, duration=duration)
    assert motion.duration == pytest.approx(duration, rel=1e-13)
    assert motion.limits == limits
    assert motion.violation(limits) <= 1e-12
    np.testing.assert_allclose(motion.end_state[:3], end, atol=1e-10)
    sampled = least_share(start, end, limits, duration)
    assert share(motion, limits) <= sampled * (1.0 + 1e-6)
    assert share(motion, limits) == pytest.approx(sampled, rel=0.03)


def test_a_velocity_that_is_kept_needs_nothing_of_it():
    limits = Limits(velocity=2.0, acceleration=1.0)
    assert min_time_transfer((0.0, 1.0), (3.0, 1.0), limits, duration=3.0).peak(2) < 1e-12


def test_a_start_outside_its_bounds_is_brought_inside_with_all_of_it():
    limits = Limits(velocity=2.0, acceleration=1.0, jerk=5.0)
    motion = min_time_transfer((0.0, 3.0), (1.0, 1.0), limits, duration=9.0)
    assert motion.duration == pytest.approx(9.0, rel=1e-13)
    assert motion.peak("jerk") == pytest.approx(5.0, rel=1e-12)


def test_transfers_take_the_durations_that_are_possible():
    limits = Limits(velocity=2.0, acceleration=1.0, jerk=5.0)
    start, end = (0.0, 1.0), (1.0, 1.0)
    for duration in (1.0, 3.5, 20.0):
        transfer = min_time_transfer(start, end, limits, duration=duration)
        assert transfer.duration == pytest.approx(duration, rel=1e-13)
        np.testing.assert_allclose(transfer.end_state[:3], [1.0, 1.0, 0.0], atol=1e-10)
    rounded = min_time_transfer(start, end, limits, round_to=0.25)
    assert rounded.duration == pytest.approx(1.0, rel=1e-13)
    beyond = min_time_transfer(start, end, limits, round_to=1.5)  # 1.5 is none, 3 is none
    assert beyond.duration == pytest.approx(4.5, rel=1e-13)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (
            lambda: min_time_move(1.0, Limits(acceleration=4.0), duration=0.999),
            r"duration = 0.999 is shorter than the least within these limits, 1.0: ",
        ),
        (
            lambda: min_time_transfer(
                (0.0, 1.0),
                (1.0, 1.0),
                Limits(velocity=2.0, acceleration=1.0, jerk=5.0),
                duration=1.9,
            ),
            r"possible are those from 0.89.* to 1.28.*, from 3.11.* on; ",
        ),
        (lambda: min_time_move(1.0, Limits(jerk=1.0), duration=-1.0), "duration = -1.0: expected"),
        (lambda: min_time_move(1.0, Limits(jerk=1.0), round_to=0.0), "round_to = 0.0: expected"),
        (lambda: min_time_move(1.0, Limits(jerk=1.0), round_to=5e-324), "range of a double"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(ask, words):
    with pytest.raises(ValueError, match=words) as refusal:
        ask()
    assert "\n" not in str(refusal.value)
