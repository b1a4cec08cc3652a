"""min_time_moves: as the moves one by one, against ruckig and Thompson, and what it takes."""

import os
import tracemalloc
from math import inf, nan

import numpy as np
import pytest
import ruckig
from hypothesis import given
from move_batches import MoveProblem, many_limits, move_lists, random_moves, together
from references import UNITS, reference_problems, thompson_order_2, thompson_order_3
from tiers import some

from jounce.shaping import Limits, min_time_move, min_time_moves, proven_excess

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
ORDERS = pytest.mark.parametrize("order", range(1, 7))
SAME = 1e-12  # relative difference of durations that the README promises
LIMITS = Limits(2.0, 3.0, 8.0)
FAST = np.array([1.0, 2.0, 4.0])


def durations(problems):
    """Return the durations of the moves one by one."""
    return np.array([p.move().duration for p in problems])


def assert_same(problems):
    """Assert that all last as long as they do alone."""
    found, expected = together(problems).duration, durations(problems)
    wrong = np.flatnonzero(~(np.abs(found - expected) <= SAME * expected))
    assert not wrong.size, f"{problems[wrong[0]]}: {found[wrong[0]]} not {expected[wrong[0]]}"


# Against others


@given(problems=move_lists())
def test_they_last_as_long_as_alone(problems):
    assert_same(problems)


@ORDERS
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
@pytest.mark.parametrize("decades", some([12.0, 3.0], 1))
def test_random_ones_last_as_long_as_alone(order, even, decades):
    alone_is_slow = order > 3 and not even
    count = 20_000 if SLOW and not alone_is_slow else 20 if alone_is_slow else 100
    assert_same(random_moves((1, order, even), order, count, decades=decades, even=even))


def test_order_3_lasts_as_long_as_ruckig_says():
    problems = random_moves(2, 3, 20_000 if SLOW else 1_000)
    problem, trajectory, planner = ruckig.InputParameter(1), ruckig.Trajectory(1), ruckig.Ruckig(1)
    batch = together(problems)
    for one, duration in zip(problems, batch.duration, strict=True):
        (_, velocity), (_, acceleration), (_, jerk) = one.bounds
        problem.current_position, problem.target_position = [0.0], [one.distance]
        problem.max_velocity, problem.max_acceleration = [velocity], [acceleration]
        problem.max_jerk = [jerk]
        planner.calculate(problem, trajectory)
        assert duration == pytest.approx(trajectory.duration, rel=SAME), one


@pytest.mark.parametrize("order", [2, 3])
def test_they_are_thompsons(order):
    rng = np.random.default_rng(order)
    distances, *bounds = 10.0 ** rng.uniform(-2.0, 2.0, (order + 1, 400))
    thompson = thompson_order_2 if order == 2 else thompson_order_3
    cases = [thompson(*numbers) for numbers in zip(distances, *bounds, strict=True)]
    found = min_time_moves(distances, Limits(*bounds)).duration
    np.testing.assert_allclose(found, [case.duration for case in cases], rtol=SAME)
    assert len({case.case for case in cases}) == (2 if order == 2 else 4)


@pytest.mark.parametrize("order", range(4, 7))
def test_durations_lie_between_proof_and_recursion(order):
    problems = [p for p in reference_problems() if p.order == order]
    found = min_time_moves(
        [p.distance for p in problems], many_limits([p.bounds for p in problems])
    ).duration
    for problem, duration in zip(problems, found, strict=True):
        assert problem.lower * (1.0 - 1e-9) <= duration <= problem.recursion * (1.0 + 1e-12)


@pytest.mark.parametrize("order", [8, 10, 14])
def test_high_orders(order):
    assert_same(random_moves(order, order, 4))


def test_uneven_bounds_are_used_in_both_directions():
    """The lift and the like: the smaller bounds alone would cost a tenth of the time and more."""
    sides = [(-10.0, 1.0), 100.0, (-1e4, 2e4)]
    limits = Limits.from_bounds([None, *sides])
    smaller = Limits(acceleration=1.0, jerk=100.0, snap=1e4)
    distances = np.array([[1.0, -1.0, 5.0, 0.0], [0.3, -9.0, 1e-3, -1e-6]])
    batch = min_time_moves(distances, limits, start=3.0)
    both = min_time_moves(distances, smaller).duration
    assert (batch.duration <= both).all()
    assert batch.duration[0, 0] < 0.8 * both[0, 0]
    np.testing.assert_array_equal(batch[:, ::-1].duration, batch.duration[:, ::-1])
    states = batch.pieces().states
    for k, (low, high) in ((k, limits.bounds(k)) for k in range(2, 5)):
        assert low * (1.0 + 1e-12) <= states[..., k].min() < states[..., k].max()
        assert states[..., k].max() <= high * (1.0 + 1e-12)
    alone = batch[1, 1]
    assert alone.violation(limits) <= 1e-12
    np.testing.assert_allclose(alone(0.7), batch(0.7)[1, 1], rtol=1e-12)
    assert proven_excess(alone, limits) < 0.02


# Identities


@given(problems=move_lists(decades=3.0))
def test_the_opposite_moves_last_as_long(problems):
    mirrored = [
        MoveProblem(-p.distance, p.start, tuple((-high, -low) for low, high in p.bounds))
        for p in problems
    ]
    np.testing.assert_array_equal(together(mirrored).duration, together(problems).duration)


@given(problems=move_lists(decades=3.0))
def test_run_backwards_they_last_as_long(problems):
    """Backwards in time even derivatives keep their sign, and the distance does not."""
    backwards = [
        MoveProblem(
            -p.distance,
            p.start,
            tuple((-high, -low) if k % 2 else (low, high)
                  for k, (low, high) in enumerate(p.bounds, start=1)),
        )
        for p in problems
    ]  # fmt: skip
    np.testing.assert_allclose(
        together(backwards).duration, together(problems).duration, rtol=SAME, err_msg=repr(problems)
    )


@ORDERS
@pytest.mark.parametrize(("distance", "time"), [(1e-9, 1.0), (1e9, 1.0), (1.0, 1e9), (1e6, 1e-6)])
def test_units_do_not_matter(order, distance, time):
    problems = random_moves((3, order), order, 300, even=order != 3)
    factors = [distance / time**k for k in range(1, order + 1)]
    scaled = [
        MoveProblem(
            p.distance * distance,
            p.start * distance,
            tuple((low * f, high * f) for (low, high), f in zip(p.bounds, factors, strict=True)),
        )
        for p in problems
    ]
    expected = together(problems).duration * time
    np.testing.assert_allclose(together(scaled).duration, expected, rtol=UNITS)


@ORDERS
def test_a_longer_distance_takes_longer(order):
    [problem] = random_moves((4, order), order, 1)
    found = min_time_moves(np.geomspace(1e-6, 1e6, 1000), problem.limits).duration
    assert (np.diff(found) > 0.0).all(), problem


@ORDERS
@pytest.mark.parametrize("count", [1, 2, 8191, 8192, 8193])
def test_neighbours_do_not_matter(order, count):
    problems = random_moves((5, order), order, 61)
    bounds, which = np.array([p.bounds for p in problems]), np.arange(count) % 61
    distances = np.array([p.distance for p in problems])
    found = min_time_moves(distances[which], many_limits(bounds[which])).duration
    few = min_time_moves(distances, many_limits(bounds)).duration[which]
    np.testing.assert_allclose(found, few, rtol=4e-16)


# What may be given


def test_all_ways_to_give_limits_are_the_same():
    v, a, j = np.array([[2.0, 1.0, inf], [3.0, inf, 5.0], [8.0, 9.0, 10.0]])
    table = np.stack([v, a, j], axis=1)
    expected = [
        min_time_move(r, Limits.from_bounds(row), method="closed-form").duration
        for r, row in zip([1.0, -2.0, 0.5], table, strict=True)
    ]
    for limits in (
        Limits(velocity=v, acceleration=a, jerk=j),
        Limits.from_bounds(table.T),
        Limits(np.stack([-v, v], axis=-1), (-a, a), j),
        Limits((-v, v), a, j, snap=inf, pop=np.full(3, inf)),
    ):
        found = min_time_moves([1.0, -2.0, 0.5], limits)
        assert found.order == 3
        np.testing.assert_allclose(found.duration, expected, rtol=1e-15)


def test_arrays_broadcast():
    assert min_time_moves(1.0, LIMITS).duration.shape == (1,)
    assert min_time_moves([], LIMITS).duration.shape == (0,)
    assert min_time_moves([1.0, 2.0], LIMITS).duration.shape == (2,)
    assert min_time_moves(1.0, Limits(FAST)).duration.tolist() == [1.0, 0.5, 0.25]
    grid = min_time_moves([[1.0], [2.0]], Limits(FAST))
    assert grid.duration.tolist() == [[1.0, 0.5, 0.25], [2.0, 1.0, 0.5]]
    assert min_time_moves(1.0, LIMITS, start=[3.0, 4.0])(0.0).tolist() == [3.0, 4.0]


def test_a_sweep_of_more_than_one_chunk_broadcasts():
    v, j = np.geomspace(0.1, 10.0, 130)[:, None], np.geomspace(1.0, 1e3, 140)
    found = min_time_moves(3.0, Limits(velocity=v, jerk=j)).duration
    assert found.shape == (130, 140)
    flat = np.broadcast_arrays(v, j)
    bounds = Limits(velocity=flat[0].ravel(), jerk=flat[1].ravel())
    np.testing.assert_allclose(found.ravel(), min_time_moves(3.0, bounds).duration, rtol=1e-15)
    assert found[77, 3] == pytest.approx(min_time_move(3.0, Limits(v[77, 0], jerk=j[3])).duration)


@ORDERS
def test_zero_distances_are_points(order):
    [problem] = random_moves((6, order), order, 1)
    found = min_time_moves([0.0, 1.0, -0.0], problem.limits, start=2.0)
    assert found.duration[[0, 2]].tolist() == [0.0, 0.0]
    assert found.duration[1] > 0.0
    assert found.pieces().durations[[0, 2]].max() == 0.0
    np.testing.assert_array_equal(found([-1.0, 0.0, 1.0])[[0, 2]], 2.0)


def test_the_given_arrays_are_copied():
    distances, bounds, start = np.ones(2), np.ones(2), np.zeros(2)
    batch = min_time_moves(distances, Limits(velocity=bounds), start=start)
    for array in (distances, bounds, start):
        array += 1.0
    assert batch.end_state[:, 0].tolist() == [1.0, 1.0]
    assert batch.peak("velocity").tolist() == [1.0, 1.0]


def test_numbers_in_one_direction_are_enough_where_they_are_needed():
    assert min_time_moves([1.0, 2.0], Limits(velocity=(-inf, 4.0))).duration.tolist() == [0.25, 0.5]
    assert min_time_moves([0.0, 4.0], Limits(np.array([inf, 2.0]))).duration.tolist() == [0.0, 2.0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"distances": [1.0, nan]}, r"^distances must be finite: distances\[1\] = nan"),
        (
            {"distances": [[1.0, 2.0], [inf, 1.0]]},
            r"^distances must be .*: distances\[1, 0\] = inf",
        ),
        ({"start": [0.0, -inf]}, r"^start must be finite: start\[1\] = -inf"),
        ({"start": [0.0, 1.0, 2.0]}, r"^distances of shape \(2,\), start of shape \(3,\) and"),
        (
            {"limits": Limits(np.ones(3))},
            r"limits of shape \(3,\) do not fit: expected shapes that",
        ),
        ({"limits": Limits.from_bounds([1.0] * 15)}, "^limits of order 15: expected at most 14"),
        (
            {"limits": Limits(jerk=np.array([1.0, inf]))},
            r"^jerk of problem 1 is not bounded, \(-inf, inf\): expected both bounds",
        ),
        (
            {"limits": Limits(velocity=(-1.0, inf))},
            r"^velocity of problem 0 is bounded in one direction only, \(-1, inf\): expected",
        ),
        ({"distances": [1.0, 1e308], "limits": Limits(1e-9)}, r"state of move 1 leaves the range"),
        (
            {"distances": [[1.0, 1e308]], "limits": Limits(velocity=1e-9, pop=1.0)},
            r"of move 0, 1 leaves the",
        ),
    ],
)
def test_what_does_not_fit_is_refused(changes, message):
    given = {"distances": [1.0, -2.0], "limits": LIMITS, "start": 0.0, **changes}
    with pytest.raises(ValueError, match=message):
        min_time_moves(given["distances"], given["limits"], start=given["start"])


@pytest.mark.parametrize("name", ["distances", "start"])
@pytest.mark.parametrize(
    ("values", "shown"),
    [
        (None, "None"),
        ("1", "'1'"),
        (["1", "2"], r"\['1', '2'\]"),
        ([1.0, None], r"\[1.0, None\]"),
        ([[1.0], [1.0, 2.0]], r"\[\[1.0\], \[1.0, 2.0\]\]"),
        ([1.0, 2j], r"\[1.0, 2j\]"),
        (np.array([1j]), r"array\(\[0.\+1.j\]\)"),
        ([True], r"\[True\]"),
        ({"a": 1}, r"\{'a': 1\}"),
        (10**400, "1000.*000"),
    ],
    ids=["None", "text", "texts", "gap", "ragged", "complex", "array", "truth", "dict", "huge"],
)
def test_what_is_no_array_of_numbers_is_refused_by_name(name, values, shown):
    given = {"distances": [1.0, 2.0], "start": 0.0, name: values}
    with pytest.raises(TypeError, match=f"^{name} = {shown}: expected a number or an array"):
        min_time_moves(given["distances"], LIMITS, start=given["start"])


# Memory


@pytest.mark.parametrize(("order", "bytes_each"), [(3, 16), (4, 17)])
def test_a_batch_keeps_as_much_memory_as_documented(order, bytes_each):
    count = 200_000
    limits = Limits.from_bounds([2.0, 3.0, 8.0, 40.0][:order])
    distances = np.linspace(-1.0, 1.0, count)
    min_time_moves(distances[:9], limits)
    tracemalloc.start()
    try:
        batch = min_time_moves(distances, limits)
        kept, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(batch) == count
    assert kept <= bytes_each * count + 50_000
    assert most <= kept + 2_500_000


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
def test_a_lane_lasts_as_long_as_its_batch_says_to_the_bit(order, even):
    problems = random_moves((7, order, even), order, 500, decades=6.0, even=even)
    batch = together(problems)
    lanes = [batch[i] for i in range(len(problems))]
    assert [lane.duration for lane in lanes] == batch.duration.tolist()
    assert [float(lane.breaks[-1]) for lane in lanes] == batch.duration.tolist()


@pytest.mark.parametrize("low", [-1.0, -0.6])
def test_some_of_many_may_have_no_bound_on_the_jerk(low):
    """They are planned as they are alone, where an infinite jerk is none."""
    rng = np.random.default_rng(6)
    jerk = np.where(rng.uniform(size=30) < 0.5, inf, rng.uniform(2.0, 60.0, 30))
    distances = np.where(np.arange(30) == 7, 0.0, rng.normal(0.0, 2.0, 30))
    batch = min_time_moves(distances, Limits((2.0 * low, 2.0), (4.0 * low, 4.0), jerk))
    times = np.linspace(0.0, 5.0, 7)
    for i, (distance, bound) in enumerate(zip(distances.tolist(), jerk.tolist(), strict=True)):
        limits = Limits((2.0 * low, 2.0), (4.0 * low, 4.0), bound)
        alone = min_time_move(distance, limits, method="closed-form")
        assert batch[i].order == alone.order == (2 if bound == inf else 3)
        assert batch.duration[i] == pytest.approx(alone.duration, rel=1e-12)
        np.testing.assert_allclose(batch(times)[i], alone(times), rtol=0.0, atol=1e-12)
    with pytest.raises(ValueError, match=r"jerk of problem 1 is bounded in one direction only"):
        min_time_moves(1.0, Limits(2.0, 4.0, (np.array([-9.0, -9.0]), np.array([9.0, inf]))))
