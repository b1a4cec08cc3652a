"""binding_limits: the derivatives at a bound on each piece."""

import pytest

from jounce.shaping import Limits, min_time_move
from jounce.shaping.optimal import binding_limits
from jounce.shaping.optimal.binding import BINDING_RTOL


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


@pytest.mark.parametrize("rtol", [-1.0, 0.0, 1.0, 2.0, float("nan")])
def test_rtol_must_be_between_0_and_1(rtol):
    """From 1 on everything would be at a bound, even what does not move."""
    limits = Limits(jerk=1.0)
    with pytest.raises(ValueError, match=f"^rtol = {rtol}: expected "):
        binding_limits(min_time_move(1.0, limits), limits, rtol=rtol)


@pytest.mark.parametrize("rtol", [BINDING_RTOL, 0.3, 0.9])
def test_rtol_is_how_near_counts_as_at_the_bound(rtol):
    move = min_time_move(1.0, Limits(velocity=2.0, acceleration=10.0))
    for share, cruise in ((0.99, (1,)), (1.01, ())):
        wider = Limits(velocity=2.0 / (1.0 - share * rtol))
        assert binding_limits(move, wider, rtol=rtol) == ((), cruise, ())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"limits": None}, "^limits = None: expected Limits, such as"),
        ({"limits": "x"}, "^limits = 'x': expected Limits, such as"),
        ({"trajectory": None}, "^trajectory = None: expected a Trajectory"),
        ({"trajectory": 1.0}, "^trajectory = 1.0: expected a Trajectory"),
        ({"rtol": "1"}, "^rtol = '1': expected a number"),
    ],
    ids=["no limits", "text", "no trajectory", "number", "rtol"],
)
def test_arguments_of_another_kind_are_refused(change, message):
    limits = Limits(jerk=1.0)
    given = {"trajectory": min_time_move(1.0, limits), "limits": limits, **change}
    with pytest.raises(TypeError, match=message):
        binding_limits(**given)


def test_position_counts_where_it_is_bounded():
    """On a wall that it stands at, and not before; whatever the positions count from."""
    for shift in (0.0, 1e6):
        wall = Limits(2.0, 10.0, 100.0, position=(shift - 1.0, shift + 1.0))
        move = min_time_move(1.0, wall, start=shift)
        there = move.until(move.duration + 0.5)
        held = binding_limits(there, wall)
        assert held[-1] == (0,)
        assert all(0 not in derivatives for derivatives in held[:-1])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bound_of_zero_is_met_by_what_stays_zero(sign):
    pairs = [(0.0, 2.0), (-10.0, 10.0), (-100.0, 100.0)]
    limits = Limits.from_bounds([tuple(sorted((sign * a, sign * b))) for a, b in pairs])
    move = min_time_move(sign, limits)
    assert binding_limits(move.until(move.duration + 0.5), limits) == (
        (3,),
        (2,),
        (3,),
        (1,),
        (3,),
        (2,),
        (3,),
        (1,),
    )
