"""Highest bounds far above what is active: planned by fewer derivatives, proven, never broken."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from extreme_problems import long_holds, pairs_of, short_ramps, wrong_with
from whole_problems import random_problem

from jounce.shaping import Limits, certify, min_time_transfer
from jounce.shaping.optimal.long_plan import long_plan
from jounce.shaping.optimal.proof_check import holds
from jounce.shaping.optimal.whole.planner import planned
from jounce.shaping.optimal.whole.search import Search
from jounce.shaping.optimal.whole.short_ramps import begun
from jounce.shaping.optimal.whole.warm_program import Effort

GAP = 1e-4


@pytest.mark.parametrize("seed", [0, 8, 21])
def test_a_plan_is_within_the_gap_of_its_proof(seed):
    problem = short_ramps(seed)
    assert wrong_with(problem) == ""
    plan = planned(problem.start, problem.end, problem.limits)
    assert plan.search.gap <= GAP
    assert plan.search.effort.left > 0.0


@pytest.mark.parametrize("snap", [1e7, 1e16])
@pytest.mark.parametrize("seed", [2, 6])
def test_order_three_is_what_is_left_of_order_four(seed, snap):
    """The core plans order 3 exactly: no motion of order 4 takes less, none need take more."""
    problem = random_problem(seed, 3)
    pairs = pairs_of(problem)
    exact = problem.solve().duration
    start, end = (np.array([*state, 0.3]) for state in (problem.start, problem.end))
    limits = Limits.from_bounds([*pairs, (-snap, 2.0 * snap)])
    motion = min_time_transfer(start, end, limits)
    assert exact * (1.0 - 1e-9) <= motion.duration <= exact * (1.0 + 2.0 * GAP)
    assert motion.violation(limits) <= 1e-12
    lower = planned(tuple(start.tolist()), tuple(end.tolist()), limits).lower_bound
    assert lower <= exact * (1.0 + 100.0 / snap)
    assert motion.duration <= lower * (1.0 + GAP)


def test_a_proof_may_have_links_of_fewer_derivatives():
    problem = short_ramps(21)
    proof = planned(problem.start, problem.end, problem.limits).proof
    assert {len(link.ends) for link in proof.links[1:]} == {3, 5}
    assert holds(proof)
    wider = list(proof.upper)
    wider[3] *= 1.01
    assert not holds(replace(proof, upper=tuple(wider)))
    first = next(i for i, link in enumerate(proof.links) if len(getattr(link, "ends", ())) == 3)
    longer = replace(proof.links[first], ends=(*proof.links[first].ends, 0.0, 0.0, 0.0))
    assert not holds(
        replace(proof, links=(*proof.links[:first], longer, *proof.links[first + 1 :]))
    )


def test_a_certificate_tells_what_bounds_cost_and_nothing_of_the_highest():
    problem = short_ramps(23)
    certificate = certify(problem.solve(), problem.limits)
    assert certificate.gap <= GAP
    assert certificate.check()
    assert len(certificate.slopes) == 5
    assert certificate.sensitivities[3] == 0.0
    assert min(certificate.sensitivities) < -0.1


def test_derivatives_without_bounds_in_between_are_brought_to_zero_and_back():
    """Jerk and snap are what they are at the start: the bounds are on acceleration and crackle."""
    problem = short_ramps(118)
    pairs = pairs_of(problem)
    assert pairs[2] == pairs[3] == (-inf, inf)
    plan = planned(problem.start, problem.end, problem.limits, 5e-3)
    assert plan.search.rounds == 0
    assert plan.trajectory.violation(problem.limits) <= 1e-12
    assert plan.trajectory.start_state[:5].tolist() == list(problem.start)


def test_a_start_on_a_bound_is_left():
    limits = Limits.from_bounds([(-2.0, 1.0), (-8.0, 9.0), (-100.0, 80.0), (-1e11, 1e11)])
    start, end = (0.0, 1.0, -3.0, 5.0), (2.0, 0.5, 1.0, 0.0)
    plan = planned(start, end, limits)
    assert plan.search.gap <= GAP
    assert plan.trajectory.violation(limits) <= 1e-12


def test_ramps_of_a_long_motion_are_proven_by_fewer_derivatives():
    problem = long_holds(7)
    *pairs, highest = pairs_of(problem)
    limits = Limits.from_bounds([*pairs, tuple(1e6 * side for side in highest)])
    plan = long_plan(problem.start, problem.end, limits, rtol=GAP)
    assert plan.gap <= GAP
    assert len(plan.proven.proof.start) == 3
    assert holds(plan.proven.proof)


def test_bounds_that_matter_are_left_to_the_search():
    plan = planned(*(lambda p: (p.start, p.end, p.limits))(random_problem(3, 4)), 0.5)
    search = begun(Search(plan.search.problem), GAP, Effort())
    assert search.best is None
    assert search.lower == search.chain[-1].high
