"""The jerk filter against its exact response in 150 digits, quadrature and its own equation."""

from functools import lru_cache
from itertools import accumulate, pairwise
from math import comb, factorial, inf, nan, perm

import mpmath
import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from references import RESPONSE, move_text
from scipy.integrate import quad
from scipy.stats import gamma
from strategies import bound_lists, smooth_trajectory
from tiers import some

from jounce.shaping import JerkFilter, Limits, Trajectory, min_jerk_move, min_time_move

DIGITS = 100
UNSHRUNK = settings(
    max_examples=settings.default.max_examples // 4,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)
"""For tests whose reference is slow."""

ROUNDING = 1e-12
"""Of a row's peak, for comparing the package with itself."""


def exact(jerk_filter, trajectory, tau, *, every_jump=False):
    """Return the output and its derivatives `tau` after the trajectory's start, from its jumps.

    The input is the coasting motion before the start plus, at each break, the jumps of all its
    derivatives: y = steady state + Σ Δ_j·g_j(t − t_i), g_j the response to t^j/j!.

    Where a lower derivative jumps by no more than rounding, the higher ones feel it only if
    `every_jump` says so: nothing to a slow filter, an impulse that is not meant to a fast one.
    """
    m, omega = jerk_filter.order, mpmath.mpf(jerk_filter.omega)
    before = coasting(trajectory, trajectory.start_state)
    total = [before[0] + before[1] * (tau - m / omega), before[1]] + [mpmath.mpf(0)] * (m - 1)
    for since, jumps in all_jumps(trajectory):
        if tau <= since:
            break
        responses = powers_responses(m, omega, tau - since, trajectory.order)
        for j, (jump, real) in enumerate(jumps):
            for k in range(m + 1 if real or every_jump else min(j, m) + 1):
                total[k] += jump * responses[j - k]
    return total


def coasting(trajectory, state):
    kept = [mpmath.mpf(float(x)) for x in state[: trajectory.coasting + 1]]
    return kept + [mpmath.mpf(0)] * max(trajectory.order + 1 - len(kept), 1)


@lru_cache(maxsize=4)
def all_jumps(trajectory):
    """Return the time of each break since the start, and every derivative's (jump, is it real?).

    A jump of a derivative below the highest is rounding unless it is 1e-9 of that derivative.
    """
    start, n = mpmath.mpf(trajectory.start_time), trajectory.order
    here = coasting(trajectory, trajectory.start_state)[: n + 1]
    clock, found = mpmath.mpf(0), []
    rows = [*trajectory.states.tolist(), coasting(trajectory, trajectory.end_state)]
    for at, row in zip(trajectory.breaks.tolist(), rows, strict=True):
        gone, clock = mpmath.mpf(at) - start - clock, mpmath.mpf(at) - start
        jumps = [
            mpmath.mpf(row[k])
            - mpmath.fsum(here[j] * gone ** (j - k) / factorial(j - k) for j in range(k, n + 1))
            for k in range(n + 1)
        ]
        real = [j == n or abs(jump) > 1e-9 * trajectory.peak(j) for j, jump in enumerate(jumps)]
        found.append((clock, list(zip(jumps, real, strict=True))))
        here = [mpmath.mpf(x) for x in row[: n + 1]]
    return found


def powers_responses(m, omega, t, highest):
    """Return {q: the filter's response to t^q/q!}; −q is derivative q of the step response."""
    x, decay = omega * t, mpmath.exp(-omega * t)
    terms = [mpmath.mpf(1)]  # x^i/i!
    for i in range(1, m + highest):
        terms.append(terms[-1] * x / i)
    partial = list(accumulate(terms))
    shares = [1 - decay * partial[m - 1 + i] for i in range(highest + 1)]  # P(m + i, x)
    responses = {
        q: mpmath.fsum(
            comb(q, i) * perm(m + i - 1, i) * t ** (q - i) * (-1 / omega) ** i * shares[i]
            for i in range(q + 1)
        )
        / factorial(q)
        for q in range(highest + 1)
    }
    for q in range(1, m + 1):
        lags = (comb(q - 1, i) * (-1) ** (q - 1 - i) * terms[m - 1 - i] for i in range(q))
        responses[-q] = omega**q * decay * mpmath.fsum(lags)
    return responses


def worst_error(jerk_filter, trajectory, dt, duration=None, samples=2, seed=0):
    """Return the largest error of each derivative row, relative to that row's peak.

    Looked at where each row peaks, at random samples and just behind random breaks.
    """
    response = jerk_filter.respond(trajectory, dt, duration=duration)
    # A coarse grid may pass a row's peak by: seen at 1.00001·T a step's jerk is next to nothing.
    around = 2.0 * trajectory.duration
    finely = jerk_filter.respond(
        trajectory,
        min(dt, trajectory.duration / 300.0),
        duration=around if duration is None else min(duration, around),
    )
    peaks = np.maximum(*(np.abs(each.states).max(axis=1) for each in (response, finely)))
    rng = np.random.default_rng(seed)
    chosen = {int(i) for i in np.abs(response.states).argmax(axis=1)}
    chosen |= {int(i) for i in rng.integers(0, response.time.size, samples)}
    behind = np.searchsorted(response.time, rng.choice(trajectory.breaks, samples)) + 1
    chosen |= {int(i) for i in behind if i < response.time.size}
    slow = jerk_filter.omega * trajectory.duration < 30.0
    errors = np.zeros(jerk_filter.order + 1)
    with mpmath.workdps(DIGITS):
        all_jumps.cache_clear()
        for i in chosen:
            expected_rows = exact(jerk_filter, trajectory, i * mpmath.mpf(dt), every_jump=slow)
            for k, expected in enumerate(expected_rows):
                error = abs(float(mpmath.mpf(float(response.states[k, i])) - expected))
                scale = max(float(peaks[k]), abs(float(expected)))
                errors[k] = max(errors[k], error / scale if scale else 0.0)
    return errors


def check_exact(jerk_filter, trajectory, dt, text, **options):
    errors = worst_error(jerk_filter, trajectory, dt, **options)
    assert errors.max() <= RESPONSE, f"{jerk_filter}.respond({text}, {dt!r}): rows {errors}"


def drifting(trajectory, velocity):
    """Return the trajectory on top of a constant velocity that was there for ever."""
    if trajectory.order == 1:  # which cannot coast
        return trajectory
    states, end = trajectory.states.copy(), trajectory.end_state.copy()
    states[:, 0] += velocity * (trajectory.breaks[:-1] - trajectory.start_time)
    end[0] += velocity * trajectory.duration
    states[:, 1] += velocity
    end[1] += velocity
    return Trajectory(trajectory.breaks, states, trajectory.durations, end)


BOUNDS = [0.9, 2.2, 15.0, 150.0, 2e3, 4e4]


def full_move(order, distance=1.0, start=0.0):
    return min_time_move(
        distance, Limits.from_bounds(BOUNDS[:order]), start=start, method="closed-form"
    )


# The step response


@pytest.mark.parametrize(("tolerance", "published"), [(0.01, 1.0431), (0.001, 1.3094)])
def test_settling_time_of_order_6_at_2_hz(tolerance, published):
    assert JerkFilter(2.0, 6).settling_time(tolerance) == pytest.approx(published, abs=5e-5)


@pytest.mark.parametrize("order", [1, 2, 6, 20, 50])
@pytest.mark.parametrize("tolerance", [0.9, 0.1, 0.01, 1e-6, 1e-12])
def test_settling_time_is_where_the_gamma_tail_is_the_tolerance(order, tolerance):
    jerk_filter = JerkFilter(0.7, order)
    settled = mpmath.mpf(jerk_filter.settling_time(tolerance))
    tail = mpmath.gammainc(order, jerk_filter.omega * settled, regularized=True)
    assert float(tail) == pytest.approx(tolerance, rel=1e-11)


def test_settling_time_scales_with_the_corner():
    assert JerkFilter(2e6, 6).settling_time(0.01) == pytest.approx(
        JerkFilter(2.0, 6).settling_time(0.01) * 1e-6, rel=1e-15
    )


@pytest.mark.parametrize("order", [1, 2, 6, 13, 50])
@pytest.mark.parametrize("corner", [1e-3, 2.0, 5e4])
def test_step_response_is_the_gamma_distribution(order, corner):
    jerk_filter = JerkFilter(corner, order)
    t = np.array([-1.0, 0.0, 1e-3, 0.3, 1.0, 2.5, 6.0, 30.0, 200.0]) / jerk_filter.omega
    expected = [
        mpmath.gammainc(order, 0, jerk_filter.omega * max(x, 0.0), regularized=True) for x in t
    ]
    np.testing.assert_allclose(
        jerk_filter.step_response(t), np.array(expected, dtype=float), rtol=1e-12
    )
    assert jerk_filter.step_response(3.0 / corner) == pytest.approx(
        gamma.cdf(3.0 / corner, order, scale=1 / jerk_filter.omega), rel=1e-13
    )


@pytest.mark.parametrize("order", range(1, 9))
def test_steps_never_overshoot(order):
    jerk_filter = JerkFilter(2.0, order)
    y = jerk_filter.step_response(np.linspace(-0.1, 20.0, 20001))
    assert y.min() == 0.0
    assert y.max() <= 1.0
    assert np.diff(y).min() >= -2.3e-16
    assert y[-1] == 1.0


@pytest.mark.parametrize("order", range(1, 9))
def test_a_jump_of_the_trajectory_is_a_step(order):
    """Where position jumps, the filter lets nothing through but its step response."""
    step = Trajectory([-1.0, 0.5, 3.0], [[2.0, 0.0], [5.0, 0.0]])
    jerk_filter = JerkFilter(1.3, order)
    response = jerk_filter.respond(step, 0.01)
    expected = 2.0 + 3.0 * gamma.cdf(response.time - 0.5, order, scale=1 / jerk_filter.omega)
    np.testing.assert_allclose(response.states[0], expected, rtol=1e-13)


# The response to trajectories


@pytest.mark.parametrize("filter_order", some([1, 3, 6], 2))
@pytest.mark.parametrize("order", some(range(1, 7), 4))
def test_every_derivative_for_minimum_time_moves(order, filter_order):
    jerk_filter = JerkFilter(1.1, filter_order)
    move = full_move(order, distance=-1.0 if order % 2 else 1.3, start=0.4)
    check_exact(jerk_filter, move, 0.013, f"full_move({order})")


@UNSHRUNK
@given(
    bounds=bound_lists(),
    filter_order=st.integers(1, 8),
    corner=st.floats(-1.0, 1.0).map(lambda x: 10.0**x),
    sign=st.sampled_from([-1.0, 1.0]),
    steps=st.floats(0.3, 300.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_every_derivative_for_random_moves(bounds, filter_order, corner, sign, steps, seed):
    move = min_time_move(sign, Limits.from_bounds(bounds), method="closed-form")
    jerk_filter = JerkFilter(corner / move.duration, filter_order)
    dt = move.duration / steps
    check_exact(jerk_filter, move, dt, move_text(sign, bounds), samples=2, seed=seed)


def test_every_derivative_just_behind_a_ramp():
    """Found by chance: the samples are the start and T + 1e-5·T, where hardly anything moves."""
    move = min_time_move(1.0, Limits.from_bounds([1.2398499926723263]))
    jerk_filter = JerkFilter(10.0**0.55 / move.duration, 3)
    check_exact(jerk_filter, move, move.duration / 0.99999, "a ramp", seed=145655)


@pytest.mark.slow
@UNSHRUNK
@given(
    bounds=bound_lists(),
    filter_order=st.integers(1, 14),
    corner=st.floats(-4.0, 4.0).map(lambda x: 10.0**x),
    velocity=st.sampled_from([0.0, -3.0, 0.1]),
    delay=st.sampled_from([0.0, -7.0, 123.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_every_derivative_of_any_filter(bounds, filter_order, corner, velocity, delay, seed):
    base = min_time_move(1.0, Limits.from_bounds(bounds), method="closed-form")
    move = drifting(base.delay(delay * base.duration), velocity / base.duration)
    jerk_filter = JerkFilter(corner / move.duration, filter_order)
    dt = min(0.1 / corner, 0.01) * move.duration
    text = f"drifting({move_text(1.0, bounds)}.delay({delay}·T), {velocity}/T)"
    check_exact(jerk_filter, move, dt, text, duration=1.5 * move.duration, samples=2, seed=seed)


@pytest.mark.parametrize("filter_order", some(range(1, 9), 3))
@pytest.mark.parametrize("distance", [2.0, -0.3])
def test_every_derivative_for_a_minimum_jerk_move(filter_order, distance):
    """Its jerk jumps at both ends: derivative 4 of the output must feel that."""
    move = min_jerk_move(distance, duration=1.7, start=-1.0)
    check_exact(JerkFilter(0.9, filter_order), move, 0.01, f"min_jerk_move({distance}, …)")


@pytest.mark.parametrize("order", some(range(1, 7), 3))
@pytest.mark.parametrize("filter_order", [2, 6])
def test_every_derivative_for_a_motion_that_starts_and_ends_moving(order, filter_order):
    """Its acceleration and higher derivatives jump at both ends."""
    moving = smooth_trajectory(31 + order, order)
    check_exact(JerkFilter(0.8, filter_order), moving, 0.017, f"smooth_trajectory({31 + order}, …)")


@pytest.mark.parametrize("filter_order", [1, 2, 3, 5])
def test_every_derivative_behind_a_jump_of_position(filter_order):
    step = Trajectory([0.0, 0.5, 3.0], [[2.0, 0.0], [5.0, 0.0]])
    check_exact(JerkFilter(1.3, filter_order), step, 0.01, "a step of 3 at 0.5")


def test_every_derivative_of_two_moves_of_different_order():
    """Appended to a jerk-limited move, an acceleration-limited one jumps in acceleration."""
    both = full_move(3).then(full_move(2, -0.5), dwell=0.2)
    check_exact(JerkFilter(1.5, 6), both, 0.01, "full_move(3).then(full_move(2, −0.5), dwell=0.2)")


@pytest.mark.parametrize("velocity", [2.0, -0.4])
@pytest.mark.parametrize("order", some([2, 3, 6], 2))
def test_a_start_in_motion_is_the_steady_state_of_a_ramp(order, velocity):
    move = drifting(full_move(order, start=3.0), velocity)
    jerk_filter = JerkFilter(1.1, 6)
    check_exact(jerk_filter, move, 0.01, f"drifting(full_move({order}), {velocity})")
    first = jerk_filter.respond(move, 0.01).states[:, 0]
    lag = velocity * 6 / jerk_filter.omega
    np.testing.assert_allclose(first, [3.0 - lag, velocity, 0, 0, 0, 0, 0], rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("order", [1, 2, 3, 6])
@pytest.mark.parametrize("delay", [-0.37, 0.05, 1e3])
def test_a_delayed_trajectory_gives_a_delayed_response(order, delay):
    jerk_filter, move = JerkFilter(1.1, 6), full_move(order)
    now, later = (jerk_filter.respond(m, 0.01, duration=4.0) for m in (move, move.delay(delay)))
    np.testing.assert_allclose(
        later.time - delay, now.time, rtol=0, atol=1e-15 + 1e-15 * abs(delay)
    )
    check_rows_agree(later.states, now.states, ROUNDING * max(1.0, abs(delay)))


def check_rows_agree(rows, expected, tolerance):
    peaks = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(rows / peaks, expected / peaks, rtol=0, atol=tolerance)


@pytest.mark.parametrize("order", some([1, 2, 4, 6], 2))
@pytest.mark.parametrize("filter_order", [1, 4, 8])
def test_dt_does_not_change_values(order, filter_order):
    jerk_filter, move = JerkFilter(1.1, filter_order), full_move(order)
    fine = jerk_filter.respond(move, 2.0**-12, duration=4.0)
    for shift in (5, 9, 12, 13):  # up to 2, longer than the move
        coarse = jerk_filter.respond(move, 2.0 ** (shift - 12), duration=4.0)
        picked = fine.states[:, :: 2**shift]
        peaks = np.abs(fine.states).max(axis=1, keepdims=True)
        assert picked.shape == coarse.states.shape
        np.testing.assert_allclose(coarse.states / peaks, picked / peaks, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("order", [1, 3, 6])
def test_a_trajectory_shorter_than_dt_is_not_missed(order):
    bounds = [b * 1e3**k for k, b in enumerate(BOUNDS[:order], start=1)]
    move = min_time_move(1.0, Limits.from_bounds(bounds), method="closed-form")
    assert move.duration < 0.01
    check_exact(JerkFilter(2.0, 6), move, 0.05, move_text(1.0, bounds))


@given(
    bounds=bound_lists(),
    filter_order=st.integers(1, 7),
    corner=st.floats(0.0, 1.5).map(lambda x: 10.0**x),
)
def test_the_rows_obey_the_filters_own_equation(bounds, filter_order, corner):
    """(1 + s/ω)^m y = r, at every sample; between samples every row integrates the next."""
    move = min_time_move(1.0, Limits.from_bounds(bounds), method="closed-form")
    jerk_filter = JerkFilter(corner / move.duration, filter_order)
    response = jerk_filter.respond(move, move.duration / 300, duration=2.0 * move.duration)
    scaled = response.states / jerk_filter.omega ** np.arange(filter_order + 1.0)[:, None]
    weights = [comb(filter_order, i) for i in range(filter_order + 1)]
    left = weights @ scaled
    unit = np.abs(weights @ np.abs(scaled)).max()
    np.testing.assert_allclose(
        left,
        move(response.time),
        rtol=0,
        atol=RESPONSE * unit,
        err_msg=f"{jerk_filter}, {move_text(1.0, bounds)}",
    )


@pytest.mark.parametrize("order", [2, 4, 6])
def test_derivatives_match_the_convolution_by_quadrature(order):
    """y^(k)(t) = ∫ r^(k)(t − u)·h(u) du; beyond the trajectory's order h is differentiated."""
    m, move = 6, full_move(order)
    jerk_filter = JerkFilter(1.3, m)
    omega = jerk_filter.omega
    response = jerk_filter.respond(move, 0.07)
    pdf = np.polynomial.Polynomial([0.0] * (m - 1) + [omega**m / 120.0])
    for i in (3, 9, 15, 21):
        t = response.time[i]
        edges = np.unique(np.clip(t - np.append(move.breaks, t - 60 / omega), 0.0, None))
        for k in range(m):
            shape = pdf
            for _ in range(max(k - order, 0)):
                shape = shape.deriv() - omega * shape
            d = min(k, order)
            expected = sum(
                quad(
                    lambda u, t=t, d=d, p=shape: float(move(t - u, d)) * p(u) * np.exp(-omega * u),
                    a + 1e-15,
                    b - 1e-15,
                    epsabs=0.0,
                    epsrel=1e-11,
                )[0]
                for a, b in pairwise(edges)
                if b - a > 1e-12
            )
            peak = np.abs(response.states[k]).max()
            assert response.states[k, i] == pytest.approx(expected, abs=1e-10 * peak), (k, t)


@pytest.mark.parametrize("filter_order", some(range(1, 9), 3))
@pytest.mark.parametrize("order", some(range(1, 9), 4))
def test_monotone_moves_never_overshoot(order, filter_order):
    bounds = [0.9, 2.2, 15.0, 150.0, 2e3, 4e4, 1e6, 3e7][:order]
    move = min_time_move(-2.0, Limits.from_bounds(bounds), start=2.0, method="closed-form")
    for corner in (0.3, 5.0):
        y = JerkFilter(corner, filter_order).respond(move, 0.01).states[:2]
        assert y[0].max() <= 2.0 * (1 + 1e-15)
        assert y[0].min() >= -4e-15
        assert np.diff(y[0]).max() <= 4e-15
        assert y[1].max() <= 1e-14 * np.abs(y[1]).max()
        assert y[1].min() >= -0.9 * (1 + 1e-14)


@pytest.mark.parametrize("filter_order", [1, 6, 50])
@pytest.mark.parametrize("order", [1, 3, 6])
def test_it_comes_to_rest_at_the_moves_end(order, filter_order):
    jerk_filter, move = JerkFilter(3.0, filter_order), full_move(order, distance=-4.0, start=1.0)
    length = move.duration + jerk_filter.settling_time(1e-16)
    response = jerk_filter.respond(move, 0.01, duration=length + 1.0)
    assert response.states[0, -1] == pytest.approx(-3.0, rel=1e-13)
    peaks = np.abs(response.states).max(axis=1)
    assert (np.abs(response.states[1:, -1]) <= 1e-12 * peaks[1:]).all()


def test_default_grid_lasts_until_a_step_has_settled_to_1e_6():
    jerk_filter, move = JerkFilter(2.0, 6), full_move(3).delay(5.0)
    response = jerk_filter.respond(move, 1e-3)
    assert response.time[0] == 5.0
    length = move.duration + jerk_filter.settling_time(1e-6)
    assert length - 1e-3 < response.time[-1] - 5.0 <= length + 1e-12
    assert response.states.shape == (7, response.time.size)
    assert response.states[0, -1] == pytest.approx(1.0, abs=1e-6)


def test_a_trajectory_without_pieces_is_a_point_at_rest():
    response = JerkFilter(2.0, 4).respond(min_time_move(0.0, Limits(jerk=1.0), start=3.0), 0.01)
    np.testing.assert_allclose(response.states[0], 3.0, rtol=1e-14)
    np.testing.assert_array_equal(response.states[1:], 0.0)


@pytest.mark.parametrize("pace", some([1e-3, 1e-2, 1.0, 1e2, 1e4, 1e5], 3))
@pytest.mark.parametrize("order", some([1, 3, 6], 2))
def test_slow_and_fast_filters_keep_the_relative_accuracy_of_every_row(order, pace):
    """Pace ωT: after 1e-3 the output has moved by 1e-18·R; at 1e5 rows span 30 decades."""
    move = full_move(order)
    jerk_filter = JerkFilter(pace / (2 * np.pi * move.duration), 6)
    dt = move.duration * min(0.01, 0.2 / pace)
    check_exact(jerk_filter, move, dt, f"full_move({order})", duration=1.01 * move.duration)


@pytest.mark.parametrize("pace", some([1e-3, 0.03, 1.0, 1e2], 2))
@pytest.mark.parametrize("order", some([1, 3, 6], 2))
def test_the_settling_after_a_short_move_keeps_the_relative_accuracy_of_every_row(order, pace):
    """Seen by a slow filter the move is a step, and row k peaks long after it, near ω^k·R."""
    move = full_move(order)
    jerk_filter = JerkFilter(pace / (2 * np.pi * move.duration), 6)
    check_exact(jerk_filter, move, 0.05 / jerk_filter.omega, f"full_move({order})")


@pytest.mark.parametrize("unit", [1e-6, 1e6])
@pytest.mark.parametrize("order", [1, 3, 6])
def test_units_of_distance_and_time_change_nothing(order, unit):
    move = full_move(order)
    response = JerkFilter(1.1, 6).respond(move, 0.01, duration=3.0)
    other = JerkFilter(1.1 / unit, 6).respond(
        move.scale(unit**2).stretch(unit), 0.01 * unit, duration=3.0 * unit
    )
    factors = unit ** (2.0 - np.arange(7.0))[:, None]
    check_rows_agree(other.states / factors, response.states, ROUNDING)
    np.testing.assert_allclose(other.time, response.time * unit, rtol=1e-14)


# State space


@given(
    order=st.integers(1, 50),
    corner=st.sampled_from([1e-4, 0.3, 2.0, 1e5]),
    ratio=st.floats(-2.0, 1.0).map(lambda x: 10.0**x),
)
def test_each_state_is_one_more_lag(order, corner, ratio):
    jerk_filter = JerkFilter(corner, order)
    a, b = jerk_filter.state_space()
    s = 1j * ratio * 2 * np.pi * corner
    states = np.linalg.solve(s * np.eye(order) - a, b)[:, 0]
    expected = (1 / (1 + 1j * ratio)) ** np.arange(1, order + 1)
    np.testing.assert_allclose(states, expected, rtol=1e-12, err_msg=f"{jerk_filter}, s = {s}")


@pytest.mark.parametrize("filter_order", [1, 2, 6, 50])
@pytest.mark.parametrize("derivative", [0, 1, 2])
def test_the_steady_state_follows_the_coasting_command(filter_order, derivative):
    """Z' = A·z + b·r with z' the slope of the command in every lag."""
    jerk_filter = JerkFilter(0.7, filter_order)
    move = drifting(full_move(3, start=2.0), -1.5)
    z = jerk_filter.steady_state(move, derivative)
    a, b = jerk_filter.state_space()
    level, slope = [(2.0, -1.5), (-1.5, 0.0), (0.0, 0.0)][derivative]
    rate = a @ z + b[:, 0] * level
    np.testing.assert_allclose(rate, slope, rtol=1e-12, atol=1e-13)


# Errors


@pytest.mark.parametrize("corner", [0.0, -2.0, nan, inf])
def test_a_corner_that_is_not_positive_is_refused(corner):
    with pytest.raises(ValueError, match=f"corner_hz = {corner!r}: expected a positive"):
        JerkFilter(corner, 6)


@pytest.mark.parametrize("order", [0, -1, 51, 2.5, nan])
def test_an_order_outside_1_to_50_is_refused(order):
    with pytest.raises(
        ValueError, match=f"order = {order!r}: expected a whole number from 1 to 50"
    ):
        JerkFilter(1.0, order)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -0.1, 2.0, nan])
def test_a_tolerance_outside_0_to_1_is_refused(tolerance):
    with pytest.raises(ValueError, match=f"tolerance = {tolerance!r}: expected a fraction"):
        JerkFilter(1.0, 6).settling_time(tolerance)


@pytest.mark.parametrize("value", [0.0, -0.1, nan, inf])
@pytest.mark.parametrize("name", ["dt", "duration"])
def test_a_dt_or_duration_that_is_not_positive_is_refused(name, value):
    options = {"dt": 0.1, "duration": 1.0} | {name: value}
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a positive"):
        JerkFilter(1.0, 6).respond(full_move(3), **options)


def test_filters_are_frozen_and_compare_by_value():
    jerk_filter = JerkFilter(2, 6)
    assert jerk_filter == JerkFilter(2.0, 6)
    assert type(jerk_filter.corner_hz) is float
    with pytest.raises(AttributeError):
        jerk_filter.order = 7
