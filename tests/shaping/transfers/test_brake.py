"""Starts outside their bounds, or bound to leave them: a linear program, and identities."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from references import TRANSFER_BOUND, assert_sound_transfer
from scipy.optimize import linprog
from strategies import TransferProblem, random_transfer

from jounce.shaping.transfers.brake import brake, inside
from jounce.shaping.transfers.task import Task

BOUNDS = ((-1.0, 1.0), (-2.0, 2.0), (-2.0, 2.0))


def outside(seed, order=3):
    """Return a problem whose start is outside its bounds, most of the time."""
    rng = np.random.default_rng((3, seed))
    problem = random_transfer(rng, order)
    away = (float(rng.uniform(*pair) * rng.uniform(0.0, 6.0)) for pair in problem.bounds[:-1])
    return replace(problem, start=(problem.start[0], *away))


def keeps(task, slack=1e-12):
    """Tell whether a state keeps its bounds for good, if the jerk does what it can."""
    bottom, top = task.v0, task.v0
    if task.a0 > 0.0:
        top += task.a0**2 / (2.0 * task.fall)
    elif task.a0 < 0.0:
        bottom -= task.a0**2 / (2.0 * task.rise)
    slack *= 1.0 + abs(task.v0) + abs(task.a0)
    return (
        task.v_min - slack <= bottom
        and top <= task.v_max + slack
        and task.a_min - slack <= task.a0 <= task.a_max + slack
    )


def inside_for_good(task, states):
    """Return rows and sides of `rows @ (a, v) ≤ sides`: states that keep their bounds for good.

    Parabolas v + a²/(2·fall) ≤ v_max for a > 0, and the other for a < 0, by tangents.
    """
    rows, sides = [states[0], -states[0]], [task.a_max, -task.a_min]
    for a in np.linspace(0.0, task.a_max, 200):
        rows.append(states[1] + a / task.fall * states[0])
        sides.append(task.v_max + 0.5 * a * a / task.fall)
    for a in np.linspace(task.a_min, 0.0, 200):
        rows.append(-states[1] + a / task.rise * states[0])
        sides.append(-task.v_min + 0.5 * a * a / task.rise)
    return rows, sides


def can_be_inside(task, time, cells=60):
    """Tell by a linear program whether a start can be inside for good in a time.

    Acceleration outside its bounds comes back as fast as it can, and may not leave them again.
    """
    h = time / cells
    steps = np.arange(1, cells + 1)
    ramps = h * np.tri(cells)
    gains = h * h * (cells - np.arange(cells) - 0.5)
    rows, sides = inside_for_good(task, (ramps[-1], gains))
    begin = np.array([task.a0, task.v0 + task.a0 * time])
    from_start = inside_for_good(task, begin[:, None])[0]
    sides = [side - float(row[0]) for side, row in zip(sides, from_start, strict=True)]
    upper = np.maximum(task.a_max, task.a0 - task.fall * h * steps) - task.a0
    lower = np.minimum(task.a_min, task.a0 + task.rise * h * steps) - task.a0
    result = linprog(
        np.zeros(cells),
        A_ub=np.vstack([*rows, ramps, -ramps]),
        b_ub=np.array([*sides, *(upper + 1e-9), *(1e-9 - lower)]),
        bounds=(-task.fall, task.rise),
        method="highs",
    )
    assert result.status in (0, 2), result.message
    return result.status == 0


@pytest.mark.parametrize("seed", range(24))
def test_no_way_inside_is_faster(seed):
    problem = outside(seed)
    task = problem.task
    time = sum(duration for duration, _ in brake(task, 0.0)[0])
    if time == 0.0:
        assert keeps(task), problem
        return
    assert can_be_inside(task, 1.03 * time), problem
    assert not can_be_inside(task, 0.97 * time), problem


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(60))
def test_what_is_left_begins_where_braking_ends_and_keeps_its_bounds(order, seed):
    problem = outside(seed, order)
    pieces, left, position = brake(problem.task, problem.start[0])
    assert left.distance == pytest.approx(problem.end[0] - position, abs=1e-12 * abs(position))
    begun = [position, left.v0, left.a0][:order]
    if order == 3:
        assert keeps(left), problem
    else:
        assert left.v_min <= left.v0 <= left.v_max
    if pieces:
        way = replace(problem, end=tuple(begun), bounds=(None, None, *problem.bounds[2:])[:order])
        way = way if order == 3 else replace(way, bounds=(None, problem.bounds[1]))
        assert_sound_transfer(way, way.trajectory(pieces))
    else:
        assert begun == list(problem.start), problem


@pytest.mark.parametrize("seed", range(60))
def test_mirrored(seed):
    problem = outside(seed)
    pieces, left, position = brake(problem.task, problem.start[0])
    other, mirrored, place = brake(problem.task.mirror(), -problem.start[0])
    assert (mirrored, place) == (left.mirror(), -position)
    assert other == [(time, tuple(-value for value in row)) for time, row in pieces]


# Through the door


@pytest.mark.parametrize(
    ("start", "inside_after"),
    [
        ((0.0, -1.0, 2.2), 0.1),  # acceleration above its bound: falls to 2 at a rate of 2
        ((0.0, 0.0, 3.0), 2.625),  # the same, then to −2 in 2 s, and 1/8 s there
        ((0.0, 2.0, 0.0), 1.0),  # falls to −2 in 1 s, velocity to 1 on the way
        ((0.0, 1.0, 1.0), 1.0),  # bound to leave: velocity back at its bound after 0.5 + 0.5 s
        ((0.0, -1.0, -1.0), 1.0),
        ((0.0, 1.0, 0.0), 0.0),
        ((0.0, 0.75, 1.0), 0.0),  # tops out at the bound
    ],
)
def test_a_start_outside_is_brought_inside(start, inside_after):
    problem = TransferProblem(start, (5.0, 0.0, 0.0), BOUNDS)
    transfer = problem.solve()
    assert transfer.inside_after == pytest.approx(inside_after, rel=1e-14), problem
    assert_sound_transfer(problem, transfer, transfer.inside_after)
    assert (transfer.violation(problem.limits) > 0.09) == (inside_after > 0.0)


@pytest.mark.parametrize("seed", range(40))
def test_arrival_by_way_of_the_opposite_bound(seed):
    """Far above a narrow band the fall must be broken before it passes through the band."""
    rng = np.random.default_rng(seed)
    high, fall, rise = (float(x) for x in 10.0 ** rng.uniform(-1.0, 1.0, 3))
    bounds = ((-0.1 * high, 0.1 * high), (-9.0, 9.0), (-fall, rise))
    start = (0.0, float(rng.uniform(0.2, 40.0)) * high, float(rng.uniform(-3.0, 3.0)))
    problem = TransferProblem(start, (1.0, 0.0, 0.0), bounds)
    transfer = problem.solve()
    assert transfer.inside_after > 0.0
    assert_sound_transfer(problem, transfer, transfer.inside_after)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(60))
def test_every_start_outside_is_brought_inside(order, seed):
    problem = outside(seed, order)
    transfer = problem.solve()
    assert_sound_transfer(problem, transfer, transfer.inside_after)
    if transfer.inside_after == 0.0:
        assert transfer.violation(problem.limits) <= TRANSFER_BOUND, problem


def test_order_2_brakes_with_the_acceleration_towards_the_bound():
    problem = TransferProblem((0.0, 3.0), (9.0, 0.0), ((-1.0, 1.0), (-4.0, 0.5)))
    transfer = problem.solve()
    assert transfer.inside_after == 0.5
    assert transfer(0.5, "velocity") == 1.0
    back = TransferProblem((0.0, -3.0), (9.0, 0.0), problem.bounds).solve()
    assert (back.inside_after, float(back(4.0, "velocity"))) == (4.0, -1.0)


def test_a_start_that_would_leave_only_after_the_end_is_planned_directly():
    """Velocity 0.9 rising at 1 under jerk 1 goes beyond 1; not within the 0.05 s asked here."""
    end = (0.9 * 0.05 + 0.5 * 0.05**2, 0.95, 1.0)
    problem = TransferProblem((0.0, 0.9, 1.0), end, ((-1.0, 1.0),) * 3)
    transfer = problem.solve()
    assert (transfer.duration, transfer.inside_after) == (pytest.approx(0.05, rel=1e-13), 0.0)
    assert_sound_transfer(problem, transfer)
    assert transfer.violation(problem.limits) == 0.0


# Rounding


@pytest.mark.parametrize("bound", [1.0, 0.3, 7e-9, 1e16])
def test_an_excess_of_mere_rounding_is_none(bound):
    assert inside(bound * (1.0 + 4e-16), -bound, bound) == bound
    assert inside(-bound * (1.0 + 4e-16), -bound, bound) == -bound
    for value in (bound, -bound, 0.5 * bound, bound * (1.0 + 1e-14), -bound * (1.0 + 1e-14)):
        assert inside(value, -bound, bound) == value


def test_without_bounds_nothing_is_outside():
    for jerk in (1.0, inf):
        task = Task(1.0, 9.0, 0.0, 0.0, 0.0, -inf, inf, -1.0, 1.0, jerk, jerk)
        pieces, left, position = brake(task, 5.0)
        assert pieces == []
        assert (left, position) == (task, 5.0)
