"""The servo loop with a flexible plant: two bodies integrated, nulls of the command."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from servo_loops import GAINS, MOMENT, MOVE, flexible, loop_with

from jounce.plant import (
    InertiaFeedforward,
    ServoLoop,
)
from jounce.shaping import JerkFilter, Limits, Trajectory, min_time_move

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
