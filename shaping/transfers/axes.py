"""An axis that moves together with others: its motion, and what is known of its bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..checks import finite, state_numbers
from ..limits import Limits
from ..moves import min_time_move
from ..real_numbers import shown
from ..trajectory import Motion
from .infeasible import InfeasibleError
from .problem import State, Transfer
from .s_curve import SCurveMove
from .transfer import min_time_transfer

Pair = tuple[float, float]


@dataclass(frozen=True)
class Axis:
    """The motion of one axis, from time 0 on.

    Attributes
    ----------
    number : int
        Its place among the axes.
    motion : Trajectory or Transfer
    limits : Limits, optional
        Those that it was planned with, where they are known.
    order : int
        Highest derivative that has to stay bounded: that of the limits, or the lowest that jumps.
    rests : bool
        Whether it starts and ends at rest.
    """

    number: int
    motion: Motion
    limits: Limits | None
    order: int
    rests: bool

    @property
    def span(self) -> float:
        """Signed distance."""
        return float(self.motion.end_state[0] - self.motion.start_state[0])

    def bounds(self) -> Iterator[Pair]:
        """Yield (lower, upper) of derivatives 1, 2, …, those that the motion uses at the least.

        Of an S-curve the smallest jerk, which serves for speeding up and for slowing down.
        """
        for k in range(1, self.order + 1):
            if self.limits is not None:
                yield self.limits.bounds(k)
            elif k == 3 and isinstance(self.motion, SCurveMove):
                jerks = np.abs(self.motion.states[:, 3])
                least = float(jerks[jerks > 0.0].min(initial=np.inf))
                yield -least, least
            else:
                yield self.motion.extremes(k)


def as_axis(number: int, given: Motion | tuple[State, State, Limits]) -> Axis:
    """Return an axis from its motion, or from what its fastest motion is planned with."""
    limits = given.limits if isinstance(given, Transfer) else None
    if isinstance(given, tuple | list) and len(given) == 3:
        start, end, limits = given
        given = _planned(number, start, end, limits)
    if not isinstance(given, Motion):
        raise TypeError(
            f"axis {number} = {shown(given)}: expected what min_time_transfer returns, or "
            "(start, end, limits), or another trajectory"
        )
    stepping = limits is None and not _has_bounded_jerk(given)
    order = given.lowest_jump() if stepping else given.order
    moving = slice(1, max(order, 1 + min(given.coasting, 1)))
    rests = not (given.start_state[moving].any() or given.end_state[moving].any())
    motion = given.delay(-given.start_time) if given.start_time else given
    return Axis(number, motion, limits, order, rests)


def _has_bounded_jerk(motion: Motion) -> bool:
    """Tell whether a motion is an S-curve without steps of acceleration."""
    if not isinstance(motion, SCurveMove) or motion.settings is None:
        return False
    return motion.settings.rates.jerk_percent is None


def _planned(number: int, start: State, end: State, limits: Limits) -> Motion:
    try:
        if isinstance(limits, Limits) and limits.order not in (2, 3):
            places = _at_rest("start", start), _at_rest("end", end)
            if places[0] is not None and places[1] is not None:
                return min_time_move(places[1] - places[0], limits, start=places[0])
        return min_time_transfer(start, end, limits)
    except InfeasibleError as error:
        told = f"axis {number}: {error}"
        raise InfeasibleError(told, error.bound, error.nearest) from error
    except ValueError as error:
        raise ValueError(f"axis {number}: {error}") from error


def _at_rest(name: str, state: State) -> float | None:
    """Return the position of a state of rest, None for another."""
    numbers = [finite(name, value) for value in state_numbers(name, state)]
    return numbers[0] if numbers and not any(numbers[1:]) else None
