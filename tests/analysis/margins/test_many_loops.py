"""Values and slopes of many loops, against polynomials evaluated one by one and differences."""

import numpy as np
import pytest

from jounce.analysis.margins.many_loops import loops_of

OMEGA = np.geomspace(1e-4, 1e4, 60)


@pytest.fixture(autouse=True)
def _quiet():
    with np.errstate(all="ignore"):
        yield


def random_rows(seed, count=6):
    """Return numerators of degree 2 and denominators of degree 4 with an integrator, and delays."""
    rng = np.random.default_rng(seed)
    num, den = rng.normal(size=(count, 3)), rng.normal(size=(count, 5))
    den[:, -1] = 0.0
    return num, den, rng.uniform(0, 2, count)


def evaluated(num, den, delay):
    s = 1j * OMEGA
    rows = zip(num, den, delay, strict=True)
    return np.array([np.polyval(n, s) / np.polyval(d, s) * np.exp(-s * t) for n, d, t in rows])


def scaled(loops):
    """Return OMEGA in the unit of each loop."""
    return OMEGA / loops.scale[:, None]


@pytest.mark.parametrize("seed", range(5))
def test_values_are_those_of_the_polynomials(seed):
    rows = random_rows(seed)
    loops = loops_of(*rows)
    gain, turns = loops.gain_and_turns(scaled(loops))
    value = np.exp(gain + 2j * np.pi * (turns - 0.5))
    np.testing.assert_allclose(value, evaluated(*rows), rtol=1e-9)
    np.testing.assert_array_equal(gain, loops.gain(scaled(loops)))


@pytest.mark.parametrize("seed", range(5))
def test_slopes_are_those_of_differences(seed):
    loops = loops_of(*random_rows(seed))
    step = 1e-6
    slopes = loops.slopes(scaled(loops))
    before, after = (loops.slopes(scaled(loops) * np.exp(side * step)) for side in (-1, 1))
    first = (after.gain - before.gain) + 2j * np.pi * (after.turns - before.turns)
    size = 1.0 + abs(slopes.first)
    np.testing.assert_allclose(slopes.first / size, first / (2 * step) / size, atol=1e-6)
    second = (after.first - before.first) / (2 * step)
    size = 1.0 + abs(slopes.second)
    np.testing.assert_allclose(slopes.second / size, second / size, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_turns_are_continuous_from_limit_to_limit(seed):
    num, den, _ = random_rows(seed)
    loops = loops_of(num, den, np.zeros(len(num)))
    omega = np.geomspace(1e-7, 1e7, 40_001) / loops.scale[:, None]
    turns = loops.gain_and_turns(omega)[1]
    assert abs(np.diff(turns, axis=1)).max() < 0.2
    low, high = loops.turns_at_limits
    np.testing.assert_allclose(turns[:, 0], low, atol=1e-4)
    np.testing.assert_allclose(turns[:, -1], high, atol=1e-4)
    assert np.all(np.concatenate([low, high]) * 4 % 1 == 0)


def test_limits_and_asymptotes():
    """Of 6/(s(s + 2)), 3(s + 1)/(s + 2), s + 4 and 5 with a delay."""
    num = np.array([[0, 0, 6], [0, 3, 3], [0, 1, 4], [0, 0, 5]], dtype=float)
    den = np.array([[1, 2, 0], [0, 1, 2], [0, 0, 1], [0, 0, 1]], dtype=float)
    loops = loops_of(num, den, np.array([0.0, 0.0, 0.0, 0.3]))
    (low, high), ends = loops.limits, loops.ends
    np.testing.assert_allclose(np.exp(low), [np.inf, 1.5, 4.0, 5.0])
    np.testing.assert_allclose(np.exp(high), [0.0, 3.0, np.inf, 5.0])
    assert loops.rise.tolist() == [-2, 0, 1, 0]
    crossings = np.array([1.61, 1.0, 1.0, 1.0]) / loops.scale
    assert np.all((ends[0] < 1e-6 * crossings) & (crossings < 1e-6 * ends[1]))


def test_far_from_every_corner_nothing_overflows():
    loops = loops_of(np.array([[1.0, 2.0, 3.0]]), np.array([[1.0, 1.0, 1.0, 1.0]]), np.zeros(1))
    gain, turns = loops.gain_and_turns(np.array([[1e-180, 1e180]]))
    expected = np.log([3.0, 1e-180 / loops.scale[0]])
    np.testing.assert_allclose(gain[0], expected, rtol=1e-12)
    np.testing.assert_allclose(turns[0], [0.5, 0.25], rtol=1e-12)


def test_what_zeros_hide_is_marked():
    num = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 2], [1, 0, 4]], dtype=float)
    den = np.array([[1, 1, 0], [1, 0, 1], [1, 3, 2], [1, 0, 1]], dtype=float)
    assert loops_of(num, den, np.zeros(4)).hidden.tolist() == [True, True, False, False]
