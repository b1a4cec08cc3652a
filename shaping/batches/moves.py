"""min_time_moves: moves from rest to rest, for arrays of distances and bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ... import core
from ..batch import MotionBatch, Problems
from ..checks import range_error
from ..closed_moves import check_move_limits
from ..frozen import Frozen
from ..limits import Limits, not_limits, one_sided
from ..pieces import FloatArray
from ..plain_moves import plain_move
from ..trajectory import Trajectory
from ..trajectory_checks import finite_array
from .closed_forms import ClosedForms
from .lanes import (
    Index,
    Shape,
    check_of_many,
    in_threads,
    index_text,
    lanes,
    limits_of,
    limits_of_one,
    table,
)

LOW = 3
"""Highest order that the core plans."""


def min_time_moves(distances: ArrayLike, limits: Limits, *, start: ArrayLike = 0.0) -> MotionBatch:
    """Return the fastest closed-form moves from rest to rest: `min_time_move` on arrays.

    Parameters
    ----------
    distances : (N,) array
        Signed, in the limits' distance unit; zero gives a move of duration zero. One number
        stands for all.
    limits : Limits
        Of numbers, which hold for every move, or of arrays. Of order 3, the jerk of some may be
        infinite: they are planned as moves of order 2.
    start : float or (N,) array, optional
        Position at the start.

    Returns
    -------
    MotionBatch
        Arrays broadcast with one another: with distances (50, 1) and bounds (60,) it has the
        shape (50, 60).

    Raises
    ------
    ValueError
        For a value that is not finite, an order above 14, a highest derivative of order ≥ 2 that
        is not bounded on both sides, or a move that leaves the range of a double, each named by
        its index; or for arrays that do not fit.
    TypeError
        For anything but Limits, or but real numbers in an array.

    Notes
    -----
    The durations agree to 1e-12 with those of `min_time_move` with method="closed-form": the
    minimum for n ≤ 3, and a feasible move beyond (`proven_excess(batch[i], limits)` tells how much
    longer than need be at most). Where bounds differ between directions, n ≥ 4, that is the
    faster one of moving averages of the exact move of order 1, 2 or 3 and of the closed form for
    the smaller magnitude of each pair from acceleration upward.

    A batch keeps 16 bytes a move: its duration and its distance. One more for n ≥ 4, and 16 for
    every bound and 8 for starts that are given as arrays. Planning takes at most 5 MB beside,
    however many moves there are, on all processors. Pieces are made when they are asked for.

    References
    ----------
    As `min_time_move`.

    Examples
    --------
    >>> batch = min_time_moves([1.0, 32.0], Limits(jerk=1.0))
    >>> batch.duration
    array([ 3.1748021, 10.0793684])
    >>> batch[1].peak("jerk")
    1.0
    >>> min_time_moves(32.0, Limits(velocity=np.array([1.0, 4.0]), jerk=1.0)).duration
    array([34., 12.])
    """
    if not isinstance(limits, Limits):
        raise not_limits(limits)
    check_of_many(limits, check_move_limits)
    lengths, starts = finite_array("distances", distances), finite_array("start", start)
    shape = _shape(lengths, starts, limits)
    duration = np.empty(shape)
    lengths, starts = (np.broadcast_to(array, shape) for array in (lengths, starts))
    if limits.order <= LOW:
        problems: Problems = Moves.planned(lengths, starts, limits, duration)
    else:
        problems = ClosedForms.planned(lengths, starts, limits, duration)
    _check_range(lengths, limits, duration)
    return MotionBatch(duration, np.broadcast_to(0.0, shape), problems)


@dataclass(frozen=True, eq=False)
class Moves(Frozen):
    """Moves of order n ≤ 3: distances and starts of one shape, and limits that broadcast."""

    distances: FloatArray
    starts: FloatArray
    limits: Limits

    def __post_init__(self) -> None:
        for array in (self.distances, self.starts):
            array.flags.writeable = False

    @classmethod
    def planned(
        cls, distances: FloatArray, starts: FloatArray, limits: Limits, duration: FloatArray
    ) -> Moves:
        """Return the problems, and put the durations of their moves in place."""
        upper = tuple(map(np.asarray, limits.upper))
        lower = None if limits.symmetric else tuple(map(np.asarray, limits.lower))

        def some(part: slice) -> None:
            def own(values: FloatArray) -> FloatArray:
                return _dense(lanes(values, duration.shape, part))

            below, above = lower and tuple(map(own, lower)), tuple(map(own, upper))
            result = duration.reshape(-1)[part]
            core.move_durations(limits.order, own(distances), below, above, result)

        in_threads(some, duration.size)
        return cls(distances, starts, limits)

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""
        return int(2**self.limits.order - 1)

    def select(self, index: Index) -> Moves:
        """Return the problems that an index of numpy selects."""
        limits = limits_of(self.limits, self.distances.shape, index)
        return Moves(self.distances[index], self.starts[index], limits)

    def alone(self, index: Index) -> Trajectory:
        """Return one motion."""
        limits = limits_of_one(self.limits, self.distances.shape, index)
        distance, start = float(self.distances[index]), float(self.starts[index])
        return plain_move(distance, limits, start, "closed-form")

    def fill(self, some: slice, rooms: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Plan some, counted in C order; see `Problems`."""
        shape = self.distances.shape
        distances = _dense(lanes(self.distances, shape, some))
        starts = _dense(lanes(self.starts, shape, some))
        bounds = table(self.limits, shape, some)
        core.move_pieces(self.limits.order, distances, starts, bounds, self.most, *rooms)


def _dense(values: FloatArray) -> FloatArray:
    """Return values as (K,), or (1,) where all have the same."""
    return np.ascontiguousarray(values).reshape(-1)


def _shape(lengths: FloatArray, starts: FloatArray, limits: Limits) -> Shape:
    shapes = lengths.shape, starts.shape, limits.shape
    try:
        return np.broadcast_shapes((1,), *shapes)
    except ValueError:
        raise ValueError(
            f"distances of shape {shapes[0]}, start of shape {shapes[1]} and limits of shape "
            f"{shapes[2]} do not fit: expected shapes that broadcast, such as (N,) or one number "
            "for all"
        ) from None


def _check_range(distances: FloatArray, limits: Limits, duration: FloatArray) -> None:
    """Refuse moves that have no duration, or none that a double holds."""
    if duration.size == 0 or (duration.min() > 0.0 and duration.max() < np.inf):
        return
    wrong = ~((duration > 0.0) & (duration < np.inf)) & (distances != 0.0)
    if not wrong.any():
        return
    ahead = np.where(distances > 0.0, limits.upper[0], limits.lower[0])
    if limits.order == 1 and np.isinf(ahead[wrong]).any():
        right = np.isfinite(ahead) | (distances == 0.0)
        raise one_sided(limits, right, "a bound in the direction of the move")
    move = index_text(int(np.argmax(wrong)), duration.shape)
    raise range_error(f" of move {move}")
