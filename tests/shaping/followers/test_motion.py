"""The motion inside a sample, however long: the transfer seen from a moving command."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import random_transfer, transfer_problems

from jounce.shaping import CommandFollower, Limits, min_time_transfer, velocity_transfer

SHARES = st.floats(-0.9375, 0.9375, width=32)


def motion_of(problem_limits, start, command, velocity, dt):
    return CommandFollower(problem_limits, dt=dt).motion(start, command, velocity)


def check_joints(motion, start, text):
    """Assert that it starts where it should, and is continuous below its highest derivative."""
    order = motion.order
    scale = np.abs(motion.states).max(axis=0) + 1e-300
    assert motion.states[0, :order] == pytest.approx(start[:order], rel=1e-13, abs=1e-13), text
    for k, (before, after) in enumerate(zip(motion.states, motion.states[1:], strict=False)):
        time = motion.durations[k]
        shape = np.polynomial.Polynomial(before / np.array([1.0, 1.0, 2.0, 6.0])[: order + 1])
        reached = [(shape.deriv(j) if j else shape)(time) for j in range(order)]
        assert (np.abs(reached - after[:order]) <= 1e-10 * scale[:order] + 1e-13).all(), (text, k)


@given(problem=transfer_problems(), share=SHARES)
def test_it_is_the_transfer_to_rest_as_seen_from_the_command(problem, share):
    low, high = problem.bounds[0] or (-3.0, 3.0)
    u = share * (high if share > 0.0 else -low)
    x, v, *a = problem.start
    seen = problem.bounds[0] and (low - u, high - u)
    relative = (x - problem.end[0], v - u, *a)
    transfer = min_time_transfer(relative, 0.0, Limits.from_bounds([seen, *problem.bounds[1:]]))
    dt = 1.25 * transfer.duration + 1.0
    motion = motion_of(problem.limits, (x, v, *a), problem.end[0], u, dt)
    text = (
        f"CommandFollower({problem.limits!r}, dt={dt}).motion({(x, v, *a)}, {problem.end[0]}, {u})"
    )
    check_joints(motion, (x, v, *a), text)
    times = np.linspace(0.0, dt, 50)
    expected = problem.end[0] + u * times + transfer(times)
    scale = np.abs(expected).max() + 1.0
    np.testing.assert_allclose(motion(times), expected, rtol=0, atol=1e-9 * scale, err_msg=text)
    assert motion.end_state[1] == pytest.approx(u, abs=1e-12), text


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_behind_a_command_at_the_bound_it_goes_to_the_bound_as_fast_as_it_can(order, seed):
    """It does not arrive at the command, and keeps the command's velocity beside it."""
    problem = random_transfer(np.random.default_rng((order, seed)), order)
    low, high = problem.bounds[0]
    for u, sign in ((high, 1.0), (low, -1.0)):
        spin_up = velocity_transfer(problem.start, u, problem.limits)
        dt = 2.0 * spin_up.duration + 1.0
        motion = motion_of(problem.limits, problem.start, problem.start[0] + 1e6 * sign, u, dt)
        times = np.linspace(0.0, dt, 50)
        expected = spin_up(times)  # which coasts at u
        np.testing.assert_allclose(motion(times), expected, rtol=0, atol=1e-9 * np.ptp(expected))


@pytest.mark.parametrize("order", [2, 3])
def test_at_the_command_nothing_is_left_to_do(order):
    limits = Limits.from_bounds([(-1.0, 2.0), (-3.0, 4.0), (-5.0, 6.0)][:order])
    for u in (-1.0, 0.0, 0.7, 2.0):
        motion = motion_of(limits, (7.0, u), 7.0, u, 0.01)
        assert motion.states.tolist() == [[7.0, u, *[0.0] * (order - 1)]]


@given(problem=transfer_problems(), share=SHARES)
def test_its_mirror_image_is_the_mirrored_motion(problem, share):
    u = share * min(map(abs, problem.bounds[0] or (3.0,)))
    start = np.array(problem.start)
    there = motion_of(problem.limits, start, 1.5, u, 0.5)
    back = motion_of(problem.mirrored().limits, -start, -1.5, -u, 0.5)
    assert back.durations.tolist() == there.durations.tolist(), (problem, u)
    assert back.states.tolist() == (-there.states).tolist(), (problem, u)


@pytest.mark.parametrize("start", [(2.0, 9.5, 0.0), (-1.0, 0.8, 9.0), (0.0, -6.5, -3.5)])
def test_a_start_beyond_the_bounds_begins_with_bringing_it_inside(start):
    pairs, u = [(-1.0, 2.0), (-3.0, 4.0), (-5.0, 6.0)], 0.5
    transfer = min_time_transfer(
        (start[0], start[1] - u, start[2]), 0.0, Limits.from_bounds([(-1.5, 1.5), *pairs[1:]])
    )
    assert transfer.inside_after > 0.0
    dt = transfer.duration + 1.0
    motion = motion_of(Limits.from_bounds(pairs), start, 0.0, u, dt)
    assert abs(motion.states[0, 3]) in (5.0, 6.0)
    check_joints(motion, start, start)
    np.testing.assert_allclose(motion.end_state[:3], [u * dt, u, 0.0], rtol=1e-12)
