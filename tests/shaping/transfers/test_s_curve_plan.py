"""Plans that tell speeding up from slowing down: closed forms, transfers, identities."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from s_curves import (
    SCurve,
    assert_continuous,
    assert_ends,
    assert_within_rates,
    by_percent,
    ramp_time,
    random_s_curve,
)
from scipy.optimize import brentq

from jounce.shaping import min_time_transfer
from jounce.shaping.limits import Limits
from jounce.shaping.transfers.s_curve_plan import plan_move, stopping_place
from jounce.shaping.transfers.s_curve_rates import Rates

SEEDS = range(100)
ROUND = pytest.mark.parametrize("round_numbers", [False, True], ids=["generic", "round"])
RATES = st.tuples(*[st.floats(0.1, 10.0)] * 5)
ALONE = Rates(4.0, 2.0, 1.0, 8.0, 4.0)
"""Ramps between rest and 4: 2.25 s up, 4.25 s down."""


def duration(pieces):
    return sum(time for time, _ in pieces)


def with_equal_rates(rng, round_numbers):
    """Return a problem of a transfer, whose best motion never slows down to speed up again."""
    p = random_s_curve(rng, round_numbers=round_numbers)
    p = replace(p, deceleration=p.acceleration, jerks=(p.jerks[0],) * 2)
    a = p.start[2]
    room = 2.0 * p.jerks[0] * max(p.velocity - abs(p.start[1]), 0.0)
    p = replace(p, start=(*p.start[:2], float(np.clip(a, -(room**0.5), room**0.5))))
    if p.start[1:] == (0.0, 0.0):
        return p
    low, high = sorted([0.0, p.settling])
    return replace(p, final_velocity=min(max(p.final_velocity, low), high))


# Against others


@ROUND
def test_with_equal_rates_a_plan_without_reversal_is_the_transfer(round_numbers):
    """Where the transfer turns round the plan takes longer: it stops first."""
    straight = 0
    for seed in SEEDS:
        problem = with_equal_rates(np.random.default_rng((1, seed)), round_numbers)
        limits = Limits(problem.velocity, problem.acceleration, problem.jerks[0])
        end = (problem.target, problem.final_velocity)
        transfer, time = min_time_transfer(problem.start, end, limits), duration(problem.planned())
        assert time >= transfer.duration * (1.0 - 1e-9), problem
        low, high = transfer.extremes("velocity")
        slight = 1e-9 * problem.velocity
        if low >= -slight or high <= slight:
            assert time <= transfer.duration * 1.0000001, problem
            straight += 1
    assert straight > 20


def rest_to_rest(problem):
    """Return duration and peak velocity, from the times that ramps take alone."""
    up, down = zip((problem.acceleration, problem.deceleration), problem.jerks, strict=True)

    def ramps(peak):
        return ramp_time(peak, *up) + ramp_time(peak, *down)

    distance, top = abs(problem.target - problem.start[0]), problem.velocity
    rest = distance - 0.5 * top * ramps(top)
    if rest >= 0.0:
        return ramps(top) + rest / top, top
    peak = brentq(lambda w: 0.5 * w * ramps(w) - distance, 0.0, top, xtol=1e-300, rtol=1e-15)
    return ramps(peak), peak


@given(rates=RATES, distance=st.floats(-2.0, 2.0).filter(bool), place=st.sampled_from([0.0, 3.0]))
def test_from_rest_to_rest_it_is_two_ramps(rates, distance, place):
    velocity, acceleration, deceleration, *jerks = rates
    target = place + float(np.sign(distance) * 10.0 ** abs(distance))
    start = (place, 0.0, 0.0)
    problem = SCurve(target, velocity, acceleration, deceleration, tuple(jerks), start)
    time, peak = rest_to_rest(problem)
    assert duration(problem.planned()) == pytest.approx(time, rel=1e-12), problem
    assert problem.trajectory().peak("velocity") == pytest.approx(peak, rel=1e-12), problem


@pytest.mark.parametrize(
    ("start", "target", "final", "expected"),
    [
        ((0.0, 0.0, 0.0), 17.0, 0.0, 2.25 + 1.0 + 4.25),  # ramps cover 4.5 and 8.5
        ((0.0, 4.0, 0.0), 12.5, 0.0, 1.0 + 4.25),
        ((0.0, 4.0, 0.0), 8.5, 0.0, 4.25),
        ((0.0, 0.0, 0.0), 4.5, 4.0, 2.25),
        ((0.0, 4.0, 0.0), -4.5, 0.0, 4.25 + 2.25 + 4.25),  # stops at 8.5, and 13 back
        ((0.0, -4.0, 0.0), -4.0, 4.0, 4.25 + 2.25),  # stops at −8.5, and 4.5 on
        ((0.0, 4.0, 0.0), -0.5, 4.0, 4.25 + 2.25 + 4.25 + 2.25 + 0.125),
        ((0.0, -3.5, 1.0), -6.1171875 - 1.0 / 96.0, 0.0, 3.375 + 0.25),  # slows down already
        ((0.0, 0.125, -1.0), 1.0 / 96.0 - 13.0, 0.0, 0.25 + 2.25 + 4.25),
    ],
)
def test_by_hand(start, target, final, expected):
    text = f"plan_move({start!r}, {target!r}, {final!r}, {ALONE!r})"
    assert duration(plan_move(start, target, final, ALONE)) == pytest.approx(expected, rel=1e-13), (
        text
    )


# Identities


@ROUND
def test_speeding_up_and_slowing_down_have_rates_of_their_own(round_numbers):
    for seed in SEEDS:
        problem = random_s_curve(np.random.default_rng((2, seed)), round_numbers=round_numbers)
        motion = problem.trajectory()
        assert_ends(problem, motion)
        assert_continuous(problem, motion)
        assert_within_rates(problem, motion)


@ROUND
def test_by_jerk_percent_velocity_is_continuous_and_rates_are_raised(round_numbers):
    for seed in SEEDS:
        rng = np.random.default_rng((3, seed))
        problem = random_s_curve(rng, round_numbers=round_numbers)
        problem = by_percent(problem, float(rng.choice([0.0, 1.0, rng.uniform()])))
        motion = problem.trajectory()
        assert_ends(problem, motion)
        assert_continuous(problem, motion, derivatives=3 if problem.percent else 2)
        assert_within_rates(problem, motion)


@ROUND
def test_the_opposite_plan_is_the_mirror_image(round_numbers):
    for seed in SEEDS:
        problem = random_s_curve(np.random.default_rng((4, seed)), round_numbers=round_numbers)
        opposite = [(time, tuple(-x for x in row)) for time, row in problem.mirrored().planned()]
        assert opposite == problem.planned(), problem


@pytest.mark.parametrize(
    ("distance", "time"),
    [(-30, 0), (53, 0), (0, 40), (7, -31), (-20, 11), (-700, 0), (700, 0), (-950, 0), (0, -300)],
)
def test_units_of_powers_of_two_do_not_matter_to_the_last_bit(distance, time):
    for seed in range(40):
        problem = random_s_curve(np.random.default_rng((5, seed)))
        scaled = problem.in_units(2.0**distance, 2.0**time)
        motion, other = problem.trajectory(), scaled.trajectory()
        np.testing.assert_array_equal(other.durations, motion.durations * 2.0**time, repr(problem))
        units = 2.0 ** (distance - time * np.arange(4.0))
        np.testing.assert_array_equal(other.states, motion.states * units, repr(problem))


@pytest.mark.parametrize(("distance", "time"), [(1e-9, 1.0), (1e9, 1.0), (1.0, 1e-6), (1e12, 1e3)])
def test_units_do_not_matter(distance, time):
    for seed in range(40):
        problem = random_s_curve(np.random.default_rng((6, seed)))
        other = duration(problem.in_units(distance, time).planned())
        assert other == pytest.approx(duration(problem.planned()) * time, rel=1e-9), problem


def test_a_quicker_rate_never_takes_longer():
    """As long as nothing turns round: from rest to rest."""
    for seed in SEEDS:
        problem = replace(random_s_curve(np.random.default_rng((7, seed))), final_velocity=0.0)
        problem = replace(problem, start=(problem.start[0], 0.0, 0.0))
        first, last = problem.jerks
        quicker = [
            replace(problem, velocity=1.5 * problem.velocity),
            replace(problem, acceleration=1.5 * problem.acceleration),
            replace(problem, deceleration=1.5 * problem.deceleration),
            replace(problem, jerks=(1.5 * first, last)),
            replace(problem, jerks=(first, 1.5 * last)),
        ]
        time = duration(problem.planned())
        for other in quicker:
            assert duration(other.planned()) <= time * (1.0 + 1e-12), (problem, other)


def test_backwards_in_time_the_rates_change_places():
    """From rest to rest, and from rest to a velocity as from that velocity to rest."""
    for seed in SEEDS:
        problem = random_s_curve(np.random.default_rng((8, seed)))
        problem = replace(problem, start=(0.0, 0.0, 0.0), target=abs(problem.target))
        runway = stopping_place((0.0, 0.0, 0.0), abs(problem.final_velocity), rates_of(problem))
        problem = replace(
            problem,
            final_velocity=abs(problem.final_velocity),
            target=runway + problem.target,
        )
        back = replace(
            problem,
            acceleration=problem.deceleration,
            deceleration=problem.acceleration,
            jerks=problem.jerks[::-1],
            start=(0.0, problem.final_velocity, 0.0),
            final_velocity=0.0,
        )
        expected = duration(problem.planned())
        assert duration(back.planned()) == pytest.approx(expected, rel=1e-10), problem


def rates_of(problem):
    return Rates(problem.velocity, problem.acceleration, problem.deceleration, *problem.jerks)


# Where it can stop


@pytest.mark.parametrize(
    ("begin", "final", "place"),
    [
        ((1.0, 4.0, 0.0), 0.0, 9.5),
        ((1.0, -4.0, 0.0), 0.0, -7.5),
        ((1.0, 0.0, 0.0), 4.0, 5.5),
        ((1.0, 0.0, 0.0), -4.0, -3.5),
        ((1.0, 0.0, 0.0), 0.0, 1.0),
        ((0.0, 0.125, -1.0), 0.0, 1.0 / 96.0),
        ((0.0, 4.0, 0.0), -4.0, 8.5),  # the nearest that is reached before it turns round
    ],
)
def test_stopping_places_by_hand(begin, final, place):
    assert stopping_place(begin, final, ALONE) == pytest.approx(place, rel=1e-14)


def test_at_the_stopping_place_a_plan_ends_where_it_stops():
    for seed in SEEDS:
        problem = replace(random_s_curve(np.random.default_rng((9, seed))), final_velocity=0.0)
        if problem.settling * problem.start[1] <= 0.0:
            continue  # it passes zero velocity, or rests
        place = stopping_place(problem.start, 0.0, rates_of(problem))
        motion = replace(problem, target=place).trajectory()
        slight = 1e-9 * problem.velocity
        low, high = motion.extremes("velocity")
        assert low >= -slight or high <= slight, problem
        beyond = place - 1e-3 * (place - problem.start[0])
        low, high = replace(problem, target=beyond).trajectory().extremes("velocity")
        assert low < 0.0 < high, problem


# By jerk percent


@pytest.mark.parametrize("percent", [0.0, 0.25, 0.5, 1.0])
def test_every_ramp_lasts_as_long_as_at_constant_acceleration(percent):
    rates = Rates(4.0, 2.0, 1.0, inf, inf, percent)
    pieces = [piece for piece in plan_move((0.0, 0.0, 0.0), 16.0, 0.0, rates) if piece[0] > 0.0]
    assert duration(pieces) == pytest.approx(2.0 + 1.0 + 4.0, rel=1e-14)
    top = next(time for time, row in pieces if row[1] == 4.0 and row[2] == row[3] == 0.0)
    assert top == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("percent", [0.0, 0.3, 1.0])
def test_by_percent_the_acceleration_of_the_start_is_left_out(percent):
    rates = Rates(4.0, 2.0, 1.0, inf, inf, percent)
    for begin in ((0.0, 1.0, 1.0), (0.0, 1.0, -1.0), (0.0, -1.0, 9.0), (2.0, 0.0, 1.0)):
        assert plan_move(begin, 7.0, 0.0, rates) == plan_move((*begin[:2], 0.0), 7.0, 0.0, rates)
