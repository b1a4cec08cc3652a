"""S-curve moves from outside: rest-to-rest moves, trapezoids, modify and append, refusals."""

from dataclasses import replace
from math import inf, nan, sqrt
from sys import float_info

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from references import thompson_order_2
from s_curves import (
    SCurve,
    assert_continuous,
    assert_ends,
    assert_within_rates,
    by_percent,
    random_s_curve,
)

from jounce.shaping import (
    InfeasibleError,
    Limits,
    SCurveMove,
    min_time_move,
    min_time_transfer,
    s_curve_move,
)

SEEDS = range(100)
RATE = st.floats(-1.0, 1.0).map(lambda exponent: 10.0**exponent)
JERKS = {"acceleration_jerk": 40.0}
PERCENT = {"jerk_percent": 0.5}


def go(target=10.0, **changes):
    """Return a move of 3.2 s: 0.7 s up to 4, 1.8 s there, 0.7 s down."""
    return s_curve_move(target, **{"velocity": 4.0, "acceleration": 8.0, **JERKS, **changes})


def by_halves(target=10.0, **changes):
    """Return a move of 3 s by jerk percent: 0.5 s up to 4, 2 s there, 0.5 s down."""
    return s_curve_move(target, velocity=4.0, acceleration=8.0, **{**PERCENT, **changes})


def assert_same_motion(one, other, times, text=""):
    scale = np.array([[one.peak(k)] for k in range(3)])
    error = np.abs(one.evaluate(times, 2) - other.evaluate(times, 2))
    assert (error <= 1e-12 * scale + 1e-14).all(), (text, error.max(axis=1))


# Against others


@given(rates=st.tuples(RATE, RATE, RATE), seed=st.integers(0, 2**32 - 1))
def test_with_equal_rates_it_is_the_transfer(rates, seed):
    velocity, acceleration, jerk = rates
    rng = np.random.default_rng(seed)
    start, end = (tuple(map(float, rng.normal(size=3) * (1.0, 0.5 * velocity, 0.1 * acceleration)))
                  for _ in range(2))  # fmt: skip
    final = max(min(end[1], velocity), -velocity)
    problem = SCurve(end[0], velocity, acceleration, acceleration, (jerk,) * 2, start, final)
    move = problem.solve()
    transfer = min_time_transfer(start, (end[0], final), Limits(velocity, acceleration, jerk))
    np.testing.assert_array_equal(move.durations, transfer.durations, repr(problem))
    np.testing.assert_array_equal(move.states, transfer.states, repr(problem))
    assert isinstance(move, SCurveMove)


@pytest.mark.parametrize("way", [1.0, -1.0])
@given(rates=st.tuples(*[RATE] * 4), distance=st.floats(-2.0, 2.0).map(lambda x: 10.0**x))
def test_from_rest_to_rest_it_is_the_move_with_bounds_either_way(way, rates, distance):
    velocity, acceleration, deceleration, jerk = rates
    problem = SCurve(way * distance, velocity, acceleration, deceleration, (jerk, jerk))
    limits = Limits(velocity, (-deceleration, acceleration), jerk)
    move = min_time_move(way * distance, limits if way > 0.0 else limits.mirror())
    found = problem.solve()
    assert found.duration == pytest.approx(move.duration, rel=1e-12), problem
    assert_same_motion(found, move, np.linspace(0.0, move.duration, 41), problem)


@pytest.mark.parametrize("round_numbers", [False, True], ids=["generic", "round"])
def test_any_move_is_sound(round_numbers):
    for seed in SEEDS:
        problem = random_s_curve(np.random.default_rng((1, seed)), round_numbers=round_numbers)
        move = problem.solve()
        assert_ends(problem, move)
        assert_continuous(problem, move)
        assert_within_rates(problem, move)


# Targets and delays


def test_a_relative_target_counts_from_the_start():
    for start in (0.0, 7.0, (-3.0, 1.0), (2.0, -1.0, 0.5)):
        place = np.atleast_1d(start)[0]
        one, other = go(5.0, start=start, relative=True), go(5.0 + place, start=start)
        np.testing.assert_array_equal(one.states, other.states)
        assert one.end_state[0] == 5.0 + place


def test_a_delay_comes_before_the_motion():
    plain, late = go(), go(delay=1.5)
    assert (late.start_time, late.end_time) == (1.5, pytest.approx(4.7, rel=1e-15))
    np.testing.assert_array_equal(late.states, plain.states)
    assert late([0.0, 1.5]).tolist() == [0.0, 0.0]
    coasting = go(start=(0.0, 2.0), delay=1.5)
    assert coasting(0.5, "velocity") == 2.0


def test_the_rates_left_out():
    assert go().duration == go(deceleration=8.0, deceleration_jerk=40.0).duration
    assert go().settings.rates.deceleration_jerk == 40.0
    assert go(start=(0.0, 1.0, 0.0, 9.0)).duration == go(start=(0.0, 1.0)).duration


# No reversal


def assert_nearest_without_reversal(problem, error):
    """Assert that the nearest target is reached without turning round, and no nearer one."""
    assert error.bound == "position"
    nearest = replace(problem, target=error.nearest)
    assert refusal(nearest) is None, nearest
    nearer = error.nearest - 1e-3 * (error.nearest - problem.start[0])
    assert refusal(replace(problem, target=nearer)) is not None, problem


def refusal(problem):
    """Return the error with which a problem is refused, None where it does not turn round."""
    low, high = problem.solve().extremes("velocity")
    slight = 1e-9 * problem.velocity
    if low >= -slight or high <= slight:
        assert problem.solve(no_reversal=True).duration == problem.solve().duration, problem
        return None
    with pytest.raises(InfeasibleError, match="takes a reversal, which no_reversal") as caught:
        problem.solve(no_reversal=True)
    return caught.value


@pytest.mark.parametrize("percent", [None, 0.0, 0.5])
def test_no_reversal_names_the_nearest_target(percent):
    refused = 0
    for seed in SEEDS:
        problem = replace(random_s_curve(np.random.default_rng((2, seed))), final_velocity=0.0)
        if percent is not None:
            problem = by_percent(problem, percent)
        elif problem.settling * problem.start[1] <= 0.0:
            continue  # it turns round wherever it goes, or rests
        error = refusal(problem)
        if error is not None:
            assert repr(problem.target) in str(error)
            assert repr(error.nearest) in str(error)
            assert_nearest_without_reversal(problem, error)
            refused += 1
    assert refused > 20


def test_no_reversal_stays_in_force():
    move = go(no_reversal=True)
    with pytest.raises(InfeasibleError, match=r"target = 0\.0 takes a reversal") as caught:
        move.modify(1.0, target=0.0)
    v = move(1.0, "velocity")
    assert caught.value.nearest == pytest.approx(move(1.0) + v * (v / 8.0 + 8.0 / 40.0) / 2.0)
    assert move.modify(1.0, target=caught.value.nearest).end_state[0] == caught.value.nearest
    assert go(-10.0, no_reversal=True).duration == go().duration


# By jerk percent


@given(
    rates=st.tuples(RATE, RATE),
    distance=st.floats(-2.0, 2.0).map(lambda x: 10.0**x),
    percent=st.sampled_from([0.0, 0.25, 0.5, 1.0]) | st.floats(1e-9, 1.0),
)
def test_jerk_percent_lasts_as_long_as_thompsons_trapezoid(rates, distance, percent):
    velocity, acceleration = rates
    expected = thompson_order_2(distance, velocity, acceleration)
    problem = SCurve(distance, velocity, acceleration, acceleration, percent=percent)
    move = problem.solve()
    assert move.duration == pytest.approx(expected.duration, rel=1e-12), problem
    assert move.peak("velocity") == pytest.approx(expected.peaks[0], rel=1e-12), problem
    peak = acceleration / (1.0 - 0.5 * percent)
    assert move.extremes("acceleration") == pytest.approx((-peak, peak), rel=1e-12), problem
    ramp = expected.peaks[0] / acceleration
    curved = move.durations[move.states[:, 3] != 0.0]
    assert len(curved) == (4 if percent * ramp > 0.0 else 0), problem
    np.testing.assert_allclose(curved, 0.5 * percent * ramp, rtol=1e-12, err_msg=repr(problem))


def test_jerk_percent_by_hand():
    none, half, whole = (by_halves(jerk_percent=p) for p in (0.0, 0.5, 1.0))
    assert none.duration == half.duration == whole.duration == 3.0
    assert [m.peak("acceleration") for m in (none, half, whole)] == pytest.approx([8, 32 / 3, 16])
    assert none.breaks.tolist() == [0.0, 0.5, 2.5, 3.0]
    assert half.breaks == pytest.approx([0, 0.125, 0.375, 0.5, 2.5, 2.625, 2.875, 3.0])
    assert whole.breaks == pytest.approx([0, 0.25, 0.5, 2.5, 2.75, 3.0])  # never held
    assert none.peak("jerk") == 0.0
    assert whole.peak("jerk") == pytest.approx(64.0)


def test_by_percent_slowing_down_has_a_ramp_of_its_own():
    move = by_halves(deceleration=2.0)
    assert move.duration == pytest.approx(0.5 + 5.0 / 4.0 + 2.0, rel=1e-14)
    assert move.extremes("acceleration") == pytest.approx((-8.0 / 3.0, 32.0 / 3.0), rel=1e-14)
    assert_same_motion(move, by_halves(-10.0, deceleration=2.0).mirror(), np.linspace(0, 4, 99))


# Remarks


def test_remarks_say_where_a_jerk_makes_no_sense():
    """From a²/v = 16 to a/dt."""
    assert go(dt=0.2).remarks == go(acceleration_jerk=16.0, dt=0.5).remarks == ()
    assert go().remarks == by_halves().remarks == by_halves(dt=9.0).remarks == ()
    (low, same) = go(acceleration_jerk=15.0).remarks
    assert low.startswith("acceleration_jerk = 15 is below acceleration²/velocity = 16: ")
    assert same.startswith("deceleration_jerk = 15 is below deceleration²/velocity = 16: ")
    assert go(acceleration_jerk=15.0).peak("acceleration") < 8.0
    [high] = go(dt=0.25, deceleration_jerk=20.0).remarks
    assert high == (
        "acceleration_jerk = 40 is above acceleration/dt = 32: the acceleration of 8 is reached "
        "within one sample"
    )
    [below] = go(deceleration=16.0).remarks
    assert "deceleration²/velocity = 64" in below
    assert go().modify(1.0, deceleration=16.0).remarks == (below,)


@given(rates=st.tuples(RATE, RATE, RATE))
def test_below_the_least_jerk_the_acceleration_is_not_reached(rates):
    velocity, acceleration, jerk = rates
    assume(abs(velocity * jerk / acceleration**2 - 1.0) > 1e-9)
    move = s_curve_move(1e4, velocity=velocity, acceleration=acceleration, acceleration_jerk=jerk)
    assert bool(move.remarks) == (sqrt(velocity * jerk) < acceleration)
    assert bool(move.remarks) == (move.peak("acceleration") < acceleration)


# Refusals

WRONG = {0.0: "positive", -1.0: "positive", nan: "positive", inf: "positive"}
POSITIVE = ("velocity", "acceleration", "deceleration", "acceleration_jerk", "deceleration_jerk")


@pytest.mark.parametrize("name", [*POSITIVE, "dt"])
@pytest.mark.parametrize("value", WRONG)
def test_rates_must_be_positive(name, value):
    message = rf"^{name} = {value!r}: expected a positive, finite number$"
    with pytest.raises(ValueError, match=message):
        go(**{name: value})
    if name != "dt":
        with pytest.raises(ValueError, match=message):
            go().modify(1.0, **{name: value})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"target": nan}, "^target = nan: expected a finite number$"),
        ({"start": (0.0, inf)}, "^start velocity = inf: expected a finite number$"),
        ({"start": ()}, r"^start = \(\): expected \(position, velocity, acceleration\)"),
        ({"delay": nan}, "^delay = nan: expected a finite number$"),
        ({"delay": -1.0}, "^delay = -1.0: expected a time ≥ 0$"),
        ({"final_velocity": nan}, "^final_velocity = nan: expected a finite number$"),
        ({"final_velocity": -4.1}, "^final_velocity = -4.1: expected at most the velocity, 4.0"),
        ({"acceleration_jerk": None}, "^no jerk given: expected acceleration_jerk or jerk_perc"),
        ({"jerk_percent": 0.5}, "^jerk_percent = 0.5 beside a jerk: give one or the other$"),
        ({"acceleration_jerk": None, "jerk_percent": 50}, "^jerk_percent = 50: expected 0 to 1"),
        ({"acceleration_jerk": None, "jerk_percent": -0.1}, "^jerk_percent = -0.1: expected 0"),
        ({"acceleration_jerk": None, "jerk_percent": nan}, "^jerk_percent = nan: expected a fin"),
        ({"target": 1e300, "velocity": 1e-300, "deceleration": 2.0}, "leaves the range of a dou"),
    ],
)
def test_other_wrong_values_are_named(changes, message):
    with pytest.raises(ValueError, match=message):
        go(**changes)


@pytest.mark.parametrize("name", ["target", "velocity", "delay", "final_velocity", "start"])
def test_what_is_no_number_is_refused(name):
    with pytest.raises(TypeError, match=rf"^{name}.* = 'fast': expected a number.*, not str$"):
        go(**{name: "fast"})


# What modify and append may change, and what a jerk percent keeps


@pytest.mark.parametrize("percent", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("distance", [0.5, 20.0])
def test_a_percent_that_keeps_the_acceleration_never_passes_it(percent, distance):
    """Ramps take Δv/A/(1 − p/2): by hand, for a move with a cruise and for one without."""
    move = s_curve_move(
        distance,
        velocity=4.0,
        acceleration=8.0,
        jerk_percent=percent,
        percent_keeps="acceleration",
    )
    assert move.peak("acceleration") == pytest.approx(8.0, rel=1e-12)
    slower = 1.0 / (1.0 - 0.5 * percent)
    ramp = 4.0 / 8.0 * slower
    if distance >= 4.0 * ramp:
        assert move.duration == pytest.approx(distance / 4.0 + ramp, rel=1e-12)
    else:  # v²·slower/A = distance
        velocity = (8.0 * distance / slower) ** 0.5
        assert move.duration == pytest.approx(2.0 * velocity / 8.0 * slower, rel=1e-12)


def test_the_smaller_the_percentage_the_quicker_a_move_that_keeps_the_acceleration():
    durations = [
        s_curve_move(
            0.5,
            velocity=4.0,
            acceleration=8.0,
            jerk_percent=percent,
            percent_keeps="acceleration",
        ).duration
        for percent in (0.0, 0.2, 0.5, 1.0)
    ]
    assert durations == sorted(durations)
    assert durations[0] < durations[-1]
    with pytest.raises(ValueError, match="percent_keeps = 'jerk': expected 'duration' or"):
        s_curve_move(1, velocity=1, acceleration=1, jerk_percent=0.5, percent_keeps="jerk")


def test_a_relative_modification_is_one_of_the_target():
    move = s_curve_move(10.0, velocity=4.0, acceleration=8.0, acceleration_jerk=40.0)
    further = move.modify(0.5, target=2.5, relative=True)
    same = move.modify(0.5, target=12.5)
    assert further.states.tolist() == same.states.tolist()
    stays = move.modify(0.5, velocity=2.0, relative=True)
    assert stays.end_state[0] == 10.0


def test_what_is_appended_has_rates_of_its_own_if_it_is_given_some():
    first = s_curve_move(10.0, velocity=4.0, acceleration=8.0, acceleration_jerk=40.0)
    both = first.append(5.0, relative=True, velocity=1.0, deceleration=2.0, final_velocity=0.5)
    alone = s_curve_move(
        15.0,
        start=10.0,
        velocity=1.0,
        acceleration=8.0,
        deceleration=2.0,
        acceleration_jerk=40.0,
        final_velocity=0.5,
    )
    assert both.duration - first.duration == pytest.approx(alone.duration, rel=1e-12)
    assert both.end_state[:2].tolist() == [15.0, 0.5]
    with pytest.raises(ValueError, match=r"final_velocity = 2.0: expected at most the velocity"):
        first.append(5.0, velocity=1.0, final_velocity=2.0)


HUGE = 1e200, 1e300, float_info.max
START = (0.5, -0.3, 0.2)


@pytest.mark.parametrize("huge", HUGE)
@pytest.mark.parametrize("target", [3.0, -2.0, 1e-5])
@pytest.mark.parametrize("name", ["acceleration", "deceleration"])
def test_a_huge_rate_is_none(name, target, huge):
    rates = {"velocity": 2.0, "acceleration": 3.0, "deceleration": 1.5, "acceleration_jerk": 8.0}
    rates["deceleration_jerk"] = 5.0
    given = s_curve_move(target, start=START, **{**rates, name: huge})
    large = s_curve_move(target, start=START, **{**rates, name: 1e6})
    assert given.duration == pytest.approx(large.duration, rel=1e-12)


@pytest.mark.parametrize("huge", HUGE)
def test_two_huge_rates_are_alike(huge):
    """Without a bound either way there is nothing for which to stop before turning round."""
    start = (1.0, -6.5, 0.0)
    jerk = {"velocity": 4.0, "acceleration_jerk": 87.0}
    move = s_curve_move(0.0, start=start, final_velocity=3.5, acceleration=1e250,
                        deceleration=huge, **jerk)  # fmt: skip
    limits = Limits(velocity=4.0, jerk=87.0)
    assert move.duration == min_time_transfer(start, (0.0, 3.5), limits).duration


@pytest.mark.parametrize("percent", [0.2, 1.0])
def test_by_percent_a_huge_acceleration_leaves_the_cruise(percent):
    move = s_curve_move(3.0, velocity=2.0, acceleration=1e300, deceleration=1.5,
                        jerk_percent=percent)  # fmt: skip
    assert move.duration == pytest.approx(3.0 / 2.0 + 2.0 / 1.5 / 2.0, rel=1e-14)


def test_a_short_way_at_speed_is_gone_to_its_end():
    """The peak is above the final velocity by less than its own digits tell."""
    move = s_curve_move(1.25e-5, final_velocity=0.35, velocity=9.0, acceleration=1e250,
                        acceleration_jerk=1e200, deceleration_jerk=0.5)  # fmt: skip
    h, (x, v, a, j) = move.durations[-2], move.states[-2]
    assert move.states[-1][0] == pytest.approx(x + h * (v + h * (a / 2 + h * j / 6)), rel=1e-13)
