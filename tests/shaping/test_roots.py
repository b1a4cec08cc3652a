"""Roots that are known."""

import math

import pytest

from jounce.shaping.roots import root_between

FUNCTIONS = {
    "cosine": (lambda x: math.cos(x) - x, 0.0, 1.0, 0.7390851332151607),
    "steep": (lambda x: math.expm1(30.0 * (x - 0.3)), -1.0, 2.0, 0.3),
    "cubic": (lambda x: (x - 0.7) ** 3, -1.0, 5.0, 0.7),
    "step": (lambda x: math.atan(1e9 * (x - 1e-3)), -1.0, 1.0, 1e-3),
    "falling": (lambda x: 2.0 - x**5, 0.0, 9.0, 2.0**0.2),
    "at an end": (lambda x: x, 0.0, 1.0, 0.0),
    "at the other": (lambda x: x - 1.0, 0.0, 1.0, 1.0),
}


@pytest.mark.parametrize("kind", FUNCTIONS)
def test_it_is_the_root(kind):
    function, low, high, expected = FUNCTIONS[kind]
    calls = []

    def counted(x):
        calls.append(x)
        return function(x)

    found = root_between(counted, low, high)
    assert found == pytest.approx(expected, rel=1e-15, abs=1e-18)
    assert len(calls) < 120
