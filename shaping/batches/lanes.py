"""Problems of a batch counted in C order: some of them, their limits, and threads over all."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from math import prod
from os import cpu_count
from types import EllipsisType
from typing import SupportsIndex, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..limits import Limits, check_plain, one_sided
from ..pieces import FloatArray

AT_ONCE = 8192  # problems whose arrays stay in the processor's cache, worth a thread of their own

Shape = tuple[int, ...]

_Along = SupportsIndex | slice | EllipsisType | None | NDArray[np.intp] | NDArray[np.bool_]
Index = _Along | tuple[_Along, ...]
"""What selects some problems of a batch, as of numpy's arrays."""

_Number = TypeVar("_Number", bound=np.generic)


def in_threads(work: Callable[[slice], None], count: int, at_once: int = AT_ONCE) -> None:
    """Do work on parts of `count` problems, on all processors where there is more than one part."""
    parts = deque(slice(i, min(i + at_once, count)) for i in range(0, count, at_once))

    def some() -> None:
        while parts:
            try:
                part = parts.popleft()
            except IndexError:  # another thread took the last one
                return
            work(part)

    others = min(cpu_count() or 1, len(parts)) - 1
    if others < 1:
        some()
        return
    with ThreadPoolExecutor(others) as pool:
        helpers = [pool.submit(some) for _ in range(others)]
        some()
        for helper in helpers:
            helper.result()


def together(*shapes: Shape) -> list[FloatArray]:
    """Return arrays of doubles to be filled, in one piece of memory.

    A system hands out a large piece at once, several small ones page by page: that takes longer
    than to fill them.
    """
    ends = list(accumulate(prod(shape) for shape in shapes))
    memory = np.empty(ends[-1])
    starts = zip([0, *ends], ends, shapes, strict=False)
    return [memory[start:end].reshape(shape) for start, end, shape in starts]


def lanes(values: NDArray[_Number], shape: Shape, some: slice) -> NDArray[_Number]:
    """Return some of the values broadcast to a shape, counted in C order; a number stays one."""
    if not any(values.strides):
        return np.asarray(values[(0,) * values.ndim])
    if values.shape == shape and values.flags.c_contiguous:
        return values.reshape(-1)[some]
    return np.broadcast_to(values, shape).flat[some]


def sides(limits: Limits, shape: Shape, some: slice) -> list[tuple[FloatArray, FloatArray]]:
    """Return lower and upper bounds of some problems by derivative; numbers have no dimension."""
    pairs = zip(limits.lower, limits.upper, strict=True)
    low_high = [(np.asarray(low), np.asarray(high)) for low, high in pairs]
    return [(lanes(low, shape, some), lanes(high, shape, some)) for low, high in low_high]


def table(limits: Limits, shape: Shape, some: slice) -> FloatArray:
    """Return the bounds of some problems, (K, n, 2), or (1, n, 2) where all have the same."""
    if limits.shape == ():
        return np.array(limits.flat).reshape(1, -1, 2)
    count = len(range(*some.indices(prod(shape))))
    bounds = np.empty((count, limits.order, 2))
    for k, pair in enumerate(sides(limits, shape, some)):
        for side, values in enumerate(pair):
            bounds[:, k, side] = values
    return bounds


def limits_of(limits: Limits, shape: Shape, index: Index) -> Limits:
    """Return the limits of the problems that an index selects in a batch of this shape."""
    return limits.each(lambda side: np.broadcast_to(side, shape)[index])


def limits_of_one(limits: Limits, shape: Shape, index: Index) -> Limits:
    """Return the limits of one problem, of a lower order where its jerk is infinite."""
    own = limits_of(limits, shape, index)
    return Limits.from_bounds([own.bounds(k) for k in range(1, own.order + 1)])


def check_of_many(limits: Limits, check: Callable[[Limits], None]) -> None:
    """Refuse limits as `check` does, but for an infinite jerk of some problems of order 3."""
    if limits.order != 3 or limits.both_sides:
        check(limits)
        return
    check_plain(limits)
    acceleration, jerk = (
        np.isfinite(limits.lower[k]) & np.isfinite(limits.upper[k]) for k in (1, 2)
    )
    free = np.isinf(limits.lower[2]) & np.isinf(limits.upper[2])
    right = jerk | (free & acceleration)
    if not np.all(right):
        raise one_sided(limits, right, "both bounds of the highest derivative")


def index_text(problem: int, shape: Shape) -> str:
    """Return the index of a problem counted in C order."""
    return ", ".join(str(int(i)) for i in np.unravel_index(problem, shape))
