"""min_time_transfers: one by one, as trajectories, and what arrays may look like."""

import os
from math import inf, nan

import numpy as np
import pytest
from batches import arrays, edge_transfers, one_by_one, solved
from hypothesis import given
from move_batches import many_limits
from references import (
    assert_sound_transfer,
    published_transfers,
    thompson_order_2,
    thompson_order_3,
)
from strategies import TransferProblem, transfer_problems
from tiers import some

from jounce.shaping import (
    InfeasibleError,
    Limits,
    Transfer,
    min_time_transfer,
    min_time_transfers,
)

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
COUNT = 100_000 if SLOW else 3_000
ORDERS = pytest.mark.parametrize("order", [2, 3])
FIELDS = ("duration", "inside_after")
LIMITS = {2: Limits(2.0, 1.0), 3: Limits((-1.0, 2.0), 2.0, (-8.0, 4.0))}


def assert_same(one, other, text=""):
    """Assert that two batches have the same transfers to the last bit."""
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), f"{text}: {name}")
    for name in ("durations", "states"):
        found, expected = getattr(one.pieces(), name), getattr(other.pieces(), name)
        most = min(found.shape[1], expected.shape[1])
        np.testing.assert_array_equal(found[:, :most], expected[:, :most], f"{text}: {name}")


# Against others


@pytest.mark.slow
@ORDERS
@pytest.mark.parametrize("seed", some(range(2), 1))
def test_one_by_one_they_take_as_long(order, seed):
    """Ends that cannot be reached are NaN just where the scalar refuses them."""
    problems = edge_transfers((seed, order), order, COUNT)
    batch, expected = solved(problems), one_by_one(problems)
    for name, values in zip(FIELDS[:2], expected, strict=True):
        found = getattr(batch, name)
        error = np.abs(found - values) > 1e-12 * expected[0]
        wrong = np.flatnonzero(error | (np.isnan(found) != np.isnan(values)))
        assert not wrong.size, f"{problems[wrong[0]]}: {name} {found[wrong[0]]!r}"
    infeasible = np.isnan(expected[0])
    assert 0 < np.count_nonzero(infeasible) < 0.5 * COUNT
    assert np.count_nonzero(expected[1] > 0.0) > 0.01 * COUNT
    np.testing.assert_array_equal(batch.feasible, ~infeasible)


@ORDERS
@pytest.mark.parametrize("factor", [1e-250, 1.0, 1e30, 1e250])
def test_durations_are_those_of_whole_plans_to_the_bit(order, factor):
    """Where pieces are worked out only when asked for, and where they are at once."""
    rng = np.random.default_rng(order)
    states = rng.normal(0.0, [1.0, 0.5, 0.7][:order], (2, 200, order)) * factor
    limits = Limits.from_bounds([factor, (-factor, 1.5 * factor), 3.0 * factor][:order])
    batch = min_time_transfers(*states, limits)
    for i in np.flatnonzero(batch.feasible).tolist():
        alone = min_time_transfer(*states[:, i].tolist(), limits)
        assert batch.duration[i] == alone.duration
        assert batch.inside_after[i] == alone.inside_after
        assert np.count_nonzero(batch[i : i + 1].pieces().durations) == len(alone.durations)
    assert 20 < np.count_nonzero(batch.feasible) <= 200


@given(problem=transfer_problems())
def test_a_problem_alone(problem):
    bounds = [pair or (-inf, inf) for pair in problem.bounds]
    batch = min_time_transfers(problem.start, problem.end, many_limits([bounds]))
    expected = problem.solve()
    assert batch.duration[0] == pytest.approx(expected.duration, rel=1e-12), problem
    assert_sound_transfer(problem, batch[0])


@pytest.mark.parametrize("case", [1, 3, 5, 7, 9, 11, 13, 17, 41])
def test_published_problems(case):
    """Those whose duration is the longest of the axes' own."""
    duration, axes = published_transfers()[case]
    batch = solved([TransferProblem(*axis) for axis in axes])
    assert batch.duration.max() == pytest.approx(duration, rel=1e-8), axes


@ORDERS
def test_from_rest_to_rest_they_are_thompsons(order):
    rng = np.random.default_rng(order)
    distances, *bounds = 10.0 ** rng.uniform(-2.0, 2.0, (order + 1, 500))
    thompson = thompson_order_2 if order == 2 else thompson_order_3
    given = list(zip(distances.tolist(), *(bound.tolist() for bound in bounds), strict=True))
    cases = [thompson(*numbers) for numbers in given]
    batch = min_time_transfers([0.0], distances[:, None], Limits(*bounds))
    expected = [case.duration for case in cases]
    np.testing.assert_allclose(batch.duration, expected, rtol=1e-12, err_msg=repr(given))
    assert len({case.case for case in cases}) == (2 if order == 2 else 4)
    assert not batch.inside_after.any()


# As trajectories


@ORDERS
def test_each_is_a_sound_trajectory(order):
    problems = edge_transfers((10, order), order, 400)
    batch = solved(problems)
    assert len(batch) == len(problems)
    for i in np.flatnonzero(batch.feasible).tolist():
        transfer = batch[i]
        assert isinstance(transfer, Transfer)
        assert_sound_transfer(problems[i], transfer, transfer.inside_after)
        assert transfer.inside_after == batch.inside_after[i]
        assert transfer.duration == pytest.approx(batch.duration[i], rel=1e-14), problems[i]
        assert transfer.limits == problems[i].limits
        if transfer.inside_after == 0.0:
            assert transfer.violation(transfer.limits) <= 1e-10, problems[i]


@ORDERS
def test_one_that_cannot_be_reached_raises_as_it_does_alone(order):
    problems = edge_transfers((11, order), order, 1500)
    batch = solved(problems)
    refused = np.flatnonzero(~batch.feasible).tolist()
    assert len(refused) >= 5
    for i in refused[:20]:
        with pytest.raises(InfeasibleError) as alone:
            problems[i].solve()
        with pytest.raises(InfeasibleError) as caught:
            batch[i]
        assert str(caught.value) == str(alone.value), problems[i]
        assert caught.value.nearest == alone.value.nearest


def test_transfers_are_counted_from_either_end():
    batch = min_time_transfers([0.0], [[1.0], [2.0], [3.0]], LIMITS[2])
    assert batch[-1].end_state[0] == 3.0
    assert batch[-3].end_state[0] == 1.0
    with pytest.raises(IndexError):
        batch[3]


def test_a_transfer_to_where_it_stands_is_a_point():
    batch = min_time_transfers([[1.0, 0.5, 0.0]], [[1.0, 0.5, 0.0]], LIMITS[3])
    assert batch.duration.tolist() == [0.0]
    assert batch[0].end_state.tolist() == [1.0, 0.5, 0.0, 0.0]


# How many, and in which order


@ORDERS
@pytest.mark.parametrize("count", some([0, 1, 2, 4095, 4096, 4097, 8193], 4))
def test_the_number_of_problems_does_not_matter(order, count):
    problems = edge_transfers((12, order), order, 97)
    few, which = solved(problems), np.arange(count) % 97
    starts, ends, limits = arrays(problems)
    limits = limits.each(lambda bounds: bounds[which])
    batch = min_time_transfers(starts[which], ends[which], limits)
    assert len(batch) == len(batch.feasible) == count
    assert_same(batch, few[which], f"{count} problems")


@ORDERS
def test_neighbours_do_not_matter(order):
    problems = edge_transfers((13, order), order, 300)
    batch = solved(problems)
    order_of = np.random.default_rng(1).permutation(300)
    assert_same(solved([problems[i] for i in order_of]), batch[order_of])
    for i in range(0, 300, 10):
        assert_same(solved(problems[i : i + 1]), batch[i : i + 1], problems[i])


@pytest.mark.parametrize("state", [np.empty((0, 2)), np.empty((0, 1)), np.zeros((0, 0))])
def test_no_problems(state):
    batch = min_time_transfers(state, [1.0], LIMITS[2])
    assert (len(batch), batch.duration.shape, len(batch.pieces().states)) == (0, (0,), 0)
    assert len(min_time_transfers(0.0, 1.0, Limits(acceleration=np.empty(0)))) == 0


# Units


@ORDERS
def test_the_opposite_transfers_are_mirror_images(order):
    problems = edge_transfers((14, order), order, 400)
    batch, other = solved(problems), solved([p.mirrored() for p in problems])
    np.testing.assert_array_equal(other.duration, batch.duration)
    np.testing.assert_array_equal(other.inside_after, batch.inside_after)


@ORDERS
@pytest.mark.parametrize(("distance", "time"), [(-30, 0), (53, 0), (0, 40), (7, -31), (-20, 11)])
def test_units_of_powers_of_two_do_not_matter_to_the_last_bit(order, distance, time):
    problems = edge_transfers((15, order), order, 400)
    batch = solved(problems)
    other = solved([p.in_units(2.0**distance, 2.0**time) for p in problems])
    np.testing.assert_array_equal(other.duration, batch.duration * 2.0**time)
    lengths, states = batch.pieces()[1:]
    np.testing.assert_array_equal(other.pieces().durations, lengths * 2.0**time)
    units = 2.0 ** (distance - time * np.arange(order + 1.0))
    some = lengths > 0.0
    np.testing.assert_array_equal(other.pieces().states[some], (states * units)[some])


@ORDERS
@pytest.mark.parametrize(("distance", "time"), [(1e-9, 1.0), (1e16, 1.0), (1.0, 1e6), (1e3, 1e-9)])
def test_units_do_not_matter(order, distance, time):
    problems = edge_transfers((16, order), order, 400)
    problems = [p for p, good in zip(problems, solved(problems).feasible, strict=True) if good]
    scaled = [p.in_units(distance, time) for p in problems]
    expected = one_by_one(problems)[0] * time
    close = np.isclose(solved(scaled).duration, expected, rtol=1e-9, atol=0.0)
    wrong = [problem for problem, same in zip(scaled, close, strict=True) if not same]
    assert not wrong, wrong[0]


# What may be given


def durations(starts, ends, limits):
    return min_time_transfers(starts, ends, limits).duration.tolist()


def test_one_start_one_end_or_one_limits_stand_for_all():
    assert durations(0.0, 1.0, LIMITS[2]) == [2.0]
    assert durations([0.0], [[1.0], [4.0]], LIMITS[2]) == [2.0, 4.0]
    assert durations([[0.0, 0.0], [3.0, 0.0]], [4.0, 0.0], LIMITS[2]) == [4.0, 2.0]
    each = Limits(np.array([2.0, 9.0, 1.0]), np.array([1.0, 4.0, 1.0]))
    assert durations([0.0], [4.0], each) == [4.0, 2.0, 5.0]
    assert durations([[0.0]], [[4.0]], Limits(np.array([[-9.0, 2.0]] * 2), 1.0)) == [4.0, 4.0]
    some = Limits(np.array([2.0, inf]), np.array([1.0, 4.0]))
    assert durations([[0.0], [2.0]], [[4.0], [3.0]], some) == [4.0, 1.0]


def test_problems_broadcast_in_any_number_of_dimensions():
    starts, ends = np.array([[[0.0, 0.5]], [[1.0, 0.0]]]), np.array([3.0, 0.25])
    limits = Limits(np.array([2.0, 3.0, inf]), np.array([1.0, 2.0, 3.0]))
    grid = min_time_transfers(starts, ends, limits)
    assert (grid.shape, len(grid), grid.pieces().states.shape[:2]) == ((2, 3), 2, (2, 3))
    for i in range(2):
        for k, bounds in enumerate([(2.0, 1.0), (3.0, 2.0), (inf, 3.0)]):
            alone = min_time_transfer(starts[i, 0].tolist(), ends.tolist(), Limits(*bounds))
            assert grid[i, k].duration == alone.duration == grid.duration[i, k]
            assert grid[i, k].limits == Limits(*bounds)
            np.testing.assert_array_equal(grid([0.1, 9.0])[i, k], alone([0.1, 9.0]))
    np.testing.assert_array_equal(grid[:, 1].duration, grid.duration[:, 1])
    np.testing.assert_array_equal(grid[1](0.3), grid(0.3)[1])


def test_magnitudes_pairs_and_limits_are_the_same():
    numbers = np.array([[2.0, inf], [1.0, 3.0], [4.0, 8.0]])
    starts, ends = [[0.0, 0.5, 0.1]], [[3.0, -0.5]]
    one = min_time_transfers(starts, ends, Limits(*numbers))
    pairs = np.stack([-numbers, numbers], axis=-1)
    assert_same(one, min_time_transfers(starts, ends, Limits(*pairs)))
    for i, bounds in enumerate([(2.0, 1.0, 4.0), (None, 3.0, 8.0)]):
        limits = Limits.from_bounds(bounds)
        assert_same(one[i : i + 1], min_time_transfers(starts, ends, limits))
        assert one[i].limits == limits


def test_what_is_left_out_of_a_state_is_zero():
    batch = min_time_transfers([[0.0], [1.0]], [[2.0, 0.5]], LIMITS[3])
    full = min_time_transfers([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[2.0, 0.5, 0.0]], LIMITS[3])
    assert_same(batch, full)
    assert batch.end_state.tolist() == [[2.0, 0.5, 0.0, 0.0]] * 2
    assert batch.start_state[:, :3].tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]


def test_where_there_is_no_transfer_there_is_no_number():
    batch = min_time_transfers([0.0], [[1.0, -1.0, 1.0], [1.0, 0.0, 0.0]], Limits(1.0, 1.0, 1.0))
    assert batch.feasible.tolist() == [False, True]
    assert repr(batch) == "MotionBatch(shape=(2,), order=3, feasible=1 of 2)"
    breaks, lengths, states = batch.pieces()
    for values in (breaks, states, batch.evaluate([-1.0, 0.5, 99.0])[0], batch.end_state):
        assert np.isnan(values[0]).all()
        assert np.isfinite(values[1]).all()
    assert lengths[0].tolist() == [0.0] * lengths.shape[1]
    assert np.isnan(batch.peak("velocity")).tolist() == [True, False]
    assert batch.sample(0.1)[0][-1] == batch.duration[1]


def test_the_given_arrays_are_copied():
    starts, ends, bounds = np.zeros((1, 2)), np.ones((1, 2)) * [1.0, 0.0], np.ones(1)
    batch = min_time_transfers(starts, ends, Limits(bounds, bounds))
    before = batch(0.7)
    for array in (starts, ends, bounds):
        array += 1.0
    np.testing.assert_array_equal(batch(0.7), before)
    assert batch[0].limits == Limits(1.0, 1.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"starts": [nan]}, "^starts must be finite"),
        ({"ends": [[1.0], [inf]]}, "^ends must be finite"),
        ({"starts": np.zeros((2, 4))}, r"^starts of shape \(2, 4\): expected \(N, 2\) or \(2,\)"),
        (
            {"starts": np.zeros((2, 2)), "ends": np.zeros((3, 2))},
            r"^starts, ends and limits of \(2,\), \(3,\) and \(\) problems do not fit",
        ),
        (
            {"starts": np.zeros((2, 2)), "limits": Limits(np.ones(3), 1.0)},
            "do not fit: expected the same",
        ),
        ({"limits": Limits(1.0)}, "^limits of order 1: expected order 2"),
        ({"limits": Limits(np.ones(2))}, "^limits of order 1: expected order 2"),
        ({"limits": Limits.from_bounds([1.0] * 11)}, "^limits of order 11: expected order 2"),
        ({"limits": Limits(snap=(-1.0, inf))}, "^snap is bounded in one direction only"),
        ({"limits": Limits(1.0, (-1.0, inf))}, "^acceleration is bounded in one direction only"),
        (
            {"limits": Limits(1.0, np.array([[-1.0, 1.0], [-1.0, inf]]))},
            r"^acceleration of problem 1 is bounded in one direction only, \(-1, inf\): expected",
        ),
    ],
)
def test_arrays_that_do_not_fit_are_refused(changes, message):
    given = {"starts": [0.0], "ends": [1.0], "limits": LIMITS[2], **changes}
    with pytest.raises(ValueError, match=message):
        min_time_transfers(*given.values())


@pytest.mark.parametrize("limits", [{"jerk": 1.0}, np.ones((1, 2)), [[1.0, 1.0]], None, "fast"])
def test_limits_of_another_kind_are_refused_as_everywhere(limits):
    message = r"^limits = .*: expected Limits, such as Limits\(acceleration=1.0\)(; give.*)?$"
    for call in (min_time_transfers, min_time_transfer):
        with pytest.raises(TypeError, match=message):
            call([0.0], [1.0], limits)


@pytest.mark.parametrize(
    ("starts", "ends", "limits"),
    [
        ([0.0], [[1.0], [1e308]], Limits(1.0, 1e-300, 1e-300)),
        ([0.0], [[1.0], [1e308]], Limits(1e-9, 1.0)),
        ([[0.0], [-1.7e308]], [[1.0], [1.7e308]], Limits(1.0, 1.0, 1.0)),
    ],
)
def test_a_transfer_that_leaves_the_range_is_named(starts, ends, limits):
    with pytest.raises(
        ValueError, match=r"^the duration or a state of transfer 1 leaves the range"
    ):
        min_time_transfers(starts, ends, limits)


def test_the_derivative_behind_those_of_a_state_may_follow_as_alone():
    limits = Limits(1.0, 1.0)
    found = min_time_transfers([[0.0, 0.5, 0.0]], [[2.0, 0.0, 0.0]], limits)
    assert found.duration[0] == min_time_transfer((0.0, 0.5, 0.0), (2.0,), limits).duration


def test_some_of_many_may_have_no_bound_on_the_jerk():
    """They are planned as they are alone, where an infinite jerk is none."""
    rng = np.random.default_rng(5)
    jerk = np.where(rng.uniform(size=40) < 0.5, inf, rng.uniform(2.0, 60.0, 40))
    states = rng.normal(0.0, [1.0, 0.5, 0.5], (2, 40, 3))
    batch = min_time_transfers(*states, Limits((-2.0, 1.5), 4.0, jerk))
    times = np.linspace(0.0, 5.0, 7)
    for i, bound in enumerate(jerk.tolist()):
        limits = Limits((-2.0, 1.5), 4.0, bound)
        alone = min_time_transfer(*states[:, i].tolist(), limits)
        assert batch[i].order == alone.order == (2 if bound == inf else 3)
        assert batch.duration[i] == alone.duration
        np.testing.assert_array_equal(batch(times)[i], alone(times))
    for bounds, words in (
        ({"acceleration": np.array([4.0, inf])}, r"jerk of problem 1 is not bounded"),
        ({"acceleration": 4.0, "velocity": (-1.0, 0.0)}, "jerk of problem"),
    ):
        with pytest.raises(ValueError, match=words):
            min_time_transfers([0.0], [1.0], Limits(**bounds, jerk=np.array([9.0, inf])))
