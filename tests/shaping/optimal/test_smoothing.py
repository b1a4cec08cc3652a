"""Moves run through moving averages, against convolutions, quadrature and their own bounds."""

from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly
from strategies import bound_lists

from jounce.shaping import Limits, min_time_move
from jounce.shaping.optimal.half_motion import whole_move
from jounce.shaping.optimal.smoothing import (
    averaged_half,
    averaging_width,
    lower_order,
    relative_width,
    truncated,
)

FEW = settings(max_examples=max(10, settings.default.max_examples // 2))
WIDTHS = st.floats(-4.0, 0.3).map(lambda exponent: 10.0**exponent)


def closed_form(bounds):
    return min_time_move(1.0, Limits.from_bounds(bounds), method="closed-form")


def times_of(half):
    return np.concatenate([[0.0], np.asarray(np.cumsum(half.durations), float)])


def means(move, derivative: int, t, widths):
    """Return moving averages of a derivative by nested Gauss quadrature between its breaks."""
    if not widths:
        return move(t, derivative) if derivative or t < move.duration else move.end_state[0]
    width, *rest = widths
    edges = {0.0, width, *(t - b for b in move.breaks)}
    for other in rest:
        edges |= {t - b - other for b in move.breaks}
    edges = sorted(e for e in edges if 0.0 <= e <= width)
    points, weights = np.polynomial.legendre.leggauss(move.order + 2)
    total = 0.0
    for left, right in pairwise(edges):
        for point, weight in zip(points, weights, strict=True):
            at = 0.5 * (left + right) + 0.5 * (right - left) * point
            total += 0.5 * (right - left) * weight * means(move, derivative, t - at, rest)
    return total / width


@pytest.mark.parametrize("steps", [1, 2])
@pytest.mark.parametrize("width", [0.01, 0.3])
@pytest.mark.parametrize("order", [2, 3])
def test_derivatives_are_means_of_the_moves(order, steps, width):
    move = closed_form([1.3, 6.0, 60.0][:order])
    half = averaged_half(move, order + steps, width)
    states, times = half.states(), times_of(half)
    for i in range(len(times)):
        for k in range(order):
            expected = means(move, k, times[i], [width] * steps)
            assert float(states[k, i]) == pytest.approx(
                expected, rel=1e-11, abs=1e-12 * move.peak(k)
            ), (k, i)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_a_numerical_convolution_gives_the_same(steps):
    move, width = closed_form([1.3, 6.0, 60.0]), 0.12
    half = averaged_half(move, 3 + steps, width)
    dt = width / 600
    t = dt * np.arange(int((move.duration + steps * width) / dt) + 2)
    box = np.ones(601)
    box[[0, -1]] = 0.5
    velocity = move(t, 1)
    for _ in range(steps):
        velocity = np.convolve(velocity, box / box.sum())[: len(t)]
    found = PPoly(half.inputs[None, :], times_of(half)).antiderivative(2 + steps)
    inside = t < times_of(half)[-1]
    np.testing.assert_allclose(found(t[inside]), velocity[inside], rtol=0, atol=2e-5)


@FEW
@given(bounds=bound_lists(1, 5), steps=st.integers(1, 3), share=WIDTHS)
def test_an_averaged_move_keeps_every_bound_and_takes_the_widths_longer(bounds, steps, share):
    """Whatever the width: nothing of the move is left out, its middle is half way."""
    move = closed_form(bounds)
    order, width = move.order + steps, share * move.duration
    half = averaged_half(move, order, width)
    assert half.order == order
    assert (half.durations > 0.0).all()
    longer = move.duration + steps * width
    assert 2.0 * float(half.durations.sum()) == pytest.approx(longer, rel=1e-13)
    states = np.asarray(half.states(), float)
    assert states[0, -1] == pytest.approx(0.5, rel=1e-9)
    for k, bound in enumerate(bounds, start=1):
        if bound is not None:
            assert np.abs(states[k]).max() <= bound * (1.0 + 1e-9), k
    highest = 2.0**steps * bounds[-1] / width**steps
    assert np.abs(half.inputs).max() <= highest * (1.0 + 1e-9)
    for k in range(2, order, 2):
        size = max(1e-300, np.abs(states[k]).max())
        assert abs(states[k, -1]) <= 1e-6 * size, k


@FEW
@given(bounds=bound_lists(1, 5), steps=st.integers(1, 3), ratio=st.floats(0.0, 6.0))
def test_the_width_is_what_the_highest_bound_needs(bounds, steps, ratio):
    """The averaged move is within all limits, the new highest one included."""
    move = closed_form(bounds)
    highest = bounds[-1] * (10.0**ratio / move.duration) ** steps
    limits = Limits.from_bounds([*bounds, *[None] * (steps - 1), highest])
    width = averaging_width(limits, len(bounds))
    assert width == pytest.approx(2.0 * move.duration / 10.0**ratio, rel=1e-12)
    assert relative_width(limits, len(bounds), move.duration) == pytest.approx(
        steps * width / move.duration, rel=1e-14
    )
    half = averaged_half(move, limits.order, width)
    assert np.abs(half.inputs).max() <= highest * (1.0 + 1e-9)
    whole = whole_move(half, 1.0, 1.0, limits)
    longest = move.duration * (1.0 + relative_width(limits, len(bounds), move.duration))
    assert whole.duration <= longest * (1.0 + 1e-9)
    assert whole.violation(limits) <= 1e-12


def test_the_width_of_sides_that_differ_is_that_of_the_wider_swing_by_the_narrower():
    limits = Limits.from_bounds([None, (-2.0, 3.0), None, (-50.0, 48.0)])
    assert averaging_width(limits, 2) == pytest.approx(2.0 * np.sqrt(3.0 / 48.0))


@given(bounds=bound_lists(2, 7))
def test_the_lower_order_is_the_one_that_costs_least(bounds):
    limits = Limits.from_bounds(bounds)
    order = lower_order(limits)
    bounded = [k for k, bound in enumerate(bounds[:-1], start=1) if bound]
    assert order in (bounded or [0])
    for other in bounded:
        assert relative_width(limits, order, 1.0) <= relative_width(limits, other, 1.0)


@pytest.mark.parametrize(
    ("bounds", "order"),
    [
        ([1.0], 0),
        ([None, None, 1.0], 0),
        ([1.0, None, 1.0], 1),
        ([(-1.0, 2.0), 1.0, None, 1.0], 2),
        ([None, (-inf, 1.0), 1.0], 0),
        ([3.0, (-1.0, inf), None, (-1.0, 2.0)], 1),
    ],
    ids=str,
)
def test_only_what_is_bounded_in_both_directions_is_a_lower_order(bounds, order):
    assert lower_order(Limits.from_bounds(bounds)) == order


@FEW
@given(bounds=bound_lists(2, 7).filter(lambda bounds: any(bounds[:-1])))
def test_from_the_lower_order_averages_lead_to_a_move_within_all_limits(bounds):
    limits = Limits.from_bounds(bounds)
    order = lower_order(limits)
    move = closed_form(bounds[:order])
    half = averaged_half(move, limits.order, averaging_width(limits, order))
    states = np.asarray(half.states(), float)
    for k, bound in enumerate(bounds, start=1):
        assert np.abs(states[k]).max() <= (bound or inf) * (1.0 + 1e-9), k
    longest = move.duration * (1.0 + relative_width(limits, order, move.duration))
    assert 2.0 * float(half.durations.sum()) == pytest.approx(longest, rel=1e-13)


@given(bounds=bound_lists(2, 7))
def test_truncated_limits_are_those_of_the_lower_derivatives(bounds):
    limits = Limits.from_bounds(bounds)
    for order in (k for k, bound in enumerate(bounds, start=1) if bound):
        below = truncated(limits, order)
        assert below.order == order
        assert [below.bounds(k) for k in range(1, order + 1)] == [
            limits.bounds(k) for k in range(1, order + 1)
        ]
