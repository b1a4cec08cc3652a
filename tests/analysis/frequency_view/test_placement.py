"""Nulls placed by lowering a limit: zero where they should be, and no slower than need be."""

from math import nan, pi, sqrt

import numpy as np
import pytest
from tiers import some

from jounce.analysis.frequency_view import place_null, residual_vibration
from jounce.shaping import Limits, min_time_move
from jounce.shaping.derivatives import derivative_name


def upper(limits, derivative):
    return limits.bounds(derivative)[1]


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forwards", "backwards"])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_jerk_ramp_of_one_period(unit, sign):
    """Where A is reached the jerk ramp takes A/W: W = A·f."""
    limits = Limits(velocity=1.0 * unit, acceleration=1.9 * unit, jerk=40.0 * unit)
    found = place_null(sign * 5.1 * unit, limits, 4.0, by="jerk")
    assert upper(found, "jerk") == pytest.approx(1.9 * unit * 4.0, rel=1e-12)
    assert found.upper[:2] == limits.upper[:2]


def test_closed_forms_of_lower_orders():
    v = place_null(3.0, Limits(velocity=2.0), 0.9, by="velocity")
    assert upper(v, 1) == pytest.approx(3.0 * 0.9 / 2.0, rel=1e-12)  # R/V of two periods
    a = place_null(5.03, Limits(velocity=1.0, acceleration=8.0), 3.0, by="acceleration")
    assert upper(a, 2) == pytest.approx(1.0 * 3.0, rel=1e-12)  # V/A of one period
    # a velocity triangle: a double null at 2/T, T = 2·sqrt(R/A)
    double = place_null(1.0, Limits(acceleration=1.0), 0.3, by="acceleration")
    assert upper(double, 2) == pytest.approx(0.3**2, rel=1e-6)
    assert residual_vibration(min_time_move(1.0, double), 0.3) < 1e-15
    # jerk alone: the first null at 2/T, T = (32·R/W)^(1/3)
    jerk = place_null(1.0, Limits(jerk=10.0), 0.2)
    assert upper(jerk, 3) == pytest.approx(32.0 * (0.2 / 2.0) ** 3, rel=1e-12)


def test_a_derivative_without_a_bound_gets_one():
    limits = Limits(velocity=1.0, acceleration=1.9)
    assert upper(place_null(5.1, limits, 4.0), "jerk") == pytest.approx(7.6, rel=1e-12)
    snap = place_null(5.1, limits, 4.0, by="snap")
    assert snap.order == 4
    assert residual_vibration(min_time_move(5.1, snap, method="closed-form"), 4.0) < 1e-15


@pytest.mark.parametrize("derivative", some(range(1, 8), 4), ids=derivative_name)
@pytest.mark.parametrize("order", some(range(1, 7), 4))
def test_any_limit_of_any_order(order, derivative):
    rng = np.random.default_rng((order, derivative))
    limits = Limits.from_bounds([10.0 ** rng.uniform(0.0, k) for k in range(1, order + 1)])
    distance = 10.0 ** rng.uniform(-2.0, 1.0)
    before = min_time_move(distance, limits, method="closed-form")
    frequency_hz = 10.0 ** rng.uniform(-0.7, 1.0) / before.duration
    found = place_null(distance, limits, frequency_hz, by=derivative)
    move = min_time_move(distance, found, method="closed-form")
    assert residual_vibration(move, frequency_hz) < 1e-12 * distance
    assert move.violation(limits) < 1e-12
    for k in range(1, order + 1):
        if k == derivative:
            assert upper(found, k) <= upper(limits, k)
        else:
            assert found.bounds(k) == limits.bounds(k)


@pytest.mark.parametrize("derivative", [1, 2, 3])
def test_no_higher_limit_has_a_null(derivative):
    """A dense search of its own between the limit found and the one given."""
    limits, distance, frequency_hz = Limits(2.0, 3.3, 25.0), 1.27, 1.1
    found = place_null(distance, limits, frequency_hz, by=derivative)
    given = min_time_move(distance, limits, method="closed-form").peak(derivative)
    bounds = np.geomspace(upper(found, derivative) * 1.0005, given, 1000)
    signs = set()
    for bound in bounds:
        pairs = list(limits.upper)
        pairs[derivative - 1] = bound
        move = min_time_move(distance, Limits.from_bounds(pairs), method="closed-form")
        omega = 2.0 * pi * frequency_hz
        time = np.linspace(0.0, move.duration, 401)
        kernel = np.cos(omega * (time - 0.5 * move.duration))
        signs.add(np.sign(np.trapezoid(move(time, "velocity") * kernel, time)))
    assert len(signs) == 1


def test_a_null_that_is_there_is_left_alone():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=40.0)  # V/A of two periods
    assert place_null(5.03, limits, 4.0) == limits
    damped_hz = 4.0 / sqrt(1.0 - 0.3**2)
    assert place_null(5.03, limits, damped_hz, damping=0.3) == limits
    assert place_null(0.3, Limits(velocity=1.0, acceleration=2.0), 1.0 / sqrt(0.15)) == Limits(1, 2)


@pytest.mark.parametrize("damping", [1e-3, 0.01, 0.05, 0.1, 0.2])
def test_with_damping_it_is_the_least_next_to_the_null(damping):
    limits, distance, mode_hz = Limits(1.0, 1.9, 40.0), 5.1, 4.0
    found = upper(place_null(distance, limits, mode_hz, damping=damping), "jerk")

    def residual(jerk):
        return residual_vibration(min_time_move(distance, Limits(1.0, 1.9, jerk)), mode_hz, damping)

    assert found == pytest.approx(1.9 * mode_hz, rel=0.06)
    near = [residual(found * factor) for factor in (0.95, 0.98, 1.02, 1.05)]
    assert residual(found) < min(near)
    assert residual(found) < 0.3 * residual(40.0)


def test_heavy_damping_leaves_no_minimum():
    with pytest.raises(ValueError, match=r"damping = 0.5 leaves no minimum .* without damping"):
        place_null(5.1, Limits(1.0, 1.9, 40.0), 4.0, damping=0.5)


def test_bounds_of_two_sides():
    with pytest.raises(ValueError, match="give the same bound in both directions"):
        place_null(1.0, Limits(2.0, (-1.0, 2.0)), 0.3, by="velocity")
    found = place_null(1.0, Limits((-1.0, 2.0), 1.0), 0.3, by="velocity")
    assert found.bounds(1) == (-upper(found, 1), upper(found, 1))
    small = place_null(1.0, Limits((-0.1, 2.0), 1.0), 0.3, by="velocity")
    assert small.bounds(1) == (-0.1, upper(found, 1))


@pytest.mark.parametrize(
    ("distance", "frequency_hz", "options", "message"),
    [
        (0.0, 1.0, {}, "distance = 0: nothing moves"),
        (nan, 1.0, {}, "distance = nan"),
        (1.0, -1.0, {}, "frequency_hz = -1.0"),
        (1.0, 1e9, {}, "rounding hides a null"),
        (1.0, 1.0, {"by": "position"}, "expected velocity or a higher derivative"),
        (1.0, 1.0, {"by": "jolt"}, "unknown derivative 'jolt'"),
        (1.0, 1.0, {"damping": 1.0}, "damping = 1.0"),
    ],
)
def test_what_makes_no_sense_is_refused(distance, frequency_hz, options, message):
    with pytest.raises(ValueError, match=message):
        place_null(distance, Limits(1.0, 2.0, 3.3), frequency_hz, **options)
