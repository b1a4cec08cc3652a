"""Limits: bounds on velocity, acceleration, jerk and any higher derivative."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf, isinf
from typing import Any

import numpy as np

from .. import core
from .checks import entries, of_kind
from .derivatives import derivative_name, derivative_number
from .real_numbers import real_array, shown

Bound = float | tuple[float, float]
"""A positive number (bound on the magnitude) or a pair lower < 0 < upper."""


@dataclass(frozen=True, init=False, repr=False)
class Limits:
    """Bounds lower_k ≤ x^(k)(t) ≤ upper_k on the derivatives k = 1, 2, … of position.

    Parameters
    ----------
    velocity, acceleration, jerk, snap, crackle, pop : float or (float, float), optional
        A positive number bounds the magnitude; a pair (lower, upper) with lower < 0 < upper
        bounds the two directions apart. Left out, None or infinite means unbounded. Units are
        the caller's: any consistent distance and time unit.

    Attributes
    ----------
    lower, upper : tuple of float
        Bounds by derivative, velocity first; the last one is finite on at least one side.

    Raises
    ------
    ValueError
        For a bound that is not positive, a pair that does not enclose zero, a NaN, or no
        bound at all.
    TypeError
        For a bound that is not a number or a pair of numbers.

    Examples
    --------
    >>> limits = Limits(velocity=2.0, jerk=(-30.0, 20.0))
    >>> limits.order
    3
    >>> limits.bounds("jerk")
    (-30.0, 20.0)
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __init__(
        self,
        velocity: Bound | None = None,
        acceleration: Bound | None = None,
        jerk: Bound | None = None,
        snap: Bound | None = None,
        crackle: Bound | None = None,
        pop: Bound | None = None,
    ) -> None:
        known = core.bounds(velocity, acceleration, jerk, snap, crackle, pop)
        if known is None:
            self._set((velocity, acceleration, jerk, snap, crackle, pop))
        else:
            fields = self.__dict__  # the way around `frozen`
            fields["lower"], fields["upper"], fields["flat"] = known

    @classmethod
    def from_bounds(cls, bounds: Iterable[Bound | None]) -> Limits:
        """Return limits of any order from bounds listed velocity first.

        Parameters
        ----------
        bounds : iterable of float, (float, float) or None
            Bound on derivative 1, 2, 3, …; as in `Limits`. An array has one bound or one pair a
            row.
        """
        limits = object.__new__(cls)
        limits._set(tuple(entries("bounds", bounds)))
        return limits

    def _set(self, bounds: tuple[Bound | None, ...]) -> None:
        pairs = [_pair(bound, k) for k, bound in enumerate(bounds, start=1)]
        while pairs and pairs[-1] == (-inf, inf):
            pairs.pop()
        if not pairs:
            raise ValueError("no limits given: bound at least one derivative, e.g. acceleration=1")
        object.__setattr__(self, "lower", tuple(low for low, _ in pairs))
        object.__setattr__(self, "upper", tuple(high for _, high in pairs))

    @property
    def order(self) -> int:
        """Highest bounded derivative."""
        return len(self.upper)

    @cached_property
    def flat(self) -> tuple[float, ...]:
        """Lower and upper bound of each derivative in turn, velocity first."""
        return tuple(side for pair in zip(self.lower, self.upper, strict=True) for side in pair)

    @property
    def symmetric(self) -> bool:
        """Whether every bound is the same in both directions."""
        return all(-low == high for low, high in zip(self.lower, self.upper, strict=True))

    def bounds(self, derivative: int | str) -> tuple[float, float]:
        """Return (lower, upper) of a derivative given by number ≥ 1 or name."""
        k = derivative_number(derivative)
        if k == 0:
            raise ValueError("position has no limit here: derivatives count from 1 (velocity)")
        return (self.lower[k - 1], self.upper[k - 1]) if k <= self.order else (-inf, inf)

    def mirror(self) -> Limits:
        """Return the limits of the motion in the opposite direction."""
        return Limits.from_bounds(
            (-high, -low) for low, high in zip(self.lower, self.upper, strict=True)
        )

    def __repr__(self) -> str:
        shown = [
            None if isinf(low) and isinf(high) else high if high == -low else (low, high)
            for low, high in zip(self.lower, self.upper, strict=True)
        ]
        if self.order > 6:
            return f"Limits.from_bounds({shown!r})"
        named = [
            f"{derivative_name(k)}={bound!r}"
            for k, bound in enumerate(shown, start=1)
            if bound is not None
        ]
        return f"Limits({', '.join(named)})"


def checked_limits(limits: Any) -> Limits:
    """Return limits; TypeError for anything else."""
    return of_kind("limits", limits, Limits, "Limits, such as Limits(acceleration=1.0)")


def _pair(bound: Bound | None, k: int) -> tuple[float, float]:
    """Return bound `k` as (lower, upper), checked."""
    if bound is None:
        return -inf, inf
    try:
        sides = real_array("bound", bound)
    except TypeError:
        sides = np.empty(0)
    if sides.shape not in ((), (2,)):
        raise TypeError(
            f"{derivative_name(k)} limit {shown(bound)}: expected a positive number or a pair "
            "(lower, upper) of numbers"
        )
    low, high = sides.tolist() if sides.ndim else (-float(sides), float(sides))
    if not low < 0.0 < high:
        raise ValueError(
            f"{derivative_name(k)} limit {shown(bound)}: expected a positive number or a pair "
            "(lower, upper) with lower < 0 < upper; leave it out where there is no limit"
        )
    return low, high
