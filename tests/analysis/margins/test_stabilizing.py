"""Loops with zeros and poles on the axis, and what stabilises loops, in exact arithmetic."""

import json
import math
import os

import control
import numpy as np
import pytest

from jounce.analysis.margins import loop_margins, many_loop_margins
from jounce.plant import FlexibleInertia, ServoLoop, design_pid

from .exact import closed_poles, crossovers, times, unstable_behind

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
DT = 0.01


def rounded(value):
    """Return a number whose products are exact."""
    return float(np.round(64 * value) / 64) or 0.125


def random_loop(seed):
    """Return N and D with undamped modes and notches, integrators, lags, leads; no more zeros."""
    rng = np.random.default_rng(seed)
    num, den = [1.0], [1.0]
    for _ in range(rng.integers(1, 4)):
        damping = rng.choice([0.0, 0.0, rounded(rng.uniform(0, 1))])
        den = times(den, [1.0, damping, rounded(10 ** rng.uniform(-0.5, 1.6))])
    for _ in range(rng.integers(0, 3)):
        damping = rng.choice([0.0, 0.0, rounded(rng.uniform(0, 1))])
        num = times(num, [1.0, damping, rounded(10 ** rng.uniform(-0.5, 1.6))])
    for _ in range(rng.integers(0, 3)):
        den = times(den, [1.0, rng.choice([0.0, rounded(rng.uniform(0.1, 5))])])
    while len(num) < len(den) - rng.integers(0, 2):
        num = times(num, [1.0, rounded(rng.uniform(0.1, 5))])
    if len(num) >= len(den):
        num = num[len(num) - len(den) + 1 :]
    gain = rounded(10 ** rng.uniform(-1.5, 1.5)) * rng.choice([1.0, 1.0, 1.0, -1.0])
    return [float(x) * gain for x in num], [float(x) for x in den]


def is_stable(num, den, factor=1.0):
    return max(pole.real for pole in closed_poles(num, den, factor)) < 0


def stable_loops(count, start=0):
    """Return loops that are stable, one in three whatever it is."""
    found, seed = [], start
    while len(found) < count:
        num, den = random_loop(seed)
        if seed % 60 == 0 or np.roots(np.polyadd(den, num)).real.max() < -1e-6:
            found.append((seed, num, den))
        seed += 1
    return found


LOOPS = stable_loops(30 if SLOW else 6)
loops = pytest.mark.parametrize(
    ("seed", "num", "den"), LOOPS, ids=[f"seed{seed}" for seed, _, _ in LOOPS]
)


def probes(intervals, top):
    """Return places just inside and outside every end, in the middle, in every gap, and whether."""
    found = []
    for low, high in intervals:
        high = min(high, max(top, 2 * low))
        found += [(low + share * (high - low), True) for share in (1e-5, 0.5, 1 - 1e-5)]
    ends = [0.0, *(end for pair in intervals for end in pair), top]
    for low, high in zip(ends[::2], ends[1::2], strict=True):
        if low < high < math.inf:
            found += [(low + share * (high - low), False) for share in (1e-5, 0.5, 1 - 1e-5)]
    return [(place, inside) for place, inside in found if place > 0]


@loops
def test_crossovers_are_the_roots_of_an_exact_polynomial(seed, num, den):
    margins = loop_margins(control.tf(num, den))
    found = [2 * math.pi * hz for hz in margins.crossovers_hz if 0 < hz < math.inf]
    assert found == pytest.approx(crossovers(num, den), rel=1e-9), seed
    assert margins.stable == is_stable(num, den), seed
    behind = loop_margins(control.tf(num, den), delay=0.25)
    assert behind.crossovers_hz == pytest.approx(margins.crossovers_hz, rel=1e-9), seed
    assert behind.stable == (unstable_behind(num, den, 0.25) == 0), seed


@loops
def test_a_result_does_not_contradict_itself(seed, num, den):
    for delay in (0.0, 0.25, 3.0):
        margins = loop_margins(control.tf(num, den), delay=delay)
        assert margins.stable == (margins.closed_loop_poles.real.max() < 0), seed
        assert margins.stable == any(a < 1 < b for a, b in margins.stabilizing_gains), seed
        at_once = [low for low, _ in margins.stabilizing_delays_s][:1] == [0.0]
        assert margins.stable == at_once, seed
        if margins.stable:
            [(low, high)] = [pair for pair in margins.stabilizing_gains if pair[0] < 1 < pair[1]]
            lower = -20 * math.log10(low) if low else math.inf
            upper = 20 * math.log10(high) if high < math.inf else math.inf
            assert margins.lower_gain_margin_db == pytest.approx(lower, rel=1e-9), seed
            assert margins.upper_gain_margin_db == pytest.approx(upper, rel=1e-9), seed
            first = margins.stabilizing_delays_s[0][1]
            assert margins.delay_margin_s == pytest.approx(first, rel=1e-9), seed


@loops
def test_gains_stabilise_within_their_intervals_and_nowhere_else(seed, num, den):
    found = loop_margins(control.tf(num, den)).stabilizing_gains
    for factor, inside in probes(found, 1e3):
        assert is_stable(num, den, factor) == inside, (seed, factor, found)
    behind = loop_margins(control.tf(num, den), delay=0.125).stabilizing_gains
    for factor, inside in probes(behind, 20.0):
        scaled = [factor * x for x in num]
        assert (unstable_behind(scaled, den, 0.125) == 0) == inside, (seed, factor, behind)


@loops
def test_delays_stabilise_within_their_intervals_and_nowhere_else(seed, num, den):
    for delay in (0.0, 0.5):
        found = loop_margins(control.tf(num, den), delay=delay).stabilizing_delays_s
        shown = found[:3]
        top = found[3][0] if len(found) > 3 else 8.0
        for added, inside in probes(shown, max([top, *(b for _, b in shown if b < math.inf)])):
            counted = unstable_behind(num, den, delay + added)
            assert (counted == 0) == inside, (seed, delay, added, found[:4])


@pytest.mark.parametrize("seed", range(40 if SLOW else 12))
def test_discrete_loops_are_stabilised_by_gains_and_whole_samples(seed):
    rng = np.random.default_rng(seed)
    num, den = [rounded(rng.uniform(-1, 1))], [1.0, -rng.choice([1.0, 0.5, -0.25])]
    for row in (num, den) if seed % 2 else (den,):
        row[:] = [float(x) for x in times(row, [1.0, rounded(rng.uniform(-1.9, 1.9)), 1.0])]
    margins = loop_margins(control.tf(num, den, DT))
    assert margins.stable == (max(map(abs, closed_poles(num, den))) < 1)
    assert margins.stable == any(a < 1 < b for a, b in margins.stabilizing_gains)
    assert margins.stable == any(a == 0 for a, _ in margins.stabilizing_delays_s)
    for factor, inside in probes(margins.stabilizing_gains, 1e3):
        assert (max(map(abs, closed_poles(num, den, factor))) < 1) == inside, factor
    for samples in range(8):
        inside = any(a <= samples * DT <= b for a, b in margins.stabilizing_delays_s)
        assert (max(map(abs, closed_poles(num, den, 1, samples))) < 1) == inside, samples


@pytest.mark.parametrize("damping", [0.0, 1e-16, 1e-14, 1e-13, 1e-12, 1e-10, 1e-8])
def test_an_undamped_mode_hides_no_crossing(damping):
    """(s/2 + 1)/(s² + 2)."""
    loop = control.tf([0.5, 1], [1, 2 * math.sqrt(2) * damping, 2])
    margins = loop_margins(loop)
    found = [2 * math.pi * hz for hz in margins.crossovers_hz]
    assert found == pytest.approx([0.94545903, 1.83196813], rel=1e-7)
    assert margins.phase_margin_deg == pytest.approx(42.489, abs=1e-3)
    assert margins.delay_margin_s == pytest.approx(0.40480, abs=1e-5)
    behind = loop_margins(loop, delay=1.0)
    assert not behind.stable
    assert abs(behind.closed_loop_poles[0].imag) == pytest.approx(1.62617039, rel=1e-7)
    assert behind.closed_loop_poles[0].real == pytest.approx(0.27565694, rel=1e-7)


def test_an_undamped_load_has_the_delay_margin_of_its_last_crossover():
    plant = FlexibleInertia(1.0, frequency_hz=7.0, damping=0.0, load_fraction=0.6)
    pid = design_pid(1.0, crossover_hz=2, phase_margin_deg=60, lower_gain_margin_db=12)
    margins = loop_margins(ServoLoop(plant, pid).loop_transfer())
    assert margins.delay_margin_s == pytest.approx(0.02540, abs=1e-5)


def test_undamped_notches_hide_neither_phase_margin_nor_bandwidth():
    margins = loop_margins(control.tf([10, 0, 30], [1, 5, 7, 3]))
    assert margins.phase_margin_deg == pytest.approx(45.22, abs=5e-3)
    margins = loop_margins(control.tf([5, 0, 12], [1, 5, 8, 20, 16]))
    assert margins.bandwidth_hz == pytest.approx(0.16805, abs=1e-5)


def test_double_roots_on_the_axis_stay_there():
    """0.01·(s + 1)³/(s² + 1)², stable from 50 times the gain on, as Routh's scheme says."""
    num = [0.01 * x for x in (1.0, 3.0, 3.0, 1.0)]
    margins = loop_margins(control.tf(num, [1.0, 0.0, 2.0, 0.0, 1.0]))
    [(low, high)] = margins.stabilizing_gains
    assert (low, high) == (pytest.approx(50.0, rel=1e-9), math.inf)
    assert is_stable(num, [1.0, 0.0, 2.0, 0.0, 1.0], 50.001)
    assert not is_stable(num, [1.0, 0.0, 2.0, 0.0, 1.0], 49.999)


def test_a_pole_that_a_zero_cancels_on_the_axis_is_never_stabilised():
    loop = control.tf([1.0, 0.0, 4.0], np.polymul([1.0, 0.0, 4.0], [1.0, 1.0]))
    for delay in (0.0, 0.3):
        margins = loop_margins(loop, delay=delay)
        assert not margins.stable
        assert margins.stabilizing_gains == margins.stabilizing_delays_s == ()


def test_the_frequency_of_a_flat_peak_keeps_its_digits():
    num, den = [3.4244026447575187, 3.62543302211631, 0.20808244347026617], 0.6707317720154541
    delay = 0.00770238993884085
    margins = loop_margins(control.tf(num, [den, 0, 0, 0]), delay=delay)
    assert margins.modulus_margin_hz == pytest.approx(10.6715064412, rel=1e-11)
    arrays = many_loop_margins(num, [den, 0, 0, 0], delay=delay)
    assert margins.modulus_margin_hz == pytest.approx(float(arrays.modulus_margin_hz), rel=1e-10)


def test_no_delay_at_all_is_an_interval_without_length():
    assert loop_margins(control.tf([2, 1], [1, 1])).stabilizing_delays_s == ((0, 0),)
    assert loop_margins(control.tf([2, 1], [1, 1]), delay=1.0).stabilizing_delays_s == ()


@pytest.mark.parametrize("slow", [1e-4, 1e-7, 1e-9])
def test_passages_are_counted_however_far_apart_crossovers_lie(slow):
    # Behind τ the mode's pole moves by slow·e^(−14jτ)/2: cos 14τ < 0 stabilises it.
    found = loop_margins(control.tf([196 * slow], [1, 0, 196, 0])).stabilizing_delays_s
    assert 4000 < len(found) <= 5000
    for k in (0, 1, 2, 100):
        expected = (np.array([0.25, 0.75]) + k) * np.pi / 7
        assert found[k] == pytest.approx(expected, rel=5 * slow + 1e-9)


@pytest.mark.parametrize("damping", [0.0, 2e-11])
def test_what_counts_as_undamped_is_not_called_stable_behind_the_least_delay(damping):
    # A notch beside the mode hides it from the loop to 13 digits: no delay can move it.
    mode, notch = [1.0, damping, 1.0], [1.0, damping, 1.0 + 2.0**-42]
    margins = loop_margins(control.tf(notch, np.polymul(mode, [1.0, 2.0])))
    assert not margins.stable
    assert all(low > 0 for low, _ in margins.stabilizing_delays_s)
    assert not any(low < 1 < high for low, high in margins.stabilizing_gains)


def test_the_least_delay_that_there_is_costs_nothing():
    plain = loop_margins(control.tf([2], [1, 1, 0]))
    for delay in (5e-324, 1e-310, 1e-300):
        margins = loop_margins(control.tf([2], [1, 1, 0]), delay=delay)
        assert margins.stable
        assert margins.phase_margin_deg == pytest.approx(plain.phase_margin_deg, rel=1e-12)
        assert margins.delay_margin_s == pytest.approx(plain.delay_margin_s, rel=1e-12)


def test_intervals_are_told_and_become_plain_data():
    """s³ + k·(s² + 28s + 38) is stable from k = 38/28 on."""
    margins = loop_margins(control.tf([1, 28, 38], [1, 0, 0, 0]))
    assert margins.stabilizing_gains == ((pytest.approx(38 / 28), math.inf),)
    assert "stable at gain times above 1.357\nstable with added delay (s): none" in str(margins)
    assert json.loads(json.dumps(margins.as_dict()))["stabilizing_gains"][0][1] is None


def test_added_delays_of_a_sampled_loop_are_told_as_whole_samples():
    """k/(z − 1)·z^(−n) is stable for k < 2·sin(π/(4n + 2)): for k = 0.7 up to n = 1, 1.2 n = 0."""
    for gain, told in ((0.7, "0 to 0.5"), (1.2, "0 only")):
        margins = loop_margins(control.tf([gain], [1.0, -1.0], 0.5))
        assert f"stable with added delay (s, whole samples): {told}" in str(margins)
