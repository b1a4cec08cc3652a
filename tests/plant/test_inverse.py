"""Exact inverses against polynomials by hand, impedances, and motion simulated by expm."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.linalg import expm

from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Controller,
    Feedforward,
    FlexibleInertia,
    FlexibleMode,
    Friction,
    Inertia,
    Ramp,
    ServoLoop,
    Sine,
    chain_axis,
    design_pid,
    inverse_feedforward,
    low_frequency_feedforward,
    system_axis,
)
from jounce.plant.inverse_dynamics import InverseDynamics
from jounce.shaping import Limits, min_time_move, perfect_spline

J, LAM, W = 2.0, 0.6, 2 * pi * 20.0
K = LAM * (1 - LAM) * J * W**2


def end_errors(matrices, trajectory, gains):
    """Return the largest error of the last mass at the breaks: free motion under the torque."""
    mass, damping, stiffness = matrices
    n, order = len(mass), trajectory.order
    load = n - 1
    solved = np.linalg.solve(mass, np.column_stack([-stiffness, -damping, np.eye(n)[0]]))
    whole = np.zeros((2 * n + order + 1,) * 2)
    whole[:n, n : 2 * n] = np.eye(n)
    whole[n : 2 * n, : 2 * n] = solved[:, :-1]
    for k, gain in gains.items():
        whole[n : 2 * n, 2 * n + k] = gain * solved[:, -1]
    whole[2 * n :, 2 * n :] = np.diag(np.ones(order), 1)
    x, worst = np.zeros(2 * n), 0.0
    for state, length in zip(trajectory.states, trajectory.durations, strict=True):
        worst = max(worst, abs(x[load] - state[0]))
        x = (expm(whole * length) @ np.concatenate([x, state]))[: 2 * n]
    return max(worst, abs(x[load] - trajectory.end_state[0]))


def chain(masses, springs, viscous, load_viscous=0.0):
    n = len(masses)
    between = np.diff(np.eye(n), axis=0)
    damping = np.zeros((n, n))
    damping[0, 0], damping[-1, -1] = viscous, load_viscous
    return np.diag(masses), damping, between.T @ np.diag(springs) @ between


def test_one_mode_with_friction_on_both_sides_is_the_formula():
    motor, load = 0.5, 0.3
    axis = Axis(J, modes=FlexibleMode(20.0, load_fraction=LAM), viscous=motor, load_viscous=load)
    inverse = inverse_feedforward(axis)
    expected = {
        1: motor + load,
        2: J + motor * load / K,
        3: ((1 - LAM) * J * load + LAM * J * motor) / K,
        4: J / W**2,
    }
    assert dict(inverse.torque) == pytest.approx(expected, rel=1e-9)
    assert dict(inverse.position) == pytest.approx({1: load / K, 2: LAM * J / K}, rel=1e-9)
    move = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=500.0, snap=3e4))
    matrices = chain([(1 - LAM) * J, LAM * J], [K], motor, load)
    assert end_errors(matrices, move, inverse.torque) < 1e-12


@pytest.mark.parametrize("masses", [[1.0, 2.0, 0.5], [0.5, 0.7, 0.3, 1.5]])
def test_a_chain_follows_to_rounding(masses):
    """THEORY: y_{i−1} = y_i + (m_i·y_i″ + k_i·(y_i − y_{i+1}))/k_{i−1}, as polynomials."""
    springs = [800.0, 3000.0, 1500.0][: len(masses) - 1]
    y, after, push = np.array([1.0]), None, np.array([0.0])
    for i in range(len(masses) - 1, 0, -1):
        push = np.polyadd(np.polymul(masses[i], np.polymul(y, [1.0, 0.0, 0.0])), push)
        after, y = y, np.polyadd(y, push / springs[i - 1])
    torque = np.polyadd(np.polymul(y, [masses[0], 0.2, 0.0]), push)
    inverse = inverse_feedforward(chain_axis(masses, springs, viscous=0.2))
    order = 2 * len(masses)
    assert inverse.order == order
    expected = {k: c for k, c in enumerate(torque[::-1]) if c}
    assert dict(inverse.torque) == pytest.approx(expected, rel=1e-8)
    assert inverse.position[2 * len(masses) - 2] == pytest.approx(y[0], rel=1e-8)
    assert after is not None
    move = perfect_spline(0.4, order, 2e6)
    matrices = chain(masses, springs, 0.2)
    assert end_errors(matrices, move, inverse.torque) < 1e-10


def test_any_modal_model_has_the_low_frequency_form():
    modes = [(18.0, 0.9, -0.8), (31.0, 0.6, 0.35), (57.0, 0.4, -0.2)]
    axis = Axis(12.0, modes=[FlexibleMode(f, motor_shape=a, load_shape=b) for f, a, b in modes])
    f, a, b = np.array(modes).T
    low = low_frequency_feedforward(axis)
    snap = -12.0 * (a * b / (2 * pi * f) ** 2).sum()
    ahead = ((a * a - a * b) / (2 * pi * f) ** 2).sum()
    assert dict(low.torque) == pytest.approx({2: 12.0, 4: snap}, rel=1e-8)
    assert dict(low.position) == pytest.approx({2: ahead}, rel=1e-8)
    with pytest.raises(ValueError, match="low_frequency_feedforward") as refusal:
        inverse_feedforward(axis)
    assert "\n" not in str(refusal.value)
    one = Axis(12.0, modes=FlexibleMode(18.0, motor_shape=0.9, load_shape=0.8))
    with pytest.raises(ValueError, match="unstable, with a pole at"):
        inverse_feedforward(Axis(12.0, modes=FlexibleMode(18.0, motor_shape=1.4, load_shape=-1.3)))
    assert len(low_frequency_feedforward(one).torque) == 2


def test_a_damped_mode_needs_more_derivatives_the_nearer_it_is_to_come():
    """c·ẋ + k·x = −λ·J·r̈ for the twist: its series in c/k, and what is left of a smooth move."""
    axis = FlexibleInertia(J, 20.0, 0.02, load_fraction=LAM)
    ratio = 2 * 0.02 / W
    low = low_frequency_feedforward(axis, order=5)
    assert low.torque[4] == pytest.approx(J / W**2, rel=1e-9)
    assert low.torque[5] == pytest.approx(-J / W**2 * ratio, rel=1e-6)
    assert low.position[3] == pytest.approx(-LAM * J / K * ratio, rel=1e-6)
    mass, _, stiffness = chain([(1 - LAM) * J, LAM * J], [K], 0.0)
    matrices = (mass, ratio * stiffness, stiffness)
    move = perfect_spline(0.4, 8, 1e9)
    left = [
        end_errors(matrices, move, low_frequency_feedforward(axis, order=n).torque)
        for n in (2, 4, 5, 6)
    ]
    assert left[1] < 0.05 * left[0]
    assert left[3] < left[2] < 0.1 * left[1]


@pytest.mark.parametrize("sensor", ["motor", "load"])
@pytest.mark.parametrize("law", [PID(3e3, 9e3, 3e2), CascadedPI(10.0, 300.0, 0.3)])
def test_in_the_loop_the_controller_has_nothing_to_do(law, sensor):
    axis = Axis(
        J,
        modes=FlexibleMode(20.0, load_fraction=LAM),
        viscous=0.5,
        load_viscous=0.3,
        spring=4.0,
        sensor=sensor,
    )
    if sensor == "load":
        law = PID(30.0, 30.0, 8.0) if isinstance(law, PID) else CascadedPI(1.0, 8.0, 3.0)
    inverse = inverse_feedforward(axis, controller=law)
    move = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=500.0, snap=3e4))
    response = ServoLoop(axis, law, inverse).respond(move, 0.01)
    assert response.peak_load_error < 1e-11


def test_a_cascade_on_two_encoders_follows_exactly():
    axis = Axis(J, modes=FlexibleMode(20.0, load_fraction=LAM), viscous=0.5, sensor="both")
    law = CascadedPI(10.0, 300.0, 0.3, velocity_feedforward=0.6)
    move = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=500.0, snap=3e4))
    exact = ServoLoop(axis, law, inverse_feedforward(axis, controller=law)).respond(move, 0.01)
    unaware = ServoLoop(axis, law, inverse_feedforward(axis)).respond(move, 0.01)
    assert exact.peak_load_error < 1e-11
    assert unaware.peak_load_error > 1e-4


def test_a_telescope_axis_settles_in_a_third_of_the_time():
    """3.5 deg with a mode of 6 Hz, motor held, 1 % damping, half of the load; 1 Hz PID; 50 mas."""
    axis = Axis(1000.0, modes=FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True))
    pid = design_pid(1000.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
    move = min_time_move(3.5, Limits(velocity=10.5, acceleration=10.5, jerk=42.0, snap=600.0))

    def settled(feedforward):
        loop = ServoLoop(axis, pid, feedforward)
        response = loop.respond(move, duration=8.0, times=[0.0, 8.0])
        return response.settling_time(3.5, 0.05 / 3600, of="load")

    undamped = Axis(1000.0, modes=FlexibleMode(6.0, load_fraction=0.5, held=True))
    assert settled(Feedforward({2: 1000.0})) == pytest.approx(4.432, abs=1e-3)
    assert settled(inverse_feedforward(undamped)) == pytest.approx(1.495, abs=1e-3)
    assert settled(low_frequency_feedforward(axis)) == pytest.approx(1.482, abs=1e-3)


def test_three_figures_of_the_telescope_with_its_inertia_fed_forward_are_three_loops():
    """4.432 s: PID designed for the rigid inertia, snap bounded by 600; 4.397 s: jerk alone.

    4.379 s, as the notebook has it: jerk alone bounded, and the PID designed for the axis with its
    mode, whose crossover is then 1 Hz. Each with a continuous, unfiltered PID; a digital one of
    1 kHz without delay settles after 4.397 s, too, with snap bounded.
    """
    axis = Axis(1000.0, modes=FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True))
    asked = {"crossover_hz": 1, "phase_margin_deg": 45, "lower_gain_margin_db": 12}
    rigid, flexible = design_pid(1000.0, **asked), design_pid(axis, **asked)
    jerk = Limits(velocity=10.5, acceleration=10.5, jerk=42.0)
    snap = Limits(velocity=10.5, acceleration=10.5, jerk=42.0, snap=600.0)
    cases = [
        (rigid, snap, 4.432),
        (rigid, jerk, 4.397),
        (flexible, jerk, 4.379),
        (Controller(rigid, sample_time=1e-3), snap, 4.397),
    ]
    for controller, limits, expected in cases:
        loop = ServoLoop(axis, controller, Feedforward({2: 1000.0}))
        response = loop.respond(min_time_move(3.5, limits), duration=8.0, times=[0.0, 8.0])
        settled = response.settling_time(3.5, 0.05 / 3600, of="load")
        assert settled == pytest.approx(expected, abs=5e-4)


LIMITS = Limits(velocity=1.0, acceleration=10.0, jerk=500.0, snap=3e4)


@pytest.mark.parametrize("zeta", [1e-3, 0.01, 0.05, 0.3])
@pytest.mark.parametrize("order", [3, 4])
@pytest.mark.parametrize(
    "others",
    [
        {},
        {"viscous": 0.5, "load_viscous": 0.3, "spring": 4.0},
        {"viscous": 0.5, "sensor": "load"},
        {"current_lag": 1e-3, "load_viscous": 0.3},
    ],
)
def test_a_damped_mode_follows_to_rounding(zeta, order, others):
    """In continuous time, simulated exactly; a lag of the current needs one order more."""
    order += "current_lag" in others
    bounds = (1.0, 10.0, 500.0, 3e4, 3e6)
    move = min_time_move(0.4, Limits.from_bounds(bounds[:order]), method="closed-form")
    axis = Axis(J, modes=FlexibleMode(20.0, zeta, load_fraction=LAM), **others)
    law = PID(30.0, 30.0, 8.0) if axis.sensor == "load" else CascadedPI(10.0, 300.0, 0.3)
    inverse = inverse_feedforward(axis, move, controller=law)
    assert inverse.dynamics is not None
    response = ServoLoop(axis, law, inverse).respond(move, 0.01, duration=move.duration + 0.2)
    assert response.peak_load_error < 1e-12 * 0.4


def driven(a, fed, trajectory):
    """Return the middles of the pieces and x there, x′ = a·x + Σ fed[k]·r^(k), from 0, by expm."""
    order = trajectory.order
    whole = np.zeros((order + 2, order + 2))
    whole[0, 0], whole[0, 1 : 1 + len(fed)] = a, fed
    whole[1:, 1:] = np.diag(np.ones(order), 1)
    x, times, found = 0.0, [], []
    for start, state, length in zip(
        trajectory.breaks[:-1], trajectory.states, trajectory.durations, strict=True
    ):
        half = expm(whole * (0.5 * length))
        middle = half @ np.append(x, state)
        times.append(start + 0.5 * length)
        found.append(middle[0])
        x = float((half @ middle)[0])
    return np.array(times), np.array(found)


@pytest.mark.parametrize("zeta", [0.01, 0.05])
def test_the_twist_of_a_damped_mode_is_that_of_its_equation(zeta):
    """THEORY: c·ẋ + k·x = −λ·J·r̈ − B_L·ṙ, y_motor = r − x; the torque from the motor's balance."""
    motor, load = 0.5, 0.3
    axis = Axis(
        J, modes=FlexibleMode(20.0, zeta, load_fraction=LAM), viscous=motor, load_viscous=load
    )
    move, c = min_time_move(0.4, LIMITS), 2.0 * zeta * W * LAM * (1.0 - LAM) * J
    times, x = driven(-K / c, [0.0, -load / c, -LAM * J / c], move)
    r, v, a, jerk = move.evaluate(times, 3)
    x1 = (-LAM * J * a - load * v - K * x) / c
    x2 = (-LAM * J * jerk - load * a - K * x1) / c
    torque = (1 - LAM) * J * (a - x2) + motor * (v - x1) + LAM * J * a + load * v
    found = inverse_feedforward(axis)
    added = found.dynamics.added(move, 0.0, times)
    rows = np.array([r, v, a, jerk])
    np.testing.assert_allclose(found.torque_gains(3) @ rows + added[0], torque, rtol=1e-9)
    np.testing.assert_allclose(found.position_gains(3) @ rows + added[1], r - x, rtol=1e-12)


def test_damped_chains_and_appendages_are_inverted_too():
    pid = PID(30.0, 30.0, 8.0)
    appendages = [(6.0, 0.01, 0.3), (11.0, 0.02, 0.2)]
    held = [FlexibleMode(f, z, load_fraction=share, held=True) for f, z, share in appendages]
    move = min_time_move(0.4, LIMITS, method="closed-form")
    for axis, size in (
        (chain_axis([1.0, 2.0, 0.5], [800.0, 3000.0], [0.8, 1.5], viscous=0.2), 2),
        (Axis(4.0, modes=held), 3),
    ):
        inverse = inverse_feedforward(axis)
        assert inverse.dynamics.size == size
        response = ServoLoop(axis, pid, inverse).respond(move, 0.01, duration=1.0)
        assert response.peak_load_error < 1e-12 * 0.4
    undamped = [held[0], FlexibleMode(11.0, load_fraction=0.2, held=True)]
    with pytest.raises(ValueError, match=r"rings for ever, at 11 Hz, .* give it damping; use low_"):
        inverse_feedforward(Axis(4.0, modes=undamped))


def test_sines_and_sums_are_remembered_from_rest():
    axis = FlexibleInertia(J, 20.0, 0.05, load_fraction=LAM)
    dynamics = inverse_feedforward(axis).dynamics
    a, b, c, d = dynamics.matrices()
    sine, move, times = Sine(0.1, 3.0), min_time_move(0.4, LIMITS), np.linspace(0.0, 0.6, 40)
    omega, size = 6.0 * pi, -0.1 * (6.0 * pi) ** 3  # r⃛ = size·cos(omega·t)
    whole = np.array([[a[0, 0], 0.0, size * b[0]], [0.0, 0.0, omega], [0.0, -omega, 0.0]])
    x = np.array([(expm(whole * t) @ [0.0, 0.0, 1.0])[0] for t in times])
    expected = c * x + np.outer(d, size * np.cos(omega * times))
    found = dynamics.added(sine, 0.0, times)
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())
    both = dynamics.added(move + sine + Ramp(1.0), 0.0, times)
    np.testing.assert_allclose(both, found + dynamics.added(move, 0.0, times), rtol=1e-12)


def test_what_remembers_is_a_transfer_function_and_goes_with_its_command():
    axis = FlexibleInertia(J, 20.0, 0.05, load_fraction=LAM, sensor="load")
    inverse = inverse_feedforward(axis)
    s = 30.0 + 40.0j
    assert inverse.transfer()(s) == pytest.approx(1.0 / axis.transfer()(s), rel=1e-12)
    bounded = inverse_feedforward(axis, min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0)))
    assert bounded.dynamics is None
    assert dict(bounded.torque) == pytest.approx({2: J})
    with pytest.raises(ValueError, match="its dynamics are unstable"):
        InverseDynamics(3, (1.0, -0.1), (1.0,), ())
    with pytest.raises(ValueError, match=r"expected m \+ 1 numbers"):
        InverseDynamics(3, (2.0, 0.1), (1.0,), ())
    with pytest.raises(TypeError, match="dynamics = 3: expected InverseDynamics"):
        Feedforward(dynamics=3)


def test_a_digital_loop_runs_what_remembers_exactly():
    """Its lead takes the delay back, as for an undamped axis; nothing of it is left without."""
    axis = Axis(J, modes=FlexibleMode(20.0, 0.05, load_fraction=LAM))
    controller = Controller(PID(800.0, 2e3, 60.0), sample_time=1e-3, delay=1.5e-3)
    move = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=200.0, snap=1e4))
    low, exact = (
        replace(find(axis), lead=2e-3) for find in (low_frequency_feedforward, inverse_feedforward)
    )
    errors = [
        ServoLoop(axis, controller, each).respond(move, 0.01).peak_load_error
        for each in (low, exact, replace(exact, lead=0.0))
    ]
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < 0.2 * errors[2]


def test_what_is_asked_of_the_command_is_said():
    axis = Axis(J, modes=FlexibleMode(20.0, load_fraction=LAM), friction=Friction(1.0, 2.0))
    inverse = inverse_feedforward(axis)
    third = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=500.0))
    fourth = min_time_move(0.4, Limits(velocity=1.0, jerk=500.0, snap=3e4), method="closed-form")
    assert inverse.friction == 1.0
    assert inverse.requirement().startswith("needs snap of the command bounded (limits of order 4")
    assert "its snap is a train of impulses" in inverse.requirement(third)
    assert inverse.requirement(fourth).endswith(": the command is of order 4")
    assert inverse.requirement(Sine(1.0, 2.0) + Ramp(1.0)) == inverse.requirement()
    kept = inverse_feedforward(axis, third)
    assert dict(kept.torque) == {2: inverse.torque[2]}
    assert dict(kept.position) == dict(inverse.position)
    assert kept.friction == 1.0
    assert ServoLoop(axis, PID(1.0, 1.0, 1.0), kept).respond(third, 0.1).peak_error > 0.0
    assert inverse_feedforward(axis, fourth) == inverse
    assert inverse_feedforward(axis, Sine(1.0, 2.0)) == inverse
    assert inverse_feedforward(Inertia(3.0)).requirement().startswith("needs acceleration")
    lagging = inverse_feedforward(Axis(3.0, current_lag=1e-3))
    assert dict(lagging.torque) == pytest.approx({2: 3.0, 3: 3e-3})
    assert Feedforward().requirement() == "needs nothing of the command"


def test_a_system_is_inverted_too():
    import control

    axis = system_axis(control.tf([1.0], [2.0, 0.5, 8.0, 0.0]))
    assert dict(inverse_feedforward(axis).torque) == pytest.approx({1: 8.0, 2: 0.5, 3: 2.0})


def test_a_digital_loop_comes_near_and_a_lead_takes_the_delay_back():
    axis = Axis(J, modes=FlexibleMode(20.0, load_fraction=LAM))
    controller = Controller(PID(800.0, 2e3, 60.0), sample_time=1e-3, delay=1.5e-3)
    move = min_time_move(0.4, Limits(velocity=1.0, acceleration=10.0, jerk=200.0, snap=1e4))
    inverse = inverse_feedforward(axis)

    def error(feedforward):
        return ServoLoop(axis, controller, feedforward).respond(move, 0.01).peak_load_error

    ahead = Feedforward(inverse.torque, position=inverse.position, lead=2e-3)
    assert error(ahead) < 0.1 * error(inverse)
    assert error(inverse) < 0.25 * error(Feedforward({2: J}))


@pytest.mark.parametrize(("zeta", "left"), [(0.005, 3.6e-6), (0.01, 7.0e-6), (0.05, 3.1e-5)])
def test_what_the_low_frequency_form_leaves_of_a_damped_mode_is_as_its_docstring_says(zeta, left):
    limits = Limits(velocity=2.0, acceleration=15.0, jerk=400.0, snap=2e4)
    move = min_time_move(0.5, limits)
    axis = Axis(2.0, modes=FlexibleMode(20.0, zeta, load_fraction=0.4))
    loop = ServoLoop(
        axis, PID(1263.31, 9525.13, 65.3451), low_frequency_feedforward(axis, move, order=4)
    )
    response = loop.respond(move, 1e-3, duration=move.duration + 0.5)
    assert response.peak_load_error == pytest.approx(left, rel=0.02)
