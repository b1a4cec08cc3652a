"""Figures of a response in exact continuous time: extremes, mean square, largest torque."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np

from .loop_response import LoopResponse, Of
from .signal_pieces import Pieces


def load_extremes(
    response: LoopResponse, target: float | None = None, *, of: Of = "load", after: float = 0.0
) -> tuple[float, float]:
    """Return the least and the largest of position less target.

    Parameters
    ----------
    response : LoopResponse
        One that knows what was simulated.
    target : float, optional
        Default: the command, wherever it moves.
    of : "position" or "load", optional
    after : float, optional
        Time from the start from which on it counts.
    """
    return _position(response, target, of, after).extremes()


def rms_error(response: LoopResponse, *, of: Of = "load", after: float = 0.0) -> float:
    """Return √(mean of (r − position)²) from `after` the start on."""
    pieces = _position(response, None, of, after)
    count = len(pieces.rows)
    nodes, weights = np.polynomial.legendre.leggauss(count)
    values = (0.5 + 0.5 * nodes)[:, None] ** np.arange(count) @ pieces.scaled
    squares = 0.5 * weights @ values**2
    return sqrt(float(squares @ pieces.durations / pieces.durations.sum()))


def peak_torque(response: LoopResponse, *, of_motor: bool = False) -> float:
    """Return the largest |u|, or of the motor's torque behind the current loop."""
    run = response.run
    rows, largest = run.torque_rows if of_motor else run.hybrid.torque, 0.0
    for mode in np.unique(run.modes[:-1]):
        some = run.modes[:-1] == mode
        low, high = _of(run.pieces(rows[mode], 0.0), some).extremes()
        largest = max(largest, high, -low)
    return largest


def _position(response: LoopResponse, target: float | None, of: Of, after: float) -> Pieces:
    run = response.run
    row = run.load_row if of == "load" else run.seen_row
    pieces = run.pieces(row, -1.0 if target is None else 0.0, target or 0.0)
    return _later(pieces, after) if after > 0.0 else pieces


def _of(pieces: Pieces, some: Any) -> Pieces:
    """Return some of the pieces."""
    times, durations = pieces.times[some], pieces.durations[some]
    return replace(pieces, times=times, durations=durations, rows=pieces.rows[:, some])


def _later(pieces: Pieces, begin: float) -> Pieces:
    """Return the pieces from a time on, the one within which it lies cut there."""
    ends = pieces.times + pieces.durations
    kept = _of(pieces, ends > begin)
    if not kept.times.size or kept.times[0] >= begin:
        return kept
    ahead = begin - float(kept.times[0])
    rows, count = kept.rows.copy(), len(kept.rows)
    powers = np.cumprod(np.append(1.0, ahead / np.arange(1.0, count)))
    for k in range(count):
        rows[k, 0] = powers[: count - k] @ kept.rows[k:, 0]
    times, durations = kept.times.copy(), kept.durations.copy()
    times[0], durations[0] = begin, durations[0] - ahead
    return replace(kept, times=times, durations=durations, rows=rows)
