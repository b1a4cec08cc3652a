"""Durations of many moves of order 3 to 40 digits, and at the borders of the cases."""

from math import inf

import mpmath
import numpy as np
import pytest
from move_batches import random_moves, together
from tiers import some

from jounce.shaping import Limits, min_time_move, min_time_moves


def exact_duration(distance, limits):
    """Return the duration of an order-3 move, its velocity bisected with 40 digits."""
    with mpmath.workdps(40):
        rising, falling = (mpmath.mpf(side) for side in (limits.upper[2], -limits.lower[2]))
        sides = [mpmath.mpf(limits.upper[1]), mpmath.mpf(-limits.lower[1])]

        def way(v, a):
            """Return time and distance of a ramp from rest, integrated phase by phase."""
            p = min(mpmath.sqrt(2 * v / (1 / rising + 1 / falling)), a)
            t1, t3 = p / rising, p / falling
            t2 = v / p - (t1 + t3) / 2
            v1 = p * t1 / 2
            v2 = v1 + p * t2
            x = p * t1**2 / 6 + v1 * t2 + p * t2**2 / 2 + v2 * t3 + p * t3**2 / 3
            return t1 + t2 + t3, x

        low, high = mpmath.mpf(0), mpmath.mpf(limits.upper[0])
        if high == inf or sum(way(high, a)[1] for a in sides) > distance:
            high = mpmath.mpf(2) ** 60 if high == inf else high
            for _ in range(250):
                v = (low + high) / 2
                low, high = (v, high) if sum(way(v, a)[1] for a in sides) < distance else (low, v)
        total, covered = (mpmath.fsum(parts) for parts in zip(*(way(high, a) for a in sides),
                                                               strict=True))  # fmt: skip
        return float(total + max(distance - covered, 0) / high)


@pytest.mark.parametrize("seed", some(range(12), 5))
def test_uneven_bounds_to_40_digits(seed):
    for problem in random_moves(seed, 3, 3, even=False):
        expected = exact_duration(
            abs(problem.distance), problem.limits if problem.distance > 0 else
            problem.limits.mirror()
        )  # fmt: skip
        assert together([problem]).duration[0] == pytest.approx(expected, rel=2e-15), problem


@pytest.mark.parametrize("skew", [1e-8, 1e-3, 1e3, 1e8])
def test_every_distance_under_very_uneven_bounds(skew):
    """Through all cases: no acceleration reached, one, both, and velocity."""
    limits = Limits(3.0, (-1.0, 7.0), (-skew, 1.0))
    distances = np.geomspace(1e-12, 1e15, 300)
    found = min_time_moves(distances, limits).duration
    expected = [min_time_move(r, limits).duration for r in distances]
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    assert (np.diff(found) > 0.0).all()


@pytest.mark.parametrize("jerk", [1.0, (-2.0, 1.0), (-1.0, 2.0)])
@pytest.mark.parametrize("factor", [1.0 - 1e-9, 1.0 - 2e-16, 1.0, 1.0 + 3e-16, 1.0 + 1e-9])
def test_borders_of_the_cases(jerk, factor):
    """At the distance at which a bound is just reached, and a hair beside it."""
    for reached in ("acceleration", "velocity"):
        free = min_time_move(5.0, Limits(jerk=jerk))
        limits = Limits(**{reached: free.peak(reached), "jerk": jerk})
        found = min_time_moves(5.0 * factor, limits).duration[0]
        assert found == pytest.approx(min_time_move(5.0 * factor, limits).duration, rel=1e-14)
        assert found == pytest.approx(free.duration, rel=2e-9)
