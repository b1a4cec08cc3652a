"""An axis that moves together with others: its motion, and what is known of its bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..checks import finite, state_numbers
from ..limits import Limits
from ..moves import min_time_move
from ..pieces import FloatArray
from ..real_numbers import shown
from ..trajectory import Motion, Trajectory
from .infeasible import InfeasibleError
from .problem import State, Transfer
from .s_curve import SCurveMove
from .s_curve_settings import SCurveSettings
from .transfer import min_time_transfer

Pair = tuple[float, float]
Given = Motion | tuple[State, State, Limits] | tuple[State, State]
"""A motion, or what its fastest motion is planned with; limits may be the resultant's alone."""

Planned = Limits | SCurveSettings | None
"""What an axis was planned with, as far as it is known."""


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
    planned : Limits or SCurveSettings, optional
        What it can be planned with anew.
    slows : bool
        Whether its motion is one S-curve that a lower velocity makes longer.
    """

    number: int
    motion: Motion
    limits: Limits | None
    planned: Planned = None
    slows: bool = False

    @cached_property
    def order(self) -> int:
        """Highest derivative that has to stay bounded: the motion's, or the lowest that jumps.

        A motion within known limits jumps in none below its own, nor does a smooth S-curve.
        """
        settings = self.planned
        smooth = isinstance(settings, SCurveSettings) and settings.rates.jerk_percent is None
        known = smooth or self.limits is not None
        return self.motion.order if known else self.motion.lowest_jump()

    @property
    def waits(self) -> bool:
        """Whether it starts at rest."""
        return self._is_rest(self.motion.start_state)

    @property
    def rests(self) -> bool:
        """Whether it starts and ends at rest."""
        return self.waits and self._is_rest(self.motion.end_state)

    def _is_rest(self, state: FloatArray) -> bool:
        """Whether a state at an end is one of rest: what jumps there does not count."""
        if not state[1 : self.motion.order].any():
            return True  # which tells without a look for jumps
        return not state[1 : max(self.order, 1 + min(self.motion.coasting, 1))].any()

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


def as_axis(number: int, given: Given, resultant: Limits | Motion | None = None) -> Axis:
    """Return an axis from its motion, or from what its fastest motion is planned with.

    An axis without limits of its own is planned within those of the resultant, which goes at
    least as far.
    """
    limits = given.limits if isinstance(given, Transfer) else None
    own = True
    if isinstance(given, tuple | list) and len(given) == 3:
        start, end, limits = given
        given = planned_motion(f"axis {number}", start, end, limits)
    elif isinstance(given, tuple | list) and len(given) == 2 and resultant is not None:
        own = False
        start, end = given
        if isinstance(resultant, Motion):
            given = _evenly(number, start, end, resultant.duration)
        else:
            forwards = _position(start) <= _position(end)
            limits = resultant if forwards else resultant.mirror()
            given = planned_motion(f"axis {number}", start, end, limits)
    if not isinstance(given, Motion):
        raise TypeError(
            f"axis {number} = {shown(given)}: expected what min_time_transfer returns, or "
            "(start, end, limits), or another trajectory"
        )
    axis = axis_of(number, given, limits)
    return axis if own else replace(axis, planned=None)


def axis_of(number: int, given: Motion, limits: Limits | None) -> Axis:
    """Return an axis from its motion and, where they are known, its limits."""
    settings = given.settings if isinstance(given, SCurveMove) else None
    motion = given.delay(-given.start_time) if given.start_time else given
    return Axis(number, motion, limits, limits if settings is None else settings)


def planned_motion(name: str, start: State, end: State, limits: Limits) -> Motion:
    """Return the fastest motion within limits; errors are headed by a name."""
    try:
        if isinstance(limits, Limits) and limits.order not in (2, 3):
            places = _at_rest("start", start), _at_rest("end", end)
            if places[0] is not None and places[1] is not None:
                return min_time_move(places[1] - places[0], limits, start=places[0])
        return min_time_transfer(start, end, limits)
    except InfeasibleError as error:
        raise error.headed(f"{name}: ") from error
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _evenly(number: int, start: State, end: State, duration: float) -> Trajectory:
    """Return a motion of constant velocity between two places at rest."""
    places = _at_rest("start", start), _at_rest("end", end)
    if places[0] is None or places[1] is None:
        raise ValueError(
            f"axis {number} = {shown((start, end))}: expected two positions beside a motion of "
            "the resultant, which says how fast it is at either end"
        )
    if not duration:
        return Trajectory([0.0], np.empty((0, 2)), end_state=[places[0], 0.0])
    velocity = (places[1] - places[0]) / duration
    return Trajectory([0.0, duration], [[places[0], velocity]], end_state=[places[1], 0.0])


def _at_rest(name: str, state: State) -> float | None:
    """Return the position of a state of rest, None for another."""
    numbers = [finite(name, value) for value in state_numbers(name, state)]
    return numbers[0] if numbers and not any(numbers[1:]) else None


def _position(state: State) -> float:
    numbers = state_numbers("start", state)
    return finite("position", numbers[0]) if numbers else 0.0
