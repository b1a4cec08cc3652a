"""The command follower in an FMU is the one in Python, to the last bit."""

import ctypes
import sys
from functools import partial

import numpy as np
import pytest
from fmus import SLOW, VERSIONS, Host, driven, fmu_of, needs_compiler, pointer
from tiers import some

from jounce.shaping import CommandFollower, JerkFilter, Limits

pytestmark = needs_compiler

SAMPLES = 1_000_000 if SLOW else 20_000
DT = 0.01

DRIVER = """
#include "block.h"
#include "numeric.h"
#include "following.c"
void drive(long n, const double *commands, const double *velocities, double *rows) {
    State s = {{0}, {0}, 0.0, -1.0, 0.0, 0, STEPPING};
    Cache cache = {0};
    long k, i;
    for (i = 0; i < N_VARIABLES; i++) {
        s.value[i] = variables[i].start;
    }
    core_initialize(&s);
    for (k = 0; k < n; k++) {
        s.value[V_COMMAND] = commands[k];
        s.value[V_COMMAND_VELOCITY] = velocities[k];
        core_step(&s, &cache, k * SAMPLE_TIME, SAMPLE_TIME);
        for (i = 0; i <= ORDER; i++) {
            rows[i * n + k] = s.value[V_POSITION + i];
        }
    }
}
"""

MAX = sys.float_info.max
EVEN = Limits(velocity=1.0, acceleration=2.0)
SMOOTH = Limits(velocity=(-1.0, 0.4), acceleration=(-3.0, 0.7), jerk=(-20.0, 30.0))
UNEVEN = Limits(velocity=(-1.0, 0.4), acceleration=(-3.0, 0.7))
FOLLOWERS = {
    "plain": partial(CommandFollower, EVEN, dt=DT),
    "uneven": partial(CommandFollower, UNEVEN, dt=DT),
    "unbounded velocity": partial(CommandFollower, Limits(acceleration=2.0), dt=DT),
    "period": partial(CommandFollower, UNEVEN, dt=DT, period=0.5),
    "jerk filter": partial(CommandFollower, EVEN, dt=DT, jerk_filter=JerkFilter(3.0, 4)),
    "order 3": partial(CommandFollower, SMOOTH, dt=DT),
    "order 3, period, filter": partial(
        CommandFollower, SMOOTH, dt=DT, period=0.5, jerk_filter=JerkFilter(3.0, 4)
    ),
    "order 3, nothing but jerk": partial(CommandFollower, Limits(jerk=30.0), dt=DT),
    "huge velocity and acceleration": partial(
        CommandFollower, Limits(MAX, (-MAX, 2.0), 9.0), dt=DT, period=0.5
    ),
    "huge jerk": partial(CommandFollower, Limits(1.0, 1.0, MAX), dt=DT),
    "huge acceleration": partial(CommandFollower, Limits(1.0, MAX), dt=DT),
    "uneven, filter": partial(CommandFollower, UNEVEN, dt=DT, jerk_filter=JerkFilter(20.0, 1)),
}


def commands(count, scale, seed):
    """Return random commands and velocities: steps, ramps, noise, rests."""
    rng = np.random.default_rng(seed)
    hold = np.repeat(rng.normal(size=count // 20 + 1), 20)[:count]
    speed = np.repeat(rng.normal(size=count // 50 + 1), 50)[:count]
    speed *= np.repeat(rng.random(count // 50 + 1) < 0.5, 50)[:count]
    ramp = np.cumsum(speed) * DT
    noise = rng.normal(size=count) * np.repeat(rng.random(count // 500 + 1) < 0.2, 500)[:count]
    return scale * (0.3 * hold + 0.05 * ramp + 0.1 * noise), scale * speed


def run_in_c(follower, given, speeds):
    rows = np.empty((follower.order + 1, given.size))
    driven(follower, DRIVER).drive(
        ctypes.c_long(given.size), pointer(given), pointer(speeds), pointer(rows)
    )
    return rows


@pytest.mark.parametrize("name", some(FOLLOWERS, 6))
def test_random_samples_agree_with_python(name):
    follower = FOLLOWERS[name]()
    given, speeds = commands(SAMPLES, 1.0, seed=7)
    expected = follower.run(given, command_velocities=speeds).states
    rows = run_in_c(follower, given, speeds)
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_units_do_not_matter(factor):
    limits = Limits(velocity=factor, acceleration=2.0 * factor)
    given, speeds = commands(2000, factor, seed=11)
    follower = CommandFollower(limits, dt=DT)
    expected = follower.run(given, command_velocities=speeds).states
    rows = run_in_c(follower, given, speeds)
    np.testing.assert_array_equal(rows, expected)


def follower_fmu():
    return FOLLOWERS["uneven"]()


def filtered_fmu():
    return FOLLOWERS["jerk filter"]()


STATES = ("position", "velocity", "acceleration")


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("make", [follower_fmu, filtered_fmu])
def test_the_fmu_follows_as_python_does(make, version):
    given, speeds = commands(300, 1.0, seed=3)
    follower = make()
    begin = (0.2, -0.1)
    expected = follower.run(given, command_velocities=speeds, initial=begin).states
    host = Host(fmu_of(make, version)).run(start_position=begin[0], start_velocity=begin[1])
    rows = host.record([DT] * 300, *STATES, command=given, command_velocity=speeds)
    host.close()
    np.testing.assert_allclose(rows[0], expected[0], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(rows, expected, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("make", [follower_fmu, filtered_fmu])
def test_shorter_steps_show_the_motion_inside_the_sample(make):
    follower = make()
    fine = CommandFollower(follower.limits, dt=DT / 5.0, jerk_filter=follower.jerk_filter)
    rng = np.random.default_rng(0)
    targets = rng.normal(size=60)
    expected = fine.run(np.repeat(targets, 5)).states
    host = Host(fmu_of(make, "2.0")).run()
    rows = host.record([DT / 5.0] * 300, *STATES, command=np.repeat(targets, 5))
    host.close()
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(rows[:2] - expected[:2]) <= 1e-11 * scale[:2]).all()


def test_a_command_within_a_sample_waits_for_the_next():
    host, other = (Host(fmu_of(follower_fmu, "3.0")).run(command=0.5) for _ in range(2))
    for one, changed in ((host, 0.5), (other, -0.5)):
        one.step(0.5 * DT)
        one.set(command=changed)
        one.step(0.5 * DT)
    assert host.get(*STATES) == other.get(*STATES)
    other.set(command=0.5)
    host.step(DT)
    other.step(DT)
    assert host.get(*STATES) == other.get(*STATES)
    host.close()
    other.close()


def test_limits_can_be_tuned_while_it_runs():
    host = Host(fmu_of(follower_fmu, "2.0")).run(command=10.0)
    follower = follower_fmu()
    for _ in range(40):
        host.step(DT)
    state = follower.run(np.full(40, 10.0)).states[:, -1]
    np.testing.assert_array_equal(host.get(*STATES), state)
    host.set(velocity_max=1.5, acceleration_max=5.0)
    faster = CommandFollower(Limits(velocity=(-1.0, 1.5), acceleration=(-3.0, 5.0)), dt=DT)
    expected = faster.run(np.full(40, 10.0), initial=tuple(state)).states
    rows = host.record([DT] * 40, *STATES)
    host.close()
    np.testing.assert_allclose(rows, expected, rtol=1e-13)
