"""The fastest change of velocity and acceleration: linear programs, and identities."""

from math import inf

import numpy as np
import pytest
from hypothesis import given
from references import TRANSFER_END, assert_sound_transfer, least_duration, replay
from strategies import TransferProblem, random_transfer, transfer_problems

from jounce.shaping.transfers.task import Task
from jounce.shaping.transfers.velocity_change import change_velocity


def changed(problem):
    """Return the problem ended where its change of velocity ends, and that change's pieces."""
    change = change_velocity(problem.task)
    end = problem.start[0] + change.distance
    moved = TransferProblem(problem.start, (end, *problem.end[1:]), problem.bounds)
    return moved, change.pieces(problem.start[0])


def unbounded_velocity(problem):
    """Return the problem without bounds of velocity, which a change does not look at."""
    return TransferProblem(problem.start, problem.end, (None, *problem.bounds[1:]))


@given(problem=transfer_problems())
def test_pieces_lead_to_the_end_within_the_bounds(problem):
    change = change_velocity(problem.task)
    moved, pieces = changed(unbounded_velocity(problem))
    assert sum(duration for duration, _ in pieces) == pytest.approx(change.duration, rel=1e-13)
    if change.duration > 0.0:
        assert_sound_transfer(moved, moved.trajectory(pieces))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(6))
def test_no_change_that_a_linear_program_finds_is_faster(order, seed):
    """To it velocity is what position is to a transfer, one order less."""
    problem = random_transfer(np.random.default_rng((11, seed)), order)
    below = TransferProblem(problem.start[1:], problem.end[1:], problem.bounds[1:])
    change = change_velocity(problem.task)
    if order == 2:
        gain, pair = problem.end[1] - problem.start[1], problem.bounds[1]
        assert change.duration == pytest.approx(max(gain / side for side in pair), rel=1e-14)
        return
    least = least_duration(below, 1.2 * change.duration)
    assert 0.97 * least <= change.duration <= 1.0001 * least, problem


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_mirrored(order, seed):
    problem = random_transfer(np.random.default_rng(seed), order)
    change, other = change_velocity(problem.task), change_velocity(problem.task.mirror())
    assert other.duration == change.duration
    assert other.distance == -change.distance
    back = change.mirror()
    assert (back.task, back.duration) == (problem.mirrored().task, change.duration)
    expected = [
        (time, tuple(-value for value in row)) for time, row in change.pieces(problem.start[0])
    ]
    assert back.pieces(-problem.start[0]) == expected
    assert back.mirror() == change


@given(problem=transfer_problems(orders=(3,)))
def test_it_leaves_the_bounds_where_its_velocity_does(problem):
    """From a start at rest within them, to ends that may be out of reach."""
    v, (low, high) = problem.end[1], problem.bounds[1] or (-3.0, 3.0)
    for a in (0.5 * low, low, 0.5 * high, high):
        ends = TransferProblem((0.0, 0.0, 0.0), (0.0, v, a), problem.bounds)
        moved, pieces = changed(ends)
        bottom, top = problem.bounds[0] or (-inf, inf)
        extremes = replay(moved.trajectory(pieces)).extremes[1]
        excess = max(extremes[0] / bottom, extremes[1] / top) - 1.0
        if abs(excess) > TRANSFER_END:
            assert change_velocity(ends.task).leaves_bounds() is (excess > 0.0), (ends, excess)


def test_nothing_to_change():
    for task in (
        Task(7.0, 1.0, 0.5, 1.0, 0.5, -inf, inf, -1.0, 1.0, 1.0, 1.0),
        Task(7.0, 1.0, 0.0, 1.0, 0.0, -inf, inf, -1.0, 1.0, inf, inf),
    ):
        change = change_velocity(task)
        assert (change.duration, change.distance, change.leaves_bounds()) == (0.0, 0.0, False)


@pytest.mark.parametrize(
    ("gain", "duration", "peak", "hold"),
    [(2.0, 3.0, 1.0, 1.0), (1.0, 2.0, 1.0, 0.0), (0.25, 1.0, 0.5, 0.0), (-2.0, 3.0, -1.0, 1.0)],
)
def test_from_rest_it_is_the_s_curve(gain, duration, peak, hold):
    """MEI, "S-Curve Jerk Algorithm": acceleration 1 and jerk 1, held from a gain of 1 on."""
    change = change_velocity(Task(0.0, 0.0, 0.0, gain, 0.0, -inf, inf, -1.0, 1.0, 1.0, 1.0))
    assert (change.duration, change.peak, change.hold) == (duration, peak, hold)
    assert change.distance == pytest.approx(0.5 * gain * duration, rel=1e-15)
