"""Margins checked from outside: by destabilising the loop, by dense search, by exact cases."""

import math

import control
import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from one_loops import (
    S,
    closed_loop_poles,
    delayed_pid,
    evaluate,
    exact_pid,
    flexible_loop,
    pid_loop,
    stable_random_margins,
)

from jounce.analysis.margins import loop_margins


def rescale_time(loop, factor):
    """Return the same loop with every frequency multiplied by `factor`."""
    if isinstance(loop, control.StateSpace):
        return control.ss(loop.A * factor, loop.B * factor, loop.C, loop.D)
    num, den = (
        part[0, 0] * factor ** -np.arange(part[0, 0].size - 1.0, -1, -1)
        for part in (loop.num_array, loop.den_array)
    )
    return control.tf(num, den)


@pytest.mark.parametrize("form", [control.tf, control.ss])
@pytest.mark.parametrize("inertia", [1.0, 3e7])
def test_exact_design_meets_its_three_specifications(form, inertia):
    margins = loop_margins(form(pid_loop(*exact_pid(inertia), inertia)))
    assert margins.stable
    assert margins.crossover_hz == pytest.approx(1, rel=1e-12)
    assert margins.phase_margin_deg == pytest.approx(45, rel=1e-12)
    assert margins.lower_gain_margin_db == pytest.approx(12, rel=1e-12)
    assert margins.upper_gain_margin_db == math.inf
    assert math.isnan(margins.upper_gain_margin_hz)
    assert margins.delay_margin_s == pytest.approx(1 / 8, rel=1e-12)
    assert margins.modulus_margin == pytest.approx(0.75645, abs=5e-6)
    assert margins.modulus_margin_hz == pytest.approx(0.9102, abs=5e-5)


def test_printed_gains_of_thompson_miss_their_specifications():
    margins = loop_margins(pid_loop(11.09, 3.187 * 11.09, 6.286 * 11.09))
    assert margins.crossover_hz == pytest.approx(1.750, abs=5e-4)
    assert margins.phase_margin_deg == pytest.approx(73.0, abs=0.05)
    assert margins.lower_gain_margin_db == pytest.approx(15.0, abs=0.05)
    assert margins.upper_gain_margin_db == math.inf
    assert (margins.modulus_margin, margins.modulus_margin_hz) == (1, math.inf)
    assert (margins.sensitivity_peak, margins.sensitivity_peak_hz) == (1, math.inf)


def test_delay_gives_the_conditionally_stable_loop_both_gain_margins():
    loop = delayed_pid()
    margins = loop_margins(loop)
    for margin, sign in ((margins.lower_gain_margin_db, -1), (margins.upper_gain_margin_db, 1)):
        inside, outside = (10 ** (sign * margin * share / 20) for share in (1 - 1e-6, 1 + 1e-6))
        assert np.all(closed_loop_poles(loop, inside).real < 0)
        assert np.any(closed_loop_poles(loop, outside).real > 0)
    assert margins.lower_gain_margin_hz < margins.crossover_hz < margins.upper_gain_margin_hz


def test_the_added_delay_is_taken_from_the_delay_margin():
    ideal = loop_margins(pid_loop(*exact_pid()))
    assert loop_margins(delayed_pid()).delay_margin_s == pytest.approx(
        ideal.delay_margin_s - 0.01, rel=1e-9
    )


def test_random_loops_reach_instability_at_their_gain_margins_and_not_before():
    limited = 0
    for loop, margins in stable_random_margins():
        assert margins.stable
        for sign, margin, hz in (
            (-1, margins.lower_gain_margin_db, margins.lower_gain_margin_hz),
            (1, margins.upper_gain_margin_db, margins.upper_gain_margin_hz),
        ):
            reach = min(margin, 100) * np.linspace(0, 1 - 1e-5, 25)
            for gain in 10 ** (sign * reach / 20):
                assert np.all(closed_loop_poles(loop, gain).real < 1e-12)
            if margin < 100:
                limited += 1
                at_limit = evaluate(loop, 2 * np.pi * hz) * 10 ** (sign * margin / 20)
                assert abs(1 + at_limit) < 1e-9
    assert limited > 20


def test_random_loops_hit_minus_one_at_their_phase_and_delay_margins():
    limited = 0
    for loop, margins in stable_random_margins():
        if math.isinf(margins.phase_margin_deg):
            continue
        limited += 1
        turn = np.exp(1j * np.radians(margins.phase_margin_deg))
        value = evaluate(loop, 2 * np.pi * margins.crossover_hz)
        assert min(abs(1 + value * turn), abs(1 + value / turn)) < 1e-9
        omega = 2 * np.pi * margins.delay_margin_hz
        lagged = evaluate(loop, omega) * np.exp(-1j * omega * margins.delay_margin_s)
        assert abs(1 + lagged) < 1e-9
        values = evaluate(loop, 2 * np.pi * np.array(margins.crossovers_hz))
        lags = np.angle(-values) % (2 * np.pi) / (2 * np.pi * np.array(margins.crossovers_hz))
        assert margins.delay_margin_s == pytest.approx(lags.min(), rel=1e-9)
        assert margins.phase_margin_deg == pytest.approx(
            abs(np.angle(-values, deg=True)).min(), rel=1e-7
        )
    assert limited > 20


def test_dense_search_finds_no_crossing_or_peak_the_margins_miss():
    for loop, margins in stable_random_margins():
        near = abs(np.concatenate([loop.poles().imag, margins.closed_loop_poles.imag]))
        fine = np.outer(near[near > 0], 1 + np.linspace(-0.05, 0.05, 401)).ravel()
        omega = np.unique(np.concatenate([np.logspace(-5, 6, 8000), fine]))
        values = evaluate(loop, omega)
        found = [hz for hz in margins.crossovers_hz if omega[0] < 2 * np.pi * hz < omega[-1]]
        assert np.sum(np.diff(np.sign(abs(values) - 1)) != 0) <= len(found)
        changes = np.diff(np.sign(values.imag)) != 0
        negative = (values.real[1:] < -1e-9) & (values.real[:-1] < -1e-9)
        assert np.sum(changes & negative) <= len(margins.phase_crossovers_hz)
        for sizes, peak in (
            (abs(1 / (1 + values)), margins.sensitivity_peak),
            (abs(values / (1 + values)), margins.complementary_peak),
            (abs((1 - values) / (1 + values)), 2 / margins.disk_margin),
        ):
            assert sizes.max() <= peak * (1 + 1e-9)
        assert margins.modulus_margin == pytest.approx(1 / margins.sensitivity_peak, rel=1e-14)


def test_peaks_are_attained_where_they_are_said_to_be():
    for loop, margins in stable_random_margins():
        for of_value, peak, hz in (
            (lambda x: 1 / (1 + x), margins.sensitivity_peak, margins.sensitivity_peak_hz),
            (lambda x: x / (1 + x), margins.complementary_peak, margins.complementary_peak_hz),
            (lambda x: (1 - x) / (1 + x), 2 / margins.disk_margin, margins.disk_margin_hz),
        ):
            omega = 2 * np.pi * (1e12 if math.isinf(hz) else max(hz, 1e-12))
            assert abs(of_value(evaluate(loop, omega))) == pytest.approx(peak, rel=1e-6)


def test_agrees_with_python_control_on_plain_loops():
    for loop in (5 / (S + 1) ** 3, 1 / (S * (S + 1) * (S / 5 + 1)), 20 / ((S + 1) * (S + 2) ** 3)):
        gain, phase, modulus, at_gain, at_phase, at_modulus = control.stability_margins(loop)
        margins = loop_margins(loop)
        ours = (
            10 ** (margins.upper_gain_margin_db / 20),
            margins.phase_margin_deg,
            margins.modulus_margin,
            2 * np.pi * margins.upper_gain_margin_hz,
            2 * np.pi * margins.crossover_hz,
            2 * np.pi * margins.modulus_margin_hz,
        )
        assert ours == pytest.approx(
            (gain, phase, modulus, at_gain, at_phase, at_modulus), rel=1e-6
        )


def test_crossings_of_a_lightly_damped_loop_agree_with_fifty_digits():
    loop = flexible_loop()
    found = loop_margins(loop)
    assert len(found.crossovers_hz) == 11
    with mpmath.workdps(50):
        a, b, c = (mpmath.matrix(part.tolist()) for part in (loop.A, loop.B, loop.C))

        def value(omega):
            s = mpmath.mpc(0, omega)
            return (c * mpmath.lu_solve(s * mpmath.eye(a.rows) - a, b))[0]

        for hz in found.crossovers_hz:
            omega = mpmath.findroot(
                lambda w: abs(value(w)) - 1, (2 * np.pi * hz, 2.0001 * np.pi * hz)
            )
            assert 2 * np.pi * hz == pytest.approx(float(omega), rel=1e-11)
        for hz in found.phase_crossovers_hz:
            omega = mpmath.findroot(lambda w: mpmath.im(value(w)) / abs(value(w)), 2 * np.pi * hz)
            assert 2 * np.pi * hz == pytest.approx(float(omega), rel=1e-11)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize(
    "loop",
    [delayed_pid(), control.ss(delayed_pid()), flexible_loop(), 5 / (S + 1) ** 3],
    ids=["delayed", "delayed-ss", "flexible", "lag"],
)
def test_margins_do_not_depend_on_the_unit_of_time(loop, factor):
    margins, scaled = loop_margins(loop), loop_margins(rescale_time(loop, factor))
    poles, scaled_poles = margins.closed_loop_poles, scaled.closed_loop_poles
    np.testing.assert_allclose(scaled_poles, poles * factor, rtol=1e-10)
    plain, scaled_plain = margins.as_dict(), scaled.as_dict()
    for name in plain.keys() - {"stable", "closed_loop_poles"}:
        power = {"hz": 1, "s": -1}.get(name.rsplit("_", 1)[-1], 0)
        expected = np.array(plain[name], dtype=float) * factor**power
        actual = np.array(scaled_plain[name], dtype=float)
        np.testing.assert_allclose(actual, expected, rtol=2e-12, err_msg=name)


@given(
    crossover=st.floats(0.1, 100),
    angle=st.floats(5, 85),
    factor=st.floats(1.2, 100),
    inertia=st.floats(1e-6, 1e6),
)
@settings(max_examples=40, deadline=None)
def test_every_pid_designed_for_a_lower_gain_margin_has_it(crossover, angle, factor, inertia):
    omega, phi = 2 * np.pi * crossover, math.radians(angle)
    kp = inertia * omega**2 * math.cos(phi)
    kr = inertia * omega * math.sin(phi) / (1 - math.cos(phi) / factor)
    margins = loop_margins(pid_loop(kr, kp, kr * kp / (inertia * factor), inertia))
    assert margins.crossover_hz == pytest.approx(crossover, rel=1e-11)
    assert margins.phase_margin_deg == pytest.approx(angle, rel=1e-10)
    assert 10 ** (margins.lower_gain_margin_db / 20) == pytest.approx(factor, rel=1e-10)


@given(order=st.integers(1, 12), gain=st.floats(0.05, 20))
@settings(max_examples=40, deadline=None)
def test_equal_lags_have_their_closed_form_margins(order, gain):
    assume(abs(gain * math.cos(math.pi / order) ** order - 1) > 1e-3 and abs(gain - 1) > 1e-3)
    margins = loop_margins(control.ss([], [], [], gain) * equal_lags(order))
    limit = math.cos(math.pi / order) ** -order if order > 2 else math.inf
    assert margins.stable == (gain < limit)
    if gain > 1:
        crossing = math.sqrt(gain ** (2 / order) - 1) / (2 * math.pi)
        assert margins.crossovers_hz == pytest.approx((crossing,), rel=1e-10)
    if margins.stable:
        expected = 20 * math.log10(limit / gain) if order > 2 else math.inf
        assert margins.upper_gain_margin_db == pytest.approx(expected, rel=1e-10)
        assert margins.lower_gain_margin_db == math.inf


def equal_lags(order):
    """1/(s + 1)^order as a chain of first-order lags."""
    return control.ss(np.eye(order, k=-1) - np.eye(order), np.eye(order, 1), np.eye(order)[-1:], 0)
