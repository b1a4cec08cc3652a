"""Chain plans on arrays: each is the scalar plan, whatever its neighbours."""

from math import inf, prod

import numpy as np
import pytest
from hypothesis import given
from strategies import bound_lists

from jounce.shaping.batches.chains import chains, int_power, spline_spans
from jounce.shaping.closed_form import chain_form, spline_span


def random_bounds(seed, order, count, decades=12.0):
    """Return bounds (order, count), some infinite below the highest."""
    rng = np.random.default_rng((seed, order))
    bounds = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, (order, count))
    bounds[:-1][rng.random((order - 1, count)) < 0.3] = inf
    return bounds


def plan_all(bounds, level):
    with np.errstate(all="ignore"):
        return chains(np.ones(bounds.shape[1]), list(bounds), level)


@pytest.mark.parametrize("order", range(1, 9))
def test_every_level_is_the_scalar_plan(order):
    bounds = random_bounds(1, order, 60)
    for level in range(order):
        plans = plan_all(bounds, level)
        for i, column in enumerate(bounds.T.tolist()):
            plan, text = chain_form(1.0, column, level), f"chain_form(1.0, {column!r}, {level})"
            for name in ("span", "peak", "highest", "duration"):
                found = getattr(plans, name)[i]
                assert found == pytest.approx(getattr(plan, name), rel=2e-14), f"{text}: {name}"
            for hold, expected in zip(plans.holds, plan.holds, strict=True):
                assert abs(hold[i] - expected) <= 1e-14 * plan.duration, text
            for peak, expected in zip(plans.peaks, plan.peaks, strict=True):
                assert peak[i] == pytest.approx(expected, rel=2e-14), text


@given(bounds=bound_lists(1, 7))
def test_the_recursion_is_a_chain_of_moving_averages(bounds):
    """R = L·∏w, each width at least the sum of those inside."""
    limits = [np.array(inf if bound is None else bound) for bound in bounds]
    n = len(bounds)
    with np.errstate(all="ignore"):
        plan = chains(np.array([1.0, 1.0]), limits, n - 1)
    widths, span = [plan.span[0]], plan.span[0]
    for hold in plan.holds:
        widths.append(span + hold[1])
        span += widths[-1]
    assert plan.duration[0] == pytest.approx(sum(widths), rel=1e-14)
    assert float(limits[-1]) * prod(widths) == pytest.approx(1.0, rel=1e-13)
    for k, bound in enumerate(limits, start=1):
        assert limits[-1] * prod(widths[: n - k]) <= bound * (1.0 + 1e-13), f"derivative {k}"


@pytest.mark.parametrize("order", range(1, 9))
def test_spans_are_the_scalar_ones(order):
    bounds = random_bounds(2, order, 200)
    peaks = np.random.default_rng(2).uniform(0.1, 10.0, 200)
    with np.errstate(all="ignore"):
        found = spline_spans(peaks, list(bounds))
    expected = [spline_span(p, c) for p, c in zip(peaks.tolist(), bounds.T.tolist(), strict=True)]
    np.testing.assert_allclose(found, np.transpose(expected), rtol=1e-14)


def test_powers():
    base = np.array([0.5, 3.0, inf])
    for power in range(1, 6):
        np.testing.assert_allclose(int_power(base, power), base**power, rtol=1e-15)
