"""Plans between any states against published brackets: never too slow, never below, all proven."""

from functools import cache

import numpy as np
import pytest
from references import BOUND, CONTINUITY, joint_gaps, polynomial_extremes
from tiers import SLOW, some
from whole_problems import Bracketed, impossible, solvable

from jounce.shaping import InfeasibleError, certify
from jounce.shaping.optimal.whole.planner import planned

SOLVABLE = [pytest.param(problem, id=problem.name) for problem in solvable()]
QUICK = [problem for problem in SOLVABLE if problem.values[0].limits.order <= 5]
FEW = SOLVABLE if SLOW else SOLVABLE[1::3]
SOLVED = cache(Bracketed.solve)


@pytest.mark.parametrize("problem", FEW)
def test_plan_and_proof_are_within_the_bracket(problem):
    transfer = SOLVED(problem)
    assert problem.least * (1.0 - 1e-9) <= transfer.duration <= problem.most * (1.0 + 1e-4)
    proof = certify(transfer, problem.limits)
    assert proof.lower_bound < problem.most
    assert proof.reached
    assert proof.check()
    assert len(transfer.states) <= 80


@pytest.mark.parametrize("problem", some(QUICK[::3], 4))
def test_a_smaller_gap_is_had_on_request(problem):
    transfer = problem.solve(rtol=1e-5)
    assert problem.least * (1.0 - 1e-9) <= transfer.duration <= problem.most * (1.0 + 1e-5)
    proof = certify(transfer, problem.limits, rtol=1e-5)
    assert proof.reached
    assert problem.least * (1.0 - 1.1e-5) <= proof.lower_bound < problem.most


@pytest.mark.parametrize("problem", FEW)
def test_states_and_bounds_are_kept_at_all_times(problem):
    transfer = SOLVED(problem)
    n = problem.limits.order
    np.testing.assert_array_equal(transfer.start_state[:n], problem.start)
    np.testing.assert_array_equal(transfer.end_state, [*problem.end, 0.0])
    assert max(joint_gaps(transfer.trajectory)) <= CONTINUITY
    for k in range(n + 1):
        low, high = problem.limits.bounds(k)
        slack = BOUND * transfer.peak(k)
        for state, time in zip(transfer.states, transfer.durations, strict=True):
            least, most = polynomial_extremes(state, time, k)
            assert low - slack <= least, k
            assert most <= high + slack, k


@pytest.mark.parametrize("problem", impossible(), ids=lambda problem: problem.name)
def test_problems_without_a_motion_are_proven_to_have_none(problem):
    with pytest.raises(InfeasibleError, match=r"no motion within the limits") as told:
        problem.solve()
    assert told.value.bound == {"start-velocity": "velocity"}.get(problem.name[5:], "position")
    assert told.value.time is not None
    plan = planned(problem.start, problem.end, problem.limits)
    assert plan.impossible
    from jounce.shaping.optimal.proof_check import holds

    assert holds(plan.proof)
