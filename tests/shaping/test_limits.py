"""Limits: validation, pairs, order, mirror, equality, repr."""

import copy
import dataclasses
import math
import pickle
from math import inf

import numpy as np
import pytest
from hypothesis import given
from strategies import any_limits

from jounce.shaping import (
    CommandFollower,
    Limits,
    binding_limits,
    certify,
    min_time_move,
    min_time_moves,
    min_time_transfer,
    min_time_transfers,
    scan_move,
    synchronize,
    tracking_transfer,
    velocity_transfer,
)
from jounce.shaping.recursive_s_curve import recursive_s_curve


def test_a_number_bounds_both_directions():
    limits = Limits(velocity=2.0, jerk=30)
    assert limits.lower == (-2.0, -inf, -30.0)
    assert limits.upper == (2.0, inf, 30.0)
    assert limits.order == 3
    assert limits.symmetric


@pytest.mark.parametrize("pair", [(-3.0, 5.0), [-3.0, 5.0], (-3, 5), (np.float64(-3), 5)])
def test_a_pair_bounds_the_directions_apart(pair):
    limits = Limits(acceleration=pair)
    assert limits.bounds("acceleration") == limits.bounds(2) == (-3.0, 5.0)
    assert limits.bounds("velocity") == (-inf, inf)
    assert limits.bounds(9) == (-inf, inf)
    assert not limits.symmetric


def test_every_name_is_its_derivative():
    limits = Limits(velocity=1, acceleration=2, jerk=3, snap=4, crackle=5, pop=6)
    assert limits.upper == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert limits == Limits.from_bounds(range(1, 7))
    assert [limits.bounds(k)[1] for k in range(1, 7)] == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("unbounded", [None, inf, (-inf, inf)])
def test_unbounded_derivatives_do_not_count(unbounded):
    assert Limits(velocity=1.0, pop=unbounded) == Limits(velocity=1.0)
    assert Limits(velocity=1.0, pop=unbounded).order == 1
    assert Limits(velocity=unbounded, jerk=1.0) == Limits(jerk=1.0)


def test_from_bounds_takes_any_order_and_any_iterable():
    limits = Limits.from_bounds(iter([None, 2.0, inf, (-1.0, 4.0), *[None] * 7, 12.0]))
    assert limits.order == 12
    assert limits.bounds(4) == (-1.0, 4.0)
    assert limits.bounds(12) == (-12.0, 12.0)
    assert limits.bounds(3) == (-inf, inf)


NOT_AROUND_ZERO = [(1.0, 2.0), (-2.0, -1.0), (0.0, 0.0), (2.0, -2.0)]
NOT_A_NUMBER = [math.nan, (math.nan, 1.0), (-1.0, math.nan)]


@pytest.mark.parametrize("value", [0.0, -1.0, -inf, *NOT_AROUND_ZERO, *NOT_A_NUMBER])
def test_a_bound_that_does_not_enclose_zero_is_refused(value):
    with pytest.raises(ValueError, match=r"snap limit .* expected a positive number or a pair"):
        Limits(snap=value)
    with pytest.raises(ValueError, match="snap limit"):
        Limits.from_bounds([1.0, 1.0, 1.0, value])


@pytest.mark.parametrize("pair", [(0.0, 1.0), (-1.0, 0.0), (-inf, 0), (-0.0, inf)])
def test_a_side_may_be_zero_but_not_of_the_highest(pair):
    assert Limits(velocity=pair, snap=1.0).bounds(1) == pair
    assert Limits(velocity=pair, snap=1.0).mirror().bounds(1) == (-pair[1], -pair[0])
    with pytest.raises(ValueError, match=r"^snap limit .*: the highest .* both signs; expected"):
        Limits(velocity=1.0, snap=pair)


@pytest.mark.parametrize("value", ["fast", "3", (1.0,), (-1.0, 0.5, 1.0), (-1.0, "x"), 1j, {}])
def test_a_bound_that_is_no_number_is_refused(value):
    with pytest.raises(TypeError, match=r"jerk limit .* expected a positive number or a pair"):
        Limits(jerk=value)


@pytest.mark.parametrize("bounds", [[], [None], [inf, None], [(-inf, inf)]])
def test_no_bound_at_all_is_refused(bounds):
    with pytest.raises(ValueError, match="no limits given: bound at least one derivative"):
        Limits.from_bounds(bounds)


def test_unknown_names_are_refused():
    with pytest.raises(TypeError, match="speed"):
        Limits(speed=1.0)
    with pytest.raises(ValueError, match="unknown derivative 'speed'"):
        Limits(velocity=1.0).bounds("speed")
    assert Limits(velocity=1.0).bounds("position") == (-inf, inf)


def test_limits_are_frozen():
    limits = Limits(velocity=1.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        limits.upper = (2.0,)


@given(limits=any_limits())
def test_mirror_swaps_the_directions_and_undoes_itself(limits):
    mirrored = limits.mirror()
    for k in range(1, limits.order + 1):
        low, high = limits.bounds(k)
        assert mirrored.bounds(k) == (-high, -low)
    assert mirrored.mirror() == limits
    assert (mirrored == limits) == limits.symmetric


@given(limits=any_limits())
def test_equal_limits_are_one_key(limits):
    pairs = [limits.bounds(k) for k in range(1, limits.order + 1)]
    again = Limits.from_bounds(pairs)
    assert again == limits
    assert {limits: "found"}[again] == "found"
    assert limits != Limits.from_bounds([*pairs, 1.0])


@given(limits=any_limits())
def test_repr_can_be_pasted(limits):
    assert eval(repr(limits), {"Limits": Limits, "inf": inf}) == limits, repr(limits)


def test_repr_shows_what_was_said():
    assert repr(Limits(velocity=2, jerk=(-1, 3))) == "Limits(velocity=2.0, jerk=(-1.0, 3.0))"


# Of position


@pytest.mark.parametrize("pair", [(0.0, 1.0), [2, 3], (-inf, 5.0), (-2.0, -1.0), (-1.0, inf)])
def test_position_takes_any_pair_that_increases(pair):
    limits = Limits(position=pair, velocity=2.0, jerk=(-3.0, 4.0))
    assert limits.position == limits.bounds("position") == limits.bounds(0) == tuple(pair)
    assert (limits.order, limits.upper[0], limits.plain) == (3, 2.0, False)
    assert limits.mirror().position == (-pair[1], -pair[0])
    assert limits.mirror().mirror() == limits != Limits(velocity=2.0, jerk=(-3.0, 4.0))
    assert Limits.from_bounds([2.0, None, (-3.0, 4.0)], position=pair) == limits
    assert len({limits, Limits(2.0, None, (-3.0, 4.0), position=pair)}) == 1
    assert eval(repr(limits), {"Limits": Limits, "inf": inf}) == limits
    assert copy.deepcopy(limits) == pickle.loads(pickle.dumps(limits)) == limits


def test_a_free_position_is_none():
    limits = Limits(velocity=1.0, position=(-inf, inf))
    assert limits == Limits(velocity=1.0)
    assert limits.plain
    assert not limits.bounds_position
    assert "position" not in repr(limits)


@pytest.mark.parametrize("pair", [(1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (inf, inf)])
def test_positions_that_do_not_increase_are_refused(pair):
    with pytest.raises(ValueError, match=r"^position limit \(.*: expected a pair \(lower, upper\)"):
        Limits(position=pair, velocity=1.0)


@pytest.mark.parametrize(
    "value", [1.0, "far", (1.0,), (None, 1.0), [1, 2, 3], np.ones(2), ("a", 1)]
)
def test_a_position_limit_that_is_no_pair_is_refused(value):
    with pytest.raises(TypeError, match=r"^position limit .*: expected a pair"):
        Limits(position=value, velocity=1.0)


def test_position_alone_bounds_no_motion():
    with pytest.raises(ValueError, match="no limits given: bound at least one derivative"):
        Limits(position=(0.0, 1.0))


def test_positions_of_many_problems_broadcast():
    pairs = np.array([[0.0, 1.0], [2.0, 4.0]])
    limits = Limits(position=pairs, velocity=1.0)
    assert limits.shape == (2,)
    assert limits.each(lambda side: side[1]) == Limits(position=(2.0, 4.0), velocity=1.0)
    assert limits == Limits(position=(pairs[:, 0], pairs[:, 1]), velocity=1.0)
    with pytest.raises(ValueError, match=r"^position limit \(3.0, 1.0\) of problem 1: expected"):
        Limits(position=np.array([[0.0, 1.0], [3.0, 1.0]]), velocity=1.0)
    with pytest.raises(ValueError, match="do not fit"):
        Limits(position=pairs, velocity=np.ones(3))


def test_violation_counts_positions_and_zero_sides():
    move = min_time_move(2.0, Limits(velocity=1.0, acceleration=1.0))
    stops = Limits(position=(0.0, 1.0), acceleration=1.0)
    assert move.violation(stops) == pytest.approx(1.0)
    assert move.mirror().violation(stops) == pytest.approx(2.0)
    assert move.violation(Limits(position=(-inf, 1.5), acceleration=1.0)) == pytest.approx(0.25)
    assert move.violation(Limits(position=(0.0, 2.0), velocity=(0.0, 1.0), jerk=9.0)) == 0.0
    assert move.mirror().violation(Limits(velocity=(0.0, 4.0), acceleration=1.0)) == 0.25
    assert move.mirror().violation(Limits(velocity=(0.0, inf), acceleration=1.0)) == 1.0


SPECIAL = [
    Limits(velocity=1.0, acceleration=2.0, jerk=20.0, position=(-5.0, 5.0)),
    Limits(velocity=1.0, acceleration=(-2.0, 0.0), jerk=20.0),
]


@pytest.mark.parametrize("limits", SPECIAL, ids=repr)
@pytest.mark.parametrize(
    "call",
    [
        lambda limits: min_time_moves([1.0], limits),
        lambda limits: recursive_s_curve(1.0, limits),
        lambda limits: velocity_transfer(0.0, 1.0, limits),
        lambda limits: CommandFollower(limits, dt=0.1),
        lambda limits: scan_move(1.0, 0.5, limits),
        lambda limits: tracking_transfer(0.0, 1.0, limits),
    ],
    ids=range(6),
)
def test_what_takes_no_such_bounds_says_so(call, limits):
    with pytest.raises(ValueError, match=r"have a bound .*: only min_time_move and min_time_tr"):
        call(limits)


# Of many problems


def test_an_array_is_one_bound_for_each_problem():
    limits = Limits(velocity=np.array([1.0, 2.0, 4.0]), jerk=30.0)
    assert (limits.shape, limits.order, limits.symmetric) == ((3,), 3, True)
    assert limits.upper[0].tolist() == [1.0, 2.0, 4.0]
    assert limits.lower[0].tolist() == [-1.0, -2.0, -4.0]
    assert (limits.lower[1:], limits.upper[1:]) == ((-inf, -30.0), (inf, 30.0))


def test_two_columns_are_pairs_and_so_is_a_tuple_of_arrays():
    pairs = np.array([[-1.0, 2.0], [-3.0, 4.0], [-5.0, 6.0]])
    limits = Limits(acceleration=pairs)
    assert limits == Limits(acceleration=(pairs[:, 0], pairs[:, 1]))
    assert limits.lower[1].tolist() == [-1.0, -3.0, -5.0]
    assert limits.upper[1].tolist() == [2.0, 4.0, 6.0]
    assert not limits.symmetric
    assert limits.mirror().upper[1].tolist() == [1.0, 3.0, 5.0]
    two = Limits(np.array([1.0, 2.0]))  # an array of two is no pair
    assert two.lower[0].tolist() == [-1.0, -2.0]


def test_problems_broadcast():
    v, a = np.ones((5, 1)), np.ones(7)
    assert Limits(v, a, 1.0).shape == (5, 7)
    assert Limits((-v, a)).shape == (5, 7)
    assert Limits(np.ones((5, 1, 2)) * [-1.0, 1.0], a).shape == (5, 7)
    assert Limits(1.0, np.array(2.0)).shape == ()
    with pytest.raises(ValueError, match=r"^limits of shapes \(3,\), \(2,\) do not fit: expected"):
        Limits(np.ones(3), np.ones(2))
    with pytest.raises(ValueError, match=r"^velocity limit: arrays of shapes .* do not fit"):
        Limits((-np.ones(3), np.ones(2)))


def test_limits_of_many_are_read_only_copies_equal_by_their_numbers():
    given = np.array([1.0, 2.0])
    limits, kept = Limits(given, (-given, 3.0)), hash(Limits(given, (-given, 3.0)))
    given += 1.0
    assert hash(limits) == kept
    for side in (limits.upper[0], limits.lower[0], limits.lower[1]):
        assert side.tolist() in ([1.0, 2.0], [-1.0, -2.0])
        with pytest.raises(ValueError, match="read-only"):
            side[0] = 1.0
    assert limits == Limits(given - 1.0, (1.0 - given, 3.0)) != Limits(given, (-given, 3.0))
    assert limits != Limits(1.0, 3.0)
    assert repr(Limits(given)) == "Limits(velocity=array([2., 3.]))"


@pytest.mark.parametrize(
    ("bound", "message"),
    [
        (np.array([1.0, -2.0]), r"^jerk limit -2.0 of problem 1: expected a positive number"),
        (np.array([[1.0], [math.nan]]), r"^jerk limit nan of problem 1, 0: expected"),
        (np.array([[1.0, 2.0]]), r"^jerk limit \(1.0, 2.0\) of problem 0: expected"),
        ((np.array([-1.0, 2.0]), 3.0), r"^jerk limit \(2.0, 3.0\) of problem 1: expected"),
    ],
    ids=range(4),
)
def test_arrays_that_do_not_enclose_zero_are_refused_by_their_index(bound, message):
    with pytest.raises(ValueError, match=message):
        Limits(jerk=bound)


@pytest.mark.parametrize("bound", [[1.0, 2.0, 3.0], [[-1.0, 1.0]], ([1.0], [2.0]), [], ["1", "2"]])
def test_lists_are_pairs_of_numbers_and_nothing_else(bound):
    with pytest.raises(TypeError, match=r"^jerk limit .* make a list of bounds an array"):
        Limits(jerk=bound)


BOUNDS = np.array([2.0, 3.0])
SQUARE = np.array([[2.0, 3.0], [4.0, 5.0]])


@pytest.mark.parametrize(
    ("wrong", "remedy", "right"),
    [
        ((None, 1.0), "write -inf or inf for a side without a bound", (-inf, 1.0)),
        ([-1.0, None], "write -inf or inf for a side without a bound", [-1.0, inf]),
        ([2.0, 3.0, 4.0], "make a list of bounds an array", np.array([2.0, 3.0, 4.0])),
        (np.array([-1.0, 2.0]), "is two bounds: make a pair a tuple", (-1.0, 2.0)),
        (
            SQUARE,
            r"an array \(2, 2\) is pairs: give .* pair \(-bounds, bounds\)",
            (-SQUARE, SQUARE),
        ),
        (0.0, "leave it out where there is none", None),
        ((1.0, 2.0), "leave it out where there is none", None),
    ],
    ids=range(7),
)
def test_the_remedy_of_a_refused_bound_works(wrong, remedy, right):
    with pytest.raises((TypeError, ValueError), match=f"^jerk limit .*; .*{remedy}") as told:
        Limits(jerk=wrong, snap=1.0)
    assert "\n" not in str(told.value)
    assert Limits(jerk=right, snap=1.0).order == 4


@pytest.mark.parametrize(
    ("bound", "lower", "upper"),
    [
        ((-BOUNDS, BOUNDS), [-2.0, -3.0], [2.0, 3.0]),
        ([-BOUNDS, BOUNDS], [-2.0, -3.0], [2.0, 3.0]),
        ((-1.0, BOUNDS), -1.0, [2.0, 3.0]),
        ([-BOUNDS, 4], [-2.0, -3.0], 4.0),
        (BOUNDS, [-2.0, -3.0], [2.0, 3.0]),
        (BOUNDS.astype(int), [-2.0, -3.0], [2.0, 3.0]),
        (BOUNDS.astype(object), [-2.0, -3.0], [2.0, 3.0]),
        (SQUARE * [-1.0, 1.0], [-2.0, -4.0], [3.0, 5.0]),
        (BOUNDS[:1], [-2.0], [2.0]),
        (BOUNDS[:, None], [[-2.0], [-3.0]], [[2.0], [3.0]]),
        (np.stack([-SQUARE, SQUARE], axis=-1), (-SQUARE).tolist(), SQUARE.tolist()),
        (np.array(2.0), -2.0, 2.0),
        ((np.array(-1.0), np.float32(2.0)), -1.0, 2.0),
        (BOUNDS[:0], [], []),
    ],
    ids=range(14),
)
def test_every_way_to_give_bounds_means_what_is_said(bound, lower, upper):
    limits = Limits(1.0, bound, 9.0)
    sides = [np.asarray(side).tolist() for side in limits.bounds(2)]
    assert sides == [lower, upper]
    shapes = [np.shape(side) for side in (lower, upper)]
    assert limits.shape == np.broadcast_shapes(*shapes)
    again = Limits.from_bounds([None, bound, 9.0])
    assert [np.asarray(side).tolist() for side in again.bounds(2)] == sides


def test_an_array_gives_its_rows_as_bounds():
    assert Limits.from_bounds(np.array([1.0, 2.0, 3.0])) == Limits(1.0, 2.0, 3.0)
    assert Limits.from_bounds(SQUARE * [-1.0, 1.0]) == Limits((-2.0, 3.0), (-4.0, 5.0))
    rows = np.ones((2, 5))
    assert Limits.from_bounds(rows).shape == (5,)
    assert Limits.from_bounds(np.stack([-rows, rows], axis=-1)) == Limits.from_bounds(rows)


def test_bounds_by_name_are_told_how_to_become_limits():
    bounds = {"velocity": 1.0, "acceleration": np.array([1.0, 2.0])}
    for call in (
        lambda limits: min_time_transfers([0.0], [[1.0]], limits),
        lambda limits: min_time_moves([1.0], limits),
        lambda limits: min_time_transfer(0.0, 1.0, limits),
        lambda limits: min_time_move(1.0, limits),
    ):
        with pytest.raises(TypeError, match=r"^limits = .*give bounds by name as Limits\(\*\*boun"):
            call(bounds)
    assert min_time_transfers([0.0], [[1.0]], Limits(**bounds)).shape == (2,)


MANY = Limits(np.array([1.0, 2.0]), 2.0, 20.0)
ONE = Limits(1.0, 2.0, 20.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda limits: min_time_move(1.0, limits),
        lambda limits: recursive_s_curve(1.0, limits),
        lambda limits: min_time_transfer(0.0, 1.0, limits),
        lambda limits: velocity_transfer(0.0, 1.0, limits),
        lambda limits: synchronize([(0.0, 1.0, limits)]),
        lambda limits: CommandFollower(limits, dt=0.1),
        lambda limits: certify(min_time_move(1.0, ONE), limits),
        lambda limits: binding_limits(min_time_move(1.0, ONE), limits),
        lambda limits: min_time_move(1.0, ONE).violation(limits),
    ],
    ids=range(9),
)
def test_what_is_about_one_motion_refuses_arrays_with_a_remedy(call):
    call(ONE)
    with pytest.raises(
        TypeError, match=r"limits of shape \(2,\): .*; min_time_moves and min_time_tr"
    ):
        call(MANY)


ONE_SIDED = [
    Limits.from_bounds([*[None] * (order - 1), pair])
    for order in range(2, 7)
    for pair in ((-inf, 3.0), (-3.0, inf))
]


@pytest.mark.parametrize("limits", ONE_SIDED, ids=repr)
def test_a_highest_bound_on_one_side_is_refused_in_the_same_words(limits):
    told = r"is bounded in one direction only, \((-inf, 3|-3, inf)\): expected both bounds of the h"
    calls = [
        lambda: min_time_move(1.0, limits),
        lambda: min_time_move(0.0, limits),
        lambda: min_time_move(-1.0, limits, method="closed-form"),
        lambda: recursive_s_curve(1.0, limits),
        lambda: min_time_moves([1.0, 2.0], limits),
    ]
    if limits.order < 4:
        calls += [
            lambda: min_time_transfer(0.0, 1.0, limits),
            lambda: velocity_transfer(0.0, 1.0, limits),
            lambda: min_time_transfers([0.0], [1.0], limits),
            lambda: CommandFollower(limits, dt=0.1),
        ]
    for call in calls:
        with pytest.raises(ValueError, match=told):
            call()


@pytest.mark.parametrize(
    ("limits", "bounded"),
    [
        (Limits(1.0, 2.0, 3.0), True),
        (Limits(1.0, (-2.0, 3.0)), True),
        (Limits(velocity=1.0, jerk=(-inf, 3.0)), False),
        (Limits(velocity=1.0, jerk=np.array([1.0, inf])), False),
        (Limits(jerk=np.array([[-1.0, 2.0], [-1.0, 3.0]])), True),
        (Limits(jerk=np.array([[-1.0, 2.0], [-inf, 3.0]])), False),
    ],
)
def test_they_remember_what_checks_ask(limits, bounded, monkeypatch):
    asked = (limits.shape, limits.symmetric, limits.both_sides)
    assert asked[2] == bounded

    def refuse(*_):
        raise AssertionError("worked out again")

    for name in ("all", "isfinite", "negative", "broadcast_shapes"):
        monkeypatch.setattr(np, name, refuse)
    assert (limits.shape, limits.symmetric, limits.both_sides) == asked
