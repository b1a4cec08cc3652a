"""MotionBatch: many moves or transfers, their pieces, values and peaks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import core
from .batches.lanes import in_threads
from .checks import positive
from .derivatives import derivative_number
from .frozen import Frozen, read_only
from .limits import Limits
from .pieces import MAX_SAMPLES, FloatArray, extrema
from .real_numbers import real_array
from .told import Rows, Told
from .trajectory import Motion

_NUMBERS = 2**17  # in the pieces and values worked out at a time, which stay in the cache


class _Arrays(NamedTuple):
    breaks: FloatArray
    durations: FloatArray
    states: FloatArray


class Pieces(_Arrays):
    """Pieces of N motions, as `Trajectory` has them, read-only; equal where all numbers are.

    breaks : (N, m + 1) array
        Times between the pieces; the last one is the duration.
    durations : (N, m) array
        Zero for those that a motion does not need.
    states : (N, m, n + 1) array
        Position and derivatives at the start of each piece.
    """

    __slots__ = ()

    def __new__(cls, breaks: FloatArray, durations: FloatArray, states: FloatArray) -> Self:
        """Look at the arrays through read-only views, without a copy."""
        return super().__new__(cls, *map(read_only, (breaks, durations, states)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Pieces):
            return False  # a tuple would compare array by array
        pairs = zip(self, other, strict=True)
        return all(np.array_equal(own, its, equal_nan=True) for own, its in pairs)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(tuple(array.shape for array in self))


class Problems(Protocol):
    """What the motions of a batch are planned from, and how."""

    @property
    def limits(self) -> Limits:
        """Bounds, which broadcast with the other arrays."""

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""

    def select(self, index: Any) -> Problems:
        """Return the problems that an index of numpy selects."""

    def alone(self, index: Any) -> Motion:
        """Return one motion; its problem's error where there is none."""

    def fill(self, some: slice, rooms: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Plan some, counted in C order, into durations and states of pieces and end states.

        The shapes are (K, most), (K, most, n + 1) and (K, n + 1).
        """


@dataclass(frozen=True, eq=False, repr=False)
class MotionBatch(Told, Frozen):
    """The motions of N problems: moves from rest to rest, or transfers between any two states.

    `batch[i]` is motion i as `min_time_move` or `min_time_transfer` gives it (InfeasibleError where
    there is none), and a slice, a mask or any other index of numpy makes a smaller batch. Every
    motion starts at time 0, and coasts before its start and after its own end.

    Attributes
    ----------
    duration : (N,) array
        NaN where the end of a transfer cannot be reached.
    inside_after : (N,) array
        Time after which every limit holds for good, as in `Transfer`; NaN as the duration.
    problems : Problems
        What they were planned from.

    Notes
    -----
    Arrays may have any number of dimensions, where N stands for all of them. They are read-only.
    Pieces are worked out when values, peaks or they themselves are asked for, and not kept.
    """

    duration: FloatArray
    inside_after: FloatArray
    problems: Problems

    def __post_init__(self) -> None:
        for array in (self.duration, self.inside_after):
            array.flags.writeable = False

    @property
    def limits(self) -> Limits:
        """Bounds, broadcast with the problems."""
        return self.problems.limits

    @property
    def order(self) -> int:
        """Highest bounded derivative n, constant on each piece."""
        return self.limits.order

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays, (N,)."""
        return self.duration.shape

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Which ends can be reached, (N,)."""
        return np.asarray(~np.isnan(self.duration))

    @property
    def start_state(self) -> FloatArray:
        """Position and derivatives 1…n at the start, (N, n + 1); NaN where there is no motion."""
        _, states, ends = self._laid_out(slice(0, self.duration.size))
        return self._shaped(states[:, 0] if states.shape[1] else ends)

    @property
    def end_state(self) -> FloatArray:
        """Position and derivatives 1…n at the end, (N, n + 1); NaN where there is no motion."""
        return self._shaped(self._laid_out(slice(0, self.duration.size))[2])

    def __len__(self) -> int:
        return len(self.duration)

    def table_rows(self) -> Rows:
        """Return how many there are, how many can be planned, and what their durations are."""
        some = self.duration[self.feasible]
        yield "shape", str(self.shape)
        yield "order", self.order
        yield "feasible", f"{some.size} of {self.duration.size}"
        if some.size:
            yield "duration", f"{some.min():.7g} … {some.max():.7g}, mean {some.mean():.7g}"

    def __repr__(self) -> str:
        told = ""
        if not self.feasible.all():
            told = f", feasible={np.count_nonzero(self.feasible)} of {self.duration.size}"
        return f"MotionBatch(shape={self.shape}, order={self.order}{told})"

    @overload
    def __getitem__(self, index: int) -> Motion: ...

    @overload
    def __getitem__(self, index: Any) -> Motion | MotionBatch: ...

    def __getitem__(self, index: Any) -> Motion | MotionBatch:
        """Return one motion, or those that an index selects as a batch."""
        duration = np.asarray(self.duration[index])
        if not duration.ndim:
            return self.problems.alone(index)
        inside_after = np.asarray(self.inside_after[index])
        return MotionBatch(duration, inside_after, self.problems.select(index))

    def __call__(
        self, t: ArrayLike, derivative: int | str = 0, *, each: bool = False
    ) -> FloatArray:
        """Evaluate one derivative of every motion.

        Parameters
        ----------
        t : float or (T,) array
            Times of all motions, finite; in increasing order is fastest. With `each`, of shape
            (N,) or (N, T), the times of each motion.
        derivative : int or str, optional
            0 position (default), 1 velocity, … or a name such as "jerk". Beyond n it is zero.
        each : bool, optional
            Whether every motion has times of its own.

        Returns
        -------
        (N, T) array
            8 bytes a value. At a break the value just after it; NaN where there is no motion.

        Raises
        ------
        ValueError
            For times that are not finite or do not fit, and for more than 1e9 values (8 GB):
            evaluate fewer at a time.
        """
        k = derivative_number(derivative)
        return np.asarray(self._values(t, range(k, k + 1), each=each)[0])

    def evaluate(
        self, t: ArrayLike, highest: int | str | None = None, *, each: bool = False
    ) -> FloatArray:
        """Evaluate position and derivatives 1…highest of every motion.

        Parameters
        ----------
        t, each
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
            As in calling the batch.
        """
        return self._values(t, range(self._highest(highest) + 1), each=each)

    def sample(self, dt: float, highest: int | str | None = None) -> tuple[FloatArray, FloatArray]:
        """Sample every motion on one time grid that ends with the longest.

        Parameters
        ----------
        dt : float
            Sampling interval, positive.
        highest : int or str, optional
            Highest derivative wanted, at most n. Default: n.

        Returns
        -------
        times : (T,) array
            0, dt, …, and the end of the longest motion as the last sample (the last interval is
            shorter where that is no multiple of dt).
        states : (highest + 1, N, T) array
            8 bytes a value.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): sample fewer motions at a time.
        """
        dt, rows = positive("dt", dt), self._highest(highest) + 1
        end = float(np.max(self.duration, initial=0.0, where=self.feasible))
        _check_size(
            f"dt = {dt!r}",
            end / dt * rows * self.duration.size,
            "a larger dt, a lower highest derivative, or fewer motions at a time",
        )
        times = np.append(dt * np.arange(int(np.ceil(end / dt * (1.0 - 1e-12)))), end)
        return times, self.evaluate(times, highest)

    def pieces(self) -> Pieces:
        """Return the pieces of all motions.

        Returns
        -------
        Pieces
            Up to m pieces for each, in 8·(m + 1 + m + m·(n + 1)) bytes; m is at most 2ⁿ − 1 for
            moves: 344 bytes a move for n = 3, up to 0.85 kB for n = 4, 2 kB for n = 5 and 4.5 kB
            for n = 6. NaN where there is no motion.

        Raises
        ------
        ValueError
            For more than 1e9 values (8 GB): take the pieces of fewer motions at a time.
        """
        m, size = self.problems.most, self.duration.size
        _check_size(
            f"{m} pieces a motion",
            float(size) * (m * (self.order + 3) + 1),
            "fewer motions at a time",
        )
        lengths, states, _ = self._laid_out(slice(0, size))
        breaks = np.zeros((size, m + 1))
        np.cumsum(lengths, axis=1, out=breaks[:, 1:])
        np.minimum(breaks, self.duration.reshape(-1, 1), out=breaks)
        breaks[:, -1] = self.duration.ravel()
        return Pieces(self._shaped(breaks), self._shaped(lengths), self._shaped(states))

    def peak(self, derivative: int | str) -> FloatArray:
        """Return the exact largest magnitude of a derivative of each motion, (N,)."""
        k, peaks = derivative_number(derivative), np.zeros(self.duration.size)

        def some(part: slice) -> None:
            lengths, states, ends = self._laid_out(part)
            rows = states[..., k:].reshape(-1, self.order + 1 - k).T
            largest = np.maximum(*_signed(extrema(lengths.ravel(), rows))).reshape(lengths.shape)
            peaks[part] = np.max(largest, axis=1, initial=0.0)
            if not lengths.shape[1]:
                peaks[part] = np.abs(ends[:, k])

        if k <= self.order:
            in_threads(some, peaks.size, self._at_once(1))
        peaks[~self.feasible.ravel()] = np.nan
        return peaks.reshape(self.shape)

    def _highest(self, derivative: int | str | None) -> int:
        k = self.order if derivative is None else derivative_number(derivative)
        if k > self.order:
            raise ValueError(f"highest = {derivative!r}: expected at most {self.order}")
        return k

    def _values(self, t: ArrayLike, derivatives: range, *, each: bool) -> FloatArray:
        """Return derivatives at times, (len(derivatives), *N, *T)."""
        times = self._times(t, len(derivatives), each=each)
        size, tail = self.duration.size, times.shape[self.duration.ndim :] if each else times.shape
        points = int(np.prod(tail))
        duration, flat = self.duration.ravel(), np.ascontiguousarray(times).reshape(-1)
        out = np.empty((len(derivatives), size, points))

        def some(part: slice) -> None:
            count = part.stop - part.start
            own = flat[part.start * points : part.stop * points] if each else flat
            values = np.empty((len(derivatives), count, points))
            first, last = derivatives[0], derivatives[-1]
            motions = duration[part], *self._laid_out(part)
            core.evaluate_lanes(*motions, own, points, first, last, values)
            out[:, part] = values

        in_threads(some, size, self._at_once(points * len(derivatives)))
        return out.reshape(len(derivatives), *self.shape, *tail)

    def _times(self, t: ArrayLike, rows: int, *, each: bool) -> FloatArray:
        """Return times, checked, at which that many rows of values fit into memory."""
        times = real_array("t", t)
        if not np.isfinite(times).all():
            raise ValueError("times must be finite: got NaN or infinity")
        if each and times.shape[: self.duration.ndim] != self.shape:
            raise ValueError(
                f"t of shape {times.shape}: expected the times of each motion, of shape "
                f"{self.shape} or that and more; leave `each` out for the same times of all"
            )
        values = float(times.size) * rows * (1 if each else self.duration.size)
        _check_size(
            f"{times.size} times of {self.duration.size} motions",
            values,
            "fewer times or motions at a time",
        )
        return times

    def _laid_out(self, some: slice) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return durations and states of pieces, and end states, of motions in C order."""
        count, most, width = some.stop - some.start, self.problems.most, self.order + 1
        rooms = np.empty((count, most)), np.empty((count, most, width)), np.empty((count, width))

        def fill(part: slice) -> None:
            own = slice(some.start + part.start, some.start + part.stop)
            lengths, states, ends = (room[part] for room in rooms)
            self.problems.fill(own, (lengths, states, ends))

        in_threads(fill, count, self._at_once(1))
        return rooms

    def _at_once(self, numbers: int) -> int:
        """Return how many motions to work on at a time, each with that many results."""
        return max(1, _NUMBERS // ((self.problems.most + 1) * (self.order + 2) + numbers))

    def _shaped(self, rows: FloatArray) -> FloatArray:
        return rows.reshape(*self.shape, *rows.shape[1:])


def _signed(low_high: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return magnitudes on both sides."""
    low, high = low_high
    return -low, high


def _check_size(what: str, values: float, remedy: str) -> None:
    """Refuse more values than a computer has memory for."""
    if values > MAX_SAMPLES:
        raise ValueError(
            f"{what} makes {values:.3g} values: expected at most {MAX_SAMPLES:.0e}; use {remedy}"
        )
