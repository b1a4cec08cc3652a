"""Motions through points: exact where the optimum is known, near a slow one of another kind."""

import itertools
import re

import numpy as np
import pytest
from scipy.optimize import linprog
from tiers import some

from jounce.shaping import (
    Limits,
    Synchronized,
    Tour,
    min_time_move,
    min_time_transfer,
    synchronize,
    through,
)

SECOND = Limits(velocity=1.0, acceleration=2.0)
THIRD = Limits(velocity=1.0, acceleration=2.0, jerk=8.0)
LOPSIDED = Limits(velocity=(-2.0, 1.0), acceleration=(-1.0, 3.0), jerk=(-9.0, 20.0))
TEN = np.random.default_rng(14).uniform(-1.0, 1.0, (10, 3))
PLANE = np.random.default_rng(2).uniform(-1.0, 1.0, (6, 2))


def stopping(points, limits):
    """Return the time that it takes with a stop at every point."""
    legs = itertools.pairwise(points)
    return sum(
        synchronize([(a, b, limits) for a, b in zip(*leg, strict=True)]).duration for leg in legs
    )


def by_hand(points, limits):
    """Return the time with the velocities of central differences where an axis does not turn."""
    times = [
        synchronize([(a, b, limits) for a, b in zip(*leg, strict=True)]).duration
        for leg in itertools.pairwise(points)
    ]
    best = sum(times)
    rates = np.diff(points, axis=0) / np.array(times)[:, None]
    mean = np.where(rates[:-1] * rates[1:] > 0.0, 0.5 * (rates[:-1] + rates[1:]), 0.0)
    for share in np.linspace(0.1, 1.5, 15):
        speeds = np.vstack([mean[:1] * 0.0, np.clip(share * mean, -1.0, 1.0), mean[:1] * 0.0])
        total = 0.0
        for i in range(len(times)):
            ends = zip(points[i], speeds[i], points[i + 1], speeds[i + 1], strict=True)
            total += synchronize([((a, u), (b, w), limits) for a, u, b, w in ends]).duration
        best = min(best, total)
    return best


def assert_sound(path, points, limits, corner=0.0):
    """Check bounds, continuity, ends, and the distances at which the points are passed."""
    axes = (path,) if isinstance(path, Tour) else path
    points = np.asarray(points, dtype=float).reshape(len(path.times), -1)
    for k, axis in enumerate(axes):
        n, size = axis.order, np.abs(points[:, k]).max()
        assert axis.violation(limits) <= 1e-9
        for i in range(1, len(axis.states)):
            before = axis.evaluate(np.nextafter(axis.breaks[i], -np.inf))
            jump = np.abs(before - axis.states[i])[:n]
            assert jump.max() <= 1e-9 * max(1.0, size, np.abs(axis.states).max())
        np.testing.assert_allclose(axis.start_state[:-1], [points[0, k], *[0.0] * (n - 1)])
        np.testing.assert_array_equal(axis.end_state, [points[-1, k], *[0.0] * n])
        assert axis.end_time == axes[0].end_time
        assert axis.start_time == 0.0
    assert np.all(np.diff(path.times) >= 0.0)
    assert path.times[0] == 0.0
    assert path.times[-1] == axes[0].end_time
    passed = np.column_stack([axis(path.times) for axis in axes])
    off = np.linalg.norm(passed - points, axis=1)
    assert off.max() <= corner * (1.0 + 1e-9) + 1e-9 * np.abs(points).max()


@pytest.mark.parametrize("limits", [SECOND, THIRD, LOPSIDED], ids=repr)
def test_points_on_the_way_of_one_axis_cost_nothing(limits):
    points = [-1.0, -0.9, -0.9, 0.3, 0.31, 2.0, 4.0]
    tour, move = through(points, limits), min_time_transfer(-1.0, 4.0, limits)
    assert tour.duration == pytest.approx(move.duration, rel=1e-14)
    assert_sound(tour, points, limits)
    assert tour.times[1] == tour.times[2]


@pytest.mark.parametrize("limits", [SECOND, THIRD, LOPSIDED], ids=repr)
def test_points_on_the_way_of_a_line_cost_nothing(limits):
    shares = np.array([0.0, 0.1, 0.35, 0.9, 1.0])
    points = np.array([1.0, -2.0]) + shares[:, None] * [0.6, 0.8]
    path = through(points, limits, straight=True)
    line = synchronize([(1.0, 1.6, limits), (-2.0, -1.2, limits)], "straight-line")
    assert path.duration == pytest.approx(line.duration, rel=1e-12)
    assert_sound(path, points, limits)


@pytest.mark.parametrize("limits", [SECOND, THIRD, LOPSIDED], ids=repr)
@pytest.mark.parametrize("points", [TEN, PLANE, TEN[:6, :1]], ids=["ten", "plane", "one axis"])
def test_it_is_sooner_than_stops_and_than_velocities_by_hand(points, limits):
    path, stops, hand = through(points, limits), stopping(points, limits), by_hand(points, THIRD)
    assert_sound(path, points, limits)
    assert path.duration <= 0.95 * stops
    if limits is THIRD:
        assert path.duration < 0.97 * hand


def test_ten_points_on_three_axes_take_a_quarter_less_than_with_stops():
    assert through(TEN, THIRD).duration < 0.76 * stopping(TEN, THIRD)


def slowest_share(h, points, limits, cells):
    """Return the least factor on the highest bound with which a sampled axis passes in time."""
    n, dt = limits.order, sum(h) / cells
    a = np.array(
        [[dt ** (j - i) / [1, 1, 2][j - i] if j >= i else 0.0 for j in range(n)] for i in range(n)]
    )
    b = np.array([dt ** (n - i) / [1, 1, 2, 6][n - i] for i in range(n)])
    rows = np.zeros((cells + 1, n, cells))
    for c in range(cells):
        rows[c + 1] = np.einsum("ij,jk->ik", a, rows[c])
        rows[c + 1, :, c] += b
    at = np.rint(np.cumsum(h) / dt).astype(int)
    equal = np.vstack([rows[at, 0], rows[-1, 1:]])
    sides = np.concatenate([np.array(points[1:]) - points[0], np.zeros(n - 1)])
    less, most = [], []
    for k in range(1, n):
        low, high = limits.bounds(k)
        less += [rows[1:, k], -rows[1:, k]]
        most += [np.full(cells, high), np.full(cells, -low)]
    low, high = limits.bounds(n)
    less += [np.eye(cells), -np.eye(cells)]
    most += [np.zeros(cells), np.zeros(cells)]
    share = np.zeros((sum(map(len, less)), 1))
    share[-2 * cells : -cells, 0], share[-cells:, 0] = -high, low
    result = linprog(
        np.append(np.zeros(cells), 1.0),
        A_ub=np.hstack([np.vstack(less), share]),
        b_ub=np.concatenate(most),
        A_eq=np.hstack([equal, np.zeros((len(equal), 1))]),
        b_eq=sides,
        bounds=[(None, None)] * cells + [(0.0, None)],
    )
    return result.x[-1] if result.status == 0 else np.inf


def soonest_on_a_grid(points, limits, cells, around):
    """Return the least time through three points, tried at every share of the first leg."""
    best = np.inf
    for first in around:
        low, high = 0.5, 8.0
        while high - low > 1e-3:
            total = 0.5 * (low + high)
            h = np.array([first, cells - first]) * total / cells
            shares = [slowest_share(h, points[:, k], limits, cells) for k in range(points.shape[1])]
            low, high = (low, total) if max(shares) <= 1.0 else (total, high)
            if low > best:
                break
        best = min(best, high)
    return best


@pytest.mark.parametrize(("limits", "seed"), some(itertools.product([THIRD, SECOND], [3, 4]), 1))
def test_three_points_take_the_least_time_of_a_sampled_motion(limits, seed):
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 2))
    path = through(points, limits)
    share = path.times[1] / path.duration
    around = range(round(48 * (share - 0.15)), round(48 * (share + 0.15)), 2)
    grid = soonest_on_a_grid(points, limits, 48, around)
    assert path.duration <= grid * 1.005
    assert path.duration >= grid * 0.97  # the samples' bounds hold, but not between them


@pytest.mark.parametrize("limits", [SECOND, THIRD], ids=repr)
@pytest.mark.parametrize("corner", some([0.02, 0.5, 0.1], 2))
def test_a_corner_saves_time_and_is_kept(corner, limits):
    exact, path = through(PLANE, limits), through(PLANE, limits, corner=corner)
    assert path.duration < exact.duration
    assert_sound(path, PLANE, limits, corner)
    np.testing.assert_array_equal(path.passage.points, PLANE)
    assert path.passage.corner == corner


def far_off_lines(path, points):
    """Return how far samples of a path are from the nearest line, and from the nearest corner."""
    xy = np.column_stack([axis(np.linspace(0.0, path.duration, 4001)) for axis in path])
    lines = []
    for a, b in itertools.pairwise(points):
        along = np.clip((xy - a) @ (b - a) / np.sum((b - a) ** 2), 0.0, 1.0)
        lines.append(np.linalg.norm(xy - a - along[:, None] * (b - a), axis=1))
    corners = np.linalg.norm(xy[:, None, :] - points[None, 1:-1], axis=2)
    return np.min(lines, axis=0), corners.min(axis=1)


@pytest.mark.parametrize("limits", some([SECOND, LOPSIDED, THIRD], 2), ids=repr)
@pytest.mark.parametrize("corner", some([0.01, 1.0, 0.1], 2))
def test_lines_are_kept_but_within_the_tolerance_of_their_corners(corner, limits):
    stops = through(PLANE, limits, straight=True)
    assert far_off_lines(stops, PLANE)[0].max() < 1e-12
    assert_sound(stops, PLANE, limits)
    path = through(PLANE, limits, straight=True, corner=corner)
    assert_sound(path, PLANE, limits, corner)
    off, near = far_off_lines(path, PLANE)
    assert off[near > corner * (1.0 + 1e-9)].max(initial=0.0) < 1e-12
    assert path.duration < stops.duration


def test_lines_beside_free_legs_and_lines_back():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.5], [0.0, 0.5]])
    path = through(points, THIRD, straight=[False, True, True, False], corner=0.05)
    assert_sound(path, points, THIRD, 0.05)
    one, two, three = path.times[1:4]
    inside = np.linspace(one, three, 500)
    np.testing.assert_allclose(path[0](inside), 1.0, atol=1e-12)
    assert abs(path[1](two, 1)) < 1e-12  # straight back


def test_a_wafer_is_scanned_at_constant_velocity_in_one_call():
    points = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.5], [0.0, 0.5], [0.0, 1.0], [3.0, 1.0]])
    path = through(points, THIRD, scan={0: 0.8, 2: 0.8, 4: 0.8})
    for leg, way in ((0, 1.0), (2, -1.0), (4, 1.0)):
        begin, end = path.times[leg : leg + 2]
        assert end - begin == pytest.approx(3.0 / 0.8, rel=1e-13)
        inside = np.linspace(begin, end, 50)[1:-1]
        np.testing.assert_allclose(path[0](inside, 1), 0.8 * way, rtol=1e-13)
        np.testing.assert_array_equal(path[1](inside, 1), 0.0)
        np.testing.assert_allclose(path[0]([begin, end]), points[leg : leg + 2, 0], atol=1e-12)
    assert max(axis.violation(THIRD) for axis in path) <= 1e-9
    change = min_time_move(0.8, Limits(velocity=2.0, acceleration=8.0)).duration
    assert path.times[0] == pytest.approx(change, rel=1e-13)
    assert path.duration - path.times[-1] == pytest.approx(change, rel=1e-13)
    assert np.abs(path[0].end_state[1:]).max() == 0.0


def test_a_scan_amid_other_points_is_met_by_them():
    path = through([0.0, 1.0, 2.0, 0.0], THIRD, scan={1: 0.5})
    np.testing.assert_allclose(path(np.linspace(*path.times[1:3], 20)[1:-1], 1), 0.5, rtol=1e-13)
    lone = min_time_transfer(0.0, (1.0, 0.5), THIRD).duration
    back = min_time_transfer((2.0, 0.5), 0.0, THIRD).duration
    assert path.duration == pytest.approx(lone + 2.0 + back, rel=1e-13)


@pytest.mark.parametrize("unit", [1e-9, 1e6])
def test_units_do_not_matter(unit):
    def limits(time):
        return Limits(unit * 1.0 / time, unit * 2.0 / time**2, unit * 8.0 / time**3)

    reference = through(PLANE, limits(1.0) if unit == 1.0 else THIRD, corner=0.05).duration
    path = through(PLANE * unit, limits(1e-3), corner=0.05 * unit)
    assert path.duration == pytest.approx(reference * 1e-3, rel=2e-3)


def test_axes_of_two_orders_and_limits_of_their_own():
    given = (THIRD, SECOND, LOPSIDED)
    path = through(TEN, given, corner=0.02)
    for axis, limits in zip(path, given, strict=True):
        assert axis.violation(limits) <= 1e-9
    off = np.linalg.norm(np.column_stack([axis(path.times) for axis in path]) - TEN, axis=1)
    assert off.max() <= 0.02 * (1.0 + 1e-9)


def test_equal_points_and_axes_that_do_not_move():
    still = through([(1.0, 2.0), (1.0, 2.0)], THIRD)
    assert still.duration == 0.0
    assert still.times.tolist() == [0.0, 0.0]
    assert through([3.0, 3.0], THIRD).end_state[0] == 3.0
    points = [(0.0, 5.0), (1.0, 5.0), (1.0, 5.0), (0.5, 5.0)]
    path = through(points, THIRD)
    assert_sound(path, points, THIRD)
    np.testing.assert_array_equal(path[1](np.linspace(0.0, path.duration, 9)), 5.0)


def test_what_comes_back_is_known_to_other_verbs():
    path = through(PLANE, THIRD)
    assert isinstance(path, Synchronized)
    further = path.modify(path.times[2], [0.0, 0.0])
    assert [axis.end_state[0] for axis in further] == [0.0, 0.0]
    with pytest.raises(ValueError, match="has no points that it passes"):
        _ = further.times
    assert not path.times.flags.writeable


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: through([1.0], THIRD), "points of shape (1,): expected (m,) or (m, axes)"),
        (lambda: through([0.0, np.nan], THIRD), "points[1] = nan"),
        (lambda: through(np.zeros((2, 2, 2)), THIRD), "points of shape (2, 2, 2)"),
        (lambda: through(PLANE, [THIRD]), "expected one for all axes, or 2, one per axis, not 1"),
        (
            lambda: through(PLANE, Limits.from_bounds([None] * 10 + [1.0])),
            "limits of order 11: expected order 2",
        ),
        (lambda: through(PLANE, Limits(velocity=1.0)), "limits of order 1: expected order 2"),
        (lambda: through(PLANE, THIRD, corner=-0.1), "corner = -0.1: expected a finite distance"),
        (lambda: through(PLANE, THIRD, straight=[True]), "expected 5 entries, one for each leg"),
        (lambda: through([0.0, 1.0], THIRD, scan={1: 0.1}), "expected a whole number from 0 to 0"),
        (lambda: through([0.0, 1.0], THIRD, scan={0: 2.0}), "expected at most 1.0"),
        (lambda: through([0.0, 1.0], THIRD, scan={0: -1.0}), "expected a positive"),
        (lambda: through([1.0, 1.0], THIRD, scan={0: 0.1}), "leg 0 has no length"),
        (
            lambda: through([0.0, 1.0, 0.0], THIRD, scan={0: 0.1, 1: 0.1}),
            "legs 0 and 1 meet at constant speed",
        ),
    ],
)
def test_bad_input_is_told_in_one_line(call, told):
    with pytest.raises(ValueError, match=re.escape(told)) as error:
        call()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("given", [{"straight": "yes"}, {"straight": [1] * 5}, {"scan": [0.1]}])
def test_other_kinds_are_refused(given):
    with pytest.raises(TypeError, match="expected"):
        through(PLANE, THIRD, **given)
