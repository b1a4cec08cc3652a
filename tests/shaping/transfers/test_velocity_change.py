"""The fastest change of velocity and acceleration: linear programs, and identities."""

import os

import numpy as np
import pytest
from hypothesis import given
from references import assert_sound_transfer, least_duration
from strategies import TransferProblem, random_transfer, transfer_problems

from jounce.shaping import InfeasibleError, Limits, velocity_transfer

SLOW = os.environ.get("JOUNCE_TIER") == "slow"


def unbounded_velocity(problem):
    """Return the problem without bounds of velocity, which a change does not look at."""
    return TransferProblem(problem.start, problem.end, (None, *problem.bounds[1:]))


def change_of(problem):
    acceleration = problem.end[2] if len(problem.end) == 3 else 0.0
    return velocity_transfer(
        problem.start, problem.end[1], problem.limits, acceleration=acceleration
    )


@given(problem=transfer_problems())
def test_it_leads_to_the_end_within_the_bounds(problem):
    problem = unbounded_velocity(problem)
    change = change_of(problem)
    if change.duration > 0.0:
        end = (float(change.end_state[0]), *problem.end[1:])
        assert_sound_transfer(TransferProblem(problem.start, end, problem.bounds), change)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(6 if SLOW else 2))
def test_no_change_that_a_linear_program_finds_is_faster(order, seed):
    """To it velocity is what position is to a transfer, one order less."""
    problem = random_transfer(np.random.default_rng((11, seed)), order)
    below = TransferProblem(problem.start[1:], problem.end[1:], problem.bounds[1:])
    change = change_of(unbounded_velocity(problem))
    if order == 2:
        gain, pair = problem.end[1] - problem.start[1], problem.bounds[1]
        assert change.duration == pytest.approx(max(gain / side for side in pair), rel=1e-14)
        return
    least = least_duration(below, 1.2 * change.duration)
    assert 0.97 * least <= change.duration <= 1.0001 * least, problem


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_mirrored(order, seed):
    problem = unbounded_velocity(random_transfer(np.random.default_rng(seed), order))
    there, back = change_of(problem), change_of(problem.mirrored())
    assert back.durations.tolist() == there.durations.tolist()
    assert back.states.tolist() == (-there.states).tolist()


def test_an_end_that_builds_up_acceleration_beyond_the_bound_is_refused():
    limits = Limits(velocity=1.0, acceleration=2.0, jerk=1.0)
    with pytest.raises(InfeasibleError, match="cannot be reached within the velocity bound"):
        velocity_transfer((0.0, 0.0, 0.0), -0.9, limits, acceleration=1.0)


def test_nothing_to_change():
    smooth = velocity_transfer((7.0, 1.0, 0.5), 1.0, Limits(acceleration=1.0, jerk=1.0),
                               acceleration=0.5)  # fmt: skip
    stepping = velocity_transfer((7.0, 1.0), 1.0, Limits(acceleration=1.0))
    for change in (smooth, stepping):
        assert (change.duration, float(change.end_state[0])) == (0.0, 7.0)


@pytest.mark.parametrize(
    ("gain", "duration", "peak", "hold"),
    [(2.0, 3.0, 1.0, 1.0), (1.0, 2.0, 1.0, 0.0), (0.25, 1.0, 0.5, 0.0), (-2.0, 3.0, -1.0, 1.0)],
)
def test_from_rest_it_is_the_s_curve(gain, duration, peak, hold):
    """MEI, "S-Curve Jerk Algorithm": acceleration 1 and jerk 1, held from a gain of 1 on."""
    change = velocity_transfer(0.0, gain, Limits(acceleration=1.0, jerk=1.0))
    held = change.durations[change.states[:, 3] == 0.0].sum()
    assert (change.duration, change.states[1, 2], held) == (duration, peak, hold)
    assert change.end_state[0] == pytest.approx(0.5 * gain * duration, rel=1e-15)


@given(problem=transfer_problems())
def test_plain_numbers_go_at_once_where_others_go(problem):
    """A change that is relative, or to numbers of another kind, is converted and checked first."""
    position, velocity, *rest = problem.start
    low, high = problem.limits.bounds(1)
    aim = min(max(problem.end[1], low), high)
    try:
        change = velocity_transfer(problem.start, aim, problem.limits)
    except (InfeasibleError, ValueError) as error:
        with pytest.raises(type(error)):
            velocity_transfer(problem.start, np.float32(0.0) + np.float64(aim), problem.limits)
        return
    start = np.array([position, velocity, *rest])
    slow = velocity_transfer(start, np.array(aim), problem.limits, acceleration=0)
    np.testing.assert_array_equal(change.states, slow.states)
    np.testing.assert_array_equal(change.end_state, slow.end_state)
    assert change.inside_after == slow.inside_after


def test_plain_numbers_are_not_checked_twice(monkeypatch):
    def refuse(*_):
        raise AssertionError("checked again")

    monkeypatch.setattr("jounce.shaping.transfers.transfer.Problem", refuse)
    change = velocity_transfer((0.0, 1.0, 0.0), 3.0, Limits(acceleration=1.0, jerk=1.0))
    assert change.duration == pytest.approx(3.0, rel=1e-14)
