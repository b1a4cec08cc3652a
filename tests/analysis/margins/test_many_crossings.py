"""Monotone pieces, crossovers and the solver, against dense grids and roots known exactly."""

import numpy as np
import pytest

from jounce.analysis.margins.many_crossings import pieces_of, solve, stable, within
from jounce.analysis.margins.many_loops import loops_of


@pytest.fixture(autouse=True)
def _quiet():
    with np.errstate(all="ignore"):
        yield


def random_loops(count=40, seed=0):
    rng = np.random.default_rng(seed)

    def poly(pairs):
        row = np.ones(1)
        for _ in range(pairs):
            size, zeta = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-2.5, 0)
            row = np.polymul(row, [1.0, 2 * zeta * size, size**2])
        return row

    num, den = (np.array([poly(pairs) for _ in range(count)]) for pairs in (1, 2))
    num *= 10 ** rng.uniform(-1, 1, (count, 1))
    return loops_of(num, den, np.where(rng.random(count) < 0.5, rng.uniform(0, 3, count), 0.0))


def test_gain_and_phase_are_monotone_on_every_piece():
    pieces = pieces_of(random_loops())
    for left, right in zip(pieces.omega.T[:-1], pieces.omega.T[1:], strict=True):
        share = np.linspace(0, 1, 200)
        inner = left[:, None] ** (1 - share) * right[:, None] ** share
        for values in pieces.loops.gain_and_turns(inner):
            steps = np.diff(values, axis=1)
            size = 1e-11 * (1.0 + abs(values).max(axis=1))
            assert np.all((steps.max(axis=1) < size) | (steps.min(axis=1) > -size))


def test_every_crossover_of_a_dense_grid_is_found():
    loops = random_loops()
    pieces = pieces_of(loops)
    grid = np.geomspace(1e-3, 1e3, 20_001) / loops.scale[:, None]
    changes = np.diff(np.sign(loops.gain(grid)), axis=1) != 0
    assert np.array_equal(changes.sum(axis=1), pieces.crossing.sum(axis=1))
    assert pieces.crossing.sum() > 40
    found = np.where(pieces.crossing, pieces.omega, 1.0)
    size = abs(np.where(pieces.crossing, loops.gain(found), 0.0))
    assert size.max() < 1e-11


def test_stability_of_quadratics_is_that_of_their_coefficients():
    """1 + L = 0 with L = k/(s² + a·s + b) is s² + a·s + b + k = 0."""
    a, b, k = (part.ravel() for part in np.meshgrid([-1.0, 0.5], [-2.0, 3.0], [-4.0, 1.0, 5.0]))
    loops = loops_of(k[:, None], np.stack([np.ones_like(a), a, b], axis=1), np.zeros(a.size))
    assert stable(pieces_of(loops)).tolist() == ((a > 0) & (b + k > 0)).tolist()


@pytest.mark.parametrize(
    ("function", "slope", "root"),
    [
        (lambda x: x - 0.3, lambda x: np.ones_like(x), 0.3),
        (lambda x: 2.0 - np.exp(x), lambda x: -np.exp(x), np.log(2.0)),
        (lambda x: np.arctan(1e6 * (x - 0.7)), lambda x: 1e6 / (1 + 1e12 * (x - 0.7) ** 2), 0.7),
        (lambda x: (x - 1.0) ** 3, lambda x: 3 * (x - 1.0) ** 2, 1.0),
        (lambda x: np.sign(x - 0.25), lambda x: np.zeros_like(x), 0.25),
    ],
    ids=["line", "falling", "steep", "flat", "jump"],
)
def test_the_solver_finds_the_root_in_its_bracket(function, slope, root):
    low, high = np.full(3, -2.0), np.array([2.0, 5.0, 30.0])
    at_low, at_high = function(low), function(high)
    found = solve(
        lambda _, x: (function(x), slope(x)),
        low,
        high,
        within(low, high, at_low, at_high),
        at_low < 0,
    )
    np.testing.assert_allclose(found, root, rtol=1e-4 if root == 1.0 else 1e-12)
    assert np.array_equal(low, np.full(3, -2.0))


def test_nothing_to_solve():
    nothing = np.empty(0)
    assert solve(lambda _, x: (x, x), nothing, nothing, nothing, nothing < 0).shape == (0,)
