"""Motions much longer than their ramps: exact, quick, and proven by both ramps and the cruise."""

import time
import warnings
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tiers import some

from jounce.shaping import (
    Certificate,
    InfeasibleError,
    Limits,
    certify,
    min_time_move,
    min_time_transfer,
)
from jounce.shaping.optimal.proof import CruisingLink
from jounce.shaping.optimal.proof_check import holds

LIMITS = Limits(velocity=(-2.0, 1.0), acceleration=(-2.0, 1.0), jerk=5.0, snap=100.0)
CHATTERING = Limits.from_bounds([(-2, 1), (-10, 1), (-100, 30), 1e4, (-1e6, 2e6)])


def planned(start, end, limits=LIMITS, rtol=1e-4):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return min_time_transfer(start, end, limits, rtol=rtol)


@pytest.mark.parametrize("distance", some([400.0, 1e4, 1e7, -60.0, -1e4], 2))
def test_a_long_transfer_is_exact_and_proven_near_the_minimum(distance):
    end = (7.0 + distance, 0.2, -0.1)
    found = planned((7.0, 0.1, 0.1), end)
    assert found.trajectory.violation(LIMITS) <= 1e-12
    assert found.end_state.tolist() == [*end, 0.0, 0.0]
    least = abs(distance) / (1.0 if distance > 0.0 else 2.0)
    assert least < found.duration < least + 4.0
    inner = found.trajectory.breaks[1:-1]
    step = 1e-9 * max(1.0, inner[-1])
    for k, most in ((1, 4.0), (2, 10.0), (3, 200.0)):
        jumps = np.abs(found(inner, k) - found(inner - step, k))
        assert jumps.max() < most * step
    proof = certify(found, LIMITS)
    assert proof.reached
    assert least < proof.lower_bound <= found.duration
    assert proof.check()


def test_its_ramps_take_what_those_of_a_shorter_one_take():
    shorter, longer = (
        planned((0.0, 0.1, 0.1), (distance, 0.2)).duration - distance for distance in (8.0, 1e6)
    )
    assert longer == pytest.approx(shorter, abs=0.006)


@pytest.mark.parametrize("sign", some([1.0, -1.0], 1))
def test_a_move_of_a_hundred_ramps_is_as_quick_as_one_of_ten(sign):
    limits = LIMITS if sign > 0.0 else LIMITS.mirror()
    began = time.process_time()
    move = min_time_move(sign * 300.0, limits)
    assert time.process_time() - began < 5.0
    proof = certify(move, limits)
    assert proof.gap < 1e-4
    assert len(move.durations) <= 60
    ten = certify(min_time_move(sign * 8.0, limits), limits)  # by the whole horizon
    assert proof.lower_bound - 300.0 == pytest.approx(ten.lower_bound - 8.0, abs=6e-3)


@pytest.mark.slow
def test_slopes_of_the_bound_are_differences():
    start, end = (0.0, 0.3), (500.0, -0.2)
    sides = [LIMITS.bounds(k) for k in range(1, 5)]
    rtol = 1e-6  # at 1e-4 the ramps themselves differ by as much
    found = planned(start, end, rtol=rtol)
    slopes = certify(found, LIMITS, rtol=rtol).slopes
    for k in (1, 2, 3):
        for side in (0, 1):
            changed = [list(pair) for pair in sides]
            changed[k][side] *= 1.1
            further = Limits.from_bounds(changed)
            gain = planned(start, end, further, rtol).duration - found.duration
            expected = slopes[k + 1][side] * 0.1 * sides[k][side]
            assert gain == pytest.approx(expected, rel=0.3, abs=1e-3)


def test_a_stop_behind_the_start_counts():
    stage = replace_position(LIMITS, (-0.02, 3000.0))
    move = planned((0.0, -0.1), (2000.0, 0.2), stage)
    low, high = move.extremes(0)
    assert -0.02 - 1e-12 <= low < -0.001
    assert high <= 3000.0
    proof = certify(move, stage)
    assert proof.reached
    assert proof.check()


def test_with_another_bound_the_proof_does_not_hold(tmp_path):
    found = certify(planned((0.0, 0.3), (500.0, -0.2)), LIMITS)
    found.save(tmp_path / "proof.json")
    again = Certificate.load(tmp_path / "proof.json")
    assert again == found
    proof = found.proof
    [link] = [each for each in proof.links if isinstance(each, CruisingLink)]
    for wrong in (
        replace(link, sign=-1),
        replace(link, cruise=-link.cruise),
        replace(link, onto=replace(link.onto, time=0.0)),
        replace(link, onto=link.off, off=link.onto),
    ):
        assert not holds(replace(proof, links=(*proof.links[:-1], wrong)))
    faster = (*proof.upper[:1], 1.001, *proof.upper[2:])
    assert not holds(replace(proof, upper=faster))
    assert all(a.high == b.low for a, b in pairwise(proof.links))


@pytest.mark.slow
def test_what_leads_nowhere_is_told_of_its_own_side():
    start = (0.0, 0.99, 1.0)
    with pytest.raises(InfeasibleError, match="leaves the start: velocity would exceed"):
        min_time_transfer(start, (1e4, 0.0), LIMITS)
    with pytest.raises(InfeasibleError, match="leads to the end: velocity would exceed"):
        min_time_transfer(0.0, (1e4, 0.99, -1.0), LIMITS)


@pytest.mark.slow
def test_ramps_that_chatter_are_tried_with_other_ends():
    move = min_time_move(60.0, CHATTERING)
    assert move.violation(CHATTERING) <= 1e-12
    assert certify(move, CHATTERING).gap < 1e-4


def test_order_3_within_bounds_on_position_still_has_its_own_way():
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=5.0, position=(-1.0, 2e3))
    found = min_time_transfer((0.0, 0.1), (1e3, 0.2), limits)
    assert np.abs(found.end_state[:2] - (1e3, 0.2)).max() < 1e-9


def replace_position(limits, position):
    pairs = zip(limits.lower, limits.upper, strict=True)
    return Limits.from_bounds(pairs, position=position)
