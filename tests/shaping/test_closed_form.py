"""Closed-form plans: the recursion, perfect-spline ramps and Thompson's longer moves."""

from math import inf, prod, sqrt

import numpy as np
import pytest
from hypothesis import given
from references import BOUND, CONTINUITY, joint_gaps, move_text, reference_problems
from strategies import bound_lists

from jounce.shaping import Limits
from jounce.shaping.closed_form import chain_form, fastest_form, spline_peaks, swing_form
from jounce.shaping.rise import spline_divisor, to_trajectory

PROBLEMS = [pytest.param(problem, id=problem.name) for problem in reference_problems()]


def filled(bounds):
    """Return bounds with inf for None."""
    return [inf if bound is None else bound for bound in bounds]


def all_plans(distance, bounds):
    """Return every closed-form plan there is, by name."""
    plans = {f"level {k}": chain_form(distance, bounds, k) for k in range(len(bounds))}
    swing = swing_form(distance, bounds)
    return plans if swing is None else {**plans, "swing": swing}


# The recursion


@pytest.mark.parametrize("problem", PROBLEMS)
def test_recursion_has_the_reference_duration(problem):
    plan = chain_form(problem.distance, problem.bounds, problem.order - 1)
    assert plan.duration == pytest.approx(problem.recursion, rel=1e-12)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_durations_lie_between_proof_and_recursion(problem):
    plan = fastest_form(problem.distance, problem.bounds)
    assert plan.duration >= problem.lower * (1.0 - 1e-9)
    assert plan.duration <= problem.recursion * (1.0 + 1e-12)


@given(bounds=bound_lists(1, 7))
def test_recursion_is_a_chain_of_moving_averages(bounds):
    """R = L·∏w, peak_k = L·∏_{j>k} w_j, T = Σw, each width at least the sum of those inside."""
    limits, n = filled(bounds), len(bounds)
    plan = chain_form(1.0, limits, n - 1)
    widths, span = [plan.span], plan.span
    for hold in plan.holds:
        widths.append(span + hold)
        span += widths[-1]
    assert plan.duration == pytest.approx(sum(widths), rel=1e-14)
    assert limits[-1] * prod(widths) == pytest.approx(1.0, rel=1e-13)
    peaks = [limits[-1] * prod(widths[: n - k]) for k in range(1, n + 1)]
    for k in range(1, n):
        assert peaks[k - 1] <= limits[k - 1] * (1.0 + 1e-13), f"derivative {k}"
        assert (plan.peak, *plan.peaks)[n - 1 - k] == pytest.approx(peaks[k - 1], rel=1e-13)
    for j in range(1, n):
        assert widths[j] >= sum(widths[:j]) * (1.0 - 1e-13)


@given(bounds=bound_lists(2, 7))
def test_a_derivative_is_held_only_at_its_bound(bounds):
    limits = filled(bounds)
    plan = chain_form(1.0, limits, len(bounds) - 1)
    peaks = (plan.peak, *plan.peaks)
    for k, hold, peak in zip(range(len(bounds) - 1, 0, -1), plan.holds, peaks, strict=False):
        if hold > 1e-12 * plan.duration:
            assert peak == pytest.approx(limits[k - 1], rel=1e-13), f"derivative {k}"


# Every plan


@given(bounds=bound_lists(1, 6))
def test_every_plan_keeps_its_bounds_and_meets_its_distance(bounds):
    limits = filled(bounds)
    plans = all_plans(1.0, limits)
    assert f"level {len(bounds) - 1}" in plans
    for name, plan in plans.items():
        move = to_trajectory(plan.build())
        text = f"{name} of {move_text(1.0, limits)}"
        assert move.violation(Limits.from_bounds(bounds)) <= BOUND, text
        assert move.duration == pytest.approx(plan.duration, rel=1e-14), text
        assert move.end_state[0] == pytest.approx(1.0, rel=1e-14), text
        assert max(joint_gaps(move)) <= CONTINUITY, text
    assert fastest_form(1.0, limits).duration == min(plan.duration for plan in plans.values())


@pytest.mark.parametrize("order", range(1, 9))
def test_level_0_is_the_perfect_spline_as_long_as_no_bound_stops_it(order):
    divisor = spline_divisor(order)
    free = [inf] * (order - 1) + [float(divisor)]
    assert chain_form(1.0, free, 0).duration == pytest.approx(1.0, rel=1e-14)
    for k, c in enumerate(spline_peaks(order)):
        bounds = list(free)
        bounds[k] = divisor * c * (1.0 + 1e-12)
        assert chain_form(1.0, bounds, 0).duration == pytest.approx(1.0, rel=1e-14)
        bounds[k] = divisor * c * (1.0 - 1e-9)
        assert chain_form(1.0, bounds, 0).duration > 1.0


@pytest.mark.parametrize("order", range(2, 9))
def test_level_0_is_stretched_until_an_inner_bound_holds(order):
    """With T stretched s-fold at the same distance, derivative k shrinks s^k-fold."""
    divisor = spline_divisor(order)
    for k, c in enumerate(spline_peaks(order), start=1):
        bounds = [inf] * (order - 1) + [float(divisor)]
        bounds[k - 1] = divisor * c / 1.5**k
        assert chain_form(1.0, bounds, 0).duration == pytest.approx(1.5, rel=1e-13)


@pytest.mark.parametrize("order", range(1, 13))
def test_recursion_is_slower_than_the_perfect_spline_by_the_known_ratio(order):
    """Widths s, s, 2s, 4s, …: T = 2^(n−1)·s and R = D·sⁿ·2^((n−1)(n−2)/2)."""
    bounds = [inf] * (order - 1) + [1.0]
    recursion, spline = (chain_form(1.0, bounds, level).duration for level in (order - 1, 0))
    ratio = (2 ** ((order - 1) * (order + 2) // 2) / spline_divisor(order)) ** (1 / order)
    assert recursion / spline == pytest.approx(ratio, rel=1e-14)
    printed = {3: 1.0, 4: 1.0746, 5: 1.2167, 6: 1.4295, 10: 3.37}
    assert recursion / spline == pytest.approx(printed.get(order, ratio), rel=1e-3)


# Thompson's longer moves: highest derivative D and acceleration A bounded, m = n − 2

LONGER = [
    pytest.param(1, 1 / 4, 2.0, 1 / 2, id="m = 1"),
    pytest.param(2, 1 / 6, 17 / 6 + 2 * sqrt(2), 2 * sqrt(2) / 3, id="m = 2"),
    pytest.param(3, 0.1850197375, 12.6844266, 17 / 12, id="m = 3"),
    pytest.param(4, 0.2029223745, 23.2760629, 1.9515308, id="m = 4"),
]
SETTINGS = [(1.0, 1.0), (0.2, 76.8), (300.0, 7.0)]


@pytest.mark.parametrize(("a", "d"), SETTINGS)
@pytest.mark.parametrize(("m", "kappa", "shortest", "gain"), LONGER)
def test_longer_moves_have_thompsons_durations(m, kappa, shortest, gain, a, d):
    bounds = [inf, a, *[inf] * (m - 1), d]
    unit, rise = (a / d) ** (1 / m), spline_divisor(m) ** (1 / m)
    for factor in (1.0 + 1e-6, 1.5, 30.0, 1e6):
        distance = factor * shortest * a * unit**2
        plan = swing_form(distance, bounds)
        expected = rise * unit + 2.0 * sqrt(kappa * unit**2 + distance / a)
        assert plan.duration == pytest.approx(expected, rel=2e-9)
        move = to_trajectory(plan.build())
        assert move.peak("acceleration") == pytest.approx(a, rel=1e-14)
        velocity = a * (0.5 * rise * unit + plan.hold + gain * unit)
        assert move.peak("velocity") == pytest.approx(velocity, rel=1e-7)


@pytest.mark.parametrize(("m", "kappa", "shortest", "gain"), LONGER)
def test_the_hold_ends_at_the_shortest_longer_move(m, kappa, shortest, gain):
    bounds = [inf, 1.0, *[inf] * (m - 1), 1.0]
    assert swing_form(shortest * (1 + 1e-6), bounds).hold > 0.0
    assert swing_form(shortest * (1 - 1e-6), bounds).hold == 0.0
    assert swing_form(shortest * (1 + 1e-9), bounds).duration == pytest.approx(
        swing_form(shortest * (1 - 1e-9), bounds).duration, rel=1e-8
    )
    at = swing_form(shortest, bounds).duration
    assert at == pytest.approx(spline_divisor(m) ** (1 / m) + 2 * sqrt(kappa + shortest), rel=1e-8)
    assert gain > 0.0


def test_order_3_longer_moves_are_thompsons_case_2():
    plan, recursion = swing_form(5.0, [inf, 1.0, 2.0]), chain_form(5.0, [inf, 1.0, 2.0], 2)
    assert plan.duration == pytest.approx(0.5 + sqrt(0.25 + 20.0), rel=1e-15)
    assert recursion.duration == pytest.approx(plan.duration, rel=1e-15)


@pytest.mark.parametrize(
    ("bounds", "why"),
    [
        ([1.0, 1.0], "order 2 has no ramp of acceleration"),
        ([inf, inf, 1.0, 1.0], "acceleration is not bounded"),
        ([0.5, 1.0, inf, 1.0], "velocity is in the way"),
    ],
)
def test_there_is_no_longer_move_where(bounds, why):
    assert swing_form(100.0, bounds) is None, why


def test_a_longer_distance_takes_longer():
    rng = np.random.default_rng(0)
    for order in range(2, 9):
        bounds = [10.0 ** rng.uniform(-0.5, 1.0) * 4.0**k for k in range(order)]
        durations = [fastest_form(r, bounds).duration for r in np.geomspace(1e-6, 1e6, 200)]
        assert (np.diff(durations) > 0).all(), f"fastest_form(…, {bounds!r})"
