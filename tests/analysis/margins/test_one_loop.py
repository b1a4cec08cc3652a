"""Margins checked from outside: by destabilising the loop, by dense search, by exact cases."""

import dataclasses
import functools
import json
import math

import control
import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from jounce.analysis.margins import LoopMargins, loop_margins

S = control.tf("s")
BETA = 3 + 2 * math.sqrt(2)


def exact_pid(inertia=1.0):
    """Return kr, kp, ki for 1 Hz, 45° and 12 dB exactly."""
    crossover, angle, factor = 2 * np.pi, np.pi / 4, 10 ** (12 / 20)
    kp = inertia * crossover**2 * math.cos(angle)
    kr = inertia * crossover * math.sin(angle) / (1 - math.cos(angle) / factor)
    return kr, kp, kr * kp / (inertia * factor)


def pid_loop(kr, kp, ki, inertia=1.0):
    return control.tf([kr, kp, ki], [inertia, 0, 0, 0])


def delayed_pid(delay=0.01, order=4):
    return pid_loop(*exact_pid()) * control.tf(*control.pade(delay, order))


def evaluate(loop, omega):
    """L(jω) by the coefficients, without the factors the margins are computed from."""
    s = 1j * np.asarray(omega)
    return np.polyval(loop.num_array[0, 0], s) / np.polyval(loop.den_array[0, 0], s)


def closed_loop_poles(loop, factor=1.0):
    return np.roots(np.polyadd(loop.den_array[0, 0], factor * loop.num_array[0, 0]))


def flexible_loop():
    """PID on five modes of damping ratio 0.001, with a roll-off: order 14 in modal form."""
    blocks = [(np.zeros((2, 2)) + np.diag([1.0], 1), 1.0)]
    for omega in (9.0, 21.0, 34.0, 55.0, 80.0):
        blocks.append((np.array([[0, 1], [-(omega**2), -2e-3 * omega]]), 0.2))
    plant = sum(control.ss(a, [[0], [gain]], [[1, 0]], 0) for a, gain in blocks)
    kr, kp, ki = exact_pid()
    return plant * control.ss((kr * S**2 + kp * S + ki) / (S * (S / 400 + 1)))


def rescale_time(loop, factor):
    """Return the same loop with every frequency multiplied by `factor`."""
    if isinstance(loop, control.StateSpace):
        return control.ss(loop.A * factor, loop.B * factor, loop.C, loop.D)
    num, den = (
        part[0, 0] * factor ** -np.arange(part[0, 0].size - 1.0, -1, -1)
        for part in (loop.num_array, loop.den_array)
    )
    return control.tf(num, den)


def random_loop(rng):
    """Return a random transfer function of order 1 to 8, over three decades."""
    order = rng.integers(1, 9)
    poles, zeros = random_roots(rng, order), random_roots(rng, rng.integers(0, order))
    den = np.real(np.poly(np.concatenate([poles, np.zeros(rng.integers(0, 2))])))
    num = np.atleast_1d(np.real(np.poly(zeros)))
    level = abs(np.prod(poles)) / abs(np.prod(zeros))
    return control.tf(num * level * 10 ** rng.uniform(-2, 1.5), den)


def random_roots(rng, count):
    roots = []
    while len(roots) < count:
        size = 10 ** rng.uniform(-1.5, 1.5)
        if count - len(roots) > 1 and rng.random() < 0.6:
            zeta = 10 ** rng.uniform(-2.5, 0)
            pole = size * complex(-zeta, math.sqrt(1 - zeta**2))
            roots += [pole, pole.conjugate()]
        else:
            roots.append(-size)
    return np.array(roots)


STABLE_RANDOM = [
    loop
    for loop in (random_loop(np.random.default_rng(seed)) for seed in range(150))
    if np.all(closed_loop_poles(loop).real < -1e-6)
]


@functools.cache
def stable_random_margins():
    return [(loop, loop_margins(loop)) for loop in STABLE_RANDOM]


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


@pytest.mark.parametrize("zeta", [0.5, 0.01, 0.001])
def test_a_resonance_that_touches_unit_gain_has_one_crossover_there(zeta):
    touching = 2 * zeta * math.sqrt(1 - zeta**2)

    def crossovers(factor):
        return loop_margins(control.tf([factor * touching], [1, 2 * zeta, 1])).crossovers_hz

    assert crossovers(1) == pytest.approx((math.sqrt(1 - 2 * zeta**2) / (2 * np.pi),), rel=1e-12)
    assert len(crossovers(1 + 1e-8)) == 2
    assert crossovers(1 - 1e-8) == ()


def test_a_phase_that_touches_180_degrees_is_a_phase_crossover():
    loop = (S + 1) ** 2 / (S**3 * (S / BETA + 1) ** 2)
    assert loop_margins(loop).phase_crossovers_hz == pytest.approx(
        ((1 + math.sqrt(2)) / (2 * np.pi),), rel=1e-6
    )


def test_phase_and_delay_margins_are_taken_at_their_own_crossovers():
    margins = loop_margins(flexible_loop())
    assert margins.delay_margin_hz == max(margins.crossovers_hz)
    assert margins.crossover_hz == min(margins.crossovers_hz)


def test_phase_margin_towards_lead_counts():
    """A resonance turned by +60° crosses unit gain first in the second quadrant."""
    corner = 1 / math.tan(math.radians(75))
    loop = 0.3 * S / (S**2 + 0.1 * S + 1) * ((1 - S / corner) / (1 + S / corner)) ** 2
    margins = loop_margins(loop)
    assert margins.stable
    value = evaluate(loop, 2 * np.pi * margins.crossover_hz)
    assert 90 < np.angle(value, deg=True) < 180
    assert margins.phase_margin_deg == pytest.approx(180 - np.angle(value, deg=True), rel=1e-9)
    assert margins.crossover_hz == margins.crossovers_hz[0]
    assert margins.delay_margin_hz == margins.crossovers_hz[1]


@pytest.mark.parametrize(
    ("loop", "real_part"),
    [
        (50 / (S + 1) ** 3, 50 ** (1 / 3) / 2 - 1),
        (1 / S**2, 0.0),
        (control.tf([1, 0], [1, 1, 0]), 0.0),
        (control.tf([1, -1], [1, 1, -2]), 1.0),
        (control.ss([[-1, 0], [0, 2]], [[1], [0]], [[1, 1]], 0), 2.0),
        (-2 / (S + 1), 1.0),
    ],
    ids=["gain", "undamped", "hidden-integrator", "hidden-rhp", "uncontrollable", "sign"],
)
def test_an_unstable_loop_has_no_margins_and_names_its_worst_pole(loop, real_part):
    margins = loop_margins(loop)
    assert not margins.stable
    numbers = margins.as_dict()
    named = {"stable", "closed_loop_poles", "crossovers_hz", "phase_crossovers_hz"}
    named |= {"stabilizing_gains", "stabilizing_delays_s"}
    assert {name for name, value in numbers.items() if value is not None} == named
    assert math.isnan(margins.phase_margin_deg)
    assert margins.closed_loop_poles[0].real == pytest.approx(real_part, abs=1e-12)
    assert margins.summary().startswith("UNSTABLE: closed-loop pole at")
    assert f"{complex(margins.closed_loop_poles[0]) + 0.0:.4g}" in str(margins)


def test_an_unstable_loop_still_lists_its_crossovers():
    crossover = math.sqrt(50 ** (2 / 3) - 1) / (2 * np.pi)
    assert loop_margins(50 / (S + 1) ** 3).crossovers_hz == pytest.approx((crossover,), rel=1e-9)


def test_undamped_modes_and_integrators_do_not_count_as_phase_crossovers():
    margins = loop_margins((S**2 + 0.5) / (S * (S**2 + 1)))
    assert margins.stable
    assert margins.phase_crossovers_hz == ()
    assert margins.lower_gain_margin_db == math.inf


def test_zero_loop_gain_leaves_every_margin_unlimited():
    margins = loop_margins(control.tf([0], [1, 1]))
    assert margins.stable
    assert margins.crossovers_hz == margins.phase_crossovers_hz == ()
    limits = ("phase_margin_deg", "lower_gain_margin_db", "upper_gain_margin_db", "delay_margin_s")
    assert all(getattr(margins, name) == math.inf for name in limits)
    assert (margins.modulus_margin, margins.disk_margin, margins.complementary_peak) == (1, 2, 0)
    assert math.isnan(margins.crossover_hz)
    assert math.isnan(margins.bandwidth_hz)


def test_unobservable_input_is_zero_loop_gain():
    hidden = control.ss([[-1, 0], [0, -2]], [[1], [0]], [[0, 1]], 0)
    assert loop_margins(hidden).crossovers_hz == ()
    assert loop_margins(hidden).modulus_margin == 1


@pytest.mark.parametrize(
    ("gain", "lower", "upper", "hz"),
    [(-2.0, 20 * math.log10(2), math.inf, 0), (-0.5, math.inf, 20 * math.log10(2), 0)],
)
def test_gain_margins_count_the_limit_at_dc(gain, lower, upper, hz):
    loop = control.tf([gain], [math.copysign(1, gain + 1), 1])
    margins = loop_margins(loop)
    assert margins.lower_gain_margin_db == pytest.approx(lower, rel=1e-12)
    assert margins.upper_gain_margin_db == pytest.approx(upper, rel=1e-12)
    assert hz in (margins.lower_gain_margin_hz, margins.upper_gain_margin_hz)


def test_gain_margins_count_the_limit_at_infinite_frequency():
    margins = loop_margins((1 - S / 2) / (1 + S))
    assert margins.upper_gain_margin_db == pytest.approx(20 * math.log10(2), rel=1e-12)
    assert margins.upper_gain_margin_hz == math.inf


@pytest.mark.parametrize("loop", [(2 * S + 1) / (S + 1), S + 1, control.ss([], [], [], 1.0)])
def test_no_delay_is_tolerated_where_the_gain_does_not_roll_off(loop):
    margins = loop_margins(loop)
    assert margins.stable
    assert (margins.delay_margin_s, margins.delay_margin_hz) == (0, math.inf)


def test_unit_gain_at_dc_is_a_crossover_at_zero():
    margins = loop_margins(1 / (S + 1))
    assert margins.crossovers_hz == (0,)
    assert margins.phase_margin_deg == 180
    assert margins.delay_margin_s == math.inf
    assert margins.bandwidth_hz == pytest.approx(1 / np.pi, rel=1e-12)


@pytest.mark.parametrize("corner", [3e-6, 7, 1e3, 2.0**20, 3e7])
@pytest.mark.parametrize("form", [control.tf, lambda n, d: control.ss(control.tf(n, d))])
def test_unit_gain_at_dc_is_no_crossover_beside_it(form, corner):
    margins = loop_margins(form([corner], [1, corner]))
    assert (margins.crossovers_hz, margins.delay_margin_s) == ((0,), math.inf)
    assert margins.stabilizing_delays_s == ((0, math.inf),)
    two = loop_margins(form([corner**2], [1, corner, corner**2]))  # |L| = 1 at 0 and at the corner
    assert two.crossovers_hz == pytest.approx((0, corner / (2 * np.pi)), rel=1e-12)
    assert two.delay_margin_s == pytest.approx(np.pi / 2 / corner, rel=1e-12)


def test_bandwidth_is_where_t_first_falls_by_three_decibels():
    loop = delayed_pid()
    margins = loop_margins(loop)
    omega = 2 * np.pi * margins.bandwidth_hz * np.array([1e-6, 0.2, 0.5, 0.8, 0.999999, 1])
    size = abs(evaluate(loop, omega) / (1 + evaluate(loop, omega)))
    assert size[-1] == pytest.approx(1 / math.sqrt(2), rel=1e-10)
    assert np.all(size[:-1] > 1 / math.sqrt(2))
    assert math.isnan(loop_margins(S / (S + 1)).bandwidth_hz)
    assert math.isnan(loop_margins((S + 1) / (S + 2)).bandwidth_hz)


def test_result_is_frozen_json_able_and_reads_as_text():
    margins = loop_margins(pid_loop(*exact_pid()))
    assert isinstance(margins, LoopMargins)
    with pytest.raises(ValueError, match="read-only"):
        margins.closed_loop_poles[0] = 0
    with pytest.raises(AttributeError):
        margins.stable = False
    plain = json.loads(json.dumps(margins.as_dict(), allow_nan=False))
    assert list(plain) == [field.name for field in dataclasses.fields(LoopMargins)]
    assert plain["upper_gain_margin_db"] is None
    assert plain["crossovers_hz"] == list(margins.crossovers_hz)
    assert plain["closed_loop_poles"][0] == [margins.closed_loop_poles[0].real, 0]
    assert "phase margin             45 deg at 1 Hz" in margins.summary()
    assert "upper gain margin        inf dB\n" in str(margins)


@pytest.mark.parametrize(
    ("system", "error", "message"),
    [
        (control.ss(-np.eye(2), np.eye(2), np.eye(2), 0), ValueError, "2 inputs and 2 outputs"),
        (control.tf([1], [1, 0.5], True), ValueError, "dt = True names no sampling time"),
        (control.tf([1, 0, 0], [1, 0.5], 0.1), ValueError, "2 zeros and 1 poles"),
        (control.frd([1, 1j], [1, 2]), TypeError, "FrequencyResponseData; loop_margins takes"),
        (3.0, TypeError, "system is a float"),
        (control.tf([math.inf], [1, 1]), ValueError, "nan or inf"),
        (control.ss([[math.nan]], [[1]], [[1]], 0), ValueError, "nan or inf"),
        (-(S + 2) / (S + 1), ValueError, "ill-posed"),
        (control.ss([[-1]], [[1]], [[1]], -1), ValueError, r"1 \+ L\(∞\) = 0"),
    ],
)
def test_what_is_not_accepted_is_named_with_a_remedy(system, error, message):
    with pytest.raises(error, match=message):
        loop_margins(system)


@pytest.mark.parametrize(
    ("system", "delay", "message"),
    [
        (1 / S, -0.1, r"delay = -0.1: expected a number of seconds, 0 or more"),
        (1 / S, math.nan, "delay"),
        (1 / S, math.inf, "delay"),
        (control.tf([1], [1, -1], 0.1), 0.1, "zero_order_hold"),
    ],
    ids=["negative", "nan", "infinite", "discrete"],
)
def test_a_delay_that_is_not_accepted_is_named_with_a_remedy(system, delay, message):
    with pytest.raises(ValueError, match=message):
        loop_margins(system, delay=delay)


def test_integrators_hidden_by_a_change_of_states_stay_at_zero():
    """Rounding would split a triple integrator into poles near 1e-5, and limit the gain at DC."""
    rng = np.random.default_rng(7)
    loop = control.ss(pid_loop(*exact_pid()))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turned = control.ss(turn @ loop.A @ turn.T, turn @ loop.B, loop.C @ turn.T, 0)
    margins = loop_margins(turned)
    assert margins.phase_crossovers_hz == pytest.approx((0.4214465481280992,), rel=1e-12)
    assert margins.lower_gain_margin_db == pytest.approx(12, rel=1e-12)


def test_modes_that_cancel_count_in_stability_but_not_in_crossings():
    cancelling = control.ss((S + 2) / (S + 3)) * control.ss(1 / (S * (S + 2)))
    twice = control.ss(-np.eye(2), np.ones((2, 1)), np.ones((1, 2)), 0)
    apart = control.ss(np.diag([-1.0, -2.0]), [[1], [1]], [[1, -1]], 0)
    for loop, same in (
        (cancelling, 1 / (S * (S + 3))),
        (twice, 2 / (S + 1)),
        (apart, 1 / ((S + 1) * (S + 2))),
    ):
        margins, expected = loop_margins(loop), loop_margins(same)
        assert margins.crossovers_hz == pytest.approx(expected.crossovers_hz, rel=1e-12)
        assert margins.modulus_margin == pytest.approx(expected.modulus_margin, rel=1e-12)
        assert margins.phase_margin_deg == pytest.approx(expected.phase_margin_deg, rel=1e-12)
    assert np.min(abs(loop_margins(cancelling).closed_loop_poles + 2)) < 1e-12


def test_mixing_the_states_changes_nothing():
    """A turned companion form hides which coefficients were zero."""
    rng = np.random.default_rng(11)
    for loop in (5 / (S + 1) ** 3, delayed_pid(order=1), 0.3 * (S + 2) / (S * (S**2 + S + 4))):
        system = control.ss(loop)
        turn = np.linalg.qr(rng.standard_normal(system.A.shape))[0]
        turned = control.ss(turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T, system.D)
        margins, expected = loop_margins(turned), loop_margins(loop)
        for name in ("phase_margin_deg", "crossover_hz", "modulus_margin", "disk_margin"):
            assert getattr(margins, name) == pytest.approx(getattr(expected, name), rel=1e-9)
        assert margins.upper_gain_margin_db == pytest.approx(
            expected.upper_gain_margin_db, rel=1e-6
        )


def test_an_undriven_state_leaves_the_margins_alone():
    """Unscaled beside a companion form, such a state would drown its small coefficients."""
    for loop, expected in stable_random_margins()[:40]:
        system = control.ss(loop)
        zeros = np.zeros((system.nstates, 1))
        a = np.block([[system.A, zeros], [zeros.T, -np.ones((1, 1))]])
        b, c = np.vstack([system.B, [[0]]]), np.hstack([system.C, [[1]]])
        margins = loop_margins(control.ss(a, b, c, system.D))
        assert margins.modulus_margin == pytest.approx(expected.modulus_margin, rel=1e-7)
        assert margins.crossovers_hz == pytest.approx(expected.crossovers_hz, rel=1e-7)


def test_rounded_undamped_modes_do_not_count_as_phase_crossovers():
    system = control.ss((S**2 + 0.5) / (S * (S**2 + 1)))
    for seed in range(10):
        turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
        turned = control.ss(turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T, 0)
        margins = loop_margins(turned)
        assert not any(abs(2 * np.pi * hz - 1) < 1e-3 for hz in margins.phase_crossovers_hz)


def test_crossovers_of_badly_scaled_states_lie_on_the_unit_circle():
    loop = STABLE_RANDOM[83]
    system = control.ss(loop)
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal(system.A.shape))[0]
    a, b, c = turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T
    for hz in loop_margins(control.ss(a, b, c, 0)).crossovers_hz:
        value = c @ np.linalg.solve(2j * np.pi * hz * np.eye(len(a)) - a, b)
        assert abs(value[0, 0]) == pytest.approx(1, rel=1e-7)
