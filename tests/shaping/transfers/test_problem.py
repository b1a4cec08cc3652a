"""What is refused before any planning, and transfers as results."""

import copy
import pickle
import re
from dataclasses import FrozenInstanceError
from math import inf, nan

import numpy as np
import pytest
from strategies import random_transfer

from jounce.shaping import Limits, Trajectory, min_time_transfer, velocity_transfer

LIMITS = Limits(1.0, 1.0, 1.0)


# What is refused


REFUSED = [
    (((nan, 0.0), 1.0), ValueError, "start position = nan: expected a finite number"),
    (((0.0, inf), 1.0), ValueError, "start velocity = inf: expected a finite number"),
    ((0.0, (1.0, 0.0, -inf)), ValueError, "end acceleration = -inf: expected a finite number"),
    (((), 1.0), ValueError, "start = (): expected (position, velocity, acceleration)"),
    ((0.0, (1, 0, 0, 0, 0)), ValueError, "end = (1, 0, 0, 0, 0): expected (position"),
    (("1", 1.0), TypeError, "start position = '1': expected a number"),
    ((None, 1.0), TypeError, "start position = None: expected a number"),
    ((0.0, (1.0, "fast")), (TypeError, ValueError), "fast"),
    (((-1e308, 0.0), 1e308), ValueError, "the distance between start and end = inf"),
    (((-1e308,), (1e308,)), ValueError, "the distance between start and end = inf"),
    (([], []), ValueError, "start = []: expected (position, velocity, acceleration)"),
]


@pytest.mark.parametrize(("states", "kind", "message"), REFUSED)
def test_states_that_are_none(states, kind, message):
    with pytest.raises(kind, match=re.escape(message)):
        min_time_transfer(*states, Limits(1.0, 1.0, 1.0))


def test_velocities_that_are_none():
    limits = Limits(1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="end velocity = nan: expected a finite number"):
        velocity_transfer(0.0, nan, limits)
    with pytest.raises(ValueError, match="end acceleration = inf: expected a finite number"):
        velocity_transfer(0.0, 0.5, limits, acceleration=inf)
    with pytest.raises(TypeError, match="end velocity = '1': expected a number"):
        velocity_transfer(0.0, "1", limits)


@pytest.mark.parametrize("order", [2, 3])
def test_the_highest_derivative_may_follow_and_is_not_used(order):
    problem = random_transfer(np.random.default_rng(order), order)
    transfer = problem.solve()
    again = min_time_transfer((*problem.start, 0.5), (*problem.end, -7.0), problem.limits)
    np.testing.assert_array_equal(again.states, transfer.states)
    with pytest.raises(ValueError, match=f"expected .* for limits of order {order}"):
        min_time_transfer((*problem.start, 0.5, 0.0), problem.end, problem.limits)


@pytest.mark.parametrize("order", [1, 11])
def test_limits_of_another_order_are_refused(order):
    limits = Limits.from_bounds([1.0] * order)
    with pytest.raises(ValueError, match=f"limits of order {order}: expected order 2"):
        min_time_transfer(0.0, 1.0, limits)
    with pytest.raises(ValueError, match=f"limits of order {order}: expected order 2"):
        velocity_transfer(0.0, 1.0, limits)


@pytest.mark.parametrize(
    ("limits", "name"),
    [
        (Limits(acceleration=(-1.0, inf)), "acceleration"),
        (Limits(1.0, 1.0, jerk=(-inf, 2.0)), "jerk"),
    ],
)
def test_a_highest_bound_in_one_direction_only_is_refused(limits, name):
    with pytest.raises(ValueError, match=f"{name} is bounded in one direction only, "):
        min_time_transfer(0.0, 1.0, limits)


@pytest.mark.parametrize("limits", [{"jerk": 1.0}, 2.0, None])
def test_limits_of_another_kind_are_refused(limits):
    with pytest.raises(TypeError, match="expected Limits"):
        min_time_transfer(0.0, 1.0, limits)


def test_times_out_of_the_range_of_a_double_are_refused():
    with pytest.raises(ValueError, match="leaves the range of a double"):
        min_time_transfer(0.0, 1e300, Limits(jerk=1e-300, velocity=1e-300))


# What is returned


def test_a_transfer_has_a_trajectory_and_knows_its_limits():
    transfer = min_time_transfer((0.0, 3.0), 5.0, Limits(1.0, 2.0))
    assert not isinstance(transfer, Trajectory)
    assert type(transfer.trajectory) is Trajectory
    assert (transfer.limits, transfer.inside_after) == (Limits(1.0, 2.0), 1.0)
    assert repr(transfer).startswith("Transfer(order=2, ")
    assert not transfer.states.flags.writeable
    with pytest.raises(FrozenInstanceError):
        transfer.states = transfer.states


def test_what_is_made_of_a_transfer_claims_no_limits():
    transfer = min_time_transfer(0.0, 5.0, Limits(1.0, 2.0))
    for made in (transfer.shift(1.0), transfer.scale(9.0), transfer.reverse().delay(2.0)):
        assert isinstance(made, Trajectory)
    assert type(transfer.scale(9.0)) is Trajectory


@pytest.mark.parametrize("send", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_transfers_can_be_copied_and_pickled(send):
    transfer = min_time_transfer((0.0, 3.0), 5.0, Limits(1.0, 2.0))
    again = send(transfer)
    np.testing.assert_array_equal(again.states, transfer.states)
    assert (again.limits, again.inside_after) == (transfer.limits, transfer.inside_after)


@pytest.mark.parametrize("order", [2, 3])
def test_numbers_left_out_are_zero(order):
    limits = Limits.from_bounds([1.0] * order)
    full = min_time_transfer((0.0,) * order, (4.0, *[0.0] * (order - 1)), limits)
    for start, end in ((0.0, 4.0), (0, 4), ([0.0], (4.0, 0.0)), (np.zeros(2), np.array([4.0]))):
        np.testing.assert_array_equal(min_time_transfer(start, end, limits).states, full.states)
