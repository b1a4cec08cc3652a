"""Durations that a problem can take, and its plan of a given one: linear programs, identities."""

from math import inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import assert_sound_transfer, can_take
from strategies import TransferProblem, random_transfer, transfer_problems
from tiers import some

from jounce import core
from jounce.shaping import InfeasibleError

PASSING = TransferProblem((0.0, 1.0), (0.5, 1.0), ((-3.0, 3.0), (-1.0, 1.0)))
"""From velocity 1 to velocity 1 over 0.5: quickly, or back and forth again."""

PARTS = st.floats(0.0, 1.0, width=32)


def durations_within(intervals, part):
    """Return the ends of the intervals, and one duration inside each."""
    for low, high in intervals:
        yield from (low, low + part * (min(high, 3.0 * low + 1.0) - low))
        if high < inf:
            yield high


def assert_lasts(problem, duration):
    """Assert that a plan of the duration exists, takes it, and is sound."""
    trajectory = problem.problem().lasting(duration)
    if not duration > 0.0:
        return
    assert trajectory.duration == pytest.approx(duration, rel=1e-10), (problem, duration)
    assert_sound_transfer(problem, trajectory)


# The durations possible


def test_the_durations_of_a_quick_pass_and_of_a_loop():
    """With a peak w: T = 2·(w − 1), w² − 1 = ±0.5; with a dip likewise: the theory's example."""
    (low, high), (again, ever) = PASSING.problem().possible_durations()
    assert low == pytest.approx(2.0 * (sqrt(1.5) - 1.0), rel=1e-13)
    assert high == pytest.approx(2.0 * (1.0 - sqrt(0.5)), rel=1e-13)
    assert again == pytest.approx(2.0 * (1.0 + sqrt(0.5)), rel=1e-13)
    assert ever == inf
    near = [low * 0.99, low * 1.01, high * 0.99, high * 1.01, again * 0.99, again * 1.01]
    assert [can_take(PASSING, t) for t in near] == [False, True, True, False, False, True]


def passing(seed):
    """Return a problem of order 3 whose durations are blocked for a while."""
    rng = np.random.default_rng((8, seed))
    jerks = (-float(rng.uniform(3.0, 30.0)), float(rng.uniform(3.0, 30.0)))
    bounds = ((-2.0, 3.0), (-1.0, float(rng.uniform(0.7, 2.0))), jerks)
    start, end = ((x, 1.0, float(rng.uniform(-0.2, 0.2))) for x in (0.0, rng.uniform(0.3, 0.7)))
    return TransferProblem(start, tuple(map(float, end)), bounds)


@pytest.mark.parametrize(
    "problem",
    [
        *(random_transfer(np.random.default_rng((9, s)), 2 + s % 2) for s in some(range(6), 2)),
        *(passing(seed) for seed in some(range(3), 2)),
    ],
)
def test_a_scan_of_linear_programs_finds_the_same_durations(problem):
    intervals = problem.problem().possible_durations()
    ends = [t for pair in intervals for t in pair if t < inf]
    for duration in np.linspace(0.05, 1.3, 16) * max(ends):
        if min(abs(duration / end - 1.0) for end in ends) < 0.03:
            continue
        expected = any(low <= duration <= high for low, high in intervals)
        assert can_take(problem, float(duration)) is expected, (problem, duration, intervals)
    if problem.start[1] == problem.end[1] == 1.0:
        assert len(intervals) == 2


@given(problem=transfer_problems())
def test_the_first_duration_possible_is_the_fastest(problem):
    intervals = problem.problem().possible_durations()
    assert intervals[0][0] == pytest.approx(problem.solve().duration, rel=1e-12, abs=1e-15)
    edges = [t for pair in intervals for t in pair]
    assert edges == sorted(edges)
    assert edges[-1] == inf


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("distance", [0.0, -1e-3, 2.0, 50.0])
def test_from_rest_to_rest_everything_slower_is_possible(order, distance):
    ends = (distance, *[0.0] * (order - 1))
    problem = TransferProblem((0.0,) * order, ends, ((-1.0, 2.0), (-3.0, 1.0), (-8.0, 5.0))[:order])
    fastest = problem.solve().duration
    assert problem.problem().possible_durations() == [(pytest.approx(fastest, rel=1e-13), inf)]


# A plan of a given duration


@given(problem=transfer_problems(), part=PARTS)
def test_lasting(problem, part):
    """At both ends of every interval of durations, and inside."""
    for duration in durations_within(problem.problem().possible_durations(), part):
        assert_lasts(problem, duration)


@pytest.mark.parametrize("seed", range(12))
def test_lasting_where_durations_are_blocked(seed):
    problem = passing(seed)
    intervals = problem.problem().possible_durations()
    for part in (1e-9, 0.01, 0.5, 0.99):
        for duration in durations_within(intervals, part):
            assert_lasts(problem, duration)


@pytest.mark.parametrize("seed", range(20))
def test_nothing_lasts_where_nothing_can(seed):
    problem = passing(seed)
    (low, high), (again, _) = problem.problem().possible_durations()
    limits = problem.limits.flat
    for duration in (0.5 * low, 0.999 * low, 1.001 * high, 0.5 * (high + again), 0.999 * again):
        found = core.transfer_lasting(problem.start, problem.end, limits, duration)
        assert found == core.NO_DURATION, (problem, duration)


@pytest.mark.parametrize("duration", [3.5, 5.0, 60.0])
def test_with_time_to_spare_it_goes_at_one_velocity(duration):
    """From rest over 3 with acceleration 1: v·(T − v) = 3."""
    problem = TransferProblem((0.0, 0.0), (3.0, 0.0), ((-9.0, 9.0), (-1.0, 1.0)))
    plan = problem.problem().lasting(duration)
    velocity = 0.5 * (duration - sqrt(duration**2 - 12.0))
    expected = [velocity, duration - 2.0 * velocity, velocity]
    assert plan.durations.tolist() == pytest.approx(expected, rel=1e-12)
    assert plan.states[1, 1] == pytest.approx(velocity, rel=1e-12)


@given(problem=transfer_problems())
def test_the_mirrored_problem_has_the_opposite_motion(problem):
    there, back = problem.solve(), problem.mirrored().solve()
    assert back.durations.tolist() == there.durations.tolist()
    assert back.states.tolist() == (-there.states).tolist()


def test_no_plan_to_an_end_out_of_reach():
    start, end = (0.0, 1.0, 0.0), (0.5, 2.9, -1.0)
    problem = TransferProblem(start, end, (*PASSING.bounds, (-1.0, 1.0)))
    with pytest.raises(InfeasibleError, match="cannot be reached within the velocity bound"):
        problem.solve()
    assert core.possible_durations(start, end, problem.limits.flat) == ()
    assert core.transfer_lasting(start, end, problem.limits.flat, 5.0) == core.NO_DURATION
