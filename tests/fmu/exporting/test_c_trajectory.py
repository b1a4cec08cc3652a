"""The trajectory in C is the one in Python."""

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import export_fmu
from jounce.shaping import Limits, Trajectory, min_time_move
from jounce.shaping.derivatives import derivative_name

pytestmark = needs_compiler


def jerk_limited():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=10.0)).delay(0.35)


def acceleration_limited():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))


def sixth_order():
    limits = Limits.from_bounds([None, None, None, None, None, 400.0])
    return min_time_move(-3.0, limits, start=2.0)


def coasting():
    """Begin and end in motion; as Trajectory([0, 1, 3], …) of order 2."""
    return Trajectory([0.5, 1.5, 3.5], [[1.0, 2.0, -1.0], [2.5, 1.0, 0.25]])


def point():
    return Trajectory(np.zeros(1), np.empty((0, 4)), end_state=[3.0, 0.0, 0.0, 0.0])


MAKERS = (jerk_limited, sixth_order, coasting, point)


def names_of(trajectory):
    return [derivative_name(k) for k in range(trajectory.order + 1)]


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", MAKERS)
def test_uneven_steps_give_what_python_gives(make, version):
    trajectory = make()
    names = names_of(trajectory)
    span = trajectory.duration or 1.0
    start = trajectory.start_time - 0.3 * span
    steps = np.random.default_rng(1).uniform(0.002, 0.04, 100) * span
    host = Host(fmu_of(make, version), start=start).run()
    at_start = host.get(*names)
    rows = host.record(steps, *names)
    host.close()
    times = np.add.accumulate([start, *steps])
    expected = trajectory.evaluate(times)
    np.testing.assert_array_equal(rows, expected[:, 1:])
    np.testing.assert_array_equal(at_start, expected[:, 0])
    assert times[-1] > trajectory.end_time


@pytest.mark.parametrize("version", VERSIONS)
def test_fmpy_simulates_it(version):
    trajectory, names = jerk_limited(), names_of(jerk_limited())
    path = fmu_of(jerk_limited, version)
    result = simulate_fmu(path, output=names, output_interval=trajectory.duration / 97.0)
    assert result["time"][0] == trajectory.start_time
    assert len(result) == 98
    expected = trajectory.evaluate(result["time"])
    for k, name in enumerate(names[:3]):
        np.testing.assert_allclose(
            result[name], expected[k], rtol=0.0, atol=1e-12 * trajectory.peak(k)
        )


def test_it_can_be_delayed_and_moved():
    moved = jerk_limited().delay(0.25).shift(-7.0)
    host = Host(fmu_of(jerk_limited, "2.0")).run(delay=0.25, offset=-7.0)
    rows = host.record([0.02] * 100, "position", "velocity")
    host.close()
    expected = moved.evaluate(np.add.accumulate([0.02] * 100), 1)
    np.testing.assert_allclose(rows, expected, rtol=0.0, atol=1e-14 * 7.0)


@pytest.mark.parametrize("version", VERSIONS)
def test_added_up_times_come_to_the_break(version):
    trajectory = acceleration_limited()
    host = Host(fmu_of(acceleration_limited, version)).run()
    rows = host.record([1e-3] * 1500, "velocity", "acceleration")
    end = host.time
    position = host.get("position")
    host.close()
    assert end < trajectory.end_time
    assert (rows[1] == np.repeat([2.0, 0.0, -2.0, 0.0], [499, 500, 500, 1])).all()
    assert position == pytest.approx([1.0], abs=1e-12)


@pytest.mark.parametrize(("early", "acceleration"), [(0.9e-6, 0.0), (1.1e-6, 2.0)])
def test_a_millionth_of_the_last_step_counts_as_the_break(early, acceleration):
    host = Host(fmu_of(acceleration_limited, "2.0")).run()
    host.step(0.4)
    host.step(0.1 - 0.1 * early)
    assert host.get("acceleration") == [acceleration]
    host.close()


def test_many_pieces(tmp_path):
    rng = np.random.default_rng(4)
    breaks = np.cumsum(rng.uniform(0.1, 1.0, 2001))
    many = Trajectory(breaks, rng.normal(size=(2000, 3)))
    made = export_fmu(many, tmp_path / "many.fmu", platforms=["host"])
    host = Host(made.path, start=float(breaks[0])).run()
    steps = np.full(500, many.duration / 499.5)
    rows = host.record(steps, "position", "velocity")
    host.close()
    expected = many.evaluate(np.add.accumulate([breaks[0], *steps])[1:], 1)
    np.testing.assert_array_equal(rows, expected)
