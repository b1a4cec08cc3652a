"""Peaks and bandwidth of loops, with and without delay, against a dense search."""

import math
import os

import control
import numpy as np
import pytest

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_modulus import DISTANCE, QUOTIENT

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
S = control.tf("s")
LOOPS = {
    "lag": (1 / (S * (S + 1)), 0.3),
    "integrator, long delay": (0.01 / S, 100.0),
    "PID on an inertia": (5.4 * (S**2 + 5.17 * S + 7.01) / S**3, 0.02),
    "resonance": (1 / (S * (S**2 + 0.02 * S + 100)), 0.05),
    "sharp resonance": (S * 5e-5 / (S**2 + 1e-4 * S + 1) + 0.1 / S, 3.0),
    "antiresonance": (0.8 * (S**2 + 1e-3 * S + 4) / (S * (S + 1) * (S + 9)), 0.4),
}
VALUES = {
    "S": ("sensitivity_peak", lambda loop: 1 / (1 + loop)),
    "T": ("complementary_peak", lambda loop: loop / (1 + loop)),
    "disk": ("disk_margin", lambda loop: (1 - loop) / (1 + loop)),
}


def values(name, hz):
    """Return L at frequencies in Hz."""
    loop, delay = LOOPS[name]
    s = 2j * np.pi * np.asarray(hz)
    return loop(s) * np.exp(-s * delay)


def dense(name):
    """Frequencies in Hz, crowded where the roots of L are."""
    loop, _ = LOOPS[name]
    roots = abs(np.concatenate([loop.zeros(), loop.poles()])) / (2 * np.pi)
    crowded = [r * (1 + np.linspace(-1e-2, 1e-2, 40_001)) for r in roots[roots > 0]]
    return np.unique(np.concatenate([np.geomspace(1e-7, 1e3, 300_001), *crowded]))


@pytest.mark.parametrize("quantity", VALUES)
@pytest.mark.parametrize("name", LOOPS)
def test_a_peak_is_the_largest_of_a_dense_search(name, quantity):
    margins = loop_margins(LOOPS[name][0], delay=LOOPS[name][1])
    field, value = VALUES[quantity]
    peak, hz = getattr(margins, field), getattr(margins, f"{field}_hz")
    peak = 2 / peak if quantity == "disk" else peak
    searched = float(abs(value(values(name, dense(name)))).max())
    assert peak >= searched * (1 - 1e-10), f"{name}: {quantity} {peak} < {searched}"
    assert peak <= searched * (1 + 1e-5), f"{name}: {quantity} {peak} > {searched}"
    if 0 < hz < math.inf:
        assert abs(value(values(name, hz))) == pytest.approx(peak, rel=1e-9)


@pytest.mark.parametrize("measure", [DISTANCE, QUOTIENT], ids=["distance", "quotient"])
def test_a_bound_over_a_sector_is_below_every_value_in_it(measure):
    rng = np.random.default_rng(1)
    for _ in range(300 if SLOW else 25):
        low, high = np.sort(rng.normal(0, 1.5, 2))
        start, end = np.sort(rng.uniform(-0.7, 0.7, 2))
        turns = np.linspace(start, end, 41)
        gains = np.linspace(low, high, 41)[:, None]
        loop = -np.exp(gains + 2j * np.pi * turns)
        value = abs(1 + loop) if measure is DISTANCE else abs((1 + loop) / (1 - loop))
        assert measure.value(gains, turns) == pytest.approx(value, rel=1e-9, abs=1e-12)
        off = 0.0 if start <= 0 <= end else min(abs(turns - np.rint(turns)))
        with np.errstate(divide="ignore"):
            found = measure.nearest(*np.array([[low], [high], [off]]))
        assert found <= value.min() * (1 + 1e-12) + 1e-15, (low, high, start, end)


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("delayed", [True, False])
def test_the_bandwidth_is_the_first_fall_of_a_dense_search(name, delayed):
    loop, delay = LOOPS[name]
    margins = loop_margins(loop, delay=delay if delayed else 0.0)
    hz = dense(name)
    s = 2j * np.pi * hz
    size = loop(s) * np.exp(-s * delay * delayed)
    size = abs(size / (1 + size))  # 1 at ω = 0, where every one of these loops has a pole
    first = np.flatnonzero(size < 1 / math.sqrt(2))[0]
    assert margins.stable
    assert hz[first - 1] <= margins.bandwidth_hz <= hz[first], name


def test_what_never_falls_has_no_bandwidth():
    assert math.isnan(loop_margins(0.5 * (S + 2) / (S + 3), delay=0.7).bandwidth_hz)
