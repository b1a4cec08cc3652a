"""PIDs tuned on measured plants against those tuned on the models behind the data."""

import numpy as np
import pytest
from measured_loops import complex_noise
from tiers import some

from jounce.analysis import MeasuredResponse, loop_margins, tune_pid
from jounce.plant import FlexibleInertia, Inertia, LowPass, ServoLoop, zero_order_hold

DT = 1e-3
AXIS = FlexibleInertia(2.0, frequency_hz=40.0, damping=0.01, load_fraction=0.4)
LINES = np.arange(1.0, 400.0)


def measured(axis, noise, **declared):
    exact = zero_order_hold(axis.transfer(), DT, delay=DT)(np.exp(2j * np.pi * LINES * DT))
    off = complex_noise(np.random.default_rng(5), LINES.size)
    sigma = noise * abs(exact)
    return MeasuredResponse(LINES, exact + sigma * off, sigma, kind="plant", dt=DT, **declared)


@pytest.mark.parametrize("noise", some([1e-8, 3e-3], 1))
def test_a_pid_tuned_on_data_is_that_of_the_model(noise):
    of_model = tune_pid(AXIS, sample_time=DT, delay=DT)
    of_data = tune_pid(measured(AXIS, noise))
    rel = 1e-3 if noise < 1e-6 else 0.1
    assert of_data.pid.ki == pytest.approx(of_model.pid.ki, rel=rel)
    assert of_data.margins.sensitivity_peak <= 1.6 * (1 + 1e-4)
    true = loop_margins(ServoLoop(AXIS, of_data.controller).sampled_loop_transfer())
    assert true.stable


def test_filters_and_python_control_data_are_taken():
    frf = measured(Inertia(2.0), 1e-8)
    tuned = tune_pid(frf.to_frd(), filters=[LowPass(150.0)], max_sensitivity=1.8)
    assert tuned.controller.sample_time == DT
    assert tuned.margins.sensitivity_peak == pytest.approx(1.8, rel=1e-3)


def test_what_is_no_plant_is_refused():
    frf = measured(Inertia(2.0), 1e-8)
    with pytest.raises(ValueError, match="has its delay in it"):
        tune_pid(frf, delay=1e-3)
    loop = MeasuredResponse(LINES, frf.response, kind="loop")
    with pytest.raises(ValueError, match="expected a response of the plant"):
        tune_pid(loop)
