"""What a plan owes to symmetry: units, mirror image, time reversal; and to other planners."""

from math import inf

import numpy as np
import pytest
from tiers import some
from whole_problems import Bracketed, random_problem, reversed_in_time

from jounce.shaping import InfeasibleError, Limits, certify, min_time_move, min_time_transfer
from jounce.shaping.optimal.whole.planner import planned

GAP = 1e-4


@pytest.mark.parametrize("seed", range(4))
def test_powers_of_two_of_the_units_change_nothing(seed):
    problem = random_problem(seed, 4)
    there = problem.solve()
    length, time = 2.0**13, 2.0**-9
    powers = length / time ** np.arange(5)
    start, end = (np.array(state) * powers[:4] for state in (problem.start, problem.end))
    pairs = [tuple(np.array(problem.limits.bounds(k)) * powers[k]) for k in range(1, 5)]
    again = min_time_transfer(start, end, Limits.from_bounds(pairs))
    assert again.duration == there.duration * time
    np.testing.assert_array_equal(again.states, there.states * powers)


@pytest.mark.parametrize("seed", range(3))
def test_the_mirror_image_has_the_mirrored_plan(seed):
    problem = random_problem(seed, 4)
    there = problem.solve()
    start, end = (tuple(-x for x in state) for state in (problem.start, problem.end))
    back = min_time_transfer(start, end, problem.limits.mirror())
    np.testing.assert_array_equal(back.states, -there.states)
    assert certify(back, problem.limits.mirror()).check()


@pytest.mark.parametrize(("seed", "order"), [(0, 4), (1, 4), (2, 4), (3, 4), (0, 5), (2, 5)])
def test_backwards_in_time_it_takes_as_long(seed, order):
    problem = random_problem(seed, order)
    there, back = problem.solve(), reversed_in_time(problem).solve()
    assert back.duration == pytest.approx(there.duration, rel=GAP)


@pytest.mark.parametrize("seed", some(range(12), 6))
def test_order_3_agrees_with_the_exact_core(seed):
    problem = random_problem(seed, 3)
    try:
        exact = problem.solve()
    except InfeasibleError:
        assert planned(problem.start, problem.end, problem.limits).impossible
        return
    if exact.inside_after:
        return
    plan = planned(problem.start, problem.end, problem.limits)
    assert plan.lower_bound <= exact.duration * (1.0 + 1e-12)
    assert plan.trajectory.duration == pytest.approx(exact.duration, rel=GAP)
    assert plan.trajectory.duration >= exact.duration * (1.0 - 1e-12)


@pytest.mark.parametrize("distance", [0.3, 5.0])
def test_symmetric_moves_agree_with_the_half_horizon(distance):
    limits = Limits(velocity=2.0, acceleration=3.0, jerk=20.0, snap=200.0)
    move = min_time_move(distance, limits)
    rest = (0.0,) * 3
    plan = planned((0.0, *rest), (distance, *rest), limits)
    assert plan.trajectory.duration == pytest.approx(move.duration, rel=GAP)
    assert plan.lower_bound <= move.duration
    proof = certify(move, limits)
    assert proof.lower_bound <= plan.trajectory.duration


def test_positions_that_are_far_away_bind_nothing():
    problem = random_problem(1, 4)
    far = Limits.from_bounds([problem.limits.bounds(k) for k in range(1, 5)], position=(-1e3, 1e3))
    other = min_time_transfer(problem.start, problem.end, far)
    assert other.duration == pytest.approx(problem.solve().duration, rel=GAP)


def test_a_wider_bound_is_never_slower_and_sensitivities_are_slopes():
    limits = Limits(velocity=1.2, acceleration=(-4.0, 1.0), jerk=10.0, snap=100.0)
    move = min_time_move(3.0, limits, rtol=1e-5)
    proof = certify(move, limits, rtol=1e-5)
    for k in some(range(1, 5), 2):
        pairs = [limits.bounds(j) for j in range(1, 5)]
        pairs[k - 1] = tuple(1.01 * side for side in pairs[k - 1])
        wider = min_time_move(3.0, Limits.from_bounds(pairs), rtol=1e-5)
        slope = (wider.duration / move.duration - 1.0) / 0.01
        assert slope == pytest.approx(proof.sensitivities[k - 1], abs=0.01)
    weighted = sum(k * share for k, share in enumerate(proof.sensitivities, start=1))
    assert weighted == pytest.approx(-1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("distance", "limits", "least", "most"),
    [
        (1.0, Limits(acceleration=(-10, 1), jerk=100, snap=1e4), 1.5492561, 1.5492619),
        (60.0, Limits(20, (-4, 1), 10, 100), 12.59997, 12.60001),
        (1.0, Limits(acceleration=(-4, 1), snap=40), 2.1022391, 2.1022503),
    ],
)
def test_published_moves(distance, limits, least, most):
    move = min_time_move(distance, limits)
    assert least <= move.duration <= most * (1.0 + GAP)
    back = min_time_move(-distance, limits.mirror(), start=7.0)
    assert back.duration == pytest.approx(move.duration, rel=1e-12)


def test_the_published_motion_next_to_a_stop():
    limits = Limits(1.5, 1.0, 1.0, position=(-4.0, 4.0))
    problem = Bracketed("", (3.999, -0.375, 1.0), (4.0, 0.0, 0.0), limits, 0.0, inf)
    assert problem.solve(rtol=1e-5).duration == pytest.approx(2.43183, abs=3e-5)
    free = min_time_transfer(problem.start, problem.end, Limits(1.5, 1.0, 1.0))
    assert free.duration == pytest.approx(1.8757344530, rel=1e-9)
