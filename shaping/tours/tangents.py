"""The motion over one leg along one way, as rows of a linear program near a duration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from .mesh import mesh_rows
from .sparse_rows import Columns, SparseRows

_ROUNDING = 1e-5  # of bounds on lower derivatives, kept for the tolerances of the solver


@dataclass(frozen=True, eq=False)
class End:
    """The state at one end: rates = constant + shares @ inputs, of these columns and values now."""

    columns: Columns
    shares: FloatArray
    constant: FloatArray
    inputs: FloatArray

    def tangent(self, length: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return what h^r·rates is per h, per input, and without both, near a duration h."""
        r = np.arange(len(self.constant))
        powers = length**r
        now = self.constant + self.shares @ self.inputs
        return (
            r * powers / length * now,
            powers[:, None] * self.shares,
            powers * (self.constant - r * now),
        )


@dataclass(frozen=True, eq=False)
class LegMotion:
    """A motion in units of its own size and of the program's time.

    Attributes
    ----------
    leg : int
        Column of the duration.
    length : float
        Duration now.
    start, end : End
    distance : float
    cells : (CELLS,) array
        Columns of the highest derivative.
    limits : Limits
    """

    leg: int
    length: float
    start: End
    end: End
    distance: float
    cells: Columns
    limits: Limits

    def add_end(self, equal: SparseRows) -> None:
        """Add the rows by which the motion leads to the end."""
        n = self.limits.order
        final, _, _ = mesh_rows(n)
        lead, cells = final[:, :n], final[:, n:]
        (per_time, per_input, rest), end = (one.tangent(self.length) for one in self._ends)
        columns = np.concatenate([[self.leg], self.start.columns, self.end.columns, self.cells])
        on_time = (lead @ per_time - end[0])[:, None]
        values = np.hstack([on_time, lead @ per_input, -end[1], cells])
        sides = end[2] - lead @ rest
        sides[0] += self.distance
        equal.add(columns, values, sides)

    def add_bounds(self, less: SparseRows, margin: float, time: float, size: float) -> None:
        """Add the rows that keep the bounds, a margin of the highest, in units of time and size."""
        n = self.limits.order
        _, bounded, k = mesh_rows(n)
        lead, cells = bounded[:, :n], bounded[:, n:]
        per_time, per_input, rest = self.start.tangent(self.length)
        columns = np.concatenate([[self.leg], self.start.columns, self.cells])
        values = np.hstack([(lead @ per_time)[:, None], lead @ per_input, cells])
        unit = np.where(k == n, 1.0 - margin, 1.0 - _ROUNDING) * time**k / size
        for sign, sides in ((1.0, self.limits.upper), (-1.0, self.limits.lower)):
            bound = sign * np.array(sides)[k - 1] * unit
            finite = np.isfinite(bound)
            power = bound[finite] * self.length ** k[finite]
            rows = sign * values[finite]
            rows[:, 0] -= k[finite] * power / self.length
            less.add(columns, rows, (1 - k[finite]) * power - sign * (lead @ rest)[finite])

    @property
    def _ends(self) -> tuple[End, End]:
        return self.start, self.end
