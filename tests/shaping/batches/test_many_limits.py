"""Limits of many moves: what may be given, parts of them, and what memory they share."""

import re
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from strategies import any_limits

from jounce.shaping import Limits
from jounce.shaping.batches.many_limits import flat_part, many_limits


def bounds(limits):
    """Return rising and falling bounds as lists."""
    return [[side.tolist() for side in sides] for sides in (limits.rising, limits.falling)]


@given(limits=any_limits())
def test_limits_come_back(limits):
    many = many_limits(limits)
    assert many.single() == limits
    assert many.order == limits.order
    assert many.symmetric == limits.symmetric


def test_a_mapping_fills_gaps_and_ends_with_its_last_bound():
    many = many_limits({"jerk": [1, 2], "velocity": (-3.0, [4.0, 5.0]), "pop": [inf, inf]})
    assert bounds(many) == [[[4.0, 5.0], inf, [1.0, 2.0]], [3.0, inf, [1.0, 2.0]]]
    assert not many.symmetric


def test_equal_bounds_are_one_array():
    table = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    for given_ in (table, np.stack([-table, table], axis=-1), Limits(1.0, 2.0)):
        many = many_limits(given_)
        assert many.symmetric
        assert len(many.arrays) == 2
        assert all(up is down for up, down in zip(many.rising, many.falling, strict=True))
        assert many.part((3,), slice(1, 2)).symmetric
        assert many.each((3,), [0, 2]).symmetric
    skewed = many_limits({"velocity": (-table, table + 1.0), "jerk": table})
    assert len(skewed.arrays) == 4  # two of velocity, one of acceleration, one of jerk


def test_parts_are_counted_in_c_order():
    v, j = np.array([[1.0], [2.0], [3.0]]), np.array([5.0, 6.0])
    many = many_limits({"velocity": v, "acceleration": 9.0, "jerk": (-j, 2.0 * j)})
    part = many.part((3, 2), slice(1, 4))
    assert bounds(part) == [
        [[1.0, 2.0, 2.0], 9.0, [12.0, 10.0, 12.0]],
        [[1.0, 2.0, 2.0], 9.0, [6.0, 5.0, 6.0]],
    ]
    assert many.each((3, 2), (2, 1)).single() == Limits(3.0, 9.0, (-6.0, 12.0))
    assert bounds(many.each((3, 2), 1)) == [[[2.0, 2.0], 9.0, [10.0, 12.0]],
                                            [[2.0, 2.0], 9.0, [5.0, 6.0]]]  # fmt: skip


def test_parts_of_what_is_there_already_are_not_copied():
    array = np.arange(1.0, 7.0)
    assert np.shares_memory(flat_part(array, (6,), slice(2, 4)), array)
    number = np.broadcast_to(np.array(3.0), (6,))
    assert flat_part(number, (6,), slice(2, 4)).shape == ()


def test_each_direction_sees_its_own_bounds():
    many = many_limits({"velocity": (-1.0, 2.0), "acceleration": (-3.0, 4.0), "jerk": 5.0})
    seen = many.directed(np.array([True, False]))
    assert bounds(seen) == [[[2.0, 1.0], [4.0, 3.0], 5.0], [[1.0, 2.0], [3.0, 4.0], 5.0]]
    assert [bound.tolist() for bound in seen.smaller()] == [[2.0, 1.0], [3.0, 3.0], 5.0]


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({}, "no limits given: bound at least one derivative"),
        ({"velocity": inf, "jerk": None}, "no limits given"),
        ({"position": 1.0}, "position has no limit here"),
        (
            {"speed": 1.0},
            "unknown derivative 'speed' in limits: expected a number from 1 to 40 or one of "
            "velocity, acceleration, jerk, snap, crackle, pop",
        ),
        ({10**8: 1.0}, "derivative 100000000 in limits: expected a number from 1 to 40"),
        ({-1: 1.0}, "derivative -1"),
        ({"jerk": 1.0, 3: 2.0}, "jerk is bounded twice, by its name and its number"),
        ({"jerk": 0.0}, "jerk limit = 0.0: expected positive numbers, or a tuple"),
        ({"jerk": [1.0, -2.0]}, "jerk limit[1] = -2.0: expected positive"),
        ({"jerk": [[1.0, 2.0], [nan, 3.0]]}, "jerk limit[1, 0] = nan: expected positive"),
        ({"jerk": ([-1.0, 2.0], 3.0)}, "jerk limit[1] = 2.0: expected positive"),
        ({"jerk": (1.0, 2.0)}, "jerk limit = 1.0: expected positive numbers, or a tuple (lower"),
        ([[1.0, 2.0], [1.0, -3.0]], "acceleration limit[1] = -3.0: expected positive"),
        (np.array([[[1.0, 2.0]]]), "velocity limit[0] = 1.0: expected positive"),
    ],
    ids=range(14),
)
def test_what_is_no_bound_is_refused(limits, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        many_limits(limits)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (None, "limits = None: expected Limits, a mapping such as"),
        (2.0, "limits = 2.0: expected Limits"),
        ("fast", "limits = 'fast': expected Limits"),
        ([[1.0], [1.0, 2.0]], "limits = [[1.0], [1.0, 2.0]]: expected Limits"),
        (np.ones((2, 3, 3)), "limits of shape (2, 3, 3): expected Limits"),
        (np.ones((1, 2, 3, 2)), "limits of shape (1, 2, 3, 2): expected Limits"),
        ({"jerk": "1"}, "jerk limit = '1': expected positive numbers"),
        ({"jerk": True}, "jerk limit = True: expected positive numbers"),
        ({"jerk": (1.0, 2.0, 3.0)}, "jerk limit = (1.0, 2.0, 3.0): expected positive numbers"),
        ({1.5: 2.0}, "derivative 1.5 in limits: expected a number from 1 to 40"),
        ([[None, 1.0]], "limits = [[None, 1.0]]: expected Limits"),
        ([["1", "2"]], "limits = [['1', '2']]: expected Limits"),
        (np.ones((2, 2)) * 1j, "expected Limits, a mapping"),
        ({"jerk": [1.0, 2j]}, "jerk limit = [1.0, 2j]: expected positive numbers"),
        ({"jerk": [[1.0], [1.0, 2.0]]}, "jerk limit = [[1.0], [1.0, 2.0]]: expected positive"),
        ({"jerk": ["a"] * 1000}, "'a', ...]: expected positive numbers"),
        ({"jerk": 10**400}, ": expected positive numbers"),
    ],
    ids=range(17),
)
def test_limits_of_another_kind_are_refused(limits, message):
    with pytest.raises(TypeError, match=re.escape(message)):
        many_limits(limits)


def test_whole_numbers_beyond_64_bits_are_numbers():
    many = many_limits({"velocity": 10**30, "jerk": [10**40, 2]})
    assert bounds(many)[0] == [1e30, inf, [1e40, 2.0]]
