"""Plans of many moves: every form occurs, and is the fastest of its move."""

import numpy as np
import pytest
from move_batches import MoveProblem, random_moves, together

from jounce.shaping.batches.plans import most_pieces, piece_count, pieces
from jounce.shaping.closed_form import chain_plan, swing_plan


@pytest.mark.parametrize("order", [4, 5, 6])
def test_the_form_is_the_fastest(order):
    problems = random_moves((1, order), order, 300)
    batch = together(problems)
    for problem, form, duration in zip(problems, batch.forms, batch.duration, strict=True):
        bounds = [high for _, high in problem.bounds]
        plans = [chain_plan(abs(problem.distance), bounds, level) for level in range(order)]
        swing = swing_plan(abs(problem.distance), bounds)
        lengths = [plan.duration for plan in plans] + ([swing.duration] if swing else [])
        assert duration == pytest.approx(min(lengths), rel=1e-14), problem
        assert lengths[form] == pytest.approx(min(lengths), rel=1e-14), problem
    assert {0, order}.issubset(np.unique(batch.forms).tolist())
    assert len(np.unique(batch.forms)) >= 4


@pytest.mark.parametrize("order", range(1, 7))
def test_pieces_are_as_many_as_foretold(order):
    problems = random_moves((2, order), order, 60)
    problems.append(MoveProblem(0.0, 0.0, problems[0].bounds))
    batch = together(problems)
    forms = np.broadcast_to(batch.forms, 61)
    seen, most = [], 0
    for lanes, durations, states in pieces(batch.distances, batch.limits, forms):
        chosen = np.arange(61)[lanes]
        [form] = np.unique(forms[chosen])
        assert len(durations) == states.shape[1] == piece_count(order, int(form))
        np.testing.assert_allclose(durations.sum(axis=0), batch.duration[chosen], rtol=1e-13)
        assert (np.sign(states[1].sum(axis=0)) == np.sign(batch.distances[chosen])).all()
        most = max(most, len(durations))
        seen += chosen.tolist()
    assert sorted(seen) == list(range(61))
    assert most == most_pieces(order, forms)
    assert piece_count(order, order - 1 if order > 3 else 0) == 2**order - 1
