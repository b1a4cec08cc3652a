"""The servo loop under a digital controller: aliases, limits of delay, simulation by hand."""

from math import inf, nan, pi

import control
import numpy as np
import pytest
from servo_loops import GAINS, MOMENT, flexible, loop_with
from tiers import some

from jounce.plant import (
    PID,
    FlexibleInertia,
    ServoLoop,
)

SAMPLED = {
    "rigid": loop_with(),
    "motor": ServoLoop(flexible(frequency=6.0), GAINS),
    "load": ServoLoop(flexible("load", 40.0, 0.03), GAINS),
}
EVERY_SAMPLED = pytest.mark.parametrize("loop", list(SAMPLED.values()), ids=list(SAMPLED))
RATES = pytest.mark.parametrize("rate", ["measured", "differenced"])


@EVERY_SAMPLED
@RATES
def test_sampled_ever_faster_the_loop_becomes_the_continuous_one(loop, rate):
    """A hold delays by half a sample, so L(e^(jω·dt)) − L(jω) falls with dt."""
    for omega in (2.0, 2 * pi, 20.0):
        expected = loop.loop_transfer()(1j * omega)
        errors = []
        for dt in (1e-3, 1e-4, 1e-5):
            sampled = loop.sampled_loop_transfer(dt, delay=0.3 * dt, rate=rate)
            errors.append(abs(sampled(np.exp(1j * omega * dt)) / expected - 1))
        np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.1)
        assert errors[-1] < 2e-5 * omega


@EVERY_SAMPLED
@RATES
@pytest.mark.parametrize("delay", some([0.0, 0.013, 0.02, 0.047], 2))
def test_the_sampled_loop_is_the_digital_controller_times_the_sum_of_aliases(loop, rate, delay):
    """Σ_k P(s_k)·e^(−s_k·τ)·(1 − e^(−s_k·dt))/(s_k·dt), cut where |s²·P| has settled."""
    dt, terms = 0.02, 100_000
    gains, g = loop.controller, loop.plant.transfer()
    numerator, denominator = g.num_array[0, 0], g.den_array[0, 0]
    sampled = loop.sampled_loop_transfer(dt, delay=delay, rate=rate)
    assert sampled.dt == dt
    for omega in (1.0, 2 * pi, 100.0):
        z = np.exp(1j * omega * dt)
        s = 1j * (omega + 2 * pi / dt * np.arange(-terms, terms + 1))
        p = np.polyval(numerator, s) / np.polyval(denominator, s)
        held = np.exp(-s * delay) * (1 - 1 / z) / (s * dt)
        left_out = 2 * abs(p[0] * s[0] ** 2) * abs(1 - 1 / z) / dt * (dt / 2 / pi) ** 2 / terms
        on_e = gains.kp + gains.ki * dt * z / (z - 1)
        if rate == "measured":
            expected = np.sum((on_e + gains.kr * s) * p * held)
            slack = gains.kr * left_out
        else:
            expected = (on_e + gains.kr * (z - 1) / (dt * z)) * np.sum(p * held)
            slack = left_out * dt / terms * abs(expected)
        assert slack < 1e-4 * abs(expected)
        assert abs(sampled(z) - expected) <= 1.1 * slack + 1e-10 * abs(expected), omega


def simulate(loop, dt, late, rate, samples, parts=4):
    """Return y and y_rate (2, N) of a digital loop let go from rest at y = 1, sample by sample.

    The plant goes on in steps of dt/parts, `late` of which are the delay; the controller is
    written out.
    """
    fine = control.sample_system(loop.plant.system(), dt / parts, "zoh")
    a, b, c = fine.A, fine.B[:, 0], fine.C[:2]
    gains, x, total = loop.controller, np.eye(len(fine.A))[0], 0.0
    queue, past, seen = [0.0] * late, -1.0, []
    for _ in range(samples):
        y, y_rate = c @ x
        total += dt * -y
        slope = -y_rate if rate == "measured" else (-y - past) / dt
        past = -y
        queue += [gains.kp * -y + gains.ki * total + gains.kr * slope] * parts
        for u in queue[:parts]:
            x = a @ x + b * u
        queue = queue[parts:]
        seen.append([y, y_rate])
    return np.array(seen).T


@EVERY_SAMPLED
@RATES
@pytest.mark.parametrize(
    ("dt", "late", "stable"),
    [(0.01, 0, True), (0.01, 7, True), (0.02, 30, False), (0.04, 12, False), (0.5, 0, False)],
)
def test_poles_of_the_sampled_loop_tell_how_a_long_simulation_ends(loop, rate, dt, late, stable):
    sampled = loop.sampled_loop_transfer(dt, delay=dt * late / 4, rate=rate)
    closed = sampled.feedback()
    radius = np.abs(closed.poles()).max()
    samples = int(min(1500, 400 / abs(np.log(radius))))
    seen = simulate(loop, dt, late, rate, samples)
    third = samples // 3
    grown = np.abs(seen[0, -third:]).max() > np.abs(seen[0, third:-third]).max()
    assert bool(radius > 1.0) is bool(grown) is not stable
    x = np.isin(sampled.state_labels, ["y", "e_past"]).astype(float)
    largest = 0.0
    for y, y_rate in seen.T:
        largest = max(largest, abs(y), abs(y_rate) * dt)
        assert abs(x[0] - y) <= 1e-10 * largest
        assert abs(x[1] - y_rate) * dt <= 1e-10 * largest
        x = closed.A @ x


@RATES
def test_the_longest_delay_of_a_sampled_loop_is_that_of_its_phase_margin(rate):
    """45 deg at 1 Hz last for 1/8 of a period, of which the hold takes half a sample."""
    dt = 2.5e-3
    loop = loop_with()

    def stable(delay):
        closed = loop.sampled_loop_transfer(dt, delay=delay, rate=rate).feedback()
        return bool(np.abs(closed.poles()).max() < 1.0)

    assert stable(0.125 - 2 * dt)
    assert not stable(0.125 + 2 * dt)


def test_signals_of_the_sampled_loop():
    loop = SAMPLED["motor"].sampled_loop_transfer(0.01, delay=0.025, rate="differenced")
    assert isinstance(loop, control.StateSpace)
    assert (loop.name, loop.dt) == ("sampled_loop", 0.01)
    assert (loop.input_labels, loop.output_labels) == (["u"], ["u_feedback"])
    axis, past = ["y", "y_rate", "twist", "twist_rate"], ["u_past_1", "u_past_2", "u_past_3"]
    assert loop.state_labels == [*axis, *past, "e_integral", "e_past"]
    rigid = loop_with(None, PID(1.0, 0.0, 2.0)).sampled_loop_transfer(0.01)
    assert rigid.state_labels == ["y", "y_rate"]


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_sampled_loop_does_not_depend_on_the_unit_of_time(unit):
    one = ServoLoop(flexible(), GAINS).sampled_loop_transfer(0.01, delay=0.003)
    axis = FlexibleInertia(MOMENT * unit**2, 10.0 / unit, 0.01, load_fraction=0.4)
    gains = PID(GAINS.kp, GAINS.ki / unit, GAINS.kr * unit)
    other = ServoLoop(axis, gains).sampled_loop_transfer(0.01 * unit, delay=0.003 * unit)
    for angle in (0.01, 0.3, 3.0):
        z = np.exp(1j * angle)
        assert other(z) == pytest.approx(one(z), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"dt": 0.0}, "dt = 0.0: expected a positive"),
        ({"dt": nan}, "dt = nan: expected a positive"),
        ({"delay": -0.1}, "delay = -0.1: expected a number ≥ 0"),
        ({"delay": inf}, "delay = inf: expected a finite"),
        ({"delay": 1e6}, "expected at most 1000; use a larger dt"),
        ({"rate": "guessed"}, "rate = 'guessed': expected 'measured' or 'differenced'"),
    ],
)
def test_how_a_loop_cannot_be_sampled(arguments, message):
    with pytest.raises(ValueError, match=message):
        loop_with().sampled_loop_transfer(**({"dt": 0.1} | arguments))
