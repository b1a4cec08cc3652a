"""MotionBatch: pieces, motions one by one, values at common and own times, peaks."""

import copy
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from move_batches import as_trajectory, move_lists, random_moves, together
from references import BOUND, CONTINUITY, END_POSITION, joint_gaps
from tiers import some

from jounce.shaping import Limits, MotionBatch, Trajectory, min_time_moves, min_time_transfers
from jounce.shaping import batch as module

ORDERS = pytest.mark.parametrize("order", range(1, 7))
LIMITS = Limits(2.0, 3.0, 8.0)
VALUES = 1e-11  # of a derivative's peak: a break's rounding times the next derivative


def assert_close(values, move, t, text):
    """Assert that values (n + 1, T) are a trajectory's, but for the jumping derivative n."""
    expected = move.evaluate(t)
    for k in range(max(1, move.order)):
        scale = move.peak(k)
        np.testing.assert_allclose(
            values[k], expected[k], rtol=0, atol=VALUES * scale, err_msg=f"{text}: derivative {k}"
        )


# Pieces


@ORDERS
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
def test_pieces_make_a_sound_trajectory(order, even):
    problems = random_moves((1, order), order, 8, even=even)
    batch = together(problems)
    for i, problem in enumerate(problems):
        move = as_trajectory(batch, i)
        assert move.duration == batch.duration[i]
        assert move.violation(problem.limits) <= BOUND, problem
        assert max(joint_gaps(move)) <= 10 * CONTINUITY, problem
        end = problem.start + problem.distance
        assert abs(move(move.end_time) - end) <= END_POSITION * (abs(end) + abs(problem.start))
        np.testing.assert_array_equal(move.start_state[:-1], [problem.start, *[0.0] * (order - 1)])


@given(problems=move_lists(decades=12.0))
def test_pieces_keep_their_bounds_and_add_up(problems):
    batch = together(problems)
    breaks, durations, states = batch.pieces()
    assert (np.diff(breaks) >= 0.0).all()
    np.testing.assert_array_equal(breaks[:, -1], batch.duration)
    np.testing.assert_allclose(durations.sum(axis=1), batch.duration, rtol=1e-13)
    for problem, rows in zip(problems, states, strict=True):
        for k, (low, high) in enumerate(problem.bounds, start=1):
            assert rows[:, k].max() <= high * (1.0 + BOUND), problem
            assert rows[:, k].min() >= low * (1.0 + BOUND), problem


@ORDERS
def test_pieces_take_as_much_memory_as_documented(order):
    """Of the recursive S-curve, which has most of them; other forms leave some empty."""
    limits = Limits.from_bounds([0.1 * 10.0**k for k in range(order)])
    pieces = min_time_moves(np.geomspace(1e-6, 1e6, 50), limits).pieces()
    m = pieces.durations.shape[1]
    assert m <= 2**order - 1
    assert sum(array.nbytes for array in pieces) == 50 * 8 * ((m + 1) + m + m * (order + 1))


# As trajectories


@given(problems=move_lists(decades=3.0))
def test_each_is_the_move_alone(problems):
    batch = together(problems)
    for i, problem in enumerate(problems):
        move, alone = batch[i], problem.move()
        assert isinstance(move, Trajectory)
        assert move.duration == pytest.approx(alone.duration, rel=1e-12, abs=0.0), problem
        np.testing.assert_array_equal(move.end_state, alone.end_state)
        assert_close(move.evaluate(alone.breaks), alone, alone.breaks, problem)


def test_moves_are_counted_as_in_numpy():
    batch = min_time_moves([1.0, 2.0, 3.0], LIMITS, start=[0.0, 10.0, 20.0])
    assert batch[-1].end_state[0] == 23.0
    assert [move.end_state[0] for move in batch] == [1.0, 12.0, 23.0]
    with pytest.raises(IndexError):
        batch[3]
    assert len(batch) == 3
    assert repr(batch) == "MotionBatch(shape=(3,), order=3)"


@pytest.mark.parametrize("order", [3, 5])
@pytest.mark.parametrize("limits", ["one", "each"])
def test_an_index_makes_a_smaller_batch(order, limits):
    problems = random_moves((2, order), order, 7)
    batch = together(problems)
    if limits == "one":
        distances, starts = ([getattr(p, name) for p in problems] for name in ("distance", "start"))
        batch = min_time_moves(distances, problems[0].limits, start=starts)
    t = np.linspace(0.0, 2.0, 11)
    for index in (slice(2, 5), [4, 0], np.arange(7) % 2 == 0, slice(None, None, -3), slice(0, 0)):
        some = batch[index]
        assert isinstance(some, MotionBatch)
        np.testing.assert_array_equal(some.duration, batch.duration[index])
        np.testing.assert_allclose(some(t), batch(t)[index], rtol=1e-14, atol=1e-14)
        np.testing.assert_allclose(some.peak(order), batch.peak(order)[index], rtol=1e-14)


def test_grids_of_moves():
    v, j = np.array([[1.0], [2.0], [3.0]]), np.array([5.0, 50.0])
    grid = min_time_moves(-4.0, Limits(velocity=v, jerk=j), start=1.0)
    assert (grid.shape, grid.order, len(grid)) == ((3, 2), 3, 3)
    alone = grid[2, 1]
    assert isinstance(alone, Trajectory)
    assert alone.peak("velocity") == grid.peak("velocity")[2, 1] == 3.0
    assert grid[1].shape == (2,)
    assert grid.pieces().states.shape == (3, 2, 7, 4)
    times, states = grid.sample(0.1)
    assert states.shape == (4, 3, 2, len(times))
    assert_close(states[:, 2, 1], alone, times, "grid")


@pytest.mark.parametrize(
    "again",
    [
        copy.copy,
        copy.deepcopy,
        lambda pieces: pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(pieces)))),
    ],
)
def test_pieces_are_read_only_and_equal_by_their_numbers(again):
    """NaN included, where there is no motion."""
    states = [[0.0, 0.5, 0.1], [0.0, 0.0, 0.0]], [[1.0, 0.2, 0.0], [1.0, -1.99, 2.9]]
    batch = min_time_transfers(*states, LIMITS)
    assert np.count_nonzero(np.isnan(batch.duration)) == 1
    pieces, other = again(batch.pieces()), min_time_transfers(*states, Limits(2.0, 3.0, 8.1))
    assert pieces == batch.pieces()
    assert (pieces != batch.pieces()) is False
    assert hash(pieces) == hash(batch.pieces())
    assert pieces != other.pieces()
    assert pieces != batch[:1].pieces()
    assert pieces != tuple(array.tolist() for array in pieces)
    for array in pieces:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_the_arrays_are_read_only():
    batch = min_time_moves([1.0, 2.0], Limits(np.array([1.0, 2.0]), 2.0))
    for array in (batch.duration, batch.inside_after, batch.limits.upper[0], batch.limits.lower[0]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(AttributeError):
        batch.duration = batch.inside_after


# Values


@ORDERS
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
def test_values_are_those_of_the_moves(order, even):
    problems = random_moves((3, order), order, 12, even=even)
    batch = together(problems)
    t = np.linspace(-0.1, 1.1, 77) * np.median(batch.duration)
    values = batch.evaluate(t)
    assert values.shape == (order + 1, 12, 77)
    for i, problem in enumerate(problems):
        assert_close(values[:, i], problem.move(), t, problem)
    for k in range(order + 1):
        np.testing.assert_array_equal(batch(t, k), values[k])
    np.testing.assert_array_equal(batch.evaluate(t, 1), values[:2])
    assert not batch(t, order + 1).any()


@given(problems=move_lists(decades=2.0))
def test_values_at_rest(problems):
    """Before the start and from the end on, exactly."""
    batch = together(problems)
    before, after = -1e-9, batch.duration.max() + 1e-9
    values = batch.evaluate([before, after])
    ends = [p.start + p.distance for p in problems]
    np.testing.assert_array_equal(values[0, :, 0], [p.start for p in problems])
    np.testing.assert_array_equal(values[0, :, 1], ends)
    np.testing.assert_array_equal(values[1:], 0.0)
    at_end = batch.evaluate(batch.duration, each=True)
    np.testing.assert_array_equal(at_end[0], ends)
    np.testing.assert_array_equal(at_end[1:], 0.0)


def test_times_in_any_order_and_shape():
    batch = together(random_moves(4, 3, 5))
    t = np.random.default_rng(4).uniform(-0.2, 3.0, (6, 7))
    values = batch.evaluate(t)
    assert values.shape == (4, 5, 6, 7)
    t_sorted = np.sort(t.ravel())
    order = np.argsort(t.ravel())
    np.testing.assert_array_equal(values.reshape(4, 5, -1)[..., order], batch.evaluate(t_sorted))
    assert batch(0.5).shape == (5,)
    assert batch.evaluate([]).shape == (4, 5, 0)
    assert batch(t, 9).shape == (5, 6, 7)


@pytest.mark.parametrize("order", [3, 4])
def test_samples_end_with_the_longest(order):
    problems = random_moves((5, order), order, 6)
    batch = together(problems)
    longest = int(np.argmax(batch.duration))
    times, states = batch.sample(batch.duration.max() / 10.5)
    expected, alone = batch[longest].sample(batch.duration.max() / 10.5)
    np.testing.assert_allclose(times, expected, rtol=1e-14)
    assert states.shape == (order + 1, 6, 12)
    np.testing.assert_array_equal(states[:, longest, -1], alone[:, -1])
    end = [p.start + p.distance for p in problems]
    np.testing.assert_array_equal(states[0, :, -1], end)
    np.testing.assert_array_equal(batch.sample(batch.duration.max() / 10.5, "velocity")[1],
                                  states[:2])  # fmt: skip
    assert len(batch.sample(batch.duration.max() / 8.0)[0]) == 9


def test_samples_of_nothing():
    times, states = min_time_moves([0.0, 0.0], LIMITS, start=3.0).sample(0.1)
    assert (times.tolist(), states[0].tolist()) == ([0.0], [[3.0], [3.0]])
    empty = min_time_moves([], LIMITS)
    assert empty.sample(0.1)[1].shape == (4, 0, 1)
    assert empty.pieces().states.shape == (0, 7, 4)
    assert empty.peak("jerk").shape == (0,)


# Peaks


@ORDERS
@pytest.mark.parametrize("decades", some([12.0, 3.0], 1))
def test_peaks_are_those_of_the_moves(order, decades):
    problems = random_moves((6, order), order, 40, decades=decades, even=order != 2)
    batch = together(problems)
    for k in range(order + 2):
        expected = [batch[i].peak(k) for i in range(40)]
        np.testing.assert_allclose(batch.peak(k), expected, rtol=1e-13, err_msg=f"derivative {k}")


# What is refused


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda batch, t: batch(t), "makes 1e+11 values: expected at most 1e+09; use fewer times"),
        (lambda batch, t: batch(t, "pop"), "100000 times of 1000000 motions makes 1e+11 values"),
        (lambda batch, t: batch.evaluate(t), "makes 4e+11 values: expected at most 1e+09"),
        (lambda batch, t: batch.evaluate(t, "velocity"), "makes 2e+11 values"),
        (lambda batch, t: batch.evaluate(t[:251]), "makes 1e+09 values: expected at most 1e+09"),
        (lambda batch, _: batch.sample(1e-5), "dt = 1e-05 makes"),
    ],
    ids=["call", "zeros", "evaluate", "lower", "just", "sample"],
)
def test_more_values_than_fit_are_refused(call, message):
    """Of a million moves, before any memory is asked for."""
    batch = min_time_moves(np.ones(10**6), LIMITS)
    with pytest.raises(ValueError, match=re.escape(message)):
        call(batch, np.linspace(0.0, 1.0, 10**5))


def test_more_pieces_than_fit_are_refused(monkeypatch):
    batch = min_time_moves(np.ones(50), LIMITS)
    numbers = sum(array.size for array in batch.pieces())
    monkeypatch.setattr(module, "MAX_SAMPLES", numbers)
    assert batch.pieces().breaks.shape == (50, 8)
    monkeypatch.setattr(module, "MAX_SAMPLES", numbers - 1)
    with pytest.raises(
        ValueError, match=r"^7 pieces a motion makes .*; use fewer motions at a time"
    ):
        batch.pieces()


@pytest.mark.parametrize("t", [None, "1", ["a"], [1j], [[1.0], [1.0, 2.0]]], ids=str)
def test_times_that_are_no_numbers_are_refused(t):
    batch = min_time_moves([1.0, 2.0], LIMITS)
    for call in (batch, batch.evaluate):
        with pytest.raises(TypeError, match=r"^t = .*: expected a number or an array"):
            call(t)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda batch: batch.sample(0.0), "dt = 0.0: expected a positive, finite number"),
        (lambda batch: batch.sample(1e-9), "values: expected at most 1e+09; use a larger dt"),
        (lambda batch: batch.sample(0.1, "snap"), "highest = 'snap': expected at most 3"),
        (lambda batch: batch.evaluate(0.0, 4), "highest = 4: expected at most 3"),
        (lambda batch: batch([0.0, np.nan]), "times must be finite"),
        (lambda batch: batch(0.0, "speed"), "unknown derivative 'speed'"),
        (lambda batch: batch.peak(-1), "derivative -1: expected 0"),
    ],
    ids=["dt", "too many", "snap", "4", "nan", "speed", "-1"],
)
def test_what_is_refused(call, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        call(min_time_moves([1.0, 2.0], LIMITS))
