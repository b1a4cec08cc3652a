"""Axes with friction, limit and load as FMU and C, against closed forms and the simulation."""

from math import sqrt

import every_block
import numpy as np
import pytest
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu.exporting.dispatch import block_of
from jounce.plant import (
    PID,
    Axis,
    Controller,
    Friction,
    ServoLoop,
    TorqueSteps,
)
from jounce.shaping import Limits, min_time_move

pytestmark = needs_compiler


def box():
    return Axis(2.0, friction=Friction(1.0, 1.5), torque_limit=5.0)


def steps(rng, total, longest):
    """Return random lengths that add up to a total."""
    ends = np.append(np.sort(rng.uniform(0.0, total, int(3.0 * total / longest))), total)
    return np.diff(np.append(0.0, ends))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("seed", some(range(3), 2))
def test_a_box_is_pushed_slides_stops_and_sticks_whatever_the_steps(version, seed):
    rng = np.random.default_rng(seed)
    host = Host(fmu_of(box, version)).run(u=1.4)
    host.record(steps(rng, 0.5, 0.2), "y")
    assert host.get("y", "y_rate", "sliding") == [0.0, 0.0, 0.0]
    host.set(u=9.0)  # limited to 5: acceleration (5 - 1)/2
    host.record(steps(rng, 0.3, 0.1), "y")
    np.testing.assert_allclose(host.get("y", "y_rate"), [0.09, 0.6], rtol=1e-13)
    assert host.get("torque", "sliding") == [5.0, 1.0]
    host.set(u=-9.0, d_motor=2.0)  # -5 + 2 - 1: backwards at 2, until it is still; then forwards
    back, last = 0.6 / 2.0, 0.25
    host.record(steps(rng, back + last, 0.1), "y")
    turned = 0.09 + 0.5 * 0.6 * back
    expected = [turned - 0.5 * 1.0 * last**2, -1.0 * last]  # (-5 + 2 + 1)/2
    np.testing.assert_allclose(host.get("y", "y_rate"), expected, rtol=1e-12)
    assert host.get("sliding") == [-1.0]
    host.set(u=0.0, d_motor=0.0)
    host.record(steps(rng, 1.0, 0.3), "y")
    stopped = expected[0] - last**2  # v²/(2·0.5)
    np.testing.assert_allclose(host.get("y"), [stopped], rtol=1e-12)
    assert host.get("y_rate", "sliding") == [0.0, 0.0]
    host.close()


def edged():
    return Axis(1.0, current_lag=1e-3, friction=Friction(0.2))


@pytest.mark.parametrize("push", [0.2, np.nextafter(0.2, 1.0)])
def test_one_on_the_edge_of_breaking_away_stays_where_it_is(push):
    host = Host(fmu_of(edged, "3.0")).run(u=push)
    made = host.record(steps(np.random.default_rng(3), 5.0, 0.01), "y", "torque")
    assert np.abs(made[0]).max() < 1e-14
    assert made[1][-1] == pytest.approx(push, rel=1e-12)
    host.close()


def test_it_slides_from_the_start_where_it_starts_to_move():
    host = Host(fmu_of(box, "2.0"))
    host.set(**{"state.y_rate": -0.5})
    host.run()
    assert host.get("sliding") == [-1.0]
    host.step(0.4)
    np.testing.assert_allclose(host.get("y", "y_rate"), [-0.2 + 0.25 * 0.16, -0.3], rtol=1e-13)
    host.close()


def test_one_that_hangs_on_a_spring_swings_exactly():
    host = Host(fmu_of(every_block.limited_axis, "3.0")).run(u=2.0)
    omega = sqrt(0.5)
    rng = np.random.default_rng(1)
    lengths = steps(rng, 20.0, 2.0)
    made = host.record(lengths, "y", "y_rate")
    phase = omega * np.cumsum(lengths)
    expected = [2.0 * (1.0 - np.cos(phase)), 2.0 * omega * np.sin(phase)]
    np.testing.assert_allclose(made, expected, atol=1e-13)
    host.close()


@pytest.mark.parametrize("make", [every_block.sticking_axis, every_block.rippling_axis])
@pytest.mark.parametrize("seed", range(3))
def test_a_flexible_one_that_sticks_is_the_simulations_whatever_the_steps(make, seed):
    rng = np.random.default_rng(seed)
    axis = make()
    times = np.sort(rng.uniform(0.0, 1.0, 12))
    levels = rng.normal(0.0, 2.0, 12)
    idle = Controller(PID(0.0, 0.0, 0.0), sample_time=0.01)
    at_rest = min_time_move(1e-9, Limits(acceleration=1.0)).delay(-1.0)
    pushed = TorqueSteps(times, np.diff(levels, prepend=0.0))
    response = ServoLoop(axis, idle).respond(
        at_rest, duration=1.2, times=at_rest.start_time + times[1:], disturbance=pushed
    )
    host = Host(fmu_of(make, VERSIONS[seed % 2])).run()
    rest = block_of(axis)
    assert {v.name for v in rest.variables} >= {"state.torque", "torque_limit", "sliding"}
    made = []
    for before, after, level in zip([0.0, *times], times, [0.0, *levels], strict=False):
        host.set(d_motor=level)
        for h in steps(rng, after - before, 0.02):
            host.step(h)
        made.append(host.get("y", "y_load", "torque", "sliding"))
    host.close()
    y, load, torque, sliding = np.array(made[1:]).T
    scale = np.abs(response.load).max()
    np.testing.assert_allclose(y, response.position, atol=1e-12 * scale)
    np.testing.assert_allclose(load, response.load, atol=1e-12 * scale)
    assert set(sliding) == {-1.0, 0.0, 1.0} or np.ptp(sliding) > 0.0
    assert np.abs(torque).max() <= 6.0


def test_what_is_linear_leaves_as_a_linear_block():
    block = block_of(every_block.linear_axis(), unit="rad")
    assert (block.core, block.partials) == ("continuous", True)
    units = {v.name: v.unit for v in block.variables}
    assert (units["u"], units["y_load"], units["state.twist_1_rate"]) == ("N.m", "rad", "rad/s")
    assert (units["torque"], units["state.torque"]) == ("N.m", "N.m")
    assert block_of(every_block.sticking_axis(), unit="m").core == "axis"


def test_too_many_states_are_refused():
    from jounce.plant import chain_axis

    chain = chain_axis([1.0] * 101, [100.0] * 100, friction=Friction(1.0))
    with pytest.raises(ValueError, match="an axis of 202 states: expected at most 200; leave out"):
        block_of(chain)
