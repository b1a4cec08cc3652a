"""Responses of simulated axes, estimated from records, against the exact sampled plant."""

import numpy as np
import pytest

from jounce.analysis import estimate_frf, loop_margins, multisine
from jounce.plant import (
    PID,
    Axis,
    Controller,
    FlexibleMode,
    Friction,
    Ramp,
    SampledTorque,
    ServoLoop,
    zero_order_hold,
)
from jounce.shaping import Limits

DT, PERIOD = 1e-3, 1000
MODE = FlexibleMode(60.0, 0.01, motor_shape=0.6, load_shape=-0.5)
AXIS = Axis(2.0, viscous=3.0, modes=[MODE])
CONTROLLER = Controller(PID(4000.0, 20000.0, 80.0, derivative_filter=2e-3), sample_time=DT)
NOISE = 3e-6


def record(w, rng, axis=AXIS):
    """Return the plant's input and its measured output with w added to the torque."""
    n = len(w)
    noise = NOISE * rng.normal(size=n)
    loop = ServoLoop(axis, CONTROLLER)
    times = DT * np.arange(n)
    found = loop.respond(
        Ramp(0.0), DT, duration=n * DT, disturbance=SampledTorque(times, w), noise=noise
    )
    return found.torque[:n] + w, found.position[:n] + noise


def truth(lines):
    return zero_order_hold(AXIS.transfer(), DT)(np.exp(2j * np.pi * lines * DT))


def pulls(frf):
    return abs(frf.response - truth(frf.frequency_hz)) / frf.sigma


@pytest.mark.parametrize("realisations", [1, 4])
def test_a_multisine_in_closed_loop_finds_the_plant(realisations):
    rng = np.random.default_rng(1)
    waves = [
        multisine(DT, PERIOD, band_hz=(1, 400), torque=20.0, seed=seed)
        for seed in range(realisations)
    ]
    records = [record(wave.repeated(6), rng) for wave in waves]
    u, y = (np.array(part) for part in zip(*records, strict=True))
    w = np.array([wave.values for wave in waves])
    found = estimate_frf(w, u, y, DT, period=PERIOD)
    off = pulls(found.plant)
    assert 0.7 < np.sqrt(np.mean(off**2)) < 1.3
    exact = loop_margins(ServoLoop(AXIS, CONTROLLER))
    told = loop_margins(found.plant, controller=CONTROLLER)
    assert told.stable
    assert len(told.crossovers_hz) == len(exact.crossovers_hz) == 3
    for name in ("phase_margin_deg", "modulus_margin", "upper_gain_margin_db", "delay_margin_s"):
        value, true = getattr(told, name), getattr(exact, name)
        assert abs(value - true) < 5 * getattr(told, f"{name}_sigma") + 1e-3 * true
    loop = loop_margins(found.sensitivity)
    assert loop.phase_margin_deg == pytest.approx(exact.phase_margin_deg, rel=0.02)
    assert (found.distortion is None) is (realisations == 1)


def test_noise_in_closed_loop_finds_the_plant_where_the_direct_method_does_not():
    rng = np.random.default_rng(2)
    w = 8.0 * rng.normal(size=60_000)
    u, y = record(w, rng)
    found = estimate_frf(w, u, y, DT, segment=4000)
    some = (found.plant.frequency_hz < 55) | (found.plant.frequency_hz > 65)
    off = pulls(found.plant)[some & (found.plant.frequency_hz < 300)]
    assert np.sqrt(np.mean(off**2)) < 1.5
    assert np.median(off) > 0.4


def test_a_stepped_sine_finds_the_plant():
    rng = np.random.default_rng(3)
    lines = np.geomspace(5.0, 200.0, 12)
    times = DT * np.arange(48_000)
    dwells = [(f, 4.0 * i, 4.0 * (i + 1)) for i, f in enumerate(lines)]
    frequency = np.repeat(lines, 4000)
    w = 5.0 * np.sin(2 * np.pi * frequency * times)
    u, y = record(w, rng)
    found = estimate_frf(w, u, y, DT, dwells=dwells)
    assert np.median(abs(found.plant.response / truth(lines) - 1)) < 0.01
    assert 0.3 < np.sqrt(np.mean(pulls(found.plant) ** 2)) < 2.0
    with pytest.raises(ValueError, match="dwell at 5 Hz"):
        estimate_frf(w, u, y, DT, dwells=[(5.0, 0.0, 0.5)])


def test_distortion_shows_at_the_lines_that_were_left_out():
    rng = np.random.default_rng(4)
    rubbing = Axis(2.0, viscous=3.0, modes=[MODE], friction=Friction(2.0))
    levels = {}
    for name, axis in (("linear", AXIS), ("rubbing", rubbing)):
        wave = multisine(DT, PERIOD, band_hz=(1, 100), torque=20.0, odd=True, left_out=True)
        w = wave.repeated(6)
        u, y = record(w, rng, axis)
        found = estimate_frf(w, u, y, DT, period=PERIOD)
        levels[name] = found
    assert levels["rubbing"].odd_distortion > 10 * levels["linear"].odd_distortion
    assert levels["rubbing"].odd_distortion > 3 * levels["rubbing"].even_distortion


@pytest.mark.parametrize(
    ("records", "options", "words"),
    [
        ((None, [1.0, 2.0], [1.0, 2.0]), {}, "give the excitation"),
        ((np.ones(9), np.ones(9), np.ones(8)), {}, "records of unequal length"),
        ((np.arange(9.0), np.ones(9), np.arange(9.0)), {}, "u is constant"),
        ((np.arange(9.0), np.arange(9.0), [np.nan, *range(8)]), {}, "y is not finite at sample 0"),
        ((np.arange(9.0),) * 3, {"period": 8}, "periods of 8"),
    ],
)
def test_bad_records_are_told_in_one_line(records, options, words):
    with pytest.raises(ValueError, match=words):
        estimate_frf(*records, DT, **options)


def test_a_multisine_keeps_the_bounds_that_the_shaper_checks():
    limits = Limits(velocity=0.05, acceleration=6.0)
    wave = multisine(
        DT, PERIOD, band_hz=(2, 300), torque=20.0, odd=True, limits=limits, inertia=2.0
    )
    motion = wave.motion()
    assert motion.violation(limits) <= 1e-12
    assert max(motion.peak(1) / 0.05, motion.peak(2) / 6.0) == pytest.approx(1.0)
    assert motion.end_state[0] == pytest.approx(0.0, abs=1e-12)
    spectrum = abs(np.fft.rfft(wave.values))
    lines = np.round(wave.frequency_hz * PERIOD * DT).astype(int)
    assert (lines % 2 == 1).all()
    silent = np.setdiff1d(np.arange(len(spectrum)), lines)
    assert spectrum[silent].max() < 1e-9 * spectrum.max()
    assert wave.crest_factor < 3.0
    with pytest.raises(ValueError, match="without inertia"):
        multisine(DT, PERIOD, band_hz=(2, 300), torque=1.0, limits=limits)
    with pytest.raises(ValueError, match="holds 0 lines"):
        multisine(DT, PERIOD, band_hz=(2.1, 2.2), torque=1.0)
