"""Readings of an encoder: times and positions checked, equal ones in a row taken as one."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping.trajectory_checks import finite_array

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

FEWEST = 16
"""Readings that a log must have, and each part of it between pauses."""

PAUSE = 100.0
"""Time without a reading that parts a log, in median times from reading to reading."""

_LARGEST = 1e30  # beyond, powers of times and positions leave the range of a double
_LONGEST = 4  # of a run taken as one reading, in median runs


def checked_log(times: ArrayLike, positions: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return times and positions as arrays; ValueError where they are no log."""
    time, position = finite_array("times", times), finite_array("positions", positions)
    if time.ndim != 1 or time.shape != position.shape:
        raise ValueError(
            f"times of shape {time.shape} and positions of shape {position.shape} do not fit: "
            "expected two arrays of shape (N,)"
        )
    if len(time) < FEWEST:
        raise ValueError(f"{len(time)} readings are too few: expected at least {FEWEST}")
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if len(backward):
        row = int(backward[0]) + 1
        fault = "repeats" if time[row] == time[row - 1] else "is before"
        raise ValueError(
            f"times[{row}] = {float(time[row])!r} {fault} the time of the row before, "
            f"{float(time[row - 1])!r}: expected strictly increasing times; sort the rows and "
            "leave repeated ones out"
        )
    _check_range("times span", float(time[-1]) - float(time[0]))
    _check_range("positions reach", float(np.abs(position).max()) or 1.0)
    _check_range("positions span", float(np.ptp(position)) or 1.0)
    return time, position


def _check_range(what: str, value: float) -> None:
    if not 1.0 / _LARGEST <= value <= _LARGEST:
        raise ValueError(
            f"{what} {value!r}: expected {1.0 / _LARGEST:.0e} to {_LARGEST:.0e}; choose units "
            "nearer to the problem's own"
        )


def reading_time(times: FloatArray) -> float:
    """Return the time from reading to reading, but for the farthest twentieth."""
    return float(np.quantile(np.diff(times), 0.95))


def parts(times: FloatArray) -> list[slice]:
    """Return the parts of a log between pauses, those with enough readings."""
    steps = np.diff(times)
    ends = 1 + np.flatnonzero(steps > PAUSE * np.median(steps))
    edges = [0, *ends.tolist(), len(times)]
    pieces = [slice(*pair) for pair in pairwise(edges)]
    return [piece for piece in pieces if piece.stop - piece.start >= FEWEST]


def found_resolution(positions: FloatArray) -> float:
    """Return the smallest step of readings most of which repeat the one before, else zero."""
    steps = np.abs(np.diff(positions))
    taken = steps[steps > 0.0]
    return float(taken.min()) if 0 < 2 * len(taken) < len(steps) else 0.0


def merged(times: FloatArray, positions: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return readings in which equal ones in a row are one, at the middle of their time.

    An encoder that is read more often than it counts repeats itself: its errors then go on from
    reading to reading, and a fit that took them for independent would follow every count. Runs
    longer than four times their median, as at rest, or than a sixteenth of the log are divided.

    Returns
    -------
    times, positions : (M,) array
    share : float
        Independent readings per reading returned: less than 1 in a log of few counts, where
        the usual run had to be divided.
    """
    starts = np.flatnonzero(np.concatenate([[True], positions[1:] != positions[:-1]]))
    lengths = np.diff(np.append(starts, len(positions)))
    longest = min(_LONGEST * int(np.median(lengths)), len(positions) // FEWEST)
    parts = -(-lengths // longest)
    run = np.repeat(np.arange(len(lengths)), parts)
    part = np.arange(len(run)) - np.repeat(np.cumsum(parts) - parts, parts)
    first = starts[run] + part * lengths[run] // parts[run]
    last = starts[run] + (part + 1) * lengths[run] // parts[run] - 1
    return 0.5 * (times[first] + times[last]), positions[first], 1.0 / float(np.median(parts))
