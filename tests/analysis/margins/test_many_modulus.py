"""Distances of sectors from −1, against sampled sectors; least distances against dense grids."""

import numpy as np
import pytest

from jounce.analysis.margins.many_crossings import pieces_of
from jounce.analysis.margins.many_gain_and_phase import gain_margins
from jounce.analysis.margins.many_loops import loops_of
from jounce.analysis.margins.many_modulus import _nearest, _Sectors, distance, modulus


@pytest.fixture(autouse=True)
def _quiet():
    with np.errstate(all="ignore"):
        yield


def test_distance_from_minus_one_keeps_its_digits_beside_it():
    gain, turns = np.array([0.0, 1e-9, 0.3, -50.0]), np.array([1e-9, -3.0, 2.4, 0.1])
    value = np.exp(gain + 2j * np.pi * (turns - 0.5))
    np.testing.assert_allclose(distance(gain, turns)[2:], abs(1 + value)[2:], rtol=1e-14)
    np.testing.assert_allclose(distance(gain, turns)[:2], [2e-9 * np.pi, 1e-9], rtol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_no_point_of_a_sector_is_nearer_than_its_bound(seed):
    rng = np.random.default_rng(seed)
    gains, turns = rng.normal(0, 1, (2, 200)), rng.normal(0, 0.4, (2, 200))
    sectors = _Sectors(np.arange(200), tuple(gains), tuple(gains), tuple(turns))
    bound = _nearest(sectors)
    share = np.linspace(0, 1, 101)
    inside = [low + np.multiply.outer(share, high - low) for low, high in (gains, turns)]
    sampled = distance(inside[0][:, None], inside[1][None]).min(axis=(0, 1))
    assert np.all(bound <= sampled * (1 + 1e-12))
    assert np.all(sampled - bound < 0.1 * np.exp(gains.max(axis=0)))


@pytest.mark.parametrize("delay", [0.0, 0.05, 2.0, 60.0])
def test_the_least_distance_is_that_of_a_dense_grid(delay):
    rng = np.random.default_rng(7)
    sizes, zeta = 10 ** rng.uniform(-1, 1, (2, 20)), 10 ** rng.uniform(-2, 0, 20)
    den = [np.polymul([1, 2 * z * a, a * a], [1, b]) for a, b, z in zip(*sizes, zeta, strict=True)]
    den = np.array(den)
    num = 10 ** rng.uniform(-2, 0.5, (20, 1)) * den[:, -1:]
    loops = loops_of(num, den, np.full(20, delay))
    pieces = pieces_of(loops)
    least, place = modulus(pieces, gain_margins(pieces)[1])
    grid = np.geomspace(1e-3, 1e3, 100_001)
    for i in range(20):
        one = loops.take([i])
        values = distance(*one.gain_and_turns(grid[None] / one.scale[:, None]))
        assert least[i] <= values.min() * (1 + 1e-12)
        assert least[i] == pytest.approx(min(values.min(), 1.0), abs=5e-3)
        if 0 < place[i] < np.inf:
            there = distance(*one.gain_and_turns(np.array([[place[i]]])))
            assert there[0, 0] == pytest.approx(least[i], rel=1e-12)
