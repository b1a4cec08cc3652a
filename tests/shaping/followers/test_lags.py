"""The lags behind a follower: the exponential of the whole system's matrix, the filter itself."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import COMMANDS, Following, random_following

from jounce import core
from jounce.shaping import CommandFollower, JerkFilter, Limits, Trajectory, min_time_transfer

ORDER_2 = Limits(velocity=(-2.0, 3.0), acceleration=(-1.5, 1.0))
ORDER_3 = Limits(velocity=(-2.0, 3.0), acceleration=(-1.5, 1.0), jerk=(-2.0, 4.0))
BOTH = pytest.mark.parametrize("limits", [ORDER_2, ORDER_3], ids=["order 2", "order 3"])
FILTERS = st.builds(JerkFilter, st.sampled_from([0.02, 0.3, 1.0, 7.0]), st.integers(1, 7))
NUMBERS = st.floats(-9.0, 9.0, width=32)
MOTIONS = st.integers(2, 3).flatmap(lambda n: st.tuples(*[NUMBERS] * (n + 1)))


def system(jerk_filter, order):
    """Return the matrix of (lags, motion): z_j' = ω·(z_{j−1} − z_j), z_0 and its chain behind."""
    m, omega = jerk_filter.order, mpmath.mpf(jerk_filter.omega)
    matrix = mpmath.zeros(m + order + 1)
    for j in range(m):
        matrix[j, j] = -omega
        matrix[j, j - 1 if j else m] = omega
    for k in range(order):
        matrix[m + k, m + k + 1] = 1
    return matrix


def exact(jerk_filter, lags, motion, tau):
    """Return lags and motion a time later."""
    with mpmath.workdps(60):
        matrix = system(jerk_filter, len(motion) - 1)
        state = mpmath.expm(matrix * mpmath.mpf(tau)) * mpmath.matrix([*lags, *motion])
        values = [float(x) for x in state]
    return values[: len(lags)], values[len(lags) :]


def size(jerk_filter, lags, motion, tau):
    """Return the size of what is added up."""
    terms = [abs(x) * (tau + jerk_filter.order / jerk_filter.omega) ** k
             for k, x in enumerate(motion)]  # fmt: skip
    return max(sum(terms), *map(abs, lags), 1e-300)


def drawn_lags(jerk_filter, seed):
    return np.random.default_rng(seed).normal(size=jerk_filter.order).tolist()


@settings(max_examples=settings.default.max_examples // 4)
@given(jerk_filter=FILTERS, motion=MOTIONS, seed=st.integers(0, 99), tau=st.floats(1e-6, 10.0))
def test_lags_follow_a_polynomial_exactly(jerk_filter, motion, seed, tau):
    lags = drawn_lags(jerk_filter, seed)
    expected, _ = exact(jerk_filter, lags, motion, tau)
    found = core.advance_lags(lags, motion, tau, jerk_filter.omega)
    slack = 1e-13 * size(jerk_filter, lags, motion, tau)
    text = f"core.advance_lags({lags}, {motion}, {tau}, {jerk_filter.omega})"
    np.testing.assert_allclose(found, expected, rtol=0, atol=slack, err_msg=text)


@given(jerk_filter=FILTERS, level=NUMBERS, slope=NUMBERS, tau=st.floats(0.01, 10.0))
def test_the_steady_state_behind_a_ramp_stays_that(jerk_filter, level, slope, tau):
    def steady(position):
        ramp = Trajectory([0.0, 1.0], [[position, slope, 0.0]])
        return jerk_filter.steady_state(ramp)

    found = core.advance_lags(
        steady(level).tolist(), (level, slope, 0.0, 0.0), tau, jerk_filter.omega
    )
    slack = 1e-13 * size(jerk_filter, found, (level, slope), tau)
    np.testing.assert_allclose(found, steady(level + slope * tau), rtol=0, atol=slack)


@given(jerk_filter=FILTERS, motion=MOTIONS, seed=st.integers(0, 99))
def test_output_and_its_derivatives_are_those_of_the_last_lag(jerk_filter, motion, seed):
    """Powers of the system's matrix; the motion shows in derivatives beyond the filter's order."""
    lags = drawn_lags(jerk_filter, seed)
    order, omega = len(motion) - 1, jerk_filter.omega
    follower = CommandFollower((ORDER_2, ORDER_3)[order - 2], dt=1.0, jerk_filter=jerk_filter)
    found = follower.output((*motion, *lags))
    with mpmath.workdps(60):
        state, matrix = mpmath.matrix([*lags, *motion]), system(jerk_filter, order)
        for k in range(order + 1):
            slack = 1e-15 * 4.0**k * size(jerk_filter, lags, motion, 0.0) * omega**k
            expected = float(state[len(lags) - 1])
            slack += 1e-15 * sum(abs(x) * omega ** (k - j) for j, x in enumerate(motion[: k + 1]))
            assert found[k] == pytest.approx(expected, abs=slack), (jerk_filter, lags, motion, k)
            state = matrix * state


@pytest.mark.parametrize("filter_order", [3, 6])
def test_output_agrees_with_the_filters_own_weights(filter_order):
    jerk_filter, rng = JerkFilter(0.4, filter_order), np.random.default_rng(3)
    states, lags = rng.normal(size=(4, 5)), rng.normal(size=(filter_order, 5))
    follower = CommandFollower(ORDER_3, dt=1.0, jerk_filter=jerk_filter)
    each = [follower.output((*row, *lag)) for row, lag in zip(states.T, lags.T, strict=True)]
    found = np.array(each).T
    chain = np.vstack([states[:1], lags])
    for k in range(4):
        expected = jerk_filter.derivative_weights(k) @ chain
        np.testing.assert_allclose(found[k], expected, rtol=1e-13, atol=1e-13)


# Behind a follower


def check_rows(found, expected, text, tolerance=1e-9, peaks=None):
    peaks = np.abs(expected).max(axis=1) if peaks is None else peaks
    error = np.abs(found - expected).max(axis=1) / peaks
    assert error.max() <= tolerance, f"{text}: rows err by {error}"


@BOTH
@pytest.mark.parametrize(
    "jerk_filter", [JerkFilter(0.5, 6), JerkFilter(3.0, 2), JerkFilter(1.0, 1)]
)
@pytest.mark.parametrize("dt", [0.03, 0.7, 20.0])
def test_behind_a_constant_command_it_is_the_response_to_the_transfer(limits, jerk_filter, dt):
    follower = CommandFollower(limits, dt=dt, jerk_filter=jerk_filter)
    count = int(10.0 / dt) + 2
    found = follower.run([4.0] * count, initial=(-1.0,)).states
    transfer = min_time_transfer(-1.0, 4.0, limits)
    span = (count + 0.5) * dt
    expected = jerk_filter.respond(transfer, dt, duration=span).states[:, 1 : count + 1]
    peaks = np.abs(jerk_filter.respond(transfer, 0.01).states).max(axis=1)
    rows = 1 + min(limits.order, jerk_filter.order)
    text = f"{jerk_filter}, {limits}, dt = {dt}"
    check_rows(found[:rows], expected[:rows], text, peaks=peaks[:rows])


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("period", [None, 2.5])
def test_behind_any_commands_it_is_the_response_to_the_motion_inside_the_samples(
    order, kind, period
):
    jerk_filter = JerkFilter(0.6, 4)
    given = random_following(np.random.default_rng((7, order)), order, kind, moving=True)
    following = Following(
        given.start, given.bounds, given.dt, given.commands, given.velocities, period
    )
    states = following.states()
    motion = following.motion(states)
    count = len(given.commands)
    span = (count + 0.5) * given.dt
    expected = jerk_filter.respond(motion, given.dt, duration=span).states[:, 1 : count + 1]
    begin = (*states[:, 0], *jerk_filter.steady_state(motion))
    found = following.follower(jerk_filter).run(
        given.commands, command_velocities=given.velocities, initial=begin
    )
    check_rows(found.states, expected[: order + 1], f"{following}, {jerk_filter}", 1e-8)


@BOTH
@pytest.mark.parametrize("filter_order", [1, 6])
def test_steps_carry_the_lags_and_output_agrees_with_run(limits, filter_order):
    jerk_filter = JerkFilter(0.8, filter_order)
    following = random_following(np.random.default_rng(5), limits.order, "steps")
    follower = following.follower(jerk_filter)
    whole = follower.run(following.commands, initial=following.start).states
    steps = following.steps(jerk_filter)
    assert {len(state) for state in steps} == {limits.order + 1 + filter_order}
    shown = np.array([follower.output(state) for state in steps]).T
    check_rows(shown, whole, f"{following}, {jerk_filter}")
    rest = follower.run(following.commands[20:], initial=steps[19]).states
    check_rows(rest, whole[:, 20:], f"{following}, {jerk_filter}")
    bare = np.array(following.steps()).T
    check_rows(np.array(steps).T[: limits.order], bare[: limits.order], f"{following}", 1e-12)


def test_lags_left_out_are_at_rest_at_the_position():
    follower = CommandFollower(ORDER_2, dt=0.5, jerk_filter=JerkFilter(1.0, 3))
    assert follower.rest(2.0) == (2.0, 0.0, 0.0, 2.0, 2.0, 2.0)
    assert follower.step((2.0, 1.0), 3.0) == follower.step((2.0, 1.0, 0.0, 2.0, 2.0, 2.0), 3.0)
    assert follower.output((2.0, 1.0)) == (2.0, 0.0, 0.0)
    assert CommandFollower(ORDER_2, dt=0.5).output((2.0, 1.0)) == (2.0, 1.0, 0.0)
