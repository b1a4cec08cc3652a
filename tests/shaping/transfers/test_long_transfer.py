"""Transfers much longer than their ramps: exact, quick, and told how near they are."""

import warnings

import numpy as np
import pytest

from jounce.shaping import Limits, min_time_transfer

LIMITS = Limits(velocity=(-2.0, 1.0), acceleration=(-2.0, 1.0), jerk=5.0, snap=100.0)


@pytest.mark.parametrize("distance", [400.0, 1e4, 1e7, -1e4])
def test_a_long_transfer_is_exact_and_takes_no_longer_than_it_says(distance):
    end = (7.0 + distance, 0.2, -0.1)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = min_time_transfer((7.0, 0.1, 0.1), end, LIMITS)
    assert all("ramps at both ends" in str(each.message) for each in told)
    assert found.trajectory.violation(LIMITS) < 1e-9
    assert found.end_state[:3] == pytest.approx(end, rel=1e-13, abs=1e-9)
    least = abs(distance) / (1.0 if distance > 0.0 else 2.0)
    assert least < found.duration < least + 4.0
    assert len(told) == (found.duration > least * 1.0001)
    inner = found.trajectory.breaks[1:-1]
    step = 1e-9 * max(1.0, inner[-1])
    for k, most in ((1, 4.0), (2, 10.0), (3, 200.0)):
        jumps = np.abs(found(inner, k) - found(inner - step, k))
        assert jumps.max() < most * step


def test_its_ramps_take_what_those_of_a_shorter_one_take():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        shorter, longer = (
            min_time_transfer((0.0, 0.1, 0.1), (distance, 0.2), LIMITS).duration - distance
            for distance in (60.0, 1e6)
        )
    assert longer == pytest.approx(shorter, abs=0.01)


def test_order_3_within_bounds_on_position_still_has_its_own_way():
    limits = Limits(velocity=1.0, acceleration=1.0, jerk=5.0, position=(-1.0, 2e3))
    found = min_time_transfer((0.0, 0.1), (1e3, 0.2), limits)
    assert np.abs(found.end_state[:2] - (1e3, 0.2)).max() < 1e-9
