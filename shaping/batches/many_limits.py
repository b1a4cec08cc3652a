"""Limits of many moves: bounds that are arrays, broadcast with one another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..derivatives import DERIVATIVE_NAMES, derivative_name, derivative_number
from ..frozen import Frozen
from ..limits import Limits
from ..pieces import MAX_ORDER, FloatArray
from ..real_numbers import real_array, shown

Bounds = tuple[FloatArray, ...]
"""Positive bounds on derivatives 1…n of moves in the positive direction, velocity first."""

Values = TypeVar("Values", bound=NDArray[Any])

LimitsOfMany = Limits | Mapping[Any, Any] | ArrayLike
"""What `min_time_moves` takes for limits."""


@dataclass(frozen=True, eq=False)
class ManyLimits(Frozen):
    """Bounds −falling_k ≤ x^(k) ≤ rising_k of many moves, positive arrays or numbers (0-d).

    Where the bounds of a derivative are equal both ways the two are the same array.
    """

    rising: Bounds
    falling: Bounds

    @property
    def order(self) -> int:
        """Highest bounded derivative."""
        return len(self.rising)

    @property
    def symmetric(self) -> bool:
        """Whether all bounds are equal both ways."""
        return all(up is down for up, down in zip(self.rising, self.falling, strict=True))

    @property
    def arrays(self) -> Bounds:
        """All different arrays."""
        falling = zip(self.rising, self.falling, strict=True)
        return (*self.rising, *(down for up, down in falling if down is not up))

    def part(self, shape: tuple[int, ...], some: slice) -> ManyLimits:
        """Return the limits of some moves of a batch of this shape, counted in C order."""
        rising = tuple(flat_part(up, shape, some) for up in self.rising)
        falling = tuple(
            up if given is down else flat_part(down, shape, some)
            for up, given, down in zip(rising, self.rising, self.falling, strict=True)
        )
        return ManyLimits(rising, falling)

    def each(self, shape: tuple[int, ...], index: Any) -> ManyLimits:
        """Return the limits of the moves that an index selects in a batch of this shape."""
        picked: dict[int, FloatArray] = {}
        for bound in self.arrays:
            whole = bound if bound.ndim == 0 else np.broadcast_to(bound, shape)[index]
            picked[id(bound)] = np.asarray(whole)
        rising, falling = (
            tuple(picked[id(bound)] for bound in side) for side in (self.rising, self.falling)
        )
        return ManyLimits(rising, falling)

    def single(self) -> Limits:
        """Return the limits of the only move."""
        return Limits.from_bounds(
            (-float(down), float(up)) for up, down in zip(self.rising, self.falling, strict=True)
        )

    def directed(self, forward: NDArray[np.bool_]) -> ManyLimits:
        """Return the limits as moves see them that go forward, those that do not mirrored."""
        pairs = [
            (up, up) if up is down else (np.where(forward, up, down), np.where(forward, down, up))
            for up, down in zip(self.rising, self.falling, strict=True)
        ]
        rising, falling = zip(*pairs, strict=True)
        return ManyLimits(rising, falling)

    def smaller(self) -> Bounds:
        """Return velocity in the direction of motion, from acceleration on the smaller bounds."""
        pairs = zip(self.rising[1:], self.falling[1:], strict=True)
        return (self.rising[0], *(up if up is down else np.minimum(up, down) for up, down in pairs))


def flat_part(values: Values, shape: tuple[int, ...], some: slice) -> Values:
    """Return some of the values broadcast to a shape, counted in C order; a number stays one."""
    if not any(values.strides):
        return cast(Values, np.asarray(values[(0,) * values.ndim]))
    if values.shape == shape and values.flags.c_contiguous:
        return cast(Values, values.reshape(-1)[some])
    return cast(Values, np.broadcast_to(values, shape).flat[some])


def many_limits(limits: LimitsOfMany) -> ManyLimits:
    """Return checked limits from what a caller gives.

    Parameters
    ----------
    limits : Limits, mapping, or (n,), (N, n) or (N, n, 2) array
        As in `min_time_moves`.
    """
    if isinstance(limits, Limits):
        pairs = zip(limits.lower, limits.upper, strict=True)
        sides = [_sides(-low if -low == high else (low, high), k)
                 for k, (low, high) in enumerate(pairs, start=1)]  # fmt: skip
    elif isinstance(limits, Mapping):
        sides = _named(limits)
    else:
        sides = _columns(limits)
    while sides and all(np.isinf(side).all() for side in sides[-1]):
        sides.pop()
    if not sides:
        raise ValueError("no limits given: bound at least one derivative, e.g. acceleration=1")
    rising, falling = zip(*sides, strict=True)
    return ManyLimits(rising, falling)


def _named(limits: Mapping[Any, Any]) -> list[tuple[FloatArray, FloatArray]]:
    given = {}
    for key, bound in limits.items():
        k = _bounded(key)
        if k in given:
            raise ValueError(f"{derivative_name(k)} is bounded twice, by its name and its number")
        given[k] = bound
    return [_sides(given.get(k), k) for k in range(1, max(given, default=0) + 1)]


def _bounded(key: Any) -> int:
    """Return the number of a derivative that can be bounded."""
    expected = (
        f"expected a number from 1 to {MAX_ORDER} or one of {', '.join(DERIVATIVE_NAMES[1:])}"
    )
    if isinstance(key, str) and key not in DERIVATIVE_NAMES:
        raise ValueError(f"unknown derivative {key!r} in limits: {expected}")
    try:
        k = derivative_number(key)
    except TypeError:
        raise TypeError(f"derivative {key!r} in limits: {expected}") from None
    if k == 0:
        raise ValueError("position has no limit here: derivatives count from 1 (velocity)")
    if k > MAX_ORDER:
        raise ValueError(f"derivative {k} in limits: {expected}")
    return k


def _columns(limits: ArrayLike) -> list[tuple[FloatArray, FloatArray]]:
    try:
        array = real_array("limits", limits)
    except TypeError:
        array = np.empty(())
    if array.ndim not in (1, 2, 3) or (array.ndim == 3 and array.shape[-1] != 2):
        found = f" of shape {array.shape}" if array.ndim else f" = {shown(limits)}"
        raise TypeError(
            f"limits{found}: expected Limits, a mapping such as "
            "{'velocity': [1.0, 2.0], 'jerk': 5.0}, or an array (N, order) of bounds or "
            "(N, order, 2) of pairs, velocity first, infinite where there is no limit"
        )
    if array.ndim == 3:
        columns = array.transpose(1, 2, 0)
        return [_sides((low, high), k) for k, (low, high) in enumerate(columns, start=1)]
    return [_sides(column, k) for k, column in enumerate(array.T, start=1)]


def _sides(bound: Any, k: int) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of derivative k both ways as positive arrays, checked."""
    if bound is None:
        bound = np.inf
    if not isinstance(bound, tuple):
        size = _positive(bound, bound, 1.0, k)
        return size, size
    if len(bound) != 2:
        raise TypeError(_expected(k, f" = {shown(bound)}"))
    low, high = bound
    rising, falling = _positive(high, bound, 1.0, k), _positive(low, bound, -1.0, k)
    return rising, (rising if np.array_equal(rising, falling) else falling)


def _positive(side: Any, bound: Any, sign: float, k: int) -> FloatArray:
    try:
        values = np.asarray(sign * real_array("bound", side))
    except TypeError:
        raise TypeError(_expected(k, f" = {shown(bound)}")) from None
    right = values > 0.0
    if not right.all():
        where = np.argwhere(~right)[0]
        element = f"[{', '.join(map(str, where))}]" if len(where) else ""
        value = sign * float(values[tuple(where)])
        raise ValueError(_expected(k, f"{element} = {value!r}"))
    values.flags.writeable = False
    return values


def _expected(k: int, found: str) -> str:
    return (
        f"{derivative_name(k)} limit{found}: expected positive numbers, or a tuple "
        "(lower, upper) of them with lower < 0 < upper; infinite where there is no limit"
    )
