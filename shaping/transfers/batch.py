"""Many transfers at once, on arrays."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from os import cpu_count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import core
from ..checks import range_error
from ..derivatives import derivative_name
from ..frozen import Frozen
from ..limits import Limits
from ..pieces import FloatArray
from ..real_numbers import real_array
from ..trajectory_checks import finite_array
from .problem import Transfer, check_order
from .transfer import min_time_transfer

_SOME = 4096  # problems that are worth a thread of their own
_TASKS = 4  # for each processor, which evens out problems that take long


@dataclass(frozen=True, eq=False)
class TransferBatch(Frozen):
    """Minimum-time transfers of N problems.

    Attributes
    ----------
    duration : (N,) array
        NaN where the end cannot be reached.
    inside_after : (N,) array
        As in `Transfer`; NaN where the end cannot be reached.
    starts, ends : (N, order) arrays
        The states asked for.
    bounds : (N, order, 2) array
        Lower and upper bounds, velocity first.
    counts : (N,) array
        Numbers of pieces.
    """

    duration: FloatArray
    inside_after: FloatArray
    starts: FloatArray
    ends: FloatArray
    bounds: FloatArray
    counts: NDArray[np.int8]

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Which ends can be reached, (N,)."""
        return np.asarray(~np.isnan(self.duration))

    @cached_property
    def _pieces(self) -> tuple[FloatArray, FloatArray]:
        count, order = self.starts.shape
        most = int(self.counts.max(initial=0))
        lengths, states = np.empty((count, most)), np.empty((count, most, order + 1))
        ends = np.empty((count, order + 1))

        def some(part: slice) -> None:
            problems = self.starts[part], self.ends[part], self.bounds[part]
            core.transfer_pieces(order, *problems, most, lengths[part], states[part], ends[part])

        _in_threads(some, count)
        for array in (lengths, states):
            array.flags.writeable = False
        return lengths, states

    @property
    def piece_durations(self) -> FloatArray:
        """Of up to m pieces each, zero for those that a transfer does not need, (N, m)."""
        return self._pieces[0]

    @property
    def piece_states(self) -> FloatArray:
        """Position and derivatives at the start of each piece, (N, m, order + 1)."""
        return self._pieces[1]

    def __repr__(self) -> str:
        feasible = int(np.count_nonzero(self.feasible))
        return f"TransferBatch(problems={len(self)}, feasible={feasible})"

    def __len__(self) -> int:
        return len(self.duration)

    def transfer(self, i: int) -> Transfer:
        """Return transfer i as a trajectory; InfeasibleError where there is none."""
        limits = Limits.from_bounds([tuple(pair) for pair in self.bounds[i].tolist()])
        return min_time_transfer(self.starts[i].tolist(), self.ends[i].tolist(), limits)


def min_time_transfers(
    starts: ArrayLike, ends: ArrayLike, limits: Limits | ArrayLike
) -> TransferBatch:
    """Return the fastest motions between many pairs of states: `min_time_transfer` on arrays.

    Parameters
    ----------
    starts, ends : (N, order) arrays
        Position, velocity and, for order 3, acceleration; those left out at the end are zero. One
        state (order,) stands for all.
    limits : Limits or (N, order) or (N, order, 2) array
        The same for all, or magnitudes or (lower, upper) pairs, velocity first; infinite where
        there is no bound.

    Returns
    -------
    TransferBatch

    Raises
    ------
    ValueError
        For arrays that do not fit or are not finite, or bounds that do not enclose zero. Ends that
        cannot be reached raise nothing: their duration is NaN.

    Notes
    -----
    Each is planned as `min_time_transfer` does, to the last bit, on all processors. A problem takes
    some 100 bytes; its pieces, another 200 to 500, are worked out when they are asked for.

    Examples
    --------
    >>> batch = min_time_transfers([0.0], [[1.0], [2.0]], Limits(acceleration=1.0))
    >>> batch.duration
    array([2.        , 2.82842712])
    """
    begin, finish, bounds = _checked(starts, ends, limits)
    count, order = begin.shape
    times = np.empty(count), np.empty(count)
    statuses, counts = np.empty(count, np.int8), np.empty(count, np.int8)

    def some(part: slice) -> None:
        problems = begin[part], finish[part], bounds[part]
        duration, inside = (each[part] for each in times)
        core.transfers(order, *problems, duration, inside, statuses[part], counts[part])

    _in_threads(some, count)
    if (statuses == core.RANGE).any():
        raise range_error()
    batch = TransferBatch(*times, begin, finish, bounds, counts)
    for array in vars(batch).values():
        array.flags.writeable = False
    return batch


def _in_threads(work: Callable[[slice], None], count: int) -> None:
    """Do work on parts of `count` problems, on all processors where there are many."""
    parts = max(1, min(count // _SOME, _TASKS * (cpu_count() or 1)))
    edges = [count * i // parts for i in range(parts + 1)]
    slices = [slice(i, j) for i, j in itertools.pairwise(edges)]
    if parts == 1:
        work(slices[0])
        return
    with ThreadPoolExecutor(cpu_count()) as pool:
        list(pool.map(work, slices))


def _checked(
    starts: ArrayLike, ends: ArrayLike, limits: Limits | ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts and ends (N, order) and bounds (N, order, 2)."""
    if isinstance(limits, Limits):
        check_order(limits)
        bounds = np.array([limits.lower, limits.upper]).T
    else:
        bounds = np.array(real_array("limits", limits))
        if bounds.ndim < 3:
            bounds = np.stack([-bounds, bounds], axis=-1)
    order = bounds.shape[-2] if bounds.ndim > 1 else 0
    if order not in (2, 3) or bounds.shape[-1] != 2:
        raise ValueError(
            f"limits of shape {bounds.shape}: expected Limits of order 2 or 3, or an array "
            "(N, order) of magnitudes or (N, order, 2) of pairs"
        )
    _check_bounds(bounds.reshape(-1, order, 2))
    states = [_states(name, value, order) for name, value in (("starts", starts), ("ends", ends))]
    shapes = [bounds.shape[:-2], *(state.shape[:-1] for state in states)]
    try:
        (count,) = np.broadcast_shapes((1,), *shapes)
    except ValueError:
        raise ValueError(
            f"starts, ends and limits of {shapes[1]}, {shapes[2]} and {shapes[0]} problems do not "
            "fit: expected the same number N, or one for all"
        ) from None
    begin, finish = (
        np.ascontiguousarray(np.broadcast_to(state, (count, order))) for state in states
    )
    return begin, finish, np.ascontiguousarray(np.broadcast_to(bounds, (count, order, 2)))


def _check_bounds(bounds: FloatArray) -> None:
    low, high = bounds[..., 0], bounds[..., 1]
    wrong = ~((low < 0.0) & (high > 0.0))
    wrong[:, -1] |= ~(np.isfinite(low[:, -1]) & np.isfinite(high[:, -1]))
    if wrong.any():
        i, k = np.argwhere(wrong)[0]
        raise ValueError(
            f"{derivative_name(int(k) + 1)} limit {bounds[i, k].tolist()} of problem {i}: expected "
            "lower < 0 < upper, finite for the highest derivative"
        )


def _states(name: str, given: ArrayLike, order: int) -> FloatArray:
    """Return states (…, order), what is left out filled with zeros."""
    states = np.atleast_1d(finite_array(name, given))
    if not states.size:
        states = np.empty((0, order))
    missing = order - states.shape[-1]
    if missing < 0 or states.ndim > 2:
        raise ValueError(
            f"{name} of shape {states.shape}: expected (N, {order}) or ({order},), position first"
        )
    return np.pad(states, [(0, 0)] * (states.ndim - 1) + [(0, missing)])
