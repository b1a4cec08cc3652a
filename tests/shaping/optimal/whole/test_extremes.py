"""Plans at the edges: an honest gap, a proof that there is none, or a reason; never a hang."""

import os

import numpy as np
import pytest
from extreme_problems import KINDS, barely_active, far_bounds, long_holds, wrong_with
from whole_problems import random_problem

from jounce.shaping.optimal.long_plan import long_plan
from jounce.shaping.optimal.proof_check import holds
from jounce.shaping.optimal.whole.nearest_state import nearest_starts
from jounce.shaping.optimal.whole.planner import planned
from jounce.shaping.optimal.whole.problem import WholeProblem
from jounce.shaping.optimal.whole.search import Search
from jounce.shaping.optimal.whole.warm_program import Effort, WarmProgram

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
QUICK = [kind for kind in KINDS if kind.__name__ not in ("short_ramps", "high_orders")]


@pytest.mark.parametrize("seed", [1, 5])
@pytest.mark.parametrize("kind", QUICK, ids=lambda kind: kind.__name__)
def test_a_sample_of_every_kind(kind, seed):
    assert wrong_with(kind(seed)) == ""


@pytest.mark.slow
@pytest.mark.skipif(not SLOW, reason="more than two hundred problems; JOUNCE_TIER=slow")
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_kind(kind):
    told = {seed: wrong_with(kind(seed)) for seed in range(28)}
    assert not {seed: wrong for seed, wrong in told.items() if wrong}


def test_a_long_hold_between_moving_states_is_found_on_a_grid_that_is_fine_at_its_ends():
    search = Search(_whole(long_holds(2)))
    search.run(1e-3, rounds=1)
    assert search.gap <= 1e-3
    coarse = Search(search.problem, np.linspace(0.0, 1.0, 17))
    coarse.run(1e-3, rounds=1)
    assert coarse.best is None


def test_a_way_hardly_longer_than_its_ramps_is_planned_as_a_whole_where_that_is_nearer():
    problem = long_holds(19)
    assert long_plan(problem.start, problem.end, problem.limits, rtol=1e-4).gap > 0.1
    assert problem.solve().duration < 4.4776


@pytest.mark.slow
def test_next_to_a_dead_end_the_room_for_repairs_is_given_up():
    problem = barely_active(24)
    assert planned(problem.start, problem.end, problem.limits).search.gap <= 1e-4
    assert problem.solve().violation(problem.limits) == 0.0


@pytest.mark.slow
def test_ramps_whose_shortest_time_tells_little_are_proven_by_how_far_they_come():
    problem = far_bounds(13)
    plan = long_plan(problem.start, problem.end, problem.limits, rtol=1e-4)
    assert plan.gap <= 1e-4
    assert holds(plan.proven.proof)


def test_a_search_ends_when_its_effort_is_spent():
    search = Search(_whole(random_problem(0, 4)))
    search.run(1e-4)
    assert search.gap <= 1e-4
    ended = Search(search.problem)
    ended.run(1e-4, effort=Effort(1e5))
    assert ended.rounds == 1
    assert ended.gap > 1e-4
    assert ended.lower <= search.best.time


def test_a_plan_takes_no_more_than_the_effort_it_is_given():
    problem = random_problem(0, 4, moving=False)
    plan = planned(problem.start, problem.end, problem.limits, effort=2e5)
    assert -1e6 < plan.search.effort.left <= 0.0
    assert plan.search.gap > 1e-4
    assert planned(problem.start, problem.end, problem.limits).search.gap <= 1e-4


def test_what_is_told_of_a_dead_end_takes_its_effort_only():
    problem = _whole(random_problem(2, 8))
    effort = Effort(1e7)
    assert list(nearest_starts(problem, 0.3, effort)) == []
    assert -1e7 < effort.left <= 0.0


def test_a_motion_is_switched_between_its_bounds_with_the_same_sums():
    problem = _whole(random_problem(0, 4))
    search = Search(problem)
    search.run(1e-2)
    nodes, low, high = np.linspace(0.0, 1.0, 401), problem.lower[-1], problem.upper[-1]
    given = search.guide.on(nodes) / search.guide.time**4
    switched = np.where(search.guide.switched_on(nodes, problem), high, low)
    assert np.abs(np.cumsum(switched - given)).max() <= 0.5001 * (high - low)


def test_a_program_without_effort_has_no_answer():
    one = np.ones(1)
    spent = WarmProgram(np.eye(1), one, np.array([True]), Effort(0.0))
    assert spent.solve(one, one, -one, one) is None
    fresh = WarmProgram(np.eye(1), one, np.array([True])).solve(one, one, -one, one)
    assert fresh.value == pytest.approx(1.0)


def _whole(problem):
    pairs = [problem.limits.bounds(k) for k in range(problem.limits.order + 1)]
    low, high = (np.array(sides) for sides in zip(*pairs, strict=True))
    return WholeProblem(np.array(problem.start), np.array(problem.end), low, high)
