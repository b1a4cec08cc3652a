"""Durations of legs and states at nodes, by linear programs about the last ones found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from .legs import States
from .mesh import CELLS, mesh_rows
from .route import Leg, Node
from .sparse_rows import Columns, SparseRows

_ROUNDING = 1e-5  # of bounds on lower derivatives, kept for the tolerances of the solver
_LONGEST = 20.0  # seconds for one program

_STAGES = (
    *[(0.3, 0.06, 1.0)] * 4,
    (0.1, 0.06, 0.5),
    (0.05, 0.06, 0.2),
    (0.02, 0.04, 0.0),
    (0.01, 0.03, 0.0),
    (0.005, 0.02, 0.0),
    (0.002, 0.01, 0.0),
)
"""How far durations may change at a time, what is kept of the highest bound, how far places go."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """Nodes, the legs between them, and the units of the program.

    Attributes
    ----------
    nodes : sequence of Node
    legs : sequence of Leg
    limits : sequence of Limits
        One per axis.
    sizes : (axes,) array
        Unit of distance of each axis.
    time : float
        Unit of time.
    """

    nodes: Sequence[Node]
    legs: Sequence[Leg]
    limits: Sequence[Limits]
    sizes: FloatArray
    time: float

    @property
    def order(self) -> int:
        """Of the highest limits."""
        return max(one.order for one in self.limits)


def stretched(
    nodes: Sequence[Node], legs: Sequence[Leg], limits: Sequence[Limits], durations: Sequence[float]
) -> Stretch:
    """Return a stretch in units of its own size, from durations near the right ones."""
    places = np.array([node.place for node in nodes])
    sizes = np.abs(np.diff(places, axis=0)).max(axis=0)
    sizes = np.where(sizes > 0.0, sizes, sizes.max())
    return Stretch(nodes, legs, limits, sizes, float(np.mean(durations)))


def approximations(stretch: Stretch, durations: Sequence[float]) -> Iterator[States]:
    """Yield states at the nodes with which the legs take less and less time.

    Every motion has the highest derivative constant on cells of its leg. Durations and states
    are found together, from a linear program about the last ones found: bounds, h^r·b in the
    time of the leg, are convex in its duration h, so that their tangents are on the safe side;
    the states at the nodes, h^r·s, are linearised. Only the stages that no longer move the
    places, and hardly the durations, are given.
    """
    program = Program(stretch)
    lengths = np.array(durations) / stretch.time
    inputs = np.zeros(program.inputs)
    for trust, margin, roam in _STAGES:
        found = program.solve(lengths, inputs, trust, margin, roam)
        if found is not None:
            lengths, inputs = found
        if found is not None and not roam:
            yield program.states(inputs)


@dataclass(frozen=True, eq=False)
class _End:
    """The state at one end of a leg along one way: rates = constant + shares @ inputs[columns]."""

    columns: Columns
    shares: FloatArray
    constant: FloatArray

    def tangent(self, length: float, inputs: FloatArray) -> tuple[FloatArray, ...]:
        """Return what h^r·rates is per h, per input, and without both, near a duration h."""
        r = np.arange(len(self.constant))
        powers = length**r
        now = self.constant + self.shares @ inputs[self.columns]
        return (
            r * powers / length * now,
            powers[:, None] * self.shares,
            powers * (self.constant - r * now),
        )


class Program:
    """The linear program of a stretch.

    Its columns are the durations of the legs, the inputs: rates of the nodes along their ways, and
    shifts where a node may be passed at a distance, and the highest derivatives on the cells.
    """

    def __init__(self, stretch: Stretch) -> None:
        self.stretch = stretch
        n, axes = stretch.order, len(stretch.limits)
        self._first = [0]
        for node in stretch.nodes:
            count = (n - 1) * node.ways.shape[1] + (axes if node.tolerance else 0)
            self._first.append(self._first[-1] + count)
        self.inputs = self._first[-1]
        self._cells = len(stretch.legs) + self.inputs

    def solve(
        self, lengths: FloatArray, inputs: FloatArray, trust: float, margin: float, roam: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return durations and inputs for which the tangents ask for the least time, or None."""
        from scipy.optimize import linprog

        equal, less = SparseRows(), SparseRows()
        used = self._cells
        for leg, length in enumerate(lengths.tolist()):
            used = self._add_leg(leg, length, inputs, margin, used, equal, less)
        least, most = np.full(used, -np.inf), np.full(used, np.inf)
        count = len(lengths)
        least[:count], most[:count] = lengths * (1.0 - trust), lengths * (1.0 + trust)
        self._hold_places(inputs, roam, least, most, less)
        result = linprog(
            np.repeat([1.0, 0.0], [count, used - count]),
            A_ub=less.matrix(used),
            b_ub=less.sides(),
            A_eq=equal.matrix(used),
            b_eq=equal.sides(),
            bounds=np.column_stack([least, most]),
            options={"time_limit": _LONGEST},
        )
        if result.status != 0:
            return None
        return result.x[:count], self._within(result.x[count : self._cells])

    def states(self, inputs: FloatArray) -> States:
        """Return the states of the nodes, in the units of the axes."""
        stretch, states = self.stretch, []
        for j, node in enumerate(stretch.nodes):
            state = np.zeros((stretch.order, len(node.place)))
            state[0], state[1] = node.place + self._shift(j, inputs), node.velocity
            rates = self._rates(j, inputs) / stretch.time ** np.arange(1, stretch.order)[:, None]
            state[1:] += rates @ (node.ways * self._units(node)).T
            states.append(state)
        return states

    def _units(self, node: Node) -> FloatArray:
        """Return the unit of distance along each way of a node."""
        return np.asarray(self.stretch.sizes @ np.abs(node.ways))

    def _rates(self, j: int, inputs: FloatArray) -> FloatArray:
        """Return the rates of a node, (order − 1, ways)."""
        count = (self.stretch.order - 1) * self.stretch.nodes[j].ways.shape[1]
        first = self._first[j]
        return inputs[first : first + count].reshape(self.stretch.order - 1, -1)

    def _places(self, j: int) -> slice:
        """Return where the shifts of a node are among the inputs."""
        axes = len(self.stretch.limits) if self.stretch.nodes[j].tolerance else 0
        return slice(self._first[j + 1] - axes, self._first[j + 1])

    def _shift(self, j: int, inputs: FloatArray) -> FloatArray:
        shift = inputs[self._places(j)]
        return shift * self.stretch.sizes if len(shift) else np.zeros(len(self.stretch.limits))

    def _within(self, inputs: FloatArray) -> FloatArray:
        """Return inputs with the shifts cut back to the tolerances."""
        inputs = inputs.copy()
        for j, node in enumerate(self.stretch.nodes):
            far = float(np.linalg.norm(self._shift(j, inputs)))
            if far > node.tolerance:
                inputs[self._places(j)] *= node.tolerance / far
        return inputs

    def _hold_places(
        self,
        inputs: FloatArray,
        roam: float,
        least: FloatArray,
        most: FloatArray,
        less: SparseRows,
    ) -> None:
        """Keep the shifts near the last ones, and within the tolerance in their direction."""
        count = len(self.stretch.legs)
        for j, node in enumerate(self.stretch.nodes):
            if not node.tolerance:
                continue
            places, sizes = self._places(j), self.stretch.sizes
            columns = count + np.arange(places.start, places.stop)
            width, now = node.tolerance / sizes, inputs[places]
            least[columns] = np.maximum(-width, now - roam * width)
            most[columns] = np.minimum(width, now + roam * width)
            shift = self._shift(j, inputs)
            far = float(np.linalg.norm(shift))
            if roam and far > 1e-3 * node.tolerance:
                less.add(columns, (shift / far * sizes)[None, :], np.array([node.tolerance]))

    def _end(self, j: int, way: FloatArray, size: float, order: int) -> _End:
        """Return the state of a node along a way, in units of a size."""
        stretch, node = self.stretch, self.stretch.nodes[j]
        shares = np.zeros((order, self._first[j + 1] - self._first[j]))
        along = way @ (node.ways * self._units(node)) / size
        for r in range(1, order):
            shares[r, (r - 1) * len(along) : r * len(along)] = along
        if node.tolerance:
            shares[0, -len(way) :] = way * stretch.sizes / size
        constant = np.zeros(order)
        constant[1] = way @ node.velocity / size * stretch.time
        return _End(np.arange(self._first[j], self._first[j + 1]), shares, constant)

    def _add_leg(
        self,
        leg: int,
        length: float,
        inputs: FloatArray,
        margin: float,
        used: int,
        equal: SparseRows,
        less: SparseRows,
    ) -> int:
        """Add the motions of a leg; return the number of columns used so far."""
        stretch = self.stretch
        places = [stretch.nodes[leg + side].place for side in (0, 1)]
        for way, limits in zip(stretch.legs[leg].way.T, stretch.legs[leg].limits, strict=True):
            n, size = limits.order, float(np.abs(way) @ stretch.sizes)
            ends = [self._end(leg + side, way, size, n) for side in (0, 1)]
            first, last = (end.tangent(length, inputs) for end in ends)
            count = len(stretch.legs)
            start_columns, end_columns = (count + end.columns for end in ends)
            cells = np.arange(used, used + CELLS)
            final, bounded, derivative = mesh_rows(n)
            distance = np.zeros(n)
            distance[0] = way @ (places[1] - places[0]) / size
            equal.add(
                np.concatenate([[leg], start_columns, end_columns, cells]),
                np.hstack(
                    [
                        (final[:, :n] @ first[0] - last[0])[:, None],
                        final[:, :n] @ first[1],
                        -last[1],
                        final[:, n:],
                    ]
                ),
                distance + last[2] - final[:, :n] @ first[2],
            )
            columns = np.concatenate([[leg], start_columns, cells])
            values = np.hstack(
                [
                    (bounded[:, :n] @ first[0])[:, None],
                    bounded[:, :n] @ first[1],
                    bounded[:, n:],
                ]
            )
            constant = bounded[:, :n] @ first[2]
            kept = np.where(derivative == n, 1.0 - margin, 1.0 - _ROUNDING)
            for sign, sides in ((1.0, limits.upper), (-1.0, limits.lower)):
                bound = sign * np.array(sides)[derivative - 1] * kept
                bound *= stretch.time**derivative / size
                finite = np.isfinite(bound)
                slope = bound[finite] * derivative[finite] * length ** (derivative[finite] - 1)
                rows = sign * values[finite]
                rows[:, 0] -= slope
                offset = bound[finite] * (derivative[finite] - 1) * length ** derivative[finite]
                less.add(columns, rows, -offset - sign * constant[finite])
            used += CELLS
        return used
