"""States next to one free flight: a duration far below what the bounds need to change anything."""

import warnings
from math import factorial

import numpy as np
import pytest

from jounce.shaping import InfeasibleError, Limits, min_time_transfer

BOUNDS = (1.0, 2.0, 8.0, 100.0, 2000.0, 5e4)


def limits_of(order, *, velocity=1.0, position=None):
    return Limits.from_bounds([velocity, *BOUNDS[1:order]], position=position)


@pytest.mark.parametrize("way", [1e-15, 1e-9, 1e-6])
@pytest.mark.parametrize("order", [3, 4, 6])
@pytest.mark.parametrize("given", [{}, {"velocity": (0.0, 1.0)}, {"position": (-1.0, 1.0)}])
def test_uniform_motion_takes_its_way_over_its_velocity(way, order, given):
    limits = limits_of(order, **given)
    motion = min_time_transfer((0.0, 0.1), (way, 0.1), limits)
    assert motion.duration == pytest.approx(way / 0.1, rel=1e-4)
    assert motion.violation(limits) <= 1e-12
    np.testing.assert_array_equal(motion.end_state[:2], [way, 0.1])


@pytest.mark.filterwarnings("ignore:this motion takes at most")
@pytest.mark.parametrize("given", [{"velocity": (0.0, 1.0)}, {"position": (-1.0, 1.0)}])
def test_it_does_so_at_order_2_where_the_proof_ends_a_little_below(given):
    limits = limits_of(2, **given)
    motion = min_time_transfer((0.0, 0.1), (1e-15, 0.1), limits)
    assert motion.duration == pytest.approx(1e-14, rel=1e-12)
    assert motion.violation(limits) <= 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_accelerated_flights_take_no_longer_than_they_took(seed):
    rng = np.random.default_rng(seed)
    for order in (4, 5):
        time = 10.0 ** rng.uniform(-7.0, -3.0)
        start = [0.0, 0.1, *(rng.uniform(-0.3, 0.3) * BOUNDS[k] for k in range(1, order - 1))]
        end = [
            sum(start[q] * time ** (q - k) / factorial(q - k) for q in range(k, order))
            for k in range(order)
        ]
        limits = limits_of(order)
        motion = min_time_transfer(start, end, limits)
        assert motion.duration <= time * (1.0 + 1e-4)
        assert motion.violation(limits) <= 1e-12


def test_a_place_just_missed_is_reached_by_turning_back():
    limits = limits_of(4)
    start, end = (0.0, 0.045, -0.17), (7.92e-14, 0.045, -0.17)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "this motion takes at most")
        motion = min_time_transfer(start, end, limits)
    assert 1e-3 < motion.duration < 5.0
    assert motion.violation(limits) <= 1e-9
    np.testing.assert_array_equal(motion.end_state[:3], end)


def test_behind_it_there_is_none_without_turning_back():
    with pytest.raises(InfeasibleError, match="velocity bound 0 stands in the way"):
        min_time_transfer((0.0, 0.1), (-1e-9, 0.1), limits_of(4, velocity=(0.0, 1.0)))


@pytest.mark.parametrize("way", [1e-9, 1e-6])
def test_given_durations_are_those_there_are(way):
    limits = limits_of(4)
    assert min_time_transfer((0.0, 0.1), (way, 0.1), limits, duration=10.0 * way).duration == (
        10.0 * way
    )
    with pytest.raises(InfeasibleError, match="impossible"):
        min_time_transfer((0.0, 0.1), (way, 0.1), limits, duration=5.0 * way)
    longer = min_time_transfer((0.0, 0.1), (way, 0.1), limits, duration=3.0)
    assert longer.duration == 3.0
    assert longer.violation(limits) <= 1e-9
