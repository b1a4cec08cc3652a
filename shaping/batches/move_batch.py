"""MoveBatch: many rest-to-rest moves, their pieces, values and peaks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike

from ..checks import positive
from ..derivatives import derivative_number
from ..frozen import Frozen
from ..pieces import MAX_SAMPLES, FloatArray, extrema
from ..real_numbers import real_array
from ..trajectory import Trajectory, point, within_range
from . import plans
from .blocks import Moves, blocks, spoilt_bound, spoilt_text
from .grids import fill
from .many_limits import ManyLimits


class MovePieces(NamedTuple):
    """Pieces of N moves, as `Trajectory` has them.

    breaks : (N, m + 1) array
        Times between the pieces; the last one is the duration.
    durations : (N, m) array
        Zero for those that a move does not need.
    states : (N, m, n + 1) array
        Position and derivatives at the start of each piece.
    """

    breaks: FloatArray
    durations: FloatArray
    states: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class MoveBatch(Frozen):
    """Fastest closed-form moves of N distances.

    `batch[i]` is move i as a `Trajectory`, and a slice, a mask or any other index of numpy makes
    a smaller batch. Every move starts at time 0; before that it rests at its start, and after its
    own end it rests there.

    Attributes
    ----------
    duration : (N,) array
    distances, starts : (N,) arrays
        Signed distances and positions at the start, as given.
    limits : ManyLimits
        Bounds, broadcast with the distances.
    forms : (N,) array
        For n ≥ 4 the derivative whose rise is one perfect spline (n − 1: the recursive S-curve;
        0: one spline from start to end), or n for Thompson's longer move without cruise.

    Notes
    -----
    Arrays may have any number of dimensions, where N stands for all of them.
    """

    distances: FloatArray
    starts: FloatArray
    limits: ManyLimits
    duration: FloatArray
    forms: plans.Forms

    def __post_init__(self) -> None:
        for array in (self.distances, self.starts, self.duration, self.forms):
            array.flags.writeable = False

    @property
    def order(self) -> int:
        """Highest bounded derivative n, constant on each piece."""
        return self.limits.order

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays, (N,)."""
        return self.duration.shape

    def __len__(self) -> int:
        return len(self.duration)

    def __repr__(self) -> str:
        return f"MoveBatch(shape={self.shape}, order={self.order})"

    @overload
    def __getitem__(self, index: int) -> Trajectory: ...

    @overload
    def __getitem__(self, index: Any) -> Trajectory | MoveBatch: ...

    def __getitem__(self, index: Any) -> Trajectory | MoveBatch:
        """Return one move as a trajectory, or those that an index selects as a batch."""
        duration = np.asarray(self.duration[index])
        limits = self.limits.each(self.shape, index)
        distance, start, form = self.distances[index], self.starts[index], self.forms[index]
        if duration.ndim:
            return MoveBatch(distance, start, limits, duration, form)
        if distance == 0.0:
            return point(float(start), self.order)
        move = within_range(lambda: plans.trajectory(float(distance), limits, int(form)))
        spoilt = spoilt_bound(move.states.T[..., None], limits)
        if spoilt:
            raise ValueError(spoilt_text(spoilt[0], str(index)))
        return move.shift(float(start)) if start else move

    def __call__(self, t: ArrayLike, derivative: int | str = 0) -> FloatArray:
        """Evaluate one derivative of every move at the same times.

        Parameters
        ----------
        t : float or (T,) array
            Times, finite; in increasing order is fastest.
        derivative : int or str, optional
            0 position (default), 1 velocity, … or a name such as "jerk". Beyond n it is zero.

        Returns
        -------
        (N, T) array
            8 bytes a value. At a break the value just after it.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): evaluate fewer at a time.
        """
        k, times = derivative_number(derivative), self._times(t, 1)
        if k > self.order:
            return np.zeros((*self.shape, *times.shape))
        return np.asarray(self._evaluate(times, range(k, k + 1))[0])

    def evaluate(self, t: ArrayLike, highest: int | str | None = None) -> FloatArray:
        """Evaluate position and derivatives 1…highest of every move at the same times.

        Parameters
        ----------
        t : float or (T,) array
            As in calling the batch.
        highest : int or str, optional
            At most n. Default: n.

        Returns
        -------
        (highest + 1, N, T) array
            8 bytes a value, which is all the memory that grows with N and T.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): evaluate fewer at a time.
        """
        k = self.order if highest is None else derivative_number(highest)
        if k > self.order:
            raise ValueError(f"highest = {highest!r}: expected at most {self.order}")
        return self._evaluate(self._times(t, k + 1), range(k + 1))

    def sample(self, dt: float, highest: int | str | None = None) -> tuple[FloatArray, FloatArray]:
        """Sample every move on one time grid that ends with the longest.

        Parameters
        ----------
        dt : float
            Sampling interval, positive.
        highest : int or str, optional
            Highest derivative wanted, at most n. Default: n.

        Returns
        -------
        times : (T,) array
            0, dt, …, and the end of the longest move as the last sample (the last interval is
            shorter where that is no multiple of dt).
        states : (highest + 1, N, T) array
            8 bytes a value.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): sample fewer moves at a time.
        """
        dt = positive("dt", dt)
        end = float(self.duration.max(initial=0.0))
        rows = 1 + (self.order if highest is None else derivative_number(highest))
        _check_size(
            f"dt = {dt!r}",
            end / dt * rows * self.duration.size,
            "a larger dt, a lower highest derivative, or fewer moves at a time",
        )
        times = np.append(dt * np.arange(int(np.ceil(end / dt * (1.0 - 1e-12)))), end)
        return times, self.evaluate(times, highest)

    def pieces(self) -> MovePieces:
        """Return the pieces of all moves.

        Returns
        -------
        MovePieces
            Up to m = 2ⁿ − 1 pieces for each, in 8·(m + 1 + m + m·(n + 1)) bytes: 344 a move for
            n = 3, up to 0.85 kB for n = 4, 2 kB for n = 5 and 4.5 kB for n = 6.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): take the pieces of fewer moves at a time.
        """
        m, size = plans.most_pieces(self.order, self.forms), self.duration.size
        _check_size(
            f"{m} pieces a move", float(size) * (m * (self.order + 3) + 1), "fewer moves at a time"
        )
        breaks, durations = np.empty((size, m + 1)), np.zeros((size, m))
        states = np.zeros((size, m, self.order + 1))
        for block in blocks(self._moves):
            lanes, count = block.lanes, len(block.durations)
            breaks[lanes, : count + 1] = block.breaks.T
            breaks[lanes, count + 1 :] = block.breaks[-1][:, None]
            durations[lanes, :count] = block.durations.T
            states[lanes, :count] = block.states.transpose(2, 1, 0)
            states[lanes, count:, 0] = block.ends[:, None]
        return MovePieces(
            *(array.reshape(*self.shape, *array.shape[1:]) for array in (breaks, durations, states))
        )

    def peak(self, derivative: int | str) -> FloatArray:
        """Return the exact largest magnitude of a derivative of each move, (N,)."""
        k = derivative_number(derivative)
        peaks = np.zeros(self.duration.size)
        if k > self.order:
            return peaks.reshape(self.shape)
        for block in blocks(self._moves):
            low, high = extrema(
                block.durations.ravel(), block.states[k:].reshape(self.order + 1 - k, -1)
            )
            largest = np.maximum(high, -low).reshape(block.durations.shape)
            peaks[block.lanes] = np.maximum(largest.max(axis=0), 0.0)
        return peaks.reshape(self.shape)

    def _times(self, t: ArrayLike, rows: int) -> FloatArray:
        """Return times, checked, at which that many rows of values fit into memory."""
        times = real_array("t", t)
        if not np.isfinite(times).all():
            raise ValueError("times must be finite: got NaN or infinity")
        _check_size(
            f"{times.size} times of {self.duration.size} moves",
            float(times.size) * self.duration.size * rows,
            "fewer times or moves at a time",
        )
        return times

    def _evaluate(self, times: FloatArray, derivatives: range) -> FloatArray:
        flat = times.ravel()
        order = None if bool((flat[1:] >= flat[:-1]).all()) else np.argsort(flat)
        out = np.empty((len(derivatives), self.duration.size, flat.size))
        for block in blocks(self._moves):
            fill(out, block, flat if order is None else flat[order], derivatives)
        if order is not None:
            out[..., order] = out.copy()
        return out.reshape(len(derivatives), *self.shape, *times.shape)

    @property
    def _moves(self) -> Moves:
        return Moves(self.distances, self.starts, self.limits, self.duration, self.forms)


def _check_size(what: str, values: float, remedy: str) -> None:
    """Refuse more values than a computer has memory for."""
    if values > MAX_SAMPLES:
        raise ValueError(
            f"{what} makes {values:.3g} values: expected at most {MAX_SAMPLES:.0e}; use {remedy}"
        )
