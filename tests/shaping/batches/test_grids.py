"""Values on a grid: the same however the work is cut up."""

import numpy as np
import pytest
from move_batches import random_moves, together

from jounce.shaping.batches import grids


@pytest.mark.parametrize("order", [3, 5])
@pytest.mark.parametrize("points", [1, 7, 100, 10**6])
def test_blocks_of_points_do_not_matter(order, points, monkeypatch):
    batch = together(random_moves((1, order), order, 9))
    t = np.linspace(-0.5, batch.duration.max() * 1.1, 60)
    expected = batch.evaluate(t)
    monkeypatch.setattr(grids, "_POINTS", points)
    np.testing.assert_array_equal(batch.evaluate(t), expected)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_at_a_break_the_value_is_the_one_after_it(order):
    batch = together(random_moves((2, order), order, 5))
    breaks, durations, states = batch.pieces()
    for i in range(5):
        values = batch[i : i + 1].evaluate(breaks[i, :-1])[:, 0]
        for j in np.flatnonzero(durations[i] > 0.0):
            if j == 0 or breaks[i, j] > breaks[i, j - 1]:
                np.testing.assert_array_equal(values[:, j], states[i, j])


def test_a_grid_longer_than_a_block():
    batch = together(random_moves(3, 3, 2))
    t = np.linspace(0.0, batch.duration.max(), 20_001)
    values = batch(t)
    for i in range(2):
        np.testing.assert_allclose(values[i], batch[i](t), rtol=0, atol=1e-12)
