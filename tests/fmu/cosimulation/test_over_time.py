"""Sources known in advance: tables against values by hand, functions, and what is refused."""

import re

import numpy as np
import pytest

from jounce.fmu.cosimulation.over_time import over_time, scaled
from jounce.fmu.importing.description import FmuError
from jounce.shaping import Limits, min_time_move

TIME = 0.25 * np.arange(9)


def values(source, *, steps=False, time=TIME):
    return over_time(source, "plant.u", time, steps=steps)[0].tolist()


def test_a_table_is_joined_by_lines_or_held():
    table = ([0.0, 1.0, 2.0], [0.0, 4.0, 2.0])
    assert values(table) == [0.0, 1.0, 2.0, 3.0, 4.0, 3.5, 3.0, 2.5, 2.0]
    assert values(table, steps=True) == [0.0] * 4 + [4.0] * 4 + [2.0]
    assert values(np.array(table)) == values(table)


def test_a_time_that_stands_twice_is_a_jump():
    table = ([0.0, 1.0, 1.0, 2.0], [1.0, 1.0, 5.0, 5.0])
    assert values(table) == [1.0] * 4 + [5.0] * 5
    assert values(table, steps=True) == [1.0] * 4 + [5.0] * 5


@pytest.mark.parametrize("steps", [False, True])
def test_a_jump_is_met_where_rounding_would_miss_it(steps):
    """0.1·3 is just above 0.3, 0.1·6 just above 0.6, and 1.1·3 is above 3.3 by rounding, too."""
    for dt in (0.1, 1.1, 0.7, 1e-3):
        time = dt * np.arange(60)
        for k in range(1, 59):
            for jump in (np.nextafter(time[k], 9e9), time[k], np.nextafter(time[k], 0.0)):
                table = ([0.0, jump, jump], [0.0, 0.0, 1.0])
                found = values(table, time=time, steps=steps)
                assert found == [0.0] * k + [1.0] * (60 - k)


def test_beyond_its_ends_a_table_is_held_and_that_is_told():
    found, note = over_time(([0.5, 1.0], [2.0, 3.0]), "plant.u", TIME, steps=False)
    assert found.tolist() == [2.0, 2.0, 2.0, 2.5, 3.0, 3.0, 3.0, 3.0, 3.0]
    assert "plant.u holds its first value until 0.5 and its last value from 1 on" in note
    for table in (([0.0, 2.0], [1.0, 1.0]), ([1.0], [3.0]), ([0.0, 1.75], [1.0, 2.0])):
        assert over_time(table, "plant.u", TIME, steps=False)[1] == ""


def test_functions_trajectories_and_numbers():
    assert values(lambda t: 2.0 * t) == (2.0 * TIME).tolist()
    move = min_time_move(1.0, Limits(velocity=2.0, acceleration=20.0))
    assert values(move) == move(TIME).tolist()
    assert values(3) == [3.0] * 9


ODD = 2**53 + 1
BESIDE = {"a number": ODD, "a function": lambda t: ODD if t else 1.0,
          "a list": ([0.0, 0.25], [1.0, ODD]),
          "objects": ([0, 1], np.array([1, ODD], object))}  # fmt: skip


@pytest.mark.parametrize("source", BESIDE.values(), ids=BESIDE)
def test_whole_numbers_of_64_bits_stay_exact(source):
    found = over_time(source, "plant.u", TIME, steps=True, exact=True)[0]
    assert found.tolist()[-1] == ODD
    assert over_time(source, "plant.u", TIME, steps=True)[0].tolist()[-1] == 2.0**53


def test_unsigned_and_signed_ones_in_one_table():
    table = ([0.0, 1.0], [2**64 - 1, -1])
    found = over_time(table, "plant.u", TIME, steps=True, exact=True)[0]
    assert found.tolist() == [2**64 - 1] * 4 + [-1] * 5


def test_truth_values_are_for_what_changes_in_steps():
    assert values(lambda t: t > 1.0, steps=True) == [0.0] * 5 + [1.0] * 4
    assert values(True, steps=True) == [1.0] * 9
    for source in (True, np.True_, lambda t: t > 1.0):
        with pytest.raises(TypeError, match="expected a number"):
            values(source)


@pytest.mark.parametrize(
    "source", [2.0, lambda t: t * t, ([0.0, 1.0, 2.0], [0.0, 4.0, 2.0])], ids=["n", "f", "table"]
)
def test_scaled_is_the_scaled_values(source):
    plain = np.array(values(source))
    np.testing.assert_allclose(values(scaled(source, -3.0, 0.5)), -3.0 * plain + 0.5, rtol=1e-15)
    assert scaled(source, 1.0, 0.0) is source


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (([0.0, 1.0], [1.0]), ["plant.u", "2 times and 1 values"]),
        (([], []), ["0 times"]),
        (([0.0, 2.0, 1.0], [1.0, 2.0, 3.0]), ["time 1 comes after 2", "sort"]),
        (([0.0, 1.0], [1.0, np.nan]), ["values[1]", "nan"]),
        (([0.0, np.inf], [1.0, 1.0]), ["times[1]", "inf"]),
        (([0.0, 1.0], ["a", "b"]), ["values", "plant.u", "numbers"]),
        (([0.0, 1.0], [1.0, 2.0], [3.0, 4.0]), ["3 parts", "(times, values)"]),
        (lambda t: np.inf if t > 0.6 else 1.0, ["plant.u at time 0.75", "inf"]),
        (lambda t: "1", ["plant.u at time 0"]),  # noqa: ARG005
        (None, ["plant.u is a NoneType", "a function of time or a pair"]),
        ({1.0, 2.0}, ["plant.u"]),
        (np.nan, ["plant.u"]),
    ],
    ids=[
        "lengths",
        "no times",
        "order",
        "nan value",
        "infinite time",
        "texts",
        "three parts",
        "infinite function",
        "text function",
        "none",
        "set",
        "nan",
    ],
)
def test_what_is_no_source_is_refused(source, words):
    with pytest.raises((FmuError, TypeError, ValueError), match=re.escape(words[0])) as caught:
        over_time(source, "plant.u", TIME, steps=False)
    assert all(word in str(caught.value) for word in words), caught.value
