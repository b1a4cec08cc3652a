"""Several axes at once: published and ruckig's own durations, linear programs, straight lines."""

import os
from math import inf, nan, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import assert_sound_transfer, can_take, published_transfers
from strategies import TransferProblem, random_transfer, transfer_problems
from tiers import some

from jounce.shaping import (
    InfeasibleError,
    Limits,
    min_jerk_move,
    min_time_move,
    min_time_transfer,
    s_curve_move,
    synchronize,
)

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
MODES = ("start", "end", "both", "straight-line")
PLAIN = Limits(velocity=2.0, acceleration=1.0)
SMOOTH = Limits(velocity=2.0, acceleration=1.0, jerk=3.0)


def together(problems, mode="both"):
    return synchronize([(p.start, p.end, p.limits) for p in problems], mode)


def check_both(problems):
    """Assert equal durations and sound motions; return the duration."""
    axes = together(problems)
    duration = max(axis.duration for axis in axes)
    for problem, axis in zip(problems, axes, strict=True):
        assert axis.start_time == 0.0
        assert axis.duration == pytest.approx(duration, rel=1e-13), problems
        if duration > 0.0:
            assert_sound_transfer(problem, axis, axis.inside_after)
    return duration


def longest(problems):
    """Return the longest of the axes' own minimum times."""
    return max(p.solve().duration for p in problems)


# All in the same time


@given(problems=st.lists(transfer_problems(), min_size=1, max_size=4))
def test_axes_of_any_kind_take_the_same_time_within_their_limits(problems):
    assert check_both(problems) >= longest(problems) * (1.0 - 1e-14), problems


def from_rest(problem, *, to_rest=False):
    """Return the problem with a start at rest, and an end."""
    rest = (0.0,) * (len(problem.start) - 1)
    end = (problem.end[0], *rest) if to_rest else problem.end
    return TransferProblem((problem.start[0], *rest), end, problem.bounds)


@given(problems=st.lists(transfer_problems(), min_size=1, max_size=4))
def test_between_states_of_rest_that_time_is_the_longest_of_the_axes_own(problems):
    rest = [from_rest(p, to_rest=True) for p in problems]
    assert check_both(rest) == pytest.approx(longest(rest), rel=1e-14), rest


def with_a_gap(order, pairs):
    """Return pairs of axes that take much longer together than each of them alone."""
    found, seed = [], 0
    while len(found) < pairs:
        rng = np.random.default_rng((9, order, seed))
        problems = [random_transfer(rng, order) for _ in range(2)]
        duration = together(problems)[0].duration
        if 1.2 * longest(problems) < duration < 6.0 * longest(problems):
            found.append((problems, duration))
        seed += 1
    return found


@pytest.mark.parametrize("order", [2, 3])
def test_no_shorter_time_is_possible_for_every_axis(order):
    """By linear programs for times in between; that this one is possible the motions prove."""
    for problems, duration in with_a_gap(order, 12 if SLOW else 2):
        assert check_both(problems) == pytest.approx(duration, rel=1e-13)
        shorter = np.linspace(longest(problems), duration, 14)[1:-1] * 0.999
        for tried in shorter.tolist():
            assert not all(can_take(p, tried) for p in problems), (problems, tried)


def pausing(duration):
    """Return an axis from rest to rest whose minimum time is the duration."""
    return TransferProblem((0.0, 0.0), ((duration / 2.0) ** 2, 0.0), ((-9.0, 9.0), (-1.0, 1.0)))


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (0.1, 2.0 * (sqrt(1.5) - 1.0)),
        (0.5, 0.5),
        (0.58, 0.58),
        (0.6, 2.0 + sqrt(2.0)),
        (1.0, 2.0 + sqrt(2.0)),
        (3.4, 2.0 + sqrt(2.0)),
        (3.5, 3.5),
    ],
)
def test_a_time_in_which_an_axis_is_blocked_is_passed_over(other, expected):
    """From v = 1 to v = 1 over 0.5 with A = 1: at most by way of w, w² = 1.5, in 2·(w − 1).

    At least by way of w² = 0.5 in 2·(1 − w); or w is negative, which takes 2·(1 + √0.5).
    """
    passing = TransferProblem((0.0, 1.0), (0.5, 1.0), ((-3.0, 3.0), (-1.0, 1.0)))
    found = check_both([passing, pausing(other)])
    assert found == pytest.approx(expected, rel=1e-14)
    assert check_both([pausing(other), passing, pausing(0.05)]) == found
    assert check_both([p.mirrored() for p in (passing, pausing(other))]) == found


@pytest.mark.parametrize("limits", [PLAIN, SMOOTH])
def test_axes_may_differ_by_50000_in_distance(limits):
    bounds = tuple(limits.bounds(k) for k in range(1, limits.order + 1))
    rest = (0.0,) * (limits.order - 1)
    problems = [TransferProblem((0.0, *rest), (distance, *rest), bounds)
                for distance in (1e-3, -50.0, 2e-7)]  # fmt: skip
    duration = check_both(problems)
    assert duration == pytest.approx(min_time_transfer(0.0, 50.0, limits).duration, rel=1e-15)
    for axis, problem in zip(together(problems), problems, strict=True):
        assert axis.peak(1) >= abs(problem.end[0]) / duration


def test_an_axis_at_its_target_stays_there():
    axes = synchronize([(3.0, 3.0, PLAIN), (0.0, 1.0, SMOOTH)])
    assert axes[0].extremes(0) == (3.0, 3.0)
    assert axes[0].duration == pytest.approx(axes[1].duration, rel=1e-15)
    for mode in MODES:
        at_rest = synchronize([(3.0, 3.0, PLAIN), (-1.0, -1.0, PLAIN)], mode)
        assert [axis.duration for axis in at_rest] == [0.0, 0.0]


def test_axes_that_pass_their_targets_at_the_start_need_no_time():
    """A duration apart from all others: leaving and coming back takes long."""
    for limits, state in ((PLAIN, (3.0, 1.0)), (SMOOTH, (3.0, 1.0, -0.5))):
        axes = synchronize([(state, state, limits)] * 2)
        assert [axis.duration for axis in axes] == [0.0, 0.0]
        later = synchronize([(state, state, limits), (0.0, 0.01, limits)])
        assert later[0].duration > 3.0


@pytest.mark.parametrize("mode", MODES)
def test_a_single_axis_takes_its_minimum_time(mode):
    transfer = min_time_transfer((1.0, 0.5), (4.0, -0.25), SMOOTH)
    for axis in (transfer, ((1.0, 0.5), (4.0, -0.25), SMOOTH)):
        (alone,) = synchronize([axis], mode)
        time = np.linspace(0.0, transfer.duration, 50)
        np.testing.assert_allclose(alone(time), transfer(time), rtol=1e-13)


def test_a_start_beyond_its_bounds_is_brought_inside_first():
    given = ((0.0, 5.0), 2.0, PLAIN)
    fast, slow = synchronize([given, (0.0, 40.0, PLAIN)])
    assert fast.duration == slow.duration == 22.0
    assert fast(3.0, 1) == pytest.approx(2.0, rel=1e-14)
    assert fast(np.linspace(3.0, 22.0, 99), 1).max() <= 2.0 * (1.0 + 1e-14)
    assert fast.end_state.tolist() == [2.0, 0.0, 0.0]


# Against others


def published(case):
    """Return one of the published problems: its duration, and one problem for each axis.

    Of order 2 where the jerk is infinite.
    """
    duration, axes = published_transfers()[case]
    orders = [3 if bounds[2][1] < inf else 2 for _, _, bounds in axes]
    return duration, [TransferProblem(start[:n], end[:n], bounds[:n])
                      for n, (start, end, bounds) in zip(orders, axes, strict=True)]  # fmt: skip


@pytest.mark.parametrize("case", [1, 3, 5, 7, 9, 11, 13, 17, 31, 41])
def test_published_durations(case):
    duration, problems = published(case)
    assert check_both(problems) == pytest.approx(duration, rel=1e-8), problems


def ruckigs_duration(problems):
    """Return ruckig's synchronised duration, None where it finds none."""
    ruckig = pytest.importorskip("ruckig")
    given = ruckig.InputParameter(len(problems))
    for side, name in (("start", "current"), ("end", "target")):
        states = zip(*(getattr(p, side) for p in problems), strict=True)
        for kind, values in zip(("position", "velocity", "acceleration"), states, strict=True):
            setattr(given, f"{name}_{kind}", list(values))
    for k, kind in enumerate(("velocity", "acceleration", "jerk")):
        setattr(given, f"max_{kind}", [p.bounds[k][1] for p in problems])
    trajectory = ruckig.Trajectory(len(problems))
    try:
        result = ruckig.Ruckig(len(problems)).calculate(given, trajectory)
    except ruckig.RuckigError:
        return None
    return trajectory.duration if result == ruckig.Result.Working else None


@pytest.mark.parametrize("case", [7, 13, 15, 35, 43])
def test_ruckig_itself_agrees_on_published_problems(case):
    """For 15, 35 and 43 the published duration is not that of the inputs listed."""
    _, problems = published(case)
    assert together(problems)[0].duration == pytest.approx(ruckigs_duration(problems), rel=1e-8)


def symmetric(rng):
    """Return a problem that ruckig can state, with states of rest among them."""
    v, a, jerk = map(float, 10.0 ** rng.uniform(-1.0, 1.0, 3))
    start, end = (
        (float(rng.normal() * size), *(float(rng.choice([0.0, x])) for x in rng.uniform(-1, 1, 2)))
        for size in (1.0, 10.0 ** rng.uniform(-1.0, 1.0))
    )
    bounds = ((-v, v), (-a, a), (-jerk, jerk))
    start, end = ((x, v * y, a * z) for x, y, z in (start, end))
    return TransferProblem(start, end, bounds).keeping()


def test_ruckig_finds_no_shorter_time_for_three_axes():
    """Ours may be shorter: proven by the motions. Where ruckig finds none at all, ours is sound."""
    rng, equal, shorter, none = np.random.default_rng(2), 0, 0, 0
    count = 2000 if SLOW else 150
    for _ in range(count):
        problems = [symmetric(rng) for _ in range(3)]
        theirs, ours = ruckigs_duration(problems), check_both(problems)
        if theirs is None:
            none += 1
            continue
        assert ours <= theirs * (1.0 + 1e-8), problems
        equal, shorter = equal + (ours >= theirs * (1.0 - 1e-8)), shorter + (ours < theirs * 0.99)
    assert equal >= 0.8 * count, (equal, shorter, none)
    assert equal + shorter + none == count


# Started or ended together


@given(problems=st.lists(transfer_problems(), min_size=1, max_size=4))
def test_started_together_each_takes_its_own_minimum_time(problems):
    for problem, axis in zip(problems, together(problems, "start"), strict=True):
        alone = problem.solve()
        np.testing.assert_array_equal(axis.breaks, alone.breaks)
        np.testing.assert_array_equal(axis.states, alone.states)


@given(problems=st.lists(transfer_problems(), min_size=1, max_size=4))
def test_ended_together_the_faster_ones_wait_at_rest(problems):
    problems = [from_rest(p) for p in problems]
    axes, end = together(problems, "end"), longest(problems)
    for problem, axis in zip(problems, axes, strict=True):
        alone = problem.solve()
        assert axis.end_time == pytest.approx(end, rel=1e-15), problems
        assert axis.start_time == pytest.approx(end - alone.duration, abs=1e-15 * end), problems
        assert axis(0.5 * axis.start_time) == problem.start[0]
        np.testing.assert_array_equal(axis.states, alone.states)


def test_an_axis_that_moves_at_its_start_cannot_wait():
    moving, slow = ((0.0, 0.5), 1.0, PLAIN), (0.0, 9.0, PLAIN)
    with pytest.raises(ValueError, match="axis 1 moves at its start and cannot wait: use mode="):
        synchronize([slow, moving], "end")
    turning = ((0.0, 0.0, 0.2), 1.0, SMOOTH)
    with pytest.raises(ValueError, match="axis 0 moves at its start and cannot wait"):
        synchronize([turning, slow], "end")
    (alone,) = synchronize([moving], "end")
    assert alone.start_time == 0.0


# Straight lines


def random_line(rng, order, count):
    """Return axes in motion along a line at both ends; the last one covers no distance."""
    starts = 10.0 * rng.normal(size=count)
    ends = starts + rng.normal(size=count) * 10.0 ** rng.uniform(-4.0, 4.0, count)
    starts[-1] = ends[-1]
    pairs = [random_transfer(rng, order).bounds for _ in range(count)]
    least = min(min(-low, high) / abs(span)
                for ((low, high), *_), span in zip(pairs, ends - starts, strict=True)
                if span)  # fmt: skip
    speeds = 0.7 * least * rng.choice([0.0, *rng.uniform(-1.0, 1.0, 3)], 2)
    rest = [0.0] * (order - 2)
    return [
        TransferProblem(
            (float(x), float(speeds[0] * (y - x)), *rest),
            (float(y), float(speeds[1] * (y - x)), *rest),
            bounds,
        )
        for x, y, bounds in zip(starts, ends, pairs, strict=True)
    ]


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(40 if SLOW else 8))
def test_positions_stay_on_the_line_within_the_limits(order, seed):
    rng = np.random.default_rng((31, order, seed))
    problems = random_line(rng, order, int(rng.integers(2, 6)))
    axes = together(problems, "straight-line")
    spans = np.array([p.end[0] - p.start[0] for p in problems])
    starts = np.array([p.start[0] for p in problems])
    leader = int(np.abs(spans).argmax())
    time = np.linspace(0.0, axes[0].duration, 201)
    share = (axes[leader](time) - starts[leader]) / spans[leader]
    for problem, axis, span, start in zip(problems, axes, spans, starts, strict=True):
        away = axis(time) - start - span * share
        rounding = 4e-16 * (abs(start) + abs(span) * np.abs(share).max())
        rounding += 4e-16 * abs(span / spans[leader]) * abs(starts[leader])
        assert np.abs(away).max() <= 4.0 * rounding, problems
        assert axis.violation(problem.limits) <= 1e-12, problems
        assert axis.duration == axes[0].duration
        assert axis.end_state[:2] == pytest.approx(problem.end[:2], rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(8))
def test_along_the_line_no_time_is_lost(order, seed):
    """It takes the time of the transfer of the path itself, bounds seen along it."""
    problems = random_line(np.random.default_rng((31, order, seed)), order, 3)[:2]
    spans = [p.end[0] - p.start[0] for p in problems]
    bounds = []
    for k in range(order):
        seen = [sorted(side / span for side in p.bounds[k])
                for p, span in zip(problems, spans, strict=True)]  # fmt: skip
        bounds.append((max(low for low, _ in seen), min(high for _, high in seen)))
    ends = ((at, *(x / spans[0] for x in state[1:]))
            for at, state in ((0.0, problems[0].start), (1.0, problems[0].end)))  # fmt: skip
    expected = min_time_transfer(*ends, Limits.from_bounds(bounds)).duration
    assert together(problems, "straight-line")[0].duration == pytest.approx(expected, rel=1e-9)
    assert expected >= longest(problems) * (1.0 - 1e-9)


def test_velocities_off_the_line_are_refused():
    across = ((0.0, 0.5), 1.0, PLAIN)
    for other in ((0.0, 2.0, PLAIN), ((0.0, -1.0), 2.0, PLAIN), ((0.0, 1.0 + 1e-6), 2.0, PLAIN)):
        with pytest.raises(
            ValueError, match=r"axis 0: start velocity = 0.5 leads off the straight"
        ):
            synchronize([across, other], "straight-line")
    synchronize([across, ((0.0, 1.0), 2.0, PLAIN)], "straight-line")
    with pytest.raises(ValueError, match=r"axis 1: start velocity = 0.1 .* expected 0.0"):
        synchronize([(0.0, 1.0, PLAIN), ((3.0, 0.1), 3.0, PLAIN)], "straight-line")
    with pytest.raises(ValueError, match=r"axis 0: end acceleration = 0.25 leads off"):
        synchronize([(0.0, (1.0, 0.0, 0.25), SMOOTH), (0.0, 9.0, SMOOTH)], "straight-line")


def test_a_straight_line_of_two_orders_needs_rest():
    moving = ((0.0, 0.5), 1.0, PLAIN)
    with pytest.raises(ValueError, match=r"axis 0 moves at its start or end: a straight line of"):
        synchronize([moving, (0.0, 1.0, SMOOTH)], "straight-line")


# Moves and S-curves

SNAP = Limits(velocity=2.0, acceleration=1.5, jerk=4.0, snap=30.0)
POP = Limits.from_bounds([3.0, 2.0, 6.0, 40.0, 300.0, 3000.0])
RATES = {"velocity": 2.0, "acceleration": 1.0, "deceleration": 3.0}


def some_axes():
    """Return motions from rest to rest of many kinds, each with its bounds, velocity first."""
    uneven = {**RATES, "acceleration_jerk": 3.0, "deceleration_jerk": 9.0}
    curve = [(-2.0, 2.0), (-3.0, 1.0), (-9.0, 9.0)]
    percent = s_curve_move(3.0, jerk_percent=0.5, **RATES)
    quintic = min_jerk_move(2.0, duration=1.5)
    return [
        (min_time_move(4.0, SNAP), pairs(SNAP)),
        (min_time_move(-1.5, POP, start=7.0), pairs(POP)),
        (min_time_move(1.0, Limits(velocity=0.5)), [(-0.5, 0.5)]),
        (min_time_transfer(1.0, 2.5, SMOOTH), pairs(SMOOTH)),
        (s_curve_move(5.0, **uneven), curve),
        (s_curve_move(-5.0, start=1.0, **uneven), [(-high, -low) for low, high in curve]),
        (percent, [(-2.0, 2.0), (-4.0, 4.0 / 3.0)]),
        (quintic, [(-quintic.peak(k), quintic.peak(k)) for k in (1, 2, 3)]),
        (min_time_move(0.0, SNAP, start=2.0), pairs(SNAP)),
    ]


def pairs(limits):
    return [limits.bounds(k) for k in range(1, limits.order + 1)]


def assert_kept(motion, original, bounds):
    """Assert ends, rest and bounds by values on a fine grid, highest derivative included."""
    assert motion.start_state[0] == pytest.approx(original.start_state[0], abs=1e-12)
    assert motion.end_state[0] == pytest.approx(original.end_state[0], abs=1e-12)
    times = np.union1d(np.linspace(motion.start_time, motion.end_time, 4001), motion.breaks)
    values = motion.evaluate(times[:-1]) if len(times) > 1 else motion.evaluate(times)
    for k, (low, high) in enumerate(bounds, start=1):
        if k > motion.order:
            break
        assert values[k].min() >= low - 1e-9 * abs(low), (k, values[k].min())
        assert values[k].max() <= high + 1e-9 * high, (k, values[k].max())
    assert motion.order >= len(bounds)
    assert abs(values[1, 0]) <= 1e-12 or len(bounds) == 1
    # the positions are the integral of the velocities
    inside = 0.5 * (times[1:] + times[:-1])
    step = np.diff(times)
    simpson = (motion(times[:-1], 1) + 4.0 * motion(inside, 1) + motion(times[1:], 1)) / 6.0
    distance = original.end_state[0] - original.start_state[0]
    assert float(simpson @ step) == pytest.approx(distance, abs=1e-3 * max(abs(distance), 1.0))


def test_moves_that_start_together_are_as_they_were():
    axes = some_axes()
    started = synchronize([axis for axis, _ in axes], "start")
    for motion, (axis, _) in zip(started, axes, strict=True):
        assert motion.start_time == 0.0
        assert motion.duration == axis.duration
        np.testing.assert_array_equal(motion.states, axis.states)


def test_a_start_time_of_its_own_is_dropped_at_the_start():
    late = s_curve_move(5.0, delay=2.0, acceleration_jerk=3.0, **RATES)
    [started] = synchronize([late], "start")
    assert (started.start_time, started.duration) == (0.0, pytest.approx(late.duration))


def test_moves_that_end_together_wait_first():
    axes = some_axes()
    latest = max(axis.duration for axis, _ in axes)
    for motion, (axis, bounds) in zip(
        synchronize([axis for axis, _ in axes], "end"), axes, strict=True
    ):
        assert motion.end_time == pytest.approx(latest, rel=1e-14)
        assert motion.duration == pytest.approx(axis.duration, rel=1e-13, abs=1e-14)
        assert motion(0.0) == pytest.approx(axis.start_state[0], abs=1e-12)
        assert_kept(motion, axis, bounds)


CHOSEN = [slice(3, 7), slice(0, 2), slice(4, 6), slice(None)]


@pytest.mark.parametrize("chosen", some(CHOSEN, 2), ids=str)
def test_moves_of_both_ends_together_keep_their_bounds(chosen):
    axes = some_axes()[chosen]
    longest_own = max(axis.duration for axis, _ in axes)
    for motion, (axis, bounds) in zip(synchronize([a for a, _ in axes]), axes, strict=True):
        assert motion.start_time == 0.0
        assert motion.duration == pytest.approx(longest_own, rel=1e-13)
        assert_kept(motion, axis, bounds)


@pytest.mark.parametrize("chosen", some(CHOSEN, 2), ids=str)
def test_moves_on_a_straight_line_are_one_scaled_move_within_all_bounds(chosen):
    axes = some_axes()[chosen]
    motions = synchronize([axis for axis, _ in axes], "straight-line")
    durations = {motion.duration for motion in motions}
    assert len(durations) == 1
    assert durations.pop() >= max(axis.duration for axis, _ in axes) * (1.0 - 1e-3)
    times = np.linspace(0.0, motions[0].duration, 501)
    fractions = []
    for motion, (axis, bounds) in zip(motions, axes, strict=True):
        assert_kept(motion, axis, bounds)
        span = axis.end_state[0] - axis.start_state[0]
        if span:
            fractions.append((motion(times) - axis.start_state[0]) / span)
    for fraction in fractions:
        np.testing.assert_allclose(fraction, fractions[0], atol=1e-12)


@pytest.mark.parametrize("limits", [SNAP, POP, Limits(1.0), SMOOTH], ids=[4, 6, 1, 3])
def test_under_the_same_limits_the_longest_move_is_the_line(limits):
    far, near = min_time_move(5.0, limits), min_time_move(-2.0, limits, start=1.0)
    long, short = synchronize([far, near], "straight-line")
    assert long.duration == short.duration == pytest.approx(far.duration, rel=1e-12)
    assert [m.end_state[0] for m in (long, short)] == pytest.approx([5.0, -1.0], abs=1e-12)


def test_a_line_takes_no_longer_than_the_fastest_move_within_all_bounds():
    wide = Limits(velocity=1.0, acceleration=9.0, jerk=90.0, snap=900.0)
    stiff = Limits(velocity=9.0, acceleration=9.0, jerk=2.0, snap=20.0)
    one, _ = synchronize([min_time_move(5.0, wide), min_time_move(4.0, stiff)], "straight-line")
    both = Limits(velocity=0.2, acceleration=9.0 / 5.0, jerk=0.5, snap=5.0)
    assert one.duration <= min_time_move(1.0, both).duration * (1.0 + 1e-3)


def test_orders_that_min_time_move_plans_can_be_given_by_their_ends():
    planned = synchronize([(0.0, 4.0, SNAP), ((1.0, 0.0), (2.5, 0.0, 0.0), SMOOTH)])
    slowest = min_time_move(4.0, SNAP).duration
    assert [axis.duration for axis in planned] == pytest.approx([slowest, slowest], rel=1e-14)


def test_what_moves_at_an_end_and_has_no_limits_takes_its_own_time():
    curve = {**RATES, "acceleration_jerk": 3.0, "deceleration_jerk": 9.0}
    passing = s_curve_move(5.0, final_velocity=1.0, **curve)
    rest = min_time_move(0.5, SNAP)
    fixed, stretched = synchronize([passing, rest])
    assert fixed.duration == passing.duration
    assert stretched.duration == pytest.approx(passing.duration, rel=1e-14)
    with pytest.raises(InfeasibleError, match="the axes have no duration in common"):
        synchronize([passing, min_time_move(50.0, SNAP)])
    with pytest.raises(ValueError, match="axis 0 moves at its start or end"):
        synchronize([passing, rest], "straight-line")
    moving = s_curve_move(5.0, start=(0.0, 1.0), **curve)
    with pytest.raises(ValueError, match="axis 0 moves at its start and cannot wait"):
        synchronize([moving, min_time_move(50.0, SNAP)], "end")


@pytest.mark.parametrize(
    "second",
    some([((0.0, 0.1), (6.0, 0.2), SNAP), ((0.0, 1.0), (1.0, 1.0), SMOOTH), (0.0, 0.5, POP)], 2),
)
def test_axes_of_order_4_that_move_at_an_end_take_a_duration_that_all_can(second):
    first = (0.0, 0.5), (4.0, 0.1, -0.2), SNAP
    slowest = max(min_time_transfer(*each).duration for each in (first, second))
    for motion, (start, end, limits) in zip(
        synchronize([first, second]), (first, second), strict=True
    ):
        assert motion.duration >= slowest * (1.0 - 1e-12)
        assert motion.violation(limits) <= 1e-9
        for state, wanted in ((motion.start_state, start), (motion.end_state, end)):
            wanted = (*np.atleast_1d(wanted), 0.0, 0.0, 0.0)[:3]
            np.testing.assert_allclose(state[:3], wanted, rtol=0, atol=1e-9)


# Errors


@pytest.mark.parametrize("mode", ["", "Both", "straight", None, 3])
def test_an_unknown_mode_is_refused(mode):
    with pytest.raises(ValueError, match=f"mode = {mode!r}: expected 'start', 'end', 'both' or"):
        synchronize([(0.0, 1.0, PLAIN)], mode)


@pytest.mark.parametrize("mode", MODES)
def test_no_axis_at_all_is_refused(mode):
    with pytest.raises(ValueError, match="transfers is empty: expected at least one axis"):
        synchronize([], mode)


@pytest.mark.parametrize("axis", [3.0, (0.0, 1.0), "abc", None, min_time_transfer])
def test_what_is_no_axis_is_refused(axis):
    with pytest.raises(TypeError, match=r"axis .*: expected what min_time_transfer returns, or"):
        synchronize([(0.0, 1.0, PLAIN), axis])


def test_errors_of_an_axis_are_those_of_a_transfer():
    with pytest.raises(InfeasibleError, match=r"end velocity = 3.0 is outside its bounds"):
        synchronize([(0.0, (1.0, 3.0), PLAIN)])
    with pytest.raises(ValueError, match="start position = nan: expected a finite number"):
        synchronize([(nan, 1.0, PLAIN)])
    with pytest.raises(TypeError, match=r"limits = 2\.0: expected Limits"):
        synchronize([(0.0, 1.0, 2.0)])


# What once failed


def test_an_axis_at_the_edge_of_its_durations_can_take_part():
    bounds = [
        (-6.475605176772254, 6.475605176772254),
        (-1.2166411940089952, 5.121542985471184),
        (-3.730756956482455, 3.730756956482455),
    ]
    there = (-0.518654604455596, 0.0, 5.121542985471184)
    axis = (there, there, Limits.from_bounds(bounds))
    slow, _ = synchronize([axis, (0.0, 1.0, Limits(1.0, 1.0))])
    assert slow.duration == pytest.approx(8.850549505, rel=1e-9)


def test_a_tiny_distance_back_is_a_motion_too():
    limits = Limits(velocity=13.0, acceleration=47.0, jerk=5.5)
    back, _ = synchronize([(0.0, -1e-13, limits), (0.0, 8000.0, limits)])
    assert back.peak("velocity") * back.duration == pytest.approx(1e-13, rel=1e-3)


def test_axes_that_end_together_but_for_rounding_need_not_wait():
    f, v = 5.167034084532541, 0.8108346533866836
    unit, scaled = Limits(1.0, 1.0), Limits(f, f)
    pair = synchronize([((0.0, v), 3.0, unit), ((0.0, v * f), 3 * f, scaled)], "end")
    assert pair[0].end_time == pytest.approx(pair[1].end_time, rel=1e-14)


# The short way


@pytest.mark.parametrize("kind", [tuple, list])
def test_states_and_limits_go_the_way_that_planned_transfers_go(kind, monkeypatch):
    def refuse(*_):
        raise AssertionError("the way of motions of other kinds")

    monkeypatch.setattr("jounce.shaping.transfers.synchronize.as_axis", refuse)
    given = [((0.0, 0.1 * k, 0.0), 0.3 * k + 1.0, SMOOTH) for k in range(7)]
    planned = synchronize([min_time_transfer(*each) for each in given])
    axes = synchronize([kind(each) for each in given])
    assert axes.planned == (SMOOTH,) * 7
    assert len({round(axis.duration, 12) for axis in axes}) == 1
    for axis, same in zip(axes, planned, strict=True):
        np.testing.assert_array_equal(axis.states, same.states)


def test_axes_of_unlike_kinds_are_planned_once(monkeypatch):
    planned = []

    def count(*given):
        planned.append(given)
        return min_time_transfer(*given)

    monkeypatch.setattr("jounce.shaping.transfers.synchronize.min_time_transfer", count)
    axes = synchronize([(0.0, 1.0, SMOOTH), min_time_move(3.0, SMOOTH)])
    assert len(planned) == 1
    assert axes[0].duration == pytest.approx(min_time_move(3.0, SMOOTH).duration, rel=1e-12)


def test_the_slowest_axis_of_those_that_end_together_stays_as_it_is():
    slow, fast = min_time_transfer(0.0, 9.0, SMOOTH), min_time_transfer(0.0, 1.0, SMOOTH)
    axes = synchronize([fast, slow], "end")
    assert axes[1] is slow
    assert axes[0].start_time == pytest.approx(slow.duration - fast.duration, rel=1e-14)


def test_an_axis_that_passes_its_end_takes_no_time_or_turns_back():
    """Beside one that takes 1e-17 s; `min_time_transfer` with a duration agrees."""
    passing = (0.0, 1.0, 0.0), (0.0, 1.0, 0.0), SMOOTH
    short = (0.0, 0.5, 0.3), (0.0, 0.5, 0.3 - 1e-17 * 3.0), SMOOTH
    for axes in ([passing, short], [min_time_transfer(*passing), min_time_transfer(*short)]):
        together = synchronize(axes)
        assert {axis.duration == 0.0 or axis.duration > 0.1 for axis in together} == {True}
