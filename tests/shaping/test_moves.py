"""min_time_move, perfect_spline and bound_for_rise_time from outside: identities and bounds."""

import os
import re
from math import factorial, inf, log2, nan
from sys import float_info

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import (
    BOUND,
    CONTINUITY,
    END_POSITION,
    UNITS,
    joint_gaps,
    move_text,
    reference_problems,
    spline_states,
)
from strategies import UNIT_FACTORS, bound_lists
from tiers import some

from jounce.shaping import (
    Limits,
    bound_for_rise_time,
    min_time_move,
    perfect_spline,
    switch_fractions,
)
from jounce.shaping.recursive_s_curve import recursive_s_curve

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
SIGNS = st.sampled_from([-1.0, 1.0])
DIVISORS = [1, 4, 32, 384, 6144, 122880, 2949120, 82575360, 2642411520, 95126814720]
ROUNDING = 4 * np.finfo(float).eps


def make(distance, bounds, *, method="closed-form", **options):
    """Return the move under a list of bounds."""
    return min_time_move(distance, Limits.from_bounds(bounds), method=method, **options)


def assert_sound(move, distance, bounds):
    """Assert end position, bounds and continuity, from the pieces themselves."""
    text = move_text(distance, bounds)
    assert move.start_time == 0.0, text
    assert move.order == len(bounds), text
    assert abs(move.end_state[0] - move.start_state[0] - distance) <= END_POSITION * abs(distance)
    assert abs(move(move.end_time) - move.start_state[0] - distance) <= END_POSITION * abs(distance)
    np.testing.assert_array_equal(move.start_state[1:-1], 0.0, text)
    np.testing.assert_array_equal(move.end_state[1:], 0.0, text)
    assert move.violation(Limits.from_bounds(bounds)) <= BOUND, text
    gaps = joint_gaps(move)
    assert max(gaps) <= CONTINUITY, f"{text}: gaps {gaps}"
    assert move.durations.sum() == pytest.approx(move.duration, rel=1e-14), text


# Every move


@given(bounds=bound_lists(1, 7), distance=SIGNS)
def test_moves_are_sound(bounds, distance):
    assert_sound(make(distance, bounds), distance, bounds)


@pytest.mark.parametrize("subset", some(range(32), 16))
@pytest.mark.parametrize("distance", some([1e-4, 1.0, 1e4], 2))
def test_every_subset_of_bounds_of_order_6(subset, distance):
    full = [3.0 * 4.0**k * factorial(k) for k in range(6)]
    bounds = [b if k == 5 or subset >> k & 1 else None for k, b in enumerate(full)]
    assert_sound(make(distance, bounds), distance, bounds)


@pytest.mark.parametrize("order", some([8, 9, 10], 2))
@pytest.mark.parametrize("seed", range(2))
def test_high_orders_are_sound(order, seed):
    rng = np.random.default_rng(seed)
    bounds = [4.0**k * factorial(k) * 10.0 ** rng.uniform(-0.5, 1.0) for k in range(order)]
    keep = rng.random(order - 1) < 0.5
    bounds[:-1] = [b if kept else None for b, kept in zip(bounds, keep, strict=False)]
    assert_sound(make(1.0, bounds), 1.0, bounds)


@pytest.mark.slow
@pytest.mark.parametrize("order", range(1, 11))
@pytest.mark.parametrize("seed", range(30 if SLOW else 4))
def test_random_moves_are_sound(order, seed):
    rng = np.random.default_rng((order, seed))
    unit = 10.0 ** rng.uniform(-3, 3)
    distance = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6, 6)
    bounds = [
        abs(distance) * unit ** (k + 1) * 4.0**k * factorial(k) * 10.0 ** rng.uniform(-1, 1.5)
        if k == order - 1 or rng.random() < 0.6 else None
        for k in range(order)
    ]  # fmt: skip
    assert_sound(make(distance, bounds), distance, bounds)


@pytest.mark.slow
@pytest.mark.parametrize("order", some([11, 12, 13, 14], 2))
def test_all_bounds_of_the_highest_orders(order):
    bounds = [3.0 * 4.0**k * factorial(k) for k in range(order)]
    move = make(1.0, bounds)
    assert move.violation(Limits.from_bounds(bounds)) <= 1e-10
    assert move.end_state[0] == pytest.approx(1.0, rel=1e-10)


@given(
    bounds=bound_lists(1, 6),
    distance_unit=UNIT_FACTORS,
    time_unit=UNIT_FACTORS,
    sign=SIGNS,
)
def test_units_do_not_matter(bounds, distance_unit, time_unit, sign):
    """In units of r and t a bound on derivative k is r/t^k times the number."""
    scaled = [b and b * distance_unit / time_unit**k for k, b in enumerate(bounds, start=1)]
    move, other = make(sign, bounds), make(sign * distance_unit, scaled)
    assert other.duration == pytest.approx(move.duration * time_unit, rel=UNITS)
    assert len(other.breaks) == len(move.breaks)
    for k in range(1, len(bounds) + 1):
        peak = move.peak(k) * distance_unit / time_unit**k
        assert other.peak(k) == pytest.approx(peak, rel=UNITS), f"derivative {k}"
    assert other.end_state[0] == sign * distance_unit


@given(bounds=bound_lists(1, 6), start=st.floats(-1e6, 1e6), distance=st.floats(-1e3, 1e3))
def test_start_only_shifts(bounds, start, distance):
    if abs(distance) < 1e-3:
        distance = 1.0
    move, moved = make(distance, bounds), make(distance, bounds, start=start)
    np.testing.assert_array_equal(moved.breaks, move.breaks)
    np.testing.assert_array_equal(moved.states[:, 1:], move.states[:, 1:])
    assert moved.start_state[0] == start
    rounding = ROUNDING * (abs(start) + abs(distance))
    assert abs(moved.end_state[0] - (start + distance)) <= rounding
    assert moved.violation(Limits.from_bounds(bounds)) <= BOUND


@given(bounds=bound_lists(1, 7))
def test_the_opposite_move_is_the_mirror_image(bounds):
    forth, back = make(1.0, bounds), make(-1.0, bounds)
    np.testing.assert_array_equal(back.states, -forth.states)
    np.testing.assert_array_equal(back.end_state, -forth.end_state)
    np.testing.assert_array_equal(back.breaks, forth.breaks)


@given(bounds=bound_lists(1, 7))
def test_a_move_run_backwards_is_the_opposite_move(bounds):
    """Equal bounds both ways: x(t) = R − x(T − t)."""
    move = make(1.0, bounds)
    again = move.reverse().mirror().shift(1.0)
    t = np.linspace(-0.1, 1.1, 97) * move.duration
    for k in range(len(bounds)):  # times round, too, and count with the slope
        rounding = 1e-12 * move.peak(k) + ROUNDING * move.duration * move.peak(k + 1)
        np.testing.assert_allclose(
            again(t, k), move(t, k), rtol=0, atol=rounding, err_msg=f"derivative {k}"
        )


@given(bounds=bound_lists(1, 7), factor=st.sampled_from([1.0 + 1e-9, 1.01, 2.0, 1e3]))
def test_a_longer_distance_takes_longer(bounds, factor):
    shorter, longer = make(1.0, bounds), make(factor, bounds)
    assert longer.duration >= shorter.duration * (1.0 - ROUNDING)


@given(
    bounds=bound_lists(1, 3),
    place=st.integers(0, 2),
    factor=st.sampled_from([1.0 + 1e-9, 1.01, 2.0, 1e3]),
)
def test_a_wider_bound_never_slows_a_move_of_order_3(bounds, place, factor):
    wider = list(bounds)
    k = min(place, len(bounds) - 1)
    wider[k] = bounds[k] and bounds[k] * factor
    slow, fast = make(1.0, bounds), make(1.0, wider)
    assert fast.duration <= slow.duration * (1.0 + ROUNDING), f"{bounds!r} to {wider!r}"


@given(bounds=bound_lists(4, 7))
def test_no_move_beats_the_same_move_without_a_lower_bound(bounds):
    """The perfect spline of each single bound is optimal for it: a lower limit on any duration."""
    move = make(1.0, bounds)
    for order, bound in enumerate(bounds, start=1):
        if bound:
            least = perfect_spline(1.0, order, bound).duration
            assert move.duration >= least * (1.0 - ROUNDING), f"derivative {order}"


@pytest.mark.parametrize(
    "problem", [pytest.param(problem, id=problem.name) for problem in reference_problems()]
)
def test_reference_problems_are_solved_soundly(problem):
    bounds = [None if bound == inf else bound for bound in problem.bounds]
    move = make(problem.distance, bounds)
    assert_sound(move, problem.distance, bounds)
    assert move.duration >= problem.lower * (1.0 - 1e-9)
    assert move.duration <= problem.recursion * (1.0 + 1e-12)


# Extremes of the bounds


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_a_huge_highest_bound_gives_the_move_of_one_order_less(order):
    """T(n−1) ≤ T(n) ≤ T(n−1) + 2·L(n−1)/L(n): ramps of a 1e-9 of the duration."""
    lower = [1.0, 2.0, 9.0, 60.0, 500.0][: order - 1]
    bounds = [*lower, 1e9 * lower[-1]]
    move, limit = make(3.0, bounds), make(3.0, lower)
    assert_sound(move, 3.0, bounds)
    assert limit.duration <= move.duration <= limit.duration + 2.0e-9
    if order <= 3:
        assert move.duration == pytest.approx(limit.duration + 1e-9, rel=1e-15)


@pytest.mark.parametrize("order", [3, 4, 6])
@pytest.mark.parametrize("seed", range(8))
def test_bounds_twelve_decades_apart(order, seed):
    rng = np.random.default_rng(seed)
    bounds = list(10.0 ** rng.uniform(-6.0, 6.0, order))
    distance = 10.0 ** rng.uniform(-6.0, 6.0)
    assert_sound(make(distance, bounds), distance, bounds)


@pytest.mark.parametrize("order", [3, 4, 5, 6])
def test_redundant_and_just_active_bounds(order):
    """Bounds exactly at the free move's peaks, or beyond them, change nothing."""
    free = perfect_spline(1.0, order, 7.0)
    peaks = [free.peak(k) for k in range(1, order + 1)]
    for widening in (1.0 + 1e-12, 1.0 + 1e-6, 1e6):
        bounds = [*(peak * widening for peak in peaks[:-1]), 7.0]
        assert make(1.0, bounds).duration == pytest.approx(free.duration, rel=1e-12), bounds
        assert_sound(make(1.0, bounds), 1.0, bounds)
    for k in range(order - 1):
        bounds = [*[None] * (order - 1), 7.0]
        bounds[k] = peaks[k] * (1.0 - 1e-9)
        barely = make(1.0, bounds)
        assert_sound(barely, 1.0, bounds)
        assert barely.duration >= free.duration * (1.0 - ROUNDING)


@pytest.mark.parametrize("nudge", [-1e-15, 0.0, 1e-15, 1e-12, -1e-12, 1e-9, -1e-9])
@pytest.mark.parametrize("distance", [2.0, 4.0, 8.0])
def test_moves_on_the_border_between_two_cases(distance, nudge):
    """R = 2 with A = W = 1 is the border of cases 1 and 2; V = 2 that of cases 2 and 4 at R = 8."""
    for bounds in ([2.0, 1.0, 1.0], [1.0, 1.0, 1.0], [2.0, 1.0], [None, 1.0, 1.0]):
        move = make(distance * (1.0 + nudge), bounds)
        assert_sound(move, distance * (1.0 + nudge), bounds)
        exact = make(distance, bounds).duration
        assert move.duration == pytest.approx(exact, rel=2.0 * abs(nudge) + 1e-15)


@pytest.mark.parametrize("exponents", [(-300, 300), (300, -300), (-150, 150), (5, -308)])
@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
def test_at_the_ends_of_a_double_a_duration_is_right_or_refused(order, exponents):
    distance, bound = (10.0**exponent for exponent in exponents)
    with mpmath.workdps(30):
        ratio = mpmath.mpf(distance) / mpmath.mpf(bound) * DIVISORS[order - 1]
        expected = float(mpmath.root(ratio, order))
    bounds = [*[None] * (order - 1), bound]
    refused = ""
    try:
        move = make(distance, bounds)
    except ValueError as error:
        refused = str(error)
    if refused:
        assert "duration" in refused, refused
    else:
        assert 0.0 < expected < inf, f"{move_text(distance, bounds)} has no duration in a double"
        assert move.duration == pytest.approx(expected, rel=1e-13), move_text(distance, bounds)
        assert move.end_state[0] == distance


# Published values


@pytest.mark.parametrize(
    ("bounds", "seconds"),
    [((10.5, 10.5, 42.0), 1.4314539066), ((5.25, 5.25, 21.0), 1.9020189668)],
    ids=["azimuth", "elevation"],
)
def test_rubin_slews(bounds, seconds):
    assert make(3.5, bounds).duration == pytest.approx(seconds, abs=5e-11)


def test_thompsons_rise_time_of_one_second():
    assert bound_for_rise_time(0.2, 1.0, 6) == pytest.approx(76.8, rel=1e-15)


@pytest.mark.parametrize("order", range(3, 9))
@pytest.mark.parametrize("rise_time", [0.3, 1.0, 40.0])
def test_a_rise_time_is_what_acceleration_takes(order, rise_time):
    bound = bound_for_rise_time(0.2, rise_time, order)
    bounds = [None, 0.2, *[None] * (order - 3), bound]
    move = make(1e4 * rise_time**2, bounds)
    below = move(0.999 * rise_time, "acceleration")
    assert below < 0.2
    assert move(1.001 * rise_time, "acceleration") == pytest.approx(0.2, rel=1e-12)
    assert_sound(move, 1e4 * rise_time**2, bounds)
    # The ramp is itself a perfect spline of order n − 2.
    assert perfect_spline(0.2, order - 2, bound).duration == pytest.approx(rise_time, rel=1e-14)


# The perfect spline


@pytest.mark.parametrize("order", some(range(1, 11), 5))
@pytest.mark.parametrize(("distance", "bound"), [(1.0, 1.0), (-32.0, 0.1), (1e-5, 1e7)])
def test_perfect_spline(order, distance, bound):
    move = perfect_spline(distance, order, bound)
    duration = (abs(distance) * DIVISORS[order - 1] / bound) ** (1 / order)
    assert move.duration == pytest.approx(duration, rel=1e-14)
    sign = np.sign(distance) * (-1.0) ** np.arange(order)
    np.testing.assert_array_equal(move.states[:, -1], sign * bound)
    np.testing.assert_allclose(
        move.breaks, move.duration * switch_fractions(order), rtol=1e-14, atol=1e-15 * duration
    )
    np.testing.assert_allclose(
        move.breaks + move.breaks[::-1], move.duration, rtol=ROUNDING, err_msg="symmetry"
    )
    assert_sound(move, distance, [*[None] * (order - 1), bound])


@pytest.mark.parametrize("order", [*range(1, 11), 15, 20])
def test_perfect_spline_matches_its_integration_in_60_digits(order):
    _, states = spline_states(order)
    move = perfect_spline(1.0, order, float(factorial(order - 1) * 4 ** (order - 1)))
    assert move.duration == pytest.approx(1.0, rel=1e-14)
    tolerance = 1e-14 if order <= 10 else 1e-9
    for k in range(order + 1):
        exact = np.array([float(state[k]) for state in states[:-1]])
        np.testing.assert_allclose(
            move.states[:, k], exact, rtol=0, atol=tolerance * np.abs(exact).max(),
            err_msg=f"derivative {k}",
        )  # fmt: skip


@pytest.mark.parametrize("order", range(1, 11))
def test_with_only_the_highest_bounded_the_move_is_the_perfect_spline(order):
    bounds = [*[None] * (order - 1), 3.0]
    move, spline = make(2.0, bounds), perfect_spline(2.0, order, 3.0)
    np.testing.assert_allclose(move.breaks, spline.breaks, rtol=1e-14)
    for k in range(order + 1):
        np.testing.assert_allclose(
            move.states[:, k], spline.states[:, k], rtol=0, atol=1e-13 * spline.peak(k),
            err_msg=f"derivative {k}",
        )  # fmt: skip


def test_perfect_spline_starts_anywhere():
    move = perfect_spline(-2.0, 4, 1.0, start=7.0)
    assert (move.start_state[0], move.end_state[0]) == (7.0, 5.0)
    assert perfect_spline(0.0, 4, 1.0, start=7.0).extremes(0) == (7.0, 7.0)


# The recursion of the field


@pytest.mark.parametrize(
    "problem", [pytest.param(problem, id=problem.name) for problem in reference_problems()]
)
def test_the_recursion_takes_as_long_as_published(problem):
    bounds = [None if bound == inf else bound for bound in problem.bounds]
    move = recursive_s_curve(problem.distance, Limits.from_bounds(bounds))
    assert_sound(move, problem.distance, bounds)
    assert move.duration == pytest.approx(problem.recursion, rel=1e-9)


@given(bounds=bound_lists(1, 3), sign=SIGNS)
def test_up_to_jerk_the_recursion_is_the_fastest(bounds, sign):
    limits = Limits.from_bounds(bounds)
    move = recursive_s_curve(sign, limits, start=2.0)
    fastest = min_time_move(sign, limits, start=2.0)
    assert move.duration == pytest.approx(fastest.duration, rel=1e-12), move_text(sign, bounds)
    assert move.end_state[0] == fastest.end_state[0] == 2.0 + sign


@pytest.mark.parametrize("order", range(1, 13))
def test_with_only_the_highest_bounded_the_recursion_has_equal_steps(order):
    """T = (2^(n(n+1)/2−1)·R/D)^(1/n): each order doubles the distance of half the time's steps."""
    limits = Limits.from_bounds([None] * (order - 1) + [5.0])
    move = recursive_s_curve(3.0, limits)
    expected = (2.0 ** (order * (order + 1) / 2 - 1) * 3.0 / 5.0) ** (1.0 / order)
    assert move.duration == pytest.approx(expected, rel=1e-13)
    shortest = 2.0 ** -max(order - 1, 0) * move.duration
    steps = move.durations / shortest
    assert steps == pytest.approx(np.round(steps), rel=1e-9)


def test_the_recursion_refuses_what_a_move_does():
    with pytest.raises(TypeError, match="expected Limits"):
        recursive_s_curve(1.0, 2.0)
    with pytest.raises(ValueError, match="distance"):
        recursive_s_curve(nan, Limits(jerk=1.0))
    with pytest.raises(ValueError, match="limits of order 15"):
        recursive_s_curve(1.0, Limits.from_bounds([None] * 14 + [1.0]))
    assert recursive_s_curve(0.0, Limits(snap=1.0), start=3.0).duration == 0.0


# Numbers at the ends of the doubles

MOST = float_info.max


@pytest.mark.parametrize("method", ["closed-form", "optimal"])
@pytest.mark.parametrize("distance", [5e-324, 1e-310])
def test_the_least_distances_are_moves_of_the_highest_bound_alone(distance, method):
    move = min_time_move(distance, Limits(1.0, 2.0, 3.0, 4.0), method=method)
    expected = 2.0 ** ((log2(384.0 / 4.0) + log2(distance)) / 4.0)
    assert move.duration == pytest.approx(expected, rel=1e-12)
    assert move(move.duration) == distance


@pytest.mark.parametrize(
    ("limits", "duration"),
    [
        (Limits(1e200, 1e200, 1e200, 1.0), 5.2642960518),
        (Limits(MOST, MOST, MOST, 1.0), 5.2642960518),
        (Limits(MOST, MOST, 1.0), 4.0),
        (Limits(1.0, 1.0, MOST), 3.0),
        (Limits(1.0, MOST, MOST), 2.0),
    ],
)
def test_bounds_that_can_never_bind_are_none(limits, duration):
    assert min_time_move(2.0, limits).duration == pytest.approx(duration, rel=1e-10)


@pytest.mark.parametrize("order", some(range(1, 7), 4))
@pytest.mark.parametrize("exponent", [-220, 220])
def test_units_far_from_one_change_nothing(order, exponent):
    bounds = [1.0, 2.0, 5.0, 30.0, 200.0, 2000.0][:order]
    unit = 10.0**exponent
    move = min_time_move(3.0 * unit, Limits.from_bounds([bound * unit for bound in bounds]))
    near = min_time_move(3.0, Limits.from_bounds(bounds))
    assert move.duration == pytest.approx(near.duration, rel=1e-9)
    assert move.end_state[0] == 3.0 * unit


@pytest.mark.parametrize(
    ("distance", "limits", "duration"),
    [
        (5e-324, Limits(1.0, (-2.0, 1.0), 1.0), 5.4e-108),
        (0.1 + 0.2 - 0.3, Limits(1.0, (-2.0, 1.0), 1.7e308), 1.2905e-8),
        (2e200, Limits((-2e200, 3e200), (-4e200, 5e200)), 1.3416407865),
    ],
)
def test_searches_end(distance, limits, duration):
    assert min_time_move(distance, limits).duration == pytest.approx(duration, rel=2e-2)


# What is refused


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_distance_and_start_must_be_finite(value):
    limits = Limits(jerk=1.0)
    with pytest.raises(ValueError, match=re.escape(f"distance = {value!r}: expected a finite")):
        min_time_move(value, limits)
    with pytest.raises(ValueError, match=re.escape(f"start = {value!r}: expected a finite")):
        min_time_move(1.0, limits, start=value)
    with pytest.raises(ValueError, match=re.escape(f"distance = {value!r}: expected a finite")):
        perfect_spline(value, 3, 1.0)
    with pytest.raises(ValueError, match=re.escape(f"start = {value!r}: expected a finite")):
        perfect_spline(1.0, 3, 1.0, start=value)


def test_an_unknown_method_is_refused():
    with pytest.raises(ValueError, match=r"method = 'fastest': expected .*'closed-form'"):
        min_time_move(1.0, Limits(jerk=1.0), method="fastest")


def test_an_order_above_14_is_refused():
    with pytest.raises(ValueError, match="limits of order 15: expected at most 14"):
        make(1.0, [*[None] * 14, 1.0])
    assert make(1.0, [*[None] * 13, 1.0]).order == 14


@pytest.mark.parametrize(
    ("bounds", "distance", "name"),
    [
        ([(-1.0, inf)], 1.0, "velocity"),
        ([(-inf, 1.0)], -1.0, "velocity"),
        ([1.0, (-1.0, inf)], 1.0, "acceleration"),
        ([None, (-inf, 1.0)], 1.0, "acceleration"),
        ([1.0, 1.0, (-inf, 1.0)], -1.0, "jerk"),
    ],
)
def test_a_highest_bound_in_one_direction_only_is_refused(bounds, distance, name):
    with pytest.raises(ValueError, match=f"{name} is bounded in one direction only"):
        make(distance, bounds)


def test_a_velocity_bound_in_the_direction_of_the_move_is_enough():
    assert make(-6.0, [(-2.0, inf)]).duration == pytest.approx(3.0)
    assert make(6.0, [(-inf, 2.0)]).duration == pytest.approx(3.0)


@pytest.mark.parametrize("distance", [100.0, -100.0])
def test_from_order_4_closed_forms_use_pairs_by_averages_of_the_exact_lower_order(distance):
    pairs = [(-3.0, 1.5), (-2.0, 8.0), (-90.0, 30.0), (-900.0, 1200.0)]
    move = make(distance, pairs)
    assert move.violation(Limits.from_bounds(pairs)) <= BOUND
    velocity = 1.5 if distance > 0 else 3.0
    assert move.peak("velocity") == pytest.approx(velocity, rel=1e-14)
    assert move.duration < make(distance, [velocity, 2.0, 30.0, 900.0]).duration
    exact = make(distance, pairs[:3]).duration
    assert exact < move.duration <= exact + 120.0 / 900.0 * (1.0 + 1e-12)


def test_zero_distance_is_a_point_of_the_limits_order():
    for order in range(1, 8):
        move = make(0.0, [1.0] * order, start=-3.0)
        assert (move.duration, move.order) == (0.0, order)
        assert move.end_state.tolist() == [-3.0, *[0.0] * order]


@pytest.mark.parametrize("order", [0, -1, 41, 2.5, nan, inf])
def test_perfect_spline_refuses_what_is_no_order(order):
    with pytest.raises(ValueError, match=re.escape(f"order = {order!r}: expected a whole number")):
        perfect_spline(1.0, order, 1.0)


@pytest.mark.parametrize("value", [0.0, -1.0, nan, inf])
def test_bounds_and_times_must_be_positive(value):
    expected = re.escape(f"= {value!r}: expected a positive, finite number")
    with pytest.raises(ValueError, match="bound " + expected):
        perfect_spline(1.0, 3, value)
    with pytest.raises(ValueError, match="acceleration " + expected):
        bound_for_rise_time(value, 1.0, 6)
    with pytest.raises(ValueError, match="rise_time " + expected):
        bound_for_rise_time(1.0, value, 6)


@pytest.mark.parametrize("order", [2, 1, 0, 41])
def test_a_rise_time_needs_order_3_or_more(order):
    with pytest.raises(ValueError, match=f"order = {order}: expected"):
        bound_for_rise_time(1.0, 1.0, order)


@pytest.mark.parametrize(
    ("distance", "bounds"), [(600.0, (60, 60, 0.2, 1e14)), (40.0, (50.0, 0.1, 1.0, 0.2, 1e14))]
)
def test_a_practically_unlimited_highest_derivative_is_no_obstacle(distance, bounds):
    """Once refused: rounding made a break step backwards."""
    limits = Limits.from_bounds(bounds)
    move = min_time_move(distance, limits)
    assert move.violation(limits) <= BOUND
    assert np.all(np.diff(move.breaks) >= 0)
    assert move.end_state[0] == distance


@pytest.mark.parametrize("limits", [{"jerk": 1.0}, 2.0, None])
def test_limits_of_another_kind_are_refused(limits):
    with pytest.raises(TypeError, match="expected Limits"):
        min_time_move(1.0, limits)


def test_a_rise_time_out_of_range_is_refused():
    with pytest.raises(ValueError, match=r"rise_time = 1e-200: .* leaves the range"):
        bound_for_rise_time(1.0, 1e-200, 6)
