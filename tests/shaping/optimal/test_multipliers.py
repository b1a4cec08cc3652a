"""The costate identity and ∫|p| behind the proofs, against quadrature for arbitrary multipliers."""

from math import factorial

import numpy as np
import pytest

from jounce.shaping.optimal.multipliers import Multipliers, signed_integrals

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(12)


def states_at(t, nodes, inputs, order):
    """Return derivatives 0…order−1 at times t of the motion from rest."""
    rows = []
    for k in range(order):
        m = order - k
        since = np.maximum(np.subtract.outer(t, nodes), 0.0) ** m / factorial(m)
        rows.append((since[:, :-1] - since[:, 1:]) @ inputs)
    return np.array(rows)


@pytest.mark.parametrize("order", range(2, 9))
@pytest.mark.parametrize("seed", range(3))
def test_every_motion_obeys_the_identity(order, seed):
    """z_0(1) − Σ λ_k·z_k(1) = ∫ p·u + Σ atoms·z_k + ∫ density·z_k, whatever the multipliers."""
    rng = np.random.default_rng((order, seed))
    cells = rng.dirichlet(np.ones(6))
    nodes = np.concatenate([[0.0], np.cumsum(cells)])
    ends, inputs = rng.normal(size=order), rng.normal(size=6)
    atoms, densities = rng.normal(size=(2, order, 7))
    ends[0] = 0.0
    atoms[0] = densities[0] = 0.0
    coefficients, rounding = Multipliers(cells, ends, atoms, densities).costates()
    assert float(rounding.max()) <= 1e-12 * max(1.0, float(np.abs(coefficients).max()))

    last = states_at(nodes[-1:], nodes, inputs, order)[:, 0]
    total = float((atoms * states_at(nodes, nodes, inputs, order)).sum())
    for i, h in enumerate(cells):
        t = nodes[i] + h * 0.5 * (1.0 + POINTS)
        sigma = (nodes[i + 1] - t) / h
        costate = np.polynomial.polynomial.polyval(sigma, coefficients[:, i].astype(float))
        density = densities[:, i, None] * sigma + densities[:, i + 1, None] * (1.0 - sigma)
        values = costate * inputs[i] + (density * states_at(t, nodes, inputs, order)).sum(axis=0)
        total += 0.5 * h * float(WEIGHTS @ values)
    assert last[0] - ends @ last == pytest.approx(total, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("degree", range(1, 9))
def test_signed_integrals_are_upper_bounds_and_tight(degree):
    rng = np.random.default_rng(degree)
    coefficients = rng.normal(size=(degree + 1, 5)).astype(np.longdouble)
    cells = rng.uniform(0.1, 1.0, 5)
    up, down = signed_integrals(coefficients, cells, np.zeros(5, np.longdouble))
    edges = np.linspace(0.0, 1.0, 4001)
    sigma = (edges[:-1] + edges[1:]) / 2.0
    for i, h in enumerate(cells):
        values = np.polynomial.polynomial.polyval(sigma, coefficients[:, i].astype(float))
        assert float(up[i]) == pytest.approx(h * np.maximum(values, 0.0).mean(), abs=2e-6)
        assert float(down[i]) == pytest.approx(h * np.maximum(-values, 0.0).mean(), abs=2e-6)
        powers = 1.0 / np.arange(1, degree + 2)
        assert float(up[i] - down[i]) == pytest.approx(
            h * float(powers @ coefficients[:, i]), abs=1e-12
        )


def test_masses_count_both_signs():
    atoms, densities = np.zeros((2, 2, 3))
    atoms[1] = [0.0, 2.0, -3.0]
    densities[1] = [4.0, -4.0, 0.0]
    positive, negative = Multipliers(np.array([0.5, 0.5]), np.zeros(2), atoms, densities).masses()
    assert positive[1] == pytest.approx(2.0 + 4.0 * 0.25, rel=1e-12)
    assert negative[1] == pytest.approx(3.0 + 4.0 * 0.5, rel=1e-12)
