"""Margins of data against the exact ones of the model that the data were made from."""

from dataclasses import replace

import control
import numpy as np
import pytest
from measured_loops import complex_noise, of_one_error, random_loop
from tiers import SLOW, some

from jounce.analysis import MeasuredResponse, loop_margins
from jounce.plant import PID, Axis, Controller, zero_order_hold

COUNT = 12 if SLOW else 6
MARGINS = (
    "crossover_hz",
    "phase_margin_deg",
    "delay_margin_s",
    "upper_gain_margin_db",
    "lower_gain_margin_db",
    "modulus_margin",
    "disk_margin",
    "sensitivity_peak",
    "complementary_peak",
)


def measured(rng, noise, *, known_noise=True):
    """Return a loop measured as a plant, its controller and its exact margins."""
    plant, controller, crossover = random_loop(rng)
    dt = controller.sample_time
    step = crossover / rng.choice([12.0, 25.0, 50.0])
    lines = step * np.arange(1, int(min(0.49 / dt, 25 * crossover) / step))
    z = np.exp(2j * np.pi * lines * dt)
    exact, values = plant(z), of_one_error(controller)(z)
    size = abs(plant(np.exp(2j * np.pi * crossover * dt)))
    sigma = noise * size * abs(1 + exact * values)
    noisy = exact + sigma * complex_noise(rng, lines.size)
    given = sigma * np.sqrt(rng.chisquare(32, lines.size) / 32) if known_noise else None
    frf = MeasuredResponse(lines, noisy, given, kind="plant", dt=dt)
    loop = control.series(plant, of_one_error(controller))
    return frf, controller, loop_margins(loop)


@pytest.mark.parametrize(
    ("noise", "known"), some([(3e-3, True), (1e-2, True), (0, False), (3e-3, False)], 2)
)
def test_random_loops_come_out_within_their_error_bars(noise, known):
    rng = np.random.default_rng(7)
    pulls, told, right = [], 0, 0
    for _ in range(COUNT):
        frf, controller, exact = measured(rng, noise, known_noise=known)
        found = loop_margins(frf, controller=controller)
        assert found.stable in (exact.stable, None)
        if not (exact.stable and found.stable):
            continue
        told += 1
        assert len(found.crossovers_hz) == len(exact.crossovers_hz)
        for name in MARGINS:
            value, sigma = getattr(found, name), getattr(found, f"{name}_sigma")
            true = getattr(exact, name)
            if np.isnan(value):
                continue
            assert value == pytest.approx(true, abs=6.25 * sigma + 3e-3 * abs(true)), name
            pulls.append((value - true) / (sigma + 1e-5 * abs(true)))
            right += 1
    assert told >= COUNT // 2
    assert right >= 4 * COUNT
    assert np.sqrt(np.mean(np.square(pulls))) < 1.5


def test_worst_cases_are_worse_than_the_margins():
    frf, controller, _ = measured(np.random.default_rng(3), 3e-3)
    found = loop_margins(frf, controller=controller)
    for name in MARGINS[1:]:
        sign = -1.0 if name.endswith("peak") else 1.0
        assert sign * getattr(found, f"{name}_worst") < sign * getattr(found, name), name


def test_python_control_data_are_taken_as_loop_or_plant():
    plant = control.tf([1], [1, 1, 0])
    omega = np.geomspace(0.02, 60, 120)
    exact = loop_margins(2 * plant)
    for found in (
        loop_margins(control.frd(2 * plant, omega)),
        loop_margins(control.frd(plant, omega), controller=control.tf([2], [1])),
    ):
        assert found.stable
        assert found.phase_margin_deg == pytest.approx(exact.phase_margin_deg, rel=1e-5)
        assert np.isnan(found.upper_gain_margin_db)
    with_controller = loop_margins(plant, controller=PID(2.0, 0.0, 0.0))
    assert with_controller.phase_margin_deg == pytest.approx(exact.phase_margin_deg)


def test_relative_to_the_loop_that_ran_stability_needs_no_model():
    rng = np.random.default_rng(11)
    right = 0
    for _ in range(6):
        frf, controller, exact = measured(rng, 1e-3)
        if not exact.stable:
            continue
        most = 10 ** (exact.upper_gain_margin_db / 20)
        for share in (0.5, 0.8, 1.25, 2.0):
            law = controller.law
            gain = share * most
            other = Controller(
                PID(
                    gain * law.kp,
                    gain * law.ki,
                    gain * law.kr,
                    derivative_filter=law.derivative_filter,
                ),
                filters=controller.filters,
                sample_time=controller.sample_time,
            )
            found = loop_margins(frf, controller=other, measured_with=controller)
            plain = loop_margins(frf, controller=other)
            assert found.stable in (share < 1.0, None)
            assert plain.stable in (share < 1.0, None)
            right += found.stable is not None
    assert right >= 8


def test_what_the_data_lack_is_said():
    lines = np.arange(1.0, 40.0)
    s = 2j * np.pi * lines
    loop = 2000.0 / s / (s + 20)

    def of(values, at=lines, **others):
        return loop_margins(MeasuredResponse(at, values, kind="loop", **others))

    assert "no line with |L| < 1" in of(1e3 * loop).reasons[0]
    assert "inverted sign" in of(-loop).reasons[0]
    assert of(-loop).stable is None
    assert "inverted sign" in of(-loop, integrators=1).reasons[0]
    assert "last line" in of(np.where(lines > 38.0, 1.01, loop)).reasons[0]
    hole = (lines < 4) | (lines > 12)
    found = of(loop[hole], lines[hole])
    assert any("no line from 3 to 13 Hz" in text for text in found.warnings)
    assert found.stable is None
    noisy = of(loop, sigma=np.where(abs(lines - 8) < 4, 2.0, 0.01) * abs(1 + loop))
    assert "cannot exclude −1" in noisy.reasons[0]


def test_an_unstable_plant_is_counted_with_its_poles():
    plant, controller = control.tf([1], [1, 0, -4]), control.tf([6, 20], [0.01, 1])
    omega = np.geomspace(0.05, 300, 200)
    frf = MeasuredResponse.from_frd(
        control.frd(plant, omega), kind="plant", unstable_poles=1, integrators=0
    )
    assert loop_margins(plant * controller).stable
    assert loop_margins(frf, controller=controller).stable
    assert loop_margins(frf, controller=0.1 * controller).stable is not True


@pytest.mark.parametrize(
    ("controller", "words"),
    [
        (Controller(PID(1.0, 1.0, 1.0), sample_time=2e-3), "sample time is 0.002 s"),
        (PID(1.0, 1.0, 1.0), "continuous"),
        (None, "without a controller"),
    ],
)
def test_a_controller_that_does_not_fit_is_refused(controller, words):
    lines = np.arange(1.0, 40.0)
    frf = MeasuredResponse(lines, 1 / lines**2, kind="plant", dt=1e-3)
    with pytest.raises(ValueError, match=words):
        loop_margins(frf, controller=controller)


def test_a_controller_of_a_measured_loop_and_a_delay_are_refused():
    lines = np.arange(1.0, 40.0)
    frf = MeasuredResponse(lines, 1 / lines**2, kind="loop")
    with pytest.raises(ValueError, match="has one in it"):
        loop_margins(frf, controller=PID(1.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="have their delay in them"):
        loop_margins(frf, delay=1e-3)
    with pytest.raises(ValueError, match="measured_with"):
        loop_margins(control.tf([1], [1, 1]), measured_with=PID(1.0, 0.0, 0.0))


def test_the_table_and_the_plain_data_hold_the_margins():
    frf, controller, _ = measured(np.random.default_rng(3), 3e-3)
    found = loop_margins(frf, controller=controller)
    assert f"{found.phase_margin_deg:.4g} ± " in str(found)
    assert found.as_dict()["phase_margin_deg"] == found.phase_margin_deg
    assert found.as_dict()["stable"] is True


@pytest.mark.parametrize("declared", [None, 1, 2])
def test_lines_from_above_the_corner_of_the_integral_on_are_enough(declared):
    dt, viscous = 5e-4, 20.0 if declared == 1 else 0.0
    plant = zero_order_hold(Axis(1.0, viscous=viscous).transfer(), dt, delay=dt)
    omega = 2 * np.pi * 20.0
    law = PID(omega / 2, omega**2 / 8, 1.0, derivative_filter=1 / (20 * omega))
    controller = Controller(law, sample_time=dt)
    unit = abs(loop_at(plant, controller, 20.0, dt))
    for size, integral in ((1.0, 1.0), (1.0, 60.0), (20.0, 1.0)):
        gains = np.array([law.kp, law.ki * integral, law.kr]) * size / unit
        own = replace(
            controller, law=replace(law, kp=float(gains[0]), ki=float(gains[1]), kr=float(gains[2]))
        )
        exact = loop_margins(control.series(plant, of_one_error(own)))
        lines = np.arange(16.0, 700.0)
        response = plant(np.exp(2j * np.pi * lines * dt))
        frf = MeasuredResponse(lines, response, kind="plant", dt=dt, integrators=declared)
        assert loop_margins(frf, controller=own).stable is exact.stable
        inverted = replace(frf, response=-response)
        told = loop_margins(inverted, controller=own)
        assert told.stable is None
        assert "inverted sign" in told.reasons[0]


def loop_at(plant, controller, hertz, dt):
    z = np.exp(2j * np.pi * hertz * dt)
    return plant(z) * of_one_error(controller)(z)


@pytest.mark.parametrize(
    ("plant", "gains", "true"),
    [
        ("pendulum", (60.0, 12.0), True),
        ("pendulum", (100.0, 0.5), True),
        ("pendulum", (5.0, 3.0), False),
        ("pendulum", (100.0, -2.0), False),
        ("mass", (60.0, 12.0), True),
        ("mass", (-60.0, 12.0), False),
        ("mass", (-60.0, -12.0), False),
        ("spring", (-40.0, 12.0), False),
        ("spring", (-20.0, 12.0), True),
    ],
)
def test_a_pole_that_leaves_at_dc_is_half_a_turn_relative_to_the_loop_that_ran(plant, gains, true):
    viscous, stiffness = {"pendulum": (0, -9.0), "mass": (0, 0), "spring": (4.0, 30.0)}[plant]
    lines = np.geomspace(0.1, 100.0, 300)
    response = 1.0 / np.polyval([1.0, viscous, stiffness], 2j * np.pi * lines)
    poles = np.roots([1.0, gains[1] + viscous, gains[0] + stiffness])
    assert (poles.real < 0.0).all() == true
    for declared in (None, 2) if plant == "mass" else (None, 0):
        frf = MeasuredResponse(lines, response, kind="plant", integrators=declared)
        law, ran_with = PID(gains[0], 0.0, gains[1]), PID(80.0, 0.0, 10.0)
        assert loop_margins(frf, controller=law, measured_with=ran_with).stable is true
