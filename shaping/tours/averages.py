"""Moving averages of a motion: pieces of one order more, within the same bounds."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray, RealArray, advance, evaluate, integral
from ..trajectory import Motion, Trajectory, as_trajectory

_SAME = 4.0 * float(np.finfo(np.longdouble).eps)  # of the duration: times that are one


def widths(span: float, bounds: Sequence[float]) -> list[float]:
    """Return the widths w₁ ≥ w₂ ≥ … of moving averages, of least sum, that bound what jumps.

    Averages of what lies in a range of size `span` have derivatives

        |x^(i)| ≤ 2^(i−1)·span / (w₁·…·w_i) ≤ bounds[i − 1],   i = 1 … q,

    so that log w_i are the slopes of the least concave curve above the logarithms of their
    products.
    """
    steps = np.arange(1.0, len(bounds) + 1.0)
    with np.errstate(divide="ignore"):
        logs = np.log(span) + (steps - 1.0) * np.log(2.0) - np.log(bounds)
    found: list[float] = []
    level = 0.0
    while len(found) < len(bounds):
        slopes = (logs[len(found) :] - level) / steps[: len(bounds) - len(found)]
        count = int(np.argmax(slopes)) + 1
        level = float(logs[len(found) + count - 1])
        found += [float(np.exp(slopes.max()))] * count
    return found


@dataclass(frozen=True, eq=False)
class Pieces:
    """A motion from time 0 on, uniform before and after.

    Parameters
    ----------
    durations : (N,) array
        In extended precision.
    states : (n + 1, N) array
        x^(k) where each piece starts.
    end : (n + 1,) array
        The same where the last one ends.
    """

    durations: RealArray
    states: FloatArray
    end: FloatArray

    @classmethod
    def joined(cls, motions: Sequence[Motion]) -> Self:
        """Return motions one after the other."""
        parts = [as_trajectory(motion) for motion in motions]
        n = max(part.order for part in parts)
        states = [np.pad(part.states, ((0, 0), (0, n - part.order))) for part in parts]
        return cls(
            np.concatenate([part.durations for part in parts]).astype(np.longdouble),
            np.vstack(states).T,
            np.pad(parts[-1].end_state, (0, n - parts[-1].order)),
        )

    @property
    def edges(self) -> RealArray:
        """Times at which pieces start, and that of the end."""
        return np.concatenate([[np.longdouble(0.0)], np.cumsum(self.durations)])

    def averaged(self, width: float) -> Pieces:
        """Return the mean over the last `width`, from time 0 on: that much longer."""
        w, order = np.longdouble(width), len(self.states)
        given = self._lengthened(width)
        edges = given.edges - w
        kept = _distinct(np.concatenate([edges, edges + w]))
        kept = kept[(kept >= 0.0) & (kept <= edges[-1])]
        grid = _distinct(np.concatenate([edges, kept, kept - w]))
        starts = given._at(grid[:-1], edges)
        cells = np.diff(grid)
        areas = np.array([integral(cells, starts[k:]) for k in range(order)])
        upto, since = _found(kept, grid), _found(kept - w, grid)
        padded = np.hstack([areas, np.zeros((order, 1))])
        pairs = np.column_stack([since, upto]).ravel()
        means = np.add.reduceat(padded, pairs, axis=1)[:, ::2] / width
        last = np.minimum(upto, len(cells) - 1)
        jumps = (starts[-1, last] - starts[-1, since]) / width
        states = np.vstack([means, jumps])
        states[-1, -1] = 0.0
        return Pieces(np.diff(kept), states[:, :-1], states[:, -1])

    def between(self, start: FloatArray, end: FloatArray) -> Pieces:
        """Return the motion with exact states at both ends: derivatives beyond them are zero."""
        n = len(self.end)
        states = self.states.copy()
        states[:-1, 0] = np.pad(start, (0, n))[: n - 1]
        return Pieces(self.durations, states, np.pad(end, (0, n))[:n])

    def cut(self, times: RealArray) -> list[Trajectory]:
        """Return the motion in parts, each from time 0 on, which end at these times."""
        edges = self.edges
        every = _distinct(np.concatenate([edges, times]))
        states = np.column_stack([self._at(every[:-1], edges), self.end])
        bounds = _found(np.concatenate([[0.0], times]), every)
        parts = []
        for first, last in itertools.pairwise(bounds):
            here = every[first : last + 1]
            breaks = np.asarray(here - here[0], float)
            lasts = np.diff(breaks) > 0.0  # in doubles, too
            durations = np.asarray(np.diff(here), float)[lasts]
            end = np.append(states[:-1, last], 0.0)
            breaks = np.append(breaks[:-1][lasts], breaks[-1])
            parts.append(Trajectory(breaks, states[:, first:last].T[lasts], durations, end))
        return parts

    def places(self, times: RealArray) -> FloatArray:
        """Return where it is."""
        return np.asarray(self._at(times, self.edges)[0])

    def _at(self, times: RealArray, edges: RealArray) -> FloatArray:
        """Return the states at times, just after them."""
        slack = 2.0 * _SAME * (edges[-1] - edges[0])
        piece = np.clip(np.searchsorted(edges, times + slack, "right") - 1, 0, len(edges) - 2)
        passed = np.maximum(np.asarray(times - edges[piece], float), 0.0)
        return evaluate(self.states[:, piece], passed, range(len(self.states)))

    def _lengthened(self, width: float) -> Pieces:
        """Return the motion with uniform ones of this duration before and after it."""
        before, after = np.zeros((2, len(self.end)))
        before[:2], after[:2] = self.states[:2, 0], self.end[:2]
        before[0] -= before[1] * width
        ends = np.array([width], dtype=np.longdouble)
        lasts = np.concatenate([ends, self.durations, ends])
        states = np.column_stack([before, self.states, after])
        return Pieces(lasts, states, advance(after, width))


def _distinct(times: RealArray) -> RealArray:
    """Return times in order, each once."""
    times = np.sort(times)
    apart = np.diff(times) > _SAME * (times[-1] - times[0])
    return np.asarray(times[np.append(True, apart)])


def _found(times: RealArray, among: RealArray) -> NDArray[np.intp]:
    """Return the places of times among distinct ones."""
    return np.asarray(np.searchsorted(among, times - 2.0 * _SAME * (among[-1] - among[0])))
