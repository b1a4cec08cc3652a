"""Axes fitted to measured plants against the axes that the data were made from."""

import numpy as np
import pytest
from measured_loops import complex_noise

from jounce.analysis import MeasuredResponse, fit_axis, loop_margins
from jounce.plant import PID, Axis, Controller, FlexibleMode, Inertia, ServoLoop, zero_order_hold

DT, DELAY = 1e-3, 0.7e-3
LINES = np.arange(1.0, 300.0)
FREE = Axis(
    2.0,
    modes=[
        FlexibleMode(61.3, 0.01, motor_shape=1.0, load_shape=-0.6),
        FlexibleMode(150.0, 0.02, motor_shape=1.0, load_shape=0.3),
    ],
    sensor="load",
)
VISCOUS = Axis(2.0, viscous=40.0, modes=[FlexibleMode(80.0, 0.01, motor_shape=0.5, load_shape=0.5)])


def measured(axis, noise=2e-3):
    exact = zero_order_hold(axis.transfer(), DT, delay=DELAY)(np.exp(2j * np.pi * LINES * DT))
    sigma = noise * abs(exact)
    off = sigma * complex_noise(np.random.default_rng(8), LINES.size)
    return MeasuredResponse(LINES, exact + off, sigma, kind="plant", dt=DT)


def test_modes_inertia_and_delay_come_out_within_their_error_bars():
    found = fit_axis(measured(FREE))
    assert len(found.axis.modes) == 2
    assert found.misfit == pytest.approx(1.0, abs=0.2)
    assert abs(found.axis.J - 2.0) < 5 * found.inertia_sigma
    assert abs(found.delay - DELAY) < 5 * found.delay_sigma
    deviations = zip(
        found.axis.modes, FREE.modes, found.frequencies_hz_sigma, found.dampings_sigma, strict=True
    )
    for mode, true, frequency, damping in deviations:
        assert abs(mode.frequency_hz - true.frequency_hz) < 5 * frequency < 0.1
        assert abs(mode.damping - true.damping) < 5 * damping < 1e-3
        assert mode.load_shape == pytest.approx(true.load_shape, rel=0.01)
    assert "mode 61." in str(found)


def test_the_fitted_axis_simulates_and_has_the_margins_of_the_true_one():
    found = fit_axis(measured(FREE), modes=2, delay=DELAY)
    controller = Controller(
        PID(800.0, 4000.0, 30.0, derivative_filter=2e-3), sample_time=DT, delay=DELAY
    )
    own, true = (loop_margins(ServoLoop(axis, controller)) for axis in (found.axis, FREE))
    assert own.phase_margin_deg == pytest.approx(true.phase_margin_deg, rel=0.01)
    assert own.upper_gain_margin_db == pytest.approx(true.upper_gain_margin_db, rel=0.01)


def test_viscous_friction_and_a_collocated_sensor_are_kept():
    found = fit_axis(measured(VISCOUS), modes=1)
    assert found.axis.sensor == "motor"
    assert found.axis.viscous == pytest.approx(40.0, rel=0.05)
    assert found.axis.modes[0].frequency_hz == pytest.approx(80.0, rel=2e-3)


def test_a_rigid_axis_without_sample_time_is_fitted():
    response = Inertia(3.0).transfer()(2j * np.pi * LINES)
    found = fit_axis(MeasuredResponse(LINES, response, kind="plant"), delay=0.0)
    assert not found.axis.modes
    assert pytest.approx(3.0) == found.axis.J


def test_what_is_no_free_plant_is_refused():
    with pytest.raises(ValueError, match="expected a plant"):
        fit_axis(MeasuredResponse(LINES, 1 / LINES, kind="loop"))
    with pytest.raises(ValueError, match="0 integrators"):
        fit_axis(MeasuredResponse(LINES, np.ones(299), kind="plant"))
