"""Blocks of moves: all moves once, their breaks, and bounds spoilt by rounding."""

import numpy as np
import pytest
from move_batches import random_moves, together

from jounce.shaping import Limits
from jounce.shaping.batches import blocks as module
from jounce.shaping.batches.blocks import Moves, blocks, index_text, spoilt_bound, spoilt_text
from jounce.shaping.batches.many_limits import many_limits


def moves_of(batch):
    return Moves(batch.distances, batch.starts, batch.limits, batch.duration, batch.forms)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("at_once", [1, 500, 10**6])
def test_every_move_is_in_one_block(order, at_once, monkeypatch):
    monkeypatch.setattr(module, "_STATES", at_once)
    batch = together(random_moves((1, order), order, 25, even=False))
    seen = []
    for block in blocks(moves_of(batch)):
        lanes = np.arange(25)[block.lanes]
        seen += lanes.tolist()
        assert block.breaks.shape == (len(block.durations) + 1, len(lanes))
        np.testing.assert_array_equal(block.breaks[0], 0.0)
        np.testing.assert_array_equal(block.breaks[-1], batch.duration[lanes])
        np.testing.assert_allclose(
            np.diff(block.breaks, axis=0), block.durations, rtol=0, atol=1e-14 * block.breaks.max()
        )
        np.testing.assert_array_equal(block.starts, batch.starts[lanes])
        np.testing.assert_array_equal(block.ends, (batch.starts + batch.distances)[lanes])
        np.testing.assert_array_equal(block.states[0, 0], batch.starts[lanes])
    assert sorted(seen) == list(range(25))


def test_spoilt_bounds_are_found():
    limits = many_limits(Limits(2.0, (-3.0, 4.0)))
    states = np.zeros((3, 2, 4))
    states[1:, 0] = [[2.0] * 4, [4.0] * 4]
    states[1:, 1] = [[-2.0] * 4, [-3.0] * 4]
    assert spoilt_bound(states, limits) is None
    for k, lane, value in ((1, 2, 2.0 + 1e-10), (2, 1, -3.0 - 1e-10), (2, 3, np.nan)):
        wrong = states.copy()
        wrong[k, 1, lane] = value
        assert spoilt_bound(wrong, limits) == (k, lane)


def test_what_is_spoilt_is_refused(monkeypatch):
    """It takes worse bounds than a double can hold to get there, so the tolerance is lowered."""
    batch = together(random_moves(2, 4, 6))
    monkeypatch.setattr(module, "_SPOILT", -1e-3)
    with pytest.raises(ValueError, match=r"limit of move [0-5] cannot be kept in double precision"):
        batch.pieces()
    with pytest.raises(ValueError, match="limit of move 3 cannot be kept in double precision"):
        batch[3]


def test_indices_are_told_as_numpy_has_them():
    assert index_text(7, (10,)) == "7"
    assert index_text(7, (3, 4)) == "1, 3"
    assert spoilt_text(3, "1, 3").startswith("the jerk limit of move 1, 3 cannot")
