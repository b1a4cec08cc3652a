"""Loops with a pure delay, against Lambert's W, high-order Padé, and the loop evaluated itself."""

import math

import control
import numpy as np
import pytest
from scipy.special import lambertw
from tiers import some

from jounce.analysis.margins import loop_margins, many_loop_margins
from jounce.analysis.margins.delayed_poles import rightmost_poles
from jounce.analysis.margins.factoring import factored
from jounce.analysis.margins.many_crossings import pieces_of
from jounce.analysis.margins.many_crossings import stable as is_stable
from jounce.analysis.margins.rooted_loops import rooted
from jounce.plant import design_pid

S = control.tf("s")
GAINS = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
PID_LOOP = control.tf([GAINS.kr, GAINS.kp, GAINS.ki], [1.0, 0.0, 0.0, 0.0])
MARGINS = ("lower_gain_margin", "upper_gain_margin")


def random_roots(rng, count, *, right=0.2):
    roots = []
    while len(roots) < count:
        size = 10 ** rng.uniform(-1, 1)
        if count - len(roots) > 1 and rng.random() < 0.5:
            damping = rng.uniform(-right, 0.9)
            pole = size * (-damping + 1j * math.sqrt(1 - damping**2))
            roots += [pole, pole.conjugate()]
        else:
            roots.append(size * rng.choice([-1.0, -1.0, -1.0, 1.0 if right else -1.0, 0.0]))
    return np.array(roots)


def random_loop(seed):
    """Return a random transfer function with at most as many zeros as poles, and a delay."""
    rng = np.random.default_rng(seed)
    zeros = rng.integers(0, 3)
    poles = rng.integers(zeros + 1, 5)
    num = np.atleast_1d(np.real(np.poly(random_roots(rng, zeros, right=0.0))))
    den = np.real(np.poly(random_roots(rng, poles)))
    return control.tf(num * 10 ** rng.uniform(-1, 1), den), 10 ** rng.uniform(-2, 1)


def first_stable(count):
    """Return the first of the random loops that are stable behind their delay."""
    found, seed = [], 0
    while len(found) < count:
        loop, delay = random_loop(seed)
        if loop_margins(loop, delay=delay).stable:
            found.append((seed, loop, delay))
        seed += 1
    return found


STABLE = first_stable(12)
stable_loops = pytest.mark.parametrize(
    ("seed", "loop", "delay"), STABLE, ids=[f"seed{seed}" for seed, _, _ in STABLE]
)


def evaluate(loop, delay, hz):
    s = 2j * np.pi * np.asarray(hz)
    return loop(s) * np.exp(-s * delay)


@pytest.mark.parametrize("delay", [1e-4, 0.3, 1.2, 1.57])
def test_an_integrator_behind_a_delay_has_margins_known_exactly(delay):
    margins = loop_margins(1 / S, delay=delay)
    assert margins.stable
    assert margins.phase_margin_deg == pytest.approx(math.degrees(math.pi / 2 - delay), rel=1e-12)
    assert margins.delay_margin_s == pytest.approx(math.pi / 2 - delay, rel=1e-12)
    assert margins.upper_gain_margin_db == pytest.approx(
        20 * math.log10(math.pi / 2 / delay), rel=1e-12
    )
    assert margins.lower_gain_margin_db == math.inf


@pytest.mark.parametrize("delay", [0.05, 0.3, 0.5, 1.2, 1.6, 4.0, 40.0])
def test_poles_of_an_integrator_behind_a_delay_are_those_of_lamberts_w(delay):
    poles = loop_margins(1 / S, delay=delay).closed_loop_poles
    expected = [lambertw(-delay, k) / delay for k in (-1, 0)]
    for pole in expected:
        assert abs(poles - pole).min() < 1e-9 * abs(pole)
    assert poles[0].real == pytest.approx(max(p.real for p in expected), rel=1e-9)
    assert loop_margins(1 / S, delay=delay).stable == (delay < math.pi / 2)


@pytest.mark.parametrize("seed", some(range(150), 50))
def test_stability_by_counting_agrees_with_the_rightmost_pole(seed):
    loop, delay = random_loop(seed)
    [stable] = is_stable(pieces_of(rooted(factored(loop, delay))))
    poles = rightmost_poles(factored(loop, delay), np.empty(0))
    assert stable == (poles[0].real < 0), f"seed {seed}: {loop} behind {delay}: {poles[:3]}"


@pytest.mark.parametrize("seed", range(30))
def test_poles_agree_with_a_pade_approximation_of_high_order(seed):
    loop, delay = random_loop(seed)
    num, den = control.pade(delay, 7)
    approximate = np.roots(
        np.polyadd(np.polymul(loop.den_array[0, 0], den), np.polymul(loop.num_array[0, 0], num))
    )
    near = approximate[abs(approximate) * delay < 2.0]
    poles = rightmost_poles(factored(loop, delay), np.empty(0))
    for pole in near:
        assert abs(poles - pole).min() < 1e-6 * (abs(pole) + 1 / delay), f"seed {seed}: {pole}"


@pytest.mark.parametrize(
    ("seed", "loop", "delay"), STABLE, ids=lambda value: str(value)[:6].strip()
)
def test_a_gain_margin_takes_the_loop_to_the_verge(seed, loop, delay):
    margins = loop_margins(loop, delay=delay)
    for name, sign in zip(MARGINS, (-1, 1), strict=True):
        margin, hz = getattr(margins, f"{name}_db"), getattr(margins, f"{name}_hz")
        if not math.isfinite(margin) or not 0 < hz < math.inf:
            continue
        factor = 10 ** (sign * margin / 20)
        assert abs(1 + factor * evaluate(loop, delay, hz)) < 1e-9, f"seed {seed}: {name}"
        inside, outside = (loop * factor ** (1 + step) for step in (-1e-6, 1e-6))
        assert loop_margins(inside, delay=delay).stable, f"seed {seed}: {name} {factor}"
        assert not loop_margins(outside, delay=delay).stable, f"seed {seed}: {name} {factor}"


@pytest.mark.parametrize(
    ("seed", "loop", "delay"), STABLE, ids=lambda value: str(value)[:6].strip()
)
def test_a_delay_margin_takes_the_loop_to_the_verge(seed, loop, delay):
    margins = loop_margins(loop, delay=delay)
    if math.isfinite(margins.delay_margin_s):
        longest = delay + margins.delay_margin_s
        assert abs(1 + evaluate(loop, longest, margins.delay_margin_hz)) < 1e-9, f"seed {seed}"
        assert loop_margins(loop, delay=longest * (1 - 1e-6)).stable, f"seed {seed}"
        assert not loop_margins(loop, delay=longest * (1 + 1e-6)).stable, f"seed {seed}"


@pytest.mark.parametrize(
    ("seed", "loop", "delay"), STABLE, ids=lambda value: str(value)[:6].strip()
)
def test_margins_do_not_depend_on_the_unit_of_time(seed, loop, delay):
    margins = loop_margins(loop, delay=delay)
    factor = 1e-9
    num, den = (
        part[0, 0] * factor ** -np.arange(part[0, 0].size - 1.0, -1, -1)
        for part in (loop.num_array, loop.den_array)
    )
    fast = loop_margins(control.tf(num, den), delay=delay / factor)
    for name in ("phase_margin_deg", "lower_gain_margin_db", "upper_gain_margin_db"):
        assert getattr(fast, name) == pytest.approx(getattr(margins, name), rel=1e-9), seed
    assert fast.sensitivity_peak == pytest.approx(margins.sensitivity_peak, rel=1e-8), seed
    assert fast.delay_margin_s == pytest.approx(margins.delay_margin_s / factor, rel=1e-9), seed


def test_the_designed_pid_behind_a_delay_has_both_gain_margins():
    margins = loop_margins(PID_LOOP, delay=0.02)
    assert margins.phase_margin_deg == pytest.approx(45 - 360 * 0.02, rel=1e-12)
    assert 0 < margins.lower_gain_margin_db < 12
    assert 0 < margins.upper_gain_margin_db < math.inf
    approximate = loop_margins(PID_LOOP * control.tf(*control.pade(0.02, 6)))
    for name in ("lower_gain_margin_db", "upper_gain_margin_db", "modulus_margin", "bandwidth_hz"):
        assert getattr(margins, name) == pytest.approx(getattr(approximate, name), rel=1e-6), name


@pytest.mark.parametrize("gain", [0.3, 0.99, 1.01])
def test_a_loop_that_does_not_roll_off_is_stable_behind_a_delay_below_gain_one_alone(gain):
    margins = loop_margins(gain * (S + 2) / (S + 3), delay=0.7)
    assert margins.stable == (gain < 1)
    if gain < 1:
        assert margins.upper_gain_margin_db == pytest.approx(-20 * math.log10(gain), rel=1e-12)
        assert margins.upper_gain_margin_hz == math.inf
        assert margins.modulus_margin == pytest.approx(1 - gain, rel=1e-12)


def test_a_delay_may_stabilise():
    """Positive feedback of an oscillator: half a turn later the sign is right again."""
    oscillator = control.tf([0.5], [1, 0.01, 1])
    stable = [loop_margins(-oscillator, delay=d).stable for d in (1e-3, 2.0, 4.5)]
    poles = [loop_margins(-oscillator, delay=d).closed_loop_poles[0].real for d in (1e-3, 2.0, 4.5)]
    assert stable == [pole < 0 for pole in poles]
    assert True in stable
    assert False in stable


@pytest.mark.parametrize(("omega", "delay"), [(62830.0, 10.0), (6283.0, 1.0)])
def test_a_fast_mode_behind_a_long_delay_is_no_trouble(omega, delay):
    """Its phase crosses −180° a hundred thousand times; the mode's peak is the margin."""
    loop = 0.01 / (S * (S**2 / omega**2 + 1e-5 * S / omega + 1))
    margins = loop_margins(loop, delay=delay)
    arrays = many_loop_margins(loop.num_array[0, 0], loop.den_array[0, 0], delay=delay)
    assert margins.stable
    for name in ("phase_margin_deg", "upper_gain_margin_db", "modulus_margin"):
        assert getattr(margins, name) == pytest.approx(float(getattr(arrays, name)), rel=1e-9)


def test_more_zeros_than_poles_behind_a_delay_are_refused():
    with pytest.raises(ValueError, match="no closed loop is stable; model the roll-off"):
        loop_margins(control.tf([1, 0], [1]), delay=1.0)


def test_a_loop_just_at_the_verge_counts_as_unstable():
    assert not loop_margins(1 / S, delay=math.pi / 2).stable
    assert not loop_margins(control.tf([1], [1, 0, 0]), delay=0.0).stable
    assert not loop_margins(control.tf([1], [1, 0, 0]), delay=0.1).stable


def test_a_mode_that_is_cancelled_and_unstable_counts():
    loop = control.tf([1.0, -1.0], [1.0, 2.0, -3.0])  # (s − 1)/((s − 1)(s + 3))
    margins = loop_margins(loop, delay=0.1)
    assert not margins.stable
    assert margins.closed_loop_poles[0] == pytest.approx(1.0)
