"""Sources that are known in advance: numbers, trajectories, functions of time, tables."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from ...shaping.checks import finite
from ...shaping.pieces import FloatArray
from ...shaping.trajectory import Motion
from ..importing.description import FmuError

Source = Any
"""A number, a Trajectory, a function of time, or a pair (times, values) of arrays."""

_ON_GRID = 1e-9


def over_time(
    source: Source, target: str, time: FloatArray, *, steps: bool, exact: bool = False
) -> tuple[FloatArray, str]:
    """Return the values of a source at communication points, and what the user should know of it.

    Parameters
    ----------
    source : float, Trajectory, callable or pair of (M,) arrays
        A trajectory gives its position. A function is called with each time. A table's values
        are joined by straight lines, or held where `steps` is set; at a time that stands twice
        it jumps; before its first and after its last time it is held. Truth values are taken
        where `steps` is set.
    target : str
        The input, for messages.
    time : (N + 1,) array
        Equally spaced.
    steps : bool
        Whether the input changes in steps only, as discrete variables do.
    exact : bool, optional
        Whether whole numbers stay as they are, in an array of objects, for an input of 64 bits.

    Returns
    -------
    values : (N + 1,) array
    note : str
        Where a table is held beyond its ends; else empty.

    Raises
    ------
    TypeError
        For a source of another kind.
    FmuError
        For tables of unequal length, times that decrease, values that are not finite.
    """
    if isinstance(source, Motion):
        return np.asarray(source(time)), ""
    if callable(source):
        name = f"source of {target} at time"
        found = [_one(f"{name} {t:g}", source(t), steps=steps, exact=exact) for t in time.tolist()]
        return np.array(found, object if exact else float), ""
    if isinstance(source, Sequence | np.ndarray) and not isinstance(source, str | bytes):
        times, values = _table(source, target, exact=exact)
        return _between(times, values, time, steps), _beyond(times, time, target)
    if np.ndim(source) or isinstance(source, str | bytes | None):
        raise TypeError(
            f"source of {target} is a {type(source).__name__}: expected 'block.output', a number, "
            "a Trajectory, a function of time or a pair of arrays (times, values)"
        )
    value = _one(f"source of {target}", source, steps=steps, exact=exact)
    return np.full(time.shape, value, object if exact else float), ""


def scaled(source: Source, gain: float, offset: float) -> Source:
    """Return gain·source + offset."""
    if (gain, offset) == (1.0, 0.0):
        return source
    if callable(source):  # which a trajectory is, too
        return lambda t: gain * source(t) + offset
    if isinstance(source, Sequence | np.ndarray) and len(source) == 2:
        return source[0], gain * np.asarray(source[1], dtype=float) + offset
    return gain * finite("source", source) + offset


def _one(name: str, value: Any, *, steps: bool, exact: bool) -> float:
    """Return one value; whole numbers as they are where they are wanted so."""
    truth = isinstance(value, bool | np.bool_)
    if (truth and steps) or (exact and isinstance(value, Integral) and not truth):
        return int(value)
    return finite(name, value)


def _table(
    source: Sequence[Any] | np.ndarray, target: str, *, exact: bool
) -> tuple[FloatArray, FloatArray]:
    if len(source) != 2:
        raise FmuError(
            f"source of {target} has {len(source)} parts: expected a pair of arrays (times, values)"
        )
    times = _row(source[0], "times", target)
    values = _row(source[1], "values", target, exact=exact)
    if times.shape != values.shape or not times.size:
        raise FmuError(
            f"source of {target}: {times.size} times and {values.size} values; expected as many "
            "of each, at least one"
        )
    if (np.diff(times) < 0.0).any():
        at = int(np.argmin(np.diff(times) >= 0.0))
        raise FmuError(
            f"source of {target}: time {times[at + 1]:g} comes after {times[at]:g}; sort the table "
            "by time"
        )
    return times, values


def _row(part: Any, name: str, target: str, *, exact: bool = False) -> FloatArray:
    found = np.asarray(part, object if exact else None)
    plain = found.dtype.kind in "biuf" or all(isinstance(v, Real | np.bool_) for v in found.flat)
    if found.ndim != 1 or not plain:
        raise TypeError(f"{name} of the source of {target}: expected a row of numbers")
    row = found.astype(float)
    if not np.isfinite(row).all():
        at = int(np.argmin(np.isfinite(row)))
        raise FmuError(f"{name}[{at}] of the source of {target} = {row[at]}: expected a number")
    if exact:
        row = np.array([int(v) if float(v).is_integer() else float(v) for v in found], object)
    return row


def _between(times: FloatArray, values: FloatArray, time: FloatArray, steps: bool) -> FloatArray:
    near = _ON_GRID * (time[1] - time[0])  # a grid that is added up misses a jump by rounding
    following = np.searchsorted(times, time + near, side="right")
    left = np.maximum(following - 1, 0)
    if steps:
        return np.asarray(values[left])
    right = np.minimum(following, times.size - 1)
    span = times[right] - times[left]
    inside = span > 0.0
    part = np.clip((time - times[left]) / np.where(inside, span, 1.0), 0.0, 1.0) * inside
    return np.asarray((1.0 - part) * values[left] + part * values[right])


def _beyond(times: FloatArray, time: FloatArray, target: str) -> str:
    if times.size == 1:
        return ""
    near = _ON_GRID * (time[1] - time[0])
    told = []
    if times[0] > time[0] + near:
        told.append(f"its first value until {times[0]:g}")
    if times[-1] < time[-2] - near:
        told.append(f"its last value from {times[-1]:g} on")
    return f"{target} holds {' and '.join(told)}: its table says no more" if told else ""
