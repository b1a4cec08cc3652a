"""Perfect splines: Thompson's Table 1, switch times, peaks and optimality, against mpmath."""

from math import factorial

import mpmath
import numpy as np
import pytest
from references import CONTINUITY, joint_gaps, spline_states

from jounce.shaping import switch_fractions
from jounce.shaping.closed_form import spline_peaks
from jounce.shaping.rise import (
    prepend_integral,
    pulse_rise,
    spline_divisor,
    spline_rise,
    swing_rise,
    to_trajectory,
    unit_spline,
)

TABLE_1 = [1, 4, 32, 384, 6144, 122880, 2949120, 82575360, 2642411520, 95126814720]


def test_divisors_are_those_of_table_1():
    assert [spline_divisor(n) for n in range(1, 11)] == TABLE_1


@pytest.mark.parametrize("order", [*range(1, 21), 40])
def test_switch_fractions_are_squared_sines(order):
    fractions = switch_fractions(order)
    with mpmath.workdps(40):
        exact = [mpmath.sin(k * mpmath.pi / (2 * order)) ** 2 for k in range(order + 1)]
    np.testing.assert_allclose(fractions, np.array(exact, dtype=float), rtol=0, atol=2.3e-16)
    np.testing.assert_allclose(fractions + fractions[::-1], 1.0, rtol=0, atol=4.5e-16)
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0


@pytest.mark.parametrize(
    ("order", "printed"),
    [
        (2, [0.5]),
        (3, [0.25, 0.75]),
        (4, [0.14644661, 0.5, 0.85355339]),
        (5, [0.09549150, 0.34549150, 0.65450850, 0.90450850]),
        (6, [0.06698730, 0.25, 0.5, 0.75, 0.93301270]),
    ],
)
def test_switch_fractions_to_eight_digits(order, printed):
    np.testing.assert_allclose(switch_fractions(order)[1:-1], printed, rtol=0, atol=5e-9)


@pytest.mark.parametrize("order", [0, -1, 2.5, float("nan")])
def test_switch_fractions_refuse_what_is_no_order(order):
    with pytest.raises(ValueError, match=r"order = .*expected a whole number"):
        switch_fractions(order)


@pytest.mark.parametrize("order", range(1, 13))
def test_the_switching_pattern_is_orthogonal_to_all_lower_powers(order):
    """A sign pattern orthogonal to 1, t, …, t^(n−2) is optimal: no other u in ±D gets further.

    x(T) = ∫u·(p + q) for p = (T−t)^(n−1)/(n−1)! and any q of degree below n − 1 (rest at the
    end); where u = D·sign(p + q) for one such q, x(T) = D·∫|p + q| is a bound for every u.
    """
    fractions = [mpmath.mpf(float(t)) for t in switch_fractions(order)]
    for j in range(order - 1):
        moment = mpmath.fsum(
            (-1) ** i * (fractions[i + 1] ** (j + 1) - fractions[i] ** (j + 1))
            for i in range(order)
        )
        assert abs(moment) < 1e-15 * order
    last = mpmath.fsum(
        (-1) ** i * ((1 - fractions[i]) ** order - (1 - fractions[i + 1]) ** order)
        for i in range(order)
    )
    reached = float(last) / factorial(order)
    assert reached * spline_divisor(order) == pytest.approx(1.0, abs=1e-15 * 8.0**order)


@pytest.mark.parametrize(
    ("order", "printed"),
    [
        (3, [1 / 16, 1 / 4]),
        (4, [(2 - 2**0.5) / 96, 0.0214466, 0.2071068]),
        (5, [4.205065e-4, 1.691704e-3, 0.01475425, 0.1545085]),
        (6, [2.297433e-5, 9.931350e-5, 1.0216272e-3, 8.974596e-3, 0.1339746]),
    ],
)
def test_peaks_are_the_published_ones(order, printed):
    assert list(spline_peaks(order)) == pytest.approx(printed, rel=5e-7)


@pytest.mark.parametrize("order", [*range(1, 11), pytest.param(20, id="20")])
def test_unit_spline_matches_its_integration_in_60_digits(order):
    times, states = spline_states(order)
    assert abs(states[-1][0] - 1) < 1e-40
    unit = unit_spline(order)
    assert (unit.span, unit.peak) == (1.0, 1.0)
    np.testing.assert_allclose(unit.durations, np.diff(np.array(times)).astype(float), rtol=1e-14)
    tolerance = 1e-15 if order <= 10 else 1e-9
    for k in range(order + 1):
        exact = np.array([float(state[k]) for state in states[:-1]])
        np.testing.assert_allclose(
            unit.rows[k], exact, rtol=0, atol=tolerance * np.abs(exact).max(), err_msg=f"row {k}"
        )


@pytest.mark.parametrize("order", range(1, 9))
def test_spline_rise_scales_every_derivative(order):
    rise, unit = (
        spline_rise(order, 2.0, 3.0, 3.0 * TABLE_1[order - 1] / 2.0**order),
        unit_spline(order),
    )
    for k in range(order + 1):
        np.testing.assert_allclose(rise.rows[k], unit.rows[k] * 3.0 / 2.0**k, rtol=1e-15)
    np.testing.assert_array_equal(rise.durations, 2.0 * unit.durations)


def _swing_distance():
    """Return the distance of the swing below: twice ∫ a·(middle − t) dt over its first half."""
    ratio, hold = mpmath.cbrt(2), mpmath.mpf("0.5")
    times, states = spline_states(3)
    middle = 1 + hold + ratio / 2

    def unit(s):
        i = max(j for j in range(3) if times[j] <= s)
        return sum(states[i][j] * (s - times[i]) ** j / mpmath.factorial(j) for j in range(4))

    def acceleration(t):
        if t < 1 + hold:
            return 2 * unit(t) if t < 1 else mpmath.mpf(2)
        return 2 - 4 * unit((t - 1 - hold) / ratio)

    edges = [*times, 1 + hold, 1 + hold + ratio * times[1], middle]
    return float(2 * mpmath.quad(lambda t: acceleration(t) * (middle - t), edges))


SWING = _swing_distance()


def make_rise(name):
    """Return a rise of position by name, and its distance."""
    up = spline_rise(3, 1.0, 2.0, 64.0)
    if name == "pulse":
        return pulse_rise(up, 0.0, 2.0), 2.0
    if name == "pulse with hold":
        return pulse_rise(up, 0.5, 3.0), 3.0
    if name == "pulse of a pulse":
        return pulse_rise(pulse_rise(up, 0.5, 3.0), 0.25, 3.0 * 2.75), 8.25
    # Up and across at the same jerk: across is 2^(1/3) as long.
    ratio = 2.0 ** (1 / 3)
    return swing_rise(up, 0.5, spline_rise(3, ratio, 4.0, 64.0), SWING), SWING


@pytest.mark.parametrize("name", ["pulse", "pulse with hold", "pulse of a pulse", "swing"])
def test_rises_are_continuous_and_point_symmetric(name):
    rise, distance = make_rise(name)
    move = to_trajectory(rise)
    assert move.duration == rise.span
    assert max(joint_gaps(move)) <= CONTINUITY, f"{name}: {joint_gaps(move)}"
    assert move.end_state[0] == rise.peak == distance
    t = np.linspace(0.0, rise.span, 301)
    np.testing.assert_allclose(move(t) + move(rise.span - t), distance, rtol=1e-14)
    np.testing.assert_array_equal(move.end_state[1:], 0.0)
    np.testing.assert_array_equal(move.start_state[:-1], 0.0)


@pytest.mark.parametrize("rise", [True, False])
@pytest.mark.parametrize("pieces", [3, 4])
def test_prepend_integral_puts_a_running_integral_on_top(pieces, rise):
    """Of a symmetric function for a rise; of an antisymmetric one for a pulse."""
    durations = np.array([1.0, 2.0, 1.0]) if pieces == 3 else np.array([1.0, 2.0, 2.0, 1.0])
    half = np.array([3.0, -1.0]) if pieces == 4 else np.array([3.0])
    middle = [] if pieces == 4 else ([5.0] if rise else [0.0])
    values = np.concatenate([half, middle, half[::-1] if rise else -half[::-1]])
    total = float((values * durations).sum())
    rows = prepend_integral(durations, values[None, :], total, rise=rise)
    np.testing.assert_array_equal(rows[1], values)
    np.testing.assert_allclose(rows[0], np.concatenate([[0.0], np.cumsum(values * durations)[:-1]]))


def test_to_trajectory_merges_pieces_of_one_polynomial():
    up = spline_rise(1, 1.0, 1.0, 1.0)
    move = to_trajectory(pulse_rise(pulse_rise(up, 0.0, 1.0), 0.0, 2.0))
    np.testing.assert_array_equal(move.durations, [1.0, 2.0, 1.0])
    np.testing.assert_array_equal(move.breaks, [0.0, 1.0, 3.0, 4.0])
    np.testing.assert_array_equal(move.states[:, -1], [1.0, -1.0, 1.0])
