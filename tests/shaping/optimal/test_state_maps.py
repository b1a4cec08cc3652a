"""Maps from inputs to states, Bernstein coefficients and means, against scipy's polynomials."""

from itertools import pairwise
from math import factorial

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import BPoly, PPoly
from scipy.linalg import expm

from jounce.shaping.optimal.state_maps import (
    bernstein_rows,
    greville_rows,
    hat_areas,
    hat_rows,
    node_maps,
)

ROUNDING = 1e-14  # of what an input of 1 all the time does


@st.composite
def motions(draw, max_order: int = 7):
    """Draw an order, nodes from 0 to 1 that are up to a thousandfold unevenly spaced, inputs."""
    order, count = draw(st.integers(1, max_order)), draw(st.integers(1, 9))
    lengths = [10.0 ** draw(st.floats(-3.0, 0.0)) for _ in range(count)]
    edges = np.concatenate([[0.0], np.cumsum(lengths)])
    inputs = [draw(st.floats(-1.0, 1.0)) for _ in range(count)]
    return order, edges / edges[-1], np.array(inputs)


def derivative(k: int, order: int, nodes, inputs) -> PPoly:
    """Return derivative k of the motion from rest, integrated by scipy."""
    return PPoly(inputs[None, :], nodes).antiderivative(order - k)


def assert_near(found, expected, integrations: int):
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING / factorial(integrations))


@given(motions())
def test_node_maps_are_the_states_at_the_nodes(motion):
    order, nodes, inputs = motion
    maps = node_maps(nodes, order)
    assert maps.shape == (order + 1, len(nodes), len(inputs))
    for k in range(order):
        assert_near(maps[k] @ inputs, derivative(k, order, nodes, inputs)(nodes), order - k)
    np.testing.assert_array_equal(maps[order] @ inputs, [*inputs, 0.0])


@pytest.mark.parametrize("order", range(1, 8))
def test_a_cell_is_a_matrix_exponential(order):
    """The chain of integrators with its input as one more, constant state."""
    rng = np.random.default_rng(order)
    nodes = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 0.3, 5))])
    inputs = rng.normal(size=5)
    maps = node_maps(nodes, order)
    state = np.zeros(order + 1)
    for j, (h, u) in enumerate(zip(np.diff(nodes), inputs, strict=True)):
        state[order] = u
        state = expm(np.eye(order + 1, k=1) * h) @ state
        np.testing.assert_allclose(maps[:order, j + 1] @ inputs, state[:order], rtol=0, atol=1e-14)


@pytest.mark.parametrize("shortest", [1e-3, 1e-6, 1e-9])
def test_very_short_cells_against_40_digits(shortest):
    """What a cell does is a difference of powers: it errs by rounding of the powers, no more."""
    nodes = np.array([0.0, 0.3, 0.3 + shortest, 0.7, 1.0 - shortest, 1.0])
    maps = node_maps(nodes, 6)
    with mpmath.workdps(40):
        exact_nodes = [mpmath.mpf(float(node)) for node in nodes]
        for k in range(6):
            for i, t in enumerate(exact_nodes):
                powers = [max(t - node, 0) ** (6 - k) for node in exact_nodes]
                for j in range(5):
                    exact = (powers[j] - powers[j + 1]) / mpmath.factorial(6 - k)
                    rounding = 4e-15 * float(powers[j]) / factorial(6 - k)
                    assert abs(maps[k, i, j] - float(exact)) <= rounding, (k, i, j)


@given(motions())
def test_bernstein_rows_with_the_end_before_are_the_motion(motion):
    order, nodes, inputs = motion
    maps, cells = node_maps(nodes, order), np.diff(nodes)
    for k in range(order):
        d = order - k
        rows = (bernstein_rows(maps, cells, k) @ inputs).reshape(d, -1)
        form = BPoly(np.vstack([[0.0, *rows[-1, :-1]], rows]), nodes)
        t = np.linspace(0.0, 1.0, 101)
        values = derivative(k, order, nodes, inputs)(t)
        assert_near(form(t), values, d)
        cell = np.searchsorted(nodes, t, side="left").clip(1) - 1
        slack = ROUNDING / factorial(d)
        assert np.all(values <= form.c.max(axis=0)[cell] + slack)
        assert np.all(values >= form.c.min(axis=0)[cell] - slack)


@given(motions())
def test_greville_rows_are_values_at_even_parts_of_a_cell(motion):
    order, nodes, inputs = motion
    maps, cells = node_maps(nodes, order), np.diff(nodes)
    for k in range(order):
        d = order - k
        times = nodes[:-1] + cells * np.arange(1, d + 1)[:, None] / d
        expected = derivative(k, order, nodes, inputs)(times).ravel()
        assert_near(greville_rows(maps, cells, k) @ inputs, expected, d)


@pytest.mark.parametrize("order", range(1, 7))
def test_both_sets_of_rows_agree_where_a_derivative_is_linear(order):
    rng = np.random.default_rng(order)
    nodes = np.concatenate([[0.0], np.cumsum(rng.dirichlet(np.ones(4)))])
    maps, cells = node_maps(nodes, order), np.diff(nodes)
    linear = order - 1
    np.testing.assert_allclose(
        bernstein_rows(maps, cells, linear), greville_rows(maps, cells, linear), rtol=1e-14
    )
    np.testing.assert_allclose(
        bernstein_rows(maps, cells, linear), maps[linear, 1:], rtol=0, atol=1e-15
    )


@pytest.mark.parametrize("seed", range(6))
def test_hat_rows_are_means_under_hats(seed):
    rng = np.random.default_rng(seed)
    order, count = 1 + seed, 5
    nodes = np.concatenate([[0.0], np.cumsum(rng.dirichlet(np.ones(count)))])
    inputs = rng.normal(size=count)
    maps, cells = node_maps(nodes, order), np.diff(nodes)
    areas = hat_areas(cells)
    for i, hat in enumerate(np.eye(count + 1)):
        pieces = list(pairwise(nodes))[max(i - 1, 0) : i + 1]
        assert areas[i] == pytest.approx(0.5 * sum(right - left for left, right in pieces))
        for k in range(order):
            x = derivative(k, order, nodes, inputs)
            whole = sum(
                quad(lambda t, x=x, hat=hat: float(np.interp(t, nodes, hat) * x(t)), *piece)[0]
                for piece in pieces
            )
            mean = float(hat_rows(maps, cells, k)[i] @ inputs)
            assert mean == pytest.approx(whole / areas[i], rel=1e-9, abs=1e-13), (i, k)


@given(st.lists(st.floats(1e-9, 1.0), min_size=1, max_size=30))
def test_hats_share_the_whole_time(cells):
    areas = hat_areas(np.array(cells))
    assert areas.shape == (len(cells) + 1,)
    assert areas.sum() == pytest.approx(sum(cells), rel=1e-13)
