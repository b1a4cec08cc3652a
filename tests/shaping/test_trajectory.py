"""Trajectory: evaluation against scipy and mpmath, exact extremes, the algebra as functions."""

import copy
import dataclasses
import pickle
import re
from math import inf, nan, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import as_ppoly, magnitude, piece_value, polynomial_extremes
from strategies import any_trajectory, smooth_trajectory

from jounce.shaping import Limits, Trajectory, min_time_move

SEEDS = st.integers(0, 2**32 - 1)
ORDERS = st.integers(1, 10)


def inside(trajectory, per_piece=7):
    """Return times strictly inside the pieces, in order."""
    fractions = (np.arange(per_piece) + 0.5) / per_piece
    starts, durations = trajectory.breaks[:-1], trajectory.durations
    return (starts[:, None] + durations[:, None] * fractions).ravel()


def around(trajectory):
    """Return times before, inside (not on a break) and after."""
    outside = np.array([0.1, 0.9, 7.0])
    return np.concatenate([
        trajectory.start_time - outside[::-1], inside(trajectory), trajectory.end_time + outside
    ])  # fmt: skip


def assert_same_function(got, expected, t, derivatives, scale=1.0):
    """Assert that two functions of (t, derivative) agree to rounding."""
    for k in derivatives:
        np.testing.assert_allclose(
            got(t, k), expected(t, k), rtol=1e-12, atol=1e-12 * scale, err_msg=f"derivative {k}"
        )


# Evaluation


@given(seed=SEEDS, order=ORDERS)
def test_every_derivative_matches_scipys_ppoly(seed, order):
    trajectory = any_trajectory(seed, order)
    reference, t = as_ppoly(trajectory), inside(trajectory)
    for k in range(order + 1):
        scale = magnitude(trajectory, k)
        np.testing.assert_allclose(
            trajectory(t, k), reference(t, k), rtol=0, atol=1e-13 * scale, err_msg=f"derivative {k}"
        )


@given(seed=SEEDS, order=ORDERS)
def test_every_derivative_matches_mpmath(seed, order):
    trajectory = any_trajectory(seed, order, pieces=2)
    for i, t in enumerate(trajectory.breaks[:-1] + 0.625 * trajectory.durations):
        tau = float(t) - float(trajectory.breaks[i])
        for k in range(order + 1):
            expected = float(piece_value(trajectory.states[i], tau, k))
            error = abs(trajectory(t, k) - expected)
            assert error <= 1e-15 * magnitude(trajectory, k), f"derivative {k} at {t!r}"


@given(seed=SEEDS, order=ORDERS)
def test_all_ways_to_evaluate_agree(seed, order):
    trajectory = any_trajectory(seed, order)
    edges = trajectory.breaks
    t = np.concatenate([around(trajectory), edges, np.nextafter(edges, -inf)])
    expected = np.array([[trajectory(float(s), k) for s in t] for k in range(order + 1)])
    np.testing.assert_array_equal(trajectory.evaluate(t), expected)
    np.testing.assert_array_equal(trajectory.evaluate(t[::-1]), expected[:, ::-1])
    assert trajectory.evaluate(t[0]).shape == (order + 1,)
    pairs = t[: len(t) // 2 * 2].reshape(2, -1)
    np.testing.assert_array_equal(
        trajectory.evaluate(pairs), expected[:, : pairs.size].reshape(-1, *pairs.shape)
    )
    many = np.tile(t, 9000 // len(t) + 1)
    scales = np.array([magnitude(trajectory, k) for k in range(order + 1)]) * 1e4
    np.testing.assert_array_equal(trajectory.evaluate(many), np.tile(expected, 9000 // len(t) + 1))
    ranks = np.argsort(many, kind="stable")
    swept = trajectory.evaluate(many[ranks])
    error = np.abs(swept - trajectory.evaluate(many)[:, ranks]).max(axis=1)
    assert (error <= 1e-15 * scales).all(), error / scales


def test_a_long_sorted_array_crosses_blocks_and_pieces():
    trajectory = smooth_trajectory(3, 6, pieces=40)
    t = np.linspace(trajectory.start_time - 1.0, trajectory.end_time + 1.0, 50_001)
    parts = np.concatenate([trajectory.evaluate(part) for part in np.array_split(t, 20)], axis=1)
    np.testing.assert_allclose(trajectory.evaluate(t), parts, rtol=1e-12, atol=1e-12)


def test_scalars_and_shapes():
    trajectory = any_trajectory(1, 3)
    assert np.ndim(trajectory(0.0)) == 0
    assert isinstance(float(trajectory(0.0, "jerk")), float)
    assert trajectory(np.zeros((2, 3, 4)), "velocity").shape == (2, 3, 4)
    assert trajectory(np.zeros((2, 0))).shape == (2, 0)
    assert trajectory([0.0, 1.0], 9).tolist() == [0.0, 0.0]
    assert trajectory(0.0, 9) == 0.0
    np.testing.assert_array_equal(trajectory([0, 1], "jerk"), trajectory([0.0, 1.0], 3))


def test_a_break_belongs_to_the_piece_after_it():
    trajectory = Trajectory([0.0, 1.0, 3.0], [[0.0, 1.0], [5.0, 2.0]])
    assert trajectory([0.0, 1.0, 3.0]).tolist() == [0.0, 5.0, 9.0]
    assert trajectory(np.nextafter(1.0, 0.0)) == pytest.approx(1.0)
    assert trajectory([-1.0, 0.0, 1.0, 3.0], "velocity").tolist() == [0.0, 1.0, 2.0, 0.0]


@given(seed=SEEDS, order=ORDERS)
def test_derivatives_are_trajectories_inside_and_outside(seed, order):
    trajectory = any_trajectory(seed, order)
    t = np.concatenate([around(trajectory), trajectory.breaks])
    for k in range(1, order):
        slope = trajectory.derivative(k)
        assert slope.order == order - k
        for j in range(order - k + 2):
            np.testing.assert_array_equal(slope(t, j), trajectory(t, k + j), f"{k} + {j}")
        for j in range(1, order - k):
            twice = slope.derivative(j)
            np.testing.assert_array_equal(twice(t), trajectory(t, k + j), f"{k}, then {j}")


@pytest.mark.parametrize("k", [0, -1, 3, 4])
def test_derivative_refuses_what_leaves_no_polynomial(k):
    with pytest.raises(
        ValueError, match=rf"derivative {k} of a trajectory of order 3: expected 1 to n"
    ):
        any_trajectory(0, 3).derivative(k)


@given(seed=SEEDS, order=st.integers(2, 8))
def test_it_coasts_outside(seed, order):
    trajectory = any_trajectory(seed, order)
    for edge, state, side in (
        (trajectory.start_time, trajectory.start_state, -1.0),
        (trajectory.end_time, trajectory.end_state, 1.0),
    ):
        away = side * np.array([1e-3, 1.0, 1e3])
        np.testing.assert_allclose(
            trajectory(edge + away), state[0] + state[1] * away, rtol=1e-13, atol=1e-12
        )
        np.testing.assert_array_equal(trajectory(edge + away, 1), state[1])
        for k in range(2, order + 1):
            np.testing.assert_array_equal(trajectory(edge + away, k), 0.0)


def test_order_1_stands_still_outside():
    trajectory = Trajectory([0.0, 2.0], [[1.0, 3.0]])
    assert trajectory([-5.0, 0.0, 1.0, 2.0, 9.0]).tolist() == [1.0, 1.0, 4.0, 7.0, 7.0]
    assert trajectory([-5.0, 9.0], 1).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("t", [nan, inf, [0.0, nan], [[-inf, 0.0]]])
def test_times_must_be_finite(t):
    with pytest.raises(ValueError, match="times must be finite"):
        any_trajectory(0, 2)(t)


# Sampling


@pytest.mark.parametrize(
    ("duration", "dt", "expected"),
    [
        (1.0, 0.25, [0.0, 0.25, 0.5, 0.75, 1.0]),
        (1.0, 0.3, [0.0, 0.3, 0.6, 0.9, 1.0]),
        (1.0, 1.0, [0.0, 1.0]),
        (1.0, 5.0, [0.0, 1.0]),
        (0.3, 0.1, [0.0, 0.1, 0.2, 0.3]),  # 0.3 / 0.1 is just below 3
        (0.7, 0.1, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]),
        (3 * 0.1, 0.1, [0.0, 0.1, 0.2, 0.3]),  # just above 0.3
    ],
)
@pytest.mark.parametrize("start", [0.0, -2.0])
def test_sample_takes_both_ends(start, duration, dt, expected):
    trajectory = Trajectory([start, start + duration], [[1.0, 2.0, 3.0]])
    times, states = trajectory.sample(dt)
    np.testing.assert_allclose(times, start + np.array(expected), rtol=1e-15, atol=1e-15)
    assert times[0] == trajectory.start_time
    assert times[-1] == trajectory.end_time
    assert states.shape == (3, len(times))
    np.testing.assert_array_equal(states[:, 0], trajectory.start_state)
    np.testing.assert_array_equal(states[:, -1], trajectory.end_state)
    np.testing.assert_array_equal(states[:, :-1], trajectory.evaluate(times[:-1]))


@pytest.mark.parametrize("count", [3, 7, 1000, 99_999])
def test_sample_of_a_whole_number_of_intervals_has_no_sliver(count):
    trajectory = Trajectory([0.0, 1.7], [[0.0, 1.0]])
    times, _ = trajectory.sample(1.7 / count)
    assert len(times) == count + 1
    assert np.diff(times).min() > 0.5 * 1.7 / count


@pytest.mark.parametrize("dt", [0.0, -1.0, nan, inf])
def test_sample_refuses_what_is_no_interval(dt):
    with pytest.raises(ValueError, match=re.escape(f"dt = {dt!r}: expected a positive, finite")):
        any_trajectory(0, 2).sample(dt)


# Extremes


@given(seed=SEEDS, order=ORDERS)
def test_extremes_are_never_passed_and_attained(seed, order):
    trajectory = any_trajectory(seed, order)
    t = inside(trajectory, 200)
    for k in range(order + 1):
        scale, values = magnitude(trajectory, k), trajectory(t, k)
        low, high = trajectory.extremes(k)
        assert low <= values.min() + 1e-15 * scale
        assert high >= values.max() - 1e-15 * scale
        pairs = [
            polynomial_extremes(state, duration, k)
            for state, duration in zip(trajectory.states, trajectory.durations, strict=True)
        ]
        expected = min(p[0] for p in pairs), max(p[1] for p in pairs)
        assert (low, high) == pytest.approx(expected, rel=0, abs=1e-12 * scale), f"derivative {k}"
        assert trajectory.peak(k) == max(-low, high, 0.0)


def test_extremes_of_a_minimum_jerk_move_lie_inside():
    move = Trajectory([0.0, 1.0], [[0.0, 0.0, 0.0, 60.0, -360.0, 720.0]])
    assert move.extremes("position") == (0.0, 1.0)
    assert move.peak("velocity") == pytest.approx(15 / 8, rel=1e-14)
    bent = 10 / sqrt(3)
    assert move.extremes("acceleration") == pytest.approx((-bent, bent), rel=1e-14)
    assert move.extremes("jerk") == pytest.approx((-30.0, 60.0), rel=1e-14)
    assert move.peak(9) == 0.0


def test_violation_looks_at_each_direction():
    # Velocity from +3 down to −1, acceleration −2.
    trajectory = Trajectory([0.0, 2.0], [[0.0, 3.0, -2.0]])
    assert trajectory.violation(Limits(velocity=3.0, acceleration=2.0)) == 0.0
    assert trajectory.violation(Limits(velocity=(-1.0, 3.0))) == 0.0
    assert trajectory.violation(Limits(velocity=(-3.0, 1.0))) == pytest.approx(2.0)
    assert trajectory.violation(Limits(velocity=(-0.5, 3.0))) == pytest.approx(1.0)
    assert trajectory.violation(Limits(acceleration=(-1.6, 9.0))) == pytest.approx(0.25)
    assert trajectory.violation(Limits(acceleration=(-2.0, 1e-9))) == 0.0
    assert trajectory.violation(Limits(velocity=(-inf, 2.0), jerk=1.0)) == pytest.approx(0.5)
    assert trajectory.mirror().violation(Limits(velocity=(-3.0, 1.0))) == 0.0


def test_violation_sees_what_samples_at_breaks_do_not():
    bump = Trajectory([0.0, 2.0], [[0.0, 0.0, 1.0, -1.0]])  # velocity t − t²/2: 0, 1/2, 0
    assert bump.violation(Limits(velocity=0.4)) == pytest.approx(0.25)


def test_switch_times_are_where_the_highest_derivative_changes():
    held = Trajectory([0.0, 1.0, 2.0, 3.0], [[0, 0, 2.0], [1, 2, 2.0], [4, 4, -4.0]])
    assert held.switch_times.tolist() == [0.0, 2.0, 3.0]
    move = min_time_move(10.0, Limits(velocity=1.0, acceleration=1.0))
    assert move.switch_times.tolist() == [0.0, 1.0, 10.0, 11.0]


# The algebra


@given(seed=SEEDS, order=ORDERS)
def test_shift_delay_scale_mirror_are_what_they_say(seed, order):
    x = smooth_trajectory(seed, order)
    t, derivatives = around(x), range(order + 1)
    scale = max(x.peak(k) for k in derivatives) + 100.0
    assert_same_function(x.shift(3.0), lambda t, k: x(t, k) + 3.0 * (k == 0), t, derivatives, scale)
    assert_same_function(x.scale(-2.5), lambda t, k: -2.5 * x(t, k), t, derivatives, scale)
    assert_same_function(x.mirror(), lambda t, k: -x(t, k), t, derivatives, scale)
    later = x.delay(1.5)
    assert later.start_time == x.start_time + 1.5
    assert_same_function(lambda t, k: later(t + 1.5, k), x, t, derivatives, scale)


@given(seed=SEEDS, order=ORDERS, factor=st.sampled_from([1e-3, 0.5, 1.0, 3.0, 1e3]))
def test_stretch_slows_down_and_composes(seed, order, factor):
    x = smooth_trajectory(seed, order)
    t, start = around(x), x.start_time
    slow = x.stretch(factor)
    assert slow.start_time == start
    assert slow.duration == pytest.approx(factor * x.duration, rel=1e-13)
    for k in range(order + 1):
        got = slow(start + factor * (t - start), k) * factor**k
        np.testing.assert_allclose(got, x(t, k), rtol=1e-9, atol=1e-10 * (magnitude(x, k) + 10))
    twice, once = x.stretch(factor).stretch(0.3), x.stretch(factor * 0.3)
    np.testing.assert_allclose(twice.breaks, once.breaks, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(twice.states, once.states, rtol=1e-13)


@pytest.mark.parametrize("factor", [0.0, -1.0, nan, inf])
def test_stretch_refuses_what_is_no_factor(factor):
    with pytest.raises(ValueError, match=re.escape(f"factor = {factor!r}: expected a positive")):
        any_trajectory(0, 2).stretch(factor)


@pytest.mark.parametrize("value", [nan, inf])
def test_shift_delay_scale_refuse_what_is_not_finite(value):
    x = any_trajectory(0, 2)
    for change in (x.shift, x.delay, x.scale):
        with pytest.raises(ValueError, match=r"must be finite|expected a finite"):
            change(value)


def assert_reversed(x):
    """Assert that x.reverse() is t ↦ x(start + end − t), and that it undoes itself."""
    back, t = x.reverse(), around(x)
    total = x.start_time + x.end_time
    for k in range(x.order + 1):
        np.testing.assert_allclose(
            back(total - t, k), (-1) ** k * x(t, k), rtol=1e-9,
            atol=1e-11 * (magnitude(x, k) + 10), err_msg=f"derivative {k}",
        )  # fmt: skip
    twice = back.reverse()
    np.testing.assert_allclose(twice.breaks, x.breaks, rtol=0, atol=1e-14)
    assert_same_function(twice, x, t, range(x.order + 1), max(10.0, *np.abs(x.states).ravel()))


@given(seed=SEEDS, order=ORDERS)
def test_reverse_of_a_smooth_motion(seed, order):
    assert_reversed(smooth_trajectory(seed, order))


@given(seed=SEEDS, order=st.integers(1, 6))
def test_reverse_where_lower_derivatives_jump(seed, order):
    assert_reversed(any_trajectory(seed, order))


def test_reverse_of_motions_of_different_order():
    first = min_time_move(1.0, Limits(acceleration=1.0))
    assert_reversed(first.then(min_time_move(1.0, Limits(velocity=1.0, jerk=1.0))))


def test_reversed_order_1_move_goes_back():
    back = Trajectory([0.0, 2.0], [[1.0, 3.0]]).reverse()
    assert back([-1.0, 0.0, 1.0, 2.0, 5.0]).tolist() == [7.0, 7.0, 4.0, 1.0, 1.0]


# Cut short, or gone on with


@given(seed=SEEDS, order=ORDERS, part=st.floats(0.0, 1.0))
def test_until_is_the_motion_before(seed, order, part):
    x = any_trajectory(seed, order)
    time = x.start_time + part * x.duration
    cut, t = x.until(time), inside(x)
    assert (cut.start_time, cut.end_time) == (x.start_time, time)
    before = np.concatenate([t[t < time], [x.start_time - 1.0]])
    # in the last piece a time that rounds to its end may be the end
    before = before[np.abs(before - time) > 1e-12]
    for k in range(order + 1):
        np.testing.assert_allclose(
            cut(before, k), x(before, k), rtol=1e-13, atol=1e-13, err_msg=f"{k} until {time!r}"
        )
        expected = x.end_state[k] if time == x.end_time else x(time, k) if k < order else 0.0
        assert cut.end_state[k] == pytest.approx(expected, rel=1e-13, abs=1e-13), (k, time)


@given(seed=SEEDS, order=ORDERS)
def test_until_a_break_has_no_sliver(seed, order):
    x = any_trajectory(seed, order)
    for i, time in enumerate(x.breaks.tolist()):
        cut = x.until(time)
        assert len(cut.states) == i
        np.testing.assert_array_equal(cut.breaks, x.breaks[: i + 1])
        np.testing.assert_array_equal(cut.states, x.states[:i])
        np.testing.assert_array_equal(cut.durations, x.durations[:i])
        outside = x.end_state if i == len(x.states) else x.states[i]
        coasts = i == len(x.states)  # after its end the highest that continue are left
        known = min(order, 2) if coasts else order
        np.testing.assert_array_equal(cut.end_state[:known], outside[:known])


@given(seed=SEEDS, order=ORDERS, more=st.floats(1e-3, 1e3))
def test_until_a_time_after_the_end_it_coasts(seed, order, more):
    x = smooth_trajectory(seed, order)
    time = x.end_time + more
    longer = x.until(time)
    t = np.concatenate([inside(x), x.end_time + more * np.array([0.1, 0.9, 1.5])])
    for k in range(order + 1):
        np.testing.assert_allclose(longer(t, k), x(t, k), rtol=1e-12, atol=1e-11)
    assert len(longer.states) == len(x.states) + 1
    assert longer.states[-1, min(2, order) :].tolist() == [0.0] * (order - min(2, order) + 1)
    assert longer.duration == pytest.approx(x.duration + more, rel=1e-13)


@given(seed=SEEDS, order=st.integers(2, 6), part=st.floats(0.05, 0.95))
def test_until_composes_and_the_rest_can_follow(seed, order, part):
    x = smooth_trajectory(seed, order)
    first, second = (x.start_time + share * x.duration for share in (part, part**0.5))
    cut = x.until(second).until(first)
    np.testing.assert_allclose(cut.states, x.until(first).states, rtol=1e-14)
    assert cut.end_time == first
    rest = x.reverse().until(x.start_time + x.end_time - first).reverse()
    joined, t = cut.then(rest.delay(first - rest.start_time)), inside(x)
    for k in range(order):
        scale = magnitude(x, k) + 10.0
        np.testing.assert_allclose(joined(t, k), x(t, k), rtol=1e-8, atol=1e-9 * scale)


def test_then_works_after_until():
    move = min_time_move(10.0, Limits(velocity=4.0, acceleration=4.0))
    cruising = move.until(1.5)
    assert cruising.end_state.tolist() == [4.0, 4.0, 0.0]
    stop = Trajectory([0.0, 2.0], [[0.0, 4.0, -2.0]])
    both = cruising.then(stop)
    assert both([0.5, 1.5, 3.5, 9.0]).tolist() == [0.5, 4.0, 8.0, 8.0]
    late = move.until(5.0).then(move)
    assert late([3.5, 5.0, 5.5, 8.5]).tolist() == [10.0, 10.0, 10.5, 20.0]
    with pytest.raises(ValueError, match="velocity would jump from 4 to 0"):
        cruising.then(move)


def test_until_keeps_what_a_derivative_does_outside():
    speed = min_time_move(10.0, Limits(acceleration=4.0)).derivative(1)
    longer = speed.until(speed.end_time + 1.0)
    assert longer.coasting == speed.coasting == 0
    assert longer([-1.0, speed.end_time + 0.5, speed.end_time + 9.0]).tolist() == [0.0] * 3
    zero = Trajectory([0.0, 1.0], [[2.0, 0.0]], coasting=-1)
    assert zero.until(3.0)([-1.0, 0.5, 2.0, 4.0]).tolist() == [0.0, 2.0, 0.0, 0.0]


def test_until_of_order_1_and_of_a_point():
    ramp = Trajectory([0.0, 2.0], [[1.0, 3.0]])
    assert ramp.until(1.0)([0.5, 1.0, 5.0]).tolist() == [2.5, 4.0, 4.0]
    assert ramp.until(4.0)([1.0, 3.0, 9.0]).tolist() == [4.0, 7.0, 7.0]
    rest = min_time_move(0.0, Limits(jerk=1.0), start=2.0)
    assert rest.until(0.0).duration == 0.0
    assert rest.until(3.0)([-1.0, 2.0, 9.0]).tolist() == [2.0] * 3


def test_until_the_start_is_a_point():
    x = smooth_trajectory(1, 4)
    point = x.until(x.start_time)
    assert (len(point.states), point.duration) == (0, 0.0)
    np.testing.assert_array_equal(point.end_state[:4], x.start_state[:4])


@pytest.mark.parametrize("time", [-0.71, -1e300])
def test_until_refuses_a_time_before_the_start(time):
    message = re.escape(f"time = {time!r} is before the start: expected at least -0.7")
    with pytest.raises(ValueError, match=message):
        any_trajectory(0, 3).until(time)


@pytest.mark.parametrize("time", [nan, inf, -inf])
def test_until_refuses_what_is_no_time(time):
    with pytest.raises(ValueError, match=re.escape(f"time = {time!r}: expected a finite number")):
        any_trajectory(0, 3).until(time)


# Appending


@pytest.mark.parametrize("dwell", [0.0, 0.75])
@pytest.mark.parametrize("orders", [(1, 1), (2, 2), (4, 4), (2, 5), (5, 2), (3, 4), (1, 3)])
def test_then_is_one_motion_after_the_other(orders, dwell):
    first = min_time_move(-2.0, Limits.from_bounds([1.0] * orders[0]), method="closed-form").delay(
        0.5
    )
    second = min_time_move(
        3.0, Limits.from_bounds([2.0] * orders[1]), start=10.0, method="closed-form"
    )
    joined = first.then(second, dwell=dwell)
    assert joined.order == max(orders)
    assert joined.duration == pytest.approx(first.duration + dwell + second.duration, rel=1e-14)
    assert joined.end_state[0] == pytest.approx(1.0, rel=1e-14)
    joint = first.end_time + dwell
    for k in range(max(orders) + 1):
        t = inside(first)
        np.testing.assert_allclose(joined(t, k), first(t, k), rtol=1e-12, atol=1e-13)
        t, offset = inside(second), -12.0 * (k == 0)
        np.testing.assert_allclose(
            joined(joint + t, k), second(t, k) + offset, rtol=1e-9, atol=1e-11
        )
        if dwell:
            rest = joined(first.end_time + dwell * np.array([0.2, 0.9]), k)
            np.testing.assert_allclose(rest, -2.0 * (k == 0), rtol=1e-14, atol=1e-14)


def test_then_keeps_moving_through_a_joint():
    first = Trajectory([0.0, 1.0], [[0.0, 0.0, 2.0]])  # ends at 1 with velocity 2
    second = Trajectory([5.0, 6.0], [[0.0, 2.0, -2.0]])
    joined = first.then(second, dwell=3.0)
    assert joined([1.0, 2.5, 4.0, 5.0, 8.0]).tolist() == [1.0, 4.0, 7.0, 8.0, 8.0]
    assert joined([2.5, 4.5, 8.0], "velocity").tolist() == [2.0, 1.0, 0.0]


def test_a_dwell_coasts_whatever_the_highest_derivative_was_at_the_end():
    first = Trajectory([0.0, 1.0], [[0.0, 0.0, 2.0]], end_state=[1.0, 2.0, 2.0])
    joined = first.then(Trajectory([0.0, 1.0], [[0.0, 2.0, -2.0]]), dwell=3.0)
    assert joined([2.5, 4.0], "velocity").tolist() == [2.0, 2.0]
    assert joined(2.5, "acceleration") == 0.0
    assert joined.end_state[0] == 8.0


def test_then_is_associative():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=9.0)
    a, b, c = (min_time_move(distance, limits) for distance in (1.0, -0.3, 5.0))
    left, right = a.then(b, dwell=0.1).then(c), a.then(b.then(c), dwell=0.1)
    np.testing.assert_allclose(left.breaks, right.breaks, rtol=1e-14)
    np.testing.assert_allclose(left.states, right.states, rtol=1e-12, atol=1e-14)


def test_then_keeps_bounds_and_extremes():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=9.0, snap=100.0)
    joined = min_time_move(1.0, limits).then(min_time_move(-4.0, limits), dwell=2.0)
    assert joined.violation(limits) <= 1e-12
    assert joined.extremes(0) == pytest.approx((-3.0, 1.0), rel=1e-14)


@pytest.mark.parametrize(
    ("end", "start", "name"),
    [
        ([0.0, 1.0, 0.0], [0.0, 2.0, 0.0], "velocity"),
        ([0.0, 1.0, 0.5, 0.0], [0.0, 1.0, 0.6, 0.0], "acceleration"),
        ([0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 2.0, 0.0], "jerk"),
    ],
)
def test_then_refuses_a_jump(end, start, name):
    order = len(end) - 1
    first = Trajectory([0.0, 1.0], [[0.0] * (order + 1)], end_state=end)
    second = Trajectory([0.0, 1.0], [start])
    with pytest.raises(ValueError, match=f"{name} would jump from .* at the joint"):
        first.then(second)


def test_then_refuses_a_dwell_in_which_acceleration_would_jump():
    first = Trajectory([0.0, 1.0], [[0.0, 0.0, 0.0, 1.0]])  # ends with acceleration 1
    second = Trajectory([0.0, 1.0], [[0.0, 0.5, 1.0, 0.0]])
    assert first.then(second)(1.0, "acceleration") == 1.0
    with pytest.raises(ValueError, match="acceleration would jump"):
        first.then(second, dwell=1.0)


@pytest.mark.parametrize("dwell", [-1.0, nan, inf])
def test_then_refuses_what_is_no_dwell(dwell):
    x = min_time_move(1.0, Limits(jerk=1.0))
    with pytest.raises(ValueError, match=re.escape(f"dwell = {dwell!r}: expected a finite time")):
        x.then(x, dwell=dwell)


# A point


def test_a_point_is_a_trajectory():
    rest = min_time_move(0.0, Limits(jerk=1.0), start=2.0)
    assert (rest.duration, rest.order, len(rest.states)) == (0.0, 3, 0)
    assert rest([-1.0, 0.0, 1.0]).tolist() == [2.0, 2.0, 2.0]
    assert rest(np.zeros(5000)).tolist() == [2.0] * 5000
    assert rest.extremes(0) == (2.0, 2.0)
    assert rest.peak(1) == rest.violation(Limits(velocity=1.0)) == 0.0
    assert rest.switch_times.size == 0
    times, states = rest.sample(0.1)
    assert times.tolist() == [0.0]
    assert states.tolist() == [[2.0], [0.0], [0.0], [0.0]]
    assert rest.derivative(1)(3.0) == 0.0


@pytest.mark.parametrize("change", ["reverse", "mirror", "shift", "delay", "scale", "stretch"])
def test_a_point_has_the_whole_algebra(change):
    rest = min_time_move(0.0, Limits(jerk=1.0), start=2.0)
    arguments = {"shift": (3.0,), "delay": (3.0,), "scale": (3.0,), "stretch": (3.0,)}
    changed = getattr(rest, change)(*arguments.get(change, ()))
    expected = {"mirror": -2.0, "shift": 5.0, "scale": 6.0}.get(change, 2.0)
    assert changed([-9.0, 9.0]).tolist() == [expected, expected]
    assert changed.duration == 0.0


def test_a_point_can_be_appended_on_either_side():
    rest = min_time_move(0.0, Limits(jerk=1.0), start=2.0)
    move = min_time_move(1.0, Limits(jerk=1.0))
    assert rest.then(move, dwell=0.5)([0.0, 0.4, 99.0]).tolist() == [2.0, 2.0, 3.0]
    assert move.then(rest).end_state[0] == 1.0
    assert move.then(rest, dwell=1.0).duration == pytest.approx(move.duration + 1.0)
    assert rest.then(rest).duration == 0.0


# Building


def test_arrays_are_copied_and_read_only():
    breaks, states, end = np.array([0.0, 1.0]), np.array([[0.0, 1.0]]), np.array([1.0, 0.0])
    trajectory = Trajectory(breaks, states, np.array([1.0]), end)
    breaks[1], states[0, 1], end[0] = 9.0, 9.0, 9.0
    assert trajectory([0.5, 5.0]).tolist() == [0.5, 1.0]
    for name in ("breaks", "states", "durations", "end_state"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(trajectory, name)[...] = 0.0
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(trajectory, name, 0.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0, 1.0], [[0.0, 1.0], [1.0, 1.0]]), r"breaks of shape \(2,\) and states of shape"),
        (([[0.0, 1.0]], [[0.0, 1.0]]), "do not fit"),
        (([0.0, 1.0], [0.0, 1.0]), "do not fit"),
        (([0.0, 1.0], [[0.0]]), "states has 1 columns: expected position and 1 to 40"),
        (([0.0, 1.0], [[0.0] * 42]), "states has 42 columns"),
        (([0.0, 0.0], [[0.0, 1.0]]), "every piece must take time"),
        (([0.0, 1.0, 0.5], [[0.0, 1.0], [1.0, 1.0]]), "every piece must take time"),
        (([0.0, nan], [[0.0, 1.0]]), "breaks must be finite"),
        (([0.0, 1.0], [[0.0, inf]]), "states must be finite"),
        (([0.0, 1.0], [[0.0, 1.0]], [nan]), "durations must be finite"),
        (([0.0, 1.0], [[0.0, 1.0]], [1.0, 1.0]), "durations has shape"),
        (([0.0, 1.0], [[0.0, 1.0]], [0.0]), "every piece must take time"),
        (([0.0, 1.0], [[0.0, 1.0]], [1.1]), "durations differ from the differences"),
        (([1e9, 1e9 + 1.0], [[0.0, 1.0]], [0.2]), "durations differ from the differences"),
        (([1e9 + 0.5, 1e9], [[0.0, 1.0]], [0.2]), r"differ|every piece must take time|increase"),
        (([0.0, 1.0], [[0.0, 1.0]], [1.0], [0.0]), r"end_state has shape \(1,\): expected \(2,\)"),
        (([0.0, 1.0], [[0.0, 1.0]], [1.0], [nan, 0.0]), "end_state must be finite"),
        (([0.0], np.empty((0, 2))), "without pieces needs its end_state"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Trajectory(*arguments)


def test_the_default_end_is_the_last_piece_run_out():
    trajectory = Trajectory([1.0, 3.0], [[1.0, 2.0, 3.0, 6.0]])
    assert trajectory.end_state.tolist() == [1 + 4 + 6 + 8, 2 + 6 + 12, 3 + 12, 0.0]
    assert trajectory.start_state.tolist() == [1.0, 2.0, 3.0, 6.0]


def test_repr_says_what_it_is():
    assert repr(Trajectory([0.0, 2.0], [[1.0, 3.0]])) == (
        "Trajectory(order=1, pieces=1, start=1, end=7, duration=2)"
    )


# Epoch-sized times


def test_a_motion_at_epoch_sized_times_keeps_its_shape():
    limits = Limits(velocity=2.0, acceleration=5.0, jerk=40.0, snap=900.0)
    move = min_time_move(3.0, limits)
    epoch, resolution = 1.7e9, 2.4e-7
    late = move.delay(epoch)
    assert late.violation(limits) == move.violation(limits)
    assert late.duration == pytest.approx(move.duration, abs=2 * resolution)
    t = np.linspace(0.0, move.duration, 5001)
    for k in range(4):
        slack = limits.bounds(k + 1)[1] * resolution
        np.testing.assert_allclose(late(epoch + t, k), move(t, k), rtol=0, atol=2 * slack)
        if k:
            assert np.abs(late(epoch + t, k)).max() <= limits.bounds(k)[1] * (1 + 1e-12)
    assert late(epoch + 100.0) == 3.0
    times, states = late.sample(1e-3)
    assert (np.diff(times) >= 0).all()
    np.testing.assert_array_equal(states[:, -1], move.end_state)


@pytest.mark.parametrize("count", [1, 5000], ids=["gathered", "swept"])
def test_no_piece_runs_past_its_duration(count):
    """The clock ticks in 1.2e-7 at 1e9: a piece may end before the last tick inside it."""
    ramp = Trajectory([1e9, 1e9 + 1.0], [[0.0, 0.0, 1.0]], [1.0 - 2e-7])
    t = np.full(count, np.nextafter(1e9 + 1.0, 0.0))
    np.testing.assert_allclose(ramp(t, "velocity"), 1.0 - 2e-7, rtol=0, atol=1e-15)


def test_a_motion_comes_back_from_epoch_sized_times():
    move = min_time_move(3.0, Limits(velocity=2.0, acceleration=5.0, jerk=40.0))
    back = move.delay(1.7e9).delay(-1.7e9)
    np.testing.assert_array_equal(back.durations, move.durations)
    np.testing.assert_allclose(back.breaks, move.breaks, rtol=0, atol=2.4e-7)


def test_pieces_below_the_clocks_resolution_survive():
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=1e9)
    late = min_time_move(3.0, limits).delay(1e9)
    assert late.violation(limits) <= 1e-12
    t = 1e9 + np.linspace(-1.0, 6.0, 20_001)
    assert np.abs(late(t, "acceleration")).max() <= 1.0 + 1e-12
    assert late(t).max() <= 3.0 + 1e-6


@pytest.mark.parametrize(
    "again",
    [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))],
    ids=["copy", "deepcopy", "pickle"],
)
def test_a_copy_is_the_same_function_and_frozen_too(again):
    move = min_time_move(1.0, Limits(1.0, 2.0, 5.0))
    times = np.linspace(-0.5, 3.0, 50)
    values = move(times)
    twin = again(move)
    np.testing.assert_array_equal(twin(times), values)
    for name in ("breaks", "states", "durations", "end_state"):
        assert not getattr(twin, name).flags.writeable


@given(seed=SEEDS, order=ORDERS, coasting=st.booleans())
def test_the_lowest_jump_is_told_by_the_peaks(seed, order, coasting):
    """Values just before and after each break, beside exact peaks, of pieces that partly join."""
    rng = np.random.default_rng(seed)
    joined = int(rng.integers(0, order + 1))
    breaks = np.cumsum(rng.uniform(0.5, 2.0, 4))
    states = rng.normal(size=(3, order + 1))
    for i in (1, 2):
        before = Trajectory(breaks[i - 1 : i + 1], states[i - 1 : i])
        states[i, :joined] = before.end_state[:joined]
    motion = Trajectory(breaks, states, coasting=0 if coasting or order == 1 else 1)
    sides = [motion.derivative(k) if 0 < k < order else motion for k in range(order)]
    expected = order
    for k in reversed(range(order)):
        gaps = [motion(np.nextafter(t, -inf), k) - motion(t, k) for t in breaks]
        gaps[-1] = float(motion.end_state[k]) - motion(breaks[-1] + 1e-300, k)
        if np.abs(gaps).max() > 1e-9 * sides[k].peak(0):
            expected = k
    assert motion.lowest_jump() == expected
