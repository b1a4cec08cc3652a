"""Moves of order 4 and more at any scale, and with huge bounds, which are none."""

from math import inf
from sys import float_info

import numpy as np
import pytest

from jounce.shaping import Limits, min_time_move, min_time_moves

HUGE = 1e200, 1e300, float_info.max


def closed(distance, bounds):
    return min_time_move(distance, Limits.from_bounds(bounds), method="closed-form")


def random_bounds(rng, order):
    bounds = (10.0 ** rng.uniform(-1.0, 1.0, order)).tolist()
    return [
        inf if k < order - 1 and rng.random() < 0.3 else bound for k, bound in enumerate(bounds)
    ]


@pytest.mark.parametrize("order", [4, 5, 6])
@pytest.mark.parametrize("huge", HUGE)
def test_a_huge_bound_below_the_highest_is_none(order, huge):
    rng = np.random.default_rng((1, order))
    for _ in range(20):
        bounds, distance = random_bounds(rng, order), 10.0 ** rng.uniform(-3.0, 3.0)
        given = [huge if bound == inf else bound for bound in bounds]
        move, other = closed(distance, given), closed(distance, bounds)
        assert move.duration == pytest.approx(other.duration, rel=1e-13), (distance, given)


@pytest.mark.parametrize("method", ["closed-form", "optimal"])
@pytest.mark.parametrize("order", [4, 5, 6])
@pytest.mark.parametrize("huge", HUGE)
def test_a_huge_highest_bound_takes_as_long_as_a_very_large_one(order, huge, method):
    bounds = [1.0] * (order - 1)
    given, large = (
        min_time_move(2.0, Limits.from_bounds([*bounds, top]), method=method)
        for top in (huge, 1e25)
    )
    assert given.duration == pytest.approx(large.duration, rel=1e-12)


def test_all_bounds_huge_but_the_jerk_s_or_the_velocity_s():
    move = closed(2.0, [1e200, 1e300, 1.0, float_info.max])
    assert move.duration == pytest.approx(min_time_move(2.0, Limits(jerk=1.0)).duration, rel=1e-14)
    move = closed(2.0, [1.0, 1e300, 1e200, 1e250])
    assert move.duration == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize("order", [4, 5, 6])
@pytest.mark.parametrize(
    ("distance", "time"), [(900, 0), (-900, 0), (0, 140), (0, -140), (-600, -100), (400, 30)]
)
def test_units_of_powers_of_two_do_not_matter(order, distance, time):
    rng = np.random.default_rng((2, order))
    for _ in range(10):
        bounds, length = random_bounds(rng, order), 10.0 ** rng.uniform(-3.0, 3.0)
        powers = [distance - k * time for k in range(1, order + 1)]
        given = [float(np.ldexp(b, power)) for b, power in zip(bounds, powers, strict=True)]
        move, other = closed(length, bounds), closed(float(np.ldexp(length, distance)), given)
        assert other.duration == pytest.approx(np.ldexp(move.duration, time), rel=1e-13)


@pytest.mark.parametrize("order", [4, 5, 6])
def test_a_batch_of_any_scales_has_the_durations_and_pieces_of_its_moves(order):
    rng = np.random.default_rng((3, order))
    scales = np.array([0, 700, -800, 0, 300, -1000])
    bounds = np.array([random_bounds(rng, order) for _ in scales])
    bounds[3][bounds[3] == inf] = 1e300
    bounds[0, -1] = 1e250
    lengths, bounds = np.ldexp(10.0 ** rng.uniform(-3, 3, 6), scales), np.ldexp(bounds.T, scales)
    batch = min_time_moves(lengths, Limits.from_bounds(list(bounds)))
    times = np.array([0.3, 0.7]) * batch.duration[:, None]
    for i, (length, own) in enumerate(zip(lengths.tolist(), bounds.T.tolist(), strict=True)):
        move = closed(length, own)
        assert batch.duration[i] == pytest.approx(move.duration, rel=1e-12)
        assert batch[i].duration == pytest.approx(move.duration, rel=1e-12)
        values = batch(times[i])[i]
        assert values == pytest.approx(move(times[i]), rel=1e-9)
