"""Torque ripple over position: cogging, as a table of straight lines that repeats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..shaping.checks import finite, positive, whole
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import real_array, shown
from ..shaping.told import Told

_MOST = 32  # points of a period


@dataclass(frozen=True, repr=False)
class Ripple(Told, Frozen):
    """A torque on the motor that depends on its position alone, and repeats every period.

    Between the points it is straight, and so is it from the last to the first of the next period;
    a loop with it is simulated exactly.

    Parameters
    ----------
    positions : sequence of 2 to 32 floats
        Increasing, over less than a period.
    torques : sequence of floats
        In the direction of positive positions, seen at the axis as all torques.
    period : float
        Positive.

    Raises
    ------
    ValueError
        For positions that do not increase or are a period apart, or numbers that do not fit.

    Examples
    --------
    >>> cogging = Ripple([0.0, 0.25, 0.75], [0.0, 2.0, -2.0], period=1.0)
    >>> cogging([0.125, 1.125, -0.125]).tolist()
    [1.0, 1.0, -1.0]
    """

    positions: tuple[float, ...]
    torques: tuple[float, ...]
    period: float

    def __post_init__(self) -> None:
        places, torques = (
            real_array(name, getattr(self, name)) for name in ("positions", "torques")
        )
        object.__setattr__(self, "period", positive("period", self.period))
        if places.ndim != 1 or not 2 <= places.size <= _MOST or torques.shape != places.shape:
            raise ValueError(
                f"ripple with positions of shape {places.shape} and torques of shape "
                f"{torques.shape}: expected 2 to {_MOST} points, one torque for each position"
            )
        rising = bool((np.diff(places) > 0.0).all()) and np.isfinite(places).all()
        if not rising or not places[-1] - places[0] < self.period:
            raise ValueError(
                f"positions = {shown(self.positions)}: expected numbers that increase, over less "
                f"than the period of {shown(self.period)}"
            )
        if not np.isfinite(torques).all():
            raise ValueError(f"torques = {shown(self.torques)}: expected finite numbers")
        object.__setattr__(self, "positions", tuple(places.tolist()))
        object.__setattr__(self, "torques", tuple(torques.tolist()))

    @classmethod
    def sine(
        cls, amplitude: float, period: float, *, phase_deg: float = 0.0, points: int = 24
    ) -> Ripple:
        """Return amplitude·sin(360°·position/period + phase) as straight lines between points.

        They miss the sine by up to 1 − cos(180°/points) of it, with 24 points 0.9 %.
        """
        size, period = finite("amplitude", amplitude), positive("period", period)
        parts = np.arange(float(whole("points", points, 3, _MOST))) / points
        angles = 2.0 * np.pi * parts + np.radians(finite("phase_deg", phase_deg))
        return cls(tuple(period * parts), tuple(size * np.sin(angles)), period)

    @property
    def edges(self) -> FloatArray:
        """Positions of all points, and that a period behind the first."""
        return np.append(self.positions, self.positions[0] + self.period)

    def lines(self) -> list[tuple[float, float]]:
        """Return offset and slope of the torque between each two edges."""
        levels = np.append(self.torques, self.torques[0])
        slopes = np.diff(levels) / np.diff(self.edges)
        return list(zip((levels[:-1] - slopes * self.edges[:-1]).tolist(), slopes, strict=True))

    def turns_before(self, position: float) -> float:
        """Return the multiple of the period by which a position is beyond the table."""
        return float(np.floor((position - self.positions[0]) / self.period) * self.period)

    def cell(self, position: float) -> int:
        """Return between which edges a position is."""
        inside = position - self.turns_before(position)
        return int(np.clip(np.searchsorted(self.edges, inside, "right") - 1, 0, self.count - 1))

    @property
    def count(self) -> int:
        """Number of straight lines."""
        return len(self.positions)

    def __call__(self, position: ArrayLike) -> Any:
        """Return the torque at positions."""
        at = np.asarray(real_array("position", position))
        return np.interp(at, self.positions, self.torques, period=self.period)
