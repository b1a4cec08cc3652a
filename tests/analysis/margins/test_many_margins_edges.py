"""Margins of many loops where gain or phase touches, turns or levels off: exact cases."""

import math
from fractions import Fraction

import control
import numpy as np
import pytest
from many_loops import GAINS, NAMES, assert_same, evaluate

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_margins import many_loop_margins

S = control.tf("s")
BETA = 3 + 2 * math.sqrt(2)
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
