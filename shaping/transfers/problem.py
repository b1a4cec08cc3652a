"""A transfer, and the problem that it solves: checked, and planned by the core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ... import core
from ..checks import finite, range_error, state_numbers
from ..derivatives import derivative_name
from ..limits import Limits, check_both_sides, check_plain, of_one
from ..real_numbers import shown
from ..trajectory import Planned, Trajectory, as_trajectory
from .infeasible import check_end, inside, unreachable

State = float | Sequence[float]
"""Position, velocity and, for order 3, acceleration; those left out at the end are zero."""


@dataclass(frozen=True, eq=False, repr=False)
class Transfer(Planned):
    """A motion between two given states that knows its limits.

    It answers what its trajectory does: `transfer(t)`, `transfer.end_state`, `transfer.peak(k)`, ….

    Attributes
    ----------
    trajectory : Trajectory
        The motion alone, which knows of no limits.
    limits : Limits
        Those it was planned with.
    inside_after : float
        Time from its start after which every limit holds for good. Zero where the start can
        keep the limits; else the time that bringing it inside takes, during which `violation`
        reports the excess.
    """

    trajectory: Trajectory
    limits: Limits
    inside_after: float = 0.0

    def __post_init__(self) -> None:
        fields = self.__dict__  # the way around `frozen`
        fields["trajectory"], fields["limits"] = as_trajectory(self.trajectory), of_one(self.limits)
        fields["inside_after"] = finite("inside_after", self.inside_after)

    def __repr__(self) -> str:
        told = f", inside_after={self.inside_after:.10g}" if self.inside_after else ""
        return f"{super().__repr__()[:-1]}{told})"


class Problem:
    """A start, an end and limits, ready to be planned."""

    def __init__(self, start: State, end: State, limits: Limits) -> None:
        check_order(limits)
        self.start = checked_state("start", start, limits)
        x1, v1, a1 = checked_state("end", end, limits)
        v1, a1 = inside(v1, *limits.bounds(1)), inside(a1, *limits.bounds(2))
        check_end(v1, a1, limits)
        finite("the distance between start and end", x1 - self.start[0])
        self.limits, self.end = limits, (x1, v1, a1)

    @property
    def _arguments(self) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
        n = self.limits.order
        return self.start[:n], self.end[:n], self.limits.flat

    def fastest(self) -> Transfer:
        """Return the minimum-time transfer."""
        return self._there(core.transfer(*self._arguments, Transfer, self.limits))

    def change_of_velocity(self) -> Transfer:
        """Return the fastest change to the end's velocity and acceleration."""
        return self._there(core.velocity_transfer(*self._arguments, Transfer, self.limits))

    def possible_durations(self) -> list[tuple[float, float]]:
        """Return the intervals of durations that a transfer can take."""
        return list(core.possible_durations(*self._arguments))

    def lasting(self, duration: float) -> Transfer:
        """Return a transfer of a given duration, one of those possible."""
        found = core.transfer_lasting(*self._arguments, duration, Transfer, self.limits)
        return self._there(found)

    def _there(self, found: Transfer | int) -> Transfer:
        if not isinstance(found, int):
            return found
        if found == core.RANGE or self.end[2] == 0.0:  # such an end can be reached
            raise range_error()
        raise unreachable(*self.end[1:], self.limits)


def check_order(limits: Limits) -> None:
    """Refuse limits that a transfer cannot be planned with."""
    check_orders(of_one(limits))


def check_orders(limits: Limits) -> None:
    """Refuse limits that transfers cannot be planned with, of one or of many."""
    n = limits.order
    if n not in (2, 3):
        if n == 1:
            raise ValueError(
                "limits of order 1: expected order 2 or above; bound the acceleration, too"
            )
        raise ValueError(
            f"limits of order {n}: expected order 2 (acceleration) or 3 (jerk) here; at orders up "
            "to 10 min_time_transfer plans one motion at a time"
        )
    check_both_sides(limits)
    check_plain(limits)


def checked_state(name: str, given: State, limits: Limits) -> tuple[float, float, float]:
    """Return (position, velocity, acceleration), checked; acceleration is zero for order 2."""
    x, v, a = (*checked_numbers(name, given, limits), 0.0)[:3]
    return x, v, a


def checked_numbers(name: str, given: State, limits: Limits) -> tuple[float, ...]:
    """Return the n numbers of a state, checked; those left out are zero."""
    numbers = state_numbers(name, given)
    n = limits.order
    if not 1 <= len(numbers) <= n + 1:
        named = ", ".join(derivative_name(k) for k in range(n))
        raise ValueError(
            f"{name} = {shown(given)}: expected ({named}) for limits of order {n}; the last may "
            f"be left out where they are zero, and {derivative_name(n)}, not used, may follow"
        )
    checked = [finite(f"{name} {derivative_name(k)}", value) for k, value in enumerate(numbers)]
    return tuple((*checked[:n], *[0.0] * n)[:n])
