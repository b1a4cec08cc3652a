"""Limits: bounds on position, velocity, acceleration, jerk, …, of one motion or of many."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from .. import core
from .bounds import (
    FREE,
    Bound,
    Pair,
    PositionBound,
    Side,
    has_zero,
    position_sides,
    read_only_copies,
    sides_of,
)
from .checks import entries
from .derivatives import derivative_name, derivative_number
from .frozen import Frozen
from .pieces import FloatArray
from .real_numbers import shown
from .told import Rows, Told, brief


@dataclass(frozen=True, init=False, repr=False)
class Limits(Told, Frozen):
    """Bounds lower_k ≤ x^(k)(t) ≤ upper_k on the derivatives k = 1, 2, … of position, and on it.

    Parameters
    ----------
    velocity, acceleration, jerk, snap, crackle, pop : number, pair or array, optional
        A positive number bounds the magnitude; a tuple or list (lower, upper) with
        lower ≤ 0 ≤ upper bounds the two directions apart: (0, 20) allows for no turning back.
        The highest one given needs lower < 0 < upper. For many problems, an array (m,) is m
        bounds on the magnitude, also where m is 2, and an array (m, 2) is m pairs, as is any of
        two or more dimensions whose last is 2. The sides of a pair may be arrays, too: then it
        is one pair for each problem. Shapes of problems broadcast with one another, (50, 1) with
        (60,), as in numpy. Left out, None or infinite means unbounded.
        Units are the caller's: any consistent distance and time unit.
    position : pair or array of pairs, optional
        Any lower < upper, such as the hard stops of a stage.

    Attributes
    ----------
    lower, upper : tuple of float
        Bounds by derivative, velocity first; the last one is finite on at least one side. Where
        a bound was given as an array, it is a read-only array of its problems.
    position : (float, float)
        Bounds on position, arrays likewise; infinite where there are none.

    Raises
    ------
    ValueError
        For a bound that is not positive, a pair that does not enclose zero, one of positions
        that does not increase, a NaN, no bound on a derivative, or arrays that do not fit.
    TypeError
        For a bound that is not a number, a pair of numbers, or an array of them.

    Notes
    -----
    `min_time_move`, `min_time_transfer`, `min_time_transfers`, `synchronize` (but on a line),
    `through` and what tells of one motion (`certify`, `binding_limits`, `violation`) take bounds
    on position and bounds that are zero on a side; everything else takes neither and says so.

    Examples
    --------
    >>> limits = Limits(velocity=2.0, jerk=(-30.0, 20.0))
    >>> limits.order
    3
    >>> limits.bounds("jerk")
    (-30.0, 20.0)
    >>> Limits(velocity=np.array([1.0, 2.0, 4.0]), jerk=30.0).shape
    (3,)
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    position: tuple[float, float]

    def __init__(
        self,
        velocity: Bound | None = None,
        acceleration: Bound | None = None,
        jerk: Bound | None = None,
        snap: Bound | None = None,
        crackle: Bound | None = None,
        pop: Bound | None = None,
        *,
        position: PositionBound | None = None,
    ) -> None:
        fields = self.__dict__  # the way around `frozen`
        fields["position"] = FREE if position is None else position_sides(position)
        known = core.bounds(velocity, acceleration, jerk, snap, crackle, pop)
        if known is None or position is not None:
            self._set((velocity, acceleration, jerk, snap, crackle, pop))
        else:  # as `_take_plain` does: a call would be a tenth of the time that a move takes
            fields["lower"], fields["upper"], fields["flat"] = known
            fields["plain"], fields["bounds_position"] = True, False

    @classmethod
    def from_bounds(
        cls, bounds: Iterable[Bound | None], *, position: PositionBound | None = None
    ) -> Limits:
        """Return limits of any order from bounds listed velocity first.

        Parameters
        ----------
        bounds : iterable of number, pair, array or None
            Bound on derivative 1, 2, 3, …; as in `Limits`. An array gives its rows: (n,) numbers,
            (n, 2) pairs, (n, m) or (n, m, 2) those of m problems.
        position : pair or array of pairs, optional
            As in `Limits`.
        """
        limits = object.__new__(cls)
        limits.__dict__["position"] = position_sides(position)
        limits._set(tuple(entries("bounds", bounds)))
        return limits

    def _set(self, bounds: tuple[Bound | None, ...]) -> None:
        known = core.bounds(*bounds)
        if known is not None and self.position is FREE:
            self._take_plain(known)
            return
        pairs = [sides_of(bound, k) for k, bound in enumerate(bounds, start=1)]
        while pairs and all(_is_missing(side) for side in pairs[-1] if side is not None):
            pairs.pop()
        if not pairs:
            raise ValueError("no limits given: bound at least one derivative, e.g. acceleration=1")
        self._take(read_only_copies(pairs))
        _check_highest(self)
        try:
            self.shape  # noqa: B018  (which does not exist where arrays do not fit)
        except ValueError:
            shapes = ", ".join(map(str, dict.fromkeys(self._shapes)))
            raise ValueError(
                f"limits of shapes {shapes} do not fit: expected shapes of problems that "
                "broadcast, such as (m,) in all arrays"
            ) from None

    def _take_plain(self, known: tuple[tuple[float, ...], ...]) -> None:
        """Take bounds that the core knows: numbers, none of them zero."""
        fields = self.__dict__  # the way around `frozen`
        fields["lower"], fields["upper"], fields["flat"] = known
        fields["plain"], fields["bounds_position"] = True, False

    def _take(self, pairs: list[Pair]) -> None:
        fields = self.__dict__
        fields["upper"] = tuple(high for _, high in pairs)
        if any(low is not None for low, _ in pairs):
            fields["lower"] = tuple(_opposite(high) if low is None else low for low, high in pairs)

    def __getattr__(self, name: str) -> Any:
        if name != "lower" or "upper" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        lower = self.__dict__["lower"] = tuple(map(_opposite, self.upper))  # both ways alike
        return lower

    @property
    def _shapes(self) -> list[tuple[int, ...]]:
        both = (*self.position, *self.upper, *self.__dict__.get("lower", ()))
        return [side.shape for side in both if isinstance(side, np.ndarray)]

    @property
    def order(self) -> int:
        """Highest bounded derivative."""
        return len(self.upper)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Shape of the problems whose limits these are; () for limits of one problem."""
        shapes = self._shapes
        return np.broadcast_shapes(*shapes) if shapes else ()

    @cached_property
    def flat(self) -> tuple[float, ...]:
        """Lower and upper bound of each derivative in turn, velocity first; for the core.

        ValueError where position is bounded, or a bound zero on a side.
        """
        check_plain(self)
        return tuple(side for pair in zip(self.lower, self.upper, strict=True) for side in pair)

    @cached_property
    def symmetric(self) -> bool:
        """Whether every bound is the same in both directions."""
        if "lower" not in self.__dict__ and not self.bounds_position:
            return True
        pairs = [self.position, *zip(self.lower, self.upper, strict=True)]
        return all(bool(np.all(np.negative(low) == high)) for low, high in pairs)

    @cached_property
    def both_sides(self) -> bool:
        """Whether the highest derivative is bounded on both sides, in all problems."""
        return bool(np.all(self._both_sides))

    @property
    def _both_sides(self) -> Any:
        """Where the highest derivative is bounded on both sides."""
        right = np.isfinite(self.upper[-1])
        return right if self.symmetric else right & np.isfinite(self.lower[-1])

    @cached_property
    def bounds_position(self) -> bool:
        """Whether there is a bound on position, on either side."""
        return not all(bool(np.all(np.isinf(side))) for side in self.position)

    @cached_property
    def plain(self) -> bool:
        """Whether position is free, and no bound zero on a side."""
        sides = (*self.upper, *self.__dict__.get("lower", ()))  # both ways alike without it
        return not self.bounds_position and not has_zero(sides)

    def bounds(self, derivative: int | str) -> tuple[float, float]:
        """Return (lower, upper) of position or a derivative, given by number or name."""
        k = derivative_number(derivative)
        if k == 0:
            return self.position
        return (self.lower[k - 1], self.upper[k - 1]) if k <= self.order else (-inf, inf)

    def mirror(self) -> Limits:
        """Return the limits of the motion in the opposite direction."""
        low, high = self.position
        return Limits.from_bounds(
            ((-high, -low) for low, high in zip(self.lower, self.upper, strict=True)),
            position=(-high, -low),
        )

    def each(self, pick: Callable[[FloatArray], Any]) -> Limits:
        """Return the limits of some of the problems: `pick` takes theirs out of an array."""

        def picked(side: Side) -> Side:
            if not isinstance(side, np.ndarray):
                return side
            values = np.asarray(pick(side))
            values.flags.writeable = False
            return values if values.ndim else float(values)

        limits = object.__new__(Limits)
        upper = tuple(map(picked, self.upper))
        low, high = map(picked, self.position)
        limits.__dict__["position"] = (low, high)
        if "lower" not in self.__dict__ or self.symmetric:
            limits._take([(None, high) for high in upper])
        else:
            limits._take(list(zip(map(picked, self.lower), upper, strict=True)))
        return limits

    @property
    def _key(self) -> tuple[Any, ...]:
        sides = (*self.position, *self.lower, *self.upper)
        return tuple((s.shape, s.tobytes()) if isinstance(s, np.ndarray) else s for s in sides)

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, Limits) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def table_rows(self) -> Rows:
        """Return lower and upper bounds by derivative, those that there are."""
        sides = zip((self.position[0], *self.lower), (self.position[1], *self.upper), strict=True)
        for k, (low, high) in enumerate(sides):
            if _told(low, high) != "None":
                yield derivative_name(k), f"{brief(low)} … {brief(high)}"

    def __repr__(self) -> str:
        told = [_told(low, high) for low, high in zip(self.lower, self.upper, strict=True)]
        position = _told(*self.position)
        position = "None" if position == "None" else f"({', '.join(map(shown, self.position))})"
        if self.order > 6:
            last = "" if position == "None" else f", position={position}"
            return f"Limits.from_bounds([{', '.join(told)}]{last})"
        named = [f"{derivative_name(k)}={bound}" for k, bound in enumerate((position, *told))]
        return f"Limits({', '.join(text for text in named if not text.endswith('=None'))})"


def of_one(limits: object) -> Limits:
    """Return limits of one motion; TypeError for arrays of bounds, and for anything else."""
    if not isinstance(limits, Limits):
        raise not_limits(limits)
    if limits.shape != ():
        raise TypeError(
            f"limits of shape {limits.shape}: expected Limits of numbers, for one motion; "
            "min_time_moves and min_time_transfers take arrays"
        )
    return limits


def check_plain(limits: Limits) -> None:
    """Refuse bounds on position, and bounds that are zero on a side."""
    if limits.plain:
        return
    what = "bound on position" if limits.bounds_position else "bound that is zero on one side"
    raise ValueError(
        f"limits = {shown(limits)} have a {what}: only min_time_move and min_time_transfer(s), "
        "and by them synchronize and through, plan with one; leave it out here"
    )


def _check_highest(limits: Limits) -> None:
    """Refuse a highest derivative that cannot change its sign."""
    if has_zero((limits.upper[-1], *limits.__dict__.get("lower", ())[-1:])):
        told = _told(limits.lower[-1], limits.upper[-1])
        raise ValueError(
            f"{derivative_name(limits.order)} limit {told}: the highest derivative "
            "that is bounded must be free to take both signs; expected a positive number or a "
            "pair (lower, upper) with lower < 0 < upper"
        )


def not_limits(limits: object) -> TypeError:
    """Return the error for anything else than limits."""
    remedy = "; give bounds by name as Limits(**bounds)" if isinstance(limits, Mapping) else ""
    return TypeError(
        f"limits = {shown(limits)}: expected Limits, such as Limits(acceleration=1.0){remedy}"
    )


def check_both_sides(limits: Limits) -> None:
    """Refuse a highest derivative of order ≥ 2 that is not bounded on both sides.

    It is the input, and a motion that starts and ends needs both.
    """
    if limits.order > 1 and not limits.both_sides:
        raise one_sided(limits, limits._both_sides, "both bounds of the highest derivative")


def one_sided(limits: Limits, right: Any, expected: str) -> ValueError:
    """Return the error about the first problem whose highest derivative lacks a bound."""
    problem = tuple(np.argwhere(np.logical_not(right))[0].tolist())
    sides = limits.lower[-1], limits.upper[-1]
    low, high = (float(np.broadcast_to(side, np.shape(right))[problem]) for side in sides)
    where = f" of problem {', '.join(map(str, problem))}" if problem else ""
    how = "not bounded" if low == -high else "bounded in one direction only"
    return ValueError(
        f"{derivative_name(limits.order)}{where} is {how}, ({low:g}, {high:g}): expected {expected}"
    )


def _opposite(side: Side) -> Side:
    if not isinstance(side, np.ndarray):
        return -side
    values = -side
    values.flags.writeable = False
    return values


def _is_missing(side: Side) -> bool:
    return bool(np.size(side)) and bool(np.isinf(side).all())


def _told(low: Side, high: Side) -> str:
    if isinstance(low, np.ndarray) or isinstance(high, np.ndarray):
        same = np.array_equal(np.negative(low), high)
        return shown(high) if same else f"({shown(low)}, {shown(high)})"
    if low == -high:
        return "None" if high == inf else repr(high)
    return repr((low, high))
