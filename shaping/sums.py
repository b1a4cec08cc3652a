"""Sums of trajectories: the union of their breaks, exact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .pieces import FloatArray, evaluate
from .piecewise_polynomial import PiecewisePolynomial

_SAME = 1e-14  # breaks this near to one another, relative to all times, are one


def weighted_sum(
    parts: Sequence[PiecewisePolynomial], weights: Sequence[float]
) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return breaks, states, end state and coasting of Σ weights[i]·parts[i], functions of time.

    Where one part is before its start or after its end it coasts.
    """
    order = max(part.order for part in parts)
    times = np.unique(np.concatenate([part.breaks for part in parts]))
    slack = _SAME * float(np.abs(times[[0, -1]]).max())
    times = times[np.append(True, np.diff(times) > slack)]
    states, coasting = np.zeros((len(times), order + 1)), order
    for part, weight in zip(parts, weights, strict=True):
        states[:, : part.order + 1] += weight * _states_at(part, times, slack)
        coasting = min(coasting, part.coasting)
    return times, states[:-1], states[-1].copy(), coasting


def _states_at(part: PiecewisePolynomial, times: FloatArray, slack: float) -> FloatArray:
    """Return position and derivatives just after times, a row each."""
    before, after = part.start_state.copy(), part.end_state.copy()
    before[part.coasting + 1 :] = after[part.coasting + 1 :] = 0.0
    rows = np.vstack([before, part.states, after])
    starts = np.concatenate([part.breaks[:1], part.breaks])
    piece = np.searchsorted(part.breaks, times + slack, side="right")
    passed = times - starts[piece]
    passed[np.abs(passed) <= slack] = 0.0
    return evaluate(rows[piece].T, passed, range(part.order + 1)).T
