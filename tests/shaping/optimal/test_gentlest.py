"""Motions of a given duration with the smallest share of the highest bound, by linear programs."""

import numpy as np
import pytest
from sampled_motions import least_share

from jounce.shaping import Limits, min_time_move, min_time_transfer

MOVES = [
    Limits(velocity=1.0, acceleration=2.0, jerk=8.0, snap=100.0),
    Limits(velocity=(-1.0, 0.4), acceleration=3.0, jerk=(-5.0, 20.0), snap=100.0),
    Limits(velocity=0.5, acceleration=2.0, jerk=8.0, snap=100.0, crackle=2e3),
    Limits(velocity=0.5, acceleration=(-4.0, 1.0), jerk=20.0, snap=(-300.0, 200.0)),
]


def share(motion, limits):
    """Return how much of the bound on the highest derivative a motion needs."""
    (low, high), (least, most) = motion.extremes(limits.order), limits.bounds(limits.order)
    return max(high / most, low / least)


@pytest.mark.parametrize("limits", MOVES, ids=repr)
@pytest.mark.parametrize("factor", [1.03, 2.0])
def test_a_move_needs_the_smallest_share_of_the_highest_bound(limits, factor):
    fastest = min_time_move(-1.0, limits.mirror())
    duration = factor * fastest.duration
    move = min_time_move(-1.0, limits.mirror(), start=0.5, duration=duration)
    assert move.duration == pytest.approx(duration, rel=1e-14)
    assert move.violation(limits.mirror()) <= 1e-12
    assert move.start_state[0] == 0.5
    assert move.end_state[0] == pytest.approx(-0.5, abs=1e-12)
    needed = share(move.mirror(), limits)
    sampled = least_share(0.0, 1.0, limits, duration)
    assert 0.98 * sampled <= needed <= 1.001 * sampled
    assert needed < 0.9 * factor**-limits.order  # of the fastest move, slowed down as a whole


def test_a_transfer_needs_the_smallest_share_of_the_highest_bound():
    limits = Limits(velocity=2.0, acceleration=(-4.0, 1.0), jerk=20.0, snap=(-300.0, 200.0))
    start, end = (0.0, 0.3, 0.1), (1.0, -0.2)
    duration = 1.2 * min_time_transfer(start, end, limits).duration
    needed = share(min_time_transfer(start, end, limits, duration=duration), limits)
    sampled = least_share(start, end, limits, duration)
    assert 0.98 * sampled <= needed <= 1.003 * sampled


def test_a_whole_number_of_samples_is_taken_gently_too():
    limits = MOVES[0]
    move = min_time_move(1.0, limits, round_to=0.25)
    assert move.duration % 0.25 == 0.0
    assert share(move, limits) < 0.95


@pytest.mark.parametrize("factor", [1.0, 1.0 + 1e-9, 1.0 + 1e-5])
def test_near_the_minimum_time_every_bound_is_kept(factor):
    fastest = min_time_move(1.0, MOVES[0]).duration
    move = min_time_move(1.0, MOVES[0], duration=factor * fastest)
    assert move.duration == factor * fastest
    assert move.violation(MOVES[0]) <= 1e-12


def test_closed_forms_are_slowed_down_as_a_whole():
    fastest = min_time_move(1.0, MOVES[0], method="closed-form")
    slow = min_time_move(1.0, MOVES[0], method="closed-form", duration=2.0 * fastest.duration)
    np.testing.assert_allclose(slow.states, fastest.stretch(2.0).states, rtol=1e-13)
