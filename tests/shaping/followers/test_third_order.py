"""Following with bounded jerk: the motion inside samples, ramps, no chatter."""

import os
from math import copysign

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import replay
from strategies import COMMANDS, Following, random_following

from jounce.shaping import CommandFollower, Limits, min_time_transfer, velocity_transfer

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
SEEDS = range(20 if SLOW else 3)
BOTH_WAYS = Limits(velocity=(-0.6, 1.1), acceleration=(-1.7, 0.8), jerk=(-3.0, 2.0))
"""Bounds that differ between the directions."""


def sizes(following, states):
    """Return the size of each derivative; positions are seen from the commands."""
    found = np.abs(states).max(axis=1)
    found[0] += max(map(abs, following.commands))
    return found


# Inside samples


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_each_sample_is_the_begin_of_a_transfer_towards_the_command(seed, kind, moving):
    """So that bounds and continuity hold between samples too: each piece integrated anew."""
    following = random_following(np.random.default_rng((3, seed)), 3, kind, moving=moving)
    states = following.states()
    again = replay(following.motion(states))
    units = sizes(following, states)
    for k in range(3):
        assert again.gaps[k] <= 1e-9 * units[k], (following, k)
    for k, (low, high) in enumerate(following.bounds, start=1):
        least, most = again.extremes[k]
        assert low * (1.0 + 1e-10) <= least, (following, k)
        assert most <= high * (1.0 + 1e-10), (following, k)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("kind", [*COMMANDS, "huge"])
@pytest.mark.parametrize("seed", SEEDS)
def test_no_bound_is_exceeded_at_any_sample(seed, kind, moving):
    following = random_following(np.random.default_rng((4, seed)), 3, kind, moving=moving)
    states, dt = following.states(), following.dt
    for k, (low, high) in enumerate(following.bounds, start=1):
        rounding = 0.0 if k == 1 else 1e-13
        assert low * (1.0 + rounding) <= states[k].min(), (following, k)
        assert states[k].max() <= high * (1.0 + rounding), (following, k)
    for k, (low, high) in enumerate(following.bounds[1:], start=1):
        change = np.diff(states[k])
        slack = 1e-12 * (high - low) * dt + 1e-15 * sizes(following, states)[k]
        if k == 1:  # a velocity reached by the way to a command is as exact as that allows
            slack += 1e-9 * sizes(following, states)[k]
        assert low * dt - slack <= change.min(), (following, k)
        assert change.max() <= high * dt + slack, (following, k)


# Plans


@given(
    seed=st.integers(0, 2**31),
    offset=st.sampled_from([0.0, 1.0, 1e6, 1e12]),
    pace=st.floats(-1.5, 0.5),
)
def test_a_constant_command_is_not_overshot_and_nothing_chatters(seed, offset, pace):
    """Sign changes of acceleration: those of the transfer; once there it stays exactly."""
    problem = random_following(np.random.default_rng(seed), 3)
    start = (offset + problem.start[0], *problem.start[1:])
    command = offset + problem.commands[0] + copysign(1.0, problem.commands[0])
    transfer = min_time_transfer(start, command, problem.limits)
    dt = transfer.duration * 10.0**pace
    there = 1 + int(transfer.duration / dt)
    following = Following(start, problem.bounds, dt, (command,) * (there + 8))
    states = following.states()[:, 1:]
    low, high = transfer.extremes(0)
    ulp = 2.0**-52 * (max(-low, high, abs(command)) + high - low)
    assert (states[0] <= max(high, command) + 4.0 * ulp).all(), following
    assert (states[0] >= min(low, command) - 4.0 * ulp).all(), following
    middles = 0.5 * (transfer.breaks[:-1] + transfer.breaks[1:])
    turns = np.sort([*transfer.breaks[:-1], *middles])
    assert sign_changes(states[2]) <= sign_changes(transfer(turns, 2)), following
    resting = {tuple(state) for state in states[:, there:].T.tolist()}
    assert resting == {(command, 0.0, 0.0, 0.0)}, following


def sign_changes(values):
    signs = np.sign(values[np.abs(values) > 1e-13 * np.abs(values).max()])
    return int(np.count_nonzero(np.diff(signs)))


@pytest.mark.parametrize(
    "start",
    [(0.0, 5.0, 0.0), (0.0, -3.0, 0.5), (0.0, 0.2, 3.0), (0.0, -0.5, -4.0), (0.0, 1.0, 0.79)],
)
def test_a_start_beyond_its_bounds_or_bound_to_leave_them_is_brought_inside(start):
    """Jerk at its bound until it is: as a transfer does, which takes `inside_after`."""
    for command in (30.0, -30.0):
        transfer = min_time_transfer(start, command, BOTH_WAYS)
        assert transfer.inside_after > 0.0
        dt = transfer.inside_after / 7.5
        response = CommandFollower(BOTH_WAYS, dt=dt).run([command] * 30, initial=start)
        expected = transfer.evaluate(response.time)
        np.testing.assert_allclose(response.states[:3], expected[:3], rtol=1e-12, atol=1e-12)
        inside = response.states[:, 8:]
        for k in (1, 2):
            low, high = BOTH_WAYS.bounds(k)
            assert low <= inside[k].min() * (1.0 - 1e-14)
            assert inside[k].max() * (1.0 - 1e-14) <= high


# Moving commands


def ramp(u, count, dt, start=0.0):
    return [start + u * dt * k for k in range(count)]


@pytest.mark.parametrize("u", [0.5, -0.4, 0.0])
@pytest.mark.parametrize("begin", [2.0, -2.0])
def test_a_ramp_given_with_its_velocity_is_caught_up_and_followed_without_lag(u, begin):
    count, dt = 1500, 0.02
    commands = np.array(ramp(u, count, dt, start=begin))
    initial = (0.0, 0.1, -0.2)
    states = (
        CommandFollower(BOTH_WAYS, dt=dt)
        .run(commands, command_velocities=u, initial=initial)
        .states
    )
    seen = Limits(velocity=(-0.6 - u, 1.1 - u), acceleration=(-1.7, 0.8), jerk=(-3.0, 2.0))
    there = 1 + int(min_time_transfer((-begin, 0.1 - u, -0.2), 0.0, seen).duration / dt)
    expected = commands + u * dt
    assert 0 < there < 1000
    np.testing.assert_allclose(states[0, there:], expected[there:], rtol=1e-15, atol=1e-15)
    assert (states[1, there:] == u).all()
    assert (states[2:, there:] == 0.0).all()
    assert abs(states[0, there - 3] - expected[there - 3]) > 1e-7


@pytest.mark.parametrize("u", [1.1, -0.6])
def test_a_ramp_at_the_velocity_bound_is_waited_for_but_cannot_be_caught_up(u):
    count, dt, sign = 3000, 0.01, copysign(1.0, u)
    spin_up = velocity_transfer((0.0, 0.1), u, BOTH_WAYS)
    lost = sign * (u * spin_up.duration - spin_up.end_state[0])
    for begin in (2.0, -2.0):  # ahead in the direction of the ramp, and behind
        commands = ramp(u, count, dt, start=begin * sign)
        response = CommandFollower(BOTH_WAYS, dt=dt).run(
            commands, command_velocities=u, initial=(0.0, 0.1)
        )
        lag = sign * (commands[-1] + u * dt - response.states[0, -1])
        expected = begin + lost if begin > 0.0 else 0.0
        assert lag == pytest.approx(expected, abs=1e-13 * np.abs(commands).max())
        assert (response.states[1, -500:] == u).all()
        assert (response.states[2:, -500:] == 0.0).all()


@pytest.mark.parametrize("u", [0.5, -0.4])
def test_without_its_velocity_a_ramp_is_followed_at_the_distance_of_a_stop(u):
    """Where the jerk hardly takes time: a lag of v²/(2·a), or a few samples' way from it."""
    count, dt = 3000, 0.004
    limits = Limits(velocity=BOTH_WAYS.bounds(1), acceleration=(-1.7, 0.8), jerk=1e4)
    commands = ramp(u, count, dt)
    states = CommandFollower(limits, dt=dt).run(commands).states
    lag = np.abs(np.array(commands) - states[0])[-500:]
    stop = u * u / (2.0 * (1.7 if u > 0.0 else 0.8))
    assert np.abs(lag - stop).max() <= 2.0 * abs(u) * dt
    assert np.abs(states[1, -500:] - u).max() <= 1.7 * dt


@pytest.mark.parametrize("told", [False, True])
@pytest.mark.parametrize("u", [3.0, -2.0])
def test_a_ramp_beyond_the_velocity_bound_is_chased_at_the_bound(u, told):
    count, dt = 300, 0.04
    top = BOTH_WAYS.bounds(1)[u > 0.0]
    response = CommandFollower(BOTH_WAYS, dt=dt).run(
        ramp(u, count, dt, start=u), command_velocities=u if told else None
    )
    spin_up = velocity_transfer(0.0, top, BOTH_WAYS)
    expected = spin_up.evaluate(response.time, 2)
    np.testing.assert_allclose(response.states[:3], expected, rtol=1e-10, atol=1e-12)
    assert response.states[1:, -1].tolist() == [top, 0.0, 0.0]
