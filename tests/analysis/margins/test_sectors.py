"""Peaks and bandwidth of loops with delay, against a dense search."""

import control
import numpy as np
import pytest

from jounce.analysis.margins import sectors
from jounce.analysis.margins.factored_loop import HIGHEST
from jounce.analysis.margins.factoring import factored

S = control.tf("s")
LOOPS = {
    "lag": (1 / (S * (S + 1)), 0.3),
    "integrator, long delay": (0.01 / S, 100.0),
    "PID on an inertia": (5.4 * (S**2 + 5.17 * S + 7.01) / S**3, 0.02),
    "resonance": (20 / (S * (S**2 + 0.02 * S + 100)), 0.05),
    "sharp resonance": (S * 1e-3 / (S**2 + 1e-4 * S + 1) + 0.1 / S, 3.0),
    "antiresonance": (0.8 * (S**2 + 1e-3 * S + 4) / (S * (S + 1) * (S + 9)), 0.4),
}
VALUES = {
    "S": (sectors.sensitivity, lambda loop: 1 / (1 + loop)),
    "T": (sectors.complementary, lambda loop: loop / (1 + loop)),
    "disk": (sectors.disk, lambda loop: (1 - loop) / (1 + loop)),
}


def dense(loop):
    """Frequencies, crowded where the roots of L are."""
    roots = abs(np.concatenate([loop.zeros, loop.poles]))
    crowded = [r * (1 + np.linspace(-1e-2, 1e-2, 40_001)) for r in roots[roots > 0]]
    return np.unique(np.concatenate([np.geomspace(1e-4, 1e4, 300_001), *crowded]))


@pytest.mark.parametrize("quantity", VALUES)
@pytest.mark.parametrize("name", LOOPS)
def test_a_peak_is_the_largest_of_a_dense_search(name, quantity):
    loop = factored(*LOOPS[name])
    bound, value = VALUES[quantity]
    peak, omega = sectors.peak(loop, bound)
    searched = float(abs(value(loop.values(dense(loop)))).max())
    assert peak >= searched * (1 - 1e-10), f"{name}: {quantity} {peak} < {searched}"
    assert peak <= searched * (1 + 1e-5), f"{name}: {quantity} {peak} > {searched}"
    if omega < HIGHEST:
        attained = float(abs(value(loop.values(np.array([omega]))))[0])
        assert attained == pytest.approx(peak, rel=1e-12)


@pytest.mark.parametrize("quantity", VALUES)
def test_a_bound_over_a_sector_is_above_every_value_in_it(quantity):
    bound, value = VALUES[quantity]
    rng = np.random.default_rng(1)
    for _ in range(300):
        low, high = np.sort(rng.normal(0, 1.5, 2))
        start, end = np.sort(rng.uniform(-4, 4, 2))
        angles = np.linspace(start, end, 41)
        loop = np.exp(np.linspace(low, high, 41))[:, None] * np.exp(1j * angles)
        square = 0.0 if start <= np.pi <= end or start <= -np.pi <= end else None
        square = np.min(np.cos(angles / 2) ** 2) if square is None else square
        largest = abs(value(loop)).max()
        found = float(bound(np.array([low]), np.array([high]), np.array([square]))[0])
        assert found >= largest * (1 - 1e-12), (low, high, start, end)


@pytest.mark.parametrize("name", LOOPS)
def test_the_bandwidth_is_the_first_fall_of_a_dense_search(name):
    loop = factored(*LOOPS[name])
    omega = dense(loop)
    size = abs(VALUES["T"][1](loop.values(omega)))
    for level in (0.7, 0.3):
        first = np.flatnonzero(size < level)[0]
        found = sectors.first_below(loop, level)
        assert omega[first - 1] <= found <= omega[first], f"{name}: {level}"


def test_what_never_falls_has_no_bandwidth():
    assert sectors.first_below(factored(0.5 * (S + 2) / (S + 3), 0.7), 0.05) == np.inf
