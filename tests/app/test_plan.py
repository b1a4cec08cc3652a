"""Plans from quantities with units, against Thompson's closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import END_POSITION, UNITS, thompson_order_2, thompson_order_3

from jounce.app.plan import HIGHEST_DERIVATIVE, derivative_key, plan_move
from jounce.app.units import UnitError
from jounce.shaping import InfeasibleError

DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600
DIVISORS = {1: 1, 2: 4, 3: 32, 4: 384, 5: 6144, 6: 122880, 7: 2949120, 10: 95126814720}


def test_a_bang_bang_move():
    plan = plan_move("60 arcsec", {2: "0.2 deg/s^2"})
    reference = thompson_order_2(60 / 3600, math.inf, 0.2)
    assert plan.trajectory.duration == pytest.approx(reference.duration, rel=1e-14)
    assert plan.unit == "arcsec"
    assert plan.scale == pytest.approx(ARCSEC)
    assert plan.limits.bounds(2) == pytest.approx((-0.2 * DEGREE, 0.2 * DEGREE))
    assert plan.trajectory.end_state[0] == pytest.approx(60 * ARCSEC, rel=END_POSITION)


@pytest.mark.parametrize(
    ("velocity", "acceleration", "jerk"),
    [(100, 100, 1), (100, 0.8, 4), (0.5, 10, 4), (0.5, 0.8, 4)],
)
def test_the_four_cases_of_order_3(velocity, acceleration, jerk):
    bounds = {1: f"{velocity} mm/s", 2: f"{acceleration} mm/s^2", 3: f"{jerk} mm/s^3"}
    reference = thompson_order_3(2.0, velocity, acceleration, jerk)
    move = plan_move("2 mm", bounds).trajectory
    assert move.duration == pytest.approx(reference.duration, rel=1e-13)
    np.testing.assert_allclose(move.switch_times, reference.switches, atol=1e-12)


def test_the_four_cases_are_four():
    cases = [(100, 100, 1), (100, 0.8, 4), (0.5, 10, 4), (0.5, 0.8, 4)]
    assert [thompson_order_3(2.0, *case).case for case in cases] == ["1", "2", "3", "4"]


@pytest.mark.parametrize("order", DIVISORS)
def test_only_the_highest_derivative_bounded(order):
    per = "s" if order == 1 else f"s^{order}"
    plan = plan_move("2 mm", {order: f"7 mm/{per}"})
    expected = (2 * DIVISORS[order] / 7) ** (1 / order)
    assert plan.trajectory.duration == pytest.approx(expected, rel=1e-13)
    assert plan.trajectory.order == order


def test_bounds_of_zero_and_on_position_are_taken_as_in_python():
    bounds = {1: "0 m/s, 20 m/s", 2: "-4 m/s^2, 1 m/s^2", 3: "10 m/s^3"}
    plan = plan_move("60 m", bounds, position="0 m, 60 m")
    assert plan.limits.bounds("velocity") == (0.0, 20.0)
    assert plan.limits.position == (0.0, 60.0)
    assert plan.trajectory.violation(plan.limits) <= 1e-12
    assert plan.trajectory.duration == pytest.approx(12.5, rel=1e-4)  # as with neither
    with pytest.raises(InfeasibleError, match="velocity bound 0 stands in the way; lower it"):
        plan_move("-60 m", bounds)


@pytest.mark.parametrize("text", ["60 m", "60 m, 0 m", "0 m, 0 m", "0 m, 1 m, 2 m"])
def test_positions_that_are_no_pair_are_refused(text):
    with pytest.raises(UnitError, match=r"position limit: .* is not a pair of positions; write"):
        plan_move("60 m", {2: "1 m/s^2"}, position=text)


def test_a_rise_time_fixes_the_highest_bound():
    """Thompson IV: A = 0.2 deg/s² reached in 1 s takes a pop of 76.8 deg/s⁶."""
    method = "closed-form"
    plan = plan_move("600 deg", {2: "0.2 deg/s^2"}, rise_time="1 s", order=6, method=method)
    assert plan.limits.bounds(6)[1] == pytest.approx(76.8 * DEGREE, rel=1e-12)
    direct = plan_move("600 deg", {2: "0.2 deg/s^2", 6: "76.8 deg/s^6"}, method=method)
    assert plan.trajectory.duration == pytest.approx(direct.trajectory.duration, rel=1e-12)
    reached = plan.trajectory.switch_times[4]
    assert reached == pytest.approx(1.0, rel=1e-9)
    assert plan.trajectory(reached, 2) == pytest.approx(0.2 * DEGREE, rel=1e-9)


@pytest.mark.parametrize("order", [3, 4, 5])
def test_rise_times_of_other_orders(order):
    plan = plan_move("600 deg", {2: "0.2 deg/s^2"}, rise_time="250 ms", order=order)
    m = order - 2
    expected = 0.2 * math.factorial(m - 1) * 4 ** (m - 1) / 0.25**m
    assert plan.limits.bounds(order)[1] == pytest.approx(expected * DEGREE, rel=1e-12)


def test_the_distance_may_be_negative():
    forth = plan_move("60 arcsec", {2: "0.2 deg/s^2", 3: "1 deg/s^3"}).trajectory
    back = plan_move("-60 arcsec", {2: "0.2 deg/s^2", 3: "1 deg/s^3"}).trajectory
    np.testing.assert_array_equal(back.breaks, forth.breaks)
    np.testing.assert_allclose(back.states, -forth.states, rtol=1e-13, atol=1e-20)


@pytest.mark.parametrize("distance", ["60 arcsec", "-60 arcsec"])
def test_a_pair_of_bounds(distance):
    plan = plan_move(distance, {2: "-0.1 deg/s^2, 0.2 deg/s^2"})
    expected = math.sqrt(2 * 60 / 3600 * (1 / 0.1 + 1 / 0.2))
    assert plan.trajectory.duration == pytest.approx(expected, rel=1e-13)
    ramp_up = plan.trajectory.switch_times[1]
    share = 1 / 3 if distance.startswith("6") else 2 / 3
    assert ramp_up == pytest.approx(share * expected, rel=1e-12)


def test_a_start():
    plan = plan_move("2 mm", {2: "5 mm/s^2"}, start="-1 inch")
    assert plan.trajectory.start_state[0] == pytest.approx(-0.0254)
    assert plan.trajectory.end_state[0] == pytest.approx(-0.0234)


def test_no_distance_takes_no_time():
    plan = plan_move("0 mm", {2: "1 mm/s^2"})
    assert plan.trajectory.duration == 0.0


@given(distance=st.floats(1e-3, 1e3), acceleration=st.floats(1e-3, 1e3))
def test_units_do_not_change_the_duration(distance, acceleration):
    one = plan_move(f"{distance!r} deg", {2: f"{acceleration!r} deg/s^2"})
    other = plan_move(f"{distance!r} deg", {2: f"{acceleration!r} deg/s/s"})
    turned = plan_move(f"{3600 * distance!r} arcsec", {2: f"{60 * acceleration!r} arcmin/s^2"})
    for plan in (other, turned):
        assert plan.trajectory.duration == pytest.approx(one.trajectory.duration, rel=UNITS)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("60", {2: "1 deg/s^2"}), ["distance", "'60'", "no unit"]),
        (("60 parsec", {2: "1 deg/s^2"}), ["distance", "parsec"]),
        (("60 s", {2: "1 deg/s^2"}), ["distance", "dimension"]),
        (("nan arcsec", {2: "1 deg/s^2"}), ["distance", "not finite"]),
        (("inf mm", {2: "1 mm/s^2"}), ["distance", "not finite"]),
        (("60 arcsec", {2: "1 mm/s^2"}), ["acceleration", "dimension", "deg/s^2"]),
        (("60 arcsec", {3: "1 deg/s^2"}), ["jerk", "dimension", "deg/s^3"]),
        (("60 arcsec", {7: "1 deg/s^2"}), ["derivative 7", "dimension", "deg/s^7"]),
        (("60 arcsec", {2: "-1 deg/s^2"}), ["acceleration", "positive"]),
        (("60 arcsec", {2: "0 deg/s^2"}), ["acceleration", "positive"]),
        (("60 arcsec", {2: "nan deg/s^2"}), ["acceleration", "not finite"]),
        (("60 arcsec", {2: "inf deg/s^2"}), ["acceleration", "not finite"]),
        (("60 arcsec", {2: "1 deg/s^2, 2 deg/s^2"}), ["acceleration", "pair"]),
        (("60 arcsec", {2: "1 deg/s^2, -2 deg/s^2"}), ["acceleration", "pair"]),
        (("60 arcsec", {2: "-1 deg/s^2,"}), ["acceleration"]),
        (("60 arcsec", {2: "-1 deg/s^2, 1 deg/s^2, 2 deg/s^2"}), ["acceleration", "pair"]),
        (("60 arcsec", {2: ""}), ["acceleration", "empty"]),
    ],
)
def test_quantities_that_are_not(arguments, words):
    with pytest.raises(UnitError) as refusal:
        plan_move(*arguments)
    message = str(refusal.value)
    assert "\n" not in message
    for word in words:
        assert word in message


def test_a_start_of_the_wrong_kind():
    with pytest.raises(UnitError, match=r"start.*dimension"):
        plan_move("60 arcsec", {2: "1 deg/s^2"}, start="1 mm")


A = "0.2 deg/s^2"


@pytest.mark.parametrize(
    ("bounds", "options", "words"),
    [
        ({}, {}, ["limit"]),
        ({}, {"rise_time": "1 s", "order": 6}, ["acceleration"]),
        ({2: A}, {"rise_time": "1 s"}, ["order"]),
        ({2: A}, {"order": 6}, ["rise time"]),
        ({2: A, 6: "1 deg/s^6"}, {"rise_time": "1 s", "order": 6}, ["pop", "twice"]),
        ({2: "-1 deg/s^2, 2 deg/s^2"}, {"rise_time": "1 s", "order": 6}, ["one acceleration"]),
        ({2: A}, {"rise_time": "1 s", "order": 1}, ["order", "3"]),
        ({2: A}, {"rise_time": "1 s", "order": 2}, ["order", "3"]),
        ({2: A}, {"rise_time": "1 s", "order": 0}, ["order", "3"]),
        ({2: A}, {"rise_time": "1 s", "order": -3}, ["order", "3"]),
        ({2: A}, {"rise_time": "1 s", "order": 60}, ["order"]),
        ({2: A}, {"rise_time": "1 s", "order": 20}, ["order"]),
        ({2: A}, {"rise_time": "0 s", "order": 6}, ["rise time", "positive"]),
        ({2: A}, {"rise_time": "1 deg", "order": 6}, ["rise time", "dimension"]),
    ],
)
def test_limits_that_do_not_fit_together(bounds, options, words):
    with pytest.raises(ValueError, match=r"\S") as refusal:
        plan_move("60 arcsec", bounds, **options)
    message = str(refusal.value)
    assert "\n" not in message
    for word in words:
        assert word in message


def test_derivatives_by_number_and_name():
    names = ("velocity", "acceleration", "jerk", "snap", "crackle", "pop")
    assert [derivative_key(name) for name in names] == [1, 2, 3, 4, 5, 6]
    assert [derivative_key(str(k)) for k in range(1, HIGHEST_DERIVATIVE + 1)] == list(
        range(1, HIGHEST_DERIVATIVE + 1)
    )
    assert derivative_key(" Jerk ") == 3


@pytest.mark.parametrize("text", ["", "0", "-1", "15", "1.5", "position", "lock", "²", "٣٣"])
def test_derivatives_that_are_not(text):
    with pytest.raises(ValueError, match="unknown derivative") as refusal:
        derivative_key(text)
    assert "velocity" in str(refusal.value)
