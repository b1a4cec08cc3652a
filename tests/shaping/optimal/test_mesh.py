"""Meshes from outside: ends and breaks kept, nodes added where losses, switches and roots are."""

from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import MAGNITUDES, bound_lists

from jounce.shaping import Limits, Trajectory, min_time_move, perfect_spline
from jounce.shaping.optimal.mesh import (
    graded_mesh,
    refined,
    split_losses,
    split_sudden,
    split_switches,
    with_touches,
)
from jounce.shaping.optimal.multipliers import Multipliers

FEW = settings(max_examples=max(10, settings.default.max_examples // 2))
SEEDS = st.integers(0, 10**6)
COUNTS = st.integers(2, 60)
GOLDEN = 0.6180339887498949  # its multiples fall on no sample


def closed_form(distance, bounds):
    return min_time_move(distance, Limits.from_bounds(bounds), method="closed-form")


def random_nodes(rng, cells: int):
    """Return nodes from 0 to 1, cells up to a thousandfold different."""
    lengths = 10.0 ** rng.uniform(-3.0, 0.0, cells)
    nodes = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    nodes[-1] = 1.0
    return nodes


def assert_grid(nodes):
    assert (nodes[0], nodes[-1]) == (0.0, 1.0)
    assert np.all(np.diff(nodes) > 0.0)


def cut(before, after):
    """Tell which cells have new nodes inside, all old nodes being kept."""
    assert_grid(after)
    assert np.isin(before, after).all()
    return np.diff(np.searchsorted(after, before)) > 1


# The first mesh


@FEW
@given(bounds=bound_lists(1, 7), cells=COUNTS)
def test_a_graded_mesh_has_the_breaks_unless_they_are_many(bounds, cells):
    move = closed_form(1.0, bounds)
    nodes = graded_mesh(move, cells)
    assert_grid(nodes)
    breaks = move.breaks / (0.5 * move.duration)
    breaks = breaks[breaks < 1.0 - 1e-9]
    assert len(nodes) <= len(breaks) + cells + 1
    if len(breaks) < cells:
        assert np.abs(nodes[:, None] - breaks).min(axis=0).max() <= 1e-12
    assert np.diff(nodes).max() <= 3.0 / cells


@pytest.mark.parametrize("pieces", [200, 3000])
def test_a_motion_of_very_many_pieces_makes_no_more_nodes_than_asked_for(pieces):
    rng = np.random.default_rng(pieces)
    lengths = rng.uniform(0.1, 1.0, pieces)
    breaks = np.concatenate([[0.0], np.cumsum([*lengths, *lengths[::-1]])])
    move = Trajectory(breaks, np.ones((2 * pieces, 5)))
    nodes = graded_mesh(move, 40)
    assert_grid(nodes)
    assert len(nodes) <= 200
    assert np.diff(nodes).max() <= 3.0 / 40


@FEW
@given(bounds=bound_lists(4, 6), distance=MAGNITUDES, time=MAGNITUDES)
def test_the_grid_has_no_units(bounds, distance, time):
    scaled = [b and b * distance / time**k for k, b in enumerate(bounds, start=1)]
    here, there = (
        graded_mesh(closed_form(1.0, bounds), 40),
        graded_mesh(closed_form(distance, scaled), 40),
    )
    assert len(here) == len(there)
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-11)


def test_short_ramps_get_as_many_nodes_as_long_cruises():
    """Half of the cells follow the pieces: each ramp of 1e-6 of the move has its share."""
    limits = Limits(velocity=1.0, acceleration=1e6, jerk=1e13)
    move = min_time_move(1.0, limits)
    nodes = graded_mesh(move, 40)
    ramp = 2.0 * (move.breaks[3] - move.breaks[0]) / move.duration
    assert np.count_nonzero(nodes <= ramp) >= 10
    assert np.count_nonzero(nodes >= ramp) >= 15


# Cuts at switches and losses


@given(SEEDS, st.integers(1, 40))
def test_cells_at_switches_and_between_the_bounds_are_cut(seed, cells):
    rng = np.random.default_rng(seed)
    nodes = random_nodes(rng, cells)
    inputs = rng.choice([-7.0, -7.0, 7.0, 7.0, 7.0, 0.0, 3.0], cells)
    after = split_switches(nodes, inputs, 7.0)
    changed = cut(nodes, after)
    steps = np.concatenate([[False], np.diff(inputs) != 0.0, [False]])
    expected = steps[1:] | steps[:-1] | ((inputs != 0.0) & (np.abs(inputs) != 7.0))
    np.testing.assert_array_equal(changed, expected)
    thirds = np.diff(nodes)[expected] / 3.0
    new = np.setdiff1d(after, nodes)
    assert len(new) == 2 * len(thirds)
    at = np.sort([*(nodes[:-1][expected] + thirds), *(nodes[1:][expected] - thirds)])
    np.testing.assert_allclose(new, at, rtol=0, atol=1e-15)


def test_a_constant_input_at_its_bound_leaves_the_grid():
    nodes = random_nodes(np.random.default_rng(0), 12)
    for level in (-7.0, 0.0, 7.0, 7.0 * (1.0 - 1e-9)):
        np.testing.assert_array_equal(split_switches(nodes, np.full(12, level), 7.0), nodes)


@given(SEEDS, st.integers(1, 100))
def test_the_cells_that_lose_most_are_cut(seed, cells):
    rng = np.random.default_rng(seed)
    nodes = random_nodes(rng, cells)
    losses = rng.exponential(size=cells) ** 3 * (rng.random(cells) < 0.7)
    after = split_losses(nodes, losses)
    chosen = cut(nodes, after)
    if not losses.any():
        np.testing.assert_array_equal(after, nodes)
        return
    assert chosen.any()
    assert losses[chosen].min() >= losses[~chosen].max(initial=0.0)
    # most of what is lost, unless that would be very many cells
    assert losses[chosen].sum() >= 0.75 * losses.sum() or chosen.sum() >= 40
    assert len(after) == len(nodes) + 2 * np.count_nonzero(chosen)


def test_no_losses_leave_the_grid():
    nodes = np.linspace(0.0, 1.0, 6)
    np.testing.assert_array_equal(split_losses(nodes, np.zeros(5)), nodes)


def test_a_refinement_by_a_third_does_not_see_units_of_the_losses():
    rng = np.random.default_rng(5)
    nodes, losses = random_nodes(rng, 30), rng.exponential(size=30)
    for factor in (1e-200, 1e200):
        np.testing.assert_array_equal(
            split_losses(nodes, losses * factor), split_losses(nodes, losses)
        )


# Roots of the costate


def multipliers_with_root(nodes, parts: int, root: float, order: int = 3) -> Multipliers:
    """Return multipliers whose costate is (1 − t)^(n−1) / (n−1)! − λ, zero at a root."""
    fine = np.interp(np.arange(parts * len(nodes) - parts + 1) / parts, range(len(nodes)), nodes)
    ends = np.zeros(order)
    ends[order - 1] = (1.0 - root) ** (order - 1) / factorial(order - 1)
    nothing = np.zeros((order, len(fine)))
    return Multipliers(np.diff(fine), ends, nothing, nothing)


@given(SEEDS, st.sampled_from([1, 2, 3]), st.integers(2, 5), st.integers(1, 10**6))
def test_a_root_of_the_costate_is_closed_in(seed, parts, order, place):
    rng = np.random.default_rng(seed)
    cells = 9
    nodes = random_nodes(rng, cells)
    cell = int(rng.integers(0, cells))
    width = nodes[cell + 1] - nodes[cell]
    root = nodes[cell] + width * (0.02 + 0.96 * (place * GOLDEN % 1.0))
    waste = np.zeros(parts * cells)
    waste[cell * parts : (cell + 1) * parts] = rng.exponential(size=parts)
    found = multipliers_with_root(nodes, parts, root, order)
    after = refined(nodes, found, waste, np.zeros(cells))
    assert np.flatnonzero(cut(nodes, after)).tolist() == [cell]
    left, right = after[after <= root].max(), after[after > root].min()
    assert right - left <= 0.25 * width, (left, root, right)


@given(SEEDS, st.sampled_from([1, 2, 3]))
def test_slack_multipliers_cut_their_cells_and_nothing_lost_leaves_the_grid(seed, parts):
    rng = np.random.default_rng(seed)
    cells = 12
    nodes = random_nodes(rng, cells)
    found = multipliers_with_root(nodes, parts, 0.37)
    nothing, slack = np.zeros(parts * cells), rng.exponential(size=cells)
    np.testing.assert_array_equal(refined(nodes, found, nothing, np.zeros(cells)), nodes)
    chosen = cut(nodes, refined(nodes, found, nothing, slack))
    assert slack[chosen].sum() >= 0.75 * slack.sum()
    assert slack[chosen].min() >= slack[~chosen].max(initial=0.0)


# Where no multiplier tells


@pytest.mark.parametrize(
    ("inputs", "levels", "expected"),
    [
        ([1, 1, 0.5, -1, -1], [0, 0.5, 1, -1, -0.5, 0], [2]),
        ([1, 1, 0.5, 0.5, -1], [0, 0.5, 1, 0.3, -0.2, 0], [2, 3]),
        ([1, 1, 0.5, -1, -1], [0, 0.5, 1, 0.8, -0.5, 0], []),
        ([1, 1, 0, -1, -1], [0, 0.5, 1, -1, -0.5, 0], []),
        ([0.5, 0.5, 0.5, 0.5, 0.5], [0, 0.5, 1, -1, -0.5, 0.95], []),
        ([0.5, 1, 1, 1, 1], [-1, 1, 1, 1, 1, 1], [0]),
    ],
    ids=["sudden", "in two cells", "not far", "input zero", "in many cells", "at the start"],
)
def test_cells_are_cut_in_which_a_derivative_crosses_its_range(inputs, levels, expected):
    nodes = np.array([0.0, 0.1, 0.4, 0.5, 0.9, 1.0])
    both = np.array([levels, np.zeros(6)])
    for sign in (1.0, -1.0):
        after = split_sudden(nodes, 7.0 * sign * np.array(inputs, float), 7.0, sign * both)
        assert np.flatnonzero(cut(nodes, after)).tolist() == expected


@pytest.mark.parametrize("order", [4, 5, 6])
def test_nodes_are_added_where_a_derivative_turns_at_its_peak(order):
    """x^(k) of a perfect spline turns where x^(k+1) is zero: compared with a dense search."""
    spline = perfect_spline(3.0, order, 2.0)
    half = 0.5 * spline.duration
    times = np.linspace(0.0, half, 200_001)
    for k in range(2, order - 1):
        values = np.abs(spline(times, k))
        turns = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
        highest = times[turns[values[turns] >= 0.99 * spline.peak(k)]] / half
        nodes = with_touches(np.array([0.0, 1.0]), spline, [k], half)
        assert nodes[1:-1] == pytest.approx(highest, abs=1e-4), f"derivative {k}"
        assert len(with_touches(nodes, spline, [k], half)) == len(nodes)  # they are there
    assert with_touches(np.array([0.0, 1.0]), spline, [], half).tolist() == [0.0, 1.0]
