"""velocity_move: ramps by hand, bounds for speeding up and slowing down, modify and append."""

from math import inf, nan, sqrt

import numpy as np
import pytest
from references import replay
from s_curves import SCurve, assert_continuous, assert_within_rates, ramp_time

from jounce.shaping import Limits, VelocityMove, s_curve_move, velocity_move, velocity_transfer

RATES = {
    "acceleration": 8.0,
    "deceleration": 2.0,
    "acceleration_jerk": 40.0,
    "deceleration_jerk": 5.0,
}
SEEDS = range(150)


def go(velocity=4.0, **changes):
    """Return a change of velocity with four rates."""
    return velocity_move(velocity, **{**RATES, **changes})


def random_change(seed):
    """Return rates, start and final velocity, generic."""
    rng = np.random.default_rng((41, seed))
    rates = dict(zip(RATES, (10.0 ** rng.uniform(-1.0, 1.0, 4)).tolist(), strict=True))
    v0, v1 = rng.normal(size=2).tolist()
    most = min(rates["acceleration"], rates["deceleration"])
    a0 = float(rng.uniform(-1.0, 1.0)) * most if seed % 3 == 0 else 0.0
    return rates, (float(rng.normal()), v0, a0), v1


def assert_sound(text, move, start, final, rates):
    assert move.start_state[:3].tolist() == pytest.approx(start, rel=1e-14), text
    assert move.end_state[1:].tolist() == [final, 0.0, 0.0], text
    assert_continuous(text, move)
    fastest = 2.0 * max(move.peak(1), 1e-300)
    problem = SCurve(0.0, fastest, *list(rates.values())[:2], tuple(rates.values())[2:])
    assert_within_rates(problem, move)


def taken(change, acceleration, jerk, a=0.0):
    """Return the time of a change of velocity that begins with acceleration a ≥ 0 towards it."""
    peak = sqrt(jerk * change + 0.5 * a * a)
    if peak <= acceleration:
        return (2.0 * peak - a) / jerk
    held = (change - (acceleration**2 - 0.5 * a * a) / jerk) / acceleration
    return (2.0 * acceleration - a) / jerk + held


def by_hand(v0, v1, rates):
    """Return the least time between two velocities, without acceleration at either."""
    up = rates["acceleration"], rates["acceleration_jerk"]
    down = rates["deceleration"], rates["deceleration_jerk"]
    if v0 * v1 < 0.0:
        return ramp_time(abs(v0), *down) + ramp_time(abs(v1), *up)
    return ramp_time(abs(v1 - v0), *(up if abs(v1) > abs(v0) else down))


def test_any_change_keeps_its_four_rates_and_takes_the_least_time():
    for seed in SEEDS:
        rates, start, final = random_change(seed)
        text = f"velocity_move({final!r}, **{rates!r}, start={start!r})"
        move = velocity_move(final, start=start, **rates)
        assert_sound(text, move, start, final, rates)
        if not start[2]:
            assert move.duration == pytest.approx(by_hand(start[1], final, rates), rel=1e-12), text


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("a", [1.0, 3.0, 7.9])
@pytest.mark.parametrize("final", [2.0, 3.0, 9.0])
def test_an_acceleration_at_the_start_is_gone_on_with(sign, a, final):
    """From velocity 1; a leads to 1 + a²/2J, at most 1.79."""
    move = go(sign * final, start=(0.0, sign, sign * a))
    assert move.duration == pytest.approx(taken(final - 1.0, 8.0, 40.0, a), rel=1e-12)
    away = go(sign * 0.5, start=(0.0, sign, sign * a))
    top = 1.0 + a * a / 80.0
    assert away.duration == pytest.approx(a / 40.0 + taken(top - 0.5, 2.0, 5.0), rel=1e-12)
    assert sign * away.evaluate(a / 40.0)[1] == pytest.approx(top)


def test_with_the_same_rates_it_is_a_velocity_transfer():
    for seed in SEEDS:
        rates, start, final = random_change(seed)
        a, jerk = rates["acceleration"], rates["acceleration_jerk"]
        move = velocity_move(final, acceleration=a, acceleration_jerk=jerk, start=start)
        same = velocity_transfer(start, final, Limits(acceleration=a, jerk=jerk))
        np.testing.assert_array_equal(move.states, same.states)


@pytest.mark.parametrize("percent", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("v0", "v1"), [(0.0, 4.0), (4.0, 1.0), (-2.0, 4.0), (3.0, -4.0)])
def test_by_jerk_percent_it_lasts_as_long_as_at_constant_acceleration(percent, v0, v1):
    rates = {"acceleration": 8.0, "deceleration": 2.0, "jerk_percent": percent}
    move = velocity_move(v1, start=(0.0, v0), **rates)
    down = max(abs(v0) - (abs(v1) if v0 * v1 > 0.0 else 0.0), 0.0) / 2.0
    up = max(abs(v1) - (abs(v0) if v0 * v1 > 0.0 else 0.0), 0.0) / 8.0
    assert move.duration == pytest.approx(down + up, rel=1e-14)
    slower = velocity_move(v1, start=(0.0, v0), percent_keeps="acceleration", **rates)
    assert slower.duration == pytest.approx((down + up) / (1.0 - 0.5 * percent), rel=1e-14)
    bounds = {True: 8.0, False: 2.0}
    times = np.linspace(0.0, slower.duration, 2000)[1:-1]
    _, v, a = slower.evaluate(times, 2)
    for speeds_up, bound in bounds.items():
        assert np.abs(a[(a * v > 0.0) == speeds_up]).max(initial=0.0) <= bound * (1.0 + 1e-12)
    one = velocity_move(v1, start=(0.0, v0), acceleration=8.0, jerk_percent=percent)
    assert one.duration == pytest.approx(abs(v1 - v0) / 8.0, rel=1e-14)


def test_relative_to_the_velocity_at_the_start():
    for v in (0.0, 3.0, -2.0):
        there, same = go(1.5, start=(7.0, v), relative=True), go(v + 1.5, start=(7.0, v))
        np.testing.assert_array_equal(there.states, same.states)
    limits = Limits(acceleration=1.0, jerk=2.0)
    change = velocity_transfer((0.0, 3.0), -1.0, limits, relative=True)
    assert change.states.tolist() == velocity_transfer((0.0, 3.0), 2.0, limits).states.tolist()


def test_after_its_end_and_before_its_start_it_coasts():
    late = go(start=(1.0, 2.0), delay=1.5)
    assert late(0.5) == pytest.approx(1.0 - 2.0)
    assert late(1.5) == 1.0
    assert (late.start_time, late(99.0, "velocity")) == (1.5, 4.0)
    changed = late.modify(0.5, velocity=-1.0)
    assert changed.start_state[:2].tolist() == [-1.0, 2.0]
    assert changed.start_time == 0.5


# Modify


def test_modified_nothing_jumps_and_the_rates_hold():
    for seed in SEEDS:
        rates, start, final = random_change(seed)
        rng = np.random.default_rng((42, seed))
        move = velocity_move(final, start=start, **rates)
        time = float(rng.uniform(0.0, 1.2)) * move.duration
        new = float(rng.normal())
        changed = move.modify(time, velocity=new)
        text = f"velocity_move({final!r}, **{rates!r}, start={start!r}).modify({time!r}, {new!r})"
        assert_sound(text, changed, start, new, rates)
        early = np.linspace(0.0, time, 30)[:-1]
        np.testing.assert_allclose(changed(early), move(early), rtol=0, atol=1e-12)
        x, v, a = move.evaluate(time)[:3].tolist()
        rest = velocity_move(new, start=(x, v, a if time < move.duration else 0.0), **rates)
        assert changed.end_time - time == pytest.approx(rest.duration, rel=1e-9, abs=1e-9)
        again = move.modify(min(time, move.duration))
        assert again.duration == pytest.approx(move.duration, rel=1e-6), text


def test_every_rate_can_be_changed_under_way():
    move = go(9.0)
    for name, value in {"acceleration": 4.0, "acceleration_jerk": 10.0}.items():
        changed = move.modify(0.1, **{name: value})
        assert getattr(changed.settings.rates, name) == value
        assert changed.duration > move.duration
        assert_continuous(name, changed)
    down = go(0.0, start=(0.0, 9.0))
    for name, value in {"deceleration": 1.0, "deceleration_jerk": 1.0}.items():
        changed = down.modify(1.0, **{name: value})
        assert changed.duration > down.duration
        assert_continuous(name, changed)
    eased = move.modify(0.3, acceleration=2.0)  # at 8, brought inside first
    assert eased(0.3 + 6.0 / 40.0, "acceleration") == pytest.approx(2.0)
    again = move.modify(0.1, velocity=2.0, relative=True)
    assert again.end_state[1] == 11.0
    assert again.modify(0.2).end_state[1] == 11.0


def test_by_percent_the_new_ramp_begins_without_acceleration():
    move = velocity_move(4.0, acceleration=8.0, jerk_percent=0.5)
    changed = move.modify(0.25, velocity=0.0)
    assert changed(0.25, "acceleration") == 0.0
    assert changed(0.25, "velocity") == pytest.approx(2.0)
    assert changed.duration == pytest.approx(0.5)
    with pytest.raises(ValueError, match=r"jerk_percent = 0.5 beside a jerk"):
        move.modify(0.1, deceleration_jerk=2.0)


# Append


def test_appended_it_is_one_change_after_the_other():
    move = go(4.0)
    both = move.append(-3.0, relative=True, delay=0.5, deceleration=1.0, deceleration_jerk=2.0)
    assert both.end_state[1:].tolist() == [1.0, 0.0, 0.0]
    assert both.duration == pytest.approx(move.duration + 0.5 + ramp_time(3.0, 1.0, 2.0))
    assert both(move.duration + 0.25, "velocity") == 4.0
    assert_continuous("append", both.append(0.0))
    assert replay(both).extremes[1] == pytest.approx((0.0, 4.0))
    assert isinstance(both, VelocityMove)
    assert go(4.0).append(4.0).duration == pytest.approx(move.duration)


# Remarks and refusals


def test_a_jerk_reached_within_one_sample_is_remarked():
    [told] = go(dt=0.25).remarks
    assert told.startswith("acceleration_jerk = 40 is above acceleration/dt = 32: ")
    assert go().remarks == go(dt=0.01).remarks == ()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"velocity": nan}, "^velocity = nan: expected a finite number$"),
        ({"acceleration": 0.0}, "^acceleration = 0.0: expected a positive, finite number$"),
        ({"deceleration": inf}, "^deceleration = inf: expected a positive, finite number$"),
        ({"acceleration_jerk": None}, "^no jerk given: expected acceleration_jerk or jerk_perc"),
        ({"jerk_percent": 0.5}, "^jerk_percent = 0.5 beside a jerk: give one or the other$"),
        ({"percent_keeps": "jerk"}, "^percent_keeps = 'jerk': expected 'duration' or"),
        ({"delay": -1.0}, "^delay = -1.0: expected a time ≥ 0$"),
        ({"dt": 0.0}, "^dt = 0.0: expected a positive, finite number$"),
        ({"velocity": 1e300, "acceleration": 1e-300}, "leaves the range of a double"),
    ],
)
def test_wrong_values_are_named(changes, message):
    with pytest.raises(ValueError, match=message):
        go(**changes)


def test_modify_and_append_refuse_what_velocity_move_refuses():
    with pytest.raises(ValueError, match=r"^velocity = nan: expected a finite number$"):
        go().modify(0.1, velocity=nan)
    with pytest.raises(ValueError, match=r"^time = inf: expected a finite number$"):
        go().modify(inf)
    with pytest.raises(ValueError, match=r"^deceleration = -1.0: expected a positive"):
        go().append(1.0, deceleration=-1.0)


def test_where_it_is_as_fast_already_it_takes_no_time():
    for rates in (RATES, {"acceleration": 1.0, "jerk_percent": 0.5}):
        still = velocity_move(3.0, start=(7.0, 3.0), **rates)
        assert (still.duration, still.end_state.tolist()) == (0.0, [7.0, 3.0, 0.0, 0.0])
        assert velocity_move(0.0, **rates).duration == 0.0


def test_a_position_move_ends_in_the_same_ramp():
    """The last ramp of a long move is a change of velocity to rest."""
    move = s_curve_move(50.0, velocity=4.0, **RATES)
    stop = go(0.0, start=(0.0, 4.0))
    begun = move.end_time - stop.duration
    times = np.linspace(0.0, stop.duration, 40)[:-1]
    np.testing.assert_allclose(move(begun + times, 1), stop(times, 1), rtol=0, atol=1e-9)
