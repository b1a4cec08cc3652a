"""SCurveMove: modified under way, and appended to."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from references import replay
from s_curves import assert_continuous, assert_within_rates, by_percent, random_s_curve

from jounce.shaping import SCurveMove, Trajectory, s_curve_move

SEEDS = range(100)
RATES = ("velocity", "acceleration", "deceleration", "acceleration_jerk", "deceleration_jerk")


def go(target=10.0, **changes):
    """Return a move of 3.2 s: 0.7 s up to 4, 1.8 s there, 0.7 s down."""
    given = {"velocity": 4.0, "acceleration": 8.0, "acceleration_jerk": 40.0, **changes}
    return s_curve_move(target, **given)


def by_halves(target=10.0, **changes):
    """Return a move of 3 s by jerk percent: 0.5 s up to 4, 2 s there, 0.5 s down."""
    given = {"velocity": 4.0, "acceleration": 8.0, "jerk_percent": 0.5, **changes}
    return s_curve_move(target, **given)


def assert_same_until(one, other, time, text=""):
    """Assert that two motions are the same up to a time."""
    times = np.linspace(one.start_time, time, 41)[:-1]
    scale = np.array([[one.peak(k)] for k in range(4)])
    error = np.abs(one.evaluate(times) - other.evaluate(times))
    assert (error <= 1e-12 * scale + 1e-14).all(), (text, error.max(axis=1))


def after(motion, time):
    """Return the part of a motion from a time on."""
    first = np.flatnonzero(motion.breaks == time)[0]
    return Trajectory.from_arrays(
        motion.breaks[first:],
        motion.states[first:],
        motion.durations[first:],
        motion.end_state,
    )


def interrupted(seed, kind=1):
    """Return a problem of generic numbers, its move, a time in it, and random changes."""
    rng = np.random.default_rng((kind, seed))
    problem = replace(random_s_curve(rng), final_velocity=0.0)
    if seed % 5 == 0:
        problem = by_percent(problem, float(rng.uniform()))
    move = problem.solve()
    return problem, move, float(rng.uniform(0.0, 1.2)) * move.duration, rng


# Modify


def test_modified_it_is_the_same_before_and_goes_to_the_new_target():
    for seed in SEEDS:
        problem, move, time, rng = interrupted(seed)
        target = float(rng.normal())
        changed = move.modify(time, target=target)
        text = f"{problem!r}.modify({time!r}, target={target!r})"
        assert_same_until(move, changed, time, text)
        assert changed.end_state.tolist() == [target, 0.0, 0.0, 0.0], text
        assert_continuous(text, changed, derivatives=2 if problem.percent is not None else 3)
        assert_within_rates(problem, changed)


def test_modified_by_nothing_it_takes_as_long():
    """Planned again on the way; to the third root of rounding."""
    for seed in SEEDS:
        problem, move, time, _ = interrupted(seed, kind=2)
        if problem.percent is None and time < move.end_time:
            again = move.modify(time)
            assert again.duration == pytest.approx(move.duration, rel=1e-4), (problem, time)
            assert again.settings == move.settings


@pytest.mark.parametrize(
    ("time", "changes"),
    [
        (1.5, {"velocity": 1.0}),  # at 4, without acceleration
        (0.4, {"velocity": 1.0}),  # speeding up at 8
        (0.1, {"velocity": 0.1}),  # speeding up at 4
        (0.4, {"acceleration": 2.0}),
        (0.4, {"acceleration": 2.0, "velocity": 0.5}),
        (2.75, {"deceleration": 6.0}),  # slowing down at 8
        (2.75, {"deceleration": 6.0, "velocity": 2.0}),
        (0.4, {"acceleration_jerk": 10.0}),
        (2.75, {"deceleration_jerk": 30.0}),
    ],
)
@pytest.mark.parametrize("equal", [True, False])
def test_limits_below_the_present_state_bring_it_down_without_a_jump(time, changes, equal):
    move = go() if equal else go(deceleration_jerk=40.1)
    changed = move.modify(time, **changes)
    text = f"go({'' if equal else 'deceleration_jerk=40.1'}).modify({time!r}, **{changes!r})"
    assert_same_until(move, changed, time, text)
    assert_continuous(text, changed)
    assert changed.end_state.tolist() == [10.0, 0.0, 0.0, 0.0]
    _, v, a, _ = move.evaluate(time).tolist()
    jerk = changes.get("acceleration_jerk", 40.0)
    settling = v + 0.5 * a * a / jerk if a > 0.0 else v
    rest = after(changed, time)
    highest = max(changes.get("velocity", 4.0), settling)
    assert rest.peak("velocity") <= highest * (1.0 + 1e-12), text
    if "velocity" in changes and time < 2.0:
        assert (rest.states[:, 1] == changes["velocity"]).any(), text


def test_lowered_limits_are_kept_once_it_is_inside():
    for seed in SEEDS:
        problem, move, time, rng = interrupted(seed, kind=3)
        _, v, a, _ = move.evaluate(time).tolist()
        if problem.percent is not None or a * v < 0.0 or time >= move.end_time:
            continue
        names = [name for name in RATES[:3] if rng.random() < 0.6]
        lower = {name: float(rng.uniform(0.2, 1.0)) * problem.settings()[name] for name in names}
        changed = move.modify(time, **lower)
        text = f"{problem!r}.modify({time!r}, **{lower!r})"
        assert_same_until(move, changed, time, text)
        assert_continuous(text, changed)
        begun = replace(problem, start=(0.0, abs(v) + 0.5 * a * a / problem.jerks[0], 0.0), **lower)
        rest = after(changed, time)
        if abs(a) > begun.acceleration:  # brought down first
            rest = after(changed, rest.breaks[1])
        assert_within_rates(begun, rest)


def test_every_setting_can_be_changed():
    changes = {
        "velocity": 3.0,
        "acceleration": 4.0,
        "deceleration": 5.0,
        "acceleration_jerk": 20.0,
        "deceleration_jerk": 30.0,
    }
    for name, value in changes.items():
        changed = go().modify(0.0, **{name: value})
        assert getattr(changed.settings.rates, name) == value
        assert changed.duration > go().duration
    whole = go().modify(0.0, target=20.0, final_velocity=1.0, **changes)
    direct = go(20.0, final_velocity=1.0, **changes)
    assert whole.settings == direct.settings
    np.testing.assert_array_equal(whole.states, direct.states)
    assert go().modify(1.0).settings == go().settings


def test_by_percent_the_new_plan_begins_without_acceleration():
    move = by_halves()
    changed = move.modify(0.25, target=12.0)
    assert move(0.25, "acceleration") == pytest.approx(32.0 / 3.0)
    assert changed(0.25, "acceleration") == 0.0
    assert changed(0.25, "velocity") == pytest.approx(2.0)
    assert max(replay(changed).gaps[:2]) < 1e-14
    assert changed(0.25) == pytest.approx(7.0 / 36.0)
    cruise = (12.0 - 7.0 / 36.0 - 0.75 - 1.0) / 4.0
    assert changed.duration == pytest.approx(0.25 + 0.25 + cruise + 0.5)


@pytest.mark.parametrize("make", [go, by_halves])
def test_modified_after_the_end_it_starts_from_rest(make):
    move = make()
    changed = move.modify(5.0, target=0.0)
    assert changed.duration == pytest.approx(5.0 + move.duration, rel=1e-14)
    assert changed([4.0, 5.0]).tolist() == [10.0, 10.0]
    assert changed.end_state.tolist() == [0.0] * 4
    assert make(final_velocity=2.0).modify(5.0, target=30.0)(5.0) == pytest.approx(
        10.0 + 2.0 * (5.0 - make(final_velocity=2.0).end_time)
    )


@pytest.mark.parametrize("make", [go, by_halves])
def test_modified_at_its_start_it_is_the_other_move(make):
    changed, other = make().modify(0.0, target=4.0), make(4.0)
    np.testing.assert_array_equal(changed.states, other.states)
    late = make(delay=2.0).modify(2.0, target=4.0)
    np.testing.assert_array_equal(late.states, other.states)
    assert late.start_time == 2.0


def test_modified_again_and_again():
    move = go()
    for k in range(12):
        move = move.modify(0.25 * (k + 1), target=10.0 * (-1.0) ** k, velocity=4.0 + k % 3)
    assert_continuous("12 modifications", move)
    assert move.end_state.tolist() == [-10.0, 0.0, 0.0, 0.0]
    assert move.peak("acceleration") <= 8.0 * (1.0 + 1e-12)
    assert isinstance(move, SCurveMove)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"time": nan}, "^time = nan: expected a finite number$"),
        ({"time": inf}, "^time = inf: expected a finite number$"),
        ({"time": 1.0, "target": nan}, "^target = nan: expected a finite number$"),
        ({"time": 1.0, "final_velocity": 5.0}, "^final_velocity = 5.0: expected at most the vel"),
        ({"time": 1.0, "velocity": 0.5, "final_velocity": 1.0}, "expected at most the velocity, 0"),
    ],
)
def test_modify_refuses_wrong_values(arguments, message):
    with pytest.raises(ValueError, match=message):
        go().modify(**arguments)


def test_a_final_velocity_beyond_the_new_velocity_is_refused():
    with pytest.raises(
        ValueError, match=r"^final_velocity = 3.0: expected at most the velocity, 2"
    ):
        go(final_velocity=3.0).modify(1.0, velocity=2.0)


# Append


@pytest.mark.parametrize("delay", [0.0, 0.75])
@pytest.mark.parametrize("make", [go, by_halves])
def test_appended_it_is_one_move_after_the_other(make, delay):
    move = make(deceleration=4.0, dt=0.01, no_reversal=True)
    both, back = move.append(15.0, delay=delay), make(5.0, deceleration=4.0)
    assert both.settings == move.settings
    assert both.duration == pytest.approx(move.duration + delay + back.duration, rel=1e-14)
    assert_same_until(move, both, move.end_time)
    times = np.linspace(0.0, back.duration, 33)[:-1]
    error = both(move.end_time + delay + times) - (10.0 + back(times))
    np.testing.assert_allclose(error, 0.0, atol=1e-12)
    assert both(move.end_time + delay / 2) == 10.0
    relative = move.append(5.0, relative=True, delay=delay)
    np.testing.assert_array_equal(relative.states, both.states)


@pytest.mark.parametrize("make", [go, by_halves])
def test_with_a_final_velocity_it_goes_on_without_a_stop(make):
    move = make(final_velocity=2.0)
    both = move.append(5.0, relative=True, delay=0.5)
    assert both.end_state.tolist() == [15.0, 2.0, 0.0, 0.0]
    assert both(move.end_time + 0.25, "velocity") == 2.0
    assert both(move.end_time + 0.5) == pytest.approx(11.0)
    assert both.extremes("velocity")[0] == 0.0  # at the start only
    assert_continuous("go(final_velocity=2.0).append(5.0, relative=True, delay=0.5)", both)


def test_appended_moves_can_be_modified_and_appended_to():
    move = go().append(0.0, delay=0.5).append(5.0).modify(4.0, target=1.0).append(2.0)
    assert_continuous("append, append, modify, append", move)
    assert move.end_state.tolist() == [2.0, 0.0, 0.0, 0.0]
    assert move.peak("velocity") <= 4.0 * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": inf}, "^target = inf: expected a finite number$"),
        ({"target": 1.0, "delay": -0.5}, "^delay = -0.5: expected a time ≥ 0$"),
        ({"target": 1.0, "delay": nan}, "^delay = nan: expected a finite number$"),
    ],
)
def test_append_refuses_wrong_values(arguments, message):
    with pytest.raises(ValueError, match=message):
        go().append(**arguments)


def test_it_is_a_trajectory_as_any_other():
    move = go()
    assert repr(move) == "SCurveMove(order=3, pieces=7, start=0, end=10, duration=3.2)"
    assert move.mirror()(3.2) == -10.0
    assert move.then(go(-10.0)).end_state[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        move.states[0, 0] = 1.0


# What once failed


def test_slowing_down_too_hard_not_to_turn_has_no_jump():
    move = s_curve_move(
        1.0,
        velocity=4.0,
        acceleration=1.0,
        deceleration=0.5,
        acceleration_jerk=1.0,
        deceleration_jerk=0.1,
        start=(0.0, 0.1, -1.0),
    )
    following = np.vstack([move.states[1:], move.end_state])
    for state, time, after in zip(move.states, move.durations, following, strict=True):
        x, v, a, j = state
        reached = [x + v * time + a * time**2 / 2 + j * time**3 / 6, v + a * time + j * time**2 / 2]
        assert reached == pytest.approx(after[:2].tolist(), abs=1e-12)


@pytest.mark.parametrize(
    "rates", [{"acceleration_jerk": 4.0, "deceleration_jerk": 1.0}, {"jerk_percent": 0.5}]
)
def test_a_move_to_where_it_rests_takes_no_time(rates):
    move = s_curve_move(7.0, start=7.0, velocity=1, acceleration=4, deceleration=0.25, **rates)
    assert (move.duration, len(move.states)) == (0.0, 0)


def test_a_dip_shortens_the_way_to_a_higher_velocity():
    rates = {"velocity": 10.0, "acceleration": 100.0, "acceleration_jerk": 1.0}
    ends = {"start": (0.0, 1.0), "final_velocity": 10.0}
    nearly = s_curve_move(32.95, **rates, deceleration=100.00001, **ends)
    assert nearly.duration == pytest.approx(s_curve_move(32.95, **rates, **ends).duration, rel=1e-9)


@pytest.mark.parametrize("target", [2.0, 2.5, 2.6])
def test_a_start_above_the_velocity_is_slowed_at_once(target):
    rates = {"velocity": 1.0, "acceleration": 1.0, "acceleration_jerk": 1.0}
    nearly, equal = (
        s_curve_move(target, **rates, deceleration=d, start=(0.0, 0.9, 0.7)) for d in (1 + 1e-9, 1)
    )
    assert nearly.duration == pytest.approx(equal.duration, rel=1e-7)


def test_a_delayed_move_modified_while_it_waits():
    rates = {"velocity": 4.0, "acceleration": 8.0, "acceleration_jerk": 40.0}
    changed = s_curve_move(10.0, **rates, delay=1.0).modify(0.5, target=3.0)
    assert changed.start_time == 0.5
    assert changed.duration == s_curve_move(3.0, **rates).duration
