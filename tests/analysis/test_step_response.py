"""The unit step: figures against a step response written out by hand."""

import control
import numpy as np
import pytest

from jounce.analysis.step_response import step_response
from jounce.plant import PID, Inertia, InertiaFeedforward, ServoLoop


@pytest.mark.parametrize("feedforward", [None, InertiaFeedforward(1.0)])
def test_figures_are_those_of_the_loop_without_feedforward(feedforward):
    kp, ki, kr = 27.915456798555518, 37.88223441211192, 5.402451145571286
    poles = np.roots([1.0, kr, kp, ki])
    step = step_response(ServoLoop(Inertia(1.0), PID(kp, ki, kr), feedforward), poles)
    time = np.linspace(0.0, 6.0, 60_001)
    closed = control.tf([kr, kp, ki], [1.0, kr, kp, ki])
    position = np.asarray(control.step_response(closed, time).outputs)
    assert step.overshoot_percent == pytest.approx(100 * (position.max() - 1), abs=1e-3)
    assert step.overshoot_percent == pytest.approx(39.85, abs=5e-3)  # Thompson: 40 %
    assert step.peak_time_s == pytest.approx(time[position.argmax()], abs=1e-3)
    reach = [time[np.argmax(position >= level)] for level in (0.1, 0.9)]
    assert step.rise_time_s == pytest.approx(reach[1] - reach[0], abs=1e-3)
    settled = time[np.flatnonzero(np.abs(position - 1) > 0.02)[-1]]
    assert step.settling_time_s == pytest.approx(settled, abs=3e-3)
    shown = step.time <= 6.0
    expected = np.interp(step.time[shown], time, position)
    np.testing.assert_allclose(step.position[shown], expected, atol=1e-6)
