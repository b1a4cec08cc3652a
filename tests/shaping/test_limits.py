"""Limits: validation, pairs, order, mirror, equality, repr."""

import dataclasses
import math
from math import inf

import numpy as np
import pytest
from hypothesis import given
from strategies import any_limits

from jounce.shaping import Limits


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


NOT_AROUND_ZERO = [(1.0, 2.0), (-2.0, -1.0), (0.0, 1.0), (-1.0, 0.0), (2.0, -2.0)]
NOT_A_NUMBER = [math.nan, (math.nan, 1.0), (-1.0, math.nan)]


@pytest.mark.parametrize("value", [0.0, -1.0, -inf, *NOT_AROUND_ZERO, *NOT_A_NUMBER])
def test_a_bound_that_does_not_enclose_zero_is_refused(value):
    with pytest.raises(ValueError, match=r"snap limit .* expected a positive number or a pair"):
        Limits(snap=value)
    with pytest.raises(ValueError, match="snap limit"):
        Limits.from_bounds([1.0, 1.0, 1.0, value])


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
    with pytest.raises(ValueError, match="position has no limit"):
        Limits(velocity=1.0).bounds("position")


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
