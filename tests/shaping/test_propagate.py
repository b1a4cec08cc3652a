"""Propagation against 40-digit matrix exponentials, numerical integration and recursions."""

from itertools import pairwise
from math import factorial

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from references import RESPONSE, as_ppoly
from scipy.integrate import solve_ivp
from scipy.signal import lsim
from scipy.special import gammainc
from strategies import any_trajectory, smooth_trajectory
from tiers import some

from jounce.shaping import Limits, Trajectory, min_jerk_move, min_time_move
from jounce.shaping.propagate import check_fed, grid, propagate

FEW = settings(max_examples=settings.default.max_examples // 2)


def random_system(seed, size, inputs, kind="stable"):
    """Return a, b and an initial state; `kind` says where the poles are."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(size, size))
    a -= np.eye(size) * (np.linalg.eigvals(a).real.max(initial=-9.0) + 0.3)
    if kind == "integrators":
        a = np.eye(size, k=1)
    if kind == "marginal":
        a = a - a.T
    if kind == "unstable":
        a += 0.8 * np.eye(size)
    return a, rng.normal(size=(size, inputs)), rng.normal(size=size)


def exact(a, b, derivatives, trajectory, dt, indices, initial):
    """Return the states at some grid points, by 40-digit exponentials from break to break."""
    with mpmath.workdps(40):
        n, k = len(a), trajectory.order + 1
        generator = mpmath.matrix(n + k, n + k)
        for i in range(n):
            for j in range(n):
                generator[i, j] = mpmath.mpf(float(a[i, j]))
            for column, d in enumerate(derivatives):
                generator[i, n + d] += mpmath.mpf(float(b[i, column]))
        for i in range(k - 1):
            generator[n + i, n + i + 1] = 1
        start = mpmath.mpf(trajectory.start_time)
        breaks = [mpmath.mpf(float(t)) - start for t in trajectory.breaks]
        end = trajectory.end_state * (np.arange(k) <= trajectory.coasting)
        z = mpmath.matrix([mpmath.mpf(float(x)) for x in initial] + [mpmath.mpf(0)] * k)
        found = {}
        for i, p in enumerate([*trajectory.states, end]):
            z[n:] = mpmath.matrix([mpmath.mpf(float(x)) for x in p])
            last = breaks[i + 1] if i + 1 < len(breaks) else mpmath.inf
            for index in indices:
                t = int(index) * mpmath.mpf(dt)
                if breaks[i] <= t < last:
                    found[index] = (mpmath.expm(generator * (t - breaks[i])) * z)[:n]
            if last < mpmath.inf:
                z = mpmath.expm(generator * (last - breaks[i])) * z
        return np.array([[float(x) for x in found[i]] for i in indices]).T


def check_exact(system, derivatives, trajectory, dt, count, text, tolerance=RESPONSE):
    a, b, initial = system
    states = propagate(a, b, derivatives, trajectory, dt, count, initial)
    indices = sorted({0, count - 1, *np.random.default_rng(count).integers(0, count, 3).tolist()})
    expected = exact(a, b, derivatives, trajectory, dt, indices, initial)
    peaks = np.abs(states).max(axis=1, keepdims=True)
    errors = np.abs(states[:, indices] - expected) / np.maximum(peaks, np.abs(expected))
    assert errors.max() <= tolerance, f"{text}, dt={dt!r}: {errors.max(axis=1)}"


# Continuous systems


@FEW
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.integers(1, 4),
    inputs=st.integers(1, 3),
    order=st.integers(1, 6),
    kind=st.sampled_from(["stable", "integrators", "marginal", "unstable"]),
    trajectory=st.sampled_from([any_trajectory, smooth_trajectory]),
    step=st.sampled_from([0.001, 0.03, 0.41, 2.0, 11.0]),
)
@example(
    seed=57, size=1, inputs=3, order=5, kind="integrators",
    trajectory=smooth_trajectory, step=0.41,
)  # fmt: skip
@example(
    seed=49, size=1, inputs=2, order=6, kind="integrators",
    trajectory=smooth_trajectory, step=11.0,
)  # fmt: skip
def test_any_system_for_any_trajectory(seed, size, inputs, order, kind, trajectory, step):
    """With jumps of every derivative, steps that divide no piece and steps beyond all pieces."""
    system = random_system(seed, size, inputs, kind)
    derivatives = np.random.default_rng(seed).integers(0, order + 1, inputs).tolist()
    count = max(int(8.0 / step), 3)
    text = f"random_system({seed}, {size}, {inputs}, {kind!r}), {derivatives}, "
    text += f"{trajectory.__name__}({seed}, {order})"
    check_exact(system, derivatives, trajectory(seed, order), step, count, text)


@pytest.mark.parametrize("kind", ["stable", "integrators", "marginal", "unstable"])
@pytest.mark.parametrize("order", some([2, 3, 6], 2))
def test_moves_match_numerical_integration(kind, order):
    a, b, initial = random_system(7 + order, 3, 2, kind)
    move = min_time_move(
        1.3, Limits.from_bounds([0.8, 2.0, 11.0, 90.0, 1e3, 2e4][:order]), method="closed-form"
    )
    states = propagate(a, b, (0, 1), move, 0.05, 61, initial)
    reference = as_ppoly(move)
    velocity, x, expected = reference.derivative(), initial, [initial]
    knots = np.union1d(move.breaks, 0.05 * np.arange(61))
    knots = knots[np.concatenate([[True], np.diff(knots) > 1e-12])]
    for left, right in pairwise(knots):

        def rate(t, x):
            moving = t < move.duration
            r = (reference(t), velocity(t)) if moving else (1.3, 0.0)
            return a @ x + b @ r

        x = solve_ivp(rate, (left, right), x, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        expected.append(x)
    picked = np.array(expected)[np.searchsorted(knots, 0.05 * np.arange(61) - 1e-9)].T
    np.testing.assert_allclose(states, picked, rtol=0, atol=1e-10 * np.abs(states).max())


@pytest.mark.parametrize("kind", ["stable", "integrators", "unstable"])
def test_a_linear_input_with_breaks_on_the_grid_matches_lsim(kind):
    """The acceleration of an order-3 move is piecewise linear: there lsim is exact."""
    move = Trajectory(
        [0.0, 0.5, 1.0, 2.0, 2.5],
        [[0, 0, 0, 2.0], [1 / 24, 0.25, 1, 0], [0.3, 0.75, 1, -2], [1.0, 0.2, -1.0, 2]],
    )
    a, b, initial = random_system(3, 3, 1, kind)
    time, n = grid(0.0, 5.0, 0.01), 501
    states = propagate(a, b, (2,), move, 0.01, n, initial)
    u = np.where(time < 2.5 - 1e-9, as_ppoly(move).derivative(2)(time), 0.0)
    reference = lsim((a, b, np.eye(3), np.zeros((3, 1))), u, time, X0=initial)[1].T
    np.testing.assert_allclose(states, reference, rtol=0, atol=1e-11 * np.abs(reference).max())


@pytest.mark.parametrize("order", [1, 3, 6, 9])
def test_a_chain_of_integrators_gives_the_trajectory_back(order):
    """Fed by derivative n, with the trajectory's own state at the start."""
    moving = smooth_trajectory(order, order)
    a, b = np.eye(order, k=1), np.zeros((order, 1))
    b[-1, 0] = 1.0
    count = int(moving.duration / 0.003)
    states = propagate(a, b, (order,), moving, 0.003, count, moving.start_state[:-1])
    expected = moving.evaluate(moving.start_time + 0.003 * np.arange(count), order - 1)
    peaks = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(states / peaks, expected / peaks, rtol=0, atol=1e-12)


def test_after_its_end_the_trajectory_coasts():
    """An integrator of position: ∫(x + v·t) = x·t + v·t²/2, for ever."""
    ramp = Trajectory([0.0, 1.0], [[0.0, 0.0, 2.0]])
    states = propagate(np.zeros((1, 1)), np.ones((1, 1)), (0,), ramp, 0.25, 4001, np.zeros(1))
    t = 0.25 * np.arange(4001) - 1.0
    later = t >= 0
    expected = 1 / 3 + t + t**2
    np.testing.assert_allclose(states[0][later], expected[later], rtol=1e-12)


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6, 1e9, 1e15])
@pytest.mark.parametrize("rate", [0.1, 0.5, 1.0, 1.9])
def test_derivatives_that_feed_nothing_do_not_matter(rate, size):
    """Lags of a step of derivative 5, while the position that goes with it is large."""
    trajectory = Trajectory([0.0, 0.37, 100.0], [[0.0] * 6, [size, 0.0, 0.0, 0.0, 0.0, 1.0]])
    a, b = rate * (np.eye(6, k=-1) - np.eye(6)), np.zeros((6, 1))
    b[0, 0] = rate
    states = propagate(a, b, (5,), trajectory, 1.0, 40, np.zeros(6))
    since = np.maximum(np.arange(40) - 0.37, 0.0)
    for i, row in enumerate(states):
        np.testing.assert_allclose(row, gammainc(i + 1, rate * since), rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", ["stable", "integrators", "marginal"])
@pytest.mark.parametrize("stride", [7, 100, 10000])
def test_a_long_grid_agrees_with_a_coarse_one(kind, stride):
    a, b, initial = random_system(5, 4, 2, kind)
    trajectory = smooth_trajectory(5, 4)
    fine = propagate(a, b, (0, 2), trajectory, 2e-4, 50_001, initial)
    coarse = propagate(a, b, (0, 2), trajectory, 2e-4 * stride, 50_000 // stride + 1, initial)
    peaks = np.abs(fine).max(axis=1, keepdims=True)
    np.testing.assert_allclose(coarse / peaks, fine[:, ::stride] / peaks, rtol=0, atol=1e-11)


@pytest.mark.parametrize("stiffness", [10.0, 1e4])
def test_stiff_poles_follow_their_input(stiffness):
    """Poles at 1e4/dt and −1 side by side; each in closed form, p_k = ∫e^(λ(t−s)) r ds."""
    dt, n = 0.01, 300
    poles = np.array([-1.0, -stiffness / dt, -0.3 * stiffness / dt])
    trajectory = smooth_trajectory(11, 4)
    states = propagate(np.diag(poles), -poles[:, None], (0,), trajectory, dt, n, np.zeros(3))
    expected = np.array([modal(p, trajectory, dt, n) for p in poles])
    peaks = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(states / peaks, expected / peaks, rtol=0, atol=RESPONSE)


def modal(pole, trajectory, dt, count):
    """Return the state of x' = λ·(x − r), x(0) = 0, by r's own derivatives over powers of λ.

    A particular solution on a piece is Σ r^(k)/λ^k; the rest decays as e^(λt).
    """
    with mpmath.workdps(60):
        pole, n = mpmath.mpf(float(pole)), trajectory.order
        start = mpmath.mpf(trajectory.start_time)
        end = trajectory.end_state * (np.arange(n + 1) <= trajectory.coasting)
        rows = [[mpmath.mpf(float(x)) for x in row] for row in [*trajectory.states, end]]
        breaks = [mpmath.mpf(float(t)) - start for t in trajectory.breaks]

        def particular(row, tau):
            return mpmath.fsum(
                row[j] * tau ** (j - k) / factorial(j - k) / pole**k
                for k in range(n + 1)
                for j in range(k, n + 1)
            )

        x, piece, values = mpmath.mpf(0), 0, []
        for i in range(count):
            t = i * mpmath.mpf(dt)
            while piece + 1 < len(breaks) and breaks[piece + 1] <= t:
                length = breaks[piece + 1] - breaks[piece]
                free = x - particular(rows[piece], 0)
                x = particular(rows[piece], length) + free * mpmath.exp(pole * length)
                piece += 1
            tau = t - breaks[piece]
            free = x - particular(rows[piece], 0)
            values.append(float(particular(rows[piece], tau) + free * mpmath.exp(pole * tau)))
        return values


@pytest.mark.parametrize("step", [0.004, 0.13, 3.0])
@pytest.mark.parametrize("spread", [4, 30, 60])
def test_badly_scaled_states_lose_nothing(spread, step):
    """States in units of powers of two: every state keeps its own relative accuracy."""
    a, b, initial = random_system(23, 4, 1)
    trajectory = smooth_trajectory(2, 3)
    count = max(int(9.0 / step), 4)
    plain = propagate(a, b, (0,), trajectory, step, count, initial)
    units = 2.0 ** np.round(np.array([1.0, -1.0, 0.3, -0.2]) * spread)
    scaled = propagate(
        a * units[:, None] / units, b * units[:, None], (0,), trajectory, step, count,
        initial * units,
    )  # fmt: skip
    peaks = np.abs(plain).max(axis=1, keepdims=True)
    np.testing.assert_allclose(scaled / units[:, None] / peaks, plain / peaks, rtol=0, atol=1e-11)


@pytest.mark.parametrize("gain", [1e-12, 1e-25, 1e18])
@pytest.mark.parametrize("step", [0.01, 0.5, 1.3])
def test_the_response_is_proportional_to_the_input_gain(gain, step):
    a, b, _ = random_system(29, 3, 1)
    trajectory = min_jerk_move(2.0, duration=3.0, start=1.0)
    count = max(int(5.0 / step), 4)
    plain = propagate(a, b, (0,), trajectory, step, count, np.zeros(3))
    small = propagate(a, b * gain, (0,), trajectory, step, count, np.zeros(3))
    np.testing.assert_allclose(small / gain, plain, rtol=0, atol=1e-12 * np.abs(plain).max())


def test_two_inputs_superpose_whatever_their_sizes():
    """Acceleration beside position at dt = 1e-6: their columns differ by 1e12 in units of dt."""
    a, b, _ = random_system(31, 3, 2)
    b[:, 1] *= 1e-6
    trajectory, zero = smooth_trajectory(4, 3), np.zeros(3)
    both = propagate(a, b, (0, 2), trajectory, 1e-6, 5000, zero)
    parts = [
        propagate(a, b[:, i : i + 1], (d,), trajectory, 1e-6, 5000, zero)
        for i, d in enumerate((0, 2))
    ]
    for part in parts:
        assert np.abs(part).max() > 0.0
    np.testing.assert_allclose(both, sum(parts), rtol=0, atol=1e-12 * np.abs(both).max())
    check_exact((a, b, zero), (0, 2), trajectory, 1e-6, 5000, "smooth_trajectory(4, 3)", 1e-12)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
@pytest.mark.parametrize("step", [0.02, 0.7, 5.0])
def test_the_unit_of_time_changes_nothing(unit, step):
    a, b, initial = random_system(37, 3, 3)
    trajectory = smooth_trajectory(6, 5, start=0.0)
    count = max(int(8.0 / step), 4)
    plain = propagate(a, b, (0, 1, 2), trajectory, step, count, initial)
    other = propagate(
        a / unit, b * unit ** (np.arange(3.0) - 1.0), (0, 1, 2), trajectory.stretch(unit),
        step * unit, count, initial,
    )  # fmt: skip
    np.testing.assert_allclose(other, plain, rtol=0, atol=1e-11 * np.abs(plain).max())


@pytest.mark.parametrize("delay", [-0.37, 12.0, 1e4])
def test_only_time_since_the_start_matters(delay):
    a, b, initial = random_system(41, 3, 1)
    trajectory = smooth_trajectory(8, 4)
    now = propagate(a, b, (1,), trajectory, 0.03, 200, initial)
    later = propagate(a, b, (1,), trajectory.delay(delay), 0.03, 200, initial)
    tolerance = 1e-13 * max(1.0, abs(delay)) * np.abs(now).max()
    np.testing.assert_allclose(later, now, rtol=0, atol=tolerance)


@pytest.mark.parametrize("count", [1, 2, 255, 256, 257, 258, 513, 1000])
def test_blocks_leave_no_seams(count):
    """At counts around the block length every grid is the beginning of a longer one."""
    a, b, initial = random_system(43, 2, 1)
    trajectory = smooth_trajectory(9, 3)
    states = propagate(a, b, (0,), trajectory, 0.011, count, initial)
    longer = propagate(a, b, (0,), trajectory, 0.011, 1500, initial)[:, :count]
    assert states.shape == (2, count)
    np.testing.assert_allclose(states, longer, rtol=0, atol=1e-13 * np.abs(longer).max())
    np.testing.assert_array_equal(states[:, 0], initial)


def test_a_system_without_states_has_none():
    none = propagate(
        np.zeros((0, 0)), np.zeros((0, 1)), (0,), smooth_trajectory(1, 3), 0.1, 40, np.zeros(0)
    )
    assert none.shape == (0, 40)


def test_a_trajectory_without_pieces_is_a_constant_input():
    point = min_time_move(0.0, Limits(jerk=1.0), start=3.0)
    states = propagate(-np.ones((1, 1)), np.ones((1, 1)), (0,), point, 0.1, 100, np.zeros(1))
    expected = -3.0 * np.expm1(-0.1 * np.arange(100))
    np.testing.assert_allclose(states[0], expected, rtol=1e-13)


# Discrete systems


@FEW
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.integers(1, 5),
    order=st.integers(1, 6),
    step=st.sampled_from([0.0013, 0.041, 0.7, 9.0]),
)
def test_discrete_systems_match_their_recursion(seed, size, order, step):
    a, b, initial = random_system(seed, size, 2)
    a /= max(np.abs(np.linalg.eigvals(a)).max(), 1e-3)
    trajectory = any_trajectory(seed, order)
    derivatives = np.random.default_rng(seed).integers(0, order + 1, 2).tolist()
    count = max(int(8.0 / step), 4)
    states = propagate(a, b, derivatives, trajectory, step, count, initial, discrete=True)
    time = trajectory.start_time + step * np.arange(count)
    u = np.array([trajectory(time, d) for d in derivatives])
    expected = np.empty((size, count))
    expected[:, 0] = initial
    for k in range(count - 1):
        expected[:, k + 1] = a @ expected[:, k] + b @ u[:, k]
    scale = max(np.abs(expected).max(), np.abs(b).sum() * np.abs(u).max())
    np.testing.assert_allclose(
        states, expected, rtol=0, atol=1e-11 * scale,
        err_msg=f"random_system({seed}, {size}, 2), any_trajectory({seed}, {order}), {step}",
    )  # fmt: skip


# The grid


@given(
    dt=st.floats(-6.0, 3.0).map(lambda x: 10.0**x),
    steps=st.integers(0, 100_000),
    start=st.sampled_from([0.0, -3.7, 1e3]),
)
def test_the_grid_keeps_an_end_that_is_a_multiple_of_dt(dt, steps, start):
    time = grid(start, steps * dt, dt)
    assert time.size == steps + 1, f"grid({start}, {steps} * {dt!r}, {dt!r})"
    assert time[0] == start
    np.testing.assert_allclose(time[-1] - start, steps * dt, rtol=1e-12, atol=1e-12 * abs(start))


@pytest.mark.parametrize(
    ("duration", "dt", "count"),
    [(0.3, 0.1, 4), (0.7, 0.1, 8), (0.35, 0.1, 4), (0.0, 0.1, 1), (0.05, 0.1, 1), (1.0, 1.0, 2)],
)
def test_the_grid_does_not_pass_its_end(duration, dt, count):
    np.testing.assert_allclose(grid(2.0, duration, dt), 2.0 + dt * np.arange(count), rtol=1e-15)


# Errors


def test_the_remedy_names_the_highest_derivative_that_is_fed():
    with pytest.raises(ValueError, match=r"jerk of a trajectory of order 2 .* up to snap at least"):
        check_fed(smooth_trajectory(1, 2), range(5))


@pytest.mark.parametrize(
    ("order", "derivative", "name"),
    [(1, 2, "acceleration"), (2, 3, "jerk"), (6, 8, "derivative 8")],
)
@pytest.mark.parametrize("discrete", [False, True])
def test_a_derivative_above_the_order_is_a_train_of_impulses(order, derivative, name, discrete):
    message = f"{name} of a trajectory of order {order} is a train of impulses: use .*{name}"
    with pytest.raises(ValueError, match=message):
        propagate(
            np.zeros((1, 1)), np.ones((1, 2)), (0, derivative), smooth_trajectory(1, order),
            0.1, 10, np.zeros(1), discrete=discrete,
        )  # fmt: skip
