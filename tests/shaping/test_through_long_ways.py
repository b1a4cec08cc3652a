"""Motions through points whose legs are long against their ramps: beside order 3, and bounds."""

import itertools

import numpy as np
import pytest

from jounce.shaping import Limits, Tour, min_time_move, through
from jounce.shaping.averaged import averaged
from jounce.shaping.tours.averages import Pieces, widths

BOUNDS = (1.0, 2.0, 8.0)
LOPSIDED = ((-2.0, 1.0), (-1.0, 3.0), (-9.0, 20.0))
POINTS = np.random.default_rng(5).uniform(-1.0, 1.0, (6, 3))


def axes_of(path):
    return (path,) if isinstance(path, Tour) else tuple(path)


def assert_sound(path, points, limits, corner=0.0):
    """Check bounds, joints, ends and distances."""
    rows = np.asarray(points, float).reshape(len(path.times), -1)
    for k, axis in enumerate(axes_of(path)):
        assert axis.violation(limits) <= 1e-10
        assert axis.lowest_jump() >= limits.order
        np.testing.assert_array_equal(axis.end_state[: limits.order], [rows[-1, k], *[0.0] * 3])
        np.testing.assert_array_equal(axis.start_state[: limits.order], [rows[0, k], *[0.0] * 3])
    near = np.column_stack([axis(path.times) for axis in axes_of(path)])
    off = np.linalg.norm(near - rows, axis=1).max()
    assert off <= corner * (1.0 + 1e-9) + 1e-13 * np.abs(rows).max()


@pytest.mark.parametrize("bounds", [BOUNDS, LOPSIDED], ids=["same", "lopsided"])
@pytest.mark.parametrize("ratio", [300.0, pytest.param(10.0, marks=pytest.mark.slow)])
def test_order_4_takes_one_average_longer_than_order_3(bounds, ratio):
    points, snap = POINTS[:3, :2] * ratio, 2e3
    third, fourth = Limits(*bounds), Limits(*bounds, snap)
    low, high = third.bounds(3)
    before, path = through(points, third), through(points, fourth)
    assert_sound(path, points, fourth)
    assert path.duration <= before.duration + (high - low) / snap * 1.01


@pytest.mark.slow
def test_points_far_apart_are_passed_in_motion():
    limits, points = Limits(*BOUNDS, 100.0), POINTS * 100.0
    path = through(points, limits)
    assert_sound(path, points, limits)
    stops = sum(
        min_time_move(float(np.abs(way).max()), limits).duration for way in np.diff(points, axis=0)
    )
    assert path.duration < stops - 2.0
    speeds = np.array([axis(path.times[1:-1], 1) for axis in path])
    assert (np.abs(speeds).max(axis=0) > 0.3).all()


@pytest.mark.slow
@pytest.mark.parametrize("corner", [1e-6, 0.03, 5.0])
def test_corners_and_lines_are_kept_by_averages(corner):
    limits, points = Limits(*BOUNDS, 500.0), POINTS[:4, :2] * 50.0
    free = through(points, limits, corner=corner)
    assert_sound(free, points, limits, corner)
    path = through(points, limits, straight=True, corner=corner)
    assert_sound(path, points, limits, corner)
    xy = np.column_stack([axis(np.linspace(0.0, path.duration, 20001)) for axis in path])
    off = []
    for a, b in itertools.pairwise(points):
        along = np.clip((xy - a) @ (b - a) / np.sum((b - a) ** 2), 0.0, 1.0)
        off.append(np.linalg.norm(xy - a - along[:, None] * (b - a), axis=1))
    corners = np.linalg.norm(xy[:, None] - points[None, 1:-1], axis=2).min(axis=1)
    assert np.min(off, axis=0)[corners > corner * (1.0 + 1e-9)].max(initial=0.0) < 1e-11


def test_a_scan_amid_long_ways():
    limits, points = Limits(*BOUNDS, 500.0), POINTS[:4, :2] * 50.0
    path = through(points, limits, scan={1: 0.5})
    assert max(axis.violation(limits) for axis in path) <= 1e-10
    begin, end = path.times[1:3]
    inside = [axis(np.linspace(begin, end, 50)[1:-1], 1) for axis in path]
    np.testing.assert_allclose(np.linalg.norm(inside, axis=0), 0.5, rtol=1e-13)


def test_widths_have_the_least_sum_of_those_that_keep_the_bounds():
    assert widths(2.0, [100.0]) == pytest.approx([0.02])
    assert widths(2.0, [100.0, 1e7]) == pytest.approx([0.02, 2e-5])
    assert widths(2.0, [np.inf, 1e3]) == pytest.approx([4e-3**0.5] * 2)
    rng = np.random.default_rng(3)
    for _ in range(50):
        bounds = 10.0 ** rng.uniform(0.0, 4.0, 3)
        found = np.array(widths(1.0, bounds.tolist()))
        products = np.cumprod(np.sort(found)[::-1])
        assert (2.0 ** np.arange(3) / products <= bounds * (1.0 + 1e-12)).all()
        others = np.sort(found * np.exp(rng.uniform(-0.5, 0.5, (2000, 3))), axis=1)[:, ::-1]
        kept = (2.0 ** np.arange(3) / np.cumprod(others, axis=1) <= bounds).all(axis=1)
        assert (others[kept].sum(axis=1) >= found.sum() * (1.0 - 1e-12)).all()


def test_pieces_are_those_of_the_average_of_a_trajectory():
    move = min_time_move(1.0, Limits(*BOUNDS))
    pieces = Pieces.joined([move]).averaged(0.07).averaged(0.03)
    [motion] = pieces.cut(pieces.edges[-1:])
    expected = averaged(averaged(move, 0.07), 0.03)
    times = np.linspace(0.0, expected.duration, 101)
    assert motion.duration == pytest.approx(expected.duration, rel=1e-14)
    for k in range(4):
        np.testing.assert_allclose(motion(times, k), expected(times, k), atol=1e-11)
