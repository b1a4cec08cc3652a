"""Scans and transfers onto moving targets: constant velocity where it is promised, bounds kept."""

from itertools import pairwise

import numpy as np
import pytest

from jounce.analysis import read_log
from jounce.plant import PID, Inertia, InertiaFeedforward, Ramp, ServoLoop, Sine
from jounce.shaping import (
    CommandFollower,
    Limits,
    Trajectory,
    follow_commands,
    min_time_move,
    min_time_transfer,
    scan_move,
    tracking_transfer,
)
from jounce.shaping.averaged import averaged

THIRD = Limits(velocity=2.0, acceleration=4.0, jerk=40.0)
LOOP = ServoLoop(Inertia(1.0), PID(100.0, 100.0, 20.0), InertiaFeedforward(1.0))


@pytest.mark.parametrize(
    "limits",
    [
        Limits(acceleration=4.0),
        THIRD,
        Limits(velocity=2.0, acceleration=4.0, jerk=40.0, snap=900.0),
        Limits(acceleration=(-3.0, 5.0), jerk=40.0),
    ],
    ids=repr,
)
@pytest.mark.parametrize("length", [10.0, -0.3])
def test_a_scan_is_straight_on_its_lines_and_within_bounds_between(limits, length):
    scan = scan_move(length, 1.5, limits, lines=3, start=1.0)
    for i, (begin, end) in enumerate(scan.lines):
        way = np.sign(length) * (-1) ** i
        times = np.linspace(begin, end, 50)[1:-1]
        np.testing.assert_allclose(scan(times, 1), 1.5 * way, rtol=1e-13)
        ends = [1.0, 1.0 + length] if i % 2 == 0 else [1.0 + length, 1.0]
        np.testing.assert_allclose(scan([begin, end]), ends, rtol=1e-12)
    assert scan.start_state[1:-1].tolist() == [0.0] * (limits.order - 1)
    assert np.abs(scan.end_state[1:]).max() == 0.0
    fine = np.linspace(0.0, scan.duration, 20001)
    for k in range(1, limits.order + 1):
        low, high = limits.bounds(k)
        values = scan(fine, k)
        assert values.max() <= high * (1 + 1e-12)
        assert values.min() >= low * (1 + 1e-12)
        if k < limits.order:  # continuous
            assert np.abs(np.diff(values)).max() <= 1.01 * scan.peak(k + 1) * fine[1]


def test_a_turn_is_the_fastest_change_of_velocity():
    scan = scan_move(10.0, 1.0, Limits(acceleration=2.0), lines=2)
    assert scan.lines[1, 0] - scan.lines[0, 1] == pytest.approx(1.0)  # 2·v/a
    assert scan.lines[0, 0] == pytest.approx(0.5)
    assert scan.duration == pytest.approx(0.5 + 10.0 + 1.0 + 10.0 + 0.5)


@pytest.mark.parametrize("limits", [Limits(velocity=2.0, acceleration=4.0), THIRD], ids=repr)
def test_tracking_is_the_transfer_seen_from_the_target(limits):
    rng = np.random.default_rng(3)
    for _ in range(50):
        x, v, position, velocity = rng.uniform(-1.9, 1.9, 4)
        onto = tracking_transfer((x, v), (position, velocity), limits)
        later = onto.duration + np.array([0.0, 0.1, 50.0])
        np.testing.assert_allclose(onto(later), position + velocity * later, atol=1e-10)
        np.testing.assert_allclose(onto(later, 1), velocity, atol=1e-12)
        assert float(onto(0.0)) == pytest.approx(x, abs=1e-12)
        assert float(onto(0.0, 1)) == pytest.approx(v, abs=1e-12)
        for k in range(1, limits.order + 1):
            assert onto.peak(k) <= limits.upper[k - 1] * (1 + 1e-9)
        for sooner in np.linspace(0.0, 0.999, 40)[1:] * onto.duration:  # never in time
            end = (position + velocity * sooner, velocity)
            with pytest.raises(ValueError, match="none that this transfer can take"):
                min_time_transfer((x, v), end, limits, duration=sooner)


def test_loops_follow_scans_tracks_dithers_and_sums():
    """With the right inertia fed forward the error is 0, but for what is added at time 0."""
    onto = tracking_transfer(0.0, (0.5, 0.004), THIRD)
    move, scan = min_time_move(1.0, THIRD), scan_move(1.0, 1.0, THIRD, lines=2)
    for command in (onto, scan, move + onto, onto + move, scan + onto + move):
        assert LOOP.respond(command, 0.01, duration=8.0).peak_error < 1e-12
    dithered = LOOP.respond(move + Sine(1e-3, 20.0), 0.01, duration=8.0)
    dither = LOOP.respond(Sine(1e-3, 20.0), 0.01, duration=8.0)
    np.testing.assert_allclose(dithered.error, dither.error, atol=1e-13)
    drift = LOOP.respond(Ramp(0.004, 0.5), 0.01, duration=8.0)
    both = LOOP.respond(onto + Sine(1e-3, 2.0) + Ramp(0.004, 0.5), 0.01, duration=8.0)
    alone = LOOP.respond(Sine(1e-3, 2.0), 0.01, duration=8.0)
    np.testing.assert_allclose(both.error, alone.error + drift.error, atol=1e-13)


@pytest.mark.parametrize("limits", [Limits(velocity=2.0, acceleration=4.0), THIRD], ids=repr)
def test_a_command_file_is_followed(limits, tmp_path):
    path = tmp_path / "command.csv"
    path.write_text("t;r\n2,0;0,5\n2,5;1,5\n2,73;1,0\n4,0;-1,0\n")
    times, positions = read_log(path)
    follower = CommandFollower(limits, dt=0.05)
    followed = follow_commands(follower, times, positions)
    assert followed.start_time == 2.0
    np.testing.assert_array_equal(followed([2.0, 2.5, 2.55]) > 0.5, [False, False, True])
    held = np.repeat([0.5, 1.5, 1.0, -1.0], [10, 5, 25, 60])  # 2.73 comes in force at 2.75
    run = follower.run(held, initial=(0.5,))
    for k in range(limits.order):
        np.testing.assert_allclose(followed(2.0 + run.time, k), run.states[k], atol=1e-11)
    assert followed.end_state[:2] == pytest.approx([-1.0, 0.0], abs=1e-12)
    for k in range(1, limits.order + 1):
        assert followed.peak(k) <= limits.upper[k - 1] * (1 + 1e-9)
    assert LOOP.respond(followed, 0.01).peak_error < 1e-12


@pytest.mark.parametrize(
    "within",
    [
        Limits(2.0, 4.0, 20.0, snap=300.0),
        Limits(2.0, (-4.0, 3.0), (-20.0, 30.0), (-400.0, 300.0), crackle=2e4),
    ],
    ids=["snap", "crackle"],
)
def test_a_command_file_is_followed_within_limits_of_any_order(within):
    """The follower's motion averaged: by quadrature; later by what the averages take."""
    times, positions = [2.0, 2.5, 2.73, 4.0], [0.5, 1.5, 1.0, -1.0]
    bounds = [within.bounds(k) for k in range(1, within.order + 1)]
    follower = CommandFollower(Limits.from_bounds(bounds[:3]), dt=0.05)
    bare = follow_commands(follower, times, positions)
    smooth = follow_commands(follower, times, positions, within=within)
    assert smooth.order == within.order
    assert (smooth.start_time, smooth.start_state.tolist()[:4]) == (2.0, [0.5, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(smooth.end_state, [-1.0, *[0.0] * within.order], atol=1e-13)
    windows = [
        (below[1] - below[0]) / min(high, -low) for below, (low, high) in pairwise(bounds[2:])
    ]
    assert smooth.duration == pytest.approx(bare.duration + sum(windows), rel=1e-12)
    for k, (low, high) in enumerate(bounds, start=1):
        least, most = smooth.extremes(k)
        assert low * (1 + 1e-9) <= least <= most <= high * (1 + 1e-9)
    at = np.linspace(2.0, smooth.end_time, 40)
    nodes, weights = np.polynomial.legendre.leggauss(100)
    expected = np.zeros(len(at))
    late = [0.5 * window * (1.0 + nodes) for window in windows]
    grid = np.add.outer(late[0], late[1]) if len(windows) == 2 else late[0]
    share = np.multiply.outer(weights, weights) if len(windows) == 2 else weights
    for i, t in enumerate(at):
        expected[i] = (share * bare(t - grid)).sum() / share.sum()
    np.testing.assert_allclose(smooth(at), expected, rtol=0.0, atol=1e-6)
    assert LOOP.respond(smooth, 0.01).peak_error < 1e-12


def test_an_average_of_a_ramp_lags_by_half_the_window():
    ramp = Trajectory([1.0, 2.0], [[3.0, 4.0, 0.0]]).delay(0.5)
    mean = averaged(ramp, 0.25)
    at = np.array([-3.0, 1.5, 1.6, 2.7, 90.0])
    np.testing.assert_allclose(mean(at), ramp(at - 0.125), rtol=1e-14)
    for window in (0.0, -1.0, np.nan, 1e-320, 1e300):
        with pytest.raises(ValueError, match=r"window = .*expected"):
            averaged(ramp, window)


def test_one_command_is_a_point():
    still = follow_commands(CommandFollower(THIRD, dt=0.1), [3.0], [0.7])
    assert (still.start_time, float(still(3.05)), still.end_state[0]) == (3.0, 0.7, 0.7)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: tracking_transfer(0.0, (1.0, 2.0), THIRD), "cannot catch up"),
        (lambda: tracking_transfer(0.0, 1.0, THIRD), r"expected \(position, velocity\)"),
        (lambda: scan_move(1.0, 3.0, THIRD), "velocity = 3.0 with limits from -2.0 to 2.0"),
        (lambda: scan_move(0.0, 1.0, THIRD), "length = 0.0"),
        (lambda: scan_move(1.0, 1.0, Limits(velocity=2.0)), "limits of order 1"),
        (lambda: scan_move(1.0, 1.0, THIRD, lines=0), "lines = 0"),
        (
            lambda: follow_commands(CommandFollower(THIRD, dt=0.1), [1.0, 1.0], [1.0, 2.0]),
            "increasing times",
        ),
        (
            lambda: follow_commands(
                CommandFollower(THIRD, dt=0.1), [0.0], [1.0], within=Limits(1.0, crackle=9.0)
            ),
            "snap from -inf to inf: expected a bound in both directions, as the crackle has",
        ),
    ],
)
def test_what_cannot_be_is_told_in_one_line(ask, words):
    with pytest.raises(ValueError, match=words) as refusal:
        ask()
    assert "\n" not in str(refusal.value)


def test_a_target_is_caught_at_any_order():
    for order in (2, 3, 4, 5):
        limits = Limits.from_bounds((10.5, 10.5, 42.0, 600.0, 2e4)[:order])
        found = tracking_transfer(0.0, (3.5, 0.1), limits)
        later = np.linspace(found.duration, found.duration + 5.0, 7)
        assert np.abs(found(later) - (3.5 + 0.1 * later)).max() < 1e-10
        assert found.trajectory.violation(limits) < 1e-9
