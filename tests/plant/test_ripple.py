"""Ripple over position, against springs, closed forms and small-step integration."""

import os
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    Controller,
    FlexibleMode,
    Friction,
    Inertia,
    Ramp,
    Ripple,
    ServoLoop,
    Sine,
    TorqueSteps,
)
from jounce.shaping import Limits, min_time_move

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
GAINS = PID(300.0, 600.0, 40.0)
MOVE = min_time_move(0.9, Limits(velocity=1.0, acceleration=5.0, jerk=50.0))


def slope(k, low, high, points=20):
    """Return a table whose torque is −k·position from low to high, and 0 a little beyond."""
    places = np.linspace(low, high, points)
    return Ripple(tuple(places), tuple(-k * places), 3.0 * (high - low))


CONTROLLERS = [
    Controller(GAINS),
    Controller(GAINS, anti_windup=BackCalculation(0.1)),
    Controller(GAINS, sample_time=2e-3, delay=1e-3, anti_windup="conditional"),
]


@pytest.mark.parametrize("friction", [None, Friction(1.0, 1.5)])
@pytest.mark.parametrize("limit", [np.inf, 9.0])
@pytest.mark.parametrize("controller", CONTROLLERS, ids=["plain", "limited", "digital"])
@pytest.mark.parametrize("modes", [(), (FlexibleMode(15.0, 0.02, load_fraction=0.3),)])
def test_a_table_that_is_a_spring_moves_as_the_spring(friction, limit, controller, modes):
    if limit == np.inf and controller.anti_windup == "conditional":
        controller = replace(controller, anti_windup=None)
    axis = Axis(2.0, modes=modes, viscous=0.3, friction=friction, torque_limit=limit)
    sprung = replace(axis, spring=7.0)
    table = replace(axis, ripple=slope(7.0, -0.6, 1.4))
    push = TorqueSteps([2.0, 2.5], [4.0, 0.0], on="motor")
    found, expected = (
        ServoLoop(each, controller).respond(MOVE, 0.01, duration=4.0, disturbance=push)
        for each in (table, sprung)
    )
    np.testing.assert_allclose(found.load, expected.load, atol=1e-11)
    np.testing.assert_allclose(found.torque, expected.torque, atol=1e-8)
    assert len(found.friction_events) == len(expected.friction_events)
    for (t, *kinds), (u, *same) in zip(
        found.friction_events, expected.friction_events, strict=True
    ):
        assert t == pytest.approx(u, abs=1e-9)
        assert kinds == same
    assert found.saturated_time == pytest.approx(expected.saturated_time, abs=1e-9)


@pytest.mark.parametrize(
    ("points", "command"),
    [
        (3, Ramp(-0.7, 0.35)), (5, Sine(0.8, 0.4)),
        *([(3, Sine(0.8, 0.4)), (24, Sine(0.8, 0.4)), (24, Ramp(-0.7, 0.35))] if SLOW else []),
    ],
)  # fmt: skip
def test_cogging_over_many_periods_is_the_integral_of_small_steps(points, command):
    ripple = Ripple.sine(3.0, 0.1, phase_deg=20.0, points=points)
    axis = Axis(2.0, viscous=0.3, ripple=ripple)
    times = np.linspace(0.0, 2.0, 41)
    found = ServoLoop(axis, GAINS).respond(command, times=times, duration=2.0)
    start = float(command.derivatives(np.zeros(1), 0)[0, 0])

    def rates(t, x):
        r, rate = command.derivatives(np.array([t]), 1)[:, 0]
        u = 300.0 * (r - x[0]) + 600.0 * x[2] + 40.0 * (rate - x[1])
        return [x[1], (u - 0.3 * x[1] + float(ripple(x[0]))) / 2.0, r - x[0]]

    preload = -float(ripple(start)) / 600.0
    solved = solve_ivp(
        rates, (0.0, 2.0), [start, 0.0, preload], "DOP853", times,
        rtol=1e-10, atol=1e-12, max_step=1e-3,
    )  # fmt: skip
    np.testing.assert_allclose(found.position, solved.y[0], atol=1e-8)
    assert abs(found.position[-1] - start) < 1.5
    bare = ServoLoop(replace(axis, ripple=None), GAINS).respond(command, times=times, duration=2.0)
    assert abs(bare.position - found.position).max() > 1e-4


def test_a_motor_stays_in_the_valley_of_its_cogging():
    """Uncontrolled but for a small gain, it is held where −slope·x balances the push."""
    axis = Axis(1.0, viscous=5.0, ripple=Ripple.sine(-10.0, 0.2, points=32))
    loop = ServoLoop(axis, PID(1e-6, 0.0, 1e-6))
    pushed = loop.respond(Ramp(0.0), 0.1, duration=20.0, disturbance=TorqueSteps([0.0], [3.0]))
    at = pushed.position[-1]
    assert float(axis.ripple(at)) == pytest.approx(-3.0, abs=1e-4)
    away = loop.respond(Ramp(0.0), 0.1, duration=20.0, disturbance=TorqueSteps([0.0], [12.0]))
    assert away.position[-1] > 5.0  # pushed over all hills


def test_it_starts_held_where_it_stands():
    axis = Axis(2.0, ripple=Ripple.sine(3.0, 0.1, phase_deg=90.0), constant_load=1.0)
    for place in (0.0, 0.37, -5.21):
        for controller in CONTROLLERS[::2]:
            controller = replace(controller, anti_windup=None)
            rest = ServoLoop(axis, controller).respond(Ramp(0.0, place), 0.01, duration=0.5)
            np.testing.assert_allclose(rest.position, place, atol=1e-12)
            expected = -1.0 - float(axis.ripple(place))
            np.testing.assert_allclose(rest.torque, expected, atol=1e-9)


def test_a_table_repeats():
    ripple = Ripple([0.02, 0.05, 0.09], [1.0, -2.0, 0.5], period=0.1)
    at = np.linspace(-0.3, 0.3, 1001)
    np.testing.assert_allclose(ripple(at), ripple(at + 0.1), atol=1e-12)
    lines, edges = ripple.lines(), ripple.edges
    for x in (0.03, 0.06, 0.095, 0.101, -0.27):
        offset, rise = lines[ripple.cell(x)]
        inside = x - ripple.turns_before(x)
        assert edges[ripple.cell(x)] <= inside <= edges[ripple.cell(x) + 1]
        assert offset + rise * inside == pytest.approx(float(ripple(x)), abs=1e-12)
    assert Axis(1.0, ripple=ripple).is_nonlinear
    assert Axis(1.0, ripple=ripple).transfer()(2j) == pytest.approx(Inertia(1.0).transfer()(2j))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Ripple([0.0, 1.0], [1.0, 2.0], period=1.0), "over less than the period"),
        (lambda: Ripple([0.5, 0.2], [1.0, 2.0], period=1.0), "numbers that increase"),
        (lambda: Ripple([0.5], [1.0], period=1.0), "expected 2 to 32 points"),
        (lambda: Ripple([0.0, 0.5], [1.0, np.nan], period=1.0), "expected finite"),
        (lambda: Ripple([0.0, 0.5], [1.0, 2.0], period=0.0), "period = 0.0"),
        (lambda: Ripple.sine(1.0, 0.1, points=100), "points = 100"),
    ],
)
def test_what_no_ripple_is_gets_one_line(make, words):
    with pytest.raises(ValueError, match=words) as refusal:
        make()
    assert "\n" not in str(refusal.value)
