"""The planner at the edges of the range of a double: huge bounds, tiny motions, far positions."""

from fractions import Fraction
from itertools import product
from math import inf
from sys import float_info

import numpy as np
import pytest

from jounce import core

HUGE = 1e160, 1e300, float_info.max


def reached(motion):
    """Return where the pieces of a motion lead, exactly."""
    _, states, durations, _ = motion.arrays()
    x, v, a, j = (*map(Fraction, states[-1].tolist()), Fraction(0))[:4]
    h = Fraction(durations[-1])
    return x + h * (v + h * (a / 2 + h * j / 6))


@pytest.mark.parametrize("least", [5e-324, 1e-300, 1.0])
def test_resting_takes_no_time_whatever_the_bounds(least):
    rest = core.transfer((7.0, 0.0, 0.0), (7.0, 0.0, 0.0), (-1.0, 1.0) + (-least, least) * 2)
    assert rest.duration == 0.0
    rest = core.transfer((7.0, 0.0), (7.0, 0.0), (-1.0, 1.0, -least, least))
    assert rest.duration == 0.0


@pytest.mark.parametrize("rise", HUGE)
@pytest.mark.parametrize("fall", HUGE)
def test_a_huge_jerk_is_none_each_way(rise, fall):
    start, end, bounds = (-0.5, 0.7, -1.0), (0.5, 0.0, 0.0), (-1.0, 1.0, -0.2, 0.1)
    motion = core.transfer(start, end, (*bounds, -fall, rise))
    expected = core.transfer(start[:2], end[:2], bounds)
    assert motion.duration == pytest.approx(expected.duration, rel=1e-14)


@pytest.mark.parametrize("jerk", HUGE)
@pytest.mark.parametrize("x", [0.0, -0.5, 1e300])
def test_an_acceleration_built_up_at_once_leaves_a_position_far_away_as_it_is(x, jerk):
    motion = core.velocity_transfer((x, 0.0, 0.0), (x, 0.0, 0.5), (-1, 1, -2, 2, -jerk, jerk))
    assert motion.duration == pytest.approx((2.0**0.5 + 1.0) * 0.5 / jerk, rel=1e-12)
    assert motion.end_state[:3] == pytest.approx((x, 0.0, 0.5), rel=1e-15, abs=1e-300)


@pytest.mark.parametrize("v", [1e-100, 1e-200, 1e-300])
@pytest.mark.parametrize("x", [1.0, -3.0, 1e300])
def test_a_next_to_nothing_of_velocity_is_reached_anywhere(x, v):
    motion = core.transfer((x, 0.0, 0.0), (x, v, 0.0), (-1.0, 1.0) * 3)
    assert motion.duration == pytest.approx(2.0 * v**0.5, rel=1e-14)
    motion = core.transfer((x, 0.0), (x, v), (-1.0, 1.0) * 2)
    assert motion.duration == pytest.approx(v, rel=1e-14)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("fastest", [2.0, 5.0, inf])
def test_a_tiny_way_at_speed_is_gone_to_its_end(fastest, order):
    bounds = (-fastest, fastest, -2.0, 2.0, -3.0, 3.0)[: 2 * order]
    for distance, speed in product(10.0 ** -np.arange(8.0, 70.0, 3.0), [2.0, 2.0 - 1e-7]):
        start, end = (0.0, speed, 0.0)[:order], (float(distance), speed, 0.0)[:order]
        motion = core.transfer(start, end, bounds)
        assert motion.duration == pytest.approx(distance / speed, rel=1e-8)
        assert reached(motion) == pytest.approx(distance, rel=1e-14)
