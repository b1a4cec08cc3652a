"""Tasks as plain numbers: mirrored, and in units of their own."""

from math import frexp, inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import transfer_problems

from jounce.shaping.transfers.task import Task, own_units

POWERS = st.integers(-60, 60).map(lambda exponent: 2.0**exponent)
REST = Task(0.0, 0.0, 0.0, 0.0, 0.0, -inf, inf, -inf, inf, 1.0, 1.0)


@given(problem=transfer_problems())
def test_a_mirrored_task_is_that_of_the_mirrored_problem(problem):
    task = problem.task
    assert task.mirror() == problem.mirrored().task
    assert task.mirror().mirror() == task


@given(problem=transfer_problems(), time=POWERS, distance=POWERS)
def test_units_of_powers_of_two_round_nothing(problem, time, distance):
    task = problem.task
    assert task.in_units(time, distance) == problem.in_units(1.0 / distance, 1.0 / time).task
    assert task.in_units(time, distance).in_units(1.0 / time, 1.0 / distance) == task


@given(problem=transfer_problems(), time=st.floats(1e-3, 1e3), distance=st.floats(1e-3, 1e3))
def test_resolution_is_a_distance(problem, time, distance):
    task = problem.task._replace(resolution=1e-9)
    assert task.in_units(time, distance).resolution == 1e-9 / distance
    assert task.mirror().resolution == 1e-9


@given(problem=transfer_problems())
def test_in_its_own_units_the_task_is_of_order_one(problem):
    """Times that speeds, accelerations and the distance take alone: the longest is about 1."""
    task = problem.task
    time, distance = own_units(task)
    assert frexp(time)[0] == frexp(distance)[0] == 0.5
    own = task.in_units(time, distance)
    power = min(own.a_max, -own.a_min) if own.rise == inf else min(own.rise, own.fall)
    speed = max(abs(own.v0), abs(own.v1)) / power
    if own.rise == inf:
        spans = [speed, (abs(own.distance) / power) ** 0.5]
    else:
        turn = max(abs(own.a0), abs(own.a1)) / power
        spans = [turn, speed**0.5, (abs(own.distance) / power) ** (1.0 / 3.0)]
    if max(spans) > 0.0:
        assert 0.499 <= max(spans) <= 1.001
        assert 0.499 <= power <= 8.01


@given(problem=transfer_problems(), time=POWERS, distance=POWERS)
def test_own_units_scale_with_the_numbers(problem, time, distance):
    """But for a cube root that lies on a power of two, and is rounded to either side."""
    first = own_units(problem.task)
    other = own_units(problem.in_units(distance, time).task)
    ratios = [other[0] / (first[0] * time), other[1] / (first[1] * distance)]
    if first != (1.0, 1.0):
        assert set(ratios) <= {0.5, 1.0, 2.0}


def test_a_task_without_any_size_keeps_its_units():
    assert own_units(REST) == (1.0, 1.0)
    assert own_units(REST._replace(rise=inf, fall=inf, a_min=-1.0, a_max=1.0)) == (1.0, 1.0)


@pytest.mark.parametrize(
    "task",
    [
        REST._replace(distance=1e300, rise=1e-300, fall=1e-300),
        REST._replace(a0=1e300, rise=1e-300),
        REST._replace(v1=1e-200, rise=1e100, fall=1e100),
        REST._replace(distance=1e300, rise=inf, fall=inf, a_min=-1.0, a_max=1e-300),
    ],
)
def test_sizes_out_of_range_are_refused(task):
    with pytest.raises(OverflowError):
        own_units(task)


@pytest.mark.parametrize(
    ("changes", "within"),
    [
        ({}, True),
        ({"v0": 1.0, "a0": -2.0}, True),
        ({"v0": 1.0 + 1e-15}, False),
        ({"v0": -3.1}, False),
        ({"a0": 2.5}, False),
        ({"a0": -2.0 - 1e-15}, False),
        ({"v1": 9.0, "a1": 9.0}, True),
    ],
)
def test_within_bounds_looks_at_the_start(changes, within):
    task = REST._replace(v_min=-3.0, v_max=1.0, a_min=-2.0, a_max=2.0)
    assert task._replace(**changes).within_bounds() is within
