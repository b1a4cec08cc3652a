"""Designs for any axis: the three margins by plain complex arithmetic, and refusals."""

import cmath
import re
import warnings
from math import degrees, log10, pi

import control
import numpy as np
import pytest
from scipy.optimize import brentq
from tiers import some

from jounce.analysis import loop_margins
from jounce.plant import (
    Axis,
    Controller,
    FlexibleInertia,
    FlexibleMode,
    Inertia,
    LowPass,
    Notch,
    ServoLoop,
    design_pid,
)
from jounce.plant.frequency_points import frequency_points

ASKED = {"crossover_hz": 2.0, "phase_margin_deg": 45.0, "lower_gain_margin_db": 12.0}


def margins_of(loop, crossover):
    """Return |L| and phase margin there, and the dB at the phase crossover below."""
    value = loop(crossover)
    low = brentq(lambda w: cmath.phase(-loop(w)), 0.05 * crossover, 0.9 * crossover, xtol=1e-14)
    return abs(value), degrees(cmath.phase(-value)), 20 * log10(abs(loop(low)))


@pytest.mark.parametrize("delay", some([0.0, 0.002, 0.004], 2))
@pytest.mark.parametrize("viscous", [0.0, 0.5])
@pytest.mark.parametrize("lag", [0.0, 2e-3])
def test_a_flexible_axis_with_friction_delay_and_filter(delay, viscous, lag):
    """Against the two-mass impedance, written out."""
    axis = Axis(2.0, modes=[FlexibleMode(20.0, 0.01, load_fraction=0.4)], viscous=viscous)
    gains = design_pid(axis, **ASKED, delay=delay, derivative_filter=lag)
    w, share = 2 * pi * 20.0, 0.4
    k, c = share * (1 - share) * 2.0 * w**2, 2 * 0.01 * w * share * (1 - share) * 2.0

    def loop(omega):
        s = 1j * omega
        spring = k + c * s
        load = share * 2.0 * s**2
        motor = (1 - share) * 2.0 * s**2 + viscous * s + spring * load / (spring + load)
        pid = gains.kp + gains.ki / s + gains.kr * s / (1 + lag * s)
        return pid / motor * cmath.exp(-s * delay)

    size, phase, lower = margins_of(loop, 2 * pi * 2.0)
    assert size == pytest.approx(1.0, rel=1e-10)
    assert phase == pytest.approx(45.0, abs=1e-8)
    assert lower == pytest.approx(12.0, abs=1e-8)


def test_a_digital_loop_in_z():
    """Double integrator behind a hold and half a sample of delay."""
    dt, moment = 2e-3, 5.0
    gains = design_pid(Inertia(moment), **ASKED, sample_time=dt, delay=0.5 * dt)

    def loop(omega):
        z = cmath.exp(1j * omega * dt)
        # x = (y, v): exact hold, the old input for the first half of the sample.
        new = np.array([dt**2 / 8, dt / 2]) / moment
        old = np.array([3 * dt**2 / 8, dt / 2]) / moment
        step = np.array([[1.0, dt], [0.0, 1.0]])
        plant = np.linalg.solve(z * np.eye(2) - step, new + old / z)[0]
        return plant * (gains.kp + gains.ki * dt * z / (z - 1) + gains.kr * (z - 1) / (dt * z))

    size, phase, lower = margins_of(loop, 2 * pi * 2.0)
    assert size == pytest.approx(1.0, rel=1e-9)
    assert phase == pytest.approx(45.0, abs=1e-6)
    assert lower == pytest.approx(12.0, abs=1e-6)


def test_without_delay_and_filters_a_rigid_axis_gets_the_closed_form():
    closed = design_pid(3.0, **ASKED)
    general = design_pid(Axis(3.0), **ASKED)
    assert (general.kp, general.ki, general.kr) == pytest.approx(
        (closed.kp, closed.ki, closed.kr), rel=1e-9
    )


def test_the_designed_loop_is_stable_down_to_its_lower_margin():
    axis = FlexibleInertia(2.0, frequency_hz=20.0, damping=0.01, load_fraction=0.4)
    gains = design_pid(axis, **ASKED, sample_time=1e-3, delay=1.5e-3)
    loop = ServoLoop(axis, Controller(gains, sample_time=1e-3, delay=1.5e-3)).loop_transfer()
    limit = 10 ** (-12.0 / 20)
    for gain, stable in ((1.0, True), (limit * 1.001, True), (limit * 0.999, False)):
        assert bool((abs((gain * loop).feedback().poles()) < 1.0).all()) is stable, gain


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"delay": 0.2}, "phase_margin_deg = 45.0 is out of reach: at the crossover the phase of"),
        ({"sample_time": 0.3}, "crossover_hz = 2 lies beyond half the sampling frequency"),
        ({"phase_margin_deg": 190.0, "delay": 0.01}, "phase_margin_deg = 190.0"),
        ({"lower_gain_margin_db": -1.0, "delay": 0.01}, "lower_gain_margin_db = -1.0"),
        ({"delay": -0.01}, "delay = -0.01"),
        ({"filters": [LowPass(1.0)]}, "out of reach"),
    ],
)
def test_refusals_name_value_and_remedy(given, told):
    with pytest.raises(ValueError, match=told) as caught:
        design_pid(Inertia(1.0), **(ASKED | given))
    assert "\n" not in str(caught.value)


def test_a_mode_that_the_load_sees_is_refused_without_a_notch():
    axis = FlexibleInertia(2.0, frequency_hz=20.0, damping=0.01, load_fraction=0.4, sensor="load")
    with pytest.raises(ValueError, match="are out of reach: the gains that meet all three give"):
        design_pid(axis, **ASKED, delay=1e-3)


@pytest.mark.parametrize("hz", [3.0, 6.0, 50.0])
@pytest.mark.parametrize("share", [0.2, 0.5])
def test_an_undamped_mode_is_no_obstacle(hz, share):
    """The motor sees 1/(J·s²)·(s² + ω_a²)/(s²·(1 − λ) + ω_a²), poles and zeros on the axis."""
    axis = Axis(3.0, modes=[FlexibleMode(hz, load_fraction=share, held=True)])
    gains = design_pid(axis, **ASKED)

    def loop(w):
        s, held = 1j * w, (2 * pi * hz) ** 2
        plant = (s * s + held) / (3.0 * s * s * ((1 - share) * s * s + held))
        return plant * (gains.kp + gains.ki / s + gains.kr * s)

    assert margins_of(loop, 2 * pi * 2.0) == pytest.approx((1.0, 45.0, 12.0), rel=1e-9)


def test_a_loop_is_looked_at_beside_its_undamped_roots_not_at_them():
    system = control.tf([1.0, 0.0, 9.0], [1.0, 0.0, 25.0, 0.0, 0.0])
    omega = frequency_points(system, 0.0)
    values = system(1j * omega)
    assert np.isfinite(values).all()
    assert (values != 0.0).all()
    for root in (3.0, 5.0):
        beside = omega - root
        assert 0.0 < beside[beside > 0.0].min() < 1e-5
        assert 0.0 < -beside[beside < 0.0].max() < 1e-5


@pytest.mark.parametrize(
    ("asked", "sample_time"), some([(1.0, None), (200.0, None), (200.0, 1e-3)], 2)
)
def test_the_lower_gain_margin_that_a_refusal_advises_is_reached(asked, sample_time):
    axis = Axis(1000.0, modes=[FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True)])
    timing = {} if sample_time is None else {"sample_time": sample_time, "delay": 1e-3}
    given = {"crossover_hz": 1.0, "phase_margin_deg": 45.0, **timing}
    with pytest.raises(ValueError, match="are out of reach") as caught:
        design_pid(axis, **given, lower_gain_margin_db=asked)
    advised = re.search(r"ask for a lower gain margin of ([\d.]+) dB", str(caught.value))
    gains = design_pid(axis, **given, lower_gain_margin_db=float(advised[1]))
    assert min(gains.kp, gains.ki, gains.kr) > 0.0


@pytest.mark.parametrize("way", ["matched", "hold"])
def test_the_design_has_its_margins_however_filters_are_sampled(way):
    filters = (Notch(40.0, zero_damping=0.2, pole_damping=0.6), LowPass(200.0))
    run = {"filters": filters, "sample_time": 2e-3, "delay": 1e-3, "discretisation": way}
    asked = {"crossover_hz": 5.0, "phase_margin_deg": 40.0, "lower_gain_margin_db": 10.0}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of the notch that is held
        gains = design_pid(2.0, **asked, **run)
        margins = loop_margins(ServoLoop(Inertia(2.0), Controller(gains, **run)))
    for name, value in asked.items():
        assert getattr(margins, name) == pytest.approx(value, rel=1e-6)
