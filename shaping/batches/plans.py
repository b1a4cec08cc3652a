"""Closed-form plans of many moves: the fastest form of each, and its pieces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..closed_form import ChainPlan, SwingPlan, chain_plan, swing_plan
from ..moves import min_time_move
from ..pieces import FloatArray
from ..rise import to_trajectory
from ..trajectory import Trajectory
from . import low_orders
from .chains import chains
from .many_limits import ManyLimits
from .rises import chain_pieces, swing_pieces
from .swings import swings

LOW = 3
"""Highest order that has one formula for all its moves."""

Forms = NDArray[np.int8]
"""Level of the chain plan that a move has, or its order n for a longer move without cruise."""


Lanes = slice | NDArray[np.intp]
"""Which moves: all of a range, or some."""


def plan(distance: FloatArray, limits: ManyLimits) -> tuple[FloatArray, Forms]:
    """Return durations (K,) and forms (K,) of the fastest closed-form moves.

    Parameters
    ----------
    distance : (K,) array
        Signed; where it is zero so is the duration.
    limits : ManyLimits
        Of these moves, each bound (K,) or one number.
    """
    size, seen = _seen_forward(distance, limits)
    forms = np.zeros(len(distance), dtype=np.int8)
    with np.errstate(all="ignore"):
        if limits.order <= LOW:
            duration = low_orders.durations(size, seen)
        else:
            duration = _fastest(size, seen, forms)
    duration[size == 0.0] = 0.0
    return duration, forms


def pieces(
    distance: FloatArray, limits: ManyLimits, forms: Forms
) -> Iterator[tuple[Lanes, FloatArray, FloatArray]]:
    """Yield, form by form, lanes (k,) with durations (m, k) and states (n + 1, m, k) from 0.

    Parameters
    ----------
    distance, limits
        As for `plan`.
    forms : (K,) array
        What `plan` returned.
    """
    size, seen = _seen_forward(distance, limits)
    with np.errstate(all="ignore"):
        for form in _present(forms, limits.order):
            lanes: Lanes = slice(0, len(size))
            length, some, back = size, seen, distance < 0.0
            if limits.order > LOW and (forms != form).any():
                [lanes] = np.nonzero(forms == form)
                length, some, back = size[lanes], seen.each(size.shape, lanes), back[lanes]
            durations, states = _pieces(length, some, form)
            still = length == 0.0
            if still.any():
                durations[:, still] = 0.0
                states[..., still] = 0.0
            if back.any():
                states *= np.where(back, -1.0, 1.0)
            yield lanes, durations, states


def most_pieces(order: int, forms: Forms) -> int:
    """Return the largest number of pieces that `pieces` makes for these forms."""
    if order <= LOW:
        return piece_count(order, 0)
    return max((piece_count(order, form) for form in _present(forms, order)), default=1)


def _present(forms: Forms, order: int) -> list[int]:
    """Return the forms that are there."""
    return [form for form in range(order + 1) if (forms == form).any()]


def trajectory(distance: float, limits: ManyLimits, form: int) -> Trajectory:
    """Return one move from 0, of a distance other than zero and the form that `plan` gave it."""
    bounds = limits.directed(np.asarray(distance > 0.0)).smaller()
    numbers = [float(bound) for bound in bounds]
    size, order = abs(distance), limits.order
    chosen: ChainPlan | SwingPlan | None = None
    if order > LOW:
        swing = form == order
        chosen = swing_plan(size, numbers) if swing else chain_plan(size, numbers, form)
    if chosen is None:  # order n ≤ 3, or a swing that rounding forbids by a hair
        return min_time_move(distance, limits.single(), method="closed-form")
    move = to_trajectory(chosen.build())
    return move if distance > 0.0 else move.mirror()


def piece_count(order: int, form: int) -> int:
    """Return the number of pieces m that `pieces` makes of a form."""
    if order <= LOW:
        return int(2**order - 1)
    if form == order:
        return 3 * (order - 2) + 2
    return int((order - form + 1) * 2**form - 1)


def _seen_forward(distance: FloatArray, limits: ManyLimits) -> tuple[FloatArray, ManyLimits]:
    """Return distances ≥ 0 and the limits as their moves see them."""
    seen = limits if limits.symmetric else limits.directed(distance >= 0.0)
    return np.abs(distance), seen


def _fastest(distance: FloatArray, limits: ManyLimits, forms: Forms) -> FloatArray:
    """Return the shortest durations of all plans, and put their forms in place."""
    bounds = limits.smaller()
    duration = np.full(distance.shape, np.inf)
    if np.isfinite(bounds[1]).any():
        duration = swings(distance, bounds).duration
        forms[:] = limits.order
    for level in range(limits.order - 1, -1, -1):  # of several that tie the lowest level
        other = chains(distance, bounds, level).duration
        better = other <= duration
        duration[better], forms[better] = other[better], level
    return duration


def _pieces(distance: FloatArray, limits: ManyLimits, form: int) -> tuple[FloatArray, FloatArray]:
    if limits.order <= LOW:
        return low_orders.pieces(distance, limits)
    bounds = limits.smaller()
    if form == limits.order:
        return swing_pieces(swings(distance, bounds), distance)
    return chain_pieces(chains(distance, bounds, form))
