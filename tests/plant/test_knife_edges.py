"""Remarks on what hangs on the last digits."""

import numpy as np
import pytest

from jounce.plant import PID, Axis, Controller, Friction, Ramp, ServoLoop, TorqueSteps

DT = 1e-3
LAW = Controller(PID(1000.0, 0.0, 60.0), sample_time=DT)


def pushed(torque, static=3.0, **others):
    """Return the response of a loop that stands still to a step of torque."""
    loop = ServoLoop(Axis(2.0, friction=Friction(2.0, static), **others), LAW)
    return loop.respond(
        Ramp(0.0), DT, duration=0.2, start=0.0, disturbance=TorqueSteps([0.05], [torque])
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("part", [1.0 - 1e-12, 1.0, 1.0 + 1e-12])
def test_a_torque_that_is_the_stiction_up_to_rounding_is_remarked(sign, part):
    [told] = pushed(sign * 3.0 * part).remarks
    assert told.startswith("Knife edge at 0.05 s: the torque to be held is the stiction")


@pytest.mark.parametrize("torque", [0.0, 2.99, 3.01, -2.999999, 5.0])
def test_a_torque_that_is_clearly_less_or_more_is_not(torque):
    assert pushed(torque).remarks == ()


def test_a_breakaway_that_a_growing_torque_brings_is_no_knife_edge():
    law = Controller(PID(100.0, 500.0, 10.0))
    loop = ServoLoop(Axis(2.0, friction=Friction(2.0, 3.0)), law)
    response = loop.respond(Ramp(0.0, 0.01), DT, duration=2.0, start=0.0)
    assert response.friction_events
    assert response.remarks == ()


@pytest.mark.parametrize(("place", "told"), [(0.5, 1), (1.5, 1), (0.49, 0), (0.0, 0)])
def test_a_sample_between_two_steps_of_the_encoder_is_remarked(place, told):
    step = 1e-5
    axis = Axis(2.0, friction=Friction(50.0), encoder_step=step)
    loop = ServoLoop(axis, LAW)
    response = loop.respond(Ramp(0.0, place * step), DT, duration=0.05, start=place * step)
    assert sum("encoder's steps" in remark for remark in response.remarks) == told


def test_samples_with_noise_hang_on_the_noise():
    axis = Axis(2.0, friction=Friction(50.0), encoder_step=1e-5)
    response = ServoLoop(axis, LAW).respond(
        Ramp(0.0, 5e-6), DT, duration=0.05, start=5e-6, noise=np.full(50, 1e-7)
    )
    assert response.remarks == ()
