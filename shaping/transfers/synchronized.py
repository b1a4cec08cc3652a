"""Axes tied together in time, and their modification under way."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..checks import finite, one_of, state_numbers
from ..drawing import draw
from ..limits import Limits
from ..passage import Passage
from ..pieces import FloatArray
from ..real_numbers import shown
from ..told import table
from ..trajectory import Motion, Trajectory
from .axes import Axis, Planned, axis_of, planned_motion
from .line_under_way import Line, changed, line_from, unknown_limits
from .modes import MODES, Mode, both_together, ending_together
from .problem import State
from .s_curve import s_curve_from
from .s_curve_settings import SCurveSettings, checked_final
from .straight_line import straight_line
from .under_way import before, spliced

Change = Limits | Mapping[str, float] | None


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Synchronized(tuple[Motion, ...]):
    """The motions of several axes tied together in time, as `synchronize` returns them.

    Attributes
    ----------
    mode : "start", "end", "both" or "straight-line"
    planned : tuple of (Limits, SCurveSettings or None)
        What each axis was planned with, as far as it is known.
    line : Line, optional
        Of axes that move on a straight line: the line, and the motion along it.
    passage : Passage, optional
        Of axes that move through points: the points, and when they are passed.
    """

    mode: Mode
    planned: tuple[Planned, ...]
    line: Line | None = None
    passage: Passage | None = None

    @classmethod
    def of(
        cls,
        motions: Sequence[Motion],
        mode: Mode,
        planned: tuple[Planned, ...],
        line: Line | None = None,
        *,
        passage: Passage | None = None,
    ) -> Synchronized:
        """Return motions that are tied together already."""
        tied = tuple.__new__(cls, motions)
        fields = tied.__dict__  # the way around `frozen`
        fields["mode"], fields["planned"], fields["line"] = mode, planned, line
        fields["passage"] = passage
        return tied

    def __repr__(self) -> str:
        return f"Synchronized(axes={len(self)}, mode={self.mode!r}, duration={self.duration:.10g})"

    def _repr_html_(self) -> str:
        rows = [("mode", self.mode), ("duration", f"{self.duration:.10g}")]
        rows += [(f"axis {k}", repr(motion)) for k, motion in enumerate(self)]
        return table(type(self).__name__, rows)

    @property
    def duration(self) -> float:
        """Time from the first start to the last end."""
        return max(one.end_time for one in self) - min(one.start_time for one in self)

    @property
    def times(self) -> FloatArray:
        """When each point is passed, shape (m,), of axes that move `through` points.

        Raises
        ------
        ValueError
            For axes that were given no points.
        """
        if self.passage is None:
            raise ValueError(
                f"{self!r} has no points that it passes: expected what through returns"
            )
        return self.passage.times

    @property
    def resultant(self) -> Trajectory:
        """The motion along a straight line: distance from its start, with all derivatives.

        Raises
        ------
        ValueError
            For axes that are on no line, or do not move.
        """
        if self.line is None or not self.line.legs:
            raise ValueError(
                f"{self!r} has no resultant: expected axes that move, with mode='straight-line'"
            )
        return self.line.path

    def modify(
        self,
        time: float,
        targets: Sequence[State | None] | None = None,
        *,
        relative: bool = False,
        limits: Limits | Sequence[Change] | None = None,
        resultant: Limits | Mapping[str, float] | None = None,
        mode: Mode | None = None,
    ) -> Synchronized:
        """Return these motions up to a time, and from their states then on new ones, tied again.

        Parameters
        ----------
        time : float
            Before their start they wait, after their end they coast.
        targets : sequence of (position, velocity, acceleration) or None, optional
            One per axis, numbers left out zero: absolute, or from the old target where `relative`.
            None leaves an axis where it was to go, or all of them.
        relative : bool, optional
        limits : Limits or sequence of Limits, rates or None, optional
            For all axes or one per axis. Of an S-curve rates as in `SCurveMove.modify`, such as
            {"velocity": 2.0}. What is left out stays as it was.
        resultant : Limits or rates, optional
            Of a straight line: bounds of the motion along it, or of an S-curve along it new rates.
        mode : "start", "end", "both" or "straight-line", optional
            Default: as it was.

        Returns
        -------
        Synchronized
            Of each axis, position, velocity and, where jerk is bounded, acceleration have no
            step (by jerk percent a new plan begins with zero acceleration). "end" ends together
            as "both" does, for what moves cannot wait. On a "straight-line" a new target further
            along the line, or behind, is gone to along it; for another the axes stop on the line
            first, in the least time, and then go straight.

        Raises
        ------
        InfeasibleError, ValueError
            As `synchronize`; for an axis whose limits are not known, or of another order than
            2 and 3.

        Examples
        --------
        >>> from jounce.shaping import synchronize
        >>> slow = Limits(velocity=1.0, acceleration=1.0, jerk=2.0)
        >>> both = synchronize([(0.0, 4.0, slow), (0.0, 2.0, slow)])
        >>> further = both.modify(2.0, [8.0, None])
        >>> [float(axis.end_state[0]) for axis in further], round(further.duration, 6)
        ([8.0, 2.0], 9.5)
        """
        mode = self.mode if mode is None else mode
        one_of("mode", mode, MODES)
        been = [before(axis, finite("time", time)) for axis in self]
        planned = self._changed(limits)
        ends = self._ends(targets, relative)
        if mode == "straight-line":
            motions, line = line_from(
                been, self.line, ends, planned, resultant, stays=targets is None
            )
            return Synchronized.of(motions, mode, planned, line)
        if resultant is not None:
            raise ValueError(
                f"resultant = {shown(resultant)} with mode = {mode!r}: it holds along a line, use "
                "mode='straight-line'"
            )
        axes = [
            _onward(number, *each)
            for number, each in enumerate(zip(been, ends, planned, strict=True))
        ]
        after = [axis.motion for axis in axes] if mode == "start" else both_together(axes)
        tied = [spliced(*pair) for pair in zip(been, after, strict=True)]
        return Synchronized.of(tied, mode, planned)

    def plot(self, *, unit: str = "", time_unit: str = "s", scale: float = 1.0) -> Any:
        """Draw the path of the first two axes, and all axes over time.

        Parameters
        ----------
        unit, time_unit : str, optional
            For the labels.
        scale : float, optional
            Units of the trajectories per `unit`, positive.

        Returns
        -------
        Figure
            As `jounce.plots.plot_synchronized` draws it.
        """
        return draw(self, unit=unit, time_unit=time_unit, scale=scale)

    def _changed(self, given: Limits | Sequence[Change] | None) -> tuple[Planned, ...]:
        """Return what the axes are planned with from now on."""
        if given is None or isinstance(given, Limits):
            changes: list[Any] = [given] * len(self)
        else:
            changes = self._one_each("limits", given)
        return tuple(
            old if new is None else changed(f"axis {number}", old, new)
            for number, (old, new) in enumerate(zip(self.planned, changes, strict=True))
        )

    def _ends(
        self, targets: Sequence[State | None] | None, relative: bool
    ) -> list[tuple[float, ...]]:
        """Return the states at the ends."""
        old = [axis.end_state[:-1].tolist() for axis in self]
        if targets is None:
            return [tuple(end) for end in old]
        ends = []
        for end, target in zip(old, self._one_each("targets", targets), strict=True):
            if target is None:
                ends.append(tuple(end))
                continue
            state = [finite("target", value) for value in state_numbers("target", target)]
            if not state:
                raise ValueError(
                    f"target = {shown(target)}: expected a position, or (position, velocity, "
                    "acceleration)"
                )
            state[0] += end[0] if relative else 0.0
            ends.append(tuple(state))
        return ends

    def _one_each(self, name: str, given: Any) -> list[Any]:
        """Return a list with one entry per axis."""
        if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
            raise TypeError(f"{name} = {shown(given)}: expected a list with one entry per axis")
        listed = list(given)
        if len(listed) != len(self):
            raise ValueError(
                f"{name} = {shown(given)}: expected {len(self)} entries, one per axis, not "
                f"{len(listed)}"
            )
        return listed


def tied_together(axes: list[Axis], mode: Mode, resultant: Limits | Motion | None) -> Synchronized:
    """Return the motions of axes tied together."""
    planned = tuple(axis.planned for axis in axes)
    if mode == "straight-line":
        motions, path = straight_line(axes, resultant)
        line = Line.of(motions, path, resultant)
        return Synchronized.of(motions, mode, planned, line)
    if mode == "start":
        return Synchronized.of([axis.motion for axis in axes], mode, planned)
    motions = ending_together(axes) if mode == "end" else both_together(axes)
    return Synchronized.of(motions, mode, planned)


def _onward(number: int, been: Trajectory, end: tuple[float, ...], planned: Planned) -> Axis:
    """Return the fastest motion of an axis from where it is to an end."""
    x, *rates = been.end_state[:-1].tolist()
    if isinstance(planned, SCurveSettings):
        return _s_curve_onward(number, (x, *rates, 0.0, 0.0), end, planned)
    if planned is None and not any(rates) and not any(end[1:]) and end[0] == x:
        return axis_of(number, Trajectory([0.0], np.empty((0, 2)), end_state=[x, 0.0]), None)
    if planned is None or planned.order not in (2, 3):
        raise unknown_limits(number, planned)
    n = planned.order
    state = (x, *rates)[:n]
    goal = end[:n] if len(end) > n + 1 else end
    return axis_of(number, planned_motion(f"axis {number}", state, goal, planned), planned)


def _s_curve_onward(
    number: int, state: tuple[float, ...], end: tuple[float, ...], settings: SCurveSettings
) -> Axis:
    """Return an axis that goes on by an S-curve."""
    target, velocity, acceleration = (*end, 0.0, 0.0)[:3]
    if acceleration:
        raise ValueError(
            f"target acceleration = {acceleration!r} of axis {number}: an S-curve ends without; "
            "leave it out, or give the axis limits"
        )
    settings = replace(settings, final_velocity=checked_final(velocity, settings.rates))
    x, v, a = state[:3]
    axis = axis_of(number, s_curve_from((x, v, a), target, settings), None)
    return replace(axis, slows=True)
