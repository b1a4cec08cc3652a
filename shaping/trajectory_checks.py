"""What the arrays of a trajectory must be."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .pieces import MAX_ORDER, FloatArray
from .real_numbers import real_array


def finite_array(name: str, values: ArrayLike | None) -> FloatArray:
    """Return a copy as an array of floats; ValueError unless all are finite."""
    return finite_numbers(name, values).copy()


def finite_numbers(name: str, values: ArrayLike | None) -> FloatArray:
    """Return the same, but an array of floats as it is."""
    array = real_array(name, values)
    finite = np.isfinite(array)
    if not finite.all():
        first = np.argwhere(~finite)[0]
        where = ", ".join(str(i) for i in first)
        element = f"{name}[{where}]" if where else name
        raise ValueError(f"{name} must be finite: {element} = {array[tuple(first)]}")
    return array


def check_shapes(breaks: FloatArray, states: FloatArray) -> None:
    """Refuse breaks and states other than (m + 1,) and (m, n + 1) with 1 ≤ n ≤ MAX_ORDER."""
    if breaks.ndim != 1 or states.ndim != 2 or len(breaks) != len(states) + 1:
        raise ValueError(
            f"breaks of shape {breaks.shape} and states of shape {states.shape} do not fit: "
            "expected (m + 1,) and (m, n + 1)"
        )
    if not 2 <= states.shape[1] <= MAX_ORDER + 1:
        raise ValueError(
            f"states has {states.shape[1]} columns: expected position and 1 to {MAX_ORDER} "
            "derivatives"
        )


def check_times(breaks: FloatArray, durations: FloatArray, *, exact: bool) -> None:
    """Refuse durations that are not positive or, unless `exact`, do not go with the breaks."""
    if durations.shape != (len(breaks) - 1,):
        raise ValueError(f"durations has shape {durations.shape}: expected {(len(breaks) - 1,)}")
    if not (durations > 0).all():
        raise ValueError(f"every piece must take time: got durations {durations}")
    if exact or not len(durations):
        return
    steps = breaks[1:] - breaks[:-1]
    rounding = 8.0 * np.finfo(float).eps * np.abs(breaks).max()
    if (steps < 0.0).any() or not np.abs(steps - durations).max() <= (
        rounding + 1e-9 * durations.sum()
    ):
        raise ValueError(f"durations differ from the differences of breaks: {durations}, {steps}")
