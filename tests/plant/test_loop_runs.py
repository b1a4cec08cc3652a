"""Runs of loops against closed forms and a slow method that shares no code with them."""

from math import inf, log, pi

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tiers import some

from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    Ramp,
    SampledTorque,
    ServoLoop,
    Sine,
    TorqueSine,
    TorqueSteps,
)
from jounce.shaping import Limits, min_time_move

STILL = Ramp(0.0)
IDLE = Controller(PID(0.0, 0.0, 0.0), sample_time=0.01)
MOVE = min_time_move(0.5, Limits(velocity=1.0, acceleration=8.0, jerk=200.0))


# A slow reference: one flexible mode, modal form, small steps, bisection


def exponential(a, h):
    """Return exp(A·h) by a series of a sixteenth, squared."""
    part, total, term = a * h / 16.0, np.eye(len(a)), np.eye(len(a))
    for k in range(1, 40):
        term = term @ part / k
        total = total + term
    for _ in range(4):
        total = total @ total
    return total


class Slow:
    """A digital PID on one mode with friction: states y_0, q, their rates, 1, u."""

    def __init__(self, p):
        self.p = p
        J, w, z, a, b = p["J"], 2 * pi * p["f"], p["z"], p["a"], p["b"]
        self.motor, self.load = np.array([1.0, a]), np.array([1.0, b])
        stiff = np.diag([0.0, w * w])
        damp = np.diag([0.0, 2 * z * w]) + p["B"] / J * np.outer(self.motor, self.motor)
        self.rates = np.zeros((6, 6))
        self.rates[:2, 2:4] = np.eye(2)
        self.rates[2:4, :2], self.rates[2:4, 2:4] = -stiff, -damp
        self.rates[2:4, 5] = self.motor / J
        self.v = np.concatenate([[0, 0], self.motor, [0, 0]])
        self.kick = np.concatenate([[0, 0], self.motor / J, [0, 0]])
        self.mobility = self.v @ self.kick

    def matrix(self, mode):
        """Return the rates of a mode."""
        if mode:
            slip = self.rates.copy()
            slip[:, 4] -= mode * self.p["Fc"] * self.kick
            return slip
        return self.rates - np.outer(self.kick, self.v @ self.rates) / self.mobility

    def push(self, x):
        """Return the torque that friction has to hold."""
        return self.v @ self.rates @ x / self.mobility

    def leaves(self, mode, x):
        """Tell whether a mode is over."""
        if mode:
            return mode * (self.v @ x) < 0.0
        return abs(self.push(x)) > self.p["Fs"]

    def settle(self, mode, x):
        """Return the mode that follows one that is over."""
        if mode:
            x = x - self.kick * (self.v @ x) / self.mobility
        push = self.push(x)
        return (0 if abs(push) <= self.p["Fs"] else int(np.sign(push))), x

    def advance(self, mode, x, t, h):
        """Go on in small steps, noting events."""
        if mode == 0 and self.leaves(0, x):
            mode = int(np.sign(self.push(x)))
            self.events.append((t, 0, mode))
        count = 40
        left = h
        while left > 1e-13:
            a = self.matrix(mode)
            step = exponential(a, left / count)
            before = x
            for i in range(count):
                after = step @ before
                if self.leaves(mode, after):
                    low, high = 0.0, left / count
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        if self.leaves(mode, exponential(a, middle) @ before):
                            high = middle
                        else:
                            low = middle
                    passed = i * left / count + high
                    old = mode
                    mode, x = self.settle(mode, exponential(a, high) @ before)
                    if old == 0:
                        mode = int(np.sign(self.push(x)))
                    self.events.append((t + passed, old, mode))
                    t, left = t + passed, left - passed
                    break
                before = after
            else:
                return mode, before
        return mode, x

    def run(self, command, duration):
        """Return the torque and the load's position at all samples."""
        p, T, tau = self.p, self.p["T"], self.p["tau"]
        x, mode, integral, past, rate = np.zeros(6), 0, 0.0, None, 0.0
        x[4] = 1.0
        self.events, torques, positions = [], [], []
        for k in range(round(duration / T)):
            t = k * T
            y = np.append(self.motor, [0, 0, 0, 0]) @ x
            positions.append(np.append(self.load, [0, 0, 0, 0]) @ x)
            e = command(t) - y
            rate = (p["Tf"] * rate + e - (e if past is None else past)) / (p["Tf"] + T)
            past, integral = e, integral + T * e
            w = p["kp"] * e + p["ki"] * integral + p["kd"] * rate
            u = float(np.clip(w, -p["limit"], p["limit"]))
            if u != w and w * e > 0:
                integral -= T * e
            torques.append(u)
            mode, x = self.advance(mode, x, t, tau)
            x = x.copy()
            x[5] = u
            mode, x = self.advance(mode, x, t + tau, T - tau)
        return np.array(torques), np.array(positions)


def random_problem(seed):
    rng = np.random.default_rng(seed)
    J, crossover = 10.0 ** rng.uniform(-1, 2), rng.uniform(2, 6) * 2 * pi
    T = rng.choice([0.001, 0.004, 0.01]) if seed % 3 else 0.02
    share = rng.uniform(0.1, 0.6)
    a = np.sqrt(share / (1 - share))
    Fc = J * rng.uniform(0.5, 4.0)
    return {
        "J": J,
        "f": rng.uniform(8, 40),
        "z": rng.uniform(0.0, 0.05),
        "a": a,
        "b": -1 / a,
        "B": J * rng.uniform(0.0, 1.0),
        "Fc": Fc,
        "Fs": Fc * rng.choice([1.0, 1.3]),
        "T": T,
        "tau": T * rng.uniform(0.1, 0.9),
        "Tf": rng.uniform(0.0, 2.0) * T,
        "kp": J * crossover**2 * 0.7,
        "ki": J * crossover**3 * 0.1,
        "kd": J * crossover * 0.8,
        "limit": J * rng.uniform(4, 20),
    }


@pytest.mark.parametrize("seed", some(range(9), 5))
def test_random_sticking_loops_are_what_small_steps_and_bisection_find(seed):
    p = random_problem(seed)
    axis = Axis(
        p["J"],
        modes=FlexibleMode(p["f"], p["z"], motor_shape=p["a"], load_shape=p["b"]),
        viscous=p["B"],
        friction=Friction(p["Fc"], p["Fs"]),
        torque_limit=p["limit"],
    )
    law = PID(p["kp"], p["ki"], p["kd"], derivative_filter=p["Tf"])
    controller = Controller(law, sample_time=p["T"], delay=p["tau"], anti_windup="conditional")
    command = Sine(0.05, 2.0)
    slow = Slow(p)
    torques, load = slow.run(lambda t: 0.05 * np.sin(4 * pi * t), 0.6)
    response = ServoLoop(axis, controller).respond(command, p["T"], duration=0.6)
    count = len(torques)
    np.testing.assert_allclose(
        response.run.samples[:, 2], torques, rtol=0, atol=1e-9 * np.abs(torques).max()
    )
    np.testing.assert_allclose(response.load[:count], load, rtol=0, atol=1e-11)
    assert len(response.friction_events) == len(slow.events) > 0, (seed, slow.events)
    for found, expected in zip(response.friction_events, slow.events, strict=True):
        assert found[1:] == expected[1:], seed
        assert found[0] == pytest.approx(expected[0], abs=1e-10), seed


# Closed forms of a rigid axis


def test_a_push_and_a_stop_are_the_closed_form():
    """v(t) = v_i + (v_0 − v_i)·e^(−bt), v_i = F/B: zero at t = −ln(−v_i/(v_0 − v_i))/b."""
    J, B, F = 2.0, 0.5, 3.0
    loop = ServoLoop(Axis(J, viscous=B, friction=Friction(F)), IDLE)
    push = TorqueSteps([0.103, 0.2047], [5.0, -5.0])
    response = loop.respond(STILL, 0.01, duration=1.0, disturbance=push)
    b, v1 = B / J, (5.0 - F) / B
    fastest = v1 * (1 - np.exp(-b * (0.2047 - 0.103)))
    stop = 0.2047 - log(F / B / (fastest + F / B)) / b
    assert [event[1:] for event in response.friction_events] == [(0, 1), (1, 0)]
    assert response.friction_events[0][0] == 0.103
    assert response.friction_events[1][0] == pytest.approx(stop, abs=3e-15)
    t1, t2 = 0.2047 - 0.103, stop - 0.2047
    way = v1 * (t1 - (1 - np.exp(-b * t1)) / b)
    way += -F / B * t2 + (fastest + F / B) * (1 - np.exp(-b * t2)) / b
    assert response.position[-1] == pytest.approx(way, rel=1e-13)
    assert response.time_in_stick == pytest.approx(1.0 - (stop - 0.103), abs=1e-14)
    assert response.next_breakaway == inf


@pytest.mark.parametrize(("torque", "moves"), [(3.0, False), (-3.0, False), (3.0 + 1e-12, True)])
def test_a_torque_of_just_the_static_friction_does_not_move(torque, moves):
    loop = ServoLoop(Axis(2.0, friction=Friction(3.0)), IDLE)
    push = TorqueSteps([0.105], [torque])
    response = loop.respond(STILL, 0.01, duration=1.0, disturbance=push)
    assert bool(response.friction_events) == moves
    assert response.time_in_stick == pytest.approx(0.105 if moves else 1.0)


@pytest.mark.parametrize("static", [3.0, 4.0])
def test_an_integral_breaks_the_axis_away_where_it_reaches_the_static_friction(static):
    """Stuck at error e a continuous PI pushes with kp·e + ki·e·t; with Fs = Fc v″ alone is > 0."""
    loop = ServoLoop(Axis(2.0, friction=Friction(3.0, static)), PID(40.0, 30.0, 9.0))
    response = loop.respond(Ramp(0.0, 0.05), 0.01, duration=2.0, start=0.0)
    first = response.friction_events[0]
    assert first[1:] == (0, 1)
    assert first[0] == pytest.approx((static - 40.0 * 0.05) / (30.0 * 0.05), abs=1e-13)
    after = response.run.at(np.array([first[0] + 1e-3]))[1][0]
    assert after[1] > 0.0


@pytest.mark.parametrize("above", [1e-2, 1e-5, 1e-8])
def test_a_push_above_the_static_friction_for_a_moment_is_not_missed(above):
    """A load that swings on the stuck motor pushes d·(1 − cos ω_a·t), at most 2d."""
    static, share, hz = 3.0, 0.4, 5.0
    d = 0.5 * static * (1.0 + above)
    mode = FlexibleMode(hz, load_fraction=share, held=True)
    loop = ServoLoop(Axis(2.0, modes=mode, friction=Friction(static)), IDLE)
    push = TorqueSteps([0.0], [d], on="load")
    response = loop.respond(STILL, 0.1, duration=0.15, disturbance=push)
    [first, second] = response.friction_events[:2]
    # the more exactly, the less steeply the push goes through the static friction
    found = np.arccos(1.0 - static / d) / (2 * pi * hz)
    assert first == (pytest.approx(found, abs=1e-15 / np.sqrt(above)), 0, 1)
    assert second[1:] == (1, 0)


@pytest.mark.parametrize(("length", "force", "second"), [(1e-9, 1e6, 1.0), (1e5, 1e-7, 1e-6)])
def test_events_do_not_depend_on_the_units(length, force, second):
    def events(length, force, second):
        stiffness = force / length
        axis = Axis(
            2.0 * stiffness * second**2,
            modes=FlexibleMode(20.0 / second, 0.01, load_fraction=0.3),
            friction=Friction(3.0 * force, 4.0 * force),
            torque_limit=14.0 * force,
            current_lag=6e-4 * second,
        )
        law = PID(
            1263.31 * stiffness,
            4762.56 * stiffness / second,
            65.3451 * stiffness * second,
            derivative_filter=1e-3 * second,
        )
        controller = Controller(law, sample_time=1e-3 * second, delay=4e-4 * second)
        move = MOVE.stretch(second).scale(length)
        response = ServoLoop(axis, controller).respond(move, second, duration=1.2 * second)
        times = [event[0] / second for event in response.friction_events]
        return times, response.peak_load_error / length

    usual, other = events(1.0, 1.0, 1.0), events(length, force, second)
    assert len(usual[0]) > 3
    assert other[0] == pytest.approx(usual[0], abs=1e-11)
    assert other[1] == pytest.approx(usual[1], rel=1e-10)


def test_stuck_for_long_is_foretold():
    loop = ServoLoop(
        Axis(2.0, friction=Friction(3.0, 4.5)),
        Controller(PID(1263.0, 4762.0, 65.0, derivative_filter=1e-3), sample_time=1e-3),
    )
    response = loop.respond(MOVE, 1e-3, duration=1.2)
    foretold = response.next_breakaway
    assert foretold > 1.2
    longer = loop.respond(MOVE, 1e-3, duration=foretold + 0.01)
    later = [event for event in longer.friction_events if event[0] > 1.2]
    assert later[0][0] == pytest.approx(foretold, abs=1.1e-3)


def test_any_static_friction_above_coulombs_hunts():
    """|e| = 0.56·(Fs − Fc)/kp in the hunting cycle of a PID on an inertia."""
    law = PID(1263.31, 4762.56, 65.3451, derivative_filter=1e-3)
    loop = ServoLoop(Axis(2.0, friction=Friction(3.0, 3.9)), Controller(law, sample_time=1e-3))
    response = loop.respond(Ramp(0.0, 0.01), 0.1, duration=20.0, start=0.0)
    assert len(response.friction_events) > 8
    assert abs(response.error[-1]) == pytest.approx(0.56 * 0.9 / 1263.31, rel=0.2)


# Continuous controllers


def test_a_linear_loop_is_the_same_from_event_to_event_as_by_powers():
    plain = ServoLoop(Inertia(2.0), PID(80.0, 100.0, 20.0), InertiaFeedforward(1.8))
    usual = plain.respond(MOVE, 0.01, duration=2.0)
    modes, states = usual.run.at(usual.time)
    np.testing.assert_allclose(states @ usual.run.seen_row, usual.position, atol=1e-14)
    assert set(modes.tolist()) == {0}
    assert usual.peak_error == pytest.approx(np.abs(usual.error).max(), rel=1e-3)
    assert usual.settling_time(0.5, 1e-4, of="load") == pytest.approx(
        usual.settling_time(0.5, 1e-4), abs=1e-3
    )


WAYS = {"none": None, "back": BackCalculation(0.1), "clamp": Clamp(2.0)}


@pytest.mark.parametrize("way", WAYS, ids=WAYS)
def test_a_continuous_limit_is_what_a_fine_integration_finds(way):
    gains, limit = (100.0, 150.0, 25.0), 9.0
    controller = Controller(PID(*gains), anti_windup=WAYS[way])
    loop = ServoLoop(Axis(2.0, viscous=0.5, torque_limit=limit), controller, Feedforward({2: 2.0}))
    response = loop.respond(MOVE, 0.05, duration=1.5)

    def rates(t, x):
        y, v, integral = x
        e, de = MOVE(t) - y, MOVE(t, 1) - v
        w = gains[0] * e + gains[1] * integral + gains[2] * de + 2.0 * MOVE(t, 2)
        u = np.clip(w, -limit, limit)
        di = e
        if way == "back":
            di += (u - w) / (0.1 * gains[1])
        if way == "clamp" and abs(gains[1] * integral) >= 2.0 and e * integral > 0:
            di = 0.0
        return [v, (u - 0.5 * v) / 2.0, di]

    fine = solve_ivp(
        rates, (0, 1.5), [0.0, 0.0, 0.0], t_eval=response.time, max_step=1e-3, rtol=1e-9, atol=1e-11
    )
    np.testing.assert_allclose(response.position, fine.y[0], atol=2e-6)
    assert 0.05 < response.saturated_time < 1.0
    assert np.abs(response.torque).max() == limit


@pytest.mark.parametrize("ki", [150.0, 600.0])
def test_conditional_integration_may_stay_on_the_limit(ki):
    """With the larger ki integrating would leave the limit and holding come back: it slides."""
    limit, step = 6.0, 2e-5
    controller = Controller(PID(100.0, ki, 25.0), anti_windup="conditional")
    axis = Axis(2.0, viscous=0.5, torque_limit=limit)
    loop = ServoLoop(axis, controller, Feedforward({2: 2.0}))
    response = loop.respond(MOVE, 0.1, duration=1.5)
    times = step * np.arange(75001)
    r, v_r, a_r = MOVE.evaluate(times, 2).tolist()
    y = v = integral = 0.0
    found = []
    for k in range(75001):
        if k % 5000 == 0:
            found.append(y)
        e = r[k] - y
        w = 100.0 * e + ki * integral + 25.0 * (v_r[k] - v) + 2.0 * a_r[k]
        u = min(max(w, -limit), limit)
        if u == w or w * e <= 0.0:
            integral += step * e
        v += step * (u - 0.5 * v) / 2.0
        y += step * v
    np.testing.assert_allclose(response.position, found, atol=2e-4)
    kinds = {response.run.hybrid.modes[mode].integral for mode in response.run.modes}
    assert (2 in kinds) == (ki == 600.0)


def test_disturbances_add_up():
    axis = Axis(2.0, modes=FlexibleMode(9.0, 0.02, load_fraction=0.4), viscous=1.0)
    loop = ServoLoop(axis, PID(800.0, 2000.0, 60.0))
    parts = [
        TorqueSteps([0.1, 0.3], [2.0, -1.0], on="load"),
        TorqueSine(1.0, 7.0),
        SampledTorque([0.05, 0.2, 0.4], [1.0, -1.0, 0.0]),
    ]
    alone = [loop.respond(STILL, 0.01, duration=1.0, disturbance=part) for part in parts]
    together = loop.respond(STILL, 0.01, duration=1.0, disturbance=parts)
    np.testing.assert_allclose(together.load, sum(response.load for response in alone), atol=1e-15)


def test_a_constant_load_is_held_from_the_start():
    for controller in (
        PID(800.0, 2000.0, 60.0),
        Controller(PID(800.0, 2000.0, 60.0), sample_time=1e-3, delay=5e-4),
    ):
        axis = Axis(
            2.0, modes=FlexibleMode(9.0, 0.02, load_fraction=0.4), constant_load=-15.0, viscous=1.0
        )
        response = ServoLoop(axis, controller).respond(Ramp(0.0, 0.3), 0.01, duration=1.0)
        np.testing.assert_allclose(response.position, 0.3, atol=1e-12)
        np.testing.assert_allclose(response.torque, 15.0, rtol=1e-10)
        assert np.ptp(response.twist) < 1e-12
        assert response.twist[0] < -1e-4


# Refusals


@pytest.mark.parametrize(
    ("respond", "words"),
    [
        (lambda loop: loop.respond(STILL, 0.01), "give duration"),
        (lambda loop: loop.respond(STILL, duration=1.0), "dt is missing"),
        (lambda loop: loop.respond(STILL, 0.01, duration=1.0, noise=[1.0]), "expected one value"),
        (lambda loop: loop.respond(STILL, duration=1.0, times=[1.0, 0.5]), "increasing times"),
    ],
)
def test_what_cannot_be_run_gets_one_line(respond, words):
    loop = ServoLoop(Axis(2.0), Controller(PID(1.0, 0.0, 2.0), sample_time=0.1))
    with pytest.raises(ValueError, match=words) as refusal:
        respond(loop)
    assert "\n" not in str(refusal.value)


def test_an_unstable_loop_says_so():
    loop = ServoLoop(Axis(2.0), Controller(PID(1e6, 0.0, 0.0), sample_time=0.1))
    with pytest.raises(ValueError, match="unstable"):
        loop.respond(MOVE, 0.1, duration=200.0)


@pytest.mark.parametrize("duration", [7.415685493214459, 22.247056479643376])
def test_a_motor_on_the_edge_of_breaking_away_stays_where_it_is(duration):
    """Static friction that equals Coulomb's, and a torque that comes to rest at it: no motion."""
    axis = Axis(1.0, current_lag=1e-3, friction=Friction(0.2))
    loop = ServoLoop(axis, Controller(CascadedPI(6.0, 12.0, 0.1), sample_time=1e-3))
    still = 0.0021604672930620136
    response = loop.respond(Ramp(0.0, still), times=[0.0, duration], start=0.0)
    times = [time for time, _, _ in response.friction_events]
    assert abs(response.error[-1]) < 1e-12 * still
    assert len(times) == len(set(times)), response.friction_events


@pytest.mark.parametrize("dt", [1e-3, None])
@pytest.mark.parametrize(("load", "leaves"), [(-0.15, False), (-0.05, True)])
def test_a_load_that_leaves_too_little_torque_never_breaks_away(load, leaves, dt):
    """Of a limit of 1.3 the load takes some, the stiction 1.2: more than is left, or less."""
    law = PID(30.0, 60.0, 2.0, derivative_filter=1e-3)
    axis = Axis(0.02, friction=Friction(0.8, 1.2), torque_limit=1.3, constant_load=load)
    assert _forecast(axis, Controller(law, sample_time=dt)) is leaves


def _forecast(axis, controller):
    """Return whether a stuck axis breaks away, as it is told and as it is found."""
    loop = ServoLoop(axis, controller)
    stuck = loop.respond(Ramp(0.0, 0.02), 0.1, duration=0.3, start=0.0)
    longer = loop.respond(Ramp(0.0, 0.02), 0.1, duration=5.0, start=0.0)
    assert not stuck.friction_events
    found = [time for time, _, _ in longer.friction_events]
    assert stuck.next_breakaway == pytest.approx(found[0] if found else inf, abs=1e-3)
    return bool(found)


@pytest.mark.parametrize("dt", [1e-3, None])
@pytest.mark.parametrize(
    ("law", "share", "clamp", "leaves"),
    [
        (PID(30.0, 60.0, 2.0, derivative_filter=1e-3), 1.0, 0.55, False),
        (PID(30.0, 60.0, 2.0, derivative_filter=1e-3), 1.0, 0.65, True),
        (CascadedPI(15.0, 2.0, 0.5), 1.0, 0.55, False),
        (CascadedPI(15.0, 2.0, 0.5), 1.0, 0.65, True),
        (PID(30.0, 60.0, 2.0, derivative_filter=1e-3), 0.5, 1.75, False),
        (PID(30.0, 60.0, 2.0, derivative_filter=1e-3), 0.5, 1.9, True),
    ],
)
def test_a_clamp_below_the_stiction_never_breaks_away(law, share, clamp, leaves, dt):
    """Stuck at e = 0.02 the law pushes with 0.6; behind a filter of gain 1/2 with half of it."""
    filters = () if share == 1.0 else (control.tf([share], [0.01, 1.0]),)
    controller = Controller(law, sample_time=dt, filters=filters, anti_windup=Clamp(clamp))
    assert _forecast(Axis(0.02, friction=Friction(0.8, 1.2)), controller) is leaves
