"""Arrays of tasks and of profiles: named tuples whose fields are arrays of one length."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray
from .task import ROUNDING

Tasks = Any
"""A `Task` of arrays."""

Profiles = Any
"""A profile of order 2 or 3 of arrays."""

Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


def take(rows: Any, which: Any) -> Any:
    """Return some rows of a named tuple of arrays."""
    return type(rows)(*(field[which] for field in rows))


def choose(where: Mask, rows: Any, others: Any) -> Any:
    """Return `rows` where a mask holds, else `others`."""
    return type(rows)(*(np.where(where, a, b) for a, b in zip(rows, others, strict=True)))


def mirror_where(where: Mask, tasks: Tasks) -> Tasks:
    """Return the tasks, some of them seen in the opposite direction."""
    return choose(where, tasks.mirror(), tasks)


def put(rows: Any, which: Any, others: Any) -> Any:
    """Return the rows with some of them replaced by others."""
    replaced = [np.array(field) for field in rows]
    for field, values in zip(replaced, others, strict=True):
        field[which] = values
    return type(rows)(*replaced)


def inside(values: FloatArray, low: FloatArray | float, high: FloatArray | float) -> FloatArray:
    """Return values, an excess over their bounds that is mere rounding cut off: `brake.inside`."""
    with np.errstate(invalid="ignore"):
        values = np.where(
            (values > high) & (values <= high + ROUNDING * np.abs(high)), high, values
        )
        return np.where((values < low) & (values >= low - ROUNDING * np.abs(low)), low, values)
