"""One trajectory for the resultant of several axes: bounds on the norm, by sampling and by hand."""

from math import hypot, inf, pi

import numpy as np
import pytest
from references import replay, thompson_order_2, thompson_order_3

from jounce.shaping import (
    InfeasibleError,
    Limits,
    Trajectory,
    min_time_move,
    min_time_transfer,
    s_curve_move,
    synchronize,
)

SEEDS = range(60)
CURVE = {"acceleration": 8.0, "deceleration": 2.0, "acceleration_jerk": 40.0}


def random_line(seed, n):
    rng = np.random.default_rng((51, seed))
    starts, ends = rng.normal(size=(2, n)) * 10.0 ** rng.uniform(-2.0, 2.0)
    bounds = 10.0 ** rng.uniform(-1.0, 1.0, 3)
    return starts.tolist(), ends.tolist(), bounds.tolist()


def norms(axes, derivative, points=1500):
    """Return the Euclidean norm of a derivative over all axes, at sampled times."""
    end = max(axis.end_time for axis in axes)
    times = np.union1d(np.linspace(0.0, end, points), axes[0].breaks)[:-1]
    return np.sqrt(sum(axis(times, derivative) ** 2 for axis in axes))


def assert_on_line(axes, starts, ends):
    """Assert that sampled positions are on the line, and the ends where they should be."""
    times = np.linspace(0.0, axes[0].end_time, 200)
    spans = np.subtract(ends, starts)
    points = np.array([axis(times) for axis in axes]).T - starts
    along = points @ spans / (spans @ spans)
    np.testing.assert_allclose(points - np.outer(along, spans), 0.0, atol=1e-9 * hypot(*spans))
    assert along[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert (np.diff(along) >= -1e-12).all()


@pytest.mark.parametrize("n", [1, 2, 3, 6])
def test_the_norms_keep_the_resultants_bounds_in_the_least_time(n):
    for seed in SEEDS:
        starts, ends, (v, a, j) = random_line(seed, n)
        limits = Limits(v, a, j)
        axes = synchronize(list(zip(starts, ends, strict=True)), "straight-line", resultant=limits)
        assert_on_line(axes, starts, ends)
        for k, bound in enumerate((v, a, j), start=1):
            assert norms(axes, k).max() <= bound * (1.0 + 1e-9), (seed, k)
        length = hypot(*np.subtract(ends, starts))
        expected = thompson_order_3(length, v, a, j).duration
        assert axes.duration == pytest.approx(expected, rel=1e-9), seed
        assert axes.resultant.end_state[0] == pytest.approx(length, rel=1e-12)
        grid = np.linspace(0.0, axes.duration, 50)
        for axis, start, end in zip(axes, starts, ends, strict=True):
            share = (end - start) / length
            error = axis(grid) - start - share * axes.resultant(grid)
            np.testing.assert_allclose(error, 0.0, atol=1e-12 * length)


@pytest.mark.parametrize("n", [2, 4])
def test_bounds_of_the_axes_hold_besides(n):
    """By hand: bounds along the line are the least of V and V_i·L/|R_i|."""
    for seed in SEEDS:
        starts, ends, own = random_line(seed, n)
        rng = np.random.default_rng((52, seed))
        spans, length = np.subtract(ends, starts), hypot(*np.subtract(ends, starts))
        each = 10.0 ** rng.uniform(-1.0, 1.0, (n, 3))
        axes = synchronize(
            [(x, y, Limits(*b)) for x, y, b in zip(starts, ends, each.tolist(), strict=True)],
            "straight-line",
            resultant=Limits(*own),
        )
        assert_on_line(axes, starts, ends)
        tightest = np.minimum(own, (each * length / np.abs(spans)[:, None]).min(axis=0))
        expected = thompson_order_3(length, *tightest).duration
        assert axes.duration == pytest.approx(expected, rel=1e-9), seed
        for k in (1, 2, 3):
            assert norms(axes, k).max() <= own[k - 1] * (1.0 + 1e-9)
            for axis, bounds in zip(axes, each, strict=True):
                assert replay(axis).extremes[k] == pytest.approx(
                    (0.0, 0.0), abs=bounds[k - 1] * (1.0 + 1e-9)
                )


def test_some_axes_have_bounds_of_their_own_and_some_have_none():
    """The second alone: 4 of 5 at 1 is 1.25 along the line, below the resultant's 2."""
    axes = synchronize(
        [(0.0, 3.0), (1.0, 5.0, Limits(1.0, 10.0))],
        "straight-line",
        resultant=Limits(2.0, 4.0),
    )
    assert axes.resultant.peak(1) == pytest.approx(1.25)
    assert axes.duration == pytest.approx(thompson_order_2(5.0, 1.25, 4.0).duration)
    assert [axis.peak(1) for axis in axes] == pytest.approx([0.75, 1.0])


def test_the_resultant_may_speed_up_and_slow_down_differently():
    """Along the line, whichever way the axes go: 1 s up to 2, 2 s down."""
    limits = Limits(2.0, (-1.0, 2.0))
    for ends in ((3.0, 4.0), (-3.0, 4.0), (-3.0, -4.0)):
        axes = synchronize([(0.0, x) for x in ends], "straight-line", resultant=limits)
        assert axes.resultant.extremes(2) == pytest.approx((-1.0, 2.0))
        assert axes.duration == pytest.approx(1.0 + 2.0 + (5.0 - 3.0) / 2.0)


def test_it_goes_on_from_a_motion_along_the_line():
    """From 1.5 to 1 along (0.6, 0.8), as the transfer over 5 does."""
    limits = Limits(2.0, 4.0, 10.0)
    given = [((0.0, 0.9, 0.3), (3.0, 0.6)), ((1.0, 1.2, 0.4), (5.0, 0.8))]
    axes = synchronize(given, "straight-line", resultant=limits)
    assert axes[0].start_state[:3].tolist() == pytest.approx([0.0, 0.9, 0.3])
    assert axes[1].end_state[:2].tolist() == pytest.approx([5.0, 0.8])
    along = min_time_transfer((0.0, 1.5, 0.5), (5.0, 1.0), limits)
    assert axes.duration == pytest.approx(along.duration, rel=1e-12)
    assert norms(axes, 1).max() <= 2.0 * (1.0 + 1e-9)
    with pytest.raises(ValueError, match=r"axis 0: start velocity = 0\.9 leads off the straight"):
        synchronize([((0.0, 0.9), 3.0), ((1.0, 0.3), 5.0)], "straight-line", resultant=limits)
    with pytest.raises(InfeasibleError, match=r"the resultant: end velocity = 2\.5 is outside"):
        synchronize([(0.0, (3.0, 1.5)), (0.0, (4.0, 2.0))], "straight-line", resultant=limits)


@pytest.mark.parametrize("limits", [Limits(2.0), Limits(2.0, 1.0, 4.0, 30.0)], ids=[1, 4])
def test_other_orders_go_from_rest_to_rest(limits):
    axes = synchronize([(0.0, -3.0), (1.0, 5.0)], "straight-line", resultant=limits)
    assert axes.duration == pytest.approx(min_time_move(5.0, limits).duration, rel=1e-6)
    for k in range(1, limits.order + 1):
        assert norms(axes, k).max() <= limits.bounds(k)[1] * (1.0 + 1e-9)


# A motion of the resultant


@pytest.mark.parametrize("percent", [None, 0.5])
def test_an_s_curve_is_shared_out(percent):
    jerk = {"jerk_percent": percent, "acceleration_jerk": None} if percent else {}
    path = s_curve_move(5.0, velocity=4.0, **{**CURVE, **jerk}, delay=1.0)
    x, y, z = axes = synchronize([(0.0, 3.0), (7.0, 7.0), (1.0, -3.0)], "straight-line",
                                 resultant=path)  # fmt: skip
    assert axes.duration == pytest.approx(path.duration)
    times = np.linspace(0.0, path.duration, 300)
    for k in range(3):
        assert x(times, k) == pytest.approx(0.6 * path(times + 1.0, k), abs=1e-12)
        assert z(times, k) - (k == 0) == pytest.approx(-0.8 * path(times + 1.0, k), abs=1e-12)
    assert (y(times) == 7.0).all()
    assert axes.resultant(times) == pytest.approx(path(times + 1.0))


def test_a_motion_of_the_resultant_is_slowed_down_for_an_axis():
    path = s_curve_move(5.0, velocity=4.0, **CURVE)
    limits = Limits(velocity=0.5 * 0.8 * path.peak(1))
    axes = synchronize([(0.0, 3.0), (0.0, 4.0, limits)], "straight-line", resultant=path)
    assert axes.duration == pytest.approx(2.0 * path.duration)
    moving = s_curve_move(5.0, velocity=4.0, **CURVE, final_velocity=2.0)
    through = synchronize([(0.0, 3.0), (0.0, 4.0)], "straight-line", resultant=moving)
    assert through[1].end_state[:2].tolist() == pytest.approx([4.0, 1.6])
    with pytest.raises(ValueError, match="breaks the bounds of an axis and cannot be slowed"):
        synchronize([(0.0, 3.0), (0.0, 4.0, limits)], "straight-line", resultant=moving)


# A circle is no line; what cannot be


def test_nothing_moves():
    still = synchronize([(1.0, 1.0), (2.0, 2.0)], "straight-line", resultant=Limits(1.0, 1.0))
    assert still.duration == 0.0
    with pytest.raises(ValueError, match="has no resultant: expected axes that move, with mode="):
        _ = still.resultant


@pytest.mark.parametrize(
    ("given", "mode", "resultant", "message"),
    [
        ([(0.0, 1.0, Limits(1.0, 1.0))], "both", Limits(1.0), "it holds along a line, use mode="),
        ([(0.0, 1.0)], "straight-line", None, "axis 0 = .*: expected what min_time_transfer"),
        ([(0.0, 1.0)], "straight-line", 2.0, "limits = 2.0: expected Limits"),
        ([(0.0, "far")], "straight-line", Limits(1.0), "expected a number"),
        ([(0.0, inf)], "straight-line", Limits(1.0, 1.0), "expected a finite number"),
        (
            [(0.0, 3.0), (0.0, 4.0)],
            "straight-line",
            min_time_move(4.9, Limits(1.0)),
            "goes 4.9: expected 5.0, the distance",
        ),
        (
            [((0.0, 1.0), 3.0), (0.0, 4.0)],
            "straight-line",
            min_time_move(5.0, Limits(1.0)),
            "axis 0 = .*: expected two positions beside a motion",
        ),
    ],
)
def test_wrong_resultants_are_refused(given, mode, resultant, message):
    with pytest.raises((ValueError, TypeError), match=message):
        synchronize(given, mode, resultant=resultant)


def test_a_circle_of_directions_takes_the_same_time():
    limits = Limits(1.0, 2.0, 5.0)
    durations = [
        synchronize(
            [(0.0, np.cos(angle)), (0.0, np.sin(angle))], "straight-line", resultant=limits
        ).duration
        for angle in np.linspace(0.0, 2.0 * pi, 25)
    ]
    assert durations == pytest.approx([min_time_move(1.0, limits).duration] * 25, rel=1e-9)
    assert all(isinstance(axis, Trajectory) for axis in synchronize(
        [(0.0, 1.0), (0.0, 0.0)], "straight-line", resultant=limits))  # fmt: skip
