"""The grid of a motion that none was found of: as fine at its ends as motions to rest are."""

from dataclasses import replace

import numpy as np
import pytest

from jounce.shaping.optimal.whole.by_rest import grid_by_rest
from jounce.shaping.optimal.whole.problem import WholeProblem
from jounce.shaping.optimal.whole.search import Search
from jounce.shaping.optimal.whole.warm_program import Effort

QUICK = np.array([np.inf, 1.0, 20.0, 1e3])
LONG = WholeProblem(np.array([0.0, 0.5, -5.0]), np.array([2.0, 0.4, 4.0]), -QUICK, QUICK)


def test_cells_at_both_ends_are_as_long_as_those_of_motions_to_rest():
    grid = grid_by_rest(LONG, 2.0, Effort())
    assert (grid[0], grid[-1]) == (0.0, 1.0)
    assert (np.diff(grid) > 0.0).all()
    stop = Search(replace(LONG, end=np.array([1.0, 0.0, 0.0])))
    stop.run(0.1)
    begun = stop.nodes * stop.best.time / 2.0
    np.testing.assert_allclose(grid[:5], begun[:5], rtol=1e-12)


def test_the_grid_ends_with_the_motion_however_short_its_last_cells():
    grid = grid_by_rest(LONG, 3e6, Effort())
    assert (grid[0], grid[-1]) == (0.0, 1.0)


@pytest.mark.parametrize("ending", ["start", "end"])
def test_either_may_be_at_rest(ending):
    rests = replace(LONG, **{ending: getattr(LONG, ending) * [1.0, 0.0, 0.0]})
    grid = grid_by_rest(rests, 2.0, Effort())
    assert (np.diff(grid) > 0.0).all()
    search = Search(rests, grid)
    search.run(1e-3)
    assert search.gap <= 1e-3


def test_where_nothing_can_turn_back_there_is_none():
    forward = replace(LONG, lower=-QUICK * [1.0, 0.0, 1.0, 1.0])
    assert grid_by_rest(forward, 2.0, Effort()) is None
    assert grid_by_rest(LONG, 2.0, Effort(0.0)) is None
