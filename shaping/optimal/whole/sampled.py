"""A motion by its inputs on cells, in unit time: states at nodes, and how far from its bounds."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray
from .problem import WholeProblem

_CELLS = 16
_SHORT = 0.5  # of a cell: what an end's derivatives take to vanish, to have cells of its own
_SHORTEST = 1e-7  # of the duration
_FINER = 2  # halvings of that


@dataclass(frozen=True, eq=False)
class Sampled:
    """z_n on each cell of a grid, for a duration T.

    Parameters
    ----------
    nodes : (N + 1,) array
        From 0 to 1.
    inputs : (N,) array
    time : float
    """

    nodes: FloatArray
    inputs: FloatArray
    time: float

    def on(self, nodes: FloatArray) -> FloatArray:
        """Return the inputs in the middles of another grid's cells."""
        middles = 0.5 * (nodes[1:] + nodes[:-1])
        at = np.searchsorted(self.nodes, middles, side="right") - 1
        return self.inputs[np.clip(at, 0, len(self.inputs) - 1)]

    def switched_on(self, nodes: FloatArray, problem: WholeProblem) -> NDArray[np.bool_]:
        """Return bang-bang inputs on another grid, True for the upper bound: sums stay the same."""
        lower, upper = problem.lower[-1], problem.upper[-1]
        shares = (self.on(nodes) / self.time**problem.order - lower) / (upper - lower)
        return np.diff(np.floor(np.cumsum(np.clip(shares, 0.0, 1.0)) + 0.5), prepend=0.0) > 0.0

    def states(self, problem: WholeProblem) -> FloatArray:
        """Return z_k at the nodes, k = 0 … n − 1, shape (n, N + 1)."""
        n, h = problem.order, np.diff(self.nodes)
        z = np.zeros((n + 1, len(h) + 1))
        z[n, :-1] = self.inputs
        begin = problem.start * self.time ** np.arange(n)
        for k in range(n - 1, -1, -1):
            rise = sum(z[k + i, :-1] * h**i / factorial(i) for i in range(1, n - k + 1))
            z[k] = begin[k] + np.concatenate([[0.0], np.cumsum(rise)])
        return z[:n]

    def sizes(self, problem: WholeProblem) -> FloatArray:
        """Return the size of each z_k, k = 0 … n: no more for the input than a cell can use."""
        largest = np.abs(self.states(problem)).max(axis=1)
        sizes = np.append(largest, np.abs(self.inputs).max())
        whole = sizes.max()
        sizes = np.maximum(sizes, 1e-9 * whole if whole > 0.0 else 1.0)
        sizes[-1] = min(sizes[-1], 4.0 * sizes[-2] / np.diff(self.nodes).min())
        return np.asarray(sizes)


def distances(
    problem: WholeProblem, values: FloatArray, of: NDArray[np.intp], time: float
) -> tuple[FloatArray, FloatArray]:
    """Return how far values of z_k are from their lower and upper bounds, infinite without."""
    powers = time ** np.arange(problem.order + 1)
    lower, upper = problem.lower * powers, problem.upper * powers
    return values - lower[of], upper[of] - values


def are_near(
    problem: WholeProblem,
    values: FloatArray,
    of: NDArray[np.intp],
    time: float,
    sizes: FloatArray,
    share: float,
) -> NDArray[np.bool_]:
    """Tell which values of z_k are within a share of the range from a bound."""
    below, above = distances(problem, values, of, time)
    room = share * np.minimum(below + above, 2.0 * sizes[of])
    return np.asarray(np.minimum(below, above) <= room)


def first_sizes(problem: WholeProblem, time: float) -> FloatArray:
    """Return sizes of z_k before any motion is known: bounds, and what others leave of them."""
    n = problem.order
    powers = time ** np.arange(n + 1)
    bounds = np.minimum(np.maximum(np.abs(problem.lower), np.abs(problem.upper)), 1e300) * powers
    bounds = np.where(bounds >= 1e290, np.inf, bounds)
    states = np.maximum(np.abs(problem.start), np.abs(problem.end)) * powers[:n]
    sizes = bounds.copy()
    sizes[0] = min(bounds[0], max(problem.length_in(time), 1e-300))
    known = np.flatnonzero(np.isfinite(sizes) & (sizes > 0.0))
    logs = np.interp(np.arange(n + 1), known, np.log(sizes[known]))
    sizes = np.exp(logs)
    for _ in range(n):
        for k in range(1, n):
            smooth = 8.0 * max(np.sqrt(sizes[k - 1] * sizes[k + 1]), sizes[k - 1])
            sizes[k] = min(sizes[k], smooth)
    sizes[n] = min(sizes[n], 64.0 * sizes[n - 1])
    sizes[:n] = np.maximum(sizes[:n], states)
    return np.asarray(sizes)


def first_nodes(problem: WholeProblem, time: float) -> FloatArray:
    """Return a grid before any motion is known: uniform, and as fine at an end as it moves there.

    A cell there is to be no longer than what it takes to bring the end's derivatives to zero.
    """
    nodes = np.linspace(0.0, 1.0, _CELLS + 1)
    bounds = np.minimum(np.abs(problem.lower), np.abs(problem.upper))[2:]
    for state, sign in ((problem.start, 1.0), (problem.end, -1.0)):
        needed = (np.abs(state[1:]) / np.maximum(bounds, 1e-300)).max() / max(time, 1e-300)
        if 0.0 < needed < _SHORT / _CELLS:
            doubled = max(needed, _SHORTEST) * 2.0 ** np.arange(-_FINER, 40)
            nodes = np.union1d(nodes, (sign * doubled[doubled < 0.5 / _CELLS]) % 1.0)
    return np.asarray(nodes)
