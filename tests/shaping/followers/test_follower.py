"""CommandFollower: constant commands, run and step, wrap-around, units, errors."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import COMMANDS, Following, random_following, transfer_problems

from jounce.shaping import CommandFollower, JerkFilter, Limits, min_time_move, min_time_transfer

ORDER_2 = Limits(velocity=(-2.0, 3.0), acceleration=(-1.5, 1.0))
ORDER_3 = Limits(velocity=(-2.0, 3.0), acceleration=(-1.5, 1.0), jerk=(-2.0, 4.0))
BOTH = pytest.mark.parametrize("limits", [ORDER_2, ORDER_3], ids=["order 2", "order 3"])
EXACT = {2: 1e-12, 3: 1e-9}
SIZES = st.floats(-2.5, 0.7).map(lambda exponent: 10.0**exponent)


# Constant commands


@given(problem=transfer_problems(), pace=SIZES)
def test_a_constant_command_gives_the_minimum_time_motion(problem, pace):
    """Every sample; dt from a 300th of the motion to five times as long."""
    command, transfer = (
        problem.end[0],
        min_time_transfer(problem.start, problem.end[0], problem.limits),
    )
    dt = pace * transfer.duration or 0.1
    count = min(int(1.2 * transfer.duration / dt) + 2, 400)
    following = Following(problem.start, problem.bounds, dt, (command,) * count)
    states, n = following.states()[:, 1:], following.order
    expected = transfer.evaluate(dt * np.arange(1, count + 1))
    peaks = [transfer.peak(k) for k in range(n)]
    drift = 4e-16 * count * peaks[0]  # of positions, by rounding of every sample
    slip = drift / max(peaks[1], 1e-300)  # of time
    for k in range(n):
        slack = EXACT[n] * peaks[k] + (drift if k == 0 else slip * transfer.peak(k + 1))
        assert np.abs(states[k] - expected[k]).max() <= slack + 1e-300, (following, k)


@BOTH
@pytest.mark.parametrize("dt", [1e-6, 1e-3])
def test_a_tiny_dt_moves_by_the_jerk_or_acceleration_alone(limits, dt):
    n, count = limits.order, 50
    states = CommandFollower(limits, dt=dt).run([9.0] * count).states
    time, top = dt * np.arange(1, count + 1), limits.bounds(n)[1]
    ulps = 4e-16 * 9.0 * count  # positions are seen from the command
    np.testing.assert_allclose(states[0], top * time**n / (2.0, 6.0)[n - 2], atol=ulps, rtol=1e-12)
    np.testing.assert_allclose(states[n - 1], top * time, rtol=1e-12)


@BOTH
def test_a_sample_longer_than_the_motion_ends_at_the_command(limits):
    follower = CommandFollower(limits, dt=1e3)
    rest = (0.0,) * limits.order
    assert follower.step((5.0, -1.0), -7.5) == (-7.5, *rest)
    assert follower.step((5.0, 1.0), 1e2, 0.25) == (350.0, 0.25, *rest[1:])


# Run and step


@pytest.mark.parametrize("period", [None, 3.0])
@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("kind", COMMANDS)
def test_run_is_step_in_a_loop(kind, moving, period):
    """But for rounding, which grows from sample to sample where commands are wild."""
    for order in (2, 3):
        given = random_following(np.random.default_rng(order), order, kind, moving=moving)
        count = len(given.commands) if kind in ("steps", "sine") else 6
        speeds = given.velocities and given.velocities[:count]
        following = Following(
            given.start, given.bounds, given.dt, given.commands[:count], speeds, period
        )
        steps = np.array(following.steps()).T
        states = following.states()[:, 1:]
        scale = 1e-9 * np.abs(states).max(axis=1)
        for k in range(order):
            assert np.abs(states[k] - steps[k]).max() <= scale[k], (following, k)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_long_courses_among_changing_commands_are_followed_step_by_step(order, seed):
    """Commands held, or on a ramp told with its velocity, for a few samples or for many."""
    rng = np.random.default_rng((order, seed))
    given, commands, speeds = random_following(rng, order), [], []
    for length in rng.choice([1, 2, 30, 63, 64, 65, 150], 12):
        u = float(rng.choice([0.0, *0.8 * np.array(given.bounds[0])]))
        commands += (rng.normal() + u * given.dt * np.arange(length)).tolist()
        speeds += [u] * length
    following = Following(given.start, given.bounds, given.dt, tuple(commands), tuple(speeds))
    states, follower = following.states(), following.follower()
    slack = 1e-10 * np.abs(states).max(axis=1)
    samples = zip(states.T[:-1].tolist(), states.T[1:], commands, speeds, strict=True)
    for before, after, command, speed in samples:
        anew = follower.step(before, command, speed)
        assert (np.abs(after - anew)[:order] <= slack[:order]).all(), (following, before)


@BOTH
def test_a_response_says_when_and_what(limits):
    response = CommandFollower(limits, dt=0.25).run([1, 2, 3], command_velocities=0.5)
    assert response.time.tolist() == [0.25, 0.5, 0.75]
    assert response.commands.tolist() == [1.0, 2.0, 3.0]
    assert response.states.shape == (limits.order + 1, 3)


@BOTH
def test_what_is_left_out_of_a_state_is_zero(limits):
    follower = CommandFollower(limits, dt=0.5)
    full = (1.5, *[0.0] * limits.order)
    assert follower.rest(1.5) == full
    expected = follower.step(full, 3.0)
    for length in range(1, limits.order + 2):
        assert follower.step(full[:length], 3.0) == expected
    assert follower.step((*full[:-1], 99.0), 3.0) == expected  # the highest is not used
    at_zero = follower.run([3.0, 3.0], initial=(0.0,)).states
    np.testing.assert_array_equal(follower.run([3.0, 3.0]).states, at_zero)


# Wrap-around


@BOTH
def test_the_shortest_way_leads_from_350_to_10_degrees_over_360(limits):
    follower = CommandFollower(limits, dt=0.1, period=360.0)
    direct = CommandFollower(limits, dt=0.1).run([370.0] * 200, initial=(350.0,)).states
    for command in (10.0, 370.0, -350.0, 10.0 + 360.0 * 64.0):
        states = follower.run([command] * 200, initial=(350.0,)).states
        np.testing.assert_allclose(states[0], direct[0], rtol=0, atol=1e-10)
        assert states[0, -1] == pytest.approx(370.0, rel=1e-14)


@BOTH
@pytest.mark.parametrize("begin", [0.0, 90.0, -1234.0])
def test_the_way_to_the_exact_opposite_is_taken_to_its_end(limits, begin):
    """Either way is as short; the one begun is gone on with."""
    follower = CommandFollower(limits, dt=0.05, period=360.0)
    positions = follower.run([begin + 180.0] * 3000, initial=(begin,)).states[0]
    assert abs(positions[-1] - begin) == pytest.approx(180.0, rel=1e-12)
    assert len(set(np.sign(np.diff(positions))) - {0.0}) == 1


@BOTH
def test_round_and_round_the_output_goes_on_continuously(limits):
    """A ramp told modulo the period, with its velocity, at turns both ways."""
    dt, count = 0.05, 4000
    for u in (1.0, -1.5):
        turning = u * dt * np.arange(count)
        given = {"command_velocities": u, "initial": (0.25, 0.5)}
        wrapped = CommandFollower(limits, dt=dt, period=7.0).run(turning % 7.0, **given)
        straight = CommandFollower(limits, dt=dt).run(turning, **given)
        np.testing.assert_allclose(wrapped.states[:2], straight.states[:2], rtol=0, atol=1e-9)
        assert abs(wrapped.states[0, -1] - u * dt * count) < 1e-9


@BOTH
def test_a_moving_start_takes_the_shortest_way_from_where_it_is(limits):
    follower = CommandFollower(limits, dt=0.02, period=10.0)
    positions = follower.run([20.0] * 800, initial=(4.0, 0.5)).states[0]
    assert positions.max() > 4.05
    assert positions[-1] == pytest.approx(0.0, abs=1e-13)
    positions = follower.run([20.0] * 800, initial=(5.5, -0.25)).states[0]
    assert positions.min() < 5.49
    assert positions[-1] == pytest.approx(10.0, rel=1e-14)


# Units and mirror


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize(("distance", "time"), [(2.0**30, 2.0**-12), (2.0**-53, 2.0**7)])
def test_units_of_powers_of_two_change_no_bit(order, kind, distance, time):
    following = random_following(np.random.default_rng((11, order)), order, kind, moving=True)
    other = following.in_units(distance, time).states()
    factors = np.array([distance / time**k for k in range(order + 1)])[:, None]
    np.testing.assert_array_equal(other, following.states() * factors, err_msg=f"{following}")


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize(("distance", "time"), [(1e-9, 1.0), (1e16, 1e3), (1e5, 1e-9)])
def test_other_units_change_no_more_than_rounding(order, kind, distance, time):
    """Sample by sample, as rounding grows where commands alternate."""
    following = random_following(np.random.default_rng((12, order)), order, kind, moving=True)
    states, factors = following.states(), [distance / time**k for k in range(order + 1)]
    other = following.in_units(distance, time)
    follower = other.follower()
    size = np.abs(states).max(axis=1)
    size[0] += max(map(abs, following.commands))
    samples = zip(states.T[:-1], states.T[1:], other.commands, other.speeds, strict=True)
    for before, after, command, speed in samples:
        found = np.array(follower.step((before * factors).tolist(), command, speed)) / factors
        assert (np.abs(found - after)[:order] <= 1e-9 * size[:order]).all(), (other, before)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("period", [None, 4.0])
def test_a_mirrored_problem_has_the_mirrored_motion(order, kind, period):
    given = random_following(np.random.default_rng((13, order)), order, kind, moving=True)
    following = Following(
        given.start, given.bounds, given.dt, given.commands, given.velocities, period
    )
    mirrored = following.mirrored().states()
    np.testing.assert_array_equal(mirrored, -following.states(), err_msg=f"{following}")


# Errors


@pytest.mark.parametrize("value", [0.0, -0.1, nan, inf])
@pytest.mark.parametrize("name", ["dt", "period"])
def test_a_dt_or_period_that_is_not_positive_is_refused(name, value):
    options = {"dt": 0.1, "period": 1.0} | {name: value}
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a positive"):
        CommandFollower(ORDER_2, **options)


@pytest.mark.parametrize("limits", [Limits(velocity=1.0), Limits.from_bounds([1.0, 1.0, 1.0, 1.0])])
def test_limits_of_another_order_are_refused(limits):
    with pytest.raises(ValueError, match=f"limits of order {limits.order}: expected order 2"):
        CommandFollower(limits, dt=0.1)


def test_other_arguments_of_the_wrong_kind_are_refused():
    one_sided = Limits(velocity=1.0, acceleration=(-inf, 1.0))
    with pytest.raises(ValueError, match=r"bounded in one direction only, \(-inf, 1\)"):
        CommandFollower(one_sided, dt=0.1)
    with pytest.raises(TypeError, match=r"limits = 3\.0: expected Limits"):
        CommandFollower(3.0, dt=0.1)
    with pytest.raises(TypeError, match=r"jerk_filter = 2\.0: expected a JerkFilter or None"):
        CommandFollower(ORDER_2, dt=0.1, jerk_filter=2.0)


@BOTH
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_numbers_that_are_not_finite_are_refused(limits, value):
    follower = CommandFollower(limits, dt=0.1)
    with pytest.raises(ValueError, match=f"command = {value!r}: expected a finite"):
        follower.step((0.0,), value)
    with pytest.raises(ValueError, match=f"command_velocity = {value!r}: expected a finite"):
        follower.step((0.0,), 1.0, value)
    with pytest.raises(ValueError, match=rf"state\[1\] = {value!r}: expected a finite"):
        follower.step((0.0, value), 1.0)
    for name in ("commands", "command_velocities"):
        arrays = {"commands": [1.0, 2.0]} | {name: [1.0, value]}
        with pytest.raises(ValueError, match=f"{name}.*{value!r}"):
            follower.run(**arrays)
    with pytest.raises(ValueError, match=rf"state\[0\] = {value!r}: expected a finite"):
        follower.run([1.0], initial=(value,))


@pytest.mark.parametrize(("jerk_filter", "told"), [(None, ""), (JerkFilter(1.0, 5), "5 lags")])
def test_a_state_of_the_wrong_length_is_refused(jerk_filter, told):
    follower = CommandFollower(ORDER_2, dt=0.1, jerk_filter=jerk_filter)
    for length in (0, 4, 7, 9):
        for use in (lambda s: follower.step(s, 1.0), follower.output):
            with pytest.raises(ValueError, match=f"state of {length} numbers: .*2 deriv.*{told}"):
                use([0.0] * length)
        with pytest.raises(ValueError, match=f"state of {length} numbers"):
            follower.run([1.0], initial=[0.0] * length)


@BOTH
def test_arrays_of_the_wrong_shape_are_refused(limits):
    follower = CommandFollower(limits, dt=0.1)
    with pytest.raises(ValueError, match=r"commands has shape \(1, 2\): expected \(N,\)"):
        follower.run([[1.0, 2.0]])
    with pytest.raises(ValueError, match=r"commands has shape \(\)"):
        follower.run(1.0)
    with pytest.raises(ValueError, match=r"command_velocities has shape \(3,\): expected \(2,\)"):
        follower.run([1.0, 2.0], command_velocities=[0.0] * 3)


def test_followers_are_frozen_and_compare_by_value():
    follower = CommandFollower(ORDER_2, dt=1, period=2)
    assert follower == CommandFollower(ORDER_2, dt=1.0, period=2.0)
    assert follower != CommandFollower(ORDER_2, dt=1.0)
    assert (type(follower.dt), follower.order) == (float, 2)
    with pytest.raises(AttributeError):
        follower.dt = 2.0


def test_a_rest_to_rest_move_is_a_command_held():
    """The planners of moves and of transfers share nothing with the follower of order 2."""
    move = min_time_move(5.0, Limits(velocity=2.0, acceleration=1.0))
    response = CommandFollower(Limits(velocity=2.0, acceleration=1.0), dt=0.3).run([5.0] * 20)
    np.testing.assert_allclose(response.states[:2], move.evaluate(response.time, 1), atol=1e-13)


# What once failed


@pytest.mark.parametrize("jerk", [None, 1.0])
@pytest.mark.parametrize("count", [1, 100])
def test_a_command_far_away_leaves_the_position_its_digits(jerk, count):
    follower = CommandFollower(Limits(1.0, 1.0, jerk), dt=0.01)
    near, far = (
        follower.run([command] * count, initial=(0.37,)).states for command in (1e3, 1e300)
    )
    np.testing.assert_allclose(far, near, rtol=1e-13)


def test_order_3_rests_at_what_is_nothing():
    follower = CommandFollower(Limits(velocity=1.0, jerk=1.0), dt=0.5)
    assert follower.step((0.0, 1e-220, 0.0), 0.0) == (0.0, 0.0, 0.0, 0.0)
    response = follower.run([5e-324 * (-1) ** k for k in range(40)])
    assert np.abs(response.states).max() <= 5e-324


@pytest.mark.parametrize("jerk", [None, (-2.0, 4.0)])
def test_the_way_round_is_chosen_at_every_sample(jerk):
    follower = CommandFollower(Limits((-2.0, 3.0), (-1.5, 1.0), jerk), dt=0.02, period=10.0)
    state = (4.9, 2.5)
    for _ in range(1000):
        state = follower.step(state, 0.0)
    assert state[0] == 10.0
    assert follower.run([0.0] * 1000, initial=(4.9, 2.5)).states[0, -1] == 10.0


@pytest.mark.parametrize("jerk", [None, 1.0])
def test_no_commands_no_states(jerk):
    response = CommandFollower(Limits(1.0, 1.0, jerk), dt=0.01).run([])
    assert response.states.shape == (3 if jerk is None else 4, 0)


@pytest.mark.parametrize("order", [2, 3])
def test_the_trajectory_behind_sampled_commands_goes_through_all_samples(order):
    limits = Limits(velocity=1.0, acceleration=4.0, **({"jerk": 40.0} if order == 3 else {}))
    follower = CommandFollower(limits, dt=0.05)
    commands = 0.3 * np.sin(np.arange(60) * 0.2)
    response = follower.run(commands)
    whole = follower.trajectory(commands)
    assert whole.violation(limits) < 1e-9
    assert whole.lowest_jump() == 2  # the acceleration, at the end at the latest
    for k in range(order):
        found = whole(response.time[:-1], k)
        np.testing.assert_allclose(found, response.states[k, :-1], atol=1e-12)
    with pytest.raises(ValueError, match="use run"):
        CommandFollower(limits, dt=0.05, period=1.0).trajectory(commands)
