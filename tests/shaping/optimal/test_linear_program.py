"""The linear program against scipy's, its optimality conditions, and itself as its bounds move."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from jounce.shaping.optimal.linear_program import LinearProgram

SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=max(10, settings.default.max_examples // 2))
TOLERANCE = 1e-8  # ten times what HiGHS is asked for


def random_program(seed: int):
    """Return objective, matrix, lower, upper and inputs' range of a program that can be done.

    Some rows are equations, some bounded on one side.
    """
    rng = np.random.default_rng(seed)
    columns, rows = int(rng.integers(1, 16)), int(rng.integers(1, 16))
    matrix = rng.normal(size=(rows, columns)) * (rng.random((rows, columns)) < 0.7)
    inside = matrix @ rng.uniform(-1.0, 1.0, columns)
    lower, upper = inside - rng.exponential(size=rows), inside + rng.exponential(size=rows)
    kind = rng.integers(0, 6, rows)
    lower[kind == 0] = -inf
    upper[kind == 1] = inf
    lower[kind == 2] = upper[kind == 2] = inside[kind == 2]
    return rng.normal(size=columns), matrix, lower, upper, (-1.0, float(rng.uniform(1.0, 3.0)))


def reference(objective, matrix, lower, upper, inputs):
    """Solve by scipy's interior-point method; None where nothing is feasible."""
    sides = [(matrix, upper), (-matrix, -lower)]
    rows, most = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    kept = np.isfinite(most)
    found = linprog(
        -objective,
        A_ub=rows[kept] if kept.any() else None,
        b_ub=most[kept] if kept.any() else None,
        bounds=[inputs] * len(objective),
        method="highs-ipm",
    )
    assert found.status in (0, 2), found.message
    return -found.fun if found.status == 0 else None


def paid(multipliers, lower, upper):
    """Return what the bounds contribute: each multiplier times the bound on its side."""
    at = np.where(multipliers > 0.0, upper, np.where(multipliers < 0.0, lower, 0.0))
    return float(multipliers @ at)


def assert_optimal(solution, objective, matrix, lower, upper, inputs):
    """Assert feasibility, stationarity and equal values of both programs: that is optimality."""
    reached = matrix @ solution.inputs
    assert np.all(reached <= upper + TOLERANCE)
    assert np.all(reached >= lower - TOLERANCE)
    assert np.all(solution.inputs <= inputs[1] + TOLERANCE)
    assert np.all(solution.inputs >= inputs[0] - TOLERANCE)
    assert solution.value == pytest.approx(float(objective @ solution.inputs), rel=1e-14)
    costate = objective - matrix.T @ solution.multipliers
    np.testing.assert_allclose(costate, solution.reduced_costs, rtol=0, atol=TOLERANCE)
    worth = paid(solution.multipliers, lower, upper) + paid(
        solution.reduced_costs, *(np.full(len(objective), side) for side in inputs)
    )
    scale = 1.0 + np.abs(objective).sum()
    assert worth == pytest.approx(solution.value, abs=TOLERANCE * scale)


@given(SEEDS)
def test_random_programs_are_solved_to_the_optimum(seed):
    program = random_program(seed)
    solution = LinearProgram(*program[:2]).solve(*program[2:])
    assert solution is not None, seed
    assert_optimal(solution, *program)
    assert solution.value == pytest.approx(reference(*program), rel=1e-7, abs=1e-7)


@FEW
@given(SEEDS, st.floats(0.25, 4.0))
def test_moved_bounds_give_what_a_new_program_gives(seed, factor):
    objective, matrix, lower, upper, inputs = random_program(seed)
    again = LinearProgram(objective, matrix)
    assert again.solve(lower, upper, inputs) is not None
    moved = lower * factor, upper * factor, (inputs[0] * factor, inputs[1] * factor)
    solution = again.solve(*moved)
    assert solution is not None
    assert_optimal(solution, objective, matrix, *moved)
    first = LinearProgram(objective, matrix).solve(*moved)
    assert first is not None
    assert solution.value == pytest.approx(first.value, rel=1e-7, abs=1e-7)


@FEW
@given(SEEDS, SEEDS)
def test_no_other_bounds_are_worth_more_than_the_multipliers_say(seed, other):
    """The optimum is concave in the bounds: its tangent is above it everywhere."""
    objective, matrix, lower, upper, inputs = random_program(seed)
    program = LinearProgram(objective, matrix)
    here = program.solve(lower, upper, inputs)
    assert here is not None
    wider = np.random.default_rng(other).exponential(size=len(lower))
    there = program.solve(lower - wider, upper + wider, inputs)
    assert there is not None
    tangent = here.value + float(np.abs(here.multipliers) @ wider)
    scale = 1.0 + np.abs(objective).sum()
    assert here.value - TOLERANCE * scale <= there.value <= tangent + TOLERANCE * scale


def test_what_cannot_be_done_is_none_and_the_next_call_is_unharmed():
    program = LinearProgram(np.array([1.0, 1.0]), np.array([[1.0, -1.0], [1.0, 1.0]]))
    possible = np.array([0.0, -inf]), np.array([0.0, 1.0]), (-1.0, 1.0)
    impossible = np.array([0.0, 3.0]), np.array([0.0, inf]), (-1.0, 1.0)
    assert program.solve(*impossible) is None
    for _ in range(2):
        solution = program.solve(*possible)
        assert solution is not None
        assert solution.inputs.tolist() == pytest.approx([0.5, 0.5])
        assert program.solve(*impossible) is None


def test_what_has_no_maximum_is_none():
    program = LinearProgram(np.array([1.0]), np.array([[1.0]]))
    assert program.solve(np.array([0.0]), np.array([inf]), (-1.0, inf)) is None


def test_a_very_small_coefficient_counts():
    """HiGHS as it comes drops what is below 1e-9."""
    program = LinearProgram(np.array([1.0]), np.array([[1e-10]]))
    solution = program.solve(np.array([-1e-4]), np.array([1e-4]), (-1e7, 1e7))
    assert solution is not None
    assert solution.value == pytest.approx(1e6, rel=1e-3)


def test_without_rows_every_input_is_at_the_bound_that_pays():
    solution = LinearProgram(np.array([2.0, -3.0]), np.zeros((0, 2))).solve(
        np.zeros(0), np.zeros(0), (-1.0, 4.0)
    )
    assert solution is not None
    assert solution.inputs.tolist() == [4.0, -1.0]
    assert solution.reduced_costs.tolist() == pytest.approx([2.0, -3.0])
    assert solution.multipliers.shape == (0,)


def test_the_arguments_are_left_alone():
    objective, matrix, lower, upper, inputs = random_program(7)
    kept = [part.copy() for part in (objective, matrix, lower, upper)]
    program = LinearProgram(objective, matrix)
    for _ in range(2):
        assert program.solve(lower, upper, inputs) is not None
    for part, before in zip((objective, matrix, lower, upper), kept, strict=True):
        np.testing.assert_array_equal(part, before)
