"""What margins of many loops take, in which shapes, and what they refuse."""

import math

import numpy as np
import pytest
from many_loops import GAINS, NAMES, assert_same, random_delayed_loop, together

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_margins import many_loop_margins, servo_margins
from jounce.plant import PID, Inertia, ServoLoop


def test_each_loop_has_the_margins_that_it_has_alone():
    loops = [random_delayed_loop(seed) for seed in range(30)]
    margins = together(loops)
    for i, (num, den, delay) in enumerate(loops):
        alone = many_loop_margins(num, den, delay=delay)
        assert alone.shape == ()
        assert margins.stable[i] == alone.stable
        assert_same(margins[i], alone, NAMES[:-1], 1e-11, f"seed {i}")


def test_more_loops_than_one_chunk_holds():
    delay = np.linspace(0, 0.2, 10_000)
    margins = servo_margins(1.0, GAINS, delay=delay)
    np.testing.assert_array_equal(margins.stable, delay < 0.125)
    good = margins[margins.stable]
    np.testing.assert_allclose(good.delay_margin_s, 0.125 - delay[delay < 0.125], atol=1e-12)


@pytest.mark.parametrize(
    ("numerator", "denominator", "delay", "shape"),
    [
        ([1.0], [1.0, 1.0, 0.0], 0.1, ()),
        (1.0, [1.0, 1.0, 0.0], 0.1, ()),
        ([[1.0]] * 3, [1.0, 1.0, 0.0], 0.1, (3,)),
        ([1.0], [[[1.0, 1.0, 0.0]] * 2] * 4, [0.1, 0.1], (4, 2)),
        ([[0.0, 0.0, 1.0]], [0.0, 1.0, 1.0, 0.0], [[0.1], [0.1]], (2, 1)),
        (np.ones((0, 1)), [1.0, 1.0, 0.0], 0.1, (0,)),
    ],
    ids=["one", "number", "numerators", "grid", "zeros-in-front", "none"],
)
def test_arguments_are_broadcast(numerator, denominator, delay, shape):
    margins = many_loop_margins(numerator, denominator, delay=delay)
    assert margins.shape == shape
    expected = many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=0.1)
    for name in NAMES:
        values = getattr(margins, name)
        assert values.shape == shape
        np.testing.assert_allclose(values, getattr(expected, name), rtol=1e-14)


def test_servo_margins_are_those_of_the_servo_loop():
    inertia, delay = np.array([[0.5], [2.0]]), np.array([0.0, 0.03])
    margins = servo_margins(inertia, GAINS, gain=1.3, delay=delay)
    assert margins.shape == (2, 2)
    for i, k in np.ndindex(margins.shape):
        loop = ServoLoop(Inertia(inertia[i, 0]), GAINS).loop_transfer() * 1.3
        assert_same(margins[i, k], loop_margins(loop, delay=delay[k]), NAMES[:-1])


@pytest.mark.parametrize(
    ("controller", "stable"),
    [(PID(2.0, 0.0, 3.0), True), (PID(2.0, 0.0, 0.0), False), (PID(0.0, 0.0, 0.0), False)],
    ids=["PD", "P", "nothing"],
)
def test_without_an_integral_there_is_no_integrator(controller, stable):
    margins = servo_margins(Inertia(2.0), controller)
    assert bool(margins.stable) == stable
    if stable:
        loop = ServoLoop(Inertia(2.0), controller).loop_transfer()
        assert_same(margins, loop_margins(loop))


def test_the_result_is_frozen_and_indexed_as_one():
    margins = servo_margins([[1.0], [50.0]], GAINS, delay=[0.0, 0.05, 1.0])
    assert repr(margins) == "ManyMargins(shape=(2, 3), stable=2)"
    with pytest.raises(ValueError, match="read-only"):
        margins.phase_margin_deg[0] = 0.0
    with pytest.raises(AttributeError):
        margins.stable = True
    assert margins[0].shape == (3,)
    assert margins[..., 1].phase_margin_deg[0] == pytest.approx(27, rel=1e-11)
    assert margins[margins.stable].shape == (2,)
    for name in NAMES:
        assert np.isnan(getattr(margins, name)[~margins.stable]).all()


def test_results_do_not_change_with_the_arguments():
    delay = np.array([0.0, 0.01])
    margins = many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=delay)
    before = margins.phase_margin_deg.copy()
    delay[:] = 5.0
    np.testing.assert_array_equal(margins.phase_margin_deg, before)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (([], [1.0, 1.0]), ValueError, r"numerator of shape \(0,\) has no coefficients"),
        (([1.0], [0.0, 0.0]), ValueError, r"denominator = \[0.0, 0.0\]: expected a polynomial"),
        (([1.0], [[1.0], [0.0]]), ValueError, r"denominator\[1\] = \[0.0\]"),
        (([1.0, math.nan], [1.0, 1.0]), ValueError, r"numerator\[1\] = nan"),
        (([1.0], [math.inf, 1.0]), ValueError, r"denominator\[0\] = inf"),
        (([1j], [1.0, 1.0]), TypeError, r"numerator = \[1j\]: expected a number"),
        (([1.0], [1.0, 1.0], -1.0), ValueError, "delay = -1.0: expected delays of zero or more"),
        (([1.0], [1.0, 1.0], [0.0, -2.0]), ValueError, r"delay\[1\] = -2.0"),
        (([1.0], [1.0, 1.0], math.nan), ValueError, "delay must be finite"),
        ((np.ones((3, 2)), np.ones((4, 3))), ValueError, r"\(3,\), denominators of \(4,\)"),
        (([1e300], [1.0, 1.0], 1.0), ValueError, "range of a double: choose units"),
    ],
    ids=["empty", "zero", "zero-row", "nan", "inf", "complex", "negative", "negative-element",
         "nan-delay", "shapes", "range"],
)  # fmt: skip
def test_what_is_not_accepted_is_named_with_a_remedy(arguments, error, message):
    numerator, denominator, *delay = arguments
    with pytest.raises(error, match=message):
        many_loop_margins(numerator, denominator, delay=delay[0] if delay else 0.0)


@pytest.mark.parametrize(
    ("inertia", "options", "error", "message"),
    [
        ([1.0, 0.0], {}, ValueError, r"inertia\[1\] = 0.0: expected positive inertias"),
        (math.nan, {}, ValueError, "inertia must be finite"),
        (1.0, {"gain": math.inf}, ValueError, "gain must be finite"),
        (1.0, {"controller": 3.0}, TypeError, "controller = 3.0: expected a PID"),
    ],
    ids=["zero", "nan", "gain", "controller"],
)
def test_what_a_servo_loop_does_not_accept(inertia, options, error, message):
    with pytest.raises(error, match=message):
        servo_margins(inertia, **{"controller": GAINS} | options)
