"""Evaluation of a piecewise polynomial at many times, quickly whatever their number and order."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .pieces import FloatArray, evaluate, evaluate_sorted
from .real_numbers import real_array

MAX_SAMPLES = 10**9
"""Longest time grid."""

_LONG_RUN = 600  # points a piece from which a run per piece is faster than a look-up per point
_BLOCK = 8192  # points evaluated at a time, so that the work stays in the cache


class Evaluator:
    """Values of pieces in Taylor form, and of what lies before the first and after the last.

    Parameters
    ----------
    breaks : (m + 1,) array
        Times between the pieces.
    states : (m + 2, n + 1) array
        Taylor state at the start of each piece; the first one is for times before breaks[0] and
        starts there too, the last one for times from breaks[-1] on.
    durations : (m,) array
        No piece between is run past its duration.
    """

    def __init__(self, breaks: FloatArray, states: FloatArray, durations: FloatArray) -> None:
        self.breaks = breaks
        self.origins = np.concatenate([breaks[:1], breaks])
        self.states = np.ascontiguousarray(states.T)
        self.longest = np.concatenate([[np.inf], durations, [np.inf]])

    def __call__(
        self, t: ArrayLike, derivatives: range, out: FloatArray | None = None
    ) -> FloatArray:
        """Return derivatives at times t, shape (len(derivatives), *t.shape)."""
        times = real_array("t", t)
        flat = times.ravel()
        if not np.isfinite(flat).all():
            raise ValueError("times must be finite: got NaN or infinity")
        if out is None:
            out = np.empty((len(derivatives), flat.size))
        out = out.reshape(len(derivatives), flat.size)
        runs_are_long = flat.size >= _LONG_RUN * len(self.longest)
        if runs_are_long and bool((flat[1:] >= flat[:-1]).all()):
            self._sweep(flat, derivatives, out)
        else:
            for i in range(0, flat.size, _BLOCK):
                self._gather(flat[i : i + _BLOCK], derivatives, out[:, i : i + _BLOCK])
        return out.reshape(len(derivatives), *times.shape)

    def _gather(self, t: FloatArray, derivatives: range, out: FloatArray) -> None:
        """Evaluate by looking up every point's piece."""
        piece = np.searchsorted(self.breaks, t, side="right")
        tau = np.minimum(t - self.origins[piece], self.longest[piece])
        out[:] = evaluate(self.states[:, piece], tau, derivatives)

    def _sweep(self, t: FloatArray, derivatives: range, out: FloatArray) -> None:
        """Evaluate increasing times, one run of points per piece."""
        edges = np.concatenate([[0], np.searchsorted(t, self.breaks, side="left"), [t.size]])
        for piece in np.flatnonzero(np.diff(edges)):
            for i in range(edges[piece], edges[piece + 1], _BLOCK):
                part = slice(i, min(i + _BLOCK, edges[piece + 1]))
                tau = np.minimum(t[part] - self.origins[piece], self.longest[piece])
                evaluate_sorted(self.states[:, piece], tau, derivatives, out[:, part])
