"""Margins of many loops against those of one, a count of roots and a dense search."""

import math

import control
import mpmath
import numpy as np
import pytest
from many_loops import (
    GAINS,
    NAMES,
    assert_same,
    evaluate,
    random_delayed_loop,
    random_loop,
    stacked,
    together,
)

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_margins import many_loop_margins, servo_margins

DELAYED = [random_delayed_loop(seed) for seed in range(400)]


@pytest.fixture(scope="module")
def delayed():
    """Margins of random loops behind delays."""
    return together(DELAYED)


def test_random_rational_loops_have_the_margins_of_each_alone():
    loops = [random_loop(seed) for seed in range(150)]
    margins = together(loops)
    assert 30 < np.count_nonzero(margins.stable) < 120
    for seed, loop in enumerate(loops):
        one = loop_margins(control.tf(*loop))
        assert margins.stable[seed] == one.stable, f"seed {seed}"
        # A smooth minimum leaves its place eight digits.
        assert_same(margins[seed], one, NAMES[:-1], message=f"seed {seed}")
        np.testing.assert_allclose(
            margins.modulus_margin_hz[seed], one.modulus_margin_hz, rtol=1e-4, err_msg=f"{seed}"
        )


@pytest.mark.parametrize("seed", [0, 3, 6, 23, 49, 61])
def test_random_loops_behind_a_delay_have_the_margins_of_each_alone(seed, delayed):
    num, den, delay = DELAYED[seed]
    one = loop_margins(control.tf(num, den), delay=delay)
    assert delayed.stable[seed] == one.stable
    assert_same(delayed[seed], one, NAMES[:-1])


def crossings_of_the_axis(num, den):
    """Return all (ω, sign) with |G(jω)| = 1, the sign that of the slope of |G|."""

    def square(row):
        return np.polymul(row, row * (-1.0) ** np.arange(row.size - 1, -1, -1))

    roots = np.roots(np.polysub(square(num), square(den)))
    found = []
    for omega in roots[(abs(roots.real) < 1e-6 * abs(roots)) & (roots.imag > 0)].imag:
        for _ in range(6):
            value, *beside = (
                math.log(abs(evaluate((num, den, 0.0), omega * (1 + part))))
                for part in (0.0, -1e-6, 1e-6)
            )
            slope = (beside[1] - beside[0]) / 2e-6
            omega *= math.exp(-value / slope) if abs(value) < 0.1 * abs(slope) else 1.0
        found.append((omega, np.sign(slope)))
    return found


def unstable_roots(num, den, delay):
    """Count closed-loop roots on the right: those without delay, and what crosses until then.

    Walton and Marshall, "Direct method for TDS stability analysis" (1987).
    """
    num, den = (np.trim_zeros(row, "f") for row in (num, den))
    count = np.sum(np.roots(np.polyadd(den, num)).real > 0)
    for omega, sign in crossings_of_the_axis(num, den):
        first = (np.angle(evaluate((num, den, 0.0), omega)) + np.pi) % (2 * np.pi)
        count -= 2 * sign * max(0, math.ceil((omega * delay - first) / (2 * np.pi)))
    return count


def test_stability_behind_a_delay_agrees_with_a_count_of_the_roots_that_cross(delayed):
    wrong = [
        seed
        for seed, loop in enumerate(DELAYED)
        if delayed.stable[seed] != (unstable_roots(*loop) == 0)
    ]
    assert wrong == []
    assert 80 < np.count_nonzero(delayed.stable) < 300


def dense_frequencies(loop):
    num, den, delay = loop
    roots = np.concatenate([np.roots(num), np.roots(den)])
    sizes = abs(roots[roots != 0])
    low, high = min(sizes.min(), 1 / delay), max(1e3 * sizes.max(), 400 / delay)
    near = (roots.imag[roots.imag > 0, None] * (1 + np.linspace(-0.05, 0.05, 1001))).ravel()
    wide = np.geomspace(1e-4 * low, high, 30_000)
    return np.unique(np.concatenate([wide, near, np.linspace(0, 60 / delay, 10_000)[1:]]))


def bisected(function, low, high):
    sign = np.sign(function(low))
    for _ in range(60):
        middle = 0.5 * (low + high)
        left = np.sign(function(middle)) == sign
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return 0.5 * (low + high)


def searched(loop):
    """Return the margins found on a dense grid of frequencies, by name."""
    num, den, _ = loop
    omega = dense_frequencies(loop)
    value = evaluate(loop, omega)
    at = np.nonzero(np.diff(np.sign(abs(value) - 1)))[0]
    crossovers = bisected(lambda w: abs(evaluate(loop, w)) - 1, omega[at], omega[at + 1])
    angles = np.angle(-evaluate(loop, crossovers))
    negative = (value.real[1:] < 0) & (value.real[:-1] < 0)
    at = np.nonzero((np.diff(np.sign(value.imag)) != 0) & negative)[0]
    real = bisected(lambda w: evaluate(loop, w).imag, omega[at], omega[at + 1])
    at_dc = num[-1] / den[-1] if den[-1] else 0.0
    at_end = abs(num[0] / den[0]) if num.size == den.size else 0.0
    sizes = [*abs(evaluate(loop, real)), *([-at_dc] if at_dc < 0 else []), at_end]
    decibels = 20 * np.log10([size for size in sizes if size > 0])
    best = abs(1 + value).argmin()
    ends = omega[max(best - 1, 0)], omega[min(best + 1, omega.size - 1)]
    inner = abs(1 + evaluate(loop, np.linspace(*ends, 20_001))).min()
    limits = [abs(1 + at_dc) if den[-1] else math.inf, 1 - at_end]
    return {
        "phase_margin_deg": min(abs(np.degrees(angles)), default=math.inf),
        "delay_margin_s": min(angles % (2 * np.pi) / crossovers, default=math.inf),
        "lower_gain_margin_db": min(decibels[decibels > 0], default=math.inf),
        "upper_gain_margin_db": -max(decibels[decibels < 0], default=-math.inf),
        "modulus_margin": min(inner, *limits),
    }


def test_a_dense_search_behind_delays_finds_the_same_margins(delayed):
    stable = np.nonzero(delayed.stable)[0][:40]
    for seed in stable.tolist():
        for name, expected in searched(DELAYED[seed]).items():
            actual = getattr(delayed, name)[seed]
            assert actual == pytest.approx(expected, rel=1e-7), f"{name}, seed {seed}"


def test_loops_lose_stability_at_their_margins_and_not_before(delayed):
    stable = np.nonzero(delayed.stable)[0]
    nums, dens, delays = zip(*(DELAYED[i] for i in stable), strict=True)
    num, den, delay = stacked(nums), stacked(dens), np.array(delays)
    kept, counted = delayed[stable], dict.fromkeys(("lower", "upper", "delay"), 0)
    for share, expected in ((1 - 1e-6, True), (1 + 1e-6, False)):
        for name, sign in (("lower", -1), ("upper", 1)):
            decibels = getattr(kept, f"{name}_gain_margin_db")
            limited = decibels < 200
            counted[name] += np.count_nonzero(limited)
            factor = 10 ** (sign * share * decibels[limited] / 20)
            again = many_loop_margins(
                num[limited] * factor[:, None], den[limited], delay=delay[limited]
            )
            assert np.all(again.stable == expected)
        limited = kept.delay_margin_s < 1e6
        counted["delay"] += np.count_nonzero(limited)
        added = share * kept.delay_margin_s[limited]
        again = many_loop_margins(num[limited], den[limited], delay=delay[limited] + added)
        assert np.all(again.stable == expected)
    assert min(counted.values()) >= 4


def test_fifty_digits_confirm_the_places_of_the_margins(delayed):
    checked = 0
    for seed in np.nonzero(delayed.stable)[0][:25].tolist():
        num, den, delay = DELAYED[seed]
        margins = delayed[seed]

        def value(hz, loop=(num, den, delay)):
            s = mpmath.mpc(0, 2 * mpmath.pi * mpmath.mpf(float(hz)))
            top, bottom = (np.polyval([mpmath.mpf(c) for c in row.tolist()], s) for row in loop[:2])
            return top / bottom * mpmath.exp(-s * mpmath.mpf(loop[2]))

        with mpmath.workdps(50):
            for sign, name in ((-1, "lower_gain_margin"), (1, "upper_gain_margin")):
                hz = getattr(margins, f"{name}_hz")
                if 0 < hz < math.inf:
                    factor = 10 ** (sign * float(getattr(margins, f"{name}_db")) / 20)
                    assert abs(1 + factor * value(hz)) < 1e-9
                    checked += 1
            if math.isfinite(margins.phase_margin_deg):
                turn = mpmath.exp(1j * mpmath.radians(float(margins.phase_margin_deg)))
                there = value(margins.crossover_hz)
                assert min(abs(1 + there * turn), abs(1 + there / turn)) < 1e-10
                checked += 1
            if 0 < margins.modulus_margin_hz < math.inf:
                nearest = abs(1 + value(margins.modulus_margin_hz))
                assert float(nearest) == pytest.approx(float(margins.modulus_margin), rel=1e-11)
    assert checked > 20


def test_an_integrator_behind_delays_has_margins_known_exactly():
    delay = np.array([0.0, 1e-9, 0.3, 1.2, 1.57, 1.58, 40.0])
    margins = many_loop_margins([1.0], [1.0, 0.0], delay=delay)
    assert margins.stable.tolist() == [True] * 5 + [False] * 2
    good, left = margins[:5], math.pi / 2 - delay[:5]
    np.testing.assert_allclose(good.phase_margin_deg, np.degrees(left), rtol=1e-11)
    np.testing.assert_allclose(good.delay_margin_s, left, rtol=1e-11)
    np.testing.assert_allclose(good.crossover_hz, 1 / (2 * math.pi), rtol=1e-14)
    upper = 20 * np.log10(math.pi / 2 / delay[1:5])
    np.testing.assert_allclose(good.upper_gain_margin_db[1:], upper, rtol=1e-11)
    np.testing.assert_allclose(good.upper_gain_margin_hz[1:], 0.25 / delay[1:5], rtol=1e-13)
    assert good.upper_gain_margin_db[0] == math.inf
    assert np.all(good.lower_gain_margin_db == math.inf)
    assert np.isnan(good.lower_gain_margin_hz).all()


@pytest.mark.parametrize("order", [3, 8, 20, 30])
def test_equal_lags_have_their_closed_form_margins(order):
    """Their roots come out of eigenvalues as a wide circle; the margins do not mind."""
    limit = math.cos(math.pi / order) ** -order
    gain = np.array([0.5, 0.98, 1.02]) * limit
    margins = many_loop_margins(gain[:, None], np.poly(-np.ones(order)))
    assert margins.stable.tolist() == [True, True, False]
    decibels = 20 * np.log10(limit / gain[:2])
    np.testing.assert_allclose(margins.upper_gain_margin_db[:2], decibels, rtol=1e-11)
    crossover = np.sqrt(gain[1] ** (2 / order) - 1) / (2 * math.pi)
    assert margins.crossover_hz[1] == pytest.approx(crossover, rel=1e-11)


def test_the_exact_design_keeps_its_specifications_and_pays_for_delay():
    delay = np.array([0.0, 0.01, 0.05, 0.1, 0.12])
    margins = servo_margins(1.0, GAINS, delay=delay)
    np.testing.assert_allclose(margins.crossover_hz, 1, rtol=1e-13)
    np.testing.assert_allclose(margins.phase_margin_deg, 45 - 360 * delay, rtol=1e-11)
    np.testing.assert_allclose(margins.delay_margin_s, 0.125 - delay, rtol=1e-11)
    assert margins.lower_gain_margin_db[0] == pytest.approx(12, rel=1e-12)
    assert margins.upper_gain_margin_db[0] == math.inf
    assert np.all(np.diff(margins.lower_gain_margin_db) < 0)
    assert np.all(np.diff(margins.upper_gain_margin_db[1:]) < 0)
    assert margins.modulus_margin[0] == pytest.approx(0.75645, abs=5e-6)
    assert margins.modulus_margin_hz[0] == pytest.approx(0.9102, abs=5e-5)


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_margins_do_not_depend_on_the_unit_of_time(factor, delayed):
    for seed in np.nonzero(delayed.stable)[0][:20].tolist():
        num, den, delay = DELAYED[seed]
        scaled = (row * factor ** -np.arange(row.size - 1.0, -1, -1) for row in (num, den))
        margins = many_loop_margins(*scaled, delay=delay / factor)
        for name in NAMES[:-1]:
            power = {"hz": 1, "s": -1}.get(name.rsplit("_", 1)[1], 0)
            expected = getattr(delayed, name)[seed] * factor**power
            np.testing.assert_allclose(
                getattr(margins, name), expected, rtol=1e-9, err_msg=f"{name}, seed {seed}"
            )
