"""The servo loop: identities at random frequencies, exact responses, published numbers."""

from itertools import pairwise
from math import inf, log, nan, pi

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references import RESPONSE, move_text
from scipy.integrate import solve_ivp
from strategies import MAGNITUDES, bound_lists

from jounce.plant import (
    PID,
    FlexibleInertia,
    Inertia,
    InertiaFeedforward,
    LoopResponse,
    ServoLoop,
    design_pid,
    filter_system,
    respond,
)
from jounce.shaping import JerkFilter, Limits, Trajectory, min_jerk_move, min_time_move

FEW = settings(max_examples=settings.default.max_examples // 2)
MOMENT = 2.5
GAINS = design_pid(MOMENT, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
MOVE = min_time_move(1.0, Limits(velocity=0.5, acceleration=1.0, jerk=4.0))
"""Its breaks are multiples of 1/4, so that its acceleration is linear between samples."""


def loop_with(estimate=None, gains=GAINS, moment=MOMENT):
    feedforward = None if estimate is None else InertiaFeedforward(estimate)
    return ServoLoop(Inertia(moment), gains, feedforward)


def random_loop(seed):
    """Return a stable loop, and its g, k and f as functions of s."""
    rng = np.random.default_rng(seed)
    moment, estimate = 10.0 ** rng.uniform(-3, 3, 2)
    gains = design_pid(
        moment,
        crossover_hz=10.0 ** rng.uniform(-1, 1),
        phase_margin_deg=rng.uniform(20, 80),
        lower_gain_margin_db=rng.uniform(3, 20),
    )
    blocks = (
        lambda s: 1 / (moment * s**2),
        lambda s: gains.kp + gains.ki / s + gains.kr * s,
        lambda s: estimate * s**2,
    )
    return loop_with(estimate, gains, moment), *blocks


# Transfer functions


@given(seed=st.integers(0, 2**32 - 1), omega=MAGNITUDES)
def test_transfer_functions_are_the_formulas(seed, omega):
    loop, g, k, f = random_loop(seed)
    s = 1j * omega
    expected = g(s) * k(s)
    assert loop.loop_transfer()(s) == pytest.approx(expected, rel=1e-12), (seed, omega)
    size = (abs(g(s) * k(s)) + abs(g(s) * f(s))) / abs(1 + expected)
    closed = g(s) * (k(s) + f(s)) / (1 + expected)
    assert loop.closed_loop()(s) == pytest.approx(closed, abs=1e-12 * size), (seed, omega)


@given(seed=st.integers(0, 2**32 - 1), omega=MAGNITUDES)
def test_the_interconnection_is_the_closed_loop(seed, omega):
    """Fed with r, jω·r and −ω²·r it gives y/r, e/r = 1 − y/r and u/r = J·s²·y/r."""
    loop, g, k, f = random_loop(seed)
    s = 1j * omega
    y, e, u = loop.system()(s) @ [1.0, s, s**2]
    inner = g(s) * k(s)
    size = (1 + abs(inner) + abs(g(s) * f(s))) / abs(1 + inner) + 1.0
    closed = g(s) * (k(s) + f(s)) / (1 + inner)
    assert y == pytest.approx(closed, abs=1e-11 * size), (seed, omega)
    assert y == pytest.approx(loop.closed_loop()(s), abs=1e-11 * size), (seed, omega)
    assert e == pytest.approx(1 - closed, abs=1e-11 * size), (seed, omega)
    torque = abs(1 / g(s)) + abs(k(s)) + abs(f(s))  # what a rounding of y is worth
    assert u == pytest.approx(closed / g(s), abs=1e-11 * size * torque), (seed, omega)


@pytest.mark.parametrize("gains", [GAINS, PID(1.0, 2.0, 3.0), PID(4.0, 0.0, 1.0)])
@pytest.mark.parametrize("moment", [1e-6, 0.1, MOMENT, 1e7])
def test_perfect_feedforward_makes_the_closed_loop_one(gains, moment):
    closed = loop_with(moment, gains, moment).closed_loop()
    np.testing.assert_array_equal(closed.num_array[0, 0], closed.den_array[0, 0])
    assert closed(0.3j) == pytest.approx(1.0, rel=1e-14)


def test_no_feedforward_is_feedforward_of_nothing():
    none, zero = loop_with().closed_loop(), loop_with(0.0).closed_loop()
    assert none(2j) == zero(2j)
    np.testing.assert_array_equal(loop_with().system().D, loop_with(0.0).system().D)


def test_a_loop_without_controller_has_the_feedforward_alone():
    closed = loop_with(1.0, PID(0.0, 0.0, 0.0)).closed_loop()
    assert closed(3j) == pytest.approx(1.0 / MOMENT, rel=1e-14)


def test_signals_have_one_vocabulary():
    loop = loop_with(1.0)
    assert loop.system().input_labels == ["r", "r_rate", "r_acceleration"]
    assert loop.system().output_labels == ["y", "e", "u"]
    assert loop.system().name == "servo_loop"
    assert loop.system().nstates == 3
    for transfer, source, name in (
        (loop.loop_transfer(), "e", "loop"),
        (loop.closed_loop(), "r", "closed_loop"),
    ):
        assert (transfer.input_labels, transfer.output_labels) == ([source], ["y"])
        assert transfer.name == name


def step_overshoot(loop):
    """Return the largest value of the unit-step response above 1, from poles and residues."""
    closed = loop.closed_loop()
    numerator, denominator = closed.num_array[0, 0], closed.den_array[0, 0]
    poles = np.roots(denominator)
    residues = np.polyval(numerator, poles) / np.polyval(np.polyder(denominator), poles) / poles
    t = np.linspace(0.0, 3.0, 300_001)
    return (residues[:, None] * np.exp(poles[:, None] * t)).sum(axis=0).real.max()


def test_the_designed_loop_overshoots_a_unit_step_by_39_85_percent():
    assert step_overshoot(loop_with()) == pytest.approx(0.3985, abs=5e-5)


def test_the_printed_gains_overshoot_by_21_5_percent():
    kr = 11.09 * MOMENT
    assert step_overshoot(loop_with(None, PID(3.187 * kr, 6.286 * kr, kr))) == pytest.approx(
        0.215, abs=5e-4
    )


# Responses


@FEW
@given(
    bounds=bound_lists(min_order=2),
    seed=st.integers(0, 2**32 - 1),
    sign=st.sampled_from([-1.0, 1.0]),
    step=st.sampled_from([0.003, 0.0471, 0.3]),
)
def test_perfect_feedforward_leaves_no_error_whatever_the_gains(bounds, seed, sign, step):
    rng = np.random.default_rng(seed)
    moment = 10.0 ** rng.uniform(-3, 3)
    move = min_time_move(sign, Limits.from_bounds(bounds), method="closed-form")
    unit = 2 * pi / move.duration
    gains = PID(*(moment * rng.uniform(0.1, 5.0, 3) * [unit**2, 0.1 * unit**3, unit]))
    dt = step * move.duration
    response = loop_with(moment, gains, moment).respond(move, dt)
    text = f"{gains}, J={moment!r}, {move_text(sign, bounds)}, dt={dt!r}"
    assert np.abs(response.error).max() <= 1e-12, text
    np.testing.assert_allclose(
        response.position, move(response.time), rtol=0, atol=1e-12, err_msg=text
    )
    feedback = max(gains.kp, gains.ki * move.duration, gains.kr / move.duration)
    slack = 1e-12 * (moment * move.peak(2) + feedback)
    needed = moment * move(response.time, 2)
    if move.order > 2:  # at order 2 torque jumps with the acceleration, at breaks on the grid
        np.testing.assert_allclose(response.torque, needed, rtol=0, atol=slack, err_msg=text)


@pytest.mark.parametrize("estimate", [0.0, 0.9 * MOMENT, 1.3 * MOMENT])
def test_the_error_of_a_wrong_estimate_is_that_of_the_missing_torque(estimate):
    """E = (J − Ĵ)·s/(J·s³ + kr·s² + kp·s + ki) of the acceleration, which is linear here."""
    response = loop_with(estimate).respond(MOVE, 2.0**-7, duration=6.0)
    transfer = control.tf([MOMENT - estimate, 0.0], [MOMENT, GAINS.kr, GAINS.kp, GAINS.ki])
    reference = control.forced_response(transfer, response.time, MOVE(response.time, 2))
    peak = np.abs(reference.outputs).max()
    assert peak > 1e-3
    np.testing.assert_allclose(response.error, reference.outputs, rtol=0, atol=RESPONSE * peak)
    torque = control.tf(
        np.polyadd([estimate, 0, 0, 0], [GAINS.kr, GAINS.kp, GAINS.ki]),
        [MOMENT, GAINS.kr, GAINS.kp, GAINS.ki],
    ) * MOMENT  # fmt: skip
    reference = control.forced_response(torque, response.time, MOVE(response.time, 2))
    peak = np.abs(reference.outputs).max()
    np.testing.assert_allclose(response.torque, reference.outputs, rtol=0, atol=RESPONSE * peak)


def test_the_error_is_linear_in_the_estimate():
    errors = {
        x: loop_with((1.0 + x) * MOMENT).respond(MOVE, 0.01, duration=5.0).error
        for x in (-0.5, -0.01, 0.01, 1.0)
    }
    unit = errors[1.0]
    assert np.abs(unit).max() > 1e-3
    for x, error in errors.items():
        np.testing.assert_allclose(error, x * unit, rtol=0, atol=1e-12 * np.abs(unit).max())


@pytest.mark.parametrize("order", [2, 3, 6])
@pytest.mark.parametrize("estimate", [0.0, MOMENT, 2.0])
def test_momentum_balances_the_torque(order, estimate):
    """∫u dt = J·Δv over every piece, by Gauss's rule."""
    move = min_time_move(
        1.0, Limits.from_bounds([0.5, 1.0, 4.0, None, None, 4096.0][:order]), method="closed-form"
    )
    loop = loop_with(estimate)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for left, right in pairwise(move.breaks):
        half = 0.5 * (right - left)
        torque = [value_at(loop, move, left + half * (1 + node)) for node in nodes]
        change = value_at(loop, move, right, 1) - value_at(loop, move, left, 1)
        assert half * weights @ torque == pytest.approx(MOMENT * change, abs=1e-11), (left, right)


def value_at(loop, move, t, state=None):
    """Return the torque, or a state, at one time."""
    if t == 0.0:
        response, i = loop.respond(move, 1.0), 0
    else:
        response, i = loop.respond(move, t, duration=t), 1
    return response.torque[i] if state is None else response.states[state, i]


@pytest.mark.parametrize("estimate", [None, 2.0, MOMENT])
@pytest.mark.parametrize("start", [0.0, -3.0, 1e3])
def test_the_loop_starts_at_rest_where_the_trajectory_does(estimate, start):
    here = loop_with(estimate).respond(MOVE.shift(start), 0.01, duration=4.0)
    zero = loop_with(estimate).respond(MOVE, 0.01, duration=4.0)
    slack = 1e-12 * max(1.0, abs(start))
    assert here.position[0] == here.command[0] == start
    assert here.states[0, 0] == start
    np.testing.assert_allclose(here.position - start, zero.position, rtol=0, atol=slack)
    np.testing.assert_allclose(here.error, zero.error, rtol=0, atol=slack)
    np.testing.assert_allclose(here.states[0], here.position, rtol=0, atol=slack)


@pytest.mark.parametrize("delay", [-0.7, 20.0])
def test_a_delayed_trajectory_gives_a_delayed_response(delay):
    later = loop_with(2.0).respond(MOVE.delay(delay), 0.01, duration=4.0)
    now = loop_with(2.0).respond(MOVE, 0.01, duration=4.0)
    np.testing.assert_allclose(later.time - delay, now.time, rtol=0, atol=1e-14)
    np.testing.assert_allclose(later.outputs, now.outputs, rtol=0, atol=1e-11)


@pytest.mark.parametrize("dt", [1e-6, 0.0173, 0.4])
@pytest.mark.parametrize("jerk_filter", [None, JerkFilter(3.0, 4)])
def test_dt_does_not_change_values(dt, jerk_filter):
    """At 1e-6 the loop's inputs differ by 1e12 in units of dt."""
    loop = loop_with(2.0)
    fine = loop.respond(MOVE, dt, duration=min(50_000 * dt, 5.0), jerk_filter=jerk_filter)
    peaks = np.abs(fine.outputs).max(axis=1)
    for i in (fine.time.size - 1, fine.time.size // 2):
        t = i * dt
        once = loop.respond(MOVE, t, duration=t, jerk_filter=jerk_filter)
        assert (np.abs(once.outputs[:, 1] - fine.outputs[:, i]) <= 1e-11 * peaks).all(), t


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_time_changes_nothing(unit):
    faster = PID(GAINS.kp / unit**2, GAINS.ki / unit**3, GAINS.kr / unit)
    one = loop_with(2.0).respond(MOVE, 0.01, duration=4.0)
    other = loop_with(2.0, faster).respond(MOVE.stretch(unit), 0.01 * unit, duration=4.0 * unit)
    expected = one.outputs / np.array([[1.0], [1.0], [unit**2]])
    peaks = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(other.outputs / peaks, expected / peaks, rtol=0, atol=1e-11)


def test_the_loop_is_respond_of_its_system():
    ours = loop_with(2.0).respond(MOVE, 0.013, duration=4.0)
    theirs = respond(loop_with(2.0).system(), MOVE, 0.013, derivatives=(0, 1, 2), duration=4.0)
    for name in ("time", "inputs", "outputs", "states"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=0, atol=1e-13)


def test_the_signals_of_a_response():
    response = loop_with(2.0).respond(MOVE, 0.01, duration=3.0)
    np.testing.assert_array_equal(response.command, MOVE(response.time))
    np.testing.assert_allclose(response.inputs, MOVE.evaluate(response.time, 2), atol=1e-14)
    np.testing.assert_allclose(response.error, response.command - response.position, atol=1e-13)
    assert response.outputs.shape == (3, 301)
    assert response.states.shape == (3, 301)
    np.testing.assert_array_equal(
        [response.position, response.error, response.torque], response.outputs
    )


# Behind a jerk filter


@pytest.mark.parametrize("order", [2, 3, 6])
@pytest.mark.parametrize("filter_order", [1, 2, 4, 6])
@pytest.mark.parametrize("corner", [0.5, 20.0])
def test_perfect_feedforward_passes_the_filtered_command_on(order, filter_order, corner):
    move = min_time_move(
        -2.0, Limits.from_bounds([0.5, 1.0, 4.0, 30.0, 4e2, 4e3][:order]), method="closed-form"
    )
    jerk_filter = JerkFilter(corner, filter_order)
    length = move.duration + jerk_filter.settling_time(1e-6)
    response = loop_with(MOMENT).respond(move, 0.01, duration=length, jerk_filter=jerk_filter)
    filtered = jerk_filter.respond(move, 0.01)
    np.testing.assert_allclose(response.position, filtered.states[0], rtol=0, atol=2e-12)
    np.testing.assert_allclose(response.command, filtered.states[0], rtol=0, atol=2e-12)
    assert np.abs(response.error).max() <= 2e-12
    torque = MOMENT * filtered.states[2] if filter_order > 1 else response.torque
    np.testing.assert_allclose(response.torque, torque, rtol=0, atol=1e-11 * np.abs(torque).max())


@pytest.mark.parametrize("filter_order", [3, 6])
@pytest.mark.parametrize("estimate", [None, 2.0])
def test_filter_and_loop_are_the_system_in_series(filter_order, estimate):
    """Fed with the velocity of an order-2 move, which is linear, through an integrator."""
    move = min_time_move(2.0, Limits(velocity=1.0, acceleration=2.0))
    np.testing.assert_allclose(move.breaks * 4, np.round(move.breaks * 4), atol=1e-14)
    jerk_filter, loop = JerkFilter(1.5, filter_order), loop_with(estimate)
    integrator = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]])
    series = loop.system() * filter_system(jerk_filter, derivatives=2) * integrator
    response = loop.respond(move, 2.0**-7, duration=6.0, jerk_filter=jerk_filter)
    reference = control.forced_response(series, response.time, move(response.time, 1))
    peaks = np.abs(reference.outputs).max(axis=1, keepdims=True)
    np.testing.assert_allclose(
        response.outputs / peaks, reference.outputs / peaks, rtol=0, atol=RESPONSE
    )


@pytest.mark.parametrize("start", [-3.0, 7.0])
def test_behind_a_filter_the_loop_still_starts_at_rest(start):
    response = loop_with(2.0).respond(
        MOVE.shift(start).delay(1.0), 0.01, jerk_filter=JerkFilter(2.0, 6), duration=6.0
    )
    zero = loop_with(2.0).respond(MOVE, 0.01, jerk_filter=JerkFilter(2.0, 6), duration=6.0)
    assert response.position[0] == response.command[0] == start
    assert response.time[0] == 1.0
    np.testing.assert_allclose(response.position - start, zero.position, rtol=0, atol=1e-12)


# A flexible plant


def flexible(sensor="motor", frequency=10.0, damping=0.01, fraction=0.4):
    return FlexibleInertia(MOMENT, frequency, damping, load_fraction=fraction, sensor=sensor)


FLEXIBLE = {
    "motor": ServoLoop(flexible(), GAINS, InertiaFeedforward(MOMENT)),
    "load": ServoLoop(flexible("load", 40.0, 0.03), GAINS, InertiaFeedforward(MOMENT)),
    "wrong estimate": ServoLoop(flexible(), GAINS, InertiaFeedforward(2.0)),
    "no feedforward": ServoLoop(flexible(fraction=0.7), GAINS),
}
EVERY_FLEXIBLE = pytest.mark.parametrize("loop", list(FLEXIBLE.values()), ids=list(FLEXIBLE))


def two_bodies(loop):
    """Return J_motor, J_load, k, c, and what is measured as a sum of motor and load."""
    axis = loop.plant
    motor, load = (1 - axis.load_fraction) * axis.J, axis.load_fraction * axis.J
    reduced, omega = motor * load / axis.J, 2 * pi * axis.frequency_hz
    seen = np.array([1.0, 0.0] if axis.sensor == "motor" else [0.0, 1.0])
    return motor, load, reduced * omega**2, 2 * axis.damping * omega * reduced, seen


def polynomials(loop):
    """Return y/r and y_load/r times the common denominator, and that, by Cramer's rule."""
    motor, load, k, c, seen = two_bodies(loop)
    on_motor, on_load = np.array([load, c, k]), np.array([c, k])
    total = np.polyadd(np.polymul([motor, 0, 0], [load, 0, 0]), [MOMENT * c, MOMENT * k, 0, 0])
    measured = np.polyadd(seen[0] * on_motor, seen[1] * on_load)
    gains, estimate = loop.controller, loop.feedforward.J_hat if loop.feedforward else 0.0
    pid = [gains.kr, gains.kp, gains.ki]
    drive = np.polyadd([estimate, 0, 0, 0], pid)
    characteristic = np.polyadd(np.polymul(total, [1, 0]), np.polymul(measured, pid))
    return np.polymul(measured, drive), np.polymul(on_load, drive), characteristic


@EVERY_FLEXIBLE
@pytest.mark.parametrize("omega", [0.01, 1.7, 40.0, 62.8, 900.0])
def test_transfer_functions_with_a_flexible_plant(loop, omega):
    s = 1j * omega
    y, on_load, characteristic = (np.polyval(p, s) for p in polynomials(loop))
    size = 1e-10 * (1 + abs(y / characteristic))
    assert loop.closed_loop()(s) == pytest.approx(y / characteristic, abs=size)
    found = loop.system()(s) @ [1.0, s, s**2]
    assert found[0] == pytest.approx(y / characteristic, abs=size)
    assert found[1] == pytest.approx(1 - y / characteristic, abs=size)
    assert found[3] == pytest.approx(on_load / characteristic, abs=size)
    g, k = loop.plant.transfer()(s), loop.controller.transfer()(s)
    assert loop.loop_transfer()(s) == pytest.approx(g * k, rel=1e-12)


@EVERY_FLEXIBLE
def test_a_flexible_loop_integrated_as_two_bodies(loop):
    motor, load, k, c, seen = two_bodies(loop)
    gains, estimate = loop.controller, loop.feedforward.J_hat if loop.feedforward else 0.0

    def forces(t, x):
        r = MOVE.evaluate(np.array([min(max(t, left), right)]), 2)[:, 0] if t < end else coasting
        e, e_rate = r[0] - seen @ x[:2], r[1] - seen @ x[2:4]
        u = gains.kp * e + gains.ki * x[4] + gains.kr * e_rate + estimate * r[2]
        link = k * (x[1] - x[0]) + c * (x[3] - x[2])
        return np.array([x[2], x[3], (u + link) / motor, -link / load, e]), u

    end, coasting = MOVE.duration, np.array([1.0, 0.0, 0.0])
    dt, length, state = 0.05, 4.0, np.zeros(5)
    response = loop.respond(MOVE, dt, duration=length)
    stops = np.unique(np.concatenate([MOVE.breaks, response.time]).round(12))
    for left, right in pairwise(stops):
        i = round(left / dt)
        if abs(left - response.time[i]) < 1e-9:
            _, u = forces(left, state)
            y = seen @ state[:2]
            found = [response.position[i], response.load[i], response.twist[i], response.torque[i]]
            expected = [y, state[1], state[1] - state[0], u]
            slack = 2e-9 * np.array([1.0, 1.0, 1.0, 100.0])
            assert (np.abs(np.subtract(found, expected)) <= slack).all(), left
            assert response.error[i] == pytest.approx(response.command[i] - y, abs=1e-9)
        state = solve_ivp(
            lambda t, x: forces(t, x)[0], (left, right), state,
            method="DOP853", rtol=1e-11, atol=1e-13,
        ).y[:, -1]  # fmt: skip
    assert np.abs(response.twist).max() > 1e-5


@EVERY_FLEXIBLE
@pytest.mark.parametrize("jerk_filter", [None, JerkFilter(3.0, 4)])
def test_a_flexible_loop_starts_at_rest_where_the_trajectory_does(loop, jerk_filter):
    here = loop.respond(MOVE.shift(-30.0), 0.01, duration=4.0, jerk_filter=jerk_filter)
    zero = loop.respond(MOVE, 0.01, duration=4.0, jerk_filter=jerk_filter)
    assert here.position[0] == here.load[0] == here.command[0] == -30.0
    for name in ("position", "load", "command"):
        shifted = getattr(here, name) + 30.0
        np.testing.assert_allclose(shifted, getattr(zero, name), rtol=0, atol=1e-10)
    for name in ("error", "twist", "torque"):
        peak = np.abs(getattr(zero, name)).max()
        np.testing.assert_allclose(
            getattr(here, name), getattr(zero, name), rtol=0, atol=1e-9 * max(peak, 1.0)
        )


def test_a_flexible_loop_names_what_it_shows():
    loop = FLEXIBLE["motor"]
    assert loop.system().output_labels == ["y", "e", "u", "y_load", "twist"]
    assert loop.system().input_labels == ["r", "r_rate", "r_acceleration"]
    response = loop.respond(MOVE, 0.01)
    np.testing.assert_array_equal(response.outputs[3:], [response.load, response.twist])
    assert loop.system().state_labels[2] == "plant_twist"
    np.testing.assert_allclose(response.states[2], response.twist, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        response.load, response.position + response.twist, rtol=0, atol=1e-13
    )
    measured = FLEXIBLE["load"].respond(MOVE, 0.01)
    np.testing.assert_allclose(measured.load, measured.position, rtol=0, atol=1e-13)


def test_a_rigid_axis_carries_its_load_along():
    response = loop_with(2.0).respond(MOVE, 0.01)
    np.testing.assert_array_equal(response.load, response.position)
    np.testing.assert_array_equal(response.twist, np.zeros(response.time.size))


def test_a_very_stiff_axis_is_rigid():
    stiff = ServoLoop(flexible(frequency=1e4, damping=0.1), GAINS, InertiaFeedforward(2.0))
    response, rigid = (x.respond(MOVE, 0.01, duration=4.0) for x in (stiff, loop_with(2.0)))
    np.testing.assert_allclose(response.position, rigid.position, rtol=0, atol=1e-7)
    assert 0.0 < np.abs(response.twist).max() < 1e-8


# Vibration after a move


def zero_vibration(move, pole):
    """Return a move split in two, half a period apart: its spectrum is zero at the pole."""
    half = pi / abs(pole.imag)
    second = np.exp(-abs(pole.real) * half)
    later, weights = move.delay(half), np.array([1.0, second]) / (1.0 + second)
    breaks = np.unique(np.concatenate([move.breaks, later.breaks]))
    both = [part.evaluate(breaks[:-1], move.order) for part in (move, later)]
    return Trajectory(breaks, (weights[0] * both[0] + weights[1] * both[1]).T)


def velocity_spectrum(move, s):
    """Return ∫ v(t)·e^(−st) dt by Gauss's rule on each piece."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    total = 0.0
    for left, right in pairwise(move.breaks):
        t = left + 0.5 * (right - left) * (1 + nodes)
        total += 0.5 * (right - left) * np.sum(weights * move(t, 1) * np.exp(-s * t))
    return total


def vibration(response, signal, move, poles):
    """Return the amplitudes of the closed loop's modes in a signal at the move's end.

    By least squares on what that signal does after it.
    """
    after = response.time >= move.duration
    modes = np.exp(poles * (response.time[after] - move.duration)[:, None])
    swing = getattr(response, signal)[after] - move.end_state[0]
    amplitudes, *_ = np.linalg.lstsq(modes, swing.astype(complex), rcond=None)
    assert np.abs(modes @ amplitudes - swing).max() <= 1e-11
    return np.abs(amplitudes)


@EVERY_FLEXIBLE
def test_a_null_of_the_command_at_the_closed_loops_pole_leaves_no_vibration(loop):
    """The mode p rings with V(p)·e^(pT) times the residue of (y/r)/s, or (y_load/r)/s, at p."""
    *numerators, characteristic = polynomials(loop)
    poles = np.roots(characteristic)
    light = int(np.argmax(np.where(poles.imag > 0, -poles.imag / poles.real, -np.inf)))
    pole = poles[light]
    slope = pole * np.polyval(np.polyder(characteristic), pole)
    period = 2 * pi / pole.imag
    plain, tuned = (
        min_time_move(1.0, Limits(velocity=2.0, acceleration=20.0, jerk=20.0 / (x * period)))
        for x in (1.4, 1.0)
    )
    found = {"position": [], "load": []}
    for move in (plain, tuned, zero_vibration(plain, pole)):
        response = loop.respond(move, 1e-3, duration=move.duration + 2.0)
        excited = velocity_spectrum(move, pole) * np.exp(pole * move.duration) / slope
        for signal, numerator in zip(found, numerators, strict=True):
            amplitude = vibration(response, signal, move, poles)[light]
            expected = abs(excited * np.polyval(numerator, pole))
            assert amplitude == pytest.approx(expected, rel=1e-7, abs=1e-13), signal
            found[signal].append(amplitude)
    for before, jerk_for_one_period, null in found.values():
        assert before > 1e-6
        assert jerk_for_one_period < 0.5 * before  # its null is beside the pole, on the axis
        assert null < 1e-9 * before


# Sampled


SAMPLED = {
    "rigid": loop_with(),
    "motor": ServoLoop(flexible(frequency=6.0), GAINS),
    "load": ServoLoop(flexible("load", 40.0, 0.03), GAINS),
}
EVERY_SAMPLED = pytest.mark.parametrize("loop", list(SAMPLED.values()), ids=list(SAMPLED))
RATES = pytest.mark.parametrize("rate", ["measured", "differenced"])


@EVERY_SAMPLED
@RATES
def test_sampled_ever_faster_the_loop_becomes_the_continuous_one(loop, rate):
    """A hold delays by half a sample, so L(e^(jω·dt)) − L(jω) falls with dt."""
    for omega in (2.0, 2 * pi, 20.0):
        expected = loop.loop_transfer()(1j * omega)
        errors = []
        for dt in (1e-3, 1e-4, 1e-5):
            sampled = loop.sampled_loop_transfer(dt, delay=0.3 * dt, rate=rate)
            errors.append(abs(sampled(np.exp(1j * omega * dt)) / expected - 1))
        np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.1)
        assert errors[-1] < 2e-5 * omega


@EVERY_SAMPLED
@RATES
@pytest.mark.parametrize("delay", [0.0, 0.013, 0.02, 0.047])
def test_the_sampled_loop_is_the_digital_controller_times_the_sum_of_aliases(loop, rate, delay):
    """Σ_k P(s_k)·e^(−s_k·τ)·(1 − e^(−s_k·dt))/(s_k·dt), cut where |s²·P| has settled."""
    dt, terms = 0.02, 100_000
    gains, g = loop.controller, loop.plant.transfer()
    numerator, denominator = g.num_array[0, 0], g.den_array[0, 0]
    sampled = loop.sampled_loop_transfer(dt, delay=delay, rate=rate)
    assert sampled.dt == dt
    for omega in (1.0, 2 * pi, 100.0):
        z = np.exp(1j * omega * dt)
        s = 1j * (omega + 2 * pi / dt * np.arange(-terms, terms + 1))
        p = np.polyval(numerator, s) / np.polyval(denominator, s)
        held = np.exp(-s * delay) * (1 - 1 / z) / (s * dt)
        left_out = 2 * abs(p[0] * s[0] ** 2) * abs(1 - 1 / z) / dt * (dt / 2 / pi) ** 2 / terms
        on_e = gains.kp + gains.ki * dt * z / (z - 1)
        if rate == "measured":
            expected = np.sum((on_e + gains.kr * s) * p * held)
            slack = gains.kr * left_out
        else:
            expected = (on_e + gains.kr * (z - 1) / (dt * z)) * np.sum(p * held)
            slack = left_out * dt / terms * abs(expected)
        assert slack < 1e-4 * abs(expected)
        assert abs(sampled(z) - expected) <= 1.1 * slack + 1e-10 * abs(expected), omega


def simulate(loop, dt, late, rate, samples, parts=4):
    """Return y and y_rate (2, N) of a digital loop let go from rest at y = 1, sample by sample.

    The plant goes on in steps of dt/parts, `late` of which are the delay; the controller is
    written out.
    """
    fine = control.sample_system(loop.plant.system(), dt / parts, "zoh")
    a, b, c = fine.A, fine.B[:, 0], fine.C[:2]
    gains, x, total = loop.controller, np.eye(len(fine.A))[0], 0.0
    queue, past, seen = [0.0] * late, -1.0, []
    for _ in range(samples):
        y, y_rate = c @ x
        total += dt * -y
        slope = -y_rate if rate == "measured" else (-y - past) / dt
        past = -y
        queue += [gains.kp * -y + gains.ki * total + gains.kr * slope] * parts
        for u in queue[:parts]:
            x = a @ x + b * u
        queue = queue[parts:]
        seen.append([y, y_rate])
    return np.array(seen).T


@EVERY_SAMPLED
@RATES
@pytest.mark.parametrize(
    ("dt", "late", "stable"),
    [(0.01, 0, True), (0.01, 7, True), (0.02, 30, False), (0.04, 12, False), (0.5, 0, False)],
)
def test_poles_of_the_sampled_loop_tell_how_a_long_simulation_ends(loop, rate, dt, late, stable):
    sampled = loop.sampled_loop_transfer(dt, delay=dt * late / 4, rate=rate)
    closed = sampled.feedback()
    radius = np.abs(closed.poles()).max()
    samples = int(min(1500, 400 / abs(np.log(radius))))
    seen = simulate(loop, dt, late, rate, samples)
    third = samples // 3
    grown = np.abs(seen[0, -third:]).max() > np.abs(seen[0, third:-third]).max()
    assert bool(radius > 1.0) is bool(grown) is not stable
    x = np.isin(sampled.state_labels, ["y", "e_past"]).astype(float)
    largest = 0.0
    for y, y_rate in seen.T:
        largest = max(largest, abs(y), abs(y_rate) * dt)
        assert abs(x[0] - y) <= 1e-10 * largest
        assert abs(x[1] - y_rate) * dt <= 1e-10 * largest
        x = closed.A @ x


@RATES
def test_the_longest_delay_of_a_sampled_loop_is_that_of_its_phase_margin(rate):
    """45 deg at 1 Hz last for 1/8 of a period, of which the hold takes half a sample."""
    dt = 2.5e-3
    loop = loop_with()

    def stable(delay):
        closed = loop.sampled_loop_transfer(dt, delay=delay, rate=rate).feedback()
        return bool(np.abs(closed.poles()).max() < 1.0)

    assert stable(0.125 - 2 * dt)
    assert not stable(0.125 + 2 * dt)


def test_signals_of_the_sampled_loop():
    loop = SAMPLED["motor"].sampled_loop_transfer(0.01, delay=0.025, rate="differenced")
    assert isinstance(loop, control.StateSpace)
    assert (loop.name, loop.dt) == ("sampled_loop", 0.01)
    assert (loop.input_labels, loop.output_labels) == (["u"], ["u_feedback"])
    axis, past = ["y", "y_rate", "twist", "twist_rate"], ["u_past_1", "u_past_2", "u_past_3"]
    assert loop.state_labels == [*axis, *past, "e_integral", "e_past"]
    rigid = loop_with(None, PID(1.0, 0.0, 2.0)).sampled_loop_transfer(0.01)
    assert rigid.state_labels == ["y", "y_rate"]


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_sampled_loop_does_not_depend_on_the_unit_of_time(unit):
    one = ServoLoop(flexible(), GAINS).sampled_loop_transfer(0.01, delay=0.003)
    axis = FlexibleInertia(MOMENT * unit**2, 10.0 / unit, 0.01, load_fraction=0.4)
    gains = PID(GAINS.kp, GAINS.ki / unit, GAINS.kr * unit)
    other = ServoLoop(axis, gains).sampled_loop_transfer(0.01 * unit, delay=0.003 * unit)
    for angle in (0.01, 0.3, 3.0):
        z = np.exp(1j * angle)
        assert other(z) == pytest.approx(one(z), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"dt": 0.0}, "dt = 0.0: expected a positive"),
        ({"dt": nan}, "dt = nan: expected a positive"),
        ({"delay": -0.1}, "delay = -0.1: expected a number ≥ 0"),
        ({"delay": inf}, "delay = inf: expected a finite"),
        ({"delay": 1e6}, "expected at most 1000; use a larger dt"),
        ({"rate": "guessed"}, "rate = 'guessed': expected 'measured' or 'differenced'"),
    ],
)
def test_how_a_loop_cannot_be_sampled(arguments, message):
    with pytest.raises(ValueError, match=message):
        loop_with().sampled_loop_transfer(**({"dt": 0.1} | arguments))


# Settling time


def curve(position, t):
    outputs = np.array([position, -position, 0.0 * position])
    return LoopResponse(t, np.zeros((3, t.size)), outputs, np.zeros((3, t.size)))


@pytest.mark.parametrize("dt", [0.1, 0.01])
@pytest.mark.parametrize("start", [0.0, -4.0, 30.0])
@pytest.mark.parametrize("tolerance", [0.5, 0.1, 1e-3])
def test_settling_of_an_exponential_is_its_logarithm(dt, start, tolerance):
    t = np.arange(0.0, 12.0, dt)
    response = curve(2.0 - np.exp(-t), start + t)
    assert response.settling_time(2.0, tolerance) == pytest.approx(
        -log(tolerance), abs=dt**2 / 8 + 1e-12
    )


def test_settling_counts_the_last_time_outside():
    t = np.linspace(0.0, 10.0, 100_001)
    response = curve(np.exp(-t) * np.cos(4 * pi * t), t)
    late = t[np.abs(np.exp(-t) * np.cos(4 * pi * t)) > 0.1][-1]
    assert response.settling_time(0.0, 0.1) == pytest.approx(late, abs=1.1e-4)


def test_settling_takes_no_time_or_for_ever():
    t = np.linspace(0.0, 1.0, 11)
    assert curve(np.full(11, 1.05), t).settling_time(1.0, 0.1) == 0.0
    assert curve(t, t).settling_time(0.0, 0.5) == inf
    assert curve(t, t).settling_time(1.0, 0.25) == pytest.approx(0.75)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, nan, inf])
def test_a_settling_tolerance_that_is_not_positive_is_refused(tolerance):
    t = np.linspace(0.0, 1.0, 11)
    with pytest.raises(ValueError, match=f"tolerance = {tolerance!r}: expected a positive"):
        curve(t, t).settling_time(0.0, tolerance)


# Errors


def test_a_trajectory_of_order_1_is_refused_unless_a_filter_smooths_it():
    ramp = min_time_move(1.0, Limits(velocity=1.0))
    message = "acceleration of a trajectory of order 1 is a train of impulses: use .*acceleration"
    with pytest.raises(ValueError, match=message):
        loop_with(1.0).respond(ramp, 0.1)
    with pytest.raises(ValueError, match=r"filter of order 1 behind .* use order 2 or more"):
        loop_with(1.0).respond(ramp, 0.1, jerk_filter=JerkFilter(2.0, 1))


@pytest.mark.parametrize("order", [2, 3, 6])
def test_a_filter_can_be_put_behind_a_velocity_limited_move(order):
    ramp, behind = min_time_move(1.0, Limits(velocity=2.0), start=3.0), JerkFilter(2.0, order)
    loop = ServoLoop(Inertia(2.0), PID(50.0, 70.0, 11.0), InertiaFeedforward(2.0))
    response = loop.respond(ramp, 0.01, duration=4.0, jerk_filter=behind)
    alone = behind.respond(ramp, 0.01, duration=4.0)
    np.testing.assert_allclose(response.inputs, alone.states[:3], atol=1e-12)
    np.testing.assert_allclose(response.error, 0.0, atol=1e-12)


@pytest.mark.parametrize("blocks", [(1.0, None), (None, 2.0), (None, None, 1.0)])
def test_blocks_of_another_kind_are_refused(blocks):
    good = (Inertia(1.0), PID(1.0, 1.0, 1.0), InertiaFeedforward(1.0))
    mixed = [good[i] if block is None else block for i, block in enumerate(blocks)]
    with pytest.raises(TypeError, match=r"= [12]\.0: expected (Inertia|PID)"):
        ServoLoop(*mixed)


@pytest.mark.parametrize("name", ["dt", "duration"])
@pytest.mark.parametrize("value", [0.0, -1.0, nan, inf])
def test_a_dt_or_duration_that_is_not_positive_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a positive"):
        loop_with().respond(MOVE, **({"dt": 0.1, "duration": 1.0} | {name: value}))


def test_loops_are_frozen():
    loop = loop_with(1.0)
    assert loop == loop_with(1.0)
    with pytest.raises(AttributeError):
        loop.plant = Inertia(1.0)


@pytest.mark.parametrize("move", [min_jerk_move(0.0, duration=1.0, start=2.0)])
def test_a_trajectory_without_pieces_leaves_the_loop_at_rest(move):
    response = loop_with(1.0).respond(move, 0.1, duration=2.0)
    np.testing.assert_array_equal(response.position, 2.0)
    np.testing.assert_array_equal(response.torque, 0.0)


def test_a_start_in_motion_is_caught_up_with():
    """The loop starts at rest, so the missing momentum shows up as an error that dies out."""
    ramp = Trajectory([0.0, 30.0], [[0.0, 1.0, 0.0]])
    response = loop_with(MOMENT).respond(ramp, 0.01)
    assert response.error[0] == 0.0
    assert response.error.max() > 0.05
    assert abs(response.error[-1]) < 1e-9
