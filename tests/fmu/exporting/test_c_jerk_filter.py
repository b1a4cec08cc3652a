"""The jerk filter in C is the one in Python."""

import numpy as np
import pytest
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.shaping import JerkFilter, Limits, Trajectory, min_time_move

pytestmark = needs_compiler

NAMES = ("position", "velocity", "acceleration", "jerk")


def fourth():
    return JerkFilter(2.0, 4)


def single():
    return JerkFilter(0.7, 1)


def longest():
    return JerkFilter(5.0, 50)


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", [fourth, single, longest])
def test_a_step_after_uneven_steps(make, version):
    steps = np.random.default_rng(1).uniform(0.001, 0.15, 60)
    host = Host(fmu_of(make, version)).run(command=1.0)
    [position] = host.record(steps, "position")
    host.close()
    expected = make().step_response(np.add.accumulate(steps))
    np.testing.assert_allclose(position, expected, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_held_command_gives_the_response_to_a_staircase(version):
    dt, levels = 0.05, np.random.default_rng(6).normal(size=40)
    stairs = Trajectory(
        dt * np.arange(41.0), np.stack([levels, np.zeros(40)], axis=1), end_state=[0.0, 0.0]
    )
    host = Host(fmu_of(fourth, version)).run(start_position=levels[0])
    rows = host.record([dt] * 40, *NAMES, command=levels)
    host.close()
    expected = fourth().respond(stairs, dt, duration=2.0).states[:4, 1:]
    size = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(rows - expected) <= 1e-12 * size).all()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_command_with_its_derivatives_gives_the_response_to_a_trajectory(version):
    move = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0), start=3.0)
    dt = move.duration / 300.0
    times, states = dt * np.arange(300.0), move.evaluate(dt * np.arange(300.0))
    np.testing.assert_allclose(move.switch_times / dt % 1.0, 0.0, atol=1e-9)
    host = Host(fmu_of(fourth, version), start=float(times[0])).run(start_position=3.0)
    rows = host.record(
        [dt] * 300,
        *NAMES,
        command=states[0],
        command_velocity=states[1],
        command_acceleration=states[2],
    )
    host.close()
    expected = fourth().respond(move, dt, duration=move.duration).states[:4, 1:301]
    differences = 4.0 * fourth().omega ** np.arange(4.0)[:, None]  # of lags at position 4
    assert (np.abs(rows - expected) <= 1e-14 * differences).all()
    assert (np.abs(rows - expected) <= 1e-11 * np.abs(expected).max(axis=1, keepdims=True)).all()


def test_it_starts_as_after_coasting_for_ever():
    filtered = fourth()
    coasting = Trajectory([0.0, 1.0], [[2.0, 0.5, 0.0]])
    host = Host(fmu_of(fourth, "2.0")).run(start_position=2.0, start_velocity=0.5, command=2.0)
    lags = host.get(*(f"lag_{i}" for i in range(1, 5)))
    np.testing.assert_allclose(lags, filtered.steady_state(coasting), rtol=1e-15)
    np.testing.assert_allclose(host.get("velocity", "acceleration"), [0.5, 0.0], atol=1e-13)
    host.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_partial_derivatives_are_the_state_space(version):
    a, b = fourth().state_space()
    host = Host(fmu_of(fourth, version)).run()
    lags = [host.reference[f"lag_{i}"] for i in range(1, 5)]
    rates = [host.reference[f"der(lag_{i})"] for i in range(1, 5)]
    command, outputs = host.reference["command"], [host.reference[name] for name in NAMES]
    partial = host.fmu.getDirectionalDerivative
    np.testing.assert_allclose(
        np.array([partial(rates, [k], [1.0]) for k in lags]).T, a, rtol=1e-15
    )
    np.testing.assert_allclose(partial(rates, [command], [1.0]), b[:, 0], rtol=1e-15)
    expected = [fourth().derivative_weights(k) for k in range(4)]
    columns = [partial(outputs, [k], [1.0]) for k in (command, *lags)]
    np.testing.assert_allclose(np.array(columns).T, expected, rtol=1e-14)
    host.close()


def test_its_corner_can_be_tuned():
    host = Host(fmu_of(fourth, "3.0")).run(corner_hz=0.5, command=1.0)
    rows = host.record([0.1] * 30, "position")
    host.close()
    slower = JerkFilter(0.5, 4).step_response(np.add.accumulate([0.1] * 30))
    np.testing.assert_allclose(rows[0], slower, rtol=0.0, atol=1e-14)
