"""Steady motions: ramps of a rate limiter, and followers on arrays as CommandFollower.run."""

from math import pi

import numpy as np
import pytest
from tiers import some

from jounce.analysis.frequency_view.periodic import (
    REPEATS,
    TRIANGLE,
    follower_cycle,
    follower_states,
    ramp_angles,
    rate_limited,
    rate_limited_harmonic,
    second_order_half,
)
from jounce.shaping import CommandFollower, Limits

MODES = pytest.mark.parametrize("with_velocity", [False, True], ids=["position", "velocity"])


def random_bounds(count, seed):
    rng = np.random.default_rng(seed)
    return 10.0 ** np.array([rng.uniform(-2.0, 1.0, count), rng.uniform(-2.0, 4.0, count)])


def test_ramps_begin_and_end_on_the_sine():
    slope = np.concatenate([np.linspace(0.001, 1.0, 2000), 1.0 - np.geomspace(1e-16, 0.1, 200)])
    begin, end = ramp_angles(slope)
    np.testing.assert_allclose(np.sin(end) - np.sin(begin), slope * (end - begin), atol=2e-15)
    partly = slope * TRIANGLE > 1.0
    np.testing.assert_allclose(np.cos(begin[partly]), slope[partly], rtol=1e-14)
    assert (np.cos(end) <= slope).all()
    assert (np.cos(end[partly]) >= -slope[partly] - 1e-14).all()
    assert (np.cos(end[~partly]) <= -slope[~partly]).all()
    np.testing.assert_allclose((end - begin)[~partly], pi, rtol=1e-15)


def test_the_ramp_that_just_becomes_a_triangle_wave():
    """Its ends are tan θ = ±π/2."""
    [begin], [end] = ramp_angles(np.array([(1.0 + 1e-12) / TRIANGLE]))
    assert np.tan(begin) == pytest.approx(-pi / 2.0, abs=1e-10)
    assert end - begin == pytest.approx(pi, abs=1e-10)


@pytest.mark.parametrize("slope", [0.01, 0.3, 0.6, 0.9, 1.0, 7.0])
def test_a_rate_limiter_keeps_its_rate_and_is_ahead_of_itself_by_half_a_period(slope):
    theta = np.linspace(-9.0, 9.0, 4001)
    output = rate_limited(theta, slope)
    rate = np.diff(output) / np.diff(theta)
    assert np.abs(rate).max() <= min(slope, 1.0) + 1e-9
    np.testing.assert_allclose(rate_limited(theta + pi, slope), -output, atol=1e-12)
    off = output - np.sin(theta)
    behind = off[1:] * off[:-1] > 1e-12  # then it moves towards the sine as fast as it may
    np.testing.assert_allclose(rate[behind], -slope * np.sign(off[1:])[behind], rtol=1e-9)
    total = (
        1j
        / pi
        * np.trapezoid(
            rate_limited(np.linspace(0.0, 2.0 * pi, 4001), slope)
            * np.exp(-1j * np.linspace(0.0, 2.0 * pi, 4001)),
            dx=2.0 * pi / 4000,
        )
    )
    assert abs(total - rate_limited_harmonic(np.array([slope]))[0]) < 1e-5


@MODES
def test_half_periods_are_those_of_the_follower(with_velocity):
    bounds, rng = random_bounds(60, 4), np.random.default_rng(5)
    states = rng.uniform(-1.0, 1.0, (2, 60)) * np.array([np.ones(60), np.minimum(bounds[0], 3.0)])
    counts = np.sort(rng.choice([8, 10, 64, 130], 60))[::-1]
    total = np.zeros(60, dtype=complex)
    ends = second_order_half(states, bounds, counts, with_velocity, total)
    for i, count in enumerate(counts.tolist()):
        theta = 2.0 * pi / count * np.arange(count // 2)
        follower = CommandFollower(Limits(*bounds[:, i]), dt=2.0 * pi / count)
        run = follower.run(
            np.sin(theta),
            command_velocities=np.cos(theta) * with_velocity,
            initial=states[:, i],
        )
        told = (bounds[:, i].tolist(), states[:, i].tolist(), count)
        np.testing.assert_allclose(ends[:, i], run.states[:2, -1], atol=1e-13, err_msg=str(told))
        rows = follower_states(states[:, i], bounds[:, i], count, with_velocity)
        np.testing.assert_array_equal(rows[:, 1:], run.states[:2])


def test_the_moments_of_the_pieces_are_those_of_finer_samples():
    """Held commands, replanned 64 times as often; by parts from the positions."""
    bounds, count, parts = random_bounds(20, 6), 16, 64
    states = np.zeros((2, 20))
    total = np.zeros(20, dtype=complex)
    second_order_half(states, bounds, np.full(20, count), False, total)
    theta = np.linspace(0.0, pi, count // 2 * parts + 1)
    commands = np.repeat(np.sin(2.0 * pi / count * np.arange(count // 2)), parts)
    for i in range(20):
        follower = CommandFollower(Limits(*bounds[:, i]), dt=theta[1])
        x = np.concatenate([[0.0], follower.run(commands).states[0]])
        turned = np.exp(-1j * theta)
        expected = x[-1] * turned[-1] + 1j * np.trapezoid(x * turned, theta)
        assert abs(total[i] - expected) < 3e-4 * max(np.abs(x).max(), 1e-3), bounds[:, i]


@MODES
@pytest.mark.parametrize("count", some([8, 64, 600], 2))
def test_cycles_repeat(count, with_velocity):
    bounds = random_bounds(400, count)
    states, apart = follower_cycle(bounds, np.full(400, count), with_velocity)
    assert np.count_nonzero(apart > REPEATS) <= 8  # as its docstring tells
    assert apart.max() < 0.01
    after = second_order_half(states, bounds, np.full(400, count), with_velocity)
    off = np.abs(after + states).max(axis=0) / np.minimum(bounds.min(axis=0), 1.0)
    np.testing.assert_allclose(off, apart, atol=1e-10)


def test_cycles_of_third_order_repeat():
    bounds = np.array([[0.7, 2.0], [1.5, 3.0], [20.0, 9.0]])
    states, apart = follower_cycle(bounds, np.array([64, 32]), False)
    assert apart.max() < REPEATS
    for i, count in enumerate((64, 32)):
        follower = CommandFollower(Limits(*bounds[:, i]), dt=2.0 * pi / count)
        theta = 2.0 * pi / count * np.arange(count)
        run = follower.run(np.sin(theta), initial=states[:, i])
        np.testing.assert_allclose(run.states[:3, -1], states[:, i], atol=1e-9)
