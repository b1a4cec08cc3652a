"""What cannot be reached within limits, and the nearest that can."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, sqrt
from typing import Any

from ..derivatives import derivative_name
from ..limits import Limits

_ROUNDING = 16.0 * 2.0**-52


def inside(value: float, low: float, high: float) -> float:
    """Return a value with an excess over its bounds that is mere rounding cut off."""
    if high < value <= high + _ROUNDING * abs(high):
        return high
    if low > value >= low - _ROUNDING * abs(low):
        return low
    return value


@dataclass(frozen=True)
class Reason:
    """What is told of a problem without a motion: the attributes of `InfeasibleError`."""

    message: str
    nearest: float | None = None
    time: float | None = None
    state: tuple[float, ...] | None = None

    def headed(self, name: str) -> Reason:
        """Return the reason with a name before its message."""
        return replace(self, message=f"{name}{self.message}")


class LaterReason:
    """A reason that is worked out when it is first asked for: it may take as long as a plan."""

    def __init__(self, work_out: Callable[[], Reason]) -> None:
        self._work_out = work_out

    @cached_property
    def reason(self) -> Reason:
        """The reason."""
        return self._work_out()

    def __str__(self) -> str:
        """Return the message."""
        return self.reason.message

    def __repr__(self) -> str:
        """Return the message as it is shown within an error."""
        return repr(str(self))


class InfeasibleError(ValueError):
    """Raised where no motion within the limits leads from the start to the end.

    At orders 4 and above and within bounds on position only `bound` is known at once: all else, the
    message included, is worked out when it is first asked for.

    Attributes
    ----------
    bound : str
        The derivative whose bound stands in the way, such as "velocity"; empty where none is
        known.
    nearest : float or None
        The nearest value that can be reached, of the derivative at the end that the message
        names, where it names one.
    time : float or None
        When that bound would be exceeded, after the start, or before the end (negative), where
        one of both is a dead end.
    state : tuple of float or None
        The start or the end with that nearest value in its place, from which or to which there is
        a motion; where the message names one at orders 4 and above or within bounds on position.
    """

    def __init__(
        self,
        message: str | LaterReason,
        bound: str,
        nearest: float | None = None,
        time: float | None = None,
        state: tuple[float, ...] | None = None,
    ) -> None:
        super().__init__(message)
        self.bound = bound
        if isinstance(message, str):
            self._told: Reason | LaterReason = Reason(message, nearest, time, state)
        else:
            self._told = message

    @property
    def reason(self) -> Reason:
        """All that is told."""
        return self._told if isinstance(self._told, Reason) else self._told.reason

    @property
    def nearest(self) -> float | None:
        """The nearest value that can be reached."""
        return self.reason.nearest

    @property
    def time(self) -> float | None:
        """When the bound would be exceeded."""
        return self.reason.time

    @property
    def state(self) -> tuple[float, ...] | None:
        """The start or the end with the nearest value in its place."""
        return self.reason.state

    def __reduce__(self) -> tuple[type[InfeasibleError], tuple[Any, ...]]:
        """Return what it takes to send the error to another process."""
        told = self.reason
        return InfeasibleError, (told.message, self.bound, told.nearest, told.time, told.state)

    def headed(self, name: str) -> InfeasibleError:
        """Return the error with a name before its message."""
        return InfeasibleError(LaterReason(lambda: self.reason.headed(name)), self.bound)


def check_end(velocity: float, acceleration: float, limits: Limits) -> None:
    """Refuse an end outside the bounds."""
    within = _velocities(acceleration, limits), _accelerations(velocity, limits)
    for k, value, reachable in zip((1, 2), (velocity, acceleration), within, strict=True):
        low, high = limits.bounds(k)
        if not low <= inside(value, low, high) <= high:
            nearest = min(max(value, reachable[0]), reachable[1]) + 0.0  # no negative zero
            raise InfeasibleError(
                f"end {derivative_name(k)} = {value!r} is outside its bounds ({low:g}, {high:g}): "
                f"the nearest that can be reached is {nearest!r}",
                derivative_name(k),
                nearest,
            )


def _velocities(acceleration: float, limits: Limits) -> tuple[float, float]:
    """Return the lowest and highest velocity at which an acceleration can be built up from zero."""
    low, high = limits.bounds(1)
    a = min(max(acceleration, limits.bounds(2)[0]), limits.bounds(2)[1])
    gain = _gain(a, limits)
    return (min(low + gain, high), high) if gain > 0.0 else (low, max(high + gain, low))


def _gain(acceleration: float, limits: Limits) -> float:
    """Return the velocity that it takes to build an acceleration up from zero, signed like it."""
    jerk = limits.bounds(3)[1 if acceleration > 0.0 else 0]
    return 0.5 * acceleration * (acceleration / jerk)  # squares may leave the range


def _accelerations(velocity: float, limits: Limits) -> tuple[float, float]:
    """Return the lowest and highest acceleration that can be built up from zero at a velocity."""
    (low, high), (fall, rise) = limits.bounds(1), limits.bounds(3)
    v = min(max(velocity, low), high)
    most, least = limits.bounds(2)[1], limits.bounds(2)[0]
    if isfinite(rise):
        least = max(least, -sqrt(-fall) * sqrt(2.0) * sqrt(high - v))
        most = min(most, sqrt(rise) * sqrt(2.0) * sqrt(v - low))
    return least, most


def unreachable(velocity: float, acceleration: float, limits: Limits) -> InfeasibleError:
    """Return the error for an end within its bounds to which no motion within bounds leads.

    Acceleration a1 > 0 is built up from zero at a velocity of at most v1 − a1²/(2·rise), which
    is below the bound; the other way round for a1 < 0.
    """
    bound = limits.bounds(1)[1 if acceleration < 0.0 else 0]
    before = velocity - _gain(acceleration, limits)
    least, most = _accelerations(velocity, limits)
    nearest = (most if acceleration > 0.0 else least) + 0.0  # no negative zero
    return InfeasibleError(
        f"end acceleration = {acceleration!r} at velocity {velocity!r} cannot be reached within "
        f"the velocity bound {bound:g}: building it up takes a velocity of {before!r} before; the "
        f"nearest acceleration that can be reached at that velocity is {nearest!r}",
        "velocity",
        nearest,
    )
