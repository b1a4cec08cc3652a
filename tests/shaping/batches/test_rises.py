"""Pieces of closed-form plans on arrays: those that the scalar plans build."""

import numpy as np
import pytest

from jounce.shaping.batches.chains import chains
from jounce.shaping.batches.rises import chain_pieces, swing_pieces
from jounce.shaping.batches.swings import swings
from jounce.shaping.closed_form import chain_form, swing_form

COUNT = 12


def random_bounds(order):
    """Return bounds (order, COUNT) for distance 1."""
    rng = np.random.default_rng(order)
    return 8.0 ** np.arange(order)[:, None] * 10.0 ** rng.uniform(-0.5, 1.0, (order, COUNT))


def assert_same(durations, rows, rise, text):
    """Assert that one move's pieces are those of a rise, but for holds of duration 0."""
    rows, durations = rows[:, durations > 0.0], durations[durations > 0.0]
    assert durations == pytest.approx(rise.durations, rel=1e-12, abs=1e-14 * rise.span), text
    for k, (found, expected) in enumerate(zip(rows, rise.rows, strict=True)):
        scale = np.abs(expected).max()
        np.testing.assert_allclose(
            found, expected, rtol=0, atol=1e-13 * scale, err_msg=f"{text}: derivative {k}"
        )


@pytest.mark.parametrize("order", range(1, 8))
def test_chains(order):
    bounds = random_bounds(order)
    for level in range(order):
        with np.errstate(all="ignore"):
            plans = chains(np.ones(COUNT), list(bounds), level)
        durations, rows = chain_pieces(plans)
        assert rows.shape == (order + 1, len(durations), COUNT)
        for i, column in enumerate(bounds.T.tolist()):
            rise = chain_form(1.0, column, level).build()
            assert_same(durations[:, i], rows[..., i], rise, f"{column!r}, level {level}")


@pytest.mark.parametrize("order", range(3, 8))
def test_swings(order):
    bounds = random_bounds(order)
    bounds[0] = np.inf
    with np.errstate(all="ignore"):
        durations, rows = swing_pieces(swings(np.ones(COUNT), list(bounds)), np.ones(COUNT))
    assert durations.shape == (3 * (order - 2) + 2, COUNT)
    for i, column in enumerate(bounds.T.tolist()):
        rise = swing_form(1.0, column).build()
        assert_same(durations[:, i], rows[..., i], rise, repr(column))
