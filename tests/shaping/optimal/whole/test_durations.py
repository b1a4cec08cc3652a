"""Motions of a given duration, order 4 and above or within stops: gentle, or impossible."""

import re

import numpy as np
import pytest
from extreme_problems import short_ramps
from sampled_motions import least_share
from tiers import some
from whole_problems import random_problem

from jounce.shaping import InfeasibleError, Limits, min_time_move, min_time_transfer
from jounce.shaping.optimal.whole.lasting import next_duration
from jounce.shaping.optimal.whole.planner import planned
from jounce.shaping.optimal.whole.search import Search
from jounce.shaping.optimal.whole.warm_program import Effort

ASYMMETRIC = Limits(velocity=2.0, acceleration=(-4.0, 1.0), jerk=20.0, snap=(-300.0, 200.0))


@pytest.mark.parametrize("factor", [1.02, 1.5, 3.0])
def test_a_move_takes_the_duration_given_with_less_of_the_highest_bound(factor):
    least = min_time_move(1.0, ASYMMETRIC)
    wanted = factor * least.duration
    move = min_time_move(1.0, ASYMMETRIC, duration=wanted)
    assert move.duration == pytest.approx(wanted, rel=1e-14)
    assert move.violation(ASYMMETRIC) == 0.0
    np.testing.assert_array_equal(move.end_state, [1.0, 0.0, 0.0, 0.0, 0.0])
    share = max(move.extremes(4)[1] / 200.0, -move.extremes(4)[0] / 300.0)
    slowed = least.stretch(factor)
    slow = max(slowed.extremes(4)[1] / 200.0, -slowed.extremes(4)[0] / 300.0)
    assert share <= slow * (1.0 + 1e-6)


def test_a_duration_below_the_least_is_proven_impossible():
    least = min_time_move(1.0, ASYMMETRIC).duration
    with pytest.raises(InfeasibleError, match=r"duration = .* is proven impossible; give another"):
        min_time_move(1.0, ASYMMETRIC, duration=0.99 * least)


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_transfers_take_whole_numbers_of_samples(seed):
    problem = random_problem(seed, 4)
    transfer = problem.solve(round_to=0.125)
    assert transfer.duration % 0.125 == 0.0
    assert transfer.duration >= problem.solve().duration
    assert transfer.violation(problem.limits) == 0.0
    n = problem.limits.order
    np.testing.assert_array_equal(transfer.end_state[:n], problem.end)


@pytest.mark.parametrize("tick", [2.0**-12, 2.0**-30, 2.0**-34])
def test_of_a_clock_finer_than_what_is_proven_the_motion_found_is_rounded_up(tick):
    least = min_time_move(1.0, ASYMMETRIC).duration
    move = min_time_move(1.0, ASYMMETRIC, round_to=tick)
    assert move.duration % tick == 0.0
    assert least * (1.0 - 1e-4) <= move.duration < least + tick
    assert move.violation(ASYMMETRIC) == 0.0


def test_a_search_that_has_ended_is_not_taken_up_again():
    start, end = (0.0, 0.5, 0.0), (0.2, 0.5, 0.0)
    limits = Limits(velocity=(0.0, 1.0), acceleration=2.0, jerk=5.0)
    plan = planned(start, end, limits)
    ended = Search(plan.search.problem, np.linspace(0.0, 1.0, 200), after=2.0)
    plan.search.later.append(ended)
    assert next_duration(start, end, limits, np.ldexp(2.0, plan.time), Effort()) == np.inf
    assert len(ended.nodes) == 200


def test_a_blocked_interval_of_durations_is_told_as_such():
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, snap=40.0, position=(-5.0, 5.0))
    start, end = (0.0, 0.9), (1.0, 0.9)
    fast = min_time_transfer(start, end, limits)
    assert fast.duration < 1.2
    with pytest.raises(InfeasibleError, match=r"is none that a motion .* takes: it is") as caught:
        min_time_transfer(start, end, limits, duration=2.5)
    told = re.search(r"the next that was found is (\S+);", str(caught.value))
    after = min_time_transfer(start, end, limits, duration=float(told[1]))
    assert after.duration == pytest.approx(2.9, rel=1e-3)
    slow = min_time_transfer(start, end, limits, duration=8.0)
    assert slow.violation(limits) == 0.0


def test_within_stops_of_order_3_too():
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, position=(-0.2, 1.2))
    transfer = min_time_transfer((0.0, 0.5), (1.0, 0.5), limits, duration=6.0)
    assert transfer.duration == 6.0
    low, high = transfer.extremes(0)
    assert low >= -0.2
    assert high <= 1.2


def assert_of_duration(motion, problem, duration):
    n = problem.limits.order
    assert motion.duration == pytest.approx(duration, rel=1e-13)
    assert motion.violation(problem.limits) <= 1e-12
    np.testing.assert_allclose(motion.end_state[:n], problem.end, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("factor", [1.3, 10.0])
def test_a_bound_far_above_what_matters_is_no_obstacle_to_a_duration(factor):
    problem = short_ramps(0)
    duration = factor * problem.solve().duration
    motion = problem.solve(duration=duration)
    assert_of_duration(motion, problem, duration)
    assert motion.peak(4) < 1e-8 * problem.limits.bounds(4)[1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(28), 3))
def test_under_short_ramps_every_longer_duration_is_found(seed):
    problem = short_ramps(seed)
    n, least = problem.limits.order, problem.solve().duration
    for factor in (1.05, 1.3, 2.5, 10.0):
        motion = problem.solve(duration=factor * least)
        assert_of_duration(motion, problem, factor * least)
        assert motion.peak(n) < 0.1 * problem.limits.bounds(n)[1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [10, 20, 24, 26])
def test_under_short_ramps_motions_are_as_gentle_as_any(seed):
    problem = short_ramps(seed)
    n = problem.limits.order
    duration = 1.3 * problem.solve().duration
    low, high = problem.solve(duration=duration).extremes(n)
    least, most = problem.limits.bounds(n)
    gentle = least_share(problem.start, problem.end, problem.limits, duration, cells=100)
    assert max(high / most, low / least) <= 1.02 * gentle


@pytest.mark.parametrize("snap", [4e4, 4e9])
def test_a_blocked_interval_is_proven_however_short_the_ramps(snap):
    """Of order 3, without a bound on snap, durations from 1.56 to 2.50 are impossible."""
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, snap=snap, position=(-5.0, 5.0))
    start, end = (0.0, 0.9), (1.0, 0.9)
    with pytest.raises(InfeasibleError, match=r"it is proven .* next that was found is 2\.50"):
        min_time_transfer(start, end, limits, duration=2.0)
    assert min_time_transfer(start, end, limits, duration=1.5).violation(limits) == 0.0
