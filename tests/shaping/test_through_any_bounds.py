"""Motions through points at orders 4 and above, and within bounds on position."""

import itertools
import os
import re

import numpy as np
import pytest
from sampled_motions import least_share

from jounce.shaping import InfeasibleError, Limits, min_time_move, min_time_transfer, through

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
FOURTH = Limits(velocity=1.0, acceleration=2.0, jerk=8.0, snap=100.0)
LOPSIDED = Limits(velocity=(-2.0, 1.0), acceleration=(-1.0, 3.0), jerk=9.0, snap=(-80.0, 200.0))
BENT = np.array([[0.0, 0.0], [0.8, 0.1], [0.9, 0.9], [0.1, 1.0]])


def assert_sound(path, points, limits, corner=0.0):
    """Check bounds, continuity, ends, and distances from the points, densely sampled."""
    times = np.linspace(0.0, path.duration, 5001)
    for k, axis in enumerate(path):
        n, own = axis.order, limits[k] if isinstance(limits, tuple) else limits
        assert axis.violation(own) <= 1e-9
        for r in range(own.order + 1):
            low, high = own.bounds(r)
            values, size = axis(times, r), 1e-9 * max(1.0, axis.peak(r))
            assert low - size <= values.min() <= values.max() <= high + size
        for i in range(1, len(axis.states)):
            before = axis.evaluate(np.nextafter(axis.breaks[i], -np.inf))
            jump = np.abs(before - axis.states[i])[: own.order]
            assert (
                jump <= 1e-9 * np.maximum(1.0, np.abs(axis.states[:, : own.order]).max(0))
            ).all()
        np.testing.assert_array_equal(axis.end_state, [points[-1, k], *[0.0] * n])
        np.testing.assert_array_equal(axis.start_state[:-1], [points[0, k], *[0.0] * (n - 1)])
        assert axis.end_time == path[0].end_time
    near = np.column_stack([axis(path.times) for axis in path])
    assert np.linalg.norm(near - points, axis=1).max() <= corner * (1.0 + 1e-9) + 1e-12


def stopping(points, limits):
    """Return the time that it takes with a stop at every point."""
    return sum(
        max(min_time_move(x, limits).duration for x in way) for way in np.diff(points, axis=0)
    )


@pytest.fixture(scope="module")
def bent():
    return through(BENT, FOURTH)


def test_it_is_sound_and_sooner_than_stops(bent):
    assert_sound(bent, BENT, FOURTH)
    assert bent.duration < 0.8 * stopping(BENT, FOURTH)


def test_its_times_cannot_be_much_shorter(bent):
    """By a sampled motion, which breaks bounds between samples: 2 % sooner some axis cannot."""
    shares = np.rint(bent.times / bent.duration * 120.0) / 120.0

    def all_can(factor):
        times = (shares * bent.duration * factor)[1:-1]
        return all(
            least_share(
                x[0],
                x[-1],
                FOURTH,
                bent.duration * factor,
                via=list(zip(times, x[1:-1], strict=True)),
            )
            <= 1.0
            for x in BENT.T
        )

    assert not all_can(0.98)
    assert all_can(1.03)


@pytest.mark.parametrize("limits", [FOURTH, *[LOPSIDED] * SLOW], ids=repr)
def test_points_on_the_way_of_one_axis_cost_nothing(limits):
    tour, move = through([-1.0, -0.9, 0.3, 2.0], limits), min_time_move(3.0, limits)
    assert tour.duration == pytest.approx(move.duration, rel=1e-12)
    np.testing.assert_allclose(tour(tour.times), [-1.0, -0.9, 0.3, 2.0], atol=1e-9)


def test_a_corner_saves_time_and_is_kept(bent):
    path = through(BENT, FOURTH, corner=0.05)
    assert_sound(path, BENT, FOURTH, 0.05)
    assert path.duration < bent.duration
    times = np.linspace(0.0, path.duration, 20001)
    xy = np.column_stack([axis(times) for axis in path])
    for point in BENT:
        assert np.linalg.norm(xy - point, axis=1).min() <= 0.05 * (1.0 + 1e-6)


@pytest.mark.parametrize("limits", [FOURTH, *[LOPSIDED] * SLOW], ids=repr)
def test_lines_are_kept_but_within_the_tolerance_of_their_corners(limits):
    points, corner = BENT[:3], 0.1
    path = through(points, limits, straight=True, corner=corner)
    assert_sound(path, points, limits, corner)
    assert path.duration < through(points, limits, straight=True).duration
    xy = np.column_stack([axis(np.linspace(0.0, path.duration, 4001)) for axis in path])
    off = []
    for a, b in itertools.pairwise(points):
        along = np.clip((xy - a) @ (b - a) / np.sum((b - a) ** 2), 0.0, 1.0)
        off.append(np.linalg.norm(xy - a - along[:, None] * (b - a), axis=1))
    away = np.linalg.norm(xy - points[1], axis=1) > corner * (1.0 + 1e-9)
    assert np.min(off, axis=0)[away].max() < 1e-12


def test_a_wafer_is_scanned_at_constant_velocity_in_one_call():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]])
    path = through(points, FOURTH, scan={0: 0.8, 2: 0.8})
    for leg, way in ((0, 1.0), (2, -1.0)):
        begin, end = path.times[leg : leg + 2]
        assert end - begin == pytest.approx(1.0 / 0.8, rel=1e-13)
        inside = np.linspace(begin, end, 50)[1:-1]
        np.testing.assert_allclose(path[0](inside, 1), 0.8 * way, rtol=1e-13)
        np.testing.assert_array_equal(path[1](inside, 1), 0.0)
    assert max(axis.violation(FOURTH) for axis in path) <= 1e-9
    change = min_time_move(0.8, Limits(velocity=2.0, acceleration=8.0, jerk=100.0)).duration
    assert path.times[0] == pytest.approx(change, rel=1e-13)


def test_axes_of_three_orders():
    limits = (FOURTH, Limits(velocity=1.0, acceleration=2.0))
    path = through(BENT[:3], limits)
    assert_sound(path, BENT[:3], limits)


@pytest.mark.parametrize("bounds", [(2.0,), (2.0, 8.0), *[(2.0, 8.0, 100.0)] * SLOW], ids=len)
def test_positions_stay_between_stops_at_any_order(bounds):
    """The first point is passed in motion, so that without stops the axis goes beyond it."""
    points = np.array([[0.0, 0.0], [0.5, 0.4], [0.45, 1.0], [0.0, 0.9]])
    free, stopped = (
        through(points, Limits(1.0, *bounds, position=position))
        for position in (None, (-0.01, 1.0))
    )
    narrow = Limits(1.0, *bounds, position=(-0.01, 1.0))
    assert_sound(stopped, points, narrow)
    assert max(axis.violation(narrow) for axis in free) > 0.0
    assert stopped.duration >= free.duration * (1.0 - 2e-3)
    assert stopped.duration < 0.9 * stopping(points, Limits(1.0, *bounds))


def test_no_turning_back_where_a_bound_on_velocity_is_zero():
    points = np.array([[0.0, 0.0], [0.2, 0.6], [0.9, 0.9]])
    limits = Limits(velocity=(0.0, 1.0), acceleration=2.0, jerk=8.0)
    path = through(points, limits)
    assert_sound(path, points, limits)
    told = "from point [0.2, 0.6] to [0.1, 0.9], axis 0: no motion within the limits"
    with pytest.raises(InfeasibleError, match=re.escape(told)) as error:
        through([[0.0, 0.0], [0.2, 0.6], [0.1, 0.9]], limits)
    assert error.value.bound == "velocity"


@pytest.mark.parametrize("highest", [(), *[(1e4,)] * SLOW], ids=len)
def test_orders_5_and_6(highest):
    limits = Limits(1.0, 2.0, 8.0, 100.0, 1e3, *highest)
    path = through(BENT[:3], limits)
    assert_sound(path, BENT[:3], limits)
    assert path.duration < 0.9 * stopping(BENT[:3], limits)


def test_points_and_scans_beyond_the_stops_are_told_with_what_would_do():
    stops = Limits(velocity=1.0, acceleration=2.0, jerk=8.0, position=(0.0, 1.0))
    with pytest.raises(InfeasibleError, match=r"points\[1, 1\] = 1.5 is outside the pos") as error:
        through([[0.0, 0.0], [1.0, 1.5]], stops)
    assert (error.value.bound, error.value.nearest) == ("position", 1.0)
    with pytest.raises(InfeasibleError, match=r"run-up to the scan takes axis 0 to -0\.0") as error:
        through([0.0, 0.5], stops, scan={0: 0.4})
    again = through([error.value.nearest, 0.5], stops, scan={0: 0.4})
    assert again.violation(stops) <= 1e-9
    with pytest.raises(InfeasibleError, match="run-out of the scan takes axis 0 to 1"):
        through([0.5, 1.0], stops, scan={0: 0.4})


def test_a_leg_between_scans_is_planned_between_moving_states_within_stops():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=8.0, position=(-0.2, 1.2))
    path = through([0.1, 0.9, 0.7, 0.1], limits, scan={0: 0.3, 2: 0.3})
    assert path.violation(limits) <= 1e-9
    turn = min_time_transfer((0.9, 0.3), (0.7, -0.3), limits).duration
    assert turn * (1.0 - 1e-4) <= path.times[2] - path.times[1] <= turn * (1.0 + 1e-9)


@pytest.mark.slow
def test_ramps_that_are_short_against_their_legs_are_no_reason_to_stop():
    limits = Limits(velocity=(-2.0, 1.0), acceleration=(-10.0, 1.0), jerk=100.0, snap=1e4)
    points = np.array([(0.0, 0.0), (3.0, 0.1), (3.0, 4.0), (0.02, 0.02)])
    path = through(points, limits)
    stops = sum(
        max(min_time_move(float(way), limits).duration for way in leg if way)
        for leg in np.diff(points, axis=0)
    )
    assert path.duration < stops - 0.5
    assert all(axis.violation(limits) <= 1e-12 for axis in path)


@pytest.mark.slow
def test_no_turning_back_is_no_reason_to_stop():
    points = np.array([[0.0, 0.0], [0.3, 0.6], [1.2, 0.9], [1.5, 1.7]])
    pairs = [(0.0, 1.0), (-2.0, 2.0), (-8.0, 9.0), (-100.0, 60.0), (-1e3, 1e3), (-1e4, 2e4)]
    once, both = (
        through(points, Limits.from_bounds(bounds)) for bounds in (pairs, [(-1.0, 1.0), *pairs[1:]])
    )
    assert_sound(once, points, Limits.from_bounds(pairs))
    assert once.duration <= both.duration * 1.02


@pytest.mark.slow
def test_a_point_on_a_bound_of_position_costs_next_to_nothing():
    rng = np.random.default_rng(11)
    points = rng.uniform(-1.0, 1.0, (5, 2)) * 3.0
    pairs = [(-1.0, 1.0), (-2.0, 3.0), (-8.0, 9.0), (-100.0, 60.0), (-1e3, 1e3)]
    limits = Limits.from_bounds(pairs, position=(float(points.min()), float(points.max())))
    path = through(points, limits)
    assert_sound(path, points, limits)
    assert path.duration <= through(points, Limits.from_bounds(pairs)).duration * 1.01
