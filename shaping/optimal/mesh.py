"""Meshes of the half 0…1: where a closed form switches, and finer where a solution asks for it."""

from __future__ import annotations

import numpy as np

from ..pieces import FloatArray
from ..trajectory import Trajectory
from .multipliers import Multipliers

_DECIMALS = 13  # kept of a node, so that a change of units leaves the very same program
_CROWDED = 0.3  # of the aimed-at cell: nodes nearer to each other are one
_SHARE = 0.9  # of the losses that a refinement goes after
_MOST_SPLIT = 60
_BRACKET = 0.05  # of a cell: how near to a root of the costate the next nodes are
_SAMPLES, _FINE_SAMPLES = 9, 65
_SAME = 1e-6  # of the bound: inputs that differ by less are equal
_FAR = 0.9  # of its bound: a change of a derivative that matters
_SUDDEN = 3  # cells
_AT_PEAK = 0.99
_BESIDE = 1e-5  # of the half: what is lost by a node that far from a peak is next to nothing


def graded_mesh(move: Trajectory, cells: int) -> FloatArray:
    """Return nodes among which are the breaks of the first half of a move, unless they are many.

    Half of the cells are spread evenly over time, half evenly over the pieces, long or short.
    """
    breaks = move.breaks / (0.5 * move.duration)
    breaks = np.append(breaks[breaks < 1.0 - 1e-9], 1.0)
    pieces = np.arange(len(breaks)) / (len(breaks) - 1.0)
    measure = 0.5 * (breaks + pieces)
    even = np.linspace(0.0, 1.0, cells + 1)
    crowded = np.abs(even[:, None] - measure).min(axis=1) * cells < _CROWDED
    filled = np.interp(even[~crowded], measure, breaks)
    kept = apart(measure, _CROWDED / cells if len(breaks) > cells else 0.0)
    return np.unique(np.round(np.concatenate([breaks[kept], filled]), _DECIMALS))


def with_touches(
    nodes: FloatArray, move: Trajectory, derivatives: list[int], span: float
) -> FloatArray:
    """Add nodes where derivatives of a move touch their peaks, 0…1 standing for its first `span`.

    Multipliers may stand there that none beside it replaces.
    """
    ends = move.breaks[move.breaks < span]
    ends = np.append(ends, span)
    times = np.unique(np.linspace(ends[:-1], ends[1:], _FINE_SAMPLES))
    found = []
    for k in derivatives:
        slope = move(times, k + 1)
        i = np.flatnonzero(slope[1:] * slope[:-1] < 0.0)
        at = times[i] + (times[i + 1] - times[i]) * slope[i] / (slope[i] - slope[i + 1])
        found.append(at[np.abs(move(at, k)) >= _AT_PEAK * move.peak(k)])
    added = np.concatenate([[], *found]) / span
    apart = np.abs(added[:, None] - nodes).min(axis=1) > _BESIDE
    return np.union1d(nodes, np.round(added[apart], _DECIMALS))


def apart(measure: FloatArray, least: float) -> np.typing.NDArray[np.bool_]:
    """Tell which of increasing values to keep so that neighbours are `least` apart, ends always."""
    kept = np.ones(len(measure), dtype=bool)
    last = measure[0]
    for i in range(1, len(measure) - 1):
        kept[i] = measure[i] - last >= least and measure[-1] - measure[i] >= least
        if kept[i]:
            last = measure[i]
    return kept


def split_switches(nodes: FloatArray, inputs: FloatArray, bound: float) -> FloatArray:
    """Cut in three every cell next to a change of the input, or whose input is no bound or zero."""
    size, same = np.abs(inputs), _SAME * bound
    cut = (size < bound - same) & (size > same)
    changes = np.abs(np.diff(inputs)) > same
    cut[:-1] |= changes
    cut[1:] |= changes
    return _cut(nodes, np.flatnonzero(cut))


def split_sudden(
    nodes: FloatArray, inputs: FloatArray, bound: float, levels: FloatArray
) -> FloatArray:
    """Cut in three the cells in which a derivative goes from bound to bound, or nearly as far.

    Where the input stays below its own bound meanwhile, finer cells could do it in less time; no
    multiplier tells.

    Parameters
    ----------
    nodes : (N + 1,) array
    inputs : (N,) array
    bound : float
        On the inputs.
    levels : (K, N + 1) array
        Derivatives over their bounds.
    """
    size = np.abs(inputs)
    between = (size < bound * (1.0 - _SAME)) & (size > _SAME * bound)
    edges = np.flatnonzero(np.diff(between, prepend=False, append=False))
    starts, ends = edges[::2], edges[1::2]
    far = np.abs(levels[:, ends] - levels[:, starts]).max(axis=0, initial=0.0) >= _FAR
    groups = zip(starts[far], ends[far], strict=True)
    cells = [cell for i, j in groups if j - i <= _SUDDEN for cell in range(i, j)]
    return _cut(nodes, np.array(cells, dtype=np.intp))


def split_losses(nodes: FloatArray, losses: FloatArray) -> FloatArray:
    """Cut in three the cells with most of the losses."""
    return _cut(nodes, _worst(losses))


def _cut(nodes: FloatArray, cells: np.typing.NDArray[np.intp]) -> FloatArray:
    thirds = np.diff(nodes)[cells] / 3.0
    return np.union1d(nodes, np.concatenate([nodes[cells] + thirds, nodes[cells + 1] - thirds]))


def refined(
    nodes: FloatArray, multipliers: Multipliers, waste: FloatArray, slack: FloatArray
) -> FloatArray:
    """Put nodes where a bound on the duration is weak.

    Parameters
    ----------
    nodes : (N + 1,) array
    multipliers : Multipliers
        On cells each of which is a part of one of the N.
    waste : (parts·N,) array
        What is lost in each part because the motion's input is not the one that the costate asks
        for; roots of the costate are closed in.
    slack : (N,) array
        What is lost because multipliers stand where the motion is not at its bounds.
    """
    count = len(nodes) - 1
    wasted = waste.reshape(count, -1).sum(axis=1)
    cells = _worst(wasted + slack)
    roots = _roots(nodes, multipliers)[cells]
    single = np.isfinite(roots) & (wasted >= slack)[cells]
    left, width = nodes[cells[single]], np.diff(nodes)[cells[single]]
    brackets = (roots[single] - left) / width + _BRACKET * np.array([[-1.0], [1.0]])
    brackets = left + width * np.clip(brackets, 0.5 * _BRACKET, 1.0 - 0.5 * _BRACKET)
    return np.union1d(_cut(nodes, cells[~single]), brackets)


def _worst(losses: FloatArray) -> np.typing.NDArray[np.intp]:
    """Return the cells with most of the losses."""
    order = np.argsort(-losses, kind="stable")
    total = np.cumsum(losses[order])
    if not total[-1] > 0.0:
        return order[:0]
    return order[: min(int(np.searchsorted(total, _SHARE * total[-1])) + 1, _MOST_SPLIT)]


def _roots(nodes: FloatArray, multipliers: Multipliers) -> FloatArray:
    """Return the root of the costate in each cell that has a single one; NaN elsewhere."""
    count = len(nodes) - 1
    coefficients = multipliers.costates()[0].astype(float)
    sigma = np.linspace(1.0, 0.0, _SAMPLES)[:, None]
    values = np.polynomial.polynomial.polyval(sigma, coefficients[:, None, :], tensor=False)
    edges = np.concatenate([[0.0], np.cumsum(multipliers.cells)])
    times = edges[1:] - sigma * multipliers.cells
    # samples in order of time, a row per cell
    values, times = (v.T.reshape(count, -1) for v in (values, times))
    changes = np.sign(values[:, 1:]) * np.sign(values[:, :-1]) < 0.0
    roots = np.full(count, np.nan)
    rows = np.flatnonzero(changes.sum(axis=1) == 1)
    i = changes[rows].argmax(axis=1)
    left, right = values[rows, i], values[rows, i + 1]
    before, after = times[rows, i], times[rows, i + 1]
    roots[rows] = before + (after - before) * left / (left - right)
    return roots
