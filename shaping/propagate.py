"""Exact response of a linear system to a trajectory on a uniform time grid.

On each piece the inputs are polynomials, so that system and inputs together are one larger
autonomous linear system

    d/dθ [x; p] = [[A·dt, B̃], [0, N]] [x; p],   θ = t/dt,   p_k = r^(k)·dt^k

with N the shift matrix: no integration error, whatever dt. Across a break p is reset to the next
piece's own state; within a piece the states at the samples are found a stride at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor, inf, isqrt, log2

import numpy as np
from numpy.typing import NDArray

from .derivatives import derivative_name
from .pieces import INVERSE_FACTORIALS, MAX_SAMPLES, FloatArray, evaluate
from .trajectory import Trajectory

_STRIDE = 1024  # samples found by one matrix product, at most
_LEAP = 2**11  # multiplications in the time from one stride to the next
_POWERS = 2**18  # entries of their powers, which for large systems shortens the strides
_PRODUCT = 2**17  # multiplications at a time: larger products start threads, which cost more here
_SERIES_NORM = 2.0  # up to this norm of A·t the Taylor series of exp(A·t)·x is the faster way
_ON_GRID = 1e-13  # a break this near to a sample, relative to its index, lies on it
_TAYLOR_TERMS = 18  # for a norm of at most 1/2: the remainder is 1e-23
_BALANCING_SWEEPS = 30
_SMALL = 2.0**-10  # no use in making the nilpotent part smaller than this


def grid(start: float, duration: float, dt: float) -> FloatArray:
    """Return start, start + dt, … up to start + duration (kept where it is a multiple of dt)."""
    if duration > MAX_SAMPLES * dt:
        raise ValueError(
            f"dt = {dt!r} makes {duration / dt:.3g} samples of {duration!r}: expected at most "
            f"{MAX_SAMPLES:.0e}; use a larger dt"
        )
    return np.asarray(start + dt * np.arange(floor(duration / dt * (1 + 1e-12)) + 1.0))


def check_fed(trajectory: Trajectory, derivatives: Sequence[int]) -> None:
    """Refuse derivatives that a system cannot be fed with."""
    for d in derivatives:
        if d > trajectory.order:
            raise ValueError(
                f"{derivative_name(d)} of a trajectory of order {trajectory.order} is a train of "
                f"impulses: use limits up to {derivative_name(max(derivatives))} at least"
            )


def inputs_on_grid(
    trajectory: Trajectory, time: FloatArray, dt: float, out: FloatArray
) -> FloatArray:
    """Put derivatives 0, 1, … on a grid of `grid` into `out`, one row each, and return it.

    A sample that falls on a break, but for rounding, has the value just after it, as in
    `propagate`.
    """
    breaks, on_grid = _breaks_on_grid(trajectory, dt)
    on_grid &= breaks < time.size
    samples = breaks[on_grid].astype(int)
    kept = time[samples]
    time[samples] = trajectory.breaks[on_grid]
    trajectory.evaluate(time, len(out) - 1, out)
    time[samples] = kept
    return out


def _breaks_on_grid(trajectory: Trajectory, dt: float) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the breaks in units of dt, and which of them are whole (and then exactly so)."""
    breaks = (trajectory.breaks - trajectory.start_time) / dt
    whole = np.round(breaks)
    on_grid = np.abs(breaks - whole) <= _ON_GRID * np.maximum(whole, 1.0)
    return np.where(on_grid, whole, breaks), on_grid


def product(left: FloatArray, right: FloatArray, out: FloatArray) -> FloatArray:
    """Put left @ right into `out`: a slim product, in parts too small to be worth threads."""
    by_rows = left.shape[0] > right.shape[1]
    part = max(_PRODUCT // max(left.shape[1] * min(out.shape), 1), 1)
    for i in range(0, max(out.shape), part):
        some = slice(i, i + part)
        if by_rows:
            np.matmul(left[some], right, out=out[some])
        else:
            np.matmul(left, right[:, some], out=out[:, some])
    return out


def propagate(
    a: FloatArray,
    b: FloatArray,
    derivatives: Sequence[int],
    trajectory: Trajectory,
    dt: float,
    count: int,
    initial: FloatArray,
    *,
    discrete: bool = False,
    out: FloatArray | None = None,
) -> FloatArray:
    """Return the states of x' = A·x + Σ_i b_i·r^(d_i)(t) at count times dt apart.

    Parameters
    ----------
    a : (n, n) array
    b : (n, k) array
    derivatives : sequence of k ints
        d_i, the derivative of the trajectory that feeds input i.
    trajectory : Trajectory
        r(t); the grid begins at its start and may go on after its end, where it coasts.
    dt : float
        Grid spacing.
    count : int
        Number of grid points.
    initial : (n,) array
        State at the first grid point.
    discrete : bool, optional
        Read the equation as x[k+1] = A·x[k] + Σ_i b_i·r^(d_i)(t_k) instead.
    out : (n, count) array, optional
        Where to put the result.

    Returns
    -------
    (n, count) array

    Raises
    ------
    ValueError
        For a derivative above the trajectory's order: it would be a train of impulses.
    """
    check_fed(trajectory, derivatives)
    system = _Driven(a, b, derivatives, trajectory.order, dt, discrete=discrete)
    pieces = _Pieces.make(trajectory, dt)
    powers = system.powers(system.stride(count))
    if out is None:
        out = np.empty((len(a), count))
    out[:, 0] = initial
    for piece, here, there, inputs in pieces.runs(count, len(powers) - 1):
        _fill(out[:, here:there], inputs[:, :-1], powers)
        if there < count:
            last = np.concatenate([out[:, there - 1], inputs[:, -1]])
            out[:, there] = system.cross(last, pieces, piece, there - 1)
    return out


@dataclass(frozen=True, eq=False)
class _Pieces:
    """The trajectory's pieces in units of dt, the coasting after its end included."""

    starts: FloatArray  # (m + 1,)
    states: FloatArray  # (n + 1, m + 1), derivative k times dt^k

    @classmethod
    def make(cls, trajectory: Trajectory, dt: float) -> _Pieces:
        end = trajectory.end_state.copy()
        end[trajectory.coasting + 1 :] = 0.0
        states = np.vstack([trajectory.states, end])
        scale = dt ** np.arange(trajectory.order + 1.0)
        starts, _ = _breaks_on_grid(trajectory, dt)
        return cls(starts, (states * scale).T)

    def runs(self, count: int, stride: int) -> Iterator[tuple[int, int, int, FloatArray]]:
        """Yield, for each piece with samples, its number, its first sample and the next piece's.

        With them comes p at every `stride`-th of these samples and at the last, (n + 1, …).
        """
        firsts = [*np.minimum(np.ceil(self.starts), count).astype(int).tolist(), count]
        held = [i for i in range(len(self.starts)) if firsts[i] < firsts[i + 1]]
        spans = [(firsts[i], firsts[i + 1]) for i in held]
        at = [np.append(np.arange(first, after, stride), after - 1) for first, after in spans]
        sizes = [len(samples) for samples in at]
        inputs = self.at(np.repeat(held, sizes), np.concatenate(at).astype(float))
        ends = np.cumsum(sizes).tolist()
        for i, span, size, end in zip(held, spans, sizes, ends, strict=True):
            yield i, *span, inputs[:, end - size : end]

    def end(self, piece: int) -> float:
        """Return where a piece ends."""
        return float(self.starts[piece + 1]) if piece + 1 < len(self.starts) else inf

    def at(self, piece: NDArray[np.intp], theta: FloatArray) -> FloatArray:
        """Return the inputs' chain p at times theta, each within its piece, (n + 1, N)."""
        return evaluate(self.states[:, piece], theta - self.starts[piece], range(len(self.states)))


class _Driven:
    """The linear system with its polynomial inputs, time in units of dt.

    `generator` acts on [x; p] divided by `scale`, powers of two that balance its rows against
    its columns: so the result does not depend on the units of the states.
    """

    def __init__(
        self,
        a: FloatArray,
        b: FloatArray,
        derivatives: Sequence[int],
        order: int,
        dt: float,
        *,
        discrete: bool,
    ) -> None:
        self.discrete = discrete
        self.size = len(a)
        coupling = np.zeros((self.size, order + 1))
        for column, d in enumerate(derivatives):
            coupling[:, d] += b[:, column] / dt**d
        if not discrete:
            a, coupling = a * dt, coupling * dt
        generator = np.eye(self.size + order + 1, k=1)
        generator[: self.size, : self.size] = a
        generator[: self.size, self.size :] = coupling
        self.scale = np.ones(len(generator)) if discrete else _balance(generator, self.size)
        self.generator = generator * self.scale / self.scale[:, None]
        self.norm = float(np.abs(self.generator).sum(axis=0).max())

    def stride(self, count: int) -> int:
        """Return how many of all samples to find at a time: powers, and leaps, cost time."""
        entries = self.generator.size
        quickest = isqrt(count * _LEAP // max(self.size * entries, 1))
        return min(max(quickest, 1), _STRIDE, _POWERS // entries + 1)

    def powers(self, stride: int) -> FloatArray:
        """Return the rows of x in the matrices that take [x; p] by 0 … stride steps."""
        change, size = self._change, self.size
        rows = np.eye(size, len(change))  # of one matrix after the other: one product for all
        while len(rows) < (stride + 1) * size:
            rows = np.concatenate([rows, rows + rows @ change])
            change = 2.0 * change + change @ change
        stack = rows[: (stride + 1) * size].reshape(stride + 1, size, len(change))
        scaled: FloatArray = stack * self.scale[:size, None] / self.scale
        return scaled

    def cross(self, z: FloatArray, pieces: _Pieces, piece: int, k: int) -> FloatArray:
        """Return x at grid point k + 1, given z = [x; p] at k and the piece that k lies in."""
        here = float(k)
        while True:
            there = k + 1.0 if self.discrete else min(pieces.end(piece), k + 1.0)
            if there > here:
                z = self._advance(z / self.scale, there - here) * self.scale
            if there == k + 1.0:
                return z[: self.size]
            here, piece = there, piece + 1
            z[self.size :] = pieces.at(np.array([piece]), np.array([here]))[:, 0]

    @cached_property
    def _change(self) -> FloatArray:
        """The matrix, less one, that takes the scaled [x; p] one dt further."""
        if not self.discrete:
            return _exponential_less_one(self.generator, self.norm)
        n = len(self.generator) - self.size
        lag = np.arange(n)[None, :] - np.arange(n)[:, None]
        shift = np.where(lag >= 0, INVERSE_FACTORIALS[np.abs(lag)], 0.0)
        matrix = self.generator.copy()
        matrix[self.size :, self.size :] = shift
        return matrix - np.eye(len(matrix))

    def _advance(self, z: FloatArray, theta: float) -> FloatArray:
        """Return exp(generator·theta)·z."""
        if theta == 1.0:
            return np.asarray(z + self._change @ z)
        if self.norm * theta > _SERIES_NORM:
            return z + _exponential_less_one(self.generator * theta, self.norm * theta) @ z
        total: FloatArray = z
        term = z
        x = slice(0, self.size)
        for k in range(1, 40):
            term = self.generator @ term * (theta / k)
            total = total + term
            # after as many terms as there are states, every one has been reached by every other
            if k > len(z) and (np.abs(term[x]) <= 1e-17 * np.abs(total[x])).all():
                break
        return total


def _exponential_less_one(matrix: FloatArray, norm: float) -> FloatArray:
    """Return exp(matrix) − 1 of a balanced matrix: Taylor series, scaled and squared.

    Without the 1 a step much shorter than the time constants keeps all its digits. For matrices
    as small as these a library's blocked algorithm is slower, and on a busy machine its threads
    are a hundred times slower.
    """
    squarings = max(ceil(log2(norm)) + 1, 0) if norm > 0.0 else 0
    small = matrix * 0.5**squarings
    total: FloatArray = small / _TAYLOR_TERMS
    for k in range(_TAYLOR_TERMS - 1, 0, -1):
        total = (small + small @ total) / k
    for _ in range(squarings):
        total = 2.0 * total + total @ total
    return total


def _balance(generator: FloatArray, size: int) -> FloatArray:
    """Return d, powers of two, that make d⁻¹·generator·d as small as its first corner allows.

    Row and column sums of the first, size × size, corner are brought to agree; the rest is
    nilpotent behind a one-way coupling, and can be made as small as that corner.
    """
    scale = np.ones(len(generator))
    corner = np.abs(generator[:size, :size])
    own = corner.diagonal().copy()
    np.fill_diagonal(corner, 0.0)
    for _ in range(_BALANCING_SWEEPS):
        rows, columns = corner.sum(axis=1), corner.sum(axis=0)
        both = (rows > 0.0) & (columns > 0.0)
        exponent = np.zeros(size)
        exponent[both] = np.round(0.25 * np.log2(rows[both] / columns[both]))
        if not exponent.any():
            break
        scale[:size] *= np.exp2(exponent)
        corner *= np.exp2(exponent[None, :] - exponent[:, None])
    small = _power_of_two(min(max((own + corner.sum(axis=0)).max(initial=0.0), _SMALL), 1.0))
    scale[size:] = small ** np.arange(len(generator) - size)
    coupling = np.abs(generator[:size, size:]) * scale[size:] / scale[:size, None]
    largest = coupling.max(initial=0.0)
    if largest > 0.0:
        scale[size:] *= _power_of_two(small / largest)
    return scale


def _power_of_two(value: float) -> float:
    return float(np.exp2(np.round(np.log2(value))))


def _fill(out: FloatArray, inputs: FloatArray, powers: FloatArray) -> None:
    """Fill the states of one piece, stride by stride; out[:, 0] is given.

    `inputs` (n + 1, strides) holds p at the first sample of each stride.
    """
    size, count = out.shape
    stride, strides = len(powers) - 1, inputs.shape[1]
    starts = np.empty((strides, size + len(inputs)))
    starts[:, size:] = inputs.T
    starts[0, :size] = x = out[:, 0].copy()
    leap = powers[stride][:, :size]
    driven = inputs.T @ powers[stride][:, size:].T
    for j in range(1, strides):
        x = leap @ x + driven[j - 1]
        starts[j, :size] = x
    whole = count // stride
    for i in range(size):
        within = powers[:stride, i]
        # a row of `out` is contiguous: its strides are written in place, without a copy
        product(starts[:whole], within.T, out[i, : whole * stride].reshape(whole, stride))
        if whole < strides:
            out[i, whole * stride :] = within[: count - whole * stride] @ starts[whole]
