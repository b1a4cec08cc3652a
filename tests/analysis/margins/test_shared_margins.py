"""Margins of many servo loops at once are those of each by itself."""

import math

import numpy as np
import pytest

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.factoring import factored, factored_all
from jounce.analysis.margins.shared_margins import SharedLoops
from jounce.plant import PID, Axis, Controller, FlexibleMode, Inertia, LowPass, Notch, ServoLoop
from jounce.plant.models import Rational

NAMES = (
    *("crossover_hz", "phase_margin_deg", "delay_margin_s", "delay_margin_hz", "bandwidth_hz"),
    *("lower_gain_margin_db", "lower_gain_margin_hz", "upper_gain_margin_db"),
    *("upper_gain_margin_hz", "modulus_margin", "modulus_margin_hz", "disk_margin"),
    *("disk_margin_hz", "sensitivity_peak", "complementary_peak", "complementary_peak_hz"),
)


def random_loop(rng: np.random.Generator) -> ServoLoop:
    """Rigid and flexible, continuous and digital, with delays of whole samples and others."""
    inertia, omega = rng.uniform(0.5, 2.0), 2.0 * math.pi * rng.uniform(0.5, 2.0)
    gain = inertia * omega**2
    pid = PID(gain, 0.2 * gain * omega, 1.2 * gain / omega, derivative_filter=0.02 / omega)
    if rng.random() < 0.2:
        return ServoLoop(Inertia(inertia), PID(pid.kp, pid.ki, pid.kr))
    modes = [
        FlexibleMode(
            omega * f, rng.uniform(1e-3, 0.05), load_fraction=rng.uniform(0.1, 0.45), held=True
        )
        for f in rng.uniform(2.0, 20.0, rng.integers(1, 3))
    ]
    axis = Axis(inertia, modes=modes, sensor="motor")
    if rng.random() < 0.3:
        return ServoLoop(
            axis, Controller(pid, filters=[Notch(omega / 2.0, zero_damping=0.1, pole_damping=0.6)])
        )
    dt = rng.uniform(0.02, 0.25) / omega
    delay = dt * rng.choice([0.5, 1.0, 1.5, 2.0, 4.0])
    filters = [LowPass(0.5 * omega)] * int(rng.integers(0, 2))
    return ServoLoop(axis, Controller(pid, filters=filters, sample_time=dt, delay=delay))


@pytest.mark.parametrize("seed", [1])
def test_margins_found_together_are_those_found_alone(seed):
    rng = np.random.default_rng(seed)
    loops = [random_loop(rng) for _ in range(16)]
    shared = SharedLoops(loops)
    stable = 0
    for k, loop in enumerate(loops):
        found, alone = shared.margins(k), loop_margins(loop)
        assert found.stable == alone.stable
        assert np.array_equal(found.closed_loop_poles, alone.closed_loop_poles)
        stable += alone.stable
        for name in NAMES if alone.stable else ():
            expected = getattr(alone, name)
            assert getattr(found, name) == pytest.approx(expected, rel=1e-9, nan_ok=True), name
    assert 0 < stable < len(loops)


def test_a_loop_that_has_no_margins_costs_the_others_nothing():
    good = ServoLoop(Inertia(2.0), PID(40.0, 60.0, 12.0))
    silent = ServoLoop(Inertia(2.0), PID(0.0, 0.0, 0.0))
    shared = SharedLoops([good, silent, good])
    assert shared.margins(0).phase_margin_deg == loop_margins(good).phase_margin_deg
    assert shared.margins(2) is shared.margins(0)
    assert shared.margins(1).stable == loop_margins(silent).stable


def test_loops_that_are_factored_together_have_the_bits_of_each_alone():
    rng = np.random.default_rng(7)
    models = [random_loop(rng).open_model() for _ in range(12)]
    loop = next(loop for loop in iter(lambda: random_loop(rng), None) if loop.is_digital)
    for share in (0.0, 0.5, 0.9, 1.1):  # alike, and one that has poles at 0 in place of friction
        axis = Axis(loop.plant.J * (1.0 + share), modes=loop.plant.modes, viscous=share)
        models.append(ServoLoop(axis, loop.controller).open_model())
    for found, model in zip(factored_all(models), models, strict=True):
        alone = factored(model)
        for name in ("zeros", "poles", "closed", "hidden", "gain", "scale", "samples"):
            assert np.array_equal(getattr(found, name), getattr(alone, name)), name


def test_a_model_that_cannot_be_factored_costs_the_others_nothing():
    good = ServoLoop(Inertia(2.0), PID(40.0, 60.0, 12.0)).open_model()
    bad = Rational(np.array([math.nan]), np.array([1.0, 0.0]))
    first, second = factored_all([bad, good])
    assert "nan or inf" in str(first)
    assert np.array_equal(second.poles, factored(good).poles)
