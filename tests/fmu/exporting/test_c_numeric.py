"""The C functions that replace the mathematics of a C library."""

import ctypes
import math

import numpy as np
import pytest
from fmus import driven, needs_compiler

from jounce.plant import Inertia

pytestmark = needs_compiler

DRIVER = """
#include "block.h"
#include "numeric.h"
double root(double x) { return square_root(x); }
double power(double x) { return exponential(x); }
double nearest(double x, double p) { return nearest_remainder(x, p); }
double truncated(double x, double p) { return truncated_remainder(x, p); }
"""


def functions(*options):
    library = driven(Inertia(1.0), DRIVER, *options)
    for name, count in (("root", 1), ("power", 1), ("nearest", 2), ("truncated", 2)):
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * count
    return library


@pytest.fixture(scope="module")
def library():
    return functions()


def numbers(count):
    """Return positive numbers over the whole range of a double, and the odd ones."""
    rng = np.random.default_rng(5)
    drawn = np.ldexp(rng.uniform(0.5, 1.0, count), rng.integers(-1070, 1024, count))
    exact = np.arange(1.0, 200.0) ** 2
    return [0.0, 5e-324, 2.2e-308, 1.7976931348623157e308, *exact.tolist(), *drawn.tolist()]


@pytest.mark.parametrize("options", [(), ("-DBY_DIGITS",)], ids=["instruction", "by digits"])
def test_square_root_is_correctly_rounded(options):
    root = functions(*options).root
    for x in numbers(5000):
        assert root(x) == math.sqrt(x), f"x = {x!r}"
    assert root(math.inf) == math.inf
    assert math.isnan(root(-1.0))
    assert math.isnan(root(math.nan))


def test_exponential_is_within_two_units_of_the_last_place(library):
    for x in np.random.default_rng(1).uniform(-745.0, 709.7, 5000).tolist():
        expected = math.exp(x)
        assert abs(library.power(x) - expected) <= 2.0 * math.ulp(expected), f"x = {x!r}"
    assert (library.power(0.0), library.power(-1e4), library.power(1e4)) == (1.0, 0.0, math.inf)
    assert math.isnan(library.power(math.nan))


def test_remainders_are_exact(library):
    rng = np.random.default_rng(2)
    sizes = np.ldexp(rng.normal(size=2000), rng.integers(-60, 60, 2000)).tolist()
    periods = np.ldexp(rng.uniform(0.5, 1.0, 2000), rng.integers(-20, 20, 2000)).tolist()
    ties = [(k * 0.5, 1.0) for k in range(-9, 10)] + [(1e300, 360.0), (0.0, 3.0), (-180.0, 360.0)]
    for x, p in [*zip(sizes, periods, strict=True), *ties]:
        assert library.nearest(x, p) == math.remainder(x, p), f"x = {x!r}, p = {p!r}"
        assert library.truncated(x, p) == math.fmod(x, p), f"x = {x!r}, p = {p!r}"
