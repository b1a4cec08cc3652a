"""Following with bounded acceleration: the motion inside samples, ramps, bounds, no chatter."""

import os
import time
from math import copysign, inf, sqrt
from sys import float_info

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import replay
from strategies import COMMANDS, Following, random_following

from jounce.shaping import CommandFollower, Limits, min_time_transfer, velocity_transfer

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
SEEDS = range(20 if SLOW else 4)
V_MIN, V_MAX, UP, DOWN = -0.6, 1.1, 0.8, 1.7
BOTH_WAYS = Limits(velocity=(V_MIN, V_MAX), acceleration=(-DOWN, UP))
"""Bounds that differ between the directions."""


def follow(start, commands, dt, velocities=None, limits=BOTH_WAYS):
    """Return position, velocity and acceleration at the end of each sample."""
    follower = CommandFollower(limits, dt=dt)
    return follower.run(commands, command_velocities=velocities, initial=start).states


def rounding(following, states):
    """Return what rounding leaves of a position, and of a velocity that follows from it."""
    position = 1e-15 * (np.abs(states[0]).max() + max(map(abs, following.commands)))
    fastest = np.abs(states[1]).max() + max(map(abs, following.speeds))
    return position, 1e-15 * fastest + sqrt(position * max(map(abs, following.bounds[1])))


# Inside samples


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_each_sample_is_the_begin_of_a_transfer_towards_the_command(seed, kind, moving):
    """So that bounds and continuity hold between samples too: each piece integrated anew."""
    following = random_following(np.random.default_rng((2, seed)), 2, kind, moving=moving)
    states = following.states()
    again = replay(following.motion(states))
    position, velocity = rounding(following, states)
    scale = 1e-12 * np.abs(states[0]).max()
    assert again.gaps[0] <= scale + position, following
    assert again.gaps[1] <= 1e-12 * np.abs(states[1]).max() + velocity, following
    for k, (low, high) in enumerate(following.bounds, start=1):
        least, most = again.extremes[k]
        assert low * (1.0 + 1e-12) <= least, (following, k)
        assert most <= high * (1.0 + 1e-12), (following, k)


def textbook(start, command, dt, parts):
    """Return the state after a sample of the switching law e = ∓v²/(2·a), in many small parts."""
    x, v, h = *start, dt / parts
    for _ in range(parts):
        e = x - command
        ahead = e + v * v / (2.0 * DOWN) if v > 0.0 else e - v * v / (2.0 * UP)
        later = min(max(v + (UP if ahead < 0.0 else -DOWN) * h, V_MIN), V_MAX)
        x, v = x + 0.5 * (v + later) * h, later
    return x, v


@pytest.mark.parametrize("seed", range(3))
def test_samples_agree_with_the_textbook_switching_law_in_small_parts(seed):
    """It chatters, by the way of one part of a sample and the velocity that this takes."""
    rng, state, parts = np.random.default_rng(seed), (0.3, -0.2), 2500
    for command in np.repeat(rng.normal(size=5), 4).tolist():
        dt = float(10.0 ** rng.uniform(-1.0, 0.3))
        expected = textbook(state, command, dt, parts)
        x, v, _ = follow(state, [command], dt)[:, 0].tolist()
        text = f"CommandFollower({BOTH_WAYS}, dt={dt}).step({state}, {command})"
        assert x == pytest.approx(expected[0], abs=4.0 * dt / parts), text
        assert v == pytest.approx(expected[1], abs=2.0 * dt / sqrt(parts)), text
        state = x, v


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("kind", [*COMMANDS, "huge"])
@pytest.mark.parametrize("seed", SEEDS)
def test_no_bound_is_exceeded_at_any_sample(seed, kind, moving):
    following = random_following(np.random.default_rng((3, seed)), 2, kind, moving=moving)
    states = following.states()
    (low, high), (least, most) = following.bounds
    assert ((low <= states[1]) & (states[1] <= high)).all(), following
    assert set(states[2, 1:].tolist()) <= {least, most, 0.0, -0.0}, following
    gain, slack = np.diff(states[1]), 1e-15 * np.abs(states[1]).max()
    if kind != "huge":  # where the resolution of positions is 1e284
        slack += rounding(following, states)[1]
    assert gain.min() >= least * following.dt - slack, following
    assert gain.max() <= most * following.dt + slack, following


@pytest.mark.parametrize("size", [5e-324, 1e-310, 1e-200])
def test_commands_around_the_least_number_are_followed(size):
    commands = size * (-1.0) ** np.arange(30)
    states = follow((0.25, 0.0), commands, 0.5)
    np.testing.assert_array_equal(states[0, 4:], commands[4:])
    assert (states[1, 4:] == 0.0).all()


# Constant commands


@given(
    seed=st.integers(0, 2**31),
    offset=st.sampled_from([0.0, 1.0, 1e6, 1e12]),
    pace=st.floats(-2.0, 0.5),
)
def test_a_constant_command_is_not_overshot_and_nothing_chatters(seed, offset, pace):
    """Sign changes of acceleration: those of the transfer; once there it stays exactly."""
    problem = random_following(np.random.default_rng(seed), 2)
    start = (offset + problem.start[0], problem.start[1])
    command = offset + problem.commands[0] + copysign(1.0, problem.commands[0])
    transfer = min_time_transfer(start, command, problem.limits)
    dt = transfer.duration * 10.0**pace
    there = 1 + int(transfer.duration / dt)
    resting = 8 + int(1e-3 * offset**0.5)
    following = Following(start, problem.bounds, dt, (command,) * (there + resting))
    low, high = transfer.extremes(0)
    ulp = 2.0**-52 * (max(-low, high, abs(command)) + high - low)
    for states in (following.states()[:, 1:], np.array(following.steps()).T):
        assert (states[0] <= max(high, command) + 4.0 * ulp).all(), following
        assert (states[0] >= min(low, command) - 4.0 * ulp).all(), following
        assert sign_changes(states[2]) <= sign_changes(transfer.states[:, 2]), following
        resting = states[:, there:] if offset < 1e12 else states[:, -1:]
        assert {tuple(state) for state in resting.T.tolist()} == {(command, 0.0, 0.0)}, following


def sign_changes(values):
    signs = np.sign(values[values != 0.0])
    return int(np.count_nonzero(np.diff(signs)))


@pytest.mark.parametrize("excess", [3.0, -2.5])
def test_a_start_beyond_the_velocity_bounds_is_slowed_down_as_fast_as_allowed(excess):
    count, dt = 60, 0.1
    change = -DOWN if excess > 0.0 else UP
    for command in (1e3, -1e3):
        _, vs, accelerations = follow((0.0, excess), [command] * count, dt)
        beyond = (vs < V_MIN) | (vs > V_MAX)
        number = np.count_nonzero(beyond)
        assert beyond[:number].all()
        expected = excess + change * dt * np.arange(1, number + 1)
        np.testing.assert_allclose(vs[:number], expected, rtol=1e-13)
        assert (accelerations[:number] == change).all()
        assert vs[-1] == (V_MAX if command > 0.0 else V_MIN)


# Moving commands


@given(seed=st.integers(0, 2**31), share=st.floats(-0.9, 0.9), kind=st.sampled_from(COMMANDS))
def test_seen_from_a_steadily_moving_observer_nothing_changes(seed, share, kind):
    """Sample by sample, as rounding grows where commands alternate."""
    given = random_following(np.random.default_rng(seed), 2, kind)
    (low, high), accelerations = given.bounds
    u, dt, states = share * min(-low, high), given.dt, given.states()
    limits = Limits(velocity=(low + u, high + u), acceleration=accelerations)
    follower = CommandFollower(limits, dt=dt)
    position, velocity = rounding(given, states)
    for (x, v, _), later, command in zip(states.T, states.T[1:], given.commands, strict=False):
        moved, faster, a = follower.step((x, v + u), command, u)
        text = f"CommandFollower({limits}, dt={dt}).step({(x, v + u)}, {command}, {u})"
        slack = position + 1e-15 * dt * (high - low)
        assert moved - u * dt == pytest.approx(later[0], rel=1e-14, abs=slack), text
        assert faster - u == pytest.approx(later[1], abs=velocity + 1e-15 * (high - low)), text
        assert a in (later[2], 0.0) or later[2] == 0.0, text


def ramp(u, count, dt, start=0.0):
    return [start + u * dt * k for k in range(count)]


@pytest.mark.parametrize("u", [0.5, -0.4, 0.0])
@pytest.mark.parametrize("begin", [2.0, -2.0])
def test_a_ramp_given_with_its_velocity_is_caught_up_and_followed_without_lag(u, begin):
    count, dt = 3000, 0.01
    commands = np.array(ramp(u, count, dt, start=begin))
    states = follow((0.0, 0.1), commands, dt, u)
    seen = Limits(velocity=(V_MIN - u, V_MAX - u), acceleration=(-DOWN, UP))
    there = 1 + int(min_time_transfer((-begin, 0.1 - u), 0.0, seen).duration / dt)
    expected = commands + u * dt
    assert 0 < there < 2000
    np.testing.assert_allclose(states[0, there:], expected[there:], rtol=1e-15, atol=1e-15)
    assert (states[1, there:] == u).all()
    assert (states[2, there:] == 0.0).all()
    assert abs(states[0, there - 2] - expected[there - 2]) > 1e-7


@pytest.mark.parametrize("u", [1.1, -0.6])
def test_a_ramp_at_the_velocity_bound_is_waited_for_but_cannot_be_caught_up(u):
    count, dt, sign = 3000, 0.01, copysign(1.0, u)
    for begin in (2.0, -2.0):  # ahead in the direction of the ramp, and behind
        commands = ramp(u, count, dt, start=begin * sign)
        states = follow((0.0, 0.1), commands, dt, u)
        lag = (commands[-1] + u * dt - states[0, -1]) * sign
        lost = begin + (u - 0.1) ** 2 / (2.0 * (UP if u > 0.1 else DOWN)) if begin > 0.0 else 0.0
        assert lag == pytest.approx(lost, rel=1e-12, abs=1e-11), begin
        assert (states[1, -500:] == u).all()
        assert (states[2, -500:] == 0.0).all()


@pytest.mark.parametrize("u", [0.5, -0.4])
def test_without_its_velocity_a_ramp_is_followed_at_the_distance_of_a_stop(u):
    """Decelerating lands on the command: the lag is v²/(2·a), or a few samples' way from it."""
    count, dt = 4000, 0.002
    commands = ramp(u, count, dt)
    states = follow((0.0, 0.0), commands, dt)
    lag = np.abs(commands - states[0])[-500:]
    stop = u * u / (2.0 * (DOWN if u > 0.0 else UP))
    assert np.abs(lag - stop).max() <= 2.0 * abs(u) * dt
    assert np.abs(states[1, -500:] - u).max() <= DOWN * dt


@pytest.mark.parametrize("u", [3.0, -2.0])
@pytest.mark.parametrize("told", [False, True])
def test_a_ramp_beyond_the_velocity_bound_is_chased_at_the_bound(u, told):
    count, dt, top = 500, 0.02, V_MAX if u > 0.0 else V_MIN
    states = follow((0.0,), ramp(u, count, dt, start=u), dt, u if told else None)
    expected = velocity_transfer(0.0, top, BOTH_WAYS)(dt * np.arange(1, count + 1))
    np.testing.assert_allclose(states[0], expected, rtol=1e-12, atol=1e-13)
    assert states[1:, -1].tolist() == [top, 0.0]


def test_without_a_velocity_bound_it_never_cruises():
    limits = Limits(acceleration=2.0)
    response = CommandFollower(limits, dt=0.01).run([50.0] * 1100)
    assert response.states[1].max() == pytest.approx(10.0, rel=1e-12)
    assert response.states[:, -1].tolist() == [50.0, 0.0, 0.0]
    assert limits.bounds(1) == (-inf, inf)


@pytest.mark.skipif(not SLOW, reason="a million samples; JOUNCE_TIER=slow")
def test_a_million_samples():
    rng, count, dt = np.random.default_rng(0), 1_000_000, 1e-3
    commands = np.sin(np.arange(count) * 1e-3) + 0.01 * rng.normal(size=count)
    begin = time.perf_counter()
    states = follow((0.0,), commands, dt)
    assert time.perf_counter() - begin < 10.0
    assert states.shape == (3, count)
    assert states[1].min() >= V_MIN
    assert states[1].max() <= V_MAX
    change = np.diff(states[1]) / dt
    assert change.max() <= UP * (1.0 + 1e-6)
    assert change.min() >= -DOWN * (1.0 + 1e-6)


@pytest.mark.parametrize("bound", [1e-320, 1e-310, 1e-300])
@pytest.mark.parametrize("command", [5.0, -5.0])
def test_the_least_bounds_are_kept_to_the_last_bit(command, bound):
    limits = Limits(velocity=(-bound, bound), acceleration=(-float_info.max, 14.0))
    states = CommandFollower(limits, dt=75.0).run(np.full(5, command)).states
    assert (np.abs(states[1]) <= bound).all()
    assert abs(states[1, -1]) == pytest.approx(bound, rel=0.01)


def test_accelerations_stay_finite_in_the_shortest_of_samples():
    limits = Limits(velocity=(-1.0, 0.07), acceleration=(-20.0, float_info.max))
    commands = [0.0, 1e-160, 0.0, 9.7e233, 0.0, -1e300]
    follower = CommandFollower(limits, dt=1e-320, period=0.19)
    states = follower.run(commands).states
    assert np.isfinite(states).all()
    state = (0.0, 0.0)
    for command, column in zip(commands, states.T, strict=True):
        state = follower.step(state, command)
        assert state == tuple(column)


def test_times_beyond_the_range_are_refused():
    follower = CommandFollower(Limits(velocity=1.0, acceleration=1.0), dt=float_info.max)
    assert follower.step((0.0, 0.0), 1.0)[0] == 1.0
    with pytest.raises(ValueError, match="leaves the range of a double"):
        follower.run([1.0, 1.0])
