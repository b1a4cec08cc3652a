"""The half problem from outside: bounds between nodes, end conditions, duality, refinement."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly
from scipy.optimize import brentq, linprog
from strategies import MAGNITUDES, bound_lists

from jounce.shaping import Limits, min_time_move, switch_fractions
from jounce.shaping.optimal.half_problem import HalfProblem, HalfProgram, duration_of

FEW = settings(max_examples=max(8, settings.default.max_examples // 4))
FEASIBLE = 1e-8  # of a bound: what HiGHS may exceed it by, and more
OPTIMAL = 1e-8  # of the distance


def closed_form(distance, limits):
    return min_time_move(distance, limits, method="closed-form")


def problem_of(bounds, distance: float = 1.0, **options) -> HalfProblem:
    limits = Limits.from_bounds(bounds)
    return HalfProblem.make(distance, limits, closed_form(distance, limits), **options)


def mesh(seed: int, cells: int = 12):
    """Return uneven nodes from 0 to 1."""
    rng = np.random.default_rng(seed)
    nodes = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, cells))])
    return nodes / nodes[-1]


def motion(nodes, inputs, order: int) -> list[PPoly]:
    """Return position and its derivatives below n from rest, integrated by scipy."""
    return [PPoly(inputs[None, :], nodes).antiderivative(order - k) for k in range(order)]


SEEDS = st.integers(0, 1000)
HALVES = st.floats(0.8, 1.2)
PROBLEMS = bound_lists(4, 6).map(problem_of)


# The problem


@FEW
@given(bounds=bound_lists(4, 7), distance=st.floats(1e-3, 1e3))
def test_bounds_and_peaks_are_in_units_of_the_closed_form(bounds, distance):
    limits = Limits.from_bounds(bounds)
    closed = closed_form(distance, limits)
    problem = HalfProblem.make(distance, limits, closed)
    half = 0.5 * closed.duration
    assert problem.order == len(bounds)
    assert (problem.lower[0], problem.upper[0]) == (-inf, inf)
    for k, bound in enumerate(bounds, start=1):
        expected = (bound or inf) * half**k / distance
        assert problem.upper[k] == pytest.approx(expected, rel=1e-11)
        assert problem.lower[k] == -problem.upper[k]
        assert problem.peaks[k] == pytest.approx(closed.peak(k) * half**k / distance, rel=1e-11)
        assert problem.peaks[k] <= problem.upper[k] * (1.0 + 1e-11)


@FEW
@given(bounds=bound_lists(4, 6), units=st.tuples(MAGNITUDES, MAGNITUDES))
def test_units_leave_the_same_problem(bounds, units):
    distance, time = units
    scaled = [b and b * distance / time**k for k, b in enumerate(bounds, start=1)]
    here, there = problem_of(bounds), problem_of(scaled, distance)
    np.testing.assert_allclose(there.upper[1:], here.upper[1:], rtol=2e-12)
    np.testing.assert_allclose(there.peaks, here.peaks, rtol=2e-12)


def test_of_even_derivatives_the_smaller_side_counts_and_relaxed_the_mean():
    pairs = [(-3.0, 1.5), (-4.0, 8.0), (-90.0, 30.0), (-900.0, 1200.0)]
    limits = Limits.from_bounds(pairs)
    half = 0.5 * closed_form(1.0, limits).duration
    for relaxed, sides in ((False, (4.0, 900.0)), (True, (6.0, 1050.0))):
        problem = problem_of(pairs, relaxed=relaxed)
        for k, side in zip((2, 4), sides, strict=True):
            assert problem.upper[k] == pytest.approx(side * half**k, rel=1e-11)
            assert problem.lower[k] == -problem.upper[k]
        for k in (1, 3):
            assert problem.upper[k] == pytest.approx(pairs[k - 1][1] * half**k, rel=1e-11)
            assert problem.lower[k] == pytest.approx(pairs[k - 1][0] * half**k, rel=1e-11)


@pytest.mark.parametrize("order", range(1, 9))
def test_ends_are_those_of_a_motion_odd_about_its_middle(order):
    problem = HalfProblem(*(np.full(order + 1, side) for side in (-3.0, 3.0, 1.0)))
    ends = problem.ends(0.5)
    held = [k for k in range(order + 1) if np.isfinite(ends[k])]
    assert held == list(range(2, order, 2))
    assert np.all(ends[held] == 0.0)


@pytest.mark.parametrize("order", range(2, 9))
def test_a_cruise_is_entered_at_full_velocity_and_nothing_else(order):
    problem = HalfProblem(*(np.full(order + 1, side) for side in (-3.0, 3.0, 1.0)), cruising=True)
    expected = [np.nan, 1.5, *[0.0] * (order - 2), np.nan]
    np.testing.assert_array_equal(problem.ends(0.5), expected)


@FEW
@given(bound_lists(4, 7))
def test_bounds_that_the_closed_form_reaches_are_relevant_and_missing_ones_are_not(bounds):
    limits = Limits.from_bounds(bounds)
    closed, relevant = closed_form(1.0, limits), problem_of(bounds).relevant()
    for k, bound in enumerate(bounds[:-1], start=1):
        if bound is None:
            assert k not in relevant
        elif closed.peak(k) >= 0.99 * bound:
            assert k in relevant
    assert len(bounds) not in relevant


@FEW
@given(bound_lists(4, 7), st.floats(1e-9, 1.0))
def test_units_are_the_peaks_and_never_above_them(bounds, shortest):
    problem = problem_of(bounds)
    units = problem.units(shortest)
    np.testing.assert_array_equal(units[:-1], problem.peaks[:-1])
    assert 0.0 < units[-1] <= problem.peaks[-1]


# The program


@FEW
@given(problem=PROBLEMS, seed=SEEDS, half=HALVES)
def test_bounds_hold_between_the_nodes_and_the_middle_is_one(problem, seed, half):
    nodes, n = mesh(seed), problem.order
    found = HalfProgram(problem, nodes).solve(half)
    assert found is not None
    x = motion(nodes, found.inputs, n)
    assert found.distance == pytest.approx(float(x[0](1.0)), rel=1e-9)
    t = np.linspace(0.0, 1.0, 2001)
    for k in range(1, n):
        # a bound left out as far from the closed form's is no part of the program
        if k in problem.relevant():
            values = x[k](t)
            assert values.max() <= problem.upper[k] * half**k * (1.0 + FEASIBLE), k
            assert values.min() >= problem.lower[k] * half**k * (1.0 + FEASIBLE), k
        if k % 2 == 0:
            assert abs(float(x[k](1.0))) <= FEASIBLE * problem.peaks[k], k
    assert np.abs(found.inputs).max() <= problem.upper[n] * half**n * (1.0 + 1e-14)


@FEW
@given(problem=PROBLEMS, seed=SEEDS, halves=st.tuples(HALVES, HALVES))
def test_the_worth_of_bounds_sums_to_the_distance_and_is_a_tangent(problem, seed, halves):
    """Linear programs are concave in their bounds, L_k·η^k here: no other η gets further."""
    program = HalfProgram(problem, mesh(seed))
    here, there = (program.solve(half) for half in halves)
    assert here is not None
    assert there is not None
    k = np.arange(problem.order + 1)
    assert here.worth.min() >= -1e-12
    assert float(here.worth @ halves[0] ** k) == pytest.approx(here.distance, rel=OPTIMAL)
    assert there.distance <= float(here.worth @ halves[1] ** k) * (1.0 + OPTIMAL)


@FEW
@given(problem=PROBLEMS, seed=SEEDS)
def test_a_finer_grid_gets_no_less_far(problem, seed):
    nodes = mesh(seed)
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    coarse = HalfProgram(problem, nodes).solve(1.0)
    fine = HalfProgram(problem, np.union1d(nodes, middles)).solve(1.0)
    assert coarse is not None
    assert fine is not None
    assert fine.distance >= coarse.distance * (1.0 - OPTIMAL)
    assert coarse.losses.shape == (len(middles),)
    assert coarse.losses.min() >= 0.0


@FEW
@given(problem=PROBLEMS, seed=SEEDS)
def test_bounds_at_the_nodes_alone_get_further(problem, seed):
    nodes = mesh(seed)
    found = HalfProgram(problem, nodes).solve(1.0)
    assert found is not None
    assert found.distance <= reach_at_nodes(problem, nodes) * (1.0 + OPTIMAL)


@pytest.mark.parametrize("order", [4, 5, 6])
def test_bounds_between_the_nodes_cost_little_on_a_fine_grid(order):
    problem = problem_of([1.7, 7.0, 90.0, 1500.0, 3e4, 4e5][:order])
    lost = []
    for cells in (12, 60):
        nodes = np.linspace(0.0, 1.0, cells + 1)
        found = HalfProgram(problem, nodes).solve(1.0)
        assert found is not None
        lost.append(1.0 - found.distance / reach_at_nodes(problem, nodes))
    assert 0.0 <= lost[1] <= min(0.02, 0.2 * lost[0])


def reach_at_nodes(problem: HalfProblem, nodes) -> float:
    """Return how far a half gets whose bounds hold at the nodes, all of them."""
    n, count = problem.order, len(nodes) - 1
    unit = [motion(nodes, u, n) for u in np.eye(count)]
    states = np.array([[x[k](nodes[1:]) for x in unit] for k in range(n)]).transpose(0, 2, 1)
    bounded = [k for k in range(1, n) if problem.upper[k] < inf]
    size = problem.upper[n]
    rows = [np.empty((0, count)), *(states[k] * (size / problem.upper[k]) for k in bounded)]
    matrix = np.vstack(rows)
    even = states[2:n:2, -1] / problem.peaks[2:n:2, None] * size
    result = linprog(
        -states[0, -1] * size,
        A_ub=np.vstack([matrix, -matrix]),
        b_ub=np.ones(2 * len(matrix)),
        A_eq=even,
        b_eq=np.zeros(len(even)),
        bounds=(-1.0, 1.0),
        method="highs",
    )
    assert result.status == 0, result.message
    return -float(result.fun)


@pytest.mark.parametrize("order", [4, 5, 6, 7])
def test_on_its_own_switches_the_perfect_spline_is_found(order):
    switches = 2.0 * switch_fractions(order)
    nodes = np.union1d(switches[switches < 1.0 - 1e-9], mesh(order))
    problem = problem_of([*[None] * (order - 1), 7.0])
    found = HalfProgram(problem, nodes).solve(1.0)
    assert found is not None
    assert found.distance == pytest.approx(0.5, rel=1e-9)
    expected = [*[0.0] * order, found.distance]
    assert found.worth.tolist() == pytest.approx(expected, abs=1e-9)


@FEW
@given(seed=SEEDS, half=HALVES)
def test_a_half_that_is_to_cruise_ends_at_full_velocity(seed, half):
    problem = problem_of([0.3, 4.0, 60.0, 900.0])
    cruising = HalfProblem(problem.lower, problem.upper, problem.peaks, cruising=True)
    nodes = mesh(seed, 40)
    found = HalfProgram(cruising, nodes).solve(half)
    assert found is not None
    x = motion(nodes, found.inputs, 4)
    assert float(x[1](1.0)) == pytest.approx(problem.upper[1] * half, rel=FEASIBLE)
    for k in (2, 3):
        assert abs(float(x[k](1.0))) <= FEASIBLE * problem.peaks[k]


def test_a_half_too_short_for_its_cruise_is_none():
    problem = problem_of([0.3, 4.0, 60.0, 900.0])
    cruising = HalfProblem(problem.lower, problem.upper, problem.peaks, cruising=True)
    program = HalfProgram(cruising, mesh(3))
    assert program.solve(1e-2) is None
    assert program.solve(1.0) is not None


# The duration


@given(
    worth=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=7).filter(lambda w: sum(w[1:]) > 1e-3),
    guess=st.floats(-2.0, 2.0).map(lambda exponent: 10.0**exponent),
)
def test_duration_of_solves_the_polynomial(worth, guess):
    worth[0] = 0.0
    half = duration_of(np.array(worth), 0.5, guess)

    def short_of(log):
        return sum(w * np.exp(k * log) for k, w in enumerate(worth)) - 0.5

    assert half == pytest.approx(
        float(np.exp(brentq(short_of, -20.0, 20.0, xtol=1e-15))), rel=1e-11
    )


# Bounds left out


@FEW
@given(bounds=bound_lists(4, 6), seed=SEEDS, half=HALVES)
def test_levels_are_those_of_the_motion(bounds, seed, half):
    problem, nodes = problem_of(bounds), mesh(seed)
    inputs = np.random.default_rng(seed).uniform(-1.0, 1.0, len(nodes) - 1)
    found = problem.levels(nodes, inputs, half)
    for k, row in zip(problem.relevant(), found, strict=True):
        reached = motion(nodes, inputs, problem.order)[k](nodes) / half**k
        scale = np.abs(reached).max() / problem.upper[k]
        np.testing.assert_allclose(row, reached / problem.upper[k], rtol=0, atol=1e-12 * scale)


def test_a_bound_that_was_left_out_comes_back_where_inputs_break_it():
    """A jerk bound of four times the perfect spline's peak."""
    snap = Limits(snap=1.0)
    problem = problem_of([None, None, 4.0 * closed_form(1.0, snap).peak("jerk"), 1.0])
    assert problem.relevant() == []
    nodes, half = mesh(3), 1.0
    jerk = problem.upper[3]
    for factor, expected in ((0.99, []), (1.01, [3])):
        inputs = np.full(len(nodes) - 1, factor * jerk)  # over 1 they make a jerk of as much
        complete = problem.completed(nodes, inputs, half)
        assert complete.relevant() == expected
        assert (complete is problem) == (not expected)
        assert complete.completed(nodes, inputs, half) is complete
