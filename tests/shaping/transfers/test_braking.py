"""Starts beyond their bounds: levelled off at the bound, or braked harder where the end is near."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jounce.shaping import (
    CommandFollower,
    Limits,
    min_time_transfer,
    min_time_transfers,
    s_curve_move,
    velocity_transfer,
)

LOWERED = Limits(velocity=0.1, acceleration=1.0, jerk=2.0)
LEVELLED = 2.0 * sqrt(0.45 / 2.0)  # from 0.55 to 0.1 with a jerk of 2, acceleration below 1


def test_a_velocity_bound_lowered_under_way_is_levelled_off_at():
    """Down to the bound in the least time that arrives with zero acceleration, cruise, stop."""
    move = s_curve_move(1.2, velocity=0.55, acceleration=1.0, acceleration_jerk=2.0)
    x, v, a = (float(move(1.5, k)) for k in range(3))
    assert (v, a) == pytest.approx((0.55, 0.0), abs=1e-12)
    modified = move.modify(1.5, velocity=0.1)
    assert modified.extremes("velocity")[0] >= 0.0
    cruise = (1.2 - x - 0.5 * (0.55 + 0.1) * LEVELLED - 0.05 * 2.0 * sqrt(0.1 / 2.0)) / 0.1
    expected = LEVELLED + cruise + 2.0 * sqrt(0.1 / 2.0)
    assert modified.duration - 1.5 == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(4.7266, abs=1e-4)
    allowed = s_curve_move(
        1.2, velocity=0.55, acceleration=1.0, acceleration_jerk=2.0, no_reversal=True
    ).modify(1.5, velocity=0.1)
    assert allowed.duration == modified.duration


def test_every_verb_has_the_same_policy():
    change = velocity_transfer((0.0, 0.55, 0.0), 0.1, LOWERED)
    assert change.duration == pytest.approx(LEVELLED, rel=1e-12)
    assert change.extremes("velocity")[0] >= 0.1 * (1.0 - 1e-12)
    transfer = min_time_transfer((0.0, 0.55, 0.0), 5.0, LOWERED)
    assert transfer.inside_after == pytest.approx(LEVELLED, rel=1e-12)
    [many] = min_time_transfers([[0.0, 0.55, 0.0]], [[5.0, 0.0, 0.0]], LOWERED).duration
    assert many == transfer.duration
    run = CommandFollower(LOWERED, dt=0.01).run(np.full(900, 5.0), initial=(0.0, 0.55, 0.0))
    times = 0.01 * np.arange(1, 901)
    np.testing.assert_allclose(run.states[0], transfer(times), rtol=0, atol=1e-12)
    assert run.states[1].min() >= 0.0
    uneven = s_curve_move(
        5.0,
        start=(0.0, 0.55),
        velocity=0.1,
        acceleration=1.0,
        deceleration=0.9,
        acceleration_jerk=2.0,
    )
    assert uneven.extremes("velocity")[0] >= 0.0


@pytest.mark.parametrize("distance", np.linspace(0.289, 0.36, 12))
def test_where_the_end_is_near_it_brakes_harder_without_turning_round(distance):
    """Braking straight to rest takes 0.55 · 1.05 / 2 = 0.28875."""
    transfer = min_time_transfer((0.0, 0.55, 0.0), float(distance), LOWERED)
    assert transfer.extremes("velocity")[0] >= -1e-12
    assert transfer.violation(Limits(acceleration=1.0, jerk=2.0)) <= 1e-12
    assert transfer.end_state[0] == distance


NUMBERS = st.floats(0.0625, 3.0, width=32)


@given(v=NUMBERS, bound=NUMBERS, a=st.floats(-1.0, 1.0, width=32), j=NUMBERS, target=NUMBERS)
def test_no_start_ahead_of_a_distant_end_turns_round(v, bound, a, j, target):
    limits = Limits(bound, 1.0, j)
    straight = velocity_transfer((0.0, v, a), 0.0, Limits(acceleration=1.0, jerk=j))
    if straight.extremes("velocity")[0] < 0.0:
        return  # the acceleration alone turns it round
    distance = float(straight.end_state[0]) + target
    transfer = min_time_transfer((0.0, v, a), distance, limits)
    text = f"min_time_transfer((0.0, {v}, {a}), {distance}, {limits!r})"
    assert transfer.extremes("velocity")[0] >= -1e-9 * max(v, bound), text
    later = np.linspace(transfer.inside_after, transfer.duration, 200)
    assert transfer(later, "velocity").max() <= bound * (1.0 + 1e-9), text


BEYOND = [  # starts beyond the velocity bound: braking just to the bound is a knife edge
    (
        (1.4925736265396559, 11.415631057207156),
        (0.0, -1.5249352367121851),
        Limits((-37.05855032011377, 9.426392535917596), (-0.05903208918369911, 5.157110503909153)),
    ),
    (
        (0.0, 1.6948168842227074),
        (-1.6855763704959026, -1.494833585462695),
        Limits(
            (-1.7440891339462627, 0.16257126968780317), (-0.04158410613253106, 4.29277042367587)
        ),
    ),
    (
        (0.0, 0.43556402589192966, 0.0),
        (0.0, -0.351911527237597, 0.0),
        Limits(
            (-2.3888831605758383, 0.11200560919312841),
            (-5.39643606489093, 3.62087803855283),
            (-6.142915947889799, 3.834107842395843),
        ),
    ),
]


@pytest.mark.parametrize(("start", "end", "limits"), BEYOND)
def test_the_last_digit_of_a_start_beyond_its_bound_changes_no_more_than_that(start, end, limits):
    found = [
        min_time_transfer((start[0], np.nextafter(start[1], way), *start[2:]), end, limits).duration
        for way in (0.0, start[1], 100.0)
    ]
    assert max(found) - min(found) < 1e-9 * max(found)


@pytest.mark.parametrize(("start", "end", "limits"), BEYOND)
def test_a_motion_is_inside_from_when_its_bounds_are_kept_for_good(start, end, limits):
    found = min_time_transfer(start, end, limits)
    times = np.linspace(0.0, found.duration, 200_001)
    outside = np.zeros_like(times, dtype=bool)
    for k in (1, 2):
        low, high = limits.bounds(k)
        slack = 1e-9 * max(-low, high)
        values = found(times, k)
        outside |= (values > high + slack) | (values < low - slack)
    last = times[outside][-1]
    assert found.inside_after == pytest.approx(last, abs=2e-5 * found.duration)
