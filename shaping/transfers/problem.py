"""A transfer problem: checked, in its own units, its start brought inside the bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import isfinite

import numpy as np

from ..checks import finite, state_numbers
from ..derivatives import derivative_name
from ..limits import Limits
from ..real_numbers import shown
from ..trajectory import Trajectory
from . import planner
from .brake import brake, inside
from .infeasible import check_end
from .task import Piece, Task, in_own_units

State = float | Sequence[float]
"""Position, velocity and, for order 3, acceleration; those left out at the end are zero."""


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Transfer(Trajectory):
    """A trajectory between two given states that knows its limits.

    Attributes
    ----------
    limits : Limits, optional
        Those it was planned with; None where it was made from arrays.
    inside_after : float
        Time from its start after which every limit holds for good. Zero where the start can
        keep the limits; else the time that bringing it inside takes, during which `violation`
        reports the excess.
    """

    limits: Limits | None = None
    inside_after: float = 0.0

    def __repr__(self) -> str:
        told = f", inside_after={self.inside_after:.10g}" if self.inside_after else ""
        return f"{super().__repr__()[:-1]}{told})"


class Problem:
    """A start, an end and limits, ready to be planned."""

    def __init__(self, start: State, end: State, limits: Limits) -> None:
        check_order(limits)
        x0, v0, a0 = checked_state("start", start, limits)
        x1, v1, a1 = checked_state("end", end, limits)
        v1, a1 = inside(v1, *limits.bounds(1)), inside(a1, *limits.bounds(2))
        check_end(v1, a1, limits)
        fall, rise = limits.bounds(3)
        task = Task(
            finite("the distance between start and end", x1 - x0),
            *(v0, a0, v1, a1),
            *limits.bounds(1),
            *limits.bounds(2),
            *(-fall, rise),
            resolution=2.0**-52 * max(abs(x0), abs(x1)),
        )
        self.limits, self.end = limits, (x1, v1, a1)
        self._scaled, *units = in_own_units(task)
        self.units = units[0], units[1]
        self._start, self._goal = x0 / self.units[1], x1 / self.units[1]
        self.braking, self.task, self.position = brake(self._scaled, self._start)

    @property
    def braking_time(self) -> float:
        """Time that bringing the start inside takes."""
        return self.units[0] * sum(duration for duration, _ in self.braking)

    def fastest(self) -> Transfer | None:
        """Return the minimum-time transfer, None where there is none."""
        if self.braking and self._scaled.within_bounds():  # it leaves them later, or never
            direct = planner.fastest(self._scaled, self._start, self._goal)
            if direct is not None:
                return self.assemble(direct, braking=False)
        plan = planner.fastest(self.task, self.position, self._goal)
        return None if plan is None else self.assemble(plan)

    def possible_durations(self) -> list[tuple[float, float]]:
        """Return the intervals of durations that a transfer can take."""
        time, first = self.units[0], self.braking_time
        return [
            (first + low * time, first + high * time)
            for low, high in planner.possible_durations(self.task)
        ]

    def lasting(self, duration: float) -> Transfer | None:
        """Return a transfer of a given duration, None where there is none."""
        remaining = (duration - self.braking_time) / self.units[0]
        plan = planner.lasting(self.task, remaining, self.position, self._goal)
        return None if plan is None else self.assemble(plan)

    def assemble(
        self, plan: list[Piece], end: float | None = None, *, braking: bool = True
    ) -> Transfer:
        """Return the trajectory of a plan, in the problem's units; it ends at `end` if given."""
        time, length = self.units
        n = self.limits.order
        pieces = [piece for piece in [*self.braking * braking, *plan] if piece[0] > 0.0]
        durations = np.array([duration for duration, _ in pieces]) * time
        scale = np.array([length / time**k for k in range(n + 1)])
        states = np.array([row for _, row in pieces]).reshape(len(pieces), n + 1) * scale
        breaks = np.array([0.0, *accumulate(durations.tolist())])
        x1 = self.end[0] if end is None else end * length
        end_state = np.array([x1, *self.end[1:n], 0.0])
        if not (np.isfinite(breaks).all() and np.isfinite(states).all()):
            raise OverflowError
        transfer = Transfer.from_arrays(breaks, states, durations, end_state)
        transfer.__dict__.update(  # the way around `frozen`
            limits=self.limits, inside_after=self.braking_time if braking else 0.0
        )
        return transfer


def check_order(limits: Limits) -> None:
    """Refuse limits that a transfer cannot be planned with."""
    if not isinstance(limits, Limits):
        raise TypeError(f"limits = {limits!r}: expected Limits, such as Limits(acceleration=1.0)")
    n = limits.order
    if n not in (2, 3):
        raise ValueError(
            f"limits of order {n}: expected order 2 (acceleration) or 3 (jerk) for a motion from "
            "any state; min_time_move plans from rest to rest at other orders"
        )
    low, high = limits.bounds(n)
    if not (isfinite(low) and isfinite(high)):
        raise ValueError(
            f"{derivative_name(n)} is bounded in one direction only, ({low:g}, {high:g}): expected "
            "both bounds of the highest derivative"
        )


def checked_state(name: str, given: State, limits: Limits) -> tuple[float, float, float]:
    """Return (position, velocity, acceleration), checked; acceleration is zero for order 2."""
    numbers = state_numbers(name, given)
    n = limits.order
    if not 1 <= len(numbers) <= n + 1:
        named = ", ".join(derivative_name(k) for k in range(n))
        raise ValueError(
            f"{name} = {shown(given)}: expected ({named}) for limits of order {n}; the last may "
            f"be left out where they are zero, and {derivative_name(n)}, not used, may follow"
        )
    checked = [finite(f"{name} {derivative_name(k)}", value) for k, value in enumerate(numbers)]
    x, v, a = (*checked[:n], 0.0, 0.0)[:3]
    return x, v, a
