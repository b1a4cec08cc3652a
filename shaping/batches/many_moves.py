"""min_time_moves: the fastest closed-form moves of arrays of distances and bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..derivatives import derivative_name
from ..moves import MAX_MOVE_ORDER
from ..pieces import FloatArray
from ..trajectory_checks import finite_array
from . import plans
from .blocks import index_text
from .many_limits import LimitsOfMany, ManyLimits, flat_part, many_limits
from .move_batch import MoveBatch

_CHUNK = 8192  # moves whose arrays stay in the processor's cache


def min_time_moves(
    distances: ArrayLike, limits: LimitsOfMany, *, start: ArrayLike = 0.0
) -> MoveBatch:
    """Return the fastest closed-form moves from rest to rest: `min_time_move` on arrays.

    Parameters
    ----------
    distances : (N,) array
        Signed, in the limits' distance unit; zero gives a move of duration zero. One number
        stands for all.
    limits : Limits, mapping or array
        `Limits` that hold for every move; or {derivative: bounds}, by name or number, such as
        {"velocity": v, "jerk": 30.0}, where bounds are positive numbers or arrays of them, a
        tuple (lower, upper) of such where the directions differ, and infinite where there is no
        limit; or an array (N, n) of bounds, velocity first, or (N, n, 2) of pairs.
    start : float or (N,) array, optional
        Position at the start.

    Returns
    -------
    MoveBatch
        Arrays broadcast with one another: with distances (50, 1) and bounds (60,) it has the
        shape (50, 60).

    Raises
    ------
    ValueError
        For a value that is not finite, a bound that is not positive, an order above 14, a move
        whose highest derivative is not bounded, or one that leaves the range of a double, each
        named by its index; or for arrays that do not fit.
    TypeError
        For limits of another kind, or anything but real numbers in an array.

    Notes
    -----
    The method is that of `min_time_move` with method="closed-form", and the durations agree with
    its to 1e-12: the minimum for n ≤ 3, and a feasible move beyond.

    A batch keeps 16 bytes a move: its duration and its distance. One more for n ≥ 4, and 8 for
    every number of the bounds and starts that are given as arrays. Planning takes at most 5 MB
    beside, however many moves there are. Pieces are made when they are asked for; see `MoveBatch`.

    References
    ----------
    As `min_time_move`.

    Examples
    --------
    >>> batch = min_time_moves([1.0, 32.0], {"jerk": 1.0})
    >>> batch.duration
    array([ 3.1748021, 10.0793684])
    >>> batch[1].peak("jerk")
    1.0
    >>> min_time_moves(32.0, {"velocity": [1.0, 4.0], "jerk": 1.0}).duration
    array([34., 12.])
    """
    bounds = many_limits(limits)
    if bounds.order > MAX_MOVE_ORDER:
        raise ValueError(
            f"limits of order {bounds.order}: expected at most {MAX_MOVE_ORDER} for a move; "
            "drop the highest bounds"
        )
    lengths, starts = finite_array("distances", distances), finite_array("start", start)
    shape = _shape(lengths, starts, bounds)
    duration = np.empty(shape)
    forms = np.zeros(shape if bounds.order > plans.LOW else (1,) * len(shape), dtype=np.int8)
    for i in range(0, duration.size, _CHUNK):
        some = slice(i, i + _CHUNK)
        distance = flat_part(lengths, shape, some)
        result = duration.reshape(-1)[some]
        distance = np.broadcast_to(distance, result.shape)
        chosen = bounds.part(shape, some)
        _check_bounded(distance, chosen, shape, i)
        result[:], found = plans.plan(distance, chosen)
        if bounds.order > plans.LOW:
            forms.reshape(-1)[some] = found
        _check_range(distance, result, shape, i)
    lengths, starts = (np.broadcast_to(array, shape) for array in (lengths, starts))
    return MoveBatch(lengths, starts, bounds, duration, np.broadcast_to(forms, shape))


def _shape(lengths: FloatArray, starts: FloatArray, bounds: ManyLimits) -> tuple[int, ...]:
    shapes = [array.shape for array in (lengths, starts, *bounds.arrays)]
    try:
        return np.broadcast_shapes((1,), *shapes)
    except ValueError:
        several = sorted(set(shapes[2:]) - {()}) or [()]
        raise ValueError(
            f"distances of shape {shapes[0]}, start of shape {shapes[1]} and limits of shape "
            f"{', '.join(map(str, several))} do not fit: expected shapes that broadcast, such as "
            "(N,) or one number for all"
        ) from None


def _check_bounded(
    distance: FloatArray, limits: ManyLimits, shape: tuple[int, ...], first: int
) -> None:
    """Refuse limits under which a move has no minimum time."""
    n, up, down = limits.order, limits.rising[-1], limits.falling[-1]
    if np.isfinite(up).all() and np.isfinite(down).all():
        return
    if n == 1:
        bound = np.where(distance >= 0.0, up, down)
    else:
        bound = np.maximum(up, down) if n <= plans.LOW else np.minimum(up, down)
    wrong = np.isinf(bound) & (distance != 0.0)
    if wrong.any():
        raise ValueError(
            f"{derivative_name(n)} of move {_index(wrong, shape, first)} has no limit in a "
            "direction that it needs: expected a finite bound on the highest derivative of every "
            "move; give moves of lower order a batch of their own"
        )


def _check_range(
    distance: FloatArray, duration: FloatArray, shape: tuple[int, ...], first: int
) -> None:
    right = (duration > 0.0) & (duration < np.inf)
    if not right.all():
        wrong = ~right & (distance != 0.0)
        if wrong.any():
            raise ValueError(
                f"the duration or a state of move {_index(wrong, shape, first)} leaves the range "
                "of a double: choose distance and time units nearer to the problem's own"
            )


def _index(wrong: NDArray[np.bool_], shape: tuple[int, ...], first: int) -> str:
    """Return the index of the first wrong move."""
    return index_text(first + int(np.argmax(wrong)), shape)
