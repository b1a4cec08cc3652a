"""Tuned PIDs: peaks by plain complex arithmetic, no better gains nearby, reasons for refusals."""

from dataclasses import replace

import control
import numpy as np
import pytest

from jounce.analysis import tune_pid, tuning
from jounce.plant import Axis, FlexibleInertia, FlexibleMode, Inertia, LowPass, Notch

AXIS = FlexibleInertia(2.0, frequency_hz=20.0, damping=0.01, load_fraction=0.4)
ON_LOAD = FlexibleInertia(2.0, frequency_hz=20.0, damping=0.01, load_fraction=0.4, sensor="load")
DELAY = 1.5e-3
OMEGA = np.sort(
    np.concatenate(
        [
            np.geomspace(1e-3, 1e5, 40_000),
            2 * np.pi * 20.0 * (1 + np.linspace(-0.05, 0.05, 20_001)),
            2 * np.pi * 20.0 * np.sqrt(0.6) * (1 + np.linspace(-0.05, 0.05, 20_001)),
        ]
    )
)


def response(gains, omega, sensor="motor", extra=1.0):
    """L of the one-mode axis, from its equations of motion."""
    s = 1j * omega
    w, z, share = 2 * np.pi * 20.0, 0.01, 0.4
    mode = s**2 + 2 * z * w * s + w**2
    numerator = s**2 / (1 - share) + 2 * z * w * s + w**2
    numerator = numerator if sensor == "motor" else 2 * z * w * s + w**2
    plant = numerator / (2.0 * s**2 * mode)
    kp, ki, kr = gains
    return (kp + ki / s + kr * s) * plant * np.exp(-s * DELAY) * extra


def peaks(loop):
    return abs(1 / (1 + loop)).max(), abs(loop / (1 + loop)).max()


@pytest.mark.parametrize(("axis", "sensor"), [(AXIS, "motor"), (ON_LOAD, "load")])
def test_both_peaks_are_reached_and_not_passed(axis, sensor):
    tuned = tune_pid(axis, delay=DELAY)
    s, t = peaks(response((tuned.pid.kp, tuned.pid.ki, tuned.pid.kr), OMEGA, sensor))
    assert s == pytest.approx(1.6, rel=1e-4)
    assert t == pytest.approx(1.6, rel=1e-4)
    assert tuned.margins.stable


def test_no_gains_nearby_have_more_integral_action():
    """500 random gains around the optimum: with more ki they break a bound."""
    tuned = tune_pid(AXIS, delay=DELAY, max_sensitivity=1.5, max_complementary=1.7)
    best = np.array([tuned.pid.kp, tuned.pid.ki, tuned.pid.kr])
    rng = np.random.default_rng(3)
    omega = OMEGA[::8]
    for _ in range(500):
        gains = best * (1.0 + rng.uniform(-0.05, 0.05, 3))
        if gains[1] < best[1] * 1.001:
            continue
        s, t = peaks(response(gains, omega))
        assert s > 1.5 or t > 1.7, gains.tolist()


def test_a_notch_hurts_on_a_collocated_mode_and_helps_on_the_load():
    """The comparison that a designer makes; ki falls to a sixth, and rises ten thousandfold."""
    notch = [Notch(20.0, zero_damping=0.05, pole_damping=0.5)]
    assert (
        tune_pid(AXIS, delay=DELAY, filters=notch).pid.ki < 0.3 * tune_pid(AXIS, delay=DELAY).pid.ki
    )
    notch = [Notch(20.0, zero_damping=0.01, pole_damping=0.5)]
    on_load = tune_pid(ON_LOAD, delay=DELAY, filters=notch).pid.ki
    assert on_load > 1e3 * tune_pid(ON_LOAD, delay=DELAY).pid.ki


def test_a_digital_loop_keeps_the_bounds_in_z():
    """By the sampled double integrator's own formula: ZOH, one sample of delay, differences."""
    dt = 1e-3
    tuned = tune_pid(Inertia(3.0), sample_time=dt, delay=dt)
    z = np.exp(1j * np.geomspace(1e-3, np.pi, 40_000))
    plant = dt**2 * (z + 1) / (2 * 3.0 * (z - 1) ** 2) / z
    gains = tuned.pid
    k = gains.kp + gains.ki * dt * z / (z - 1) + gains.kr * (z - 1) / (dt * z)
    s, t = peaks(k * plant)
    assert (s, t) == (pytest.approx(1.6, rel=1e-4), pytest.approx(1.6, rel=1e-4))


def test_integral_error_of_the_rigid_axis_by_its_own_scale():
    """J scales the gains, the delay the frequencies: ki ∝ J/delay³."""
    one = tune_pid(Inertia(1.0), delay=1e-2)
    two = tune_pid(Inertia(50.0), delay=2e-3)
    assert two.pid.ki == pytest.approx(one.pid.ki * 50.0 * 125.0, rel=1e-3)


def test_a_filter_of_the_rate_bounds_what_nothing_else_does():
    tuned = tune_pid(Inertia(1.0), derivative_filter=1e-3, filters=[LowPass(100.0)])
    assert tuned.pid.derivative_filter == 1e-3
    assert str(tuned).startswith("kp ")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "nothing limits the integral gain: .* give delay=…, sample_time=… or"),
        ({"max_sensitivity": 1.0}, "max_sensitivity = 1.0: expected a number above 1"),
        ({"max_complementary": 0.5}, "max_complementary = 0.5: expected a number above 1"),
        (
            {"sample_time": 1e-3, "filters": [Notch(600.0, zero_damping=0.1, pole_damping=1.0)]},
            "600",
        ),
    ],
)
def test_refusals_name_value_and_remedy(given, told):
    with pytest.raises(ValueError, match=told) as caught:
        tune_pid(Inertia(1.0), **given)
    assert "\n" not in str(caught.value)


def test_a_resonance_without_damping_is_named_and_the_remedy_works(monkeypatch):
    """Behind a delay |S| passes its bound on a part of 1e-7 of the frequency beside the pole."""
    mode = FlexibleMode(50.0, load_fraction=0.5, held=True)
    timing = {"sample_time": 1e-3, "delay": 1e-3}
    with monkeypatch.context() as patched:
        patched.setattr(tuning, "_ROUNDS", 3)
        with pytest.raises(
            ValueError, match=r"a resonance at 71\.\d+ Hz is too sharp .*; give the"
        ):
            tune_pid(Axis(1000.0, modes=[mode]), **timing)
    damped = Axis(1000.0, modes=[replace(mode, damping=1e-4)])
    assert tune_pid(damped, **timing).margins.sensitivity_peak < 1.6001


def test_bounds_that_no_stable_loop_keeps_are_no_sharp_resonance():
    axis = Axis(1.0, modes=[FlexibleMode(20.0, 0.01, load_fraction=0.5)])
    with pytest.raises(ValueError, match=r"no stable loop .* \|S\| ≤ 1.001 .* allow larger peaks"):
        tune_pid(axis, max_sensitivity=1.001, sample_time=0.2, delay=0.3)


def test_an_unreachable_bound_says_what_came_nearest():
    unstable = control.tf([1.0], [1.0, 0.0, -90_000.0])
    with pytest.raises(ValueError, match="no PID that keeps the bounds was found"):
        tune_pid(unstable, delay=0.01)
