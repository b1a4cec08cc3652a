"""The relaxed half problem: its multipliers against scipy's program, motions below them."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly
from scipy.optimize import linprog
from strategies import bound_lists

from jounce.shaping import Limits, min_time_move, perfect_spline
from jounce.shaping.optimal.half_problem import HalfProblem, HalfProgram
from jounce.shaping.optimal.multipliers import Multipliers, signed_integrals
from jounce.shaping.optimal.relaxation import RelaxedProgram

FEW = settings(max_examples=max(8, settings.default.max_examples // 4))
OPTIMAL = (
    1e-3  # of the distance: two solvers at their tolerances, of programs with large multipliers
)
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(5)
SEEDS = st.integers(0, 10**6)
HALVES = st.floats(0.8, 1.2)


def closed_form(limits):
    return min_time_move(1.0, limits, method="closed-form")


def problem_of(bounds) -> HalfProblem:
    limits = Limits.from_bounds(bounds)
    return HalfProblem.make(1.0, limits, closed_form(limits), relaxed=True)


def mesh(seed: int, cells: int):
    lengths = np.random.default_rng(seed).uniform(0.2, 1.0, cells)
    nodes = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    nodes[-1] = 1.0
    return nodes


def worth(problem: HalfProblem, found: Multipliers, half: float, inputs: float) -> float:
    """Return what the multipliers prove: bounds times masses, `inputs` being ∫|p|."""
    positive, negative = found.masses()
    total = problem.upper[-1] * half**problem.order * inputs
    for k in range(1, problem.order):
        for mass, bound in ((positive[k], problem.upper[k]), (negative[k], -problem.lower[k])):
            if mass > 0.0:
                total += mass * bound * half**k
    return float(total)


def proven(problem: HalfProblem, found: Multipliers, half: float) -> float:
    coefficients, rounding = found.costates()
    up, down = signed_integrals(coefficients, found.cells, rounding)
    return worth(problem, found, half, float(up.sum() + down.sum()))


def reach_with_means(problem: HalfProblem, nodes, parts: int, half: float) -> float:
    """Return the optimum by scipy: bounds at the nodes and in the mean under every hat."""
    n, count = problem.order, parts * (len(nodes) - 1)
    fine = np.interp(np.arange(count + 1) / parts, range(len(nodes)), nodes)
    h = np.diff(fine)
    t = fine[:-1, None] + 0.5 * h[:, None] * (1.0 + POINTS)
    weights = 0.5 * h[:, None] * WEIGHTS
    hats = np.array([np.interp(t, nodes, hat) * weights for hat in np.eye(len(nodes))])
    hats /= hats.sum(axis=(1, 2), keepdims=True)
    size = problem.upper[n] * half**n
    rows, even, reach = [np.empty((0, count))], [], []
    for k in range(n):
        unit = [PPoly(u[None, :], fine).antiderivative(n - k) for u in np.eye(count)]
        at = np.array([x(nodes[1:]) for x in unit]).T
        if k == 0:
            reach = at[-1] * size
        elif k % 2 == 0:
            even.append(at[-1] * size / problem.peaks[k])
        if k in problem.relevant():
            means = np.array([[(hat * x(t)).sum() for x in unit] for hat in hats])
            rows.append(np.vstack([at, means]) * size / (problem.upper[k] * half**k))
    matrix = np.vstack(rows)
    result = linprog(
        -np.asarray(reach),
        A_ub=np.vstack([matrix, -matrix]),
        b_ub=np.ones(2 * len(matrix)),
        A_eq=np.array(even),
        b_eq=np.zeros(len(even)),
        bounds=(-1.0, 1.0),
        method="highs",
    )
    assert result.status == 0, result.message
    return -float(result.fun)


@FEW
@given(
    bounds=bound_lists(4, 6),
    seed=SEEDS,
    cells=st.integers(3, 8),
    parts=st.integers(1, 3),
    half=HALVES,
)
def test_the_multipliers_are_worth_the_optimum(bounds, seed, cells, parts, half):
    """With the costate averaged over each cell, where the input is constant.

    With cells in parts they are worth less where densities of both signs meet, yet no less than
    what a motion within the bounds reaches.
    """
    problem, nodes = problem_of(bounds), mesh(seed, cells)
    found = RelaxedProgram(problem, nodes, parts).solve(half)
    assert found is not None
    coefficients, _ = found.costates()
    powers = np.arange(1, len(coefficients) + 1)[:, None]
    costate = (coefficients / powers).sum(axis=0) * found.cells
    value = worth(problem, found, half, float(np.abs(costate).sum()))
    optimum = reach_with_means(problem, nodes, parts, half)
    motion = HalfProgram(problem, nodes).solve(half)
    assert motion is not None
    assert motion.distance * (1.0 - OPTIMAL) <= value <= optimum * (1.0 + OPTIMAL)
    if parts == 1:
        assert value == pytest.approx(optimum, rel=OPTIMAL)


@FEW
@given(bounds=bound_lists(4, 6), seed=SEEDS, parts=st.integers(1, 3), half=HALVES)
def test_multipliers_stand_where_the_grid_says(bounds, seed, parts, half):
    problem, nodes = problem_of(bounds), mesh(seed, 15)
    found = RelaxedProgram(problem, nodes, parts).solve(half)
    assert found is not None
    n = problem.order
    assert found.cells.shape == (15 * parts,)
    assert found.cells.sum() == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(np.cumsum(found.cells)[parts - 1 :: parts], nodes[1:], rtol=1e-13)
    assert found.atoms.shape == found.densities.shape == (n, 15 * parts + 1)
    inside = np.arange(15 * parts + 1) % parts > 0
    assert not found.atoms[:, inside].any()
    held = {*range(2, n, 2)}
    assert not any(found.ends[k] for k in range(n) if k not in held)
    for k in range(n):
        if k not in problem.relevant():
            assert not found.atoms[k].any()
            assert not found.densities[k].any()


@FEW
@given(bounds=bound_lists(4, 6), seed=SEEDS, parts=st.integers(1, 3), half=HALVES)
def test_no_motion_within_the_bounds_gets_further_than_is_proven(bounds, seed, parts, half):
    problem, nodes = problem_of(bounds), mesh(seed, 15)
    found = RelaxedProgram(problem, nodes, parts).solve(half)
    motion = HalfProgram(problem, nodes).solve(half)
    assert found is not None
    assert motion is not None
    assert motion.distance <= proven(problem, found, half) * (1.0 + 1e-9)
    # the closed form is there in unit time
    assert proven(problem, found, 1.0) >= 0.5 * (1.0 - 1e-11)


@FEW
@given(bounds=bound_lists(4, 6), halves=st.tuples(HALVES, HALVES), seed=SEEDS)
def test_a_proof_for_one_time_holds_for_another(bounds, halves, seed):
    problem, nodes = problem_of(bounds), mesh(seed, 15)
    program = RelaxedProgram(problem, nodes, 2)
    here = program.solve(halves[0])
    motion = HalfProgram(problem, nodes).solve(halves[1])
    assert here is not None
    assert motion is not None
    assert motion.distance <= proven(problem, here, halves[1]) * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_motion_and_proof_meet_as_the_grid_gets_finer(seed):
    rng = np.random.default_rng(seed)
    bounds = [None, *(np.array([7.0, 90.0, 1500.0]) * rng.uniform(0.7, 1.5, 3))]
    problem = problem_of(bounds)
    gaps = []
    for cells in (10, 40):
        nodes = np.linspace(0.0, 1.0, cells + 1)
        found = RelaxedProgram(problem, nodes, 3).solve(1.0)
        motion = HalfProgram(problem, nodes).solve(1.0)
        assert found is not None
        assert motion is not None
        gaps.append(proven(problem, found, 1.0) / motion.distance - 1.0)
    assert 0.0 <= gaps[1] <= 0.2 * gaps[0]


@pytest.mark.parametrize("order", [4, 5, 6])
def test_the_perfect_spline_is_proven_on_an_even_grid(order):
    """Its costate has no measures: any mesh with nodes near its roots proves it nearly."""
    spline = perfect_spline(1.0, order, 3.0)
    problem = problem_of([*[None] * (order - 1), 3.0])
    nodes = np.union1d(np.linspace(0.0, 1.0, 41), 2.0 * spline.breaks / spline.duration)
    found = RelaxedProgram(problem, nodes[nodes <= 1.0], 1).solve(1.0)
    assert found is not None
    assert not found.atoms.any()
    assert not found.densities.any()
    assert 0.5 * (1.0 - 1e-12) <= proven(problem, found, 1.0) <= 0.5 * (1.0 + 2e-2)


@pytest.mark.parametrize("parts", [1, 2])
def test_a_direction_without_a_bound_has_no_multiplier(parts):
    pairs = [(-inf, 1.4), 8.0, (-40.0, inf), 900.0]
    problem = problem_of(pairs)
    found = RelaxedProgram(problem, mesh(3, 20), parts).solve(1.0)
    assert found is not None
    positive, negative = found.masses()
    assert positive[1] > 0.0
    assert negative[1] == 0.0
    assert positive[3] == 0.0
    assert np.isfinite(proven(problem, found, 1.0))
    assert proven(problem, found, 1.0) >= 0.5


@FEW
@given(bounds=bound_lists(4, 6), seed=SEEDS, parts=st.integers(1, 3))
def test_no_multipliers_stand_at_nodes_that_are_left_out(bounds, seed, parts):
    problem, nodes = problem_of(bounds), mesh(seed, 12)
    near = np.random.default_rng(seed).random((problem.order, len(nodes))) < 0.5
    found = RelaxedProgram(problem, nodes, parts, near).solve(1.0)
    every = RelaxedProgram(problem, nodes, parts).solve(1.0)
    assert found is not None
    assert every is not None
    assert not found.atoms[:, ::parts][~near].any()
    for k in range(problem.order):
        alone = ~near[k] & ~np.append(near[k, 1:], False) & ~np.append(False, near[k, :-1])
        assert not found.densities[k, ::parts][alone].any()
    same = RelaxedProgram(problem, nodes, parts, np.ones_like(near)).solve(1.0)
    assert same is not None
    np.testing.assert_array_equal(same.atoms, every.atoms)
    np.testing.assert_array_equal(same.densities, every.densities)
