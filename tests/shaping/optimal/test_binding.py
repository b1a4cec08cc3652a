"""binding_limits: the derivatives at a bound on each piece."""

import pytest

from jounce.shaping import Limits, min_time_move
from jounce.shaping.optimal import binding_limits


def test_an_s_curve_with_all_bounds_reached():
    limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    expected = ((3,), (2,), (3,), (1,), (3,), (2,), (3,))
    assert binding_limits(min_time_move(1.0, limits), limits) == expected


def test_wider_limits_do_not_bind_and_missing_ones_neither():
    limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    move = min_time_move(1.0, limits)
    wider = Limits(velocity=2.0, acceleration=11.0, jerk=101.0)
    assert binding_limits(move, wider) == ((), (), (), (1,), (), (), ())
    assert binding_limits(move, Limits(velocity=2.0)) == ((), (), (), (1,), (), (), ())


def test_each_direction_has_its_own_bound():
    limits = Limits.from_bounds([(-9.0, 9.0), (-4.0, 1.0)])
    assert binding_limits(min_time_move(1.0, limits), limits) == ((2,), (2,))
    assert binding_limits(min_time_move(-1.0, limits), limits) == ((2,), (2,))


def test_an_optimal_move_is_nearly_always_at_a_bound():
    limits = Limits(velocity=1.3, acceleration=9.0, snap=900.0)
    move = min_time_move(1.0, limits)
    held = binding_limits(move, limits, rtol=1e-4)
    assert len(held) == len(move.states)
    at_a_bound = sum(d for d, names in zip(move.durations, held, strict=True) if names)
    assert at_a_bound >= 0.9 * move.duration


def test_a_point_has_no_pieces():
    limits = Limits(jerk=1.0)
    assert binding_limits(min_time_move(0.0, limits), limits) == ()


def test_rtol_must_be_positive():
    limits = Limits(jerk=1.0)
    with pytest.raises(ValueError, match=r"rtol = -1\.0"):
        binding_limits(min_time_move(1.0, limits), limits, rtol=-1.0)
