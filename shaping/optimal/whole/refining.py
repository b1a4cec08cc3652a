"""Where a grid should be finer: cells on which motion and proof differ most."""

from __future__ import annotations

from math import comb, factorial

import numpy as np
from numpy.typing import NDArray

from ...pieces import FloatArray, RealArray
from .costate import Costate
from .elastic import Found, Rows
from .problem import WholeProblem
from .relaxation import MeanRows
from .sampled import Sampled, distances

_MOST = 12  # cells refined for each reason
_SHARE = 0.85  # of what is lost: what the refined cells hold
_ASIDE = 0.08  # of a cell, to both sides of the costate's root
_BISECTIONS = 12
_FEW = 0.1  # of the mean loss: cells of equal input that lose less are joined
_LONGEST = 0.5  # cell that is made by joining


def duality_losses(
    problem: WholeProblem, means: MeanRows, found: Found, costate: Costate, motion: Sampled
) -> FloatArray:
    """Return what a motion loses against multipliers, by cell; the sum is its distance from them.

    `motion` has inputs on the grid's cells, one or several on each.
    """
    count = len(means.lengths)
    unit = motion.time**problem.order
    each = motion.inputs.reshape(count, -1)
    used = (each * _part_areas(costate.pieces, each.shape[1])).sum(axis=1)
    most = problem.upper[-1] * unit * costate.positive - problem.lower[-1] * unit * costate.negative
    losses = np.maximum(most - used, 0.0)
    start = problem.start * motion.time ** np.arange(problem.order)
    columns = means.rows.matrix.shape[1] - problem.order
    inputs = np.repeat(motion.inputs, columns // len(motion.inputs))
    values = means.rows.matrix @ np.concatenate([inputs, start])
    below, above = distances(problem, values, means.rows.derivative, motion.time)
    held = found.rows != 0.0
    far = np.where(found.rows > 0.0, below, above)[held]
    np.add.at(losses, means.cells[held], np.abs(found.rows[held] * far))
    return np.asarray(losses)


def _part_areas(pieces: RealArray, parts: int) -> FloatArray:
    """Return ∫p over equal parts of every cell, (N, parts)."""
    d = len(pieces) - 1
    at = np.arange(parts + 1) / parts
    area = np.cumsum(np.vstack([np.zeros((1, pieces.shape[1])), pieces]), axis=0)
    basis = np.array(
        [[comb(d + 1, j) * x**j * (1 - x) ** (d + 1 - j) for j in range(d + 2)] for x in at]
    )
    return np.diff(np.asarray(basis @ area, float), axis=0).T


def hull_losses(problem: WholeProblem, rows: Rows, found: Found, nodes: FloatArray) -> FloatArray:
    """Return what is lost where a Bernstein coefficient is at its bound and the motion is not."""
    count = len(nodes) - 1
    losses = np.zeros(count)
    for k in problem.bounded:
        m = problem.order - k
        of = np.flatnonzero(rows.derivative == k)
        duals, coefficients = (x[of].reshape(m, count) for x in (found.rows, found.reached))
        first = np.concatenate([[coefficients[-1, 0]], coefficients[-1, :-1]])
        hull = np.vstack([first, coefficients])
        points = np.arange(1, m + 1) / m
        basis = np.array(
            [[comb(m, j) * x**j * (1 - x) ** (m - j) for j in range(m + 1)] for x in points]
        )
        losses += (np.abs(duals) * np.abs(coefficients - basis @ hull)).sum(axis=0)
    return losses


def broken_inside(problem: WholeProblem, motion: Sampled, parts: int) -> FloatArray:
    """Return by how much a motion exceeds its bounds inside the cells, relative to the sizes."""
    sizes, states = motion.sizes(problem), motion.states(problem)
    count = len(motion.inputs) // parts
    excess = np.zeros(count)
    for k in problem.bounded:
        of = np.full(states.shape[1], k)
        below, above = distances(problem, states[k], of, motion.time)
        over = np.maximum(-np.minimum(below, above), 0.0)[1:].reshape(count, parts).max(axis=1)
        excess += over / sizes[k]
    return excess


def worst_cells(losses: FloatArray) -> NDArray[np.intp]:
    """Return the fewest cells that hold nearly all of the losses."""
    order = np.argsort(-losses, kind="stable")
    total = np.cumsum(losses[order])
    if not total[-1] > 0.0:
        return order[:0]
    return order[: min(int(np.searchsorted(total, _SHARE * total[-1])) + 1, _MOST)]


def refined(
    nodes: FloatArray, cells: NDArray[np.intp], costate: Costate | None, inputs: FloatArray
) -> FloatArray:
    """Return the grid with these cells cut: at the costate's root, at a switch, or in thirds."""
    new = []
    for i in cells.tolist():
        left, width = nodes[i], nodes[i + 1] - nodes[i]
        switch = _switch(inputs, i)
        root = None if costate is None else _root(np.asarray(costate.pieces[:, i], float))
        if root is not None:
            new += [left + width * min(max(root + x, 0.02), 0.98) for x in (-_ASIDE, _ASIDE)]
        else:
            new += [left + width / 3.0, left + 2.0 * width / 3.0]
        if switch is not None:
            new.append(left + width * switch)
    merged = np.union1d(nodes, new)
    return np.asarray(merged[np.concatenate([[True], np.diff(merged) > 1e-9])])


def _root(coefficients: FloatArray) -> float | None:
    """Return the root of a polynomial in Bernstein form that changes its sign once; else None."""
    signs = np.sign(coefficients[coefficients != 0.0])
    if np.count_nonzero(np.diff(signs)) != 1:
        return None
    low, high = 0.0, 1.0
    rising = signs[-1] > 0.0
    d = len(coefficients) - 1
    terms = [(comb(d, j) * value, j) for j, value in enumerate(coefficients.tolist())]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        at = sum(term * middle**j * (1.0 - middle) ** (d - j) for term, j in terms)
        low, high = (low, middle) if (at > 0.0) == rising else (middle, high)
    return middle


def _switch(inputs: FloatArray, i: int) -> float | None:
    """Return where an input would switch between those of the neighbours, mean kept."""
    if not 0 < i < len(inputs) - 1:
        return None
    before, here, after = inputs[i - 1 : i + 2].tolist()
    if before == after or not min(before, after) < here < max(before, after):
        return None
    share = (here - after) / (before - after)
    return share if 0.02 < share < 0.98 else None


def coarser(problem: WholeProblem, motion: Sampled, losses: FloatArray) -> FloatArray:
    """Return a motion's grid without nodes between cells of equal input that lose little.

    Hulls of the longer cells are within the bounds still.
    """
    nodes, inputs = motion.nodes, motion.inputs
    few = losses < _FEW * losses.mean()
    same = np.abs(np.diff(inputs)) <= 1e-6 * np.abs(inputs).max()
    drop = np.concatenate([[False], same & few[1:] & few[:-1], [False]])
    while drop.any():
        begun = 0
        for i in range(1, len(nodes)):
            if drop[i] and nodes[i + 1] - nodes[begun] > _LONGEST:
                drop[i] = False
            begun = begun if drop[i] else i
        kept = nodes[~drop]
        broken = ~inside_hull(problem, Sampled(kept, motion.on(kept), motion.time))
        owner = np.searchsorted(kept, nodes, side="right") - 1
        back = drop & broken[np.minimum(owner, len(broken) - 1)]
        if not back.any():
            break
        drop &= ~back
    return np.asarray(nodes[~drop])


def inside_hull(problem: WholeProblem, motion: Sampled) -> NDArray[np.bool_]:
    """Tell in which cells all Bernstein coefficients are within the bounds, but for rounding."""
    n, h = problem.order, np.diff(motion.nodes)
    states = np.vstack([motion.states(problem)[:, :-1], motion.inputs])
    sizes = motion.sizes(problem)
    inside = np.ones(len(h), dtype=bool)
    for k in problem.bounded:
        m = n - k
        basis = np.array([[comb(j, i) / comb(m, i) for i in range(m + 1)] for j in range(m + 1)])
        powers = np.array([h**i / factorial(i) for i in range(m + 1)])
        hull = basis @ (states[k:] * powers)
        below, above = distances(problem, hull, np.full(1, k), motion.time)
        inside &= np.minimum(below, above).min(axis=0) >= -1e-7 * sizes[k]
    return inside
