"""min_time_transfers: motions between two states, for arrays of states and bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import core
from ..batch import MotionBatch
from ..checks import range_error
from ..frozen import Frozen
from ..limits import Limits, not_limits
from ..pieces import FloatArray
from ..trajectory_checks import finite_numbers
from ..transfers.problem import Transfer, check_orders
from ..transfers.transfer import min_time_transfer
from .lanes import (
    Index,
    Shape,
    check_of_many,
    in_threads,
    index_text,
    limits_of,
    limits_of_one,
    table,
    together,
)
from .whole_transfers import WholeTransfers


def min_time_transfers(starts: ArrayLike, ends: ArrayLike, limits: Limits) -> MotionBatch:
    """Return the fastest motions between many pairs of states: `min_time_transfer` on arrays.

    Parameters
    ----------
    starts, ends : (N, order) arrays
        Position, velocity, …, of derivatives below the order; those left out at the end are zero.
        One state (order,) stands for all.
    limits : Limits
        Of order 2 to 10, of numbers, which hold for all, or of arrays. At order 3 the jerk of some
        problems may be infinite: they are planned as those of order 2.

    Returns
    -------
    MotionBatch
        N stands for any number of dimensions, which broadcast: with starts (50, 1, 3), ends (3,)
        and bounds (60,) the batch has the shape (50, 60).

    Raises
    ------
    ValueError
        For arrays that do not fit or are not finite, another order, or a highest derivative that is
        not bounded on both sides. Ends that cannot be reached raise nothing: their duration is NaN.
    TypeError
        For anything but Limits, or but real numbers in an array.

    Notes
    -----
    Each is planned as `min_time_transfer` does, to the last bit, on all processors. A problem takes
    some 70 bytes; its pieces, another 200 to 500, are worked out when they are asked for. At orders
    above 3, and with bounds on position or zero on a side, one is planned after the other, in the
    time that `min_time_transfer` takes, with its warnings, and kept as a whole.

    Examples
    --------
    >>> batch = min_time_transfers([0.0], [[1.0], [2.0]], Limits(acceleration=1.0))
    >>> batch.duration
    array([2.        , 2.82842712])
    """
    if not isinstance(limits, Limits):
        raise not_limits(limits)
    order = limits.order
    whole = order > 3 or not limits.plain
    if not whole:
        check_of_many(limits, check_orders)
    states = [_states(name, value, order) for name, value in (("starts", starts), ("ends", ends))]
    shape = _shape(*(state.shape[:-1] for state in states), limits.shape)
    if whole:
        found = WholeTransfers.planned(states[0], states[1], limits, shape)
        return MotionBatch(found.duration, np.where(np.isnan(found.duration), np.nan, 0.0), found)
    given = [_spread(state, shape) for state in states]
    wanted = [state.shape if any(state.strides[:-1]) else (0,) for state in given]
    *rooms, duration, inside_after = together(*wanted, shape, shape)
    begin, finish = own = [_room(state, room) for state, room in zip(given, rooms, strict=True)]
    statuses, counts = np.empty(shape, np.int8), np.empty(shape, np.int8)
    problems = Transfers(begin, finish, limits, counts)

    def some(part: slice) -> None:
        for room, state in zip(own, given, strict=True):
            if room.flags.writeable:  # memory is new: first touched by the thread that uses it
                _rows(room, part)[:] = _rows(state, part)
        times = duration.reshape(-1)[part], inside_after.reshape(-1)[part]
        told = statuses.reshape(-1)[part], counts.reshape(-1)[part]
        core.transfers(order, *problems.given(part), *times, *told)

    in_threads(some, duration.size)
    wrong = statuses == core.RANGE
    if wrong.any():
        raise range_error(f" of transfer {index_text(int(np.argmax(wrong)), shape)}")
    return MotionBatch(duration, inside_after, problems.frozen())


@dataclass(frozen=True, eq=False)
class Transfers(Frozen):
    """Starts and ends (N, order), limits that broadcast, and the number of pieces of each (N,).

    A number of pieces is zero where the end cannot be reached.
    """

    starts: FloatArray
    ends: FloatArray
    limits: Limits
    counts: NDArray[np.int8]

    def frozen(self) -> Transfers:
        """Make the arrays read-only."""
        for array in (self.starts, self.ends, self.counts):
            array.flags.writeable = False
        return self

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""
        return int(self.counts.max(initial=0))

    def select(self, index: Index) -> Transfers:
        """Return the problems that an index of numpy selects."""
        limits, counts = limits_of(self.limits, self.counts.shape, index), self.counts[index]
        states = (_of(rows, self.counts.shape, index) for rows in (self.starts, self.ends))
        starts, ends = (_spread(rows, counts.shape) for rows in states)
        return Transfers(starts, ends, limits, counts).frozen()

    def alone(self, index: Index) -> Transfer:
        """Return one motion; InfeasibleError where there is none."""
        limits = limits_of_one(self.limits, self.counts.shape, index)
        start, end = (_of(rows, self.counts.shape, index) for rows in (self.starts, self.ends))
        return min_time_transfer(start.tolist(), end.tolist(), limits)

    def fill(self, some: slice, rooms: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Plan some, counted in C order; see `Problems`."""
        core.transfer_pieces(self.limits.order, *self.given(some), self.most, *rooms)

    def given(self, some: slice) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return starts, ends and bounds of some, counted in C order, or those of one for all."""
        bounds = table(self.limits, self.counts.shape, some)
        return _rows(self.starts, some), _rows(self.ends, some), bounds


def _of(rows: FloatArray, shape: Shape, index: Index) -> FloatArray:
    """Return the states (…, order) that an index selects in a batch of this shape."""
    columns = [
        np.asarray(np.broadcast_to(rows[..., k], shape)[index]) for k in range(rows.shape[-1])
    ]
    return np.stack(columns, axis=-1)


def _rows(states: FloatArray, some: slice) -> FloatArray:
    """Return states (K, order) of some, or (1, order) where all have the same."""
    if not any(states.strides[:-1]):
        return np.asarray(states[(0,) * (states.ndim - 1)]).reshape(1, -1)
    return np.asarray(states.reshape(-1, states.shape[-1])[some])


def _spread(states: FloatArray, shape: Shape) -> FloatArray:
    """Return states (*shape, order), in one piece of memory or one for all."""
    spread = np.broadcast_to(states, (*shape, states.shape[-1]))
    one = states.size == states.shape[-1]
    return spread if one else np.ascontiguousarray(spread)


def _room(states: FloatArray, room: FloatArray) -> FloatArray:
    """Return the memory for states that were spread, or a read-only copy of one for all."""
    if any(states.strides[:-1]) or not states.size:
        return room.reshape(states.shape)
    return np.broadcast_to(_rows(states, slice(0, 1))[0].copy(), states.shape)


def _shape(*shapes: Shape) -> Shape:
    try:
        return np.broadcast_shapes((1,), *shapes)
    except ValueError:
        raise ValueError(
            f"starts, ends and limits of {shapes[0]}, {shapes[1]} and {shapes[2]} problems do not "
            "fit: expected the same number N, or one for all"
        ) from None


def _states(name: str, given: ArrayLike, order: int) -> FloatArray:
    """Return states (…, order), what is left out filled with zeros.

    The derivative of this order, which is not used, may follow, as in `min_time_transfer`.
    """
    states = np.atleast_1d(finite_numbers(name, given))
    if not states.size:
        states = np.empty((0, order))
    missing = order - states.shape[-1]
    if missing == -1:
        return np.ascontiguousarray(states[..., :order])
    if missing < 0:
        raise ValueError(
            f"{name} of shape {states.shape}: expected (N, {order}) or ({order},), position first"
        )
    return np.pad(states, [(0, 0)] * (states.ndim - 1) + [(0, missing)]) if missing else states
