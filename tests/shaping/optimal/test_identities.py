"""What holds of optimal moves and their proofs under any limits, however near the minimum they are.

A lower bound on the minimum time is proven, so that an easier problem's bound is never above a
harder one's duration: that is tested to rounding. How near two moves of about one problem are is
tested to the gaps of both.
"""

import os
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from references import BOUND, CONTINUITY, END_POSITION, joint_gaps, move_text
from scipy.optimize import brentq
from strategies import MAGNITUDES, UNIT_FACTORS, bound_lists, bound_pairs

from jounce.shaping import Limits, min_time_move
from jounce.shaping.optimal import binding_limits, certify

pytestmark = pytest.mark.filterwarnings("ignore:these limits are too far apart:RuntimeWarning")
HIGHEST = 8 if os.environ.get("JOUNCE_TIER") == "slow" else 6
FEW = settings(max_examples=max(4, settings.default.max_examples // 25))
BOUNDS = bound_lists(4, HIGHEST)
PLACES = st.integers(0, HIGHEST - 1)
FACTORS = st.sampled_from([1.0 + 1e-9, 1.0 + 1e-4, 1.03, 1.7, 30.0])
SIGNS = st.sampled_from([-1.0, 1.0])
ROUNDING = 1e-11
NEAR = 5e-3  # of the duration: the largest gap that adversarial bounds may leave
SAME = 1e-4  # of the duration: how much meshes that differ by rounding may differ by


def optimal(distance, bounds, **options):
    return min_time_move(distance, Limits.from_bounds(bounds), method="optimal", **options)


@lru_cache(maxsize=64)
def _proof(distance, bounds):
    move = optimal(distance, bounds)
    return move, certify(move, Limits.from_bounds(bounds))


def proof_of(bounds, distance: float = 1.0):
    """Return the optimal move and its certificate."""
    return _proof(distance, tuple(bounds))


def proven(bounds, distance: float = 1.0) -> float:
    """Return a time that nothing within the bounds can beat."""
    return proof_of(bounds, distance)[1].lower_bound


def duration(bounds, distance: float = 1.0) -> float:
    return proof_of(bounds, distance)[0].duration


def change(bounds, place: int, value):
    """Return the bounds with one that is there changed, and its derivative."""
    there = [k for k, bound in enumerate(bounds) if bound]
    k = there[place % len(there)]
    return [value(bound) if i == k else bound for i, bound in enumerate(bounds)], k + 1


def assert_sound(move, distance, bounds):
    """Assert ends, bounds at breaks and extrema, continuity and symmetry about the middle."""
    text = move_text(distance, bounds)
    n, travelled = move.order, float(move.end_state[0] - move.start_state[0])
    assert (move.start_time, n) == (0.0, len(bounds)), text
    assert abs(travelled - distance) <= END_POSITION * abs(distance), text
    assert abs(float(move(move.end_time) - move.end_state[0])) <= END_POSITION * abs(distance), text
    np.testing.assert_array_equal(move.start_state[1:-1], 0.0, text)
    np.testing.assert_array_equal(move.end_state[1:], 0.0, text)
    assert move.violation(Limits.from_bounds(bounds)) <= BOUND, text
    assert max(joint_gaps(move)) <= CONTINUITY, text
    assert np.all(move.durations > 0.0), text
    assert move.durations.sum() == pytest.approx(move.duration, rel=1e-13), text
    if not Limits.from_bounds(bounds).symmetric:
        return
    back = move.reverse().mirror().shift(travelled + 2.0 * float(move.start_state[0]))
    t = np.linspace(0.0, 1.0, 41) * move.duration
    for k in range(n):
        slack = 1e-11 * move.peak(k)
        np.testing.assert_allclose(back(t, k), move(t, k), rtol=0, atol=slack, err_msg=text)


# Moves


@settings(max_examples=max(8, settings.default.max_examples // 10))
@given(bounds=BOUNDS, distance=SIGNS)
def test_moves_are_sound_and_never_slower_than_the_closed_form(bounds, distance):
    move = optimal(distance, bounds)
    assert_sound(move, distance, bounds)
    closed = min_time_move(distance, Limits.from_bounds(bounds), method="closed-form")
    assert move.duration <= closed.duration, move_text(distance, bounds)


@FEW
@given(pairs=bound_pairs(4, 6))
def test_bounds_that_differ_between_the_directions_are_kept_in_both(pairs):
    limits = Limits.from_bounds(pairs)
    forth = min_time_move(1.0, limits, method="optimal")
    back = min_time_move(-1.0, limits, method="optimal")
    turned = min_time_move(-1.0, limits.mirror(), method="optimal")
    assert_sound(forth, 1.0, pairs)
    assert_sound(back, -1.0, pairs)
    np.testing.assert_array_equal(turned.states, -forth.states)
    for move in (forth, back):
        proof = certify(move, limits)
        assert 0.0 < proof.lower_bound <= move.duration, limits


@FEW
@given(bounds=BOUNDS, start=st.floats(-1e3, 1e3), distance=MAGNITUDES)
def test_the_opposite_move_is_the_mirror_image_and_a_start_only_shifts(bounds, start, distance):
    forth, back = optimal(distance, bounds), optimal(-distance, bounds)
    np.testing.assert_array_equal(back.states, -forth.states)
    np.testing.assert_array_equal(back.end_state, -forth.end_state)
    np.testing.assert_array_equal(back.breaks, forth.breaks)
    moved = optimal(distance, bounds, start=start)
    np.testing.assert_array_equal(moved.states[:, 1:], forth.states[:, 1:])
    np.testing.assert_array_equal(moved.breaks, forth.breaks)
    assert moved.start_state[0] == start


@FEW
@given(bounds=BOUNDS, distance_unit=UNIT_FACTORS, time_unit=UNIT_FACTORS, sign=SIGNS)
def test_units_change_a_duration_by_no_more_than_a_grid_does(
    bounds, distance_unit, time_unit, sign
):
    """Nearly always by rounding; a digit that is rounded otherwise may lead to another mesh."""
    scaled = [b and b * distance_unit / time_unit**k for k, b in enumerate(bounds, start=1)]
    here, there = optimal(sign, bounds), optimal(sign * distance_unit, scaled)
    assert_sound(there, sign * distance_unit, scaled)
    assert there.duration / time_unit == pytest.approx(here.duration, rel=SAME)
    assert there.duration >= proven(bounds) * time_unit * (1.0 - ROUNDING)


@FEW
@given(bounds=BOUNDS)
def test_nearly_all_of_the_time_some_bound_is_reached(bounds):
    """Otherwise there would be time to gain."""
    move = optimal(1.0, bounds)
    held = binding_limits(move, Limits.from_bounds(bounds), rtol=1e-3)
    idle = sum(d for d, at in zip(move.durations.tolist(), held, strict=True) if not at)
    assert idle <= 0.25 * move.duration, move_text(1.0, bounds)


# Proofs


@FEW
@given(bounds=bound_lists(4, 6))
def test_a_proof_is_below_the_move_and_near_it(bounds):
    move, proof = proof_of(bounds)
    text = move_text(1.0, bounds)
    assert proof.duration == move.duration
    assert 0.0 < proof.lower_bound <= move.duration, text
    assert 0.0 <= proof.gap <= NEAR, text
    assert proof.reached == (proof.gap <= proof.rtol)
    assert proof.gap == pytest.approx(move.duration / proof.lower_bound - 1.0, abs=1e-15)


@FEW
@given(bounds=BOUNDS)
def test_sensitivities_share_the_duration_among_the_bounds(bounds):
    """The duration is homogeneous: bounds L_k·s^k make it T/s, so that Σ k·s_k = −1."""
    _, proof = proof_of(bounds)
    text = move_text(1.0, bounds)
    assert len(proof.sensitivities) == len(bounds), text
    for bound, sensitivity in zip(bounds, proof.sensitivities, strict=True):
        assert sensitivity <= 0.0, text
        assert bound or sensitivity == 0.0, text
    weighted = sum(k * s for k, s in enumerate(proof.sensitivities, start=1))
    assert weighted == pytest.approx(-1.0, rel=1e-12), text


@FEW
@given(bounds=BOUNDS, data=st.data())
def test_the_sensitivities_of_one_problem_are_a_proof_for_every_other(bounds, data):
    """Any limits f_k·L_k and distance R' need σ·T or more.

        Σ_k c_k·f_k·σ^k = R' / R,   c_k = s_k / Σ s_k

    The duration's slope in every L_k follows, as other limits may be wider or narrower.
    """
    _, proof = proof_of(bounds)
    spread = data.draw(st.sampled_from([1e-3, 0.1, 1.0]), label="spread")
    factors = [10.0 ** (spread * data.draw(st.floats(-1.0, 1.0))) for _ in bounds]
    further = 10.0 ** (spread * data.draw(st.floats(-1.0, 1.0)))
    others = [b and b * f for b, f in zip(bounds, factors, strict=True)]
    shares = np.array(proof.sensitivities) / sum(proof.sensitivities)

    def short_of(sigma):
        return float(shares * factors @ sigma ** np.arange(1, len(bounds) + 1)) - further

    sigma = brentq(short_of, 1e-3, 1e3, xtol=1e-14)
    least = sigma * proof.lower_bound
    assert duration(others, further) >= least * (1.0 - ROUNDING), (bounds, factors, further)


@FEW
@given(bounds=BOUNDS, slower=st.sampled_from([None, 1.0 + 1e-6, 1.01, 3.0]))
def test_a_proof_from_a_slower_move_holds_as_well(bounds, slower):
    limits, move = Limits.from_bounds(bounds), optimal(1.0, bounds)
    closed = min_time_move(1.0, limits, method="closed-form")
    proof = certify(move.stretch(slower) if slower else closed, limits)
    assert proof.lower_bound <= move.duration, move_text(1.0, bounds)


# Two problems of which one is easier


@FEW
@given(bounds=BOUNDS, factor=FACTORS)
def test_a_longer_distance_takes_longer_but_not_by_more_than_the_lowest_bound_says(bounds, factor):
    """f^(1/n) ≤ T(f·R) / T(R) ≤ f^(1/m), m the lowest bounded derivative, as motions scale."""
    lowest = next(k for k, bound in enumerate(bounds, start=1) if bound)
    most, least = factor ** (1.0 / lowest), factor ** (1.0 / len(bounds))
    assert duration(bounds, factor) >= proven(bounds) * least * (1.0 - ROUNDING)
    assert duration(bounds) * most >= proven(bounds, factor) * (1.0 - ROUNDING)


@FEW
@given(
    bounds=BOUNDS.filter(lambda bounds: bounds[0]),
    distance=st.floats(0.0, 2.0).map(lambda exponent: 10.0**exponent),
    further=MAGNITUDES,
)
def test_a_longer_cruise_costs_no_more_than_its_own_time(bounds, distance, further):
    """A motion at constant velocity in its middle can go on with it."""
    move, _ = proof_of(bounds, distance)
    _, velocity, *higher = move.evaluate(0.5 * move.duration).tolist()
    assume(not any(higher))
    longer = move.duration + further / velocity
    text = f"{move_text(distance, bounds)}, {further!r} further"
    assert longer >= proven(bounds, distance + further) * (1.0 - ROUNDING), text
    assert duration(bounds, distance + further) <= longer * (1.0 + NEAR), text


@FEW
@given(bounds=BOUNDS, place=PLACES, factor=FACTORS)
def test_a_wider_bound_saves_time_but_no_more_than_its_root(bounds, place, factor):
    """f^(−1/k) ≤ T(f·L_k) / T(L_k) ≤ 1, as motions scale."""
    wider, k = change(bounds, place, lambda bound: bound * factor)
    text = f"{move_text(1.0, bounds)}, derivative {k} by {factor}"
    assert duration(bounds) >= proven(wider) * (1.0 - ROUNDING), text
    assert duration(wider) * factor ** (1.0 / k) >= proven(bounds) * (1.0 - ROUNDING), text
    # and nearly so of the moves themselves
    assert duration(wider) <= duration(bounds) * (1.0 + NEAR), text


@FEW
@given(bounds=BOUNDS.filter(lambda bounds: any(bounds[:-1])), place=PLACES)
def test_a_bound_removed_never_costs_time(bounds, place):
    without, _ = change(bounds[:-1], place, lambda _: None)
    without.append(bounds[-1])
    assert duration(bounds) >= proven(without) * (1.0 - ROUNDING), move_text(1.0, bounds)
    assert duration(without) <= duration(bounds) * (1.0 + NEAR), move_text(1.0, bounds)


@FEW
@given(bounds=BOUNDS.filter(lambda b: not all(b)), place=PLACES, widening=FACTORS)
def test_a_bound_that_the_move_keeps_anyway_changes_nothing(bounds, place, widening):
    free = [k for k, bound in enumerate(bounds) if not bound]
    k = free[place % len(free)]
    move, proof = proof_of(bounds)
    redundant = [move.peak(i + 1) * widening if i == k else b for i, b in enumerate(bounds)]
    assert move.violation(Limits.from_bounds(redundant)) <= BOUND
    text = move_text(1.0, redundant)
    assert proven(redundant) <= move.duration * (1.0 + ROUNDING), text
    assert duration(redundant) >= proof.lower_bound * (1.0 - ROUNDING), text
    assert duration(redundant) == pytest.approx(move.duration, rel=NEAR), text


@FEW
@given(bounds=BOUNDS.filter(lambda bounds: any(bounds[:-1])), ramps=st.floats(-4.0, 0.0))
def test_a_highest_bound_costs_no_more_than_moving_averages(bounds, ramps):
    """T(m) ≤ T(n) ≤ T(m) + (n − m)·w,  w = 2·(L_m / L_n)^(1/(n−m)), for the m below n."""
    below = bounds[:-1]
    while not below[-1]:
        below.pop()
    steps = len(bounds) - len(below)
    width = 10.0**ramps * duration(below)
    high = [*bounds[:-1], below[-1] * (2.0 / width) ** steps]
    text = move_text(1.0, high)
    assert duration(high) >= proven(below) * (1.0 - ROUNDING), text
    assert duration(below) + steps * width >= proven(high) * (1.0 - ROUNDING), text
    assert duration(high) <= (duration(below) + steps * width) * (1.0 + NEAR), text
