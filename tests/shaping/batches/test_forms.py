"""Plans of many moves: every form occurs, and is the fastest of its move."""

import numpy as np
import pytest
from move_batches import MoveProblem, random_moves, together

from jounce.shaping.batches import closed_forms
from jounce.shaping.batches.forms import piece_count
from jounce.shaping.closed_form import chain_form, swing_form


@pytest.mark.parametrize("order", [4, 5, 6])
def test_the_form_is_the_fastest(order):
    problems = random_moves((1, order), order, 300)
    batch = together(problems)
    for problem, form, duration in zip(problems, batch.problems.forms, batch.duration, strict=True):
        bounds = [high for _, high in problem.bounds]
        plans = [chain_form(abs(problem.distance), bounds, level) for level in range(order)]
        swing = swing_form(abs(problem.distance), bounds)
        lengths = [plan.duration for plan in plans] + ([swing.duration] if swing else [])
        assert duration == pytest.approx(min(lengths), rel=1e-14), problem
        assert lengths[form] == pytest.approx(min(lengths), rel=1e-14), problem
    assert {0, order}.issubset(np.unique(batch.problems.forms).tolist())
    assert len(np.unique(batch.problems.forms)) >= 4


@pytest.mark.parametrize("order", range(4, 7))
def test_no_move_has_more_pieces_than_its_form(order):
    problems = random_moves((2, order), order, 60)
    problems.append(MoveProblem(0.0, 0.0, problems[0].bounds))
    batch = together(problems)
    durations = batch.pieces().durations
    counts = [piece_count(order, int(form)) for form in batch.problems.forms]
    assert durations.shape[1] == max(counts)
    for row, count in zip(durations, counts, strict=True):
        assert not row[count:].any()
    assert piece_count(order, order - 1) == 2**order - 1


def test_what_rounding_spoils_is_refused(monkeypatch):
    """It takes worse bounds than a double can hold to get there, so the tolerance is lowered."""
    batch = together(random_moves(2, 4, 6))
    monkeypatch.setattr(closed_forms, "_SPOILT", -1e-3)
    with pytest.raises(ValueError, match=r"limit of move [0-5] cannot be kept in double precision"):
        batch.pieces()
    with pytest.raises(ValueError, match="limit of move 3 cannot be kept in double precision"):
        batch[3]
