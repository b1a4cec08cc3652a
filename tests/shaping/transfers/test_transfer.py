"""min_time_transfer and velocity_transfer from outside: ruckig, linear programs, identities."""

import os
from dataclasses import replace

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st
from references import (
    TRANSFER_BOUND,
    assert_sound_transfer,
    least_duration,
    published_transfers,
    thompson_order_2,
)
from strategies import TransferProblem, random_transfer, transfer_problems
from tiers import some

from jounce.shaping import Limits, min_time_transfer, min_time_transfers, velocity_transfer

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
SLOWEST_AXIS = (1, 3, 5, 7, 9, 11, 13, 17, 41)
"""Published problems whose duration is the longest of the axes' own."""


def published(case):
    """Return one of the published problems: its duration, and one problem for each axis."""
    duration, axes = published_transfers()[case]
    return duration, [TransferProblem(*axis) for axis in axes]


# Against others


@pytest.mark.parametrize("case", SLOWEST_AXIS)
def test_published_problems(case):
    duration, axes = published(case)
    transfers = [axis.solve() for axis in axes]
    assert max(t.duration for t in transfers) == pytest.approx(duration, rel=1e-8), axes
    for axis, transfer in zip(axes, transfers, strict=True):
        assert_sound_transfer(axis, transfer, transfer.inside_after)


def test_published_change_of_velocity():
    duration, axes = published(37)
    changes = [
        velocity_transfer(axis.start, axis.end[1], axis.limits, acceleration=axis.end[2])
        for axis in axes
    ]
    assert max(change.duration for change in changes) == pytest.approx(duration, rel=1e-8)
    assert [c.end_state[1] for c in changes] == [axis.end[1] for axis in axes]


def ruckig_problem(rng):
    """Return a problem that ruckig can state, numbers at their bounds and zero among them."""
    v_max, a_max, jerk = map(float, 10.0 ** rng.uniform(-1.0, 1.0, 3))
    v_min, a_min = -v_max, -a_max
    if rng.random() < 0.5:
        v_min, a_min = (float(x) for x in (v_min, a_min) * 10.0 ** rng.uniform(-1.0, 1.0, 2))

    def anywhere(low, high):
        return float(rng.choice([0.0, low, high, *rng.uniform(low, high, 3)]))

    start, end = (
        (float(rng.normal() * unit), anywhere(v_min, v_max), anywhere(a_min, a_max))
        for unit in (1.0, 10.0 ** rng.uniform(-2.0, 1.0))
    )
    return TransferProblem(start, end, ((v_min, v_max), (a_min, a_max), (-jerk, jerk)))


def ruckigs_duration(problem):
    """Return what ruckig finds; None for problems that it does not take."""
    given = ruckig.InputParameter(1)
    states = {"current": problem.start, "target": problem.end}
    for name, state in states.items():
        for kind, value in zip(("position", "velocity", "acceleration"), state, strict=True):
            setattr(given, f"{name}_{kind}", [value])
    for kind, (low, high) in zip(("velocity", "acceleration"), problem.bounds, strict=False):
        setattr(given, f"min_{kind}", [low])
        setattr(given, f"max_{kind}", [high])
    given.max_jerk = [problem.bounds[2][1]]
    trajectory = ruckig.Trajectory(1)
    try:
        result = ruckig.Ruckig(1).calculate(given, trajectory)
    except ruckig.RuckigError:
        return None
    return trajectory.duration if result == ruckig.Result.Working else None


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(10), 5))
def test_random_problems_take_as_long_as_ruckig_says(seed):
    """But for starts bound to leave their bounds: Ruckig swings past a bound and back, ours not.

    Ruckig brings them inside even where the end comes before; there ours is shorter.
    """
    rng, compared, count = np.random.default_rng(seed), 0, 10_000 if SLOW else 200
    for _ in range(count):
        problem = ruckig_problem(rng)
        expected = ruckigs_duration(problem)
        if expected is None:
            continue
        transfer = problem.solve()
        assert_sound_transfer(problem, transfer, transfer.inside_after)
        if transfer.inside_after > 0.0:
            continue
        if problem.keeping() == problem:
            assert transfer.duration == pytest.approx(expected, rel=1e-8, abs=1e-12), problem
        else:
            assert transfer.duration <= expected * (1.0 + 1e-8), problem
        compared += 1
    assert compared > 0.3 * count


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(4 if SLOW else 1))
def test_no_motion_that_a_linear_program_finds_is_faster(order, seed):
    """Between nodes 1/240 of the time apart it may exceed the velocity bounds by a little."""
    problem = random_transfer(np.random.default_rng((7, seed)), order)
    transfer = problem.solve()
    least = least_duration(problem, 1.2 * transfer.duration, cells=80)
    assert transfer.duration <= 1.001 * least, problem
    assert transfer.duration >= 0.97 * least, problem


@given(distance=st.floats(1e-3, 1e3), velocity=st.floats(1e-2, 1e2), power=st.floats(1e-2, 1e2))
def test_from_rest_to_rest_order_2_is_thompsons(distance, velocity, power):
    expected = thompson_order_2(distance, velocity, power)
    transfer = min_time_transfer(0.0, distance, Limits(velocity, power))
    assert transfer.duration == pytest.approx(expected.duration, rel=1e-13)
    assert [transfer.peak(k) for k in (1, 2)] == pytest.approx(expected.peaks, rel=1e-13)


# Identities


@given(problem=transfer_problems())
def test_transfers_are_sound(problem):
    transfer = problem.solve()
    assert_sound_transfer(problem, transfer)
    assert transfer.inside_after == 0.0
    assert transfer.violation(problem.limits) <= TRANSFER_BOUND
    assert transfer.limits == problem.limits


@given(problem=transfer_problems())
def test_the_opposite_transfer_is_the_mirror_image(problem):
    assert problem.mirrored().solve().duration == problem.solve().duration


@given(problem=transfer_problems())
def test_backwards_in_time_a_transfer_takes_as_long(problem):
    """Velocity and jerk bounds are mirrored; those of acceleration stay."""
    forth, back = problem.solve(), problem.backwards().solve()
    assert back.duration == pytest.approx(forth.duration, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_units_do_not_matter(seed):
    problem = random_transfer(np.random.default_rng(seed), 2 + seed % 2)
    duration = problem.solve().duration
    units = [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e10, 1e16]
    for distance, time in (each for u in units for each in ((u, 1.0), (1.0, u), (u, u**0.5))):
        scaled = problem.in_units(distance, time)
        transfer = scaled.solve()
        assert transfer.duration == pytest.approx(duration * time, rel=1e-10), scaled
        assert_sound_transfer(scaled, transfer)


@pytest.mark.parametrize(("distance", "time"), [(-30, 0), (53, 0), (0, 40), (7, -31), (-20, 11)])
def test_units_of_powers_of_two_do_not_matter_to_the_last_bit(distance, time):
    for seed in range(20):
        assert_the_same_in_powers_of_two(seed, distance, time)


def assert_the_same_in_powers_of_two(seed, distance, time):
    problem = random_transfer(np.random.default_rng(seed), 2 + seed % 2)
    scaled = problem.in_units(2.0**distance, 2.0**time)
    transfer, other = problem.solve(), scaled.solve()
    np.testing.assert_array_equal(other.durations, transfer.durations * 2.0**time, repr(problem))
    units = 2.0 ** (distance - time * np.arange(transfer.order + 1.0))
    np.testing.assert_array_equal(other.states, transfer.states * units, repr(problem))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(25))
def test_planned_again_on_the_way_the_rest_takes_the_time_left(order, seed):
    problem = random_transfer(np.random.default_rng(seed), order)
    problem = replace(problem, end=(problem.end[0], *[0.0] * (order - 1)))
    transfer = problem.solve()
    for part in (0.1, 0.37, 0.5, 0.8, 0.95, 0.999):
        time = part * transfer.duration
        there = tuple(transfer.evaluate(time)[:order].tolist())
        rest = replace(problem, start=there).solve()
        left = transfer.duration - time
        assert rest.duration == pytest.approx(left, abs=1e-5 * transfer.duration), (problem, part)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("shift", [-1e6, -3.7, 0.1, 1e3])
def test_only_the_distance_counts(seed, shift):
    problem = random_transfer(np.random.default_rng(seed), 2 + seed % 2)
    start, end = ((s[0] + shift, *s[1:]) for s in (problem.start, problem.end))
    moved = replace(problem, start=start, end=end)
    problem = replace(moved, start=(0.0, *start[1:]), end=(end[0] - start[0], *end[1:]))
    assert moved.solve().duration == pytest.approx(problem.solve().duration, rel=1e-8), moved


# What once failed, here or elsewhere


def test_constant_acceleration_to_a_velocity_the_bound_allows_no_more_of():
    """A crash of ruckig: the end would leave its velocity bound right afterwards."""
    limits = Limits(velocity=0.01, acceleration=1.0, jerk=100.0)
    transfer = min_time_transfer((0.0, -0.005, 1.0), (0.0, 0.005, 1.0), limits)
    assert transfer.duration == pytest.approx(0.01, rel=1e-15)
    assert transfer.states.tolist() == [[0.0, -0.005, 1.0, 0.0]]


@pytest.mark.parametrize("distance", [1e-3, 1e-9, 1e-16, 1e-30, 1e-90])
@pytest.mark.parametrize("order", [2, 3])
def test_tiny_moves(distance, order):
    """pantor/ruckig#141."""
    problem = TransferProblem(
        (0.0,) * order, (distance, *[0.0] * (order - 1)), ((-1.0, 1.0),) * order
    )
    transfer = problem.solve()
    expected = 2.0 * distance**0.5 if order == 2 else (32.0 * distance) ** (1.0 / 3.0)
    assert transfer.duration == pytest.approx(expected, rel=1e-12)
    assert_sound_transfer(problem, transfer)


@pytest.mark.parametrize("distance", [1e-15, 1e-12, -1e-12, -1e-9])
def test_tiny_moves_far_from_the_origin(distance):
    limits = Limits(velocity=1.0, acceleration=7.0, jerk=1000.0)
    start, end = 0.6283, 0.6283 + distance
    transfer = min_time_transfer(start, end, limits)
    assert transfer.duration == pytest.approx((32.0 * abs(end - start) / 1e3) ** (1 / 3), rel=1e-10)


@pytest.mark.parametrize(
    "state",
    [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (-3.0, 0.0, 0.5), (2.0, -1.0, 1.0), (1.0, 0.3, -0.1)],
)
def test_already_there(state):
    """pantor/ruckig#160."""
    transfer = min_time_transfer(state, state, Limits(1.0, 1.0, 1.0))
    assert transfer.duration == 0.0
    assert transfer.end_state.tolist() == [*state, 0.0]
    assert (transfer.inside_after, transfer.order) == (0.0, 3)


@pytest.mark.parametrize("unit", [1e5, 1e9, 1e16])
def test_large_units(unit):
    """pantor/ruckig#194."""
    bounds = ((-1.8, 1.8), (-20.0, 20.0), (-200.0, 200.0))
    problem = TransferProblem((0.4, 0.0, 0.0), (1.7, 0.9, -3.0), bounds)
    scaled = problem.in_units(unit, 1.0)
    transfer = scaled.solve()
    assert transfer.duration == pytest.approx(problem.solve().duration, rel=1e-13)
    assert_sound_transfer(scaled, transfer)


# Changes of velocity


@given(problem=transfer_problems())
def test_a_change_of_velocity_is_the_transfer_of_one_order_less(problem):
    """Velocity and acceleration are to it what position and velocity are to a transfer."""
    order, (_, v1, *a1) = len(problem.start), problem.end
    change = velocity_transfer(problem.start, v1, problem.limits, acceleration=sum(a1))
    assert change.inside_after == 0.0
    assert change.violation(problem.limits) <= TRANSFER_BOUND
    assert change.end_state[1:order].tolist() == [v1, *a1]
    if order == 3:
        below = Limits.from_bounds(problem.bounds[1:])
        expected = min_time_transfer(problem.start[1:], problem.end[1:], below).duration
    else:
        low, high = problem.bounds[1]
        expected = max((v1 - problem.start[1]) / low, (v1 - problem.start[1]) / high)
    assert change.duration == pytest.approx(expected, rel=1e-10, abs=1e-12)
    ended = replace(problem, end=(float(change.end_state[0]), *problem.end[1:]))
    assert_sound_transfer(ended, change)
    assert ended.solve().duration <= change.duration * (1.0 + 1e-7)


def test_a_change_of_velocity_brings_its_start_inside():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=2.0)
    change = velocity_transfer((7.0, 2.0), -1.0, limits)
    assert change.inside_after == pytest.approx(1.0, rel=1e-14)
    assert change.extremes("velocity") == pytest.approx((-1.0, 2.0), rel=1e-14)
    assert change.start_state[0] == 7.0


# What once failed


@pytest.mark.parametrize("acceleration", [-1e-8, -1e-10, -1e-12])
def test_an_acceleration_that_is_next_to_nothing_still_starts_the_motion(acceleration):
    """Rounding of its square made it zero, and the start another one."""
    limits = Limits(1.0, 1.0, 1.0)
    for transfer in (
        min_time_transfer((0.0, 0.5, acceleration), (0.0, 0.5), limits),
        min_time_transfers([0.0, 0.5, acceleration], [0.0, 0.5], limits)[0],
    ):
        assert transfer.start_state[:3].tolist() == [0.0, 0.5, acceleration]
        assert transfer.duration == pytest.approx(4.0, rel=1e-6)
