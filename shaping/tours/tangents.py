"""The motion over one leg along one way, as rows of a linear program near a duration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..pieces import INVERSE_FACTORIALS, FloatArray
from .mesh import mesh_rows
from .sparse_rows import Columns, SparseRows

_ROUNDING = 1e-5  # of bounds on lower derivatives, kept for the tolerances of the solver
_BELOW = 0.5  # of the room of the highest bound: that of the bounds on lower derivatives
_PLACES = 5e-7  # the most of it that bounds on position have, in units of the size
_NEAR_ENDS = 4.0  # of it: what the highest derivative can do since the start, or until the end


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
    cells : (N,) array
        Columns of the highest derivative.
    edges : (N + 1,) array
        Of the cells, from 0 to 1.
    lower, upper : (n + 1,) arrays
        Bounds on position, as seen from the place of the start, and on derivatives.
    """

    leg: int
    length: float
    start: End
    end: End
    distance: float
    cells: Columns
    edges: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def order(self) -> int:
        """Of the highest derivative."""
        return len(self.upper) - 1

    @property
    def unit(self) -> float:
        """Of the highest derivative on the cells: what its bounds allow in the time of the leg."""
        return float(max(-self.lower[-1], self.upper[-1]) * self.length**self.order)

    def add_end(self, equal: SparseRows) -> None:
        """Add the rows by which the motion leads to the end."""
        n = self.order
        final, _, _ = mesh_rows(n, self.edges)
        lead, cells = final[:, :n], final[:, n:] * self.unit
        (per_time, per_input, rest), end = (one.tangent(self.length) for one in self._ends)
        columns = np.concatenate([[self.leg], self.start.columns, self.end.columns, self.cells])
        on_time = (lead @ per_time - end[0])[:, None]
        values = np.hstack([on_time, lead @ per_input, -end[1], cells])
        sides = end[2] - lead @ rest
        sides[0] += self.distance
        equal.add(columns, values, sides)

    def add_bounds(self, less: SparseRows, margin: float, share: Columns, kept: float) -> None:
        """Add the rows that keep the bounds, a margin of the highest.

        `share` is empty, or the column of the share of the highest bound that is used, where the
        duration is fixed; then a share of all bounds is `kept` for the repair of what it misses.
        """
        n = self.order
        _, bounded, k = mesh_rows(n, self.edges)
        lead, cells = bounded[:, :n], bounded[:, n:] * self.unit
        per_time, per_input, rest = self.start.tangent(self.length)
        columns = np.concatenate([[self.leg], self.start.columns, self.cells, share])
        free = np.zeros((len(k), len(share)))
        values = np.hstack([(lead @ per_time)[:, None], lead @ per_input, cells, free])
        room, shared = self._room(k, kept), (k == n) & (len(share) > 0)
        for sign, sides in ((1.0, self.upper), (-1.0, self.lower)):
            finite = np.isfinite(sides[k])
            of, by_share = k[finite], shared[finite]
            bound = np.where(of == n, 1.0 - margin, 1.0) * sign * sides[of]
            power = bound * self.length**of
            slope = np.where(by_share, 0.0, of * power / self.length)
            rows = sign * values[finite]
            rows[:, 0] -= slope
            rows[by_share, -1:] = -power[by_share, None]
            left = room[finite] * ((bound != 0.0) | (kept > 0.0))  # ends may be on a bound of zero
            most = np.where(by_share, 0.0, power - slope * self.length - left)
            less.add(columns, rows, most - sign * (lead @ rest)[finite])

    def _room(self, k: NDArray[np.intp], kept: float) -> FloatArray:
        """Return what the rows of derivatives k below the highest keep free."""
        n, highest = self.order, k == self.order
        most = np.maximum(np.abs(self.lower), np.abs(self.upper)) * self.length ** np.arange(n + 1)
        if not kept:
            return np.where(highest | (k == 0), 0.0, _ROUNDING * most[k])
        most[0] = min(1.0, _PLACES / (_BELOW * kept))
        begun, left = self.edges[:-1], 1.0 - self.edges[1:]
        reach = []
        for r in range(n + 1):
            near = np.minimum(self._since(self.start, r, begun), self._since(self.end, r, left))
            reach += [near ** (n - r) * INVERSE_FACTORIALS[n - r]] * max(n - r, 1)
        room = np.minimum(_BELOW * most[k], _NEAR_ENDS * most[n] * np.concatenate(reach))
        return np.asarray(kept * room)

    def _since(self, end: End, derivative: int, away: FloatArray) -> FloatArray:
        """Return how far cells are from an end where a derivative is given; where not, 1."""
        given = derivative < self.order and not end.shares[derivative].any()
        return away if given else np.ones(len(away))

    @property
    def _ends(self) -> tuple[End, End]:
        return self.start, self.end
