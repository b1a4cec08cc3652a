"""Turning points, checked against dense search and against roots known exactly."""

import itertools
import math

import control
import numpy as np
import pytest

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.factored_loop import FactoredLoop
from jounce.analysis.margins.turning_points import phase_points, stationary_points

NONE = np.empty(0, complex)


def loop_of(zeros, poles, gain=1.0, delay=0.0):
    roots = np.array(zeros, complex), np.array(poles, complex)
    return FactoredLoop(*roots, gain, NONE, NONE, delay=delay)


def random_roots(rng, count):
    sizes, damping = 10 ** rng.uniform(-2, 2, count), 10 ** rng.uniform(-3, 0, count)
    roots = sizes * (-damping + 1j * np.sqrt(1 - damping**2))
    return np.concatenate([roots, roots.conj()])


@pytest.mark.parametrize("quantity", ["gain", "phase", "phase behind a delay"])
@pytest.mark.parametrize("seed", range(30))
def test_between_stationary_points_a_quantity_is_monotone(seed, quantity):
    rng = np.random.default_rng(seed)
    loop = loop_of(
        random_roots(rng, rng.integers(0, 4)),
        random_roots(rng, rng.integers(1, 6)),
        delay=10 ** rng.uniform(-3, 2) if "delay" in quantity else 0.0,
    )
    of_gain = quantity == "gain"
    points = (
        stationary_points(loop.zeros, loop.poles)
        if of_gain
        else phase_points(loop.zeros, loop.poles, loop.delay)
    )
    function = loop.log_gain if of_gain else loop.phase
    edges = np.concatenate([[1e-5], points, [1e5]])
    for low, high in itertools.pairwise(edges):
        steps = np.diff(function(np.geomspace(low, high, 300)))
        assert steps.max() < 1e-12 or steps.min() > -1e-12


@pytest.mark.parametrize("zeta", [0.5, 0.01, 0.001])
def test_a_resonance_turns_where_theory_says(zeta):
    pole = -zeta + 1j * math.sqrt(1 - zeta**2)
    points = stationary_points(NONE, np.array([pole, pole.conjugate()]))
    assert points == pytest.approx([math.sqrt(1 - 2 * zeta**2)], rel=1e-13)


def test_a_turn_between_roots_far_apart_is_not_lost():
    """(s + 1)(s + 2)/(s²(s + 1e-16)): the phase falls to −270 degrees and rises again to −90."""
    margins = loop_margins(control.tf([1.0, 3.0, 2.0], [1.0, 1e-16, 0.0, 0.0]))
    assert 2 * math.pi * margins.phase_crossovers_hz[-1] == pytest.approx(math.sqrt(2), rel=1e-12)


@pytest.mark.parametrize("delay", [1e-3, 0.1, 1.0, 1.5])
def test_phase_crossovers_of_an_integrator_behind_a_delay_are_known(delay):
    found = np.array(loop_margins(control.tf([1.0], [1.0, 0.0]), delay=delay).phase_crossovers_hz)
    whole = found * delay - 0.25
    assert whole == pytest.approx(np.round(whole), abs=1e-9)
    assert whole[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("slow", "fast"), [(0.1, 1e2), (1e-3, 1e4), (1e-5, 1e5)])
def test_disk_margin_of_a_lag_and_lead_over_many_decades_agrees_with_dense_search(slow, fast):
    s = control.tf("s")
    loop = 10 * fast * (s + slow) / (s * (s + slow / 10) * (s + fast))
    value = loop(1j * np.geomspace(slow / 100, 100 * fast, 100_001))
    expected = 2 * abs((1 + value) / (1 - value)).min()
    assert loop_margins(loop).disk_margin == pytest.approx(expected, rel=1e-6)
