"""Samples are counted: none is lost, none runs twice, however the host counts its time."""

import ctypes

import control
import pytest
from fmus import driven, needs_compiler
from tiers import some

pytestmark = needs_compiler

DRIVER = """
#include "model.c"
/* Counts samples of 1 ms: steps of h, times added up or multiplied, offset by a start time. */
double count(long n, double h, int added, double start) {
    fmi2CallbackFunctions none = {0};
    fmi2ValueReference input = V_INPUT + 1, output = V_STATE + 1;
    fmi2Real one = 1.0, result, t = start;
    fmi2Component c = fmi2Instantiate("a", fmi2CoSimulation, TOKEN, "", &none, 0, 0);
    long k;
    if (fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0) || fmi2EnterInitializationMode(c) ||
        fmi2ExitInitializationMode(c) || fmi2SetReal(c, &input, 1, &one)) {
        return -1.0;
    }
    for (k = 0; k < n; k++) {
        if (fmi2DoStep(c, t, h, 0)) {
            return -2.0;
        }
        t = added ? t + h : start + (k + 1) * h;
    }
    if (fmi2GetReal(c, &output, 1, &result)) {
        return -3.0;
    }
    fmi2FreeInstance(c);
    return result;
}
"""


@pytest.fixture(scope="module")
def count():
    counter = control.ss([[1.0]], [[1.0]], [[1.0]], [[0.0]], 1e-3)
    function = driven(counter, DRIVER).count
    function.restype = ctypes.c_double
    function.argtypes = [ctypes.c_long, ctypes.c_double, ctypes.c_int, ctypes.c_double]
    return function


@pytest.mark.parametrize("added", [True, False], ids=["t += h", "t = k h"])
@pytest.mark.parametrize("start", some([0.0, 0.123, 1e5], 2))
def test_a_million_ticks_of_a_millisecond(count, added, start):
    assert count(1_000_000, 1e-3, added, start) == 1e6


@pytest.mark.parametrize("added", [True, False], ids=["t += h", "t = k h"])
@pytest.mark.parametrize(
    ("steps", "length", "ticks"),
    [
        (700_000, 1e-3 / 7.0, 100_000),
        (70_001, 1e-3 / 7.0, 10_001),
        (100_000, 5e-3, 500_000),
        (1_000, 0.7e-3, 700),
        (10_000, 1.3e-3, 13_000),
        (1, 1.0, 1_000),
        (100_000, 1e-3 / 1000.0, 100),
    ],
)
def test_steps_of_any_length(count, steps, length, ticks, added):
    assert count(steps, length, added, 0.0) == ticks


def test_a_step_of_too_many_samples_is_refused(count):
    assert count(1, 2e6, True, 0.0) == -2.0
