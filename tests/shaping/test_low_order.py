"""Moves of order 1 to 3: Thompson's printed cases, and a linear program where bounds differ."""

import os
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references import (
    BOUND,
    CONTINUITY,
    farthest_distance,
    joint_gaps,
    move_text,
    thompson_order_2,
    thompson_order_3,
)
from strategies import MAGNITUDES, bound_lists, bound_pairs

from jounce.shaping import Limits, min_time_move
from jounce.shaping.closed_form import chain_form

SLOW = os.environ.get("JOUNCE_TIER") == "slow"


def assert_as_published(move, published, text):
    """Assert duration, switch times and peaks."""
    assert move.duration == pytest.approx(published.duration, rel=1e-14), text
    tolerance = 1e-13 * published.duration
    assert move.switch_times == pytest.approx(published.switches, rel=0, abs=tolerance), text
    peaks = [move.peak(k) for k in range(1, move.order + 1)]
    assert peaks == pytest.approx(published.peaks, rel=1e-13), text


@pytest.mark.parametrize(
    ("distance", "velocity", "acceleration", "case"),
    [
        (1.0, 2.0, 1.0, "no cruise"),
        (3.9, 2.0, 1.0, "no cruise"),
        (4.1, 2.0, 1.0, "cruise"),
        (1e3, 2.0, 1e-3, "no cruise"),
        (1e9, 2.0, 1e3, "cruise"),
    ],
)
def test_order_2_is_thompsons(distance, velocity, acceleration, case):
    published = thompson_order_2(distance, velocity, acceleration)
    assert published.case == case
    move = min_time_move(distance, Limits(velocity=velocity, acceleration=acceleration))
    assert_as_published(move, published, move_text(distance, (velocity, acceleration)))


@pytest.mark.parametrize(
    ("distance", "bounds", "case"),
    [
        (1.9, (inf, 1.0, 1.0), "1"),
        (1.0, (9.0, 9.0, 2.0), "1"),
        (2.1, (inf, 1.0, 1.0), "2"),
        (5.0, (9.0, 1.0, 3.0), "2"),
        (5.0, (1.0, inf, 1.0), "3"),
        (50.0, (1.0, 2.0, 1.0), "3"),
        (3.5, (10.5, 10.5, 42.0), "2"),
        (50.0, (3.0, 2.0, 4.0), "4"),
        (1e6, (3.0, 0.1, 1e3), "4"),
    ],
)
def test_order_3_has_thompsons_four_cases(distance, bounds, case):
    published = thompson_order_3(distance, *bounds)
    assert published.case == case
    move = min_time_move(distance, Limits.from_bounds(bounds))
    assert_as_published(move, published, move_text(distance, bounds))


@given(distance=MAGNITUDES, velocity=MAGNITUDES, acceleration=MAGNITUDES)
def test_any_order_2_move_is_thompsons(distance, velocity, acceleration):
    published = thompson_order_2(distance, velocity, acceleration)
    move = min_time_move(distance, Limits(velocity=velocity, acceleration=acceleration))
    assert move.duration == pytest.approx(published.duration, rel=1e-14)
    assert move.peak("velocity") == pytest.approx(published.peaks[0], rel=1e-13)


@given(distance=MAGNITUDES, velocity=MAGNITUDES, acceleration=MAGNITUDES, jerk=MAGNITUDES)
def test_any_order_3_move_is_thompsons(distance, velocity, acceleration, jerk):
    published = thompson_order_3(distance, velocity, acceleration, jerk)
    move = min_time_move(distance, Limits(velocity, acceleration, jerk))
    assert move.duration == pytest.approx(published.duration, rel=1e-13)
    peaks = [move.peak(k) for k in (1, 2, 3)]
    assert peaks == pytest.approx(published.peaks, rel=1e-12)


@pytest.mark.parametrize("distance", [1e-9, 2.0, 7e8])
def test_order_1_is_one_cruise(distance):
    move = min_time_move(distance, Limits(velocity=(-9.0, 4.0)))
    assert move.duration == pytest.approx(distance / 4.0, rel=1e-15)
    assert min_time_move(-distance, Limits(velocity=(-9.0, 4.0))).duration == distance / 9.0
    np.testing.assert_array_equal(move.states, [[0.0, 4.0]])


@given(bounds=bound_lists(1, 3))
def test_the_chain_of_any_order_gives_the_same_durations_and_peaks(bounds):
    filled = [inf if bound is None else bound for bound in bounds]
    move = min_time_move(1.0, Limits.from_bounds(bounds))
    plan = chain_form(1.0, filled, len(bounds) - 1)
    assert move.duration == pytest.approx(plan.duration, rel=1e-14)
    peaks = [*reversed(plan.peaks[:-1]), plan.peak, filled[-1]] if len(bounds) > 1 else filled
    assert [move.peak(k) for k in range(1, len(bounds) + 1)] == pytest.approx(peaks, rel=1e-13)


# Bounds that differ between the directions


@given(pairs=bound_pairs(1, 3), sign=st.sampled_from([-1.0, 1.0]))
def test_unequal_bounds_are_kept_and_the_end_is_met(pairs, sign):
    limits = Limits.from_bounds(pairs)
    move = min_time_move(sign, limits)
    assert move.violation(limits) <= BOUND
    assert move.end_state.tolist() == [sign, *[0.0] * limits.order]
    assert max(joint_gaps(move)) <= CONTINUITY, joint_gaps(move)


@settings(max_examples=max(25, settings.default.max_examples // 10))
@given(pairs=bound_pairs(2, 3))
def test_nothing_goes_further_in_the_same_time_under_unequal_bounds(pairs):
    """The linear program has the move's own switches among its nodes, so it can follow it."""
    limits = Limits.from_bounds(pairs)
    move = min_time_move(1.0, limits)
    nodes = np.union1d(np.linspace(0.0, move.duration, 81), move.switch_times)
    nodes = nodes[np.concatenate([[True], np.diff(nodes) > 1e-9 * move.duration])]
    nodes[-1] = move.duration
    assert farthest_distance(move.duration, limits, nodes, 1.0) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20 if SLOW else 2))
def test_unequal_bounds_against_a_fine_grid(seed):
    rng = np.random.default_rng(seed)
    bounds = [
        (-(10.0 ** rng.uniform(-1, 1)) * s, 10.0 ** rng.uniform(-1, 1) * s) for s in (2, 8, 32)
    ]
    limits = Limits.from_bounds(bounds)
    move = min_time_move(1.0, limits)
    nodes = np.union1d(np.linspace(0.0, move.duration, 401), move.switch_times)
    farthest = farthest_distance(move.duration, limits, nodes, 1.0)
    assert farthest == pytest.approx(1.0, rel=5e-5), move_text(1.0, bounds)


@given(pairs=bound_pairs(1, 3))
def test_a_move_run_backwards_is_the_move_under_mirrored_even_bounds(pairs):
    """R − x(T − t) turns the sign of even derivatives only."""
    turned = [
        pair and ((-pair[1], -pair[0]) if k % 2 == 0 else pair)
        for k, pair in enumerate(pairs, start=1)
    ]
    move = min_time_move(1.0, Limits.from_bounds(pairs))
    other = min_time_move(1.0, Limits.from_bounds(turned))
    assert other.duration == pytest.approx(move.duration, rel=1e-13)
    t = np.linspace(0.0, move.duration, 50)
    np.testing.assert_allclose(1.0 - move(move.duration - t), other(t), rtol=0, atol=1e-12)


@given(pairs=bound_pairs(1, 3))
def test_the_opposite_move_is_the_mirror_image(pairs):
    limits = Limits.from_bounds(pairs)
    back, forth = min_time_move(-1.0, limits), min_time_move(1.0, limits.mirror())
    np.testing.assert_array_equal(back.states, -forth.states)
    np.testing.assert_array_equal(back.breaks, forth.breaks)


def test_one_sided_bounds_below_the_highest_are_bounds():
    limits = Limits(velocity=(-inf, 1.0), acceleration=(-2.0, inf), jerk=50.0)
    move = min_time_move(3.0, limits)
    low, high = move.extremes("acceleration")
    assert move.extremes("velocity") == pytest.approx((0.0, 1.0), abs=1e-15)
    assert low == pytest.approx(-2.0)
    assert high == pytest.approx(50.0**0.5)  # sqrt(V·W), nothing stops it
    assert min_time_move(-3.0, limits).peak("velocity") > 1.0


@pytest.mark.parametrize(
    ("distance", "limits"),
    [
        (0.38, Limits(acceleration=(-9.8e-05, 190.0), jerk=(-8479.0, 1806.0))),
        (860.71, Limits(acceleration=(-1.12e-06, 100.0), jerk=(-3.9, 635.7))),
        (1e-6, Limits(1, (-1e-12, 1), 1)),
    ],
)
def test_bounds_many_decades_apart_in_the_two_directions_are_kept(distance, limits):
    """Once the larger ramp's rounding spoilt the smaller: an excess of up to 3e-9."""
    move = min_time_move(distance, limits)
    assert move.violation(limits) <= BOUND, move_text(distance, limits)
    assert max(joint_gaps(move)) <= CONTINUITY
