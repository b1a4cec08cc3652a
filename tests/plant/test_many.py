"""Many loops at once: the same as one by one, in order, whatever they have in common."""

import numpy as np
import pytest

from jounce.plant import (
    PID,
    Axis,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    Ramp,
    ServoLoop,
    TorqueSteps,
    respond_all,
)
from jounce.shaping import Limits, min_time_move

MOVE = min_time_move(0.5, Limits(velocity=1.0, acceleration=8.0, jerk=200.0))


def digital(j=2.0, kp=1200.0, dt=1e-3, lead=0.0, **axis):
    plant = Axis(j, modes=FlexibleMode(20.0, 0.01, load_fraction=0.3), torque_limit=14.0, **axis)
    controller = Controller(PID(kp, 4700.0, 65.0, derivative_filter=dt), sample_time=dt, delay=4e-4)
    return ServoLoop(plant, controller, Feedforward({2: j}, lead=lead))


def continuous(kp=30.0):
    return ServoLoop(Inertia(1.0), PID(kp, 20.0, 9.0), InertiaFeedforward(0.9))


MIXED = [
    *(digital(kp=1200.0 + i) for i in range(20)),
    *(digital(j) for j in (1.8, 2.0, 2.2)),
    digital(dt=2e-3),
    digital(lead=1e-3),
    digital(friction=Friction(3.0, 4.0)),
    digital(encoder_step=1e-3),
    continuous(),
    digital(kp=1000.0),
]


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_a_batch_is_what_its_loops_are_one_by_one(workers):
    found = respond_all(MIXED, MOVE, times=[0.4, 0.6], figures=lambda r: r, workers=workers)
    assert len(found) == len(MIXED)
    for loop, response in zip(MIXED, found, strict=True):
        alone = loop.respond(MOVE, times=[0.4, 0.6])
        assert (response.load[-1], response.peak_error) == (alone.load[-1], alone.peak_error)
        np.testing.assert_array_equal(response.run.samples, alone.run.samples)


def test_ideal_loops_are_taken_on_a_grid():
    loops = [continuous(kp) for kp in (30.0, 40.0)]
    found = respond_all(loops, MOVE, 0.01, figures=lambda r: r.position)
    for loop, position in zip(loops, found, strict=True):
        np.testing.assert_array_equal(position, loop.respond(MOVE, 0.01).position)


def test_disturbances_and_other_commands_are_passed_on():
    loops = [digital(kp=kp) for kp in (1000.0, 1500.0)]
    pushed = {"disturbance": TorqueSteps([0.1], [2.0]), "duration": 0.5, "start": 0.01}
    found = respond_all(loops, Ramp(0.1), 0.05, figures=lambda r: r.torque, **pushed)
    for loop, torque in zip(loops, found, strict=True):
        np.testing.assert_array_equal(torque, loop.respond(Ramp(0.1), 0.05, **pushed).torque)


def test_loops_are_taken_as_they_are_needed_and_none_behind_a_failure():
    taken = []

    def made():
        for i in range(100):
            taken.append(i)
            yield digital(kp=1000.0 + i)

    def figure(response):
        if response.scene.controller.law.kp == 1020.0:
            raise ValueError("the 20th")

    with pytest.raises(ValueError, match="the 20th"):
        respond_all(made(), MOVE, times=[0.01], figures=figure, workers=1)
    assert 20 < max(taken) < 50


def test_no_loops_have_no_figures():
    assert respond_all([], MOVE, figures=lambda r: r) == []
