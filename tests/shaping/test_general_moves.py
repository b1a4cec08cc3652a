"""Moves under bounds on position, that are zero on a side, or that differ between directions."""

from math import inf

import numpy as np
import pytest

from jounce.shaping import InfeasibleError, Limits, certify, min_time_move, min_time_transfer


@pytest.mark.parametrize("order", [2, 3])
def test_low_orders_stay_exact_within_stops_and_without_turning_back(order):
    pairs = [2.0, (-3.0, 1.0), 5.0][:order]
    exact = min_time_move(4.0, Limits.from_bounds(pairs), start=1.0)
    stopped = Limits.from_bounds([(0.0, 2.0), *pairs[1:]], position=(1.0, 5.0))
    move = min_time_move(4.0, stopped, start=1.0)
    assert move.duration == exact.duration
    np.testing.assert_array_equal(move.states, exact.states)
    assert move.violation(stopped) <= 1e-15


def test_from_order_4_too():
    limits = Limits((0.0, 2.0), (-1.0, 2.0), 5.0, 30.0, position=(0.0, 1.0))
    move = min_time_move(1.0, limits)
    assert move.violation(limits) <= 1e-15
    free = min_time_move(1.0, Limits(2.0, (-1.0, 2.0), 5.0, 30.0))
    assert move.duration >= free.duration * (1.0 - 1e-4)
    assert certify(move, limits).check()
    symmetric = Limits(2.0, 1.0, 5.0, 30.0, position=(0.0, 1.0))
    same = min_time_move(1.0, Limits(2.0, 1.0, 5.0, 30.0))
    assert min_time_move(1.0, symmetric).duration == same.duration


@pytest.mark.parametrize("method", ["optimal", "closed-form"])
@pytest.mark.parametrize(
    ("distance", "limits", "told", "bound"),
    [
        (-1.0, Limits((0.0, 2.0), 1.0, 1.0), "the velocity bound 0 stands in the way", "velocity"),
        (1.0, Limits(2.0, (0.0, 1.0), 1.0), "with a bound of 0 on acc.* never", "acceleration"),
        (1.0, Limits(2.0, 1.0, (-1.0, 0.0), 9.0), "with a bound of 0 on jerk", "jerk"),
        (2.0, Limits(2.0, 1.0, position=(0.0, 1.0)), "end position = 2.0 is outside", "position"),
        (2.0, Limits(2.0, 1.0, 3.0, 4.0, position=(0.5, 9.0)), "start position = 0.0", "position"),
    ],
    ids=range(5),
)
def test_moves_that_cannot_be_are_told_by_the_bound_in_the_way(
    distance, limits, told, bound, method
):
    with pytest.raises(InfeasibleError, match=told) as error:
        min_time_move(distance, limits, method=method)
    assert error.value.bound == bound
    assert "\n" not in str(error.value)


def test_closed_forms_of_unequal_bounds_average_the_exact_lower_order():
    limits = Limits(acceleration=(-10.0, 1.0), jerk=100.0, snap=1e4)
    move = min_time_move(1.0, limits, method="closed-form")
    exact = min_time_move(1.0, Limits(acceleration=(-10.0, 1.0), jerk=100.0))
    assert move.duration == pytest.approx(exact.duration + 0.02, rel=1e-12)
    assert move.violation(limits) <= 1e-12
    assert certify(move, limits).lower_bound < move.duration


@pytest.mark.parametrize("snap", [1e6, 1e8, 1e10, 1e14])
def test_ramps_too_short_for_any_grid_are_averaged(snap):
    limits = Limits(acceleration=(-10.0, 1.0), jerk=100.0, snap=snap)
    move = min_time_move(1.0, limits, rtol=1e-3)
    exact = min_time_move(1.0, Limits(acceleration=(-10.0, 1.0), jerk=100.0)).duration
    assert exact < move.duration <= exact * (1.0 + 2e-4)
    assert move.violation(limits) <= 1e-12


@pytest.mark.parametrize("length", [1e-12, 1e12])
@pytest.mark.parametrize("time", [1e-6, 1e6])
def test_twelve_decades_of_units(length, time):
    powers = length / time ** np.arange(5)
    pairs = [(-2.0, 2.0), (-4.0, 1.0), (-20.0, 20.0), (-200.0, 300.0)]
    scaled = [(low * p, high * p) for (low, high), p in zip(pairs, powers[1:], strict=True)]
    move = min_time_move(length, Limits.from_bounds(scaled))
    plain = min_time_move(1.0, Limits.from_bounds(pairs))
    assert move.duration == pytest.approx(plain.duration * time, rel=1e-4)
    assert move.violation(Limits.from_bounds(scaled)) <= 1e-12


def test_a_transfer_that_starts_and_ends_on_its_bounds():
    limits = Limits(1.0, (-2.0, 1.0), 4.0, 40.0, position=(0.0, 3.0))
    transfer = min_time_transfer((0.0, 1.0), (3.0, 1.0), limits)
    assert transfer.duration == pytest.approx(3.0, rel=1e-4)
    assert transfer.violation(limits) <= 1e-12


def test_nothing_to_do_takes_no_time():
    limits = Limits(1.0, (-2.0, 1.0), 4.0, 40.0, position=(0.0, 3.0))
    state = (1.0, 0.5, 0.0, 1.0)
    assert min_time_transfer(state, state, limits).duration == 0.0
    assert min_time_move(0.0, limits, start=1.0).duration == 0.0


@pytest.mark.parametrize("rtol", [0.0, -1.0, inf])
def test_a_gap_that_is_none_is_refused(rtol):
    with pytest.raises(ValueError, match=r"^rtol = .*: expected a positive, finite number"):
        min_time_transfer(0.0, 1.0, Limits(1.0, 1.0, 1.0, 9.0), rtol=rtol)


def test_a_move_a_million_times_its_ramps_cruises():
    limits = Limits(velocity=1.0, acceleration=(-2.0, 1.0), jerk=5.0, snap=100.0)
    for method in ("optimal", "closed-form"):
        move = min_time_move(1e7, limits, method=method)
        assert 1e7 < move.duration < 1e7 + 10.0
        assert move.violation(limits) < 1e-11


@pytest.mark.parametrize(
    "limits",
    [
        Limits(velocity=(0.0, 5.0), snap=300.0),
        Limits(velocity=(0.0, 5.0), jerk=20.0, snap=300.0),
        Limits(velocity=(0.0, 5.0), snap=(-10.0, 20.0)),
    ],
)
def test_a_closed_form_under_a_bound_of_zero_is_proven(limits):
    move = min_time_move(3.0, limits, method="closed-form")
    proof = certify(move, limits)
    assert 0.0 < proof.lower_bound <= move.duration * (1.0 + 1e-12)
    assert proof.check()


def test_a_long_duration_needs_the_share_of_its_fourth_power():
    pairs = (-2.0, 1.0), (-4.0, 1.0), (-10.0, 5.0), (-100.0, 50.0)
    limits = Limits.from_bounds(pairs)
    shares = [
        max(high / 50.0, -low / 100.0)
        for low, high in (
            min_time_move(2.0, limits, duration=time).extremes(4) for time in (50.0, 500.0)
        )
    ]
    assert shares[0] == pytest.approx(1e4 * shares[1], rel=2e-3)
