"""Margins of many loops against those of one, a count of roots, dense search and exact cases."""

import dataclasses
import math
from fractions import Fraction

import control
import mpmath
import numpy as np
import pytest

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_loops import ManyMargins, many_loop_margins, servo_margins
from jounce.plant import PID, Inertia, ServoLoop, design_pid

S = control.tf("s")
BETA = 3 + 2 * math.sqrt(2)
NAMES = [field.name for field in dataclasses.fields(ManyMargins)][1:]
GAINS = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)


def random_roots(rng, count, *, right=0.0, lightest=-2.5, decades=1.5):
    roots = []
    while len(roots) < count:
        size = 10 ** rng.uniform(-decades, decades)
        side = 1 if rng.random() < right else -1
        if count - len(roots) > 1 and rng.random() < 0.6:
            zeta = 10 ** rng.uniform(lightest, 0)
            root = size * complex(side * zeta, math.sqrt(1 - zeta**2))
            roots += [root, root.conjugate()]
        else:
            roots.append(side * size)
    return np.array(roots)


def random_loop(seed, **kinds):
    """Return numerator and denominator of order 1 to 8.

    Some have roots in the right half plane, resonances of damping ratio 1e-5, up to three
    integrators, as many zeros as poles, or gain of the other sign.
    """
    rng = np.random.default_rng(seed)
    order, kind = rng.integers(1, 9), rng.integers(0, 6)
    lightest = -5 if kind == 2 else -2.5
    poles = random_roots(rng, order, right=0.2 * (kind == 1), lightest=lightest, **kinds)
    most = order + (kind != 3)
    right = 0.3 * (kind == 4)
    zeros = random_roots(rng, rng.integers(0, most), right=right, lightest=lightest, **kinds)
    integrators = np.zeros(rng.integers(0, 4 if kind == 5 else 2))
    den = np.real(np.poly(np.concatenate([poles, integrators])))
    num = np.atleast_1d(np.real(np.poly(zeros)))
    level = abs(np.prod(poles)) / abs(np.prod(zeros)) * 10 ** rng.uniform(-2, 2.5)
    return num * level * (1 if rng.random() < 0.9 else -1), den


def random_delayed_loop(seed):
    """Return numerator and denominator, |L| < 1 as ω → ∞, and a delay."""
    num, den = random_loop(seed)
    if num.size == den.size:
        num = num * min(1.0, 0.5 * abs(den[0] / num[0]))
    return num, den, 10 ** np.random.default_rng(seed).uniform(-4, 1)


def stacked(rows):
    """Return polynomials of different degree as one array, with zeros in front."""
    width = max(row.size for row in rows)
    return np.array([np.concatenate([np.zeros(width - row.size), row]) for row in rows])


def together(loops):
    nums, dens, *delays = zip(*loops, strict=True)
    return many_loop_margins(stacked(nums), stacked(dens), delay=delays[0] if delays else 0.0)


def assert_same(actual, expected, names=NAMES, rtol=1e-9, message=""):
    for name in names:
        values = [float(getattr(result, name)) for result in (actual, expected)]
        np.testing.assert_allclose(*values, rtol=rtol, err_msg=f"{name} {message}")


def evaluate(loop, omega):
    num, den, delay = loop
    s = 1j * np.asarray(omega)
    return np.polyval(num, s) / np.polyval(den, s) * np.exp(-s * delay)


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


LIGHT = 0.01
TOUCHING = 2 * LIGHT * math.sqrt(1 - LIGHT**2)
CORNER = 1 / math.tan(math.radians(75))
EDGES = {
    "resonance touches unit gain": TOUCHING / (S**2 + 2 * LIGHT * S + 1),
    "resonance just above unit gain": TOUCHING * (1 + 1e-8) / (S**2 + 2 * LIGHT * S + 1),
    "resonance just below unit gain": TOUCHING * (1 - 1e-8) / (S**2 + 2 * LIGHT * S + 1),
    "phase touches 180 degrees": 3e3 * (S + 1) ** 2 / (S**3 * (S / BETA + 1) ** 2),
    "phase margin towards lead": 0.3 * S / (S**2 + 0.1 * S + 1)
    * ((1 - S / CORNER) / (1 + S / CORNER)) ** 2,
    "unstable": 50 / (S + 1) ** 3,
    "undamped": 1 / S**2,
    "hidden integrator": control.tf([1, 0], [1, 1, 0]),
    "hidden pole on the right": control.tf([1, -1], [1, 1, -2]),
    "hidden undamped mode": (S**2 + 1) / ((S**2 + 1) * (S + 1)),
    "sign": -2 / (S + 1),
    "undamped mode and zeros": (S**2 + 0.5) / (S * (S**2 + 1)),
    "undamped mode twice": 0.1 * (S + 0.5) ** 3 / (S**2 + 1) ** 2,
    "undamped zeros": (S**2 + 1) / (S + 0.1) ** 3,
    "stable open loop, no gain": control.tf([0], [1, 1]),
    "integrator, no gain": control.tf([0], [1, 0]),
    "unstable open loop, no gain": control.tf([0], [1, -1]),
    "unstable pole": 2.5 * (S + 2) / ((S - 1) * (S + 3)),
    "limit at DC above": control.tf([-2.0, -1.0], [-1.0, 1.0, 0.3]),
    "limit at DC below": control.tf([-0.5], [1, 1]),
    "limit at infinity": (1 - S / 2) / (1 + S),
    "no roll-off": (2 * S + 1) / (S + 1),
    "improper": S + 1,
    "static": control.tf([3.0], [1.0]),
    "static negative": control.tf([-0.5], [1.0]),
    "static beyond": control.tf([-2.0], [1.0]),
    "unit gain at DC": 1 / (S + 1),
    "closed-loop pole at 0": -1 / (S + 1),
    "differentiator": 3 * S**2 / (S + 1) ** 3,
    "all-pass": 0.5 * (1 - S) / (1 + S),
    "eight equal lags": 1.5 / (S + 1) ** 8,
    "corners 12 decades apart": 1e9 / ((S + 1e-6) * (S + 1e6) * (S + 1e3)),
    "two unstable poles": 60 * (S + 1) ** 2 / ((S - 1) * (S - 0.5) * (S + 20)),
}  # fmt: skip


@pytest.mark.parametrize("name", EDGES)
def test_edges_agree_with_the_margins_of_one_loop(name):
    loop = EDGES[name]
    one = loop_margins(loop)
    margins = many_loop_margins(loop.num_array[0, 0], loop.den_array[0, 0])
    assert bool(margins.stable) == one.stable
    # Of a touch the place has half of the digits.
    rtol = 1e-5 if name == "phase touches 180 degrees" else 1e-9
    assert_same(margins, one, [n for n in NAMES if n != "modulus_margin_hz"], rtol)


def test_an_ill_posed_loop_among_others_is_unstable():
    margins = many_loop_margins([[-1.0, -2.0], [1.0, 2.0]], [1.0, 1.0])
    assert margins.stable.tolist() == [False, True]
    assert np.isnan(margins.modulus_margin[0])


def test_no_delay_at_all_is_borne_where_the_gain_does_not_roll_off():
    margins = many_loop_margins([2.0, 1.0], [1.0, 1.0], delay=[0.0, 1e-12, 1.0])
    assert margins.stable.tolist() == [True, False, False]
    assert (margins.delay_margin_s[0], margins.delay_margin_hz[0]) == (0.0, math.inf)


def test_small_gain_bears_every_delay_and_its_distance_is_the_gain_it_starts_with():
    delay = 10.0 ** np.arange(3, 31, 3)
    margins = many_loop_margins([0.5], [1.0, 1.0], delay=delay)
    assert margins.stable.all()
    np.testing.assert_allclose(margins.modulus_margin, 0.5, rtol=1e-5)
    np.testing.assert_allclose(margins.modulus_margin_hz, 0.5 / delay, rtol=1e-2)
    np.testing.assert_allclose(margins.upper_gain_margin_db, 20 * math.log10(2), rtol=1e-4)
    assert np.all(margins.delay_margin_s == math.inf)


def test_behind_a_delay_a_gain_that_levels_off_comes_by_again_and_again():
    """0.9(s + 1)/(s + 2) rises to 0.9, whose phase passes −180° without end."""
    margins = many_loop_margins([0.9, 0.9], [1.0, 2.0], delay=0.7)
    assert margins.stable
    assert margins.upper_gain_margin_db == pytest.approx(-20 * math.log10(0.9), rel=1e-13)
    assert margins.upper_gain_margin_hz == math.inf
    assert margins.modulus_margin == pytest.approx(0.1, rel=1e-13)
    assert margins.modulus_margin_hz == math.inf


def test_many_turns_of_phase_under_a_resonance():
    """The gain margin is that of the crossing nearest the peak, a thousand turns up."""
    delay, zeta = 300.0, 0.2
    num, den = np.array([0.3]), np.array([1.0, 2 * zeta, 1.0])
    margins = many_loop_margins(num, den, delay=delay)
    omega = np.linspace(1e-9, 3.0, 1_000_001)
    value = evaluate((num, den, delay), omega)
    assert margins.stable == (abs(value).max() < 1)
    assert margins.modulus_margin == pytest.approx(abs(1 + value).min(), rel=1e-6)
    negative = (np.diff(np.sign(value.imag)) != 0) & (value.real[1:] < 0)
    largest = abs(value[1:][negative]).max()
    assert margins.upper_gain_margin_db == pytest.approx(-20 * math.log10(largest), rel=1e-4)


def modal_loop(zeta, coupling):
    """PID with a roll-off on an inertia with five modes: order 13, modes in partial fractions."""
    num, den = np.array([1.0]), np.array([1.0, 0.0, 0.0])
    for omega in (9.0, 21.0, 34.0, 55.0, 80.0):
        mode = np.array([1.0, 2 * zeta * omega, omega**2])
        num, den = np.polyadd(np.polymul(num, mode), coupling * den), np.polymul(den, mode)
    return np.polymul(num, [GAINS.kr, GAINS.kp, GAINS.ki]), np.polymul(den, [1 / 400, 1, 0])


@pytest.mark.parametrize("zeta", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("coupling", [0.2, 0.001])
def test_lightly_damped_modes(zeta, coupling):
    num, den = modal_loop(zeta, coupling)
    assert_same(many_loop_margins(num, den), loop_margins(control.tf(num, den)), NAMES, 1e-11)


def test_a_notch_eight_decades_from_the_other_corners_is_not_lost():
    """It takes the gain below 1 over 0.4 % of its frequency: the roots in ω² do not show it."""
    num = [9.589818219409615e17, 2.9878681796293023e21, 346041833881789.44, 33434157840845.117]
    den = [1.0, 5783.050600158945, 25320011.734293126, 136889875809.54984]
    one = loop_margins(control.tf(num, den))
    assert len(one.crossovers_hz) == 2
    assert_same(many_loop_margins(num, den), one)


def exact(values):
    return [Fraction(value) for value in values]


def routh(row):
    """Return the first column of Routh's array: of one sign where all roots lie on the left."""
    upper, lower = row[0::2], row[1::2]
    column = [upper[0]]
    while lower:
        column.append(lower[0])
        padded = [*lower, 0]
        ratio = upper[0] / lower[0]
        upper, lower = lower, [a - ratio * b for a, b in zip(upper[1:], padded[1:], strict=False)]
    return column


def test_poles_of_the_closed_loop_twenty_decades_apart():
    """The eigenvalues that a list of closed-loop poles is made of lie on the right by rounding."""
    num = [
        3.0704684295185866e23,
        6.468022470181102e21,
        6.020212992765183e24,
        1.1246598283107689e22,
        9.38477910783256e23,
        2.974359144232526e20,
        5.972300108971104e16,
        10988299658169.584,
    ]
    den = [1.0, 54.44604638235246, 3911359.3790776758, 177875205.00885123, 1775097594764.1985,
           357804970538.93774, 2578840058752705.5, 122199819030839.53, 0.0]  # fmt: skip
    assert min(routh([d + n for d, n in zip(exact(den), exact([0.0, *num]), strict=True)])) > 0
    assert many_loop_margins(num, den).stable


def test_each_loop_has_the_margins_that_it_has_alone():
    loops = [random_delayed_loop(seed) for seed in range(30)]
    margins = together(loops)
    for i, (num, den, delay) in enumerate(loops):
        alone = many_loop_margins(num, den, delay=delay)
        assert alone.shape == ()
        assert margins.stable[i] == alone.stable
        assert_same(margins[i], alone, NAMES[:-1], 1e-11, f"seed {i}")


def test_more_loops_than_one_chunk_holds():
    delay = np.linspace(0, 0.2, 10_000)
    margins = servo_margins(1.0, GAINS, delay=delay)
    np.testing.assert_array_equal(margins.stable, delay < 0.125)
    good = margins[margins.stable]
    np.testing.assert_allclose(good.delay_margin_s, 0.125 - delay[delay < 0.125], atol=1e-12)


@pytest.mark.parametrize(
    ("numerator", "denominator", "delay", "shape"),
    [
        ([1.0], [1.0, 1.0, 0.0], 0.1, ()),
        (1.0, [1.0, 1.0, 0.0], 0.1, ()),
        ([[1.0]] * 3, [1.0, 1.0, 0.0], 0.1, (3,)),
        ([1.0], [[[1.0, 1.0, 0.0]] * 2] * 4, [0.1, 0.1], (4, 2)),
        ([[0.0, 0.0, 1.0]], [0.0, 1.0, 1.0, 0.0], [[0.1], [0.1]], (2, 1)),
        (np.ones((0, 1)), [1.0, 1.0, 0.0], 0.1, (0,)),
    ],
    ids=["one", "number", "numerators", "grid", "zeros-in-front", "none"],
)
def test_arguments_are_broadcast(numerator, denominator, delay, shape):
    margins = many_loop_margins(numerator, denominator, delay=delay)
    assert margins.shape == shape
    expected = many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=0.1)
    for name in NAMES:
        values = getattr(margins, name)
        assert values.shape == shape
        np.testing.assert_allclose(values, getattr(expected, name), rtol=1e-14)


def test_servo_margins_are_those_of_the_servo_loop():
    inertia, delay = np.array([[0.5], [2.0]]), np.array([0.0, 0.03])
    margins = servo_margins(inertia, GAINS, gain=1.3, delay=delay)
    assert margins.shape == (2, 2)
    for i, k in np.ndindex(margins.shape):
        loop = ServoLoop(Inertia(inertia[i, 0]), GAINS).loop_transfer() * 1.3
        assert_same(margins[i, k], loop_margins(loop, delay=delay[k]), NAMES[:-1])


@pytest.mark.parametrize(
    ("controller", "stable"),
    [(PID(2.0, 0.0, 3.0), True), (PID(2.0, 0.0, 0.0), False), (PID(0.0, 0.0, 0.0), False)],
    ids=["PD", "P", "nothing"],
)
def test_without_an_integral_there_is_no_integrator(controller, stable):
    margins = servo_margins(Inertia(2.0), controller)
    assert bool(margins.stable) == stable
    if stable:
        loop = ServoLoop(Inertia(2.0), controller).loop_transfer()
        assert_same(margins, loop_margins(loop))


def test_the_result_is_frozen_and_indexed_as_one():
    margins = servo_margins([[1.0], [50.0]], GAINS, delay=[0.0, 0.05, 1.0])
    assert repr(margins) == "ManyMargins(shape=(2, 3), stable=2)"
    with pytest.raises(ValueError, match="read-only"):
        margins.phase_margin_deg[0] = 0.0
    with pytest.raises(AttributeError):
        margins.stable = True
    assert margins[0].shape == (3,)
    assert margins[..., 1].phase_margin_deg[0] == pytest.approx(27, rel=1e-11)
    assert margins[margins.stable].shape == (2,)
    for name in NAMES:
        assert np.isnan(getattr(margins, name)[~margins.stable]).all()


def test_results_do_not_change_with_the_arguments():
    delay = np.array([0.0, 0.01])
    margins = many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=delay)
    before = margins.phase_margin_deg.copy()
    delay[:] = 5.0
    np.testing.assert_array_equal(margins.phase_margin_deg, before)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (([], [1.0, 1.0]), ValueError, r"numerator of shape \(0,\) has no coefficients"),
        (([1.0], [0.0, 0.0]), ValueError, r"denominator = \[0.0, 0.0\]: expected a polynomial"),
        (([1.0], [[1.0], [0.0]]), ValueError, r"denominator\[1\] = \[0.0\]"),
        (([1.0, math.nan], [1.0, 1.0]), ValueError, r"numerator\[1\] = nan"),
        (([1.0], [math.inf, 1.0]), ValueError, r"denominator\[0\] = inf"),
        (([1j], [1.0, 1.0]), TypeError, r"numerator = \[1j\]: expected a number"),
        (([1.0], [1.0, 1.0], -1.0), ValueError, "delay = -1.0: expected delays of zero or more"),
        (([1.0], [1.0, 1.0], [0.0, -2.0]), ValueError, r"delay\[1\] = -2.0"),
        (([1.0], [1.0, 1.0], math.nan), ValueError, "delay must be finite"),
        ((np.ones((3, 2)), np.ones((4, 3))), ValueError, r"\(3,\), denominators of \(4,\)"),
        (([1e300], [1.0, 1.0], 1.0), ValueError, "range of a double: choose units"),
    ],
    ids=["empty", "zero", "zero-row", "nan", "inf", "complex", "negative", "negative-element",
         "nan-delay", "shapes", "range"],
)  # fmt: skip
def test_what_is_not_accepted_is_named_with_a_remedy(arguments, error, message):
    numerator, denominator, *delay = arguments
    with pytest.raises(error, match=message):
        many_loop_margins(numerator, denominator, delay=delay[0] if delay else 0.0)


@pytest.mark.parametrize(
    ("inertia", "options", "error", "message"),
    [
        ([1.0, 0.0], {}, ValueError, r"inertia\[1\] = 0.0: expected positive inertias"),
        (math.nan, {}, ValueError, "inertia must be finite"),
        (1.0, {"gain": math.inf}, ValueError, "gain must be finite"),
        (1.0, {"controller": 3.0}, TypeError, "controller = 3.0: expected a PID"),
    ],
    ids=["zero", "nan", "gain", "controller"],
)
def test_what_a_servo_loop_does_not_accept(inertia, options, error, message):
    with pytest.raises(error, match=message):
        servo_margins(inertia, **{"controller": GAINS} | options)
