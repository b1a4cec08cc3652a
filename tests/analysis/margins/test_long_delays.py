"""Loops behind many samples of delay, against all their states and against a dense circle."""

import time
from functools import cache

import control
import numpy as np
import pytest

from jounce.analysis import loop_margins
from jounce.plant import Axis, Controller, FlexibleMode, Notch, ServoLoop, design_pid

DT, J = 1e-3, 1000.0
GAINS = design_pid(J, crossover_hz=0.3, phase_margin_deg=40.0, lower_gain_margin_db=10.0)
MODE = FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True)
NOTCH = Notch(8.485, zero_damping=0.1, pole_damping=0.7)


def transfer(samples, modes=(MODE,)):
    """Return L(z) behind a delay in samples, with one state for each."""
    law = Controller(GAINS, sample_time=DT, delay=samples * DT, filters=[NOTCH])
    return ServoLoop(Axis(J, modes=list(modes)), law).loop_transfer()


def dense(samples):
    """Return L(e^(jω·dt)) up to half the sampling frequency, its delay taken exactly."""
    whole = int(samples)
    parts = [
        np.geomspace(1e-4, 30.0, 20_000),
        np.linspace(30.0, 80.0, 30_000),  # the mode rings here
        np.linspace(80.0, np.pi / DT, 10_000),
    ]
    z = np.exp(1j * np.unique(np.concatenate(parts)) * DT)
    return within_a_sample(samples - whole, z.tobytes()) * z ** (-whole)


@cache
def within_a_sample(share, z):
    """Return L(z) behind a part of a sample of delay; z in bytes."""
    return transfer(share)(np.frombuffer(z, dtype=complex))


def unstable_poles(values):
    """Return how many poles are outside of the unit circle, of three at z = 1 open: the argument.

    Around the indentation that leaves z = 1 outside, L turns by 3·180 degrees the other way.
    """
    angle = np.unwrap(np.angle(1.0 + values))
    turned = (angle[-1] - angle[0]) / np.pi - 1.5
    return -round(float(turned))


@pytest.mark.parametrize("samples", [0.0, 1.0, 1.5, 4.0, 7.25, 12.0, 20.0])
@pytest.mark.parametrize("modes", [(), (MODE,)])
def test_short_delays_have_the_poles_of_all_their_states(samples, modes):
    system = transfer(samples, modes)
    margins = loop_margins(system)
    expected = np.linalg.eigvals(np.asarray(system.A) - np.asarray(system.B @ system.C))
    found = np.asarray(margins.closed_loop_poles)
    assert found.size == expected.size
    near = expected[abs(expected) > 0.05]  # the fastest lie in clusters: rounding parts them
    assert max(abs(found - pole).min() for pole in near) < 1e-9
    assert margins.stable
    assert max(abs(expected)) < 1.0


@pytest.mark.parametrize("samples", [1.5, 20.0, 100.0, 200.0, 200.5, 250.0])
def test_margins_are_those_of_a_dense_search(samples):
    values = dense(samples)
    margins = loop_margins(transfer(samples))
    assert margins.stable == (unstable_poles(values) == 0)
    assert margins.stable
    assert margins.modulus_margin == pytest.approx(abs(1 + values).min(), rel=1e-5)
    assert margins.complementary_peak == pytest.approx(abs(values / (1 + values)).max(), rel=1e-5)
    crossing = np.flatnonzero(np.diff(np.sign(abs(values) - 1)))
    assert len(margins.crossovers_hz) == crossing.size
    angles = np.degrees(abs(np.angle(-values[crossing])))
    assert margins.phase_margin_deg == pytest.approx(angles.min(), abs=0.05)
    real = np.flatnonzero(np.diff(np.sign(values.imag)) * (values.real[1:] < 0))
    sizes = 20 * np.log10(abs(values[real]))
    assert margins.lower_gain_margin_db == pytest.approx(sizes[sizes > 0].min(), abs=0.05)
    assert margins.upper_gain_margin_db == pytest.approx(-sizes[sizes < 0].max(), abs=0.05)


@pytest.mark.parametrize("samples", [357.0, 360.0, 400.5, 900.0])
def test_stability_is_lost_where_the_argument_says(samples):
    margins = loop_margins(transfer(samples))
    count = unstable_poles(dense(samples))
    assert count > 0
    assert not margins.stable
    assert int(np.sum(abs(np.asarray(margins.closed_loop_poles)) > 1.0)) == count


def test_a_delay_margin_in_samples_is_where_a_longer_delay_loses_stability():
    [(_, last)] = loop_margins(transfer(200.0)).stabilizing_delays_s
    spare = round(last / DT)
    assert loop_margins(transfer(200.0 + spare)).stable
    assert not loop_margins(transfer(201.0 + spare)).stable


def test_a_polynomial_with_roots_at_zero_is_the_same_loop():
    denominator = np.polymul([1.0, -1.0], [1.0, -0.9])
    whole = control.tf([2e-4, 1e-4], np.concatenate([denominator, np.zeros(60)]), DT)
    states = control.ss(control.tf([2e-4, 1e-4], denominator, DT))
    for _ in range(60):
        states = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], DT) * states
    of_polynomials, of_states = loop_margins(whole), loop_margins(states)
    assert of_polynomials.phase_margin_deg == pytest.approx(of_states.phase_margin_deg, rel=1e-9)
    assert of_polynomials.upper_gain_margin_db == pytest.approx(of_states.upper_gain_margin_db)
    assert of_polynomials.stable
    assert of_states.stable


def test_two_hundred_samples_are_soon_looked_at():
    system = transfer(200.0)
    took = []
    for _ in range(3):
        begin = time.process_time()
        loop_margins(system)
        took.append(time.process_time() - begin)
    assert min(took) < 0.4  # of one core and a half; 0.04 s alone on a machine
