"""Axes fitted to measured plants against the axes that the data were made from."""

import numpy as np
import pytest
from measured_loops import complex_noise
from tiers import SLOW, some

from jounce.analysis import MeasuredResponse, fit_axis, loop_margins
from jounce.plant import PID, Axis, Controller, FlexibleMode, Inertia, ServoLoop, zero_order_hold

COUNT = 25 if SLOW else 2
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


def measured(axis, noise=2e-3, lines=LINES, seed=8):
    exact = zero_order_hold(axis.transfer(), DT, delay=DELAY)(np.exp(2j * np.pi * lines * DT))
    sigma = noise * abs(exact)
    off = sigma * complex_noise(np.random.default_rng(seed), lines.size)
    return MeasuredResponse(lines, exact + off, sigma, kind="plant", dt=DT)


def random_axis(rng, sensor, spring):
    """Return an axis with friction and one or two modes; all shapes are alike at the motor."""
    inertia = 10 ** rng.uniform(-2, 1)
    modes = []
    for frequency in (rng.uniform(25, 60), rng.uniform(90, 200))[: rng.integers(1, 3)]:
        own = 10 ** rng.uniform(-0.5, 0.3)
        other = own if sensor == "motor" else -own * 10 ** rng.uniform(-0.4, 0.4)
        damping = 10 ** rng.uniform(-2.2, -1.4)
        modes.append(FlexibleMode(frequency, damping, motor_shape=own, load_shape=other))
    stiffness = inertia * (2 * np.pi * rng.uniform(3, 10)) ** 2 * spring
    viscous = inertia * 2 * np.pi * 10 ** rng.uniform(-0.5, 0.7)
    return Axis(inertia, viscous=viscous, spring=stiffness, modes=modes, sensor=sensor)


def pulls(found, axis):
    """Return how many standard deviations each number is off."""
    told = found.axis
    yield (told.J - axis.J) / found.inertia_sigma
    yield (found.delay - DELAY) / found.delay_sigma
    yield (told.viscous - axis.viscous) / found.viscous_sigma
    if axis.spring:
        yield (told.spring - axis.spring) / found.spring_sigma
    for k, (mode, true) in enumerate(zip(told.modes, axis.modes, strict=True)):
        yield (mode.frequency_hz - true.frequency_hz) / found.frequencies_hz_sigma[k]
        yield (mode.damping - true.damping) / found.dampings_sigma[k]
        gain, exact = (m.motor_shape * m.load_shape for m in (mode, true))
        yield (gain - exact) / found.gains_sigma[k]


def test_friction_acts_on_the_motor_of_a_mode_that_is_seen_at_the_load():
    axis = Axis(
        2.0,
        viscous=40.0,
        modes=[FlexibleMode(61.3, 0.01, motor_shape=1.5, load_shape=-0.6)],
        sensor="load",
    )
    found = fit_axis(measured(axis, lines=LINES[::3]), modes=1)
    assert found.axis.sensor == "load"
    assert found.misfit < 1.5
    assert max(map(abs, pulls(found, axis))) < 3.5
    assert found.axis.viscous == pytest.approx(40.0, rel=0.02)


def test_a_spring_to_the_ground_is_found_and_none_where_none_is():
    axis = Axis(0.5, viscous=2.0, spring=400.0)
    found = fit_axis(measured(axis, lines=LINES[::3]), modes=0)
    assert max(map(abs, pulls(found, axis))) < 3.5
    assert "spring 400" in str(found) or abs(found.axis.spring - 400.0) < 4 * found.spring_sigma
    free = fit_axis(measured(Axis(0.5), lines=LINES[::3]), modes=0)
    assert free.axis.spring == free.axis.viscous == 0.0
    assert free.spring_sigma > 0.0 < free.viscous_sigma


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensor", "spring"), some([("load", 0.0), ("motor", 0.0), ("load", 1.0), ("motor", 1.0)], 1)
)
def test_error_bars_hold_what_they_say_on_random_axes(sensor, spring):
    rng = np.random.default_rng(5)
    off = []
    for seed in range(COUNT):
        axis = random_axis(rng, sensor, spring)
        response = measured(axis, 3e-3, LINES[::3], seed)
        found = fit_axis(response, modes=len(axis.modes), sensor=sensor)
        assert found.misfit < 1.5
        off += [abs(pull) for pull in pulls(found, axis)]
    assert np.mean(np.array(off) < 1.0) > 0.58
    assert np.mean(np.array(off) < 2.0) > 0.9


def test_modes_inertia_and_delay_come_out_within_their_error_bars():
    found = fit_axis(measured(FREE, lines=LINES[::2]))
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
        gain = mode.motor_shape * mode.load_shape
        assert gain == pytest.approx(true.motor_shape * true.load_shape, rel=0.01)
    assert "mode 61." in str(found)


def test_the_fitted_axis_simulates_and_has_the_margins_of_the_true_one():
    found = fit_axis(measured(FREE, lines=LINES[::2]), modes=2, delay=DELAY)
    controller = Controller(
        PID(800.0, 4000.0, 30.0, derivative_filter=2e-3), sample_time=DT, delay=DELAY
    )
    own, true = (loop_margins(ServoLoop(axis, controller)) for axis in (found.axis, FREE))
    assert own.phase_margin_deg == pytest.approx(true.phase_margin_deg, rel=0.01)
    assert own.upper_gain_margin_db == pytest.approx(true.upper_gain_margin_db, rel=0.01)


def test_viscous_friction_and_a_collocated_sensor_are_kept():
    found = fit_axis(measured(VISCOUS, lines=LINES[::3]), modes=1)
    assert found.axis.sensor == "motor"
    assert found.axis.viscous == pytest.approx(40.0, rel=0.05)
    assert found.axis.modes[0].frequency_hz == pytest.approx(80.0, rel=2e-3)


def test_a_rigid_axis_without_sample_time_is_fitted():
    lines = LINES[::10]
    response = Inertia(3.0).transfer()(2j * np.pi * lines)
    found = fit_axis(MeasuredResponse(lines, response, kind="plant"), delay=0.0)
    assert not found.axis.modes
    assert pytest.approx(3.0) == found.axis.J


def test_what_is_no_axis_is_refused():
    with pytest.raises(ValueError, match="expected a plant"):
        fit_axis(MeasuredResponse(LINES, 1 / LINES, kind="loop"))
    with pytest.raises(ValueError, match="no inertia is seen"):
        fit_axis(MeasuredResponse(LINES, np.ones(299), kind="plant"), modes=0)
    with pytest.raises(ValueError, match="3 integrators"):
        fit_axis(MeasuredResponse(LINES, 1 / LINES, kind="plant", integrators=3))
