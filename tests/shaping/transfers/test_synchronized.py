"""Synchronized axes modified under way: nothing jumps, bounds hold by sampling, all stay tied."""

import copy
import pickle
from math import nan, sqrt

import numpy as np
import pytest
from references import thompson_order_3
from tiers import some

from jounce.shaping import (
    InfeasibleError,
    Limits,
    Synchronized,
    min_time_move,
    min_time_transfer,
    s_curve_move,
    synchronize,
)

PLAIN, SMOOTH = Limits(2.0, 3.0), Limits(1.5, 2.0, 8.0)
SNAP = Limits(2.0, 1.5, 4.0, 30.0)
CURVE = {"velocity": 2.0, "acceleration": 3.0, "deceleration": 1.0, "acceleration_jerk": 9.0}
SEEDS = range(40)


def random_axes(seed, mode, order=3):
    """Return limits, axes that move together, a time on their way and new targets."""
    rng = np.random.default_rng((61, seed, len(mode)))
    n = int(rng.integers(2, 5))
    limits = [Limits(*bounds) for bounds in (10.0 ** rng.uniform(-0.5, 0.5, (n, order))).tolist()]
    starts, ends, new = (3.0 * rng.normal(size=(3, n))).tolist()
    axes = synchronize(list(zip(starts, ends, limits, strict=True)), mode)
    return rng, limits, axes, float(rng.uniform(0.05, 1.1)) * axes.duration, new


def assert_same_before(axes, changed, time):
    early = np.linspace(0.0, time, 60)[:-1]
    for old, new in zip(axes, changed, strict=True):
        np.testing.assert_allclose(new(early), old(early), rtol=0, atol=1e-12)


def assert_no_jump(axes, derivatives):
    """Assert by sampling on both sides of every break that no derivative steps."""
    for number, axis in enumerate(axes):
        for k in range(derivatives):
            scale = max(axis.peak(k), 1e-9)
            step = 1e-9 * max(axis.duration, 1.0)
            inside = axis.breaks[(axis.breaks > step) & (axis.breaks < axis.end_time - step)]
            most = 1e-9 * scale + 2.5 * step * axis.peak(k + 1)
            jumps = np.abs(axis(inside + step, k) - axis(inside - step, k))
            assert jumps.max(initial=0.0) <= most, (number, k, jumps.max())


def assert_within(axis, limits, since):
    """Assert the bounds at sampled times."""
    times = np.union1d(np.linspace(since, axis.end_time, 2000), axis.breaks[axis.breaks >= since])
    for k in range(1, limits.order + 1):
        low, high = limits.bounds(k)
        values = axis(times[:-1], k)
        assert values.max() <= high * (1.0 + 1e-9), (k, values.max())
        assert values.min() >= low * (1.0 + 1e-9), (k, values.min())


def assert_tied(axes):
    assert [axis.end_time for axis in axes] == pytest.approx([axes.duration] * len(axes), rel=1e-9)


# Both, start, end


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("mode", some(["both", "end", "start"], 2))
def test_new_targets_are_reached_together_and_nothing_jumps(mode, order):
    for seed in SEEDS:
        _, limits, axes, time, new = random_axes(seed, mode, order)
        changed = axes.modify(time, new)
        assert isinstance(changed, Synchronized)
        assert changed.mode == mode
        assert_same_before(axes, changed, time)
        assert_no_jump(changed, order)
        for axis, target, bounds in zip(changed, new, limits, strict=True):
            assert axis.end_state.tolist() == [target] + [0.0] * order
            assert_within(axis, bounds, 0.0)
        if mode != "start":
            assert_tied(changed)


def test_the_duration_is_the_least_that_all_can_take():
    """No shorter than any axis alone, and that of the slowest where it alone decides."""
    for seed in SEEDS:
        _, limits, axes, time, new = random_axes(seed, "both")
        changed = axes.modify(time, new)
        alone = [
            min_time_transfer(axis.evaluate(time)[:3], target, each).duration
            for axis, target, each in zip(axes, new, limits, strict=True)
        ]
        rest = changed.duration - time
        assert rest >= max(alone) * (1.0 - 1e-9)
        [slow] = np.flatnonzero(np.array(alone) == max(alone))[:1]
        far = axes.modify(time, [x + 1e3 * (i == slow) for i, x in enumerate(new)])
        state = axes[slow].evaluate(time)[:3]
        least = min_time_transfer(state, new[slow] + 1e3, limits[slow]).duration
        assert far.duration - time == pytest.approx(least, rel=1e-9)


def test_left_out_targets_stay_and_relative_ones_count_from_the_old():
    axes = synchronize([(0.0, 4.0, SMOOTH), (1.0, 2.0, SMOOTH)])
    stays = axes.modify(1.0)
    assert stays.duration == pytest.approx(axes.duration, rel=1e-9)
    further = axes.modify(1.0, [1.5, None], relative=True)
    assert [axis.end_state[0] for axis in further] == [5.5, 2.0]
    moving = axes.modify(1.0, [(6.0, 0.5), None])
    assert moving[0].end_state[:2].tolist() == [6.0, 0.5]
    again = moving.modify(2.0).modify(2.5, [7.0, 7.0])
    assert [axis.end_state[0] for axis in again] == [7.0, 7.0]
    assert_no_jump(again, 3)
    assert_tied(again)


def test_new_limits_hold_once_the_axes_are_inside():
    for seed in SEEDS:
        rng, limits, axes, time, new = random_axes(seed, "both")
        lower = [Limits(*(float(rng.uniform(0.3, 1.0)) * b for b in each.upper)) for each in limits]
        changed = axes.modify(time, new, limits=lower)
        assert_same_before(axes, changed, time)
        assert_no_jump(changed, 3)
        assert_tied(changed)
        for axis, old, each in zip(changed, axes, lower, strict=True):
            alone = min_time_transfer(old.evaluate(time)[:3], axis.end_state[0], each)
            assert_within(axis, each, min(time + alone.inside_after, axis.end_time))
    one = axes.modify(time, limits=SMOOTH)
    assert one.planned == (SMOOTH,) * len(axes)


def test_before_the_start_they_wait_and_after_the_end_they_go_on():
    axes = synchronize([(0.0, 4.0, SMOOTH), (1.0, 2.0, SMOOTH)])
    early = axes.modify(-1.0, [1.0, None])
    assert {axis.start_time for axis in early} == {-1.0}
    same = synchronize([(0.0, 1.0, SMOOTH), (1.0, 2.0, SMOOTH)])
    assert early.duration == pytest.approx(same.duration)
    late = axes.modify(axes.duration + 1.0, [0.0, 1.0])
    assert late.duration == pytest.approx(2.0 * axes.duration + 1.0)
    assert late[0](axes.duration + 0.5) == 4.0


def test_the_mode_may_change():
    axes = synchronize([(0.0, 4.0, SMOOTH), (1.0, 2.0, SMOOTH)], "start")
    tied = axes.modify(0.5, mode="both")
    assert_tied(tied)
    assert axes[1].end_time < tied[1].end_time
    loose = tied.modify(1.0, mode="start")
    assert loose[1].end_time < loose[0].end_time
    assert_no_jump(loose, 3)


# S-curves and moves of other kinds


@pytest.mark.parametrize("rates", [{}, {"jerk_percent": 0.4, "acceleration_jerk": None}], ids=str)
def test_s_curves_go_on_as_s_curves(rates):
    """By jerk percent the new plan begins without acceleration."""
    settings = {**CURVE, **rates}
    for time in (0.3, 1.0, 1.8):
        axes = synchronize([s_curve_move(5.0, **settings), s_curve_move(1.0, **settings),
                            (0.0, -2.0, SMOOTH)])  # fmt: skip
        changed = axes.modify(time, [9.0, 2.0, -6.0])
        assert_tied(changed)
        assert_same_before(axes, changed, time)
        assert_no_jump(changed, 2 if rates else 3)
        assert [axis.end_state[0] for axis in changed] == pytest.approx([9.0, 2.0, -6.0])
        rise = 0.8 if rates else 1.0
        for axis in changed[:2]:
            assert_within(axis, Limits(2.0, (-1.0 / rise, 3.0 / rise)), 0.0)
        slower = changed.modify(time + 0.2, limits=[{"velocity": 1.0}, None, None])
        assert slower.planned[0].rates.velocity == 1.0
        assert slower.duration > changed.duration
        assert_no_jump(slower, 2 if rates else 3)
        assert_tied(slower)


def test_an_s_curve_with_time_to_spare_goes_slower():
    axes = synchronize([s_curve_move(5.0, **CURVE), (0.0, 1.0, PLAIN)], "start")
    tied = axes.modify(0.5, [5.0, 30.0], mode="both")
    assert_tied(tied)
    assert tied[0].extremes(1)[0] >= -1e-9
    assert tied[0](tied.duration - 3.0, 1) < 0.5
    back = axes.modify(0.5, [-5.0, 30.0], mode="both")
    assert_tied(back)
    assert back[0].end_state[0] == -5.0
    passing = axes.modify(0.5, [(5.0, 1.5), None], mode="start")
    assert passing[0].end_state[1] == 1.5
    with pytest.raises(ValueError, match=r"target acceleration = 1\.0 of axis 0: an S-curve ends"):
        axes.modify(0.5, [(5.0, 0.5, 1.0), None])
    with pytest.raises(InfeasibleError, match="have no duration in common"):
        axes.modify(0.5, [(5.0, 1.5), 90.0], mode="both")


def test_a_move_without_known_limits_takes_some():
    axes = synchronize([min_time_move(4.0, SNAP), (0.0, 1.0, SMOOTH)])
    with pytest.raises(ValueError, match="axis 0 was planned with limits that are not known: exp"):
        axes.modify(1.0, [5.0, None])
    changed = axes.modify(1.0, [5.0, None], limits=[SMOOTH, None])
    assert_no_jump(changed, 3)
    assert_tied(changed)
    rested = axes.modify(axes.duration + 1.0, [None, 3.0])
    assert (rested[0](axes.duration + np.array([0.5, 2.0])) == 4.0).all()
    assert_tied(rested)


# Straight lines


def off_line(axes, since, until, points=200):
    """Return how far positions are off the straight line between two times."""
    times = np.linspace(since, until, points)
    x = np.array([axis(times) for axis in axes]).T
    along = (x[-1] - x[0]) / np.linalg.norm(x[-1] - x[0])
    d = x - x[0]
    return np.abs(d - np.outer(d @ along, along)).max()


@pytest.mark.parametrize("resultant", [None, Limits(1.0, 1.5, 6.0)])
def test_on_the_line_new_ends_along_it_need_no_stop(resultant):
    given = [(0.0, 3.0, SMOOTH), (1.0, 5.0, SMOOTH)]
    axes = synchronize(given, "straight-line", resultant=resultant)
    time = 0.5 * axes.duration
    for share in (2.0, 0.9, -0.5):
        ends = [3.0 * share, 1.0 + 4.0 * share]
        changed = axes.modify(time, ends)
        assert_same_before(axes, changed, time)
        assert_no_jump(changed, 3)
        assert_tied(changed)
        assert [axis.end_state[0] for axis in changed] == pytest.approx(ends, abs=1e-12)
        assert off_line(changed, 0.0, changed.duration) < 1e-9
        v = changed.resultant(np.linspace(time, changed.duration, 500)[:-1], 1)
        if share > 1.0:
            assert v.min() > 0.0
        for axis in changed:
            assert_within(axis, SMOOTH, 0.0)
        if resultant is not None:
            assert_within(changed.resultant, resultant, 0.0)
    stays = axes.modify(time)
    assert stays.duration == pytest.approx(axes.duration, rel=1e-7)


def test_off_the_line_they_stop_first_and_then_go_straight():
    """By hand: at full speed v the stop takes v/A + A/J, and the new line is a move from rest."""
    limits = Limits(1.0, 1.5, 6.0)
    axes = synchronize([(0.0, 30.0), (0.0, 40.0)], "straight-line", resultant=limits)
    changed = axes.modify(10.0, [0.0, 40.0])
    assert_no_jump(changed, 3)
    assert_tied(changed)
    stop = 1.0 / 1.5 + 1.5 / 6.0
    x = np.array([axis(10.0 + stop) for axis in changed])
    assert [axis(10.0 + stop, 1) for axis in changed] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert off_line(changed, 0.0, 10.0 + stop) < 1e-9
    assert off_line(changed, 10.0 + stop, changed.duration) < 1e-9
    length = np.linalg.norm([-x[0], 40.0 - x[1]])
    expected = 10.0 + stop + thompson_order_3(length, 1.0, 1.5, 6.0).duration
    assert changed.duration == pytest.approx(expected, rel=1e-9)
    assert_within(changed.resultant, limits, 0.0)
    norm = sqrt(sum(axis(15.0, 1) ** 2 for axis in changed))
    assert norm == pytest.approx(changed.resultant(15.0, 1))
    blended = axes.modify(10.0, [0.0, 40.0], mode="both", limits=limits)
    assert_no_jump(blended, 3)
    assert blended.duration < changed.duration


def test_new_bounds_of_the_resultant_and_of_axes_hold_along_the_line():
    axes = synchronize([(0.0, 30.0), (0.0, 40.0, Limits(1.0, 2.0, 8.0))], "straight-line",
                       resultant=Limits(2.0, 2.0, 8.0))  # fmt: skip
    assert axes.resultant.peak(1) == pytest.approx(1.25)
    slower = axes.modify(10.0, resultant=Limits(0.5, 1.0, 8.0))
    assert_no_jump(slower, 3)
    assert slower.resultant(np.array([20.0, 40.0]), 1) == pytest.approx([0.5, 0.5])
    assert slower.resultant.extremes(1)[0] >= -1e-12
    axis = axes.modify(10.0, limits=[Limits(0.3, 2.0, 8.0), None])
    assert axis.resultant(20.0, 1) == pytest.approx(0.5)
    assert [each(20.0, 1) for each in axis] == pytest.approx([0.3, 0.4])


@pytest.mark.parametrize("rates", [{}, {"jerk_percent": 0.4, "acceleration_jerk": None}], ids=str)
def test_an_s_curve_along_the_line_goes_on_as_one(rates):
    path = s_curve_move(50.0, **{**CURVE, **rates})
    axes = synchronize([(0.0, 30.0), (0.0, 40.0)], "straight-line", resultant=path)
    longer = axes.modify(5.0, [60.0, 80.0])
    same = path.modify(5.0, target=100.0)
    times = np.linspace(0.0, same.duration, 200)
    assert longer.duration == pytest.approx(same.duration)
    assert longer.resultant(times) == pytest.approx(same(times), abs=1e-9)
    slower = axes.modify(5.0, resultant={"velocity": 1.0})
    assert slower.resultant(15.0, 1) == pytest.approx(1.0)
    corner = axes.modify(5.0, [0.0, 40.0])
    assert_no_jump(corner, 2 if rates else 3)
    rise = 0.8 if rates else 1.0
    low, high = corner.resultant.extremes(2)
    assert (low, high) == pytest.approx((-1.0 / rise, 3.0 / rise))
    with pytest.raises(ValueError, match="rate 'speed' of the resultant: expected one of velocity"):
        axes.modify(5.0, resultant={"speed": 1.0})


def test_axes_at_rest_take_a_line_of_their_own():
    limits = Limits(1.0, 1.5, 6.0)
    axes = synchronize([(0.0, 3.0), (0.0, 4.0)], "straight-line", resultant=limits)
    on = axes.modify(axes.duration, [-4.0, 5.0])
    length = sqrt(49.0 + 1.0)
    expected = axes.duration + thompson_order_3(length, 1.0, 1.5, 6.0).duration
    assert on.duration == pytest.approx(expected)
    assert on.resultant.end_state[0] == pytest.approx(5.0 + length)
    still = synchronize([(0.0, 0.0, SMOOTH), (0.0, 0.0, SMOOTH)], "straight-line")
    assert still.modify(1.0, [3.0, 4.0]).resultant.end_state[0] == pytest.approx(5.0)
    assert still.modify(1.0).duration == 1.0


# The noun, and refusals


def test_it_is_a_tuple_that_can_be_copied_and_shown():
    axes = synchronize([(0.0, 4.0, SMOOTH), (1.0, 2.0, SMOOTH)])
    pan, tilt = axes
    assert axes == (pan, tilt)
    assert repr(axes).startswith("Synchronized(axes=2, mode='both', duration=")
    for other in (copy.copy(axes), copy.deepcopy(axes), pickle.loads(pickle.dumps(axes))):
        assert (other.mode, other.planned) == ("both", (SMOOTH, SMOOTH))
        assert other.modify(1.0, [5.0, 5.0]).duration == axes.modify(1.0, [5.0, 5.0]).duration


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"time": nan}, "^time = nan: expected a finite number$"),
        ({"targets": [1.0]}, r"^targets = \[1.0\]: expected 2 entries, one per axis, not 1$"),
        ({"targets": 1.0}, r"^targets = 1.0: expected a list with one entry per axis$"),
        ({"targets": [nan, 1.0]}, "^target = nan: expected a finite number$"),
        ({"targets": [(), 1.0]}, r"^target = \(\): expected a position, or \(position, vel"),
        ({"targets": ["far", 1.0]}, "^target = 'far': expected a number"),
        ({"targets": [(9.0, 9.0), None]}, "axis 0: end velocity = 9.0 is outside its bounds"),
        ({"limits": [SMOOTH]}, "expected 2 entries, one per axis, not 1$"),
        ({"limits": [2.0, None]}, "^limits of axis 0 = 2.0: expected Limits or rates of an S-cu"),
        ({"limits": [{"velocity": 1.0}, None]}, "^rates of axis 0 = .*: it was planned with no S"),
        ({"limits": SNAP}, "axis 0 was planned with .*: expected limits of order 2 or 3 for new"),
        ({"resultant": SMOOTH}, "it holds along a line, use mode='straight-line'$"),
        ({"mode": "line"}, "^mode = 'line': expected 'start', 'end', 'both' or"),
        ({"mode": "straight-line"}, "^the axes move and are on no straight line: use mode='both'"),
    ],
)
def test_wrong_changes_are_refused(arguments, message):
    axes = synchronize([(0.0, 4.0, SMOOTH), (1.0, 2.0, SMOOTH)])
    with pytest.raises((ValueError, TypeError), match=message):
        axes.modify(**{"time": 1.0, **arguments})


# More on lines


def test_after_a_corner_they_are_on_the_new_line_and_can_be_modified_again():
    limits = Limits(1.0, 1.5, 6.0)
    axes = synchronize([(0.0, 30.0), (0.0, 40.0)], "straight-line", resultant=limits)
    corner = axes.modify(10.0, [0.0, 40.0])
    turned = float(corner[0](10.0 + 1.0 / 1.5 + 0.25)), float(corner[1](10.0 + 1.0 / 1.5 + 0.25))
    beyond = [turned[0] + 2.0 * (0.0 - turned[0]), turned[1] + 2.0 * (40.0 - turned[1])]
    further = corner.modify(20.0, beyond)
    assert_no_jump(further, 3)
    assert [axis.end_state[0] for axis in further] == pytest.approx(beyond, abs=1e-9)
    assert off_line(further, 12.0, further.duration) < 1e-9
    assert further.resultant(np.linspace(20.0, further.duration, 300)[:-1], 1).min() > 0.0
    twice = corner.modify(20.0, [5.0, 5.0]).modify(20.2, [-5.0, 0.0])
    assert_no_jump(twice, 3)
    assert_tied(twice)
    assert_within(twice.resultant, limits, 0.0)


def test_an_end_along_the_line_may_be_passed():
    axes = synchronize([(0.0, 30.0), (0.0, 40.0)], "straight-line", resultant=SMOOTH)
    passing = axes.modify(5.0, [(60.0, 0.6), (80.0, 0.8)])
    assert passing.resultant.end_state[:2].tolist() == pytest.approx([100.0, 1.0])
    assert [axis.end_state[1] for axis in passing] == pytest.approx([0.6, 0.8])
    with pytest.raises(ValueError, match="leads off the straight line to them; use mode='both'"):
        axes.modify(5.0, [(60.0, 0.8), (80.0, 0.6)])


def test_s_curves_of_the_axes_bound_the_line_under_way():
    axes = synchronize([s_curve_move(30.0, **CURVE), s_curve_move(40.0, **CURVE)], "straight-line")
    further = axes.modify(5.0, [60.0, 80.0])
    assert_no_jump(further, 3)
    assert_tied(further)
    for axis in further:
        assert_within(axis, Limits(2.0, 1.0, 9.0), 5.0)
    slower = axes.modify(5.0, limits=[None, {"velocity": 1.0}])
    assert slower[1](20.0, 1) == pytest.approx(1.0)
    percent = {**CURVE, "jerk_percent": 0.4, "acceleration_jerk": None}
    by_percent = synchronize([s_curve_move(x, **percent) for x in (30.0, 40.0)], "straight-line")
    with pytest.raises(ValueError, match=r"axis 0 was planned with .*: expected limits of order 2"):
        by_percent.modify(5.0, [60.0, 80.0])
    assert_no_jump(by_percent.modify(5.0, [60.0, 80.0], limits=SMOOTH), 2)


def test_limits_of_two_orders_on_one_line_are_told():
    axes = synchronize([(0.0, 30.0, SMOOTH), (0.0, 40.0, SMOOTH)], "straight-line")
    with pytest.raises(ValueError, match=r"limits of orders \[2, 3\] along one line: expected one"):
        axes.modify(5.0, limits=[PLAIN, None])


def test_while_they_stop_for_a_corner_the_old_line_is_theirs():
    """Left as they are, modified in the stop, they stop and take the same corner."""
    axes = synchronize([(0.0, 30.0), (0.0, 40.0)], "straight-line", resultant=SMOOTH)
    corner = axes.modify(10.0, [0.0, 40.0])
    same = corner.modify(10.3)
    assert_no_jump(same, 3)
    assert same.duration == pytest.approx(corner.duration, rel=1e-6)
    on = corner.modify(10.3, [30.0, 40.0])  # the old target after all
    assert_no_jump(on, 3)
    assert off_line(on, 0.0, on.duration) < 1e-9
    assert on.resultant(np.linspace(0.1, on.duration, 300)[:-1], 1).min() > 0.0


@pytest.mark.parametrize(
    "resultant",
    [
        Limits(velocity=1.0, acceleration=1.0, jerk=1.0),
        s_curve_move(0.0, velocity=1.0, acceleration=1.0, acceleration_jerk=1.0),
    ],
)
def test_axes_that_do_not_move_yet_remember_the_bounds_of_the_resultant(resultant):
    """From rest over 5 with unit bounds: ramps of 2 s over 1 each, and 3 s between, by hand."""
    still = synchronize([((1.0, 0.0, 0.0), 1.0), (0.0, 0.0)], "straight-line", resultant=resultant)
    for waited in (still, still.modify(0.5), still.modify(0.5, [1.0, 0.0])):
        with pytest.raises(ValueError, match="has no resultant"):
            _ = waited.resultant
        gone = waited.modify(2.0, [4.0, 4.0])
        assert gone.resultant.peak("jerk") == pytest.approx(1.0, rel=1e-9)
        assert [float(axis.end_state[0]) for axis in gone] == pytest.approx([4.0, 4.0], rel=1e-12)
        assert gone.duration == pytest.approx(2.0 + 7.0, rel=1e-9)


def test_new_bounds_of_a_resultant_that_does_not_move_hold_later():
    still = synchronize([(1.0, 1.0), (0.0, 0.0)], "straight-line", resultant=Limits(9.0, 9.0, 9.0))
    slower = still.modify(0.5, resultant=Limits(velocity=1.0, acceleration=1.0, jerk=1.0))
    assert slower.modify(1.0, [4.0, 4.0]).duration == pytest.approx(1.0 + 7.0, rel=1e-9)
