"""The servo loop: identities at random frequencies, exact responses, published numbers."""

from itertools import pairwise
from math import inf, nan, pi

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references import RESPONSE, move_text
from servo_loops import GAINS, MOMENT, MOVE, loop_with
from strategies import MAGNITUDES, bound_lists
from tiers import some

from jounce.plant import (
    PID,
    Inertia,
    InertiaFeedforward,
    ServoLoop,
    design_pid,
    respond,
)
from jounce.shaping import JerkFilter, Limits, Trajectory, min_jerk_move, min_time_move

FEW = settings(max_examples=settings.default.max_examples // 2)
"""Its breaks are multiples of 1/4, so that its acceleration is linear between samples."""


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
@pytest.mark.parametrize("estimate", some([0.0, MOMENT, 2.0], 2))
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
