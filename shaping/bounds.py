"""What a bound may be: a number, a pair, or an array of either for many problems."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .derivatives import derivative_name
from .pieces import FloatArray
from .real_numbers import real_array, shown

Side = float | FloatArray
"""A lower or an upper bound: of one problem, or of many."""

Bound = float | tuple[ArrayLike, ArrayLike] | list[float] | NDArray[np.floating]
"""A positive number (bound on the magnitude), a pair lower ≤ 0 ≤ upper, or an array of either."""

Pair = tuple[Side | None, Side]
"""Both sides of a bound; the lower one is None where it is the upper with the other sign."""

PositionBound = tuple[ArrayLike, ArrayLike] | list[float] | NDArray[np.floating]
"""A pair lower < upper, or an array (m, 2) of pairs."""

FREE = -inf, inf

_EXPECTED = (
    "expected a positive number or a pair, a tuple or list (lower, upper) with lower ≤ 0 ≤ upper, "
    "or for many problems an array (m,) of positive numbers or (m, 2) of pairs"
)


def sides_of(bound: Bound | None, k: int) -> Pair:
    """Return the bound on derivative k as (lower, upper), checked; arrays are those given.

    The lower one is None where it is that of the upper, with the other sign.

    Raises
    ------
    ValueError
        For numbers that do not enclose zero, named by the index of the problem.
    TypeError
        For anything else than numbers, pairs or arrays.
    """
    if bound is None:
        return None, inf
    try:
        if not isinstance(bound, tuple | list):
            low, high = _sides_of_array(real_array("bound", bound))
        elif len(bound) == 2 and not any(isinstance(side, tuple | list) for side in bound):
            low, high = (real_array("bound", side) for side in bound)
        else:
            raise TypeError
    except TypeError:
        told = f"{derivative_name(k)} limit {shown(bound)}: {_EXPECTED}"
        raise TypeError(told + _remedy_of_kind(bound)) from None
    _check_around_zero(bound, low, high, k)
    return None if low is None else _number_or_array(low), _number_or_array(high)


def read_only_copies(pairs: list[Pair]) -> list[Pair]:
    """Return sides with their arrays copied, all into one piece of memory.

    Pieces of their own would each be taken from the system and given back anew.
    """
    arrays = [side for pair in pairs for side in pair if isinstance(side, np.ndarray)]
    if not arrays:
        return pairs
    block, begin = np.empty(sum(side.size for side in arrays)), 0
    for side in arrays:
        block[begin : begin + side.size] = side.ravel()
        begin += side.size
    block.flags.writeable = False
    ends = iter(np.cumsum([side.size for side in arrays]))

    def copy(side: Side | None) -> Side | None:
        if not isinstance(side, np.ndarray):
            return side
        end = int(next(ends))
        return block[end - side.size : end].reshape(side.shape)

    return [(copy(low), copy(high)) for low, high in pairs]  # type: ignore[misc]


def position_sides(bound: PositionBound | None) -> tuple[Side, Side]:
    """Return the bounds on position as (lower, upper), checked; arrays are read-only copies.

    Raises
    ------
    ValueError
        For a pair of which the first is not below the second.
    TypeError
        For anything else than a pair, or an array of pairs.
    """
    if bound is None:
        return FREE
    expected = "expected a pair (lower, upper) with lower < upper, or an array (m, 2) of pairs"
    try:
        if isinstance(bound, tuple | list) and len(bound) == 2:
            low, high = (np.array(real_array("bound", side)) for side in bound)
        else:
            pairs = real_array("bound", bound)
            if isinstance(bound, tuple | list) or pairs.ndim < 2 or pairs.shape[-1] != 2:
                raise TypeError
            low, high = pairs[..., 0].copy(), pairs[..., 1].copy()
        right = np.asarray(low < high)
    except TypeError:
        told = f"position limit {shown(bound)}: {expected}"
        raise TypeError(told + _remedy_of_kind(bound)) from None
    except ValueError:
        raise ValueError(f"position limit {shown(bound)}: {expected}") from None
    if not right.all():
        problem = tuple(np.argwhere(~right)[0].tolist())
        lower, upper = (float(np.broadcast_to(side, right.shape)[problem]) for side in (low, high))
        where = f" of problem {', '.join(map(str, problem))}" if problem else ""
        raise ValueError(
            f"position limit {(lower, upper)!r}{where}: {expected}; leave it out where there is "
            "none, and write -inf or inf for a side without a bound"
        )
    return _side(low), _side(high)


def has_zero(sides: Iterable[Side]) -> bool:
    """Tell whether some bound is zero."""
    return any(bool(np.any(np.equal(side, 0.0))) for side in sides)


def _sides_of_array(bounds: FloatArray) -> tuple[FloatArray | None, FloatArray]:
    if bounds.ndim > 1 and bounds.shape[-1] == 2:
        return bounds[..., 0], bounds[..., 1]
    return None, bounds


def _remedy_of_kind(bound: object) -> str:
    if not isinstance(bound, tuple | list):
        return ""
    if len(bound) == 2 and any(side is None for side in bound):
        return "; write -inf or inf for a side without a bound"
    return "; make a list of bounds an array, as numpy.array does"


def _number_or_array(values: FloatArray) -> Side:
    return values if values.ndim else float(values)


def _side(values: FloatArray) -> Side:
    if not values.ndim:
        return float(values)
    values.flags.writeable = False
    return values


def _check_around_zero(given: Bound, low: FloatArray | None, high: FloatArray, k: int) -> None:
    name = derivative_name(k)
    try:
        right = np.asarray(high > 0.0)
        right = right if low is None else (high >= 0.0) & (low <= 0.0) & (low < high)
    except ValueError:
        raise ValueError(
            f"{name} limit: arrays of shapes {getattr(low, 'shape', ())} and {high.shape} "
            "do not fit: expected shapes that broadcast"
        ) from None
    if right.all():
        return
    problem = tuple(np.argwhere(~right)[0].tolist())
    below = -high if low is None else low
    lower, upper = (float(np.broadcast_to(side, right.shape)[problem]) for side in (below, high))
    told = shown(upper if lower == -upper or upper != upper else (lower, upper))
    where = f" of problem {', '.join(map(str, problem))}" if problem else ""
    remedy = _remedy_of_values(given, low, high)
    raise ValueError(f"{name} limit {told}{where}: {_EXPECTED}; {remedy}")


def _remedy_of_values(given: Bound, low: FloatArray | None, high: FloatArray) -> str:
    if not isinstance(given, tuple | list):
        if low is None and high.shape == (2,) and high[0] < 0.0 < high[1]:
            return "an array of two numbers is two bounds: make a pair a tuple"
        if low is not None and (low > 0.0).all():
            return (
                f"an array {(*low.shape, 2)} is pairs: give bounds on the magnitude of as many "
                "problems as the pair (-bounds, bounds)"
            )
    return "leave it out where there is none"
