"""A minimum-time problem between two states: its numbers, in its own units or mirrored in time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import factorial, frexp, ldexp

import numpy as np

from ...pieces import FloatArray


@dataclass(frozen=True, eq=False)
class WholeProblem:
    """Move from one state to another, lower_k ≤ x^(k) ≤ upper_k all the way, k = 0 … n.

    Parameters
    ----------
    start, end : (n,) arrays
        Position and derivatives up to n − 1.
    lower, upper : (n + 1,) arrays
        Bounds on position and derivatives 1 … n, infinite where there are none; those of the
        highest are finite.
    """

    start: FloatArray
    end: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def order(self) -> int:
        """Highest bounded derivative n."""
        return len(self.upper) - 1

    @property
    def bounded(self) -> list[int]:
        """The derivatives below n with a bound on either side."""
        finite = np.isfinite(self.lower[:-1]) | np.isfinite(self.upper[:-1])
        return [int(k) for k in np.flatnonzero(finite)]

    @property
    def at_rest(self) -> bool:
        """Whether it starts and ends at rest: then it can take any time above the least, too."""
        return not (self.start[1:].any() or self.end[1:].any())

    @property
    def may_hold(self) -> bool:
        """Whether start and end are on the same bound of a derivative below n, from 1 on."""
        sides = (self.lower[1:-1], self.upper[1:-1])
        return any(((self.start[1:] == s) & (self.end[1:] == s)).any() for s in sides)

    @property
    def backward(self) -> bool:
        """Whether its mirror image is the one that is planned, so that both have one plan."""
        ways = [self.end[0] - self.start[0], *self.start[1:], *self.end[1:]]
        return next((bool(way < 0.0) for way in ways if way), False)

    def below(self, order: int) -> WholeProblem:
        """Return the problem without the derivatives above `order`: what it excludes is excluded.

        The derivative of that order may jump.
        """
        sides = self.lower[: order + 1], self.upper[: order + 1]
        return WholeProblem(self.start[:order], self.end[:order], *sides)

    def with_share(self, share: float) -> WholeProblem:
        """Return the problem with a share of the highest bound."""
        factors = np.append(np.ones(self.order), share)
        return replace(self, lower=self.lower * factors, upper=self.upper * factors)

    def mirrored(self) -> WholeProblem:
        """Return the problem of the opposite direction."""
        return WholeProblem(-self.start, -self.end, -self.upper, -self.lower)

    def reversed(self) -> WholeProblem:
        """Return the problem run backwards, from the end to the start."""
        odd = np.arange(self.order + 1) % 2 == 1
        signs = np.where(odd[:-1], -1.0, 1.0)
        lower = np.where(odd, -self.upper, self.lower)
        upper = np.where(odd, -self.lower, self.upper)
        return WholeProblem(self.end * signs + 0.0, self.start * signs + 0.0, lower, upper)

    def scaled(self, length: int, time: int) -> WholeProblem:
        """Return the problem in units of 2^length and 2^time, positions from the start's on."""
        powers = np.arange(self.order + 1) * time - length
        offset = np.where(np.arange(self.order + 1) == 0, self.start[0], 0.0)
        start, end = (
            np.ldexp(state - offset[:-1], powers[:-1]) for state in (self.start, self.end)
        )
        lower, upper = (np.ldexp(side - offset, powers) for side in (self.lower, self.upper))
        return WholeProblem(start, end, lower, upper)

    def length_in(self, time: float) -> float:
        """Return the size of the motion's positions, seen from the start, in a time like this."""
        powers = time ** np.arange(self.order) / [factorial(k) for k in range(self.order)]
        sizes = np.abs(np.array([self.start, self.end])) * powers
        sizes[:, 0] = abs(self.end[0] - self.start[0])
        return float(sizes.max())


def power_of_two(value: float) -> int:
    """Return the exponent of the power of two next above a positive number."""
    return frexp(value)[1]


def scaled_time(value: float, exponent: int) -> float:
    """Return a duration in units of 2^exponent as one in the caller's."""
    return ldexp(value, exponent)
