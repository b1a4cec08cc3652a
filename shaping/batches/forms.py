"""Closed forms of many moves of order 4 and more: the fastest of each, and its pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..closed_form import ChainForm, SwingForm, chain_form, fastest_form, swing_form
from ..pieces import FloatArray
from ..rise import to_trajectory
from ..trajectory import Trajectory
from .chains import chains
from .rises import chain_pieces, swing_pieces
from .swings import swings

Forms = NDArray[np.int8]
"""Level of the chain that a move has, or its order n for a longer move without cruise."""

Lanes = slice | NDArray[np.intp]
"""Which moves: all of a range, or some."""


def fastest(distance: FloatArray, bounds: Sequence[FloatArray]) -> tuple[FloatArray, Forms]:
    """Return durations (K,) and forms (K,) of the fastest closed-form moves.

    Parameters
    ----------
    distance : (K,) array
        At least zero; where it is zero so is the duration.
    bounds : sequence of (K,) or 0-d arrays
        Symmetric bounds on derivatives 1…n, velocity first.
    """
    order = len(bounds)
    duration, forms = np.full(distance.shape, np.inf), np.zeros(len(distance), dtype=np.int8)
    with np.errstate(all="ignore"):
        if np.isfinite(bounds[1]).any():
            duration = swings(distance, bounds).duration
            forms[:] = order
        for level in range(order - 1, -1, -1):  # of several that tie the lowest level
            other = chains(distance, bounds, level).duration
            better = other <= duration
            duration[better], forms[better] = other[better], level
    duration[distance == 0.0] = 0.0
    return duration, forms


def pieces(
    distance: FloatArray, bounds: Sequence[FloatArray], forms: Forms
) -> Iterator[tuple[Lanes, FloatArray, FloatArray]]:
    """Yield, form by form, lanes (k,) with durations (m, k) and states (n + 1, m, k) from 0.

    Parameters
    ----------
    distance, bounds
        As for `fastest`.
    forms : (K,) array
        What `fastest` returned.
    """
    order = len(bounds)
    with np.errstate(all="ignore"):
        for form in _present(forms, order):
            lanes: Lanes = slice(0, len(distance))
            length, some = distance, list(bounds)
            if (forms != form).any():
                [lanes] = np.nonzero(forms == form)
                length = distance[lanes]
                some = [bound[lanes] if bound.ndim else bound for bound in bounds]
            durations, states = _pieces(length, some, form)
            durations[:, length == 0.0] = 0.0
            states[..., length == 0.0] = 0.0
            yield lanes, durations, states


def most_pieces(order: int, forms: Forms) -> int:
    """Return the largest number of pieces that `pieces` makes for these forms."""
    return max((piece_count(order, form) for form in _present(forms, order)), default=1)


def _present(forms: Forms, order: int) -> list[int]:
    """Return the forms that are there."""
    return [form for form in range(order + 1) if (forms == form).any()]


def trajectory(distance: float, bounds: Sequence[float], form: int) -> Trajectory:
    """Return one move from 0, of a positive distance and the form that `fastest` gave it."""
    swing = form == len(bounds)
    chosen: ChainForm | SwingForm | None = (
        swing_form(distance, bounds) if swing else chain_form(distance, bounds, form)
    )
    if chosen is None:  # a swing that rounding forbids by a hair
        chosen = fastest_form(distance, bounds)
    return to_trajectory(chosen.build())


def piece_count(order: int, form: int) -> int:
    """Return the number of pieces m that `pieces` makes of a form."""
    if form == order:
        return 3 * (order - 2) + 2
    return int((order - form + 1) * 2**form - 1)


def _pieces(
    distance: FloatArray, bounds: Sequence[FloatArray], form: int
) -> tuple[FloatArray, FloatArray]:
    if form == len(bounds):
        return swing_pieces(swings(distance, bounds), distance)
    return chain_pieces(chains(distance, bounds, form))
