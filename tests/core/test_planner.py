"""What the planner returns to Python: motions against their problems, arrays, threads, refusals."""

from concurrent.futures import ThreadPoolExecutor
from math import inf, isnan

import numpy as np
import pytest

from jounce.core import (
    NO_DURATION,
    OK,
    RANGE,
    UNREACHABLE,
    Motion,
    Pieces,
    evaluate_lanes,
    move,
    possible_durations,
    together,
    transfer,
    transfer_lasting,
    transfer_pieces,
    transfers,
    velocity_transfer,
)

BOUNDS = (-1.0, 1.5, -2.0, 1.0, -4.0, 3.0)


def problems(order, count, seed=5):
    """Return starts, ends inside their bounds, and bounds (count, 2 order) of random problems."""
    rng = np.random.default_rng([seed, order])
    bounds = rng.uniform(0.2, 3.0, size=(count, 2 * order)) * np.tile([-1.0, 1.0], order)
    starts, ends = rng.normal(size=(2, count, order))
    ends[:, 1] *= 0.1
    if order == 3:
        ends[:, 2] *= 0.01
    return starts, ends, bounds


def out(count):
    return np.empty(count), np.empty(count), np.empty(count, np.int8), np.empty(count, np.int8)


def run_on(state, duration):
    """Return a Taylor state later, by sums of powers."""
    later = [
        sum(
            x * duration ** (j - k) / np.prod(range(1, j - k + 1))
            for j, x in enumerate(state)
            if j >= k
        )
        for k in range(len(state))
    ]
    return np.array(later)


@pytest.mark.parametrize("order", [2, 3])
def test_a_motion_leads_from_start_to_end_within_its_bounds(order):
    for start, end, bounds in zip(*problems(order, 200), strict=True):
        motion = transfer(start.tolist(), end.tolist(), bounds.tolist())
        assert isinstance(motion, Motion)
        assert motion.order == order
        breaks, states, durations, end_state = motion.arrays()
        assert states.shape == (motion.count, order + 1)
        assert durations.shape == (motion.count,)
        np.testing.assert_allclose(breaks, np.append(0.0, np.cumsum(durations)), rtol=1e-15)
        assert breaks[-1] == pytest.approx(motion.duration, rel=1e-15)
        assert tuple(end_state) == motion.end_state
        np.testing.assert_array_equal(end_state, [*end, 0.0])
        np.testing.assert_array_equal(states[0, :order], start)
        joints = np.array([run_on(row, t) for row, t in zip(states, durations, strict=True)])
        following = np.vstack([states[1:], end_state])
        np.testing.assert_allclose(joints[:, :order], following[:, :order], rtol=0, atol=1e-12)
        inside = breaks[:-1] >= motion.inside_after
        for k in range(1, order):
            low, high = bounds[2 * k - 2 : 2 * k]
            assert (states[inside, k] >= low - 1e-12).all()
            assert (states[inside, k] <= high + 1e-12).all()
        assert (states[:, order] >= bounds[-2] * (1 + 1e-12)).all()
        assert (states[:, order] <= bounds[-1] * (1 + 1e-12)).all()


@pytest.mark.parametrize("order", [2, 3])
def test_pieces_of_a_motion_are_those_of_its_arrays(order):
    times = np.linspace(-1.0, 12.0, 200)
    for start, end, bounds in zip(*problems(order, 20), strict=True):
        motion = transfer(start.tolist(), end.tolist(), bounds.tolist())
        for k in range(order + 1):
            expected = Pieces(*motion.arrays(), 1).at(times, k)
            np.testing.assert_array_equal(motion.pieces().at(times, k), expected)


def test_arrays_of_a_motion_are_read_only():
    for array in transfer((0.0,), (1.0,), BOUNDS).arrays():
        assert not array.flags.writeable


def test_a_velocity_transfer_ends_at_a_velocity_wherever_that_is():
    motion = velocity_transfer((2.0, 0.5, 0.0), (0.0, 1.0, 0.0), BOUNDS)
    assert motion.end_state[1:] == (1.0, 0.0, 0.0)
    assert motion.end_state[0] == pytest.approx(2.0 + 0.75 * motion.duration, abs=1.0)
    assert motion.pieces().at(motion.duration, 0) == pytest.approx(motion.end_state[0], rel=1e-15)


@pytest.mark.parametrize("order", [2, 3])
def test_transfers_last_as_long_as_is_possible_and_wished(order):
    for start, end, bounds in zip(*(x.tolist() for x in problems(order, 100)), strict=True):
        fastest = transfer(start, end, bounds).duration
        possible = possible_durations(start, end, bounds)
        assert possible[0][0] == pytest.approx(fastest, rel=1e-12)
        for low, high in possible:
            wished = 0.5 * (low + min(high, low + 10.0))
            slow = transfer_lasting(start, end, bounds, wished)
            assert slow.duration == pytest.approx(wished, rel=1e-12)
            assert slow.end_state == (*end, 0.0)
        assert transfer_lasting(start, end, bounds, 0.5 * fastest) == NO_DURATION


def test_where_there_is_no_motion_the_status_says_why():
    assert (OK, UNREACHABLE, NO_DURATION, RANGE) == (0, 1, 2, 3)
    far = (0.0, 0.0, 0.0), (1.0, -1.0, 1.0), BOUNDS  # its velocity would come from below its bound
    assert transfer(*far) == UNREACHABLE
    assert possible_durations(*far) == ()


@pytest.mark.parametrize("order", [2, 3])
def test_arrays_and_single_problems_get_the_same_bits(order):
    starts, ends, bounds = problems(order, 300)
    ends[::7, 1] = 0.999 * bounds[::7, 1]
    if order == 3:
        ends[::7, 2] = 0.9 * bounds[::7, 3]
    durations, inside, statuses, counts = out(300)
    transfers(order, starts, ends, bounds, durations, inside, statuses, counts)
    most = int(counts.max())
    lengths, states = np.empty((300, most)), np.empty((300, most, order + 1))
    end_states = np.empty((300, order + 1))
    transfer_pieces(order, starts, ends, bounds, most, lengths, states, end_states)
    assert order == 2 or {OK, UNREACHABLE} == set(statuses.tolist())
    for i in range(300):
        single = transfer(starts[i].tolist(), ends[i].tolist(), bounds[i].tolist())
        if isinstance(single, int):
            assert single == statuses[i]
            assert isnan(durations[i])
            assert isnan(inside[i])
            assert counts[i] == 0
            continue
        assert (durations[i], inside[i]) == (single.duration, single.inside_after)
        assert (statuses[i], counts[i]) == (OK, single.count)
        _, rows, pieces, end = single.arrays()
        np.testing.assert_array_equal(lengths[i], np.pad(pieces, (0, most - single.count)))
        np.testing.assert_array_equal(states[i, : single.count], rows)
        np.testing.assert_array_equal(end_states[i], end)


@pytest.mark.parametrize("order", [2, 3])
def test_values_of_many_motions_are_those_of_each(order):
    starts, ends, bounds = problems(order, 100)
    lengths, states = np.empty((100, 24)), np.empty((100, 24, order + 1))
    end_states = np.empty((100, order + 1))
    transfer_pieces(order, starts, ends, bounds, 24, lengths, states, end_states)
    single = [transfer(*(part[i].tolist() for part in (starts, ends, bounds))) for i in range(100)]
    durations = np.array([motion.duration for motion in single])
    times = np.linspace(-1.0, 12.0, 150)
    own = times + np.arange(100.0)[:, None]
    common, each = np.empty((2, 2, 100, 150))
    evaluate_lanes(durations, lengths, states, end_states, times, 150, 1, 2, common)
    evaluate_lanes(durations, lengths, states, end_states, own, 150, 1, 2, each)
    for i in range(100):
        pieces = single[i].pieces()
        for k in (1, 2):
            np.testing.assert_array_equal(common[k - 1, i], pieces.at(times, k))
            np.testing.assert_array_equal(each[k - 1, i], pieces.at(own[i], k))
    with pytest.raises(ValueError, match="times must be finite"):
        evaluate_lanes(durations, lengths, states, end_states, times * inf, 150, 1, 2, common)
    with pytest.raises(ValueError, match="argument 4 has 150 values: expected 14900"):
        evaluate_lanes(durations, lengths, states, end_states, times, 149, 1, 2, common)


def test_one_start_end_and_bounds_stand_for_all():
    starts, ends, _ = problems(3, 50)
    bounds = np.array(BOUNDS)
    whole, one = out(50), out(50)
    transfers(3, starts, ends, np.tile(bounds, (50, 1)), *whole)
    transfers(3, starts, ends, bounds, *one)
    np.testing.assert_array_equal(whole[0], one[0])
    transfers(3, starts[0], ends, bounds, *one)
    transfers(3, np.tile(starts[0], (50, 1)), ends, bounds, *whole)
    np.testing.assert_array_equal(whole[0], one[0])


def test_several_threads_at_once_get_the_bits_of_one():
    starts, ends, bounds = problems(3, 4_000)

    def plan(lane):
        found = out(4_000)
        transfers(3, starts, ends, bounds, *found)
        single = [transfer(starts[i].tolist(), ends[i].tolist(), bounds[i].tolist()).duration
                  for i in range(lane, 400, 4)]  # fmt: skip
        return [x.tobytes() for x in found], single, found[0][lane:400:4].tolist()

    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(plan, range(4)))
    assert all(result[0] == results[0][0] for result in results)
    assert all(single == lanes for _, single, lanes in results)


@pytest.mark.parametrize(
    "call",
    [
        lambda: transfer("012", (1.0,), BOUNDS),
        lambda: transfer(np.zeros(3), (1.0,), BOUNDS),
        lambda: transfer((0.0, "1"), (1.0,), BOUNDS),
        lambda: transfer((0.0, 0.0, 0.0, 0.0), (1.0,), BOUNDS),
        lambda: transfer((0.0,), (1.0,)),
        lambda: transfer((10**400,), (1.0,), BOUNDS),
        lambda: transfer_lasting((0.0,), (1.0,), BOUNDS, "3"),
        lambda: Motion(),
    ],
    ids=range(8),
)
def test_what_is_no_plain_number_is_a_type_error(call):
    with pytest.raises(TypeError):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: transfer((inf,), (1.0,), BOUNDS),
        lambda: transfer((0.0,), (float("nan"),), BOUNDS),
        lambda: transfer((0.0,), (1.0,), (-1.0, 1.0)),
        lambda: transfer((0.0,), (1.0,), (-1.0, 1.0, 0.0, 0.0)),
        lambda: transfer((0.0,), (1.0,), (-1.0, 1.0, -1.0, inf)),
        lambda: transfer((0.0,), (1.0,), (-1.0, 1.0, -1.0, 1.0, -1.0)),
        lambda: transfer_lasting((0.0,), (1.0,), BOUNDS, inf),
        lambda: transfers(4, *[np.zeros(3)] * 3, *out(1)),
        lambda: transfers(3, *[np.zeros(3)] * 3, *out(1)),
    ],
    ids=range(9),
)
def test_numbers_out_of_place_are_a_value_error(call):
    with pytest.raises(ValueError, match=r"finite|expected"):
        call()


def test_arrays_written_to_must_be_writable():
    found = out(2)
    found[0].flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        transfers(3, np.zeros((2, 3)), np.ones((2, 3)), np.array(BOUNDS), *found)


class Held:
    """Stands for a class of trajectories, whose constructor is not called."""

    def __init__(self):
        raise AssertionError


class Bounds:
    """Stands for limits."""

    flat = BOUNDS


def test_a_class_that_is_given_holds_motion_and_limits():
    held = transfer((0.0, 0.5), 1.0, BOUNDS, Held, Bounds)
    assert type(held) is Held
    motion = transfer((0.0, 0.5), 1.0, BOUNDS)
    assert held._motion.duration == motion.duration
    assert vars(held) == {"_motion": held._motion, "limits": Bounds}
    outside = transfer((0.0, 2.0), 1.0, BOUNDS, Held, Bounds)
    assert outside.inside_after == transfer((0.0, 2.0), 1.0, BOUNDS).inside_after > 0.0
    assert vars(move(1.0, BOUNDS[:2], 0.0, Held, None)).keys() == {"_motion", "coasting"}


@pytest.mark.parametrize("type_", ["text", None, 1.0, Motion])
def test_what_can_hold_no_motion_is_refused(type_):
    with pytest.raises((TypeError, AttributeError)):
        transfer((0.0, 0.5), 1.0, BOUNDS, type_, Bounds)


def test_axes_are_slowed_down_together_and_the_slowest_stays():
    bounds = Bounds()
    slow, fast = (transfer(0.0, distance, BOUNDS, Held, bounds) for distance in (3.0, 1.0))
    (first, second), limits = together((slow, fast), Held)
    assert first is slow
    assert limits == (bounds, second.limits) == (bounds, bounds)
    assert second._motion.duration == pytest.approx(slow._motion.duration, rel=1e-14)


@pytest.mark.parametrize("others", [(1.0,), (object(),), (object.__new__(Held),), [], (None,) * 65])
def test_what_is_no_axis_is_refused(others):
    with pytest.raises((TypeError, AttributeError, ValueError)):
        together(others, Held)


def test_the_single_profile_sought_from_the_longest_on_is_the_shortest_of_all():
    """All profiles of both families are found for `possible_durations`, one for `transfer`."""
    rng = np.random.default_rng(20261129)
    found = 0
    for _ in range(1000):
        decades = rng.choice([0.3, 2.0, 8.0])
        sides = 10.0 ** rng.uniform(-decades, decades, (3, 2)) * [-1.0, 1.0]
        v, a = (rng.uniform(*sides[k], 2) for k in (0, 1))
        a *= rng.integers(0, 2, 2)
        start, end = (0.0, v[0], a[0]), (rng.normal(0.0, 2.0), v[1], a[1])
        motion = transfer(start, end, tuple(sides.ravel()))
        possible = possible_durations(start, end, tuple(sides.ravel()))
        if not isinstance(motion, int):
            found += 1
            assert motion.duration == pytest.approx(possible[0][0], rel=1e-13)
    assert found > 700


def test_a_bound_of_velocity_that_is_not_reached_changes_nothing_however_far_it_is():
    start, end = (
        (0.0, -1.303193504470855, 0.5868515295339114),
        (1.7059367555049676, 0.2036564901690785),
    )
    near, far = (
        transfer(start, end, (-26.5, v, -0.0023876, 0.800231, -0.681284, 0.04092))
        for v in (30.0, 1.8e8)
    )
    assert far.duration == pytest.approx(near.duration, rel=1e-13)
    assert near.duration == pytest.approx(16.37, rel=1e-3)
