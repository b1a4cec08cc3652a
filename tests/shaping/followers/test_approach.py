"""The fastest motion towards a moving command: the transfer seen from it, or what bounds allow."""

from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import random_transfer, transfer_problems

from jounce.shaping import Limits, min_time_transfer, velocity_transfer
from jounce.shaping.followers.approach import approach
from jounce.shaping.transfers.task import Task

DT = 0.01
SHARES = st.floats(-0.9375, 0.9375, width=32)


def bounds_of(pairs):
    """Return a task of which only the bounds count."""
    pairs = [pair or (-inf, inf) for pair in (*pairs, None)]
    return Task(*[0.0] * 5, *pairs[0], *pairs[1], -pairs[2][0], pairs[2][1])


def later(row, time):
    """Return position and derivatives a time after a piece's start."""
    shape = np.polynomial.Polynomial(np.array(row) / [1.0, 1.0, 2.0, 6.0][: len(row)])
    return [shape.deriv(k)(time) if k else shape(time) for k in range(len(row))]


def check_joints(pieces, start, text):
    """Assert continuity from the start to the resting piece, which goes on for ever."""
    order = len(pieces[0][1]) - 1
    rows = np.array([row for _, row in pieces])
    scale = np.abs(rows).max(axis=0) + 1e-300
    assert pieces[0][1][:order] == pytest.approx(start[:order], rel=1e-13, abs=1e-15), text
    for (time, row), (_, following) in pairwise(pieces):
        error = np.abs(np.subtract(later(row, time), following))
        assert time > 0.0, text
        assert (error[:order] <= 1e-10 * scale[:order] + 1e-14).all(), (text, row, following)
    assert pieces[-1][0] == inf
    assert list(pieces[-1][1][1:]) == [0.0] * order


@given(problem=transfer_problems(), share=SHARES)
def test_it_is_the_transfer_to_rest_as_seen_from_the_command(problem, share):
    low, high = problem.bounds[0] or (-3.0, 3.0)
    u = share * (high if share > 0.0 else -low)
    x, v, *a = problem.start
    seen = problem.bounds[0] and (low - u, high - u)
    start = (x - problem.end[0], v - u, *a)
    transfer = min_time_transfer(start, 0.0, Limits.from_bounds([seen, *problem.bounds[1:]]))
    pieces = approach((*start, 0.0)[:3], 0.0, u, bounds_of(problem.bounds), DT)
    text = f"approach({(*start, 0.0)[:3]}, 0.0, {u}, bounds_of({problem.bounds}))"
    duration = sum(time for time, _ in pieces[:-1])
    assert duration == pytest.approx(transfer.duration, rel=1e-9, abs=1e-9), text
    assert pieces[-1][1][0] == 0.0, text
    check_joints(pieces, start, text)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_behind_a_command_at_the_bound_it_goes_to_the_bound_as_fast_as_it_can(order, seed):
    """It does not arrive at the command, and at the command's velocity it rests beside it."""
    problem = random_transfer(np.random.default_rng((order, seed)), order)
    low, high = problem.bounds[0]
    _, v, *a = problem.start
    for u, sign in ((high, -1.0), (low, 1.0)):
        relative = (1e6 * sign, v - u, *a)
        pieces = approach((*relative, 0.0)[:3], 0.0, u, bounds_of(problem.bounds), DT)
        spin_up = velocity_transfer(problem.start, u, problem.limits)
        duration = sum(time for time, _ in pieces[:-1])
        assert duration == pytest.approx(spin_up.duration, rel=1e-12), (problem, u)
        gain = spin_up.end_state[0] - problem.start[0] - u * spin_up.duration
        assert pieces[-1][1][0] == pytest.approx(1e6 * sign + gain, rel=1e-12), (problem, u)
        check_joints(pieces, relative, (problem, u))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_ahead_of_a_command_at_the_bound_it_waits_and_arrives(order, seed):
    problem = random_transfer(np.random.default_rng((order, seed)), order)
    low, high = problem.bounds[0]
    _, v, *a = problem.start
    for u, sign in ((high, 1.0), (low, -1.0)):
        relative = (1e4 * sign, v - u, *a)
        pieces = approach((*relative, 0.0)[:3], 0.0, u, bounds_of(problem.bounds), DT)
        assert pieces[-1][1][0] == 0.0, (problem, u)
        check_joints(pieces, relative, (problem, u))
        speeds = [row[1] for _, row in pieces]
        slack = 1e-12 * (high - low)
        assert low - u - slack <= min(speeds) <= max(speeds) <= high - u + slack, (problem, u)
        opposite = low if sign > 0.0 else high
        least = 1e4 / abs(opposite - u)  # the way at the opposite bound alone
        assert sum(time for time, _ in pieces[:-1]) > least, (problem, u)


@pytest.mark.parametrize("order", [2, 3])
def test_at_the_command_nothing_is_left_to_do(order):
    bounds = bounds_of([(-1.0, 2.0), (-3.0, 4.0), (-5.0, 6.0)][:order])
    for u in (-1.0, 0.0, 0.7, 2.0):
        assert approach((0.0, 0.0, 0.0), 7.0, u, bounds, DT) == [(inf, (0.0,) * (order + 1))]


@given(problem=transfer_problems(), share=SHARES)
def test_its_mirror_image_is_the_mirrored_motion(problem, share):
    u = share * min(map(abs, problem.bounds[0] or (3.0,)))
    e, w, a = (*problem.start, 0.0)[:3]
    there = approach((e - 1.5, w - u, a), 2.0, u, bounds_of(problem.bounds), DT)
    back = approach((1.5 - e, u - w, -a), -2.0, -u, bounds_of(problem.mirrored().bounds), DT)
    assert [time for time, _ in back] == [time for time, _ in there], (problem, u)
    assert [row for _, row in back] == [tuple(-x for x in row) for _, row in there], (problem, u)


@pytest.mark.parametrize("relative", [(2.0, 9.0, 0.0), (-1.0, 0.3, 9.0), (0.0, -7.0, -3.5)])
def test_a_start_beyond_the_bounds_begins_with_bringing_it_inside(relative):
    pairs = [(-1.0, 2.0), (-3.0, 4.0), (-5.0, 6.0)]
    pieces = approach(relative, 0.0, 0.5, bounds_of(pairs), DT)
    seen = Limits.from_bounds([(-1.5, 1.5), *pairs[1:]])
    transfer = min_time_transfer(relative, 0.0, seen)
    assert transfer.inside_after > 0.0
    assert sum(time for time, _ in pieces[:-1]) == pytest.approx(transfer.duration, rel=1e-12)
    assert abs(pieces[0][1][3]) in (5.0, 6.0)
    check_joints(pieces, relative, relative)
