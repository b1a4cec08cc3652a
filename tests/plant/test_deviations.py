"""Deviations in wind and noise: against plain sums over frequency and seeded simulations."""

from functools import cache
from math import pi

import numpy as np
import pytest

from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Controller,
    FlexibleMode,
    LowPass,
    Ramp,
    ServoLoop,
    Spectrum,
    Wind,
    noise_realisation,
    wind_realisation,
)

AXIS = Axis(2.0, modes=FlexibleMode(8.0, 0.02, load_fraction=0.4), viscous=1.0, current_lag=1e-3)
LAW = PID(800.0, 2000.0, 60.0, derivative_filter=5e-3)
DIGITAL = Controller(LAW, sample_time=4e-3, delay=5e-3)
WINDS = [
    Wind("first_order", 3.0, corner_hz=0.5),
    Wind("double_pole", 3.0, corner_hz=2.0, on="motor"),
    Wind("von_karman", 3.0, length_over_speed=0.5),
]


@pytest.mark.parametrize("wind", WINDS, ids=lambda wind: wind.kind)
def test_the_spectrum_holds_the_variance(wind):
    f = np.exp(np.linspace(-16.0, 16.0, 400_001))
    assert np.trapezoid(wind.spectrum(f) * f, np.log(f)) == pytest.approx(9.0, rel=3e-4)


@cache
def over_frequency(controller):
    """Return densely frequencies in Hz, the axis and the controller there."""
    f = np.exp(np.linspace(np.log(1e-5), np.log(1e4), 50_001))
    return f, AXIS.system()(2j * pi * f), controller.transfer()(2j * pi * f)


@pytest.mark.parametrize("wind", WINDS, ids=lambda wind: wind.kind)
def test_a_continuous_loop_is_the_integral_over_frequency(wind):
    """Closed by hand: y = g_d·d − g·k·y."""
    controller = Controller(LAW, filters=LowPass(60.0))
    loop = ServoLoop(AXIS, controller)
    found = loop.deviations(wind)
    f, g, k = over_frequency(controller)
    column = 1 if wind.on == "motor" else 2
    motor = g[0, column] / (1 + g[0, 0] * k)
    load = g[2, column] - g[2, 0] * k * motor
    for response, deviation in (
        (motor, found.motor),
        (load, found.load),
        (k * motor, found.torque),
    ):
        density = wind.spectrum(f) * np.abs(response) ** 2
        assert deviation**2 == pytest.approx(np.trapezoid(density * f, np.log(f)), rel=1e-4)


@pytest.mark.parametrize("wind", WINDS, ids=lambda wind: wind.kind)
def test_a_digital_loop_in_seeded_wind_deviates_so(wind):
    loop = ServoLoop(AXIS, DIGITAL)
    found = loop.deviations(wind)
    course = wind_realisation(wind, 400.0, 4e-3, seed=3)
    response = loop.respond(Ramp(0.0), 4e-3, duration=400.0, disturbance=course)
    assert np.std(course.torques) == pytest.approx(3.0, rel=0.1)
    assert np.std(response.load) == pytest.approx(found.load, rel=0.1)
    assert np.std(response.torque) == pytest.approx(found.torque, rel=0.1)
    if wind.kind != "von_karman":
        assert found.load_average == pytest.approx(found.load, rel=1e-2)


@pytest.mark.parametrize("sensor", ["motor", "load"])  # both have noise of their own
@pytest.mark.parametrize("law", [LAW, CascadedPI(15.0, 50.0, 0.1)], ids=["pid", "cascade"])
def test_noise_of_the_encoder_comes_out_as_in_a_simulation(law, sensor):
    axis = Axis(2.0, modes=FlexibleMode(40.0, 0.05, load_fraction=0.2), sensor=sensor)
    loop = ServoLoop(axis, Controller(law, sample_time=2e-3, delay=0.5e-3))
    noise = 1e-5 * np.random.default_rng(5).standard_normal(50_000)
    found = loop.deviations(encoder_noise=1e-5)
    response = loop.respond(Ramp(0.0), 2e-3, duration=100.0, noise=noise)
    assert np.std(response.motor) == pytest.approx(found.motor, rel=0.03)
    assert np.std(response.torque) == pytest.approx(found.torque, rel=0.03)


def test_parts_of_the_budget_add_up_in_squares():
    loop = ServoLoop(AXIS, DIGITAL)
    wind, noise = loop.deviations(WINDS[0]), loop.deviations(encoder_noise=1e-4)
    both = loop.deviations(WINDS[0], encoder_noise=1e-4)
    assert both.load == pytest.approx(np.hypot(wind.load, noise.load), rel=1e-12)
    assert both.torque == pytest.approx(np.hypot(wind.torque, noise.torque), rel=1e-12)


BENT = Spectrum([0.2, 3.0, 40.0, 300.0], [5.0, 40.0, 2e-3, 1e-3])


def test_a_table_is_straight_in_logarithms_and_nothing_outside():
    assert BENT.spectrum([0.1, 0.2, 3.0, 300.0, 301.0]) == pytest.approx([0, 5.0, 40.0, 1e-3, 0])
    middle = np.sqrt(np.array([0.2 * 3.0, 40.0 * 300.0]))
    assert BENT.spectrum(middle) == pytest.approx(np.sqrt([5.0 * 40.0, 2e-3 * 1e-3]))
    f = np.exp(np.linspace(np.log(0.2), np.log(300.0), 200_001))
    assert BENT.variance == pytest.approx(np.trapezoid(BENT.spectrum(f) * f, np.log(f)), rel=1e-6)
    assert Spectrum([1.0, 10.0], [1.0, 0.1]).sigma == pytest.approx(np.sqrt(np.log(10.0)))


@pytest.mark.parametrize("controller", [DIGITAL, Controller(LAW, filters=LowPass(60.0))])
def test_a_table_of_a_wind_deviates_as_the_wind_does(controller):
    """The wind by Lyapunov's equation, its table by the integral over frequency."""
    wind = WINDS[1]
    f = np.geomspace(1e-5, 3e3, 2001)
    loop = ServoLoop(AXIS, controller)
    expected, found = (
        loop.deviations(each) for each in (wind, Spectrum(f, wind.spectrum(f), on="motor"))
    )
    for name in ("load", "motor", "torque"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=2e-5)


@pytest.mark.parametrize("sensor", ["motor", "load", "both"])
@pytest.mark.parametrize("halves", [1, 3, 4])
def test_flat_noise_up_to_halves_of_the_sample_rate_is_white_at_the_samples(sensor, halves):
    """Folded or not, by frequency, against white noise of each sample by Lyapunov's equation."""
    axis = Axis(2.0, modes=FlexibleMode(40.0, 0.05, load_fraction=0.2), sensor=sensor)
    law = CascadedPI(15.0, 50.0, 0.1)
    loop = ServoLoop(axis, Controller(law, sample_time=2e-3, delay=0.5e-3))
    end = halves * 250.0
    expected = loop.deviations(encoder_noise=1e-5)
    flat = Spectrum([1e-9 * end, end], [1e-10 / end, 1e-10 / end])
    found = loop.deviations(encoder_noise=flat)
    for name in ("load", "motor", "torque"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-6)


def test_noise_of_a_continuous_loop_is_the_integral_over_frequency():
    """By hand, u = −k·(y + n); the rate of a second encoder has no noise of the first."""
    controller = Controller(LAW, filters=LowPass(60.0))
    f = np.geomspace(0.2, 300.0, 10_001)
    s = 2j * pi * f
    for sensor in ("motor", "both"):
        axis = Axis(2.0, modes=FlexibleMode(80.0, 0.02, load_fraction=0.1), sensor=sensor)
        found = ServoLoop(axis, controller).deviations(encoder_noise=BENT)
        g, behind = axis.system()(s)[:, 0], LowPass(60.0).transfer()(s)
        ahead = behind * (LAW.kp + LAW.ki / s)
        rate = behind * LAW.kr * s / (1.0 + LAW.derivative_filter * s)
        noisy = ahead if sensor == "both" else ahead + rate
        u = -noisy / (1.0 + ahead * g[0] + rate * g[5])
        for response, deviation in ((g[2] * u, found.load), (u, found.torque)):
            density = BENT.spectrum(f) * np.abs(response) ** 2
            assert deviation**2 == pytest.approx(np.trapezoid(density * f, np.log(f)), rel=1e-4)


def test_seeded_noise_of_a_table_moves_a_loop_so():
    loop = ServoLoop(AXIS, DIGITAL)
    errors = noise_realisation(BENT, 50_000, 4e-3, seed=4)
    assert np.std(errors) == pytest.approx(BENT.sigma, rel=0.05)
    found = loop.deviations(encoder_noise=BENT)
    response = loop.respond(Ramp(0.0), 4e-3, duration=200.0, noise=errors)
    assert np.std(response.load) == pytest.approx(found.load, rel=0.1)
    assert np.std(response.torque) == pytest.approx(found.torque, rel=0.1)
    gusts = wind_realisation(BENT, 200.0, 4e-3, seed=4)
    assert (gusts.on, len(gusts.torques)) == ("load", 50_000)
    assert np.std(gusts.torques) == pytest.approx(BENT.sigma, rel=0.05)
    again = noise_realisation(BENT, 50_000, 4e-3, seed=4)
    np.testing.assert_array_equal(errors, again)


def test_the_same_seed_is_the_same_wind():
    one, same, other = (wind_realisation(WINDS[2], 1.0, 0.01, seed=s).torques for s in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Wind("first_order", 1.0), "give corner_hz"),
        (lambda: Wind("von_karman", 1.0, corner_hz=1.0), "give length_over_speed"),
        (lambda: Wind("gale", 1.0), "kind = 'gale'"),
        (lambda: ServoLoop(AXIS, LAW).deviations(encoder_noise=1.0), "give the controller"),
        (lambda: Spectrum([1.0], [1.0]), "two or more frequencies"),
        (lambda: Spectrum([2.0, 1.0], [1.0, 1.0]), "expected finite, increasing ones"),
        (lambda: Spectrum([0.0, 1.0], [1.0, 1.0]), "frequencies_hz: 0.0 has no logarithm"),
        (lambda: Spectrum([1.0, 2.0], [1.0, 0.0]), "densities: 0.0 has no logarithm"),
        (
            lambda: ServoLoop(AXIS, DIGITAL).deviations(encoder_noise=Spectrum([1, 1e8], [1, 1])),
            "end the table there",
        ),
        (lambda: ServoLoop(AXIS, PID(-1.0, 0.0, 0.0)).deviations(WINDS[2]), "the loop is"),
        (lambda: ServoLoop(AXIS, PID(-1.0, 0.0, 0.0)).deviations(WINDS[0]), "unstable"),
        (
            lambda: ServoLoop(AXIS, Controller(PID(1e6, 0.0, 0.0), sample_time=0.1)).deviations(
                WINDS[0]
            ),
            "the loop is unstable",
        ),
    ],
)
def test_what_has_no_deviations_gets_one_line(make, words):
    with pytest.raises(ValueError, match=words):
        make()
