"""Moves of order 4 and more: sound, symmetric, no slower than a closed form, near the minimum."""

from itertools import product
from math import factorial, inf

import numpy as np
import pytest
from references import BOUND, CONTINUITY, END_POSITION, joint_gaps, reference_problems
from tiers import some

from jounce.shaping import Limits, certify, min_time_move, perfect_spline

GAPS = {4: 5e-4, 5: 1e-3, 6: 1.5e-3}
REFERENCES = [
    pytest.param(problem, id=problem.name)
    for problem in reference_problems()
    if problem.order >= 4 or problem.name.endswith("03")
]


def limits_of(bounds):
    return Limits.from_bounds([None if bound == inf else bound for bound in bounds])


def random_bounds(order, seed):
    """Return bounds around those of the perfect spline in unit time, some left out."""
    rng = np.random.default_rng((order, seed))
    return [
        4.0**k * factorial(k) * 10.0 ** rng.uniform(-1.0, 1.5)
        if k == order - 1 or rng.random() < 0.7
        else inf
        for k in range(order)
    ]


def assert_sound(move, distance, limits):
    text = f"min_time_move({distance!r}, {limits!r})"
    np.testing.assert_array_equal(move.start_state[1:-1], 0.0, text)
    np.testing.assert_array_equal(move.end_state[1:], 0.0, text)
    travelled = move.end_state[0] - move.start_state[0]
    assert abs(travelled - distance) <= END_POSITION * abs(distance), text
    assert abs(move(move.end_time) - move.end_state[0]) <= END_POSITION * abs(distance), text
    assert move.violation(limits) <= BOUND, text
    assert max(joint_gaps(move)) <= CONTINUITY, text
    closed = min_time_move(distance, limits, method="closed-form")
    assert move.duration <= closed.duration, text
    mirrored = move.reverse().mirror().shift(travelled + 2.0 * move.start_state[0])
    t = np.linspace(0.0, 1.0, 40) * move.duration  # the middle may be within a ramp of 1e-13
    for k in range(move.order):
        np.testing.assert_allclose(mirrored(t, k), move(t, k), rtol=0, atol=1e-11 * move.peak(k))


@pytest.mark.parametrize("problem", some(REFERENCES, 12))
def test_reference_problems(problem):
    limits = limits_of(problem.bounds)
    move = min_time_move(problem.distance, limits)
    assert_sound(move, problem.distance, limits)
    assert move.duration >= problem.lower * (1.0 - 1e-9)
    assert move.duration <= problem.upper * (1.0 + 1e-4)


@pytest.mark.parametrize("order", [4, 5, 6, 7])
@pytest.mark.parametrize("seed", some(range(4), 2))
def test_random_moves_are_sound(order, seed):
    limits = limits_of(random_bounds(order, seed))
    assert_sound(
        min_time_move(-2.0 if seed % 2 else 2.0, limits), -2.0 if seed % 2 else 2.0, limits
    )


@pytest.mark.parametrize("order", range(1, 11))
def test_a_perfect_spline_stays_one(order):
    limits = Limits.from_bounds([*[None] * (order - 1), 3.0])
    move, spline = min_time_move(2.0, limits), perfect_spline(2.0, order, 3.0)
    np.testing.assert_allclose(move.breaks, spline.breaks, rtol=1e-12, atol=1e-12)
    for k in range(order):
        np.testing.assert_allclose(
            move.states[:, k], spline.states[:, k], rtol=0, atol=1e-12 * spline.peak(k)
        )


@pytest.mark.parametrize("acceleration", [1.0, 3.0, 5.0])
def test_highest_and_acceleration_at_order_4_is_thompsons_profile(acceleration):
    limits = Limits(acceleration=acceleration, snap=384.0)
    move = min_time_move(1.0, limits)
    closed = min_time_move(1.0, limits, method="closed-form")
    np.testing.assert_array_equal(move.breaks, closed.breaks)
    np.testing.assert_array_equal(move.states, closed.states)


@pytest.mark.parametrize(("distance", "time"), some(product([1e-6, 1e6], repeat=2), 2))
@pytest.mark.parametrize("order", [4, 5])
def test_units_change_nothing_but_scale(order, distance, time):
    bounds = random_bounds(order, 11)
    move = min_time_move(1.0, limits_of(bounds))
    scaled = [bound * distance / time**k for k, bound in enumerate(bounds, start=1)]
    other = min_time_move(distance, limits_of(scaled))
    assert len(other.breaks) == len(move.breaks)
    assert other.duration == pytest.approx(move.duration * time, rel=1e-11)


@pytest.mark.parametrize("order", some([4, 6, 5], 2))
def test_duration_grows_with_distance_and_falls_with_every_bound(order):
    """To within the gap allowed."""
    bounds = random_bounds(order, 3)
    slack = 1.0 + GAPS[order]
    duration = min_time_move(1.0, limits_of(bounds)).duration
    assert min_time_move(1.01, limits_of(bounds)).duration >= duration / slack
    for k in range(order):
        wider = [bound * 1.1 if i == k else bound for i, bound in enumerate(bounds)]
        assert min_time_move(1.0, limits_of(wider)).duration <= duration * slack, (
            f"derivative {k + 1}"
        )


EXTREMES = {
    "ramps of 1e-5 of the duration": [1.8, 7.0, 60.0, 384e4],
    "nothing but ramps": [None, 4.0, None, 384e12],
    "a cruise of a thousand ramps": [0.0018, None, None, 384.0],
    "a hold of many ramps": [None, 0.07, None, None, 6144.0],
    "twelve decades": [1e-6, 1e6, 1e-2, 1e4, 1e-6],
    "redundant": [1e6, 1e9, 1e12, 3.0, 1e3],
    "pop beyond reach": [1.8, 7.0, None, None, None, 1e13],
    "the simplex method cycles": [
        34.3553444303096, 0.0008137961671450839, 798567.1175964089, 6465734.872857671,
        3686.6410806526337, 52066044479.41595,
    ],
    "the linear program fails": [
        2.377288602462569, 8.103152925275228e-05, 35.34759622444703, 392513.0733538621,
        230835972.7097749, 190.99960443072484,
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", EXTREMES)
@pytest.mark.filterwarnings("ignore:these limits are too far apart:RuntimeWarning")
def test_extremes_end_in_a_sound_move(name):
    limits = Limits.from_bounds(EXTREMES[name])
    assert_sound(min_time_move(1.0, limits), 1.0, limits)


@pytest.mark.parametrize(
    "bounds",
    [
        [4.356316773689454, 8.868625112759844, 100961.5, 47.388258854008086, 2453350474.840627],
        [345.4236345647513, 0.2490833915634557, 0.0009802799890988529, 0.0047287986, 400034677.9],
        [2197.8842949473083, None, 10.87766631770994, 2.9837749168478903e-06, 14695.328134719897],
        [None, 4.0, None, 6.0, 20.0, 3e12],
        [1.8, 7.0, 40.0, 700.0, 3e19, 3e30],
    ],
    ids=["1e-8 of the duration", "1e-13", "1e-12", "1e-12, pop", "two orders"],
)
def test_a_bound_beyond_reach_costs_no_more_than_its_ramps(bounds):
    """The lower order's motion, its steps made into ramps that are nearly lost in rounding."""
    lower = len(bounds) - (2 if bounds[-1] == 3e30 else 1)
    limits, below = Limits.from_bounds(bounds), Limits.from_bounds(bounds[:lower])
    move = min_time_move(1.0, limits)
    assert_sound(move, 1.0, limits)
    assert move.duration <= min_time_move(1.0, below).duration * (1.0 + 3e-8)


@pytest.mark.parametrize("nudge", some([-1e-3, -1e-9, 0.0, 1e-12, 1e-6, 1.0], 4))
@pytest.mark.parametrize("order", [4, 5])
def test_barely_active_bounds(order, nudge):
    free = perfect_spline(1.0, order, 7.0)
    for k in range(1, order):
        bounds = [None] * (order - 1) + [7.0]
        bounds[k - 1] = free.peak(k) * (1.0 + nudge)
        move = min_time_move(1.0, Limits.from_bounds(bounds))
        assert move.violation(Limits.from_bounds(bounds)) <= BOUND
        slower = 1e-12 if nudge >= 0.0 else 10.0 * abs(nudge) + 5e-6
        assert move.duration == pytest.approx(free.duration, rel=slower), f"derivative {k}"


@pytest.mark.parametrize(
    ("free", "bounded"),
    [
        (Limits(jerk=(-inf, 5.0), snap=100.0), Limits(jerk=(-1e3, 5.0), snap=100.0)),
        (Limits(jerk=(-5.0, inf), snap=100.0), Limits(jerk=(-5.0, 1e4), snap=100.0)),
        (Limits((-inf, 0.5), jerk=5.0, snap=100.0), Limits(0.5, jerk=5.0, snap=100.0)),
    ],
    ids=["jerk above", "jerk below", "velocity above"],
)
def test_a_side_without_a_bound_is_one_with_a_bound_out_of_reach(free, bounded):
    move = min_time_move(1.0, free)
    assert move.duration == pytest.approx(min_time_move(1.0, bounded).duration, rel=1e-9)
    assert certify(move, free).reached


@pytest.mark.parametrize("distance", [1.0, -1.0])
def test_bounds_that_differ_between_directions_are_kept(distance):
    pairs = [(-3.0, 1.5), (-4.0, 8.0), (-90.0, 30.0), (-900.0, 1200.0), (-1e4, 2e4)]
    limits = Limits.from_bounds(pairs)
    move = min_time_move(distance, limits)
    assert move.violation(limits) <= BOUND
    assert move.duration <= min_time_move(distance, limits, method="closed-form").duration


def test_start_shifts_and_zero_distance_is_a_point():
    limits = Limits(velocity=1.0, snap=500.0)
    assert min_time_move(-1.0, limits, start=7.0).end_state[0] == 6.0
    assert min_time_move(0.0, limits, start=7.0).extremes(0) == (7.0, 7.0)


def test_an_order_above_10_is_the_closed_form_and_says_so():
    limits = Limits.from_bounds([3.0 * 4.0**k * factorial(k) for k in range(11)])
    with pytest.warns(RuntimeWarning, match="order 11 is above 10: this move is the fastest"):
        move = min_time_move(1.0, limits)
    assert move.duration == min_time_move(1.0, limits, method="closed-form").duration


def test_the_optimal_move_is_the_default():
    limits = limits_of(random_bounds(5, 3))
    move, same = min_time_move(-1.0, limits), min_time_move(-1.0, limits, method="optimal")
    np.testing.assert_array_equal(move.states, same.states)
