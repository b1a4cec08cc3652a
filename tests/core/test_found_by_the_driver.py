"""Problems at which the random driver once failed; motions are run on in exact fractions."""

from fractions import Fraction
from math import inf

import pytest

from jounce.core import NO_DURATION, RANGE, Follower, possible_durations, transfer_lasting

M = 1.7976931348623157e308

LASTING = [  # ramps at the end shorter than what rounding leaves of the duration
    ((0.0, 0.0, 0.0), (0.0, 0.0, -0.5), (-2.5e-15, 4.2e-16, -1, 1, -3.9e46, 3.9e46), 0.2268),
    ((0.0, 0.0, 1.0), (0.0, 0.0, 7.3e-37), (-2.1, 1, -2e46, 2e45, -9e42, 9e42), 0.2164555),
    ((3.5e-39, 0.0, -3.3e-10), (0.0, 0.0, 0.0), (-inf, inf, -inf, inf, -1, 1), 0.1548341707),
    ((8e-32, 0.0, -1.0), (0.0, 0.0, 0.0), (-8e-11, 9e-12, -1, 1, -2.9e10, 2.9e10), 0.2914),
    ((0.0, 0.0, 1.0), (-4.4e-40, 0.0, 1.0), (-362.0, 565.0, -7.2, 1, -1.5e16, 1.5e15), 0.44),
    ((0.0, 5.8e-58, 1.0), (4e-57, 0.0, 0.0), (-M, M, -1, 1, -5e15, 5e15), 0.43305725136563233),
    (  # the mean of two motions 1e31 times as fast as itself
        (3.979484967886432e-42, 2.5662383686396928e-44, 1.0981554889815728e21),
        (0.0, -3.9934772909748471e-56, 7.1768993493564027e-46),
        (-M, inf, -7e48, 6.7e48, -6.1128967691480925e42, 6.1128967691480925e42),
        0.44113032720533818,
    ),
]


def run_on(state, duration):
    """Return position, velocity and acceleration after a time under constant jerk."""
    x, v, a, j = map(Fraction, state)
    t = Fraction(duration)
    return x + (v + (a / 2 + j * t / 6) * t) * t, v + (a + j * t / 2) * t, a + j * t


@pytest.mark.parametrize(("start", "end", "bounds", "duration"), LASTING)
def test_pieces_follow_one_another_and_last_as_long_as_asked(start, end, bounds, duration):
    motion = transfer_lasting(start, end, bounds, duration)
    _, states, durations, _ = motion.arrays()
    pieces = states[-len(durations) :]
    assert sum(map(Fraction, durations)) == pytest.approx(Fraction(duration), rel=1e-14)
    peaks = [
        max(
            max(abs(piece[k]), abs(run_on(piece, t)[k]))
            for piece, t in zip(pieces, durations, strict=True)
        )
        for k in range(3)
    ]
    for piece, t, there in zip(pieces, durations, [*pieces[1:], motion.end_state], strict=True):
        for k, value in enumerate(run_on(piece, t)):
            assert abs(value - Fraction(there[k])) <= peaks[k] * Fraction(1e-9)


def test_a_duration_that_only_rounding_allows_is_refused_and_never_another_one_taken():
    start, end = (0.0, -1.0, 0.0), (8.6441081719082773e-09, -1.0, 0.0)
    bounds = (-26.47, 4.78, -1.4177867060877031e-06, 3.8375763601555077e-07, -246953.0, 178783.0)
    for low, _ in possible_durations(start, end, bounds):
        motion = transfer_lasting(start, end, bounds, low)
        assert motion == NO_DURATION or motion.duration == pytest.approx(low, rel=1e-12)
    assert transfer_lasting(start, end, bounds, 1.7371745391127092e-11) == NO_DURATION


def test_a_way_inside_too_short_for_numbers_beside_the_duration_is_out_of_range():
    start, end = (0.0, -1.0, -4.9e34), (-9.4e-17, -0.34651249053624322, 0.0)
    bounds = (-0.69302498107248645, 1.0, -3.1e-42, 4.9e-43, -7.4e-52, 9.5e-53)
    assert transfer_lasting(start, end, bounds, 3.1367207394124645e284) == RANGE


def test_a_follower_at_a_command_too_far_off_for_digits_brakes_within_its_bounds():
    follower = Follower((-1.0, 1.0, -1.0, 1.0), 0.046143613157898729, inf, 0.0, 0)
    far = -6.5023810460863347e40
    state = follower.step((far, -1.0), far, 0.0)
    assert state[1] == pytest.approx(-1.0 + 0.046143613157898729, rel=1e-12)


def test_a_follower_far_off_under_hardly_bounded_jerk_keeps_its_velocity_bound():
    bound, jerk = 5.1836904379819812e-20, 5.675284124122148e29
    follower = Follower((-bound, bound, -inf, inf, -jerk, jerk), 0.01, inf, 0.0, 0)
    state = (-5.6528524559148638e22, 0.0, 1.0)
    for _ in range(20):
        state = follower.step(state, 1.0, 0.0)
        assert -bound * 1.000001 <= state[1] <= bound * 1.000001
