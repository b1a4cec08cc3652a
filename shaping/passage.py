"""The points that a motion passes, and when it passes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .drawing import draw
from .frozen import Frozen
from .pieces import FloatArray
from .told import Told
from .trajectory import Planned, Trajectory


@dataclass(frozen=True, eq=False, repr=False)
class Passage(Told, Frozen):
    """Points that are passed.

    Attributes
    ----------
    points : (m, axes) array
        As they were given.
    times : (m,) array
        When each is passed; where the motion keeps to a distance, when it is within it.
    corner : float
        How far from a point the motion may pass.
    """

    points: FloatArray
    times: FloatArray
    corner: float


@dataclass(frozen=True, eq=False, repr=False)
class Tour(Planned):
    """A motion of one axis through points, which answers what its trajectory does.

    Attributes
    ----------
    trajectory : Trajectory
    passage : Passage
        The points, and when they are passed.
    """

    trajectory: Trajectory
    passage: Passage

    @property
    def times(self) -> FloatArray:
        """When each point is passed, shape (m,)."""
        return self.passage.times

    def plot(self, *, unit: str = "", time_unit: str = "s", scale: float = 1.0) -> Any:
        """Draw position, with the points, and every derivative.

        Parameters
        ----------
        unit, time_unit : str, optional
            For the labels.
        scale : float, optional
            Units of the trajectory per `unit`, positive.

        Returns
        -------
        Figure
            As `jounce.plots.plot_tour` draws it.
        """
        return draw(self, unit=unit, time_unit=time_unit, scale=scale)
