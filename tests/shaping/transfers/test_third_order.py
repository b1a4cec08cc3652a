"""The profiles of order 3 that go furthest in their time: identities, and a linear program."""

from itertools import pairwise
from math import inf

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import assert_sound_transfer, reachable_distances
from strategies import random_transfer, transfer_problems

from jounce.shaping.transfers.jerk_profile import ramp
from jounce.shaping.transfers.third_order import Family, quadratic

PARTS = st.floats(0.0, 1.0, width=32)
NUMBERS = st.integers(-600, 600).map(lambda number: number / 64.0)
PROBLEMS = transfer_problems(orders=(3,))


def parameters(arc, count=7):
    """Return parameters along an arc, its ends included, as far as they are finite."""
    last = arc.last if abs(arc.last) < inf else arc.first + (4.0 if arc.last > 0.0 else -4.0)
    return np.linspace(arc.first, last, count).tolist()


def size(problem, duration):
    """Return the size of the distances covered, the unit of their rounding."""
    speed = max(abs(problem.start[1]), abs(problem.end[1]))
    power = max(abs(problem.start[2]), abs(problem.end[2]))
    jerk = max(map(abs, problem.bounds[2]))
    return duration * (speed + duration * (power + duration * jerk)) + 1e-6


# Building blocks


@given(v=NUMBERS, a=NUMBERS, end=NUMBERS)
def test_a_ramp_of_acceleration(v, a, end):
    jerk = 0.7 if end >= a else -0.3
    t = (end - a) / jerk
    distance, velocity = ramp(v, a, end, jerk)
    assert distance == pytest.approx(v * t + a * t**2 / 2 + jerk * t**3 / 6, rel=1e-9, abs=1e-9)
    assert velocity == pytest.approx(v + a * t + jerk * t**2 / 2, rel=1e-12, abs=1e-11)


@given(a=st.floats(0.01, 9.0), b=NUMBERS, c=NUMBERS)
def test_roots_of_a_quadratic_have_all_their_digits(a, b, c):
    roots = sorted(quadratic(a, b, c))
    with mpmath.workdps(60):
        exact = mpmath.mpf(b) ** 2 - 4 * mpmath.mpf(a) * mpmath.mpf(c)
        near_double = abs(exact) <= 1e-9 * b * b
        if exact < 0 or near_double:
            assert near_double or roots == []
            return
        sides = [(-b + sign * mpmath.sqrt(exact)) / (2 * mpmath.mpf(a)) for sign in (-1, 1)]
    assert sorted(set(roots)) == pytest.approx(sorted({float(side) for side in sides}), rel=1e-6)


def test_small_roots_do_not_cancel():
    assert sorted(quadratic(1.0, -1e9, 1.0)) == pytest.approx([1e-9, 1e9], rel=1e-15)
    assert sorted(quadratic(1.0, 1e9, 1.0)) == pytest.approx([-1e9, -1e-9], rel=1e-15)
    assert quadratic(2.0, 0.0, 0.0) == (0.0,)


# Arcs


@given(problem=PROBLEMS)
def test_members_of_every_arc_lead_to_the_end_within_the_bounds(problem):
    family = Family(problem.task)
    for arc in family.arcs():
        for s in parameters(arc, 5):
            profile = family.profile(arc.kind, s)
            distance = family.distance(profile)
            if not profile.duration > 0.0:
                continue
            moved = type(problem)(problem.start, (distance, *problem.end[1:]), problem.bounds)
            trajectory = moved.trajectory(family.pieces(profile, 0.0, distance))
            assert trajectory.duration == pytest.approx(profile.duration, rel=1e-12, abs=1e-14)
            assert_sound_transfer(moved, trajectory)


@given(problem=PROBLEMS)
def test_along_every_arc_the_duration_grows(problem):
    family = Family(problem.task)
    for arc in family.arcs():
        durations = [family.profile(arc.kind, s).duration for s in parameters(arc)]
        slack = 1e-13 * max(durations)
        assert all(before <= after + slack for before, after in pairwise(durations)), (problem, arc)


@pytest.mark.parametrize("seed", range(60))
def test_the_slope_is_that_of_distance_by_duration(seed):
    problem = random_transfer(np.random.default_rng((10, seed)))
    family = Family(problem.task)
    for arc in family.arcs():
        for s, following in pairwise(parameters(arc, 60)):
            middle = 0.5 * (s + following)
            members = [family.profile(arc.kind, x) for x in (s, middle, following)]
            distances, slopes, _ = zip(*map(family.travel, members), strict=True)
            time = members[2].duration - members[0].duration
            slack = abs(slopes[2] - slopes[0]) + 1e-3 * max(map(abs, slopes))
            rounding = 1e-11 * size(problem, members[2].duration)
            error = distances[2] - distances[0] - slopes[1] * time
            assert abs(error) <= slack * time + rounding, (problem, arc, s)


@given(problem=PROBLEMS)
def test_between_turning_points_the_distance_is_monotone(problem):
    family = Family(problem.task)
    for arc in family.arcs():
        grid = parameters(arc, 41)
        turns = family.turning_points(arc.kind)
        for s in turns:
            if min(grid) < s < max(grid):
                profile = family.profile(arc.kind, s)
                fastest = size(problem, profile.duration) / max(profile.duration, 1e-3)
                assert abs(family.travel(profile)[1]) <= 1e-9 * fastest, (problem, arc, s)
        for s, following in pairwise(grid):
            if any(min(s, following) <= turn <= max(s, following) for turn in turns):
                continue
            one, other = (family.profile(arc.kind, x) for x in (s, following))
            if other.duration - one.duration > 1e-12 * other.duration:
                slopes = [family.travel(profile)[1] for profile in (one, other)]
                assert slopes[0] * slopes[1] >= -1e-12, (problem, arc, s)


# Members of a duration


@given(problem=PROBLEMS, part=PARTS)
def test_lasting_is_the_inverse_of_the_duration(problem, part):
    family = Family(problem.task)
    for arc in family.arcs():
        first, *_, last = parameters(arc)
        profile = family.profile(arc.kind, first + part * (last - first))
        again = family.lasting(profile.duration)
        assert again is not None, (problem, arc, part)
        assert again.duration == pytest.approx(profile.duration, rel=1e-12, abs=1e-14)
        rounding = 1e-11 * size(problem, profile.duration)
        assert family.distance(again) == pytest.approx(family.distance(profile), abs=rounding)


@given(problem=PROBLEMS, part=PARTS)
def test_beyond_every_limit_the_family_goes_on(problem, part):
    """It cruises at the bound, or goes ever higher where there is none."""
    family = Family(problem.task)
    longest = max(family.limits_of_duration())
    duration = longest * (1.0 + part) + 0.01
    profile = family.lasting(duration)
    assert profile.duration == pytest.approx(duration, rel=1e-12)
    if problem.bounds[0]:
        assert profile.cruise == pytest.approx(duration - longest, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_no_motion_of_a_linear_program_goes_further(seed):
    problem = random_transfer(np.random.default_rng((5, seed)))
    family = Family(problem.task)
    marks = sorted(family.limits_of_duration())
    for duration in (0.9 * marks[0], *(np.array([0.1, 1.0, 3.0]) + marks[0])):
        profile = family.lasting(float(duration))
        if profile is None:
            assert reachable_distances(problem, duration) is None, (problem, duration)
            continue
        switches = np.cumsum([d for d, _ in family.pieces(profile, 0.0, 0.0)])[:-1]
        lowest, highest = reachable_distances(problem, duration, switches=switches)
        slack = 2e-3 * (highest - lowest) + 1e-9
        assert family.distance(profile) == pytest.approx(highest, abs=slack), (problem, duration)


# Members of a distance


@given(problem=PROBLEMS)
def test_solutions_cover_the_distance(problem):
    family = Family(problem.task)
    for profile in family.solutions():
        rounding = 1e-13 * size(problem, profile.duration)
        assert family.distance(profile) == pytest.approx(problem.task.distance, abs=rounding)
        if profile.duration > 1e-6:
            pieces = family.pieces(profile, *(s[0] for s in (problem.start, problem.end)))
            assert_sound_transfer(problem, problem.trajectory(pieces))


@pytest.mark.parametrize("seed", range(30))
def test_there_are_as_many_solutions_as_the_distance_is_passed(seed):
    problem = random_transfer(np.random.default_rng((6, seed)))
    family = Family(problem.task)
    found = sorted(profile.duration for profile in family.solutions())
    times = np.linspace(0.0, 1.47 * max([*found, *family.limits_of_duration()]), 3001).tolist()
    members = [(t, family.lasting(t)) for t in times]
    errors = [(t, p and family.distance(p) - problem.task.distance) for t, p in members]
    passed = [(t, u) for (t, e), (u, f) in pairwise(errors) if e and f and e * f < 0.0]
    assert len(found) == len(passed), problem
    for duration, (before, after) in zip(found, passed, strict=True):
        assert before <= duration <= after, problem
