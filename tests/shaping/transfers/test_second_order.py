"""The profiles of order 2 that go furthest in their time: identities, and a linear program."""

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import assert_sound_transfer, can_take, reachable_distances
from strategies import TransferProblem, random_transfer, transfer_problems

from jounce.shaping.transfers.second_order import Family

PARTS = st.floats(0.0, 1.0, width=32)


def shortest(family):
    """Return the duration at which the family begins."""
    return next(iter(family.limits_of_duration()))


def scale(family, duration):
    """Return the size of the distances covered, the unit of their rounding."""
    task = family.task
    return duration * (max(abs(task.v0), abs(task.v1)) + duration * (task.a_max - task.a_min))


@given(problem=transfer_problems(orders=(2,)), part=PARTS)
def test_distance_changes_with_duration_by_the_peak_velocity(problem, part):
    """For a profile stretched by dt the peak is held dt longer, and the rest stays."""
    family = Family(problem.task)
    duration = shortest(family) + 0.1 + 5.0 * part
    step = 1e-4 * duration
    before, here, after = (family.lasting(duration + k * step) for k in (-1, 0, 1))
    slope = (family.distance(after) - family.distance(before)) / (2.0 * step)
    bend = 1.0 / (1.0 / problem.task.a_max - 1.0 / problem.task.a_min)
    assert slope == pytest.approx(here.peak, abs=bend * step), (problem, duration)


@given(problem=transfer_problems(orders=(2,)), part=PARTS)
def test_lasting_has_its_duration(problem, part):
    family = Family(problem.task)
    duration = shortest(family) * (1.0 + part) + part
    profile = family.lasting(duration)
    task = problem.task
    ramps = [(profile.peak - task.v0) / task.a_max, (task.v1 - profile.peak) / task.a_min]
    speed = max(map(abs, (task.v0, task.v1, profile.peak)))
    rounding = 1e-15 * speed * (1.0 / task.a_max - 1.0 / task.a_min)
    assert min(*ramps, profile.cruise) >= -rounding
    assert sum(ramps) + profile.cruise == pytest.approx(duration, rel=1e-13, abs=rounding)
    assert profile.duration == pytest.approx(duration, rel=1e-13, abs=rounding)
    assert profile.peak <= problem.task.v_max
    assert profile.cruise == 0.0 or profile.peak == problem.task.v_max


@given(problem=transfer_problems(orders=(2,)))
def test_no_profile_is_shorter_than_the_change_of_velocity(problem):
    family = Family(problem.task)
    gain = problem.end[1] - problem.start[1]
    (low, high), least = problem.bounds[1], shortest(family)
    assert least == pytest.approx(max(gain / low, gain / high), rel=1e-14)
    if gain:
        assert family.lasting(0.999 * least) is None


@given(problem=transfer_problems(orders=(2,)))
def test_solutions_cover_the_distance(problem):
    family = Family(problem.task)
    stop = 1.0 + family.least**2 / min(problem.task.a_max, -problem.task.a_min)
    for profile in family.solutions():
        rounding = 1e-13 * scale(family, profile.duration) + 1e-14 * stop
        assert family.distance(profile) == pytest.approx(problem.task.distance, abs=rounding)


@pytest.mark.parametrize("seed", range(30))
def test_there_are_as_many_solutions_as_the_distance_is_passed(seed):
    problem = random_transfer(np.random.default_rng(seed), 2)
    problem = TransferProblem(problem.start, (problem.end[0] / 8.0, problem.end[1]), problem.bounds)
    family = Family(problem.task)
    found = sorted(profile.duration for profile in family.solutions())
    times = np.linspace(
        1.00001 * shortest(family), 2.0 * max([*found, shortest(family) + 1.0]), 4001
    )
    errors = [family.distance(family.lasting(t)) - problem.task.distance for t in times.tolist()]
    passed = np.flatnonzero(np.diff(np.sign(errors)))
    assert len(found) == len(passed), problem
    for duration, i in zip(found, passed, strict=True):
        assert times[i] * (1.0 - 1e-12) <= duration <= times[i + 1], problem


@pytest.mark.parametrize("seed", range(8))
def test_no_motion_of_a_linear_program_goes_further(seed):
    problem = random_transfer(np.random.default_rng((2, seed)), 2)
    family = Family(problem.task)
    for duration in shortest(family) + np.array([0.3, 1.0, 3.0]):
        profile = family.lasting(float(duration))
        switches = np.cumsum([d for d, _ in family.pieces(profile, 0.0, 0.0)])[:-1]
        _, highest = reachable_distances(problem, duration, switches=switches)
        slack = 1e-6 * scale(family, duration)
        assert family.distance(profile) == pytest.approx(highest, abs=slack), (problem, duration)


@given(problem=transfer_problems(orders=(2,)))
def test_pieces_are_sound(problem):
    family = Family(problem.task)
    for profile in family.solutions():
        if profile.duration > 0.0 and -profile.peak < -(problem.bounds[0] or (-inf,))[0]:
            pieces = family.pieces(profile, problem.start[0], problem.end[0])
            assert_sound_transfer(problem, problem.trajectory(pieces))


def test_both_peaks_can_be_profiles():
    """From −1 to −1 the furthest up go w² − 1: between the two it is too far down."""
    problem = TransferProblem((0.0, -1.0), (-0.75, -1.0), ((-3.0, 3.0), (-1.0, 1.0)))
    found = list(Family(problem.task).solutions())
    assert [p.peak for p in found] == pytest.approx([-0.5, 0.5], rel=1e-15)
    assert [p.duration for p in found] == pytest.approx([1.0, 3.0], rel=1e-15)
    assert [can_take(problem, t) for t in (0.98, 1.02, 2.98, 3.02)] == [True, False, False, True]
