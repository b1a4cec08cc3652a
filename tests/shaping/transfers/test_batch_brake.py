"""Many starts brought inside: as one by one, and identities."""

from math import inf

import numpy as np
import pytest
from batches import edge_transfers, stacked, unstacked
from strategies import TransferProblem, random_transfer

from jounce.shaping.transfers import brake as scalar
from jounce.shaping.transfers.batch_brake import brake, outside
from jounce.shaping.transfers.batch_tasks import take
from jounce.shaping.transfers.task import taylor

ORDERS = pytest.mark.parametrize("order", [2, 3])


@pytest.fixture(autouse=True)
def _as_in_a_batch():
    """Let what is not chosen divide by zero."""
    with np.errstate(all="ignore"):
        yield


def starts_outside(seed, order, count=400):
    """Return problems whose starts are outside, most of them, some between narrow bounds."""
    rng = np.random.default_rng((20, seed))
    problems = []
    for k in range(count):
        problem = random_transfer(rng, order)
        factor = 0.05 if k % 4 == 0 else 1.0
        bounds = [(low * factor, high * factor) for low, high in problem.bounds[:1]]
        away = (float(rng.uniform(*pair) * rng.uniform(0.0, 6.0)) for pair in problem.bounds[:-1])
        problems.append(
            TransferProblem((0.0, *away), problem.end, (*bounds, *problem.bounds[1:]))
        )  # fmt: skip
    return problems


def leaving(problems):
    """Return problems whose starts cannot keep their bounds, and their tasks."""
    tasks = stacked([problem.task for problem in problems])
    [which] = np.nonzero(outside(tasks))
    return [problems[i] for i in which], take(tasks, which)


@ORDERS
@pytest.mark.parametrize("seed", range(3))
def test_outside_are_those_that_braking_takes_time_for(order, seed):
    problems = starts_outside(seed, order) + edge_transfers((21, seed), order, 400)
    tasks = stacked([problem.task for problem in problems])
    for problem, found in zip(problems, outside(tasks), strict=True):
        pieces, _, _ = scalar.brake(problem.task, 0.0)
        if bool(pieces) != found:  # by less than rounding
            assert sum(time for time, _ in pieces) < 1e-14, problem


@ORDERS
@pytest.mark.parametrize("seed", range(3))
def test_the_way_inside_is_that_of_each(order, seed):
    problems, tasks = leaving(starts_outside(seed, order) + edge_transfers((21, seed), order, 400))
    assert len(problems) > 200
    durations, states, left = brake(tasks)
    for i, (problem, after) in enumerate(zip(problems, unstacked(left), strict=True)):
        pieces, expected, _ = scalar.brake(problem.task, 0.0)
        some = durations[:, i] > 1e-14
        steps = [(time, row) for time, row in pieces if time > 1e-14]
        assert durations[some, i] == pytest.approx([time for time, _ in steps], rel=1e-12), problem
        for row, (_, wanted) in zip(states[some, :, i], steps, strict=True):
            assert row.tolist() == pytest.approx(wanted, rel=1e-11, abs=1e-12), problem
        assert after == pytest.approx(expected, rel=1e-11, abs=1e-12), problem


@ORDERS
def test_each_step_begins_where_the_one_before_ends(order):
    problems, tasks = leaving(starts_outside(9, order))
    durations, states, left = brake(tasks)
    assert (durations >= 0.0).all()
    for i, (problem, after) in enumerate(zip(problems, unstacked(left), strict=True)):
        some = durations[:, i] > 0.0
        rows = states[some, :, i].tolist()
        assert rows[0][:order] == list(problem.start)
        ends = [taylor(row, time) for row, time in zip(rows, durations[some, i], strict=True)]
        x = problem.task.distance - after.distance
        following = [*rows[1:], [x, after.v0, after.a0]]
        scale = np.abs(rows).max() + 1.0
        for end, begin in zip(ends, following, strict=True):
            assert end[:order] == pytest.approx(begin[:order], abs=1e-12 * scale), problem


@ORDERS
def test_what_is_left_is_inside(order):
    problems, tasks = leaving(starts_outside(10, order))
    _, _, left = brake(tasks)
    slack = 1e-12 * (1.0 + np.abs(left.v0))
    assert (left.v0 <= left.v_max + slack).all()
    assert (left.v0 >= left.v_min - slack).all()
    if order == 3:
        top = left.v0 + np.maximum(left.a0, 0.0) ** 2 / (2.0 * left.fall)
        bottom = left.v0 - np.minimum(left.a0, 0.0) ** 2 / (2.0 * left.rise)
        assert (top <= left.v_max + slack).all(), problems
        assert (bottom >= left.v_min - slack).all(), problems
    assert (left.a0 <= left.a_max).all()
    assert (left.a0 >= left.a_min).all()


@ORDERS
def test_mirrored(order):
    _, tasks = leaving(starts_outside(11, order))
    durations, states, left = brake(tasks)
    other_durations, other_states, other = brake(tasks.mirror())
    np.testing.assert_array_equal(other_durations, durations)
    some = np.broadcast_to((durations > 0.0)[:, None], states.shape)
    np.testing.assert_array_equal(other_states[some], -states[some])
    assert unstacked(other) == unstacked(left.mirror())


@pytest.mark.parametrize(
    ("v0", "a0", "total", "v", "a"),
    [
        (-1.0, 2.2, 0.1, -0.79, 2.0),  # acceleration above its bound: falls to 2 at a rate of 2
        (0.0, 3.0, 2.625, 1.0, -2.0),  # the same, then to −2 in 2 s, and 1/8 s there
        (2.0, 0.0, 1.0, 1.0, -2.0),  # falls to −2 in 1 s, velocity to 1 on the way
        (1.0, 1.0, 1.0, 1.0, -1.0),  # bound to leave: velocity back at its bound after 0.5 + 0.5 s
        (-1.0, -1.0, 1.0, -1.0, 1.0),
    ],
)
def test_by_hand(v0, a0, total, v, a):
    bounds = ((-1.0, 1.0), (-2.0, 2.0), (-2.0, 2.0))
    tasks = stacked([TransferProblem((0.0, v0, a0), (5.0, 0.0, 0.0), bounds).task] * 2)
    assert outside(tasks).all()
    durations, _, left = brake(tasks)
    assert durations.sum(axis=0) == pytest.approx(total, rel=1e-14)
    assert left.v0 == pytest.approx(v, rel=1e-14)
    assert left.a0 == pytest.approx(a, rel=1e-14)


@pytest.mark.parametrize(
    ("v0", "a0"), [(1.0, 0.0), (-1.0, 0.0), (0.75, 1.0), (-0.75, -1.0), (1.0, -2.0), (0.0, 2.0)]
)
def test_at_the_edge_it_is_inside(v0, a0):
    bounds = ((-1.0, 1.0), (-2.0, 2.0), (-2.0, 2.0))
    task = TransferProblem((0.0, v0, a0), (5.0, 0.0, 0.0), bounds).task
    tasks = stacked([task, task._replace(v_min=-inf), task._replace(a_min=-inf)])
    assert not outside(tasks).any()
