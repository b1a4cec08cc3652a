"""Durations of legs and states at nodes, by linear programs about the last ones found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from .legs import States
from .mesh import CELLS
from .route import Leg, Node
from .sparse_rows import SparseRows
from .tangents import End, LegMotion

_LONGEST = 20.0  # seconds for one program
_NO_WAY = 1e-3  # of the tolerance: a shift that has no direction yet


class Stage(NamedTuple):
    """How far durations may change, what is kept of the highest bound, how far places may go."""

    trust: float
    margin: float
    roam: float


_STAGES = (
    *[Stage(0.3, 0.06, 1.0)] * 4,
    Stage(0.1, 0.06, 0.5),
    Stage(0.05, 0.06, 0.2),
    Stage(0.02, 0.04, 0.0),
    Stage(0.01, 0.03, 0.0),
    Stage(0.005, 0.02, 0.0),
    Stage(0.002, 0.01, 0.0),
)


class Iterate(NamedTuple):
    """Durations of the legs, and inputs of the nodes, in the units of a program."""

    lengths: FloatArray
    inputs: FloatArray


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
    last = Iterate(np.array(durations) / stretch.time, np.zeros(program.inputs))
    for stage in _STAGES:
        found = program.solve(last, stage)
        if found is None:
            continue
        last = found
        if not stage.roam:
            yield program.states(last.inputs)


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

    def solve(self, last: Iterate, stage: Stage) -> Iterate | None:
        """Return durations and inputs for which the tangents ask for the least time, or None."""
        from scipy.optimize import linprog

        equal, less, used = SparseRows(), SparseRows(), self._cells
        for motion, size in self._motions(last):
            motion.add_end(equal)
            motion.add_bounds(less, stage.margin, self.stretch.time, size)
            used += CELLS
        ranges = np.tile([-np.inf, np.inf], (used, 1))
        count = len(last.lengths)
        ranges[:count] = np.outer(last.lengths, [1.0 - stage.trust, 1.0 + stage.trust])
        self._hold_places(last.inputs, stage.roam, ranges, less)
        result = linprog(
            np.repeat([1.0, 0.0], [count, used - count]),
            A_ub=less.matrix(used),
            b_ub=less.sides(),
            A_eq=equal.matrix(used),
            b_eq=equal.sides(),
            bounds=ranges,
            options={"time_limit": _LONGEST},
        )
        if result.status != 0:
            return None
        return Iterate(result.x[:count], self._within(result.x[count : self._cells]))

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
        self, inputs: FloatArray, roam: float, ranges: FloatArray, less: SparseRows
    ) -> None:
        """Keep the shifts near the last ones, and within the tolerance in their direction."""
        for j, node in enumerate(self.stretch.nodes):
            if not node.tolerance:
                continue
            places, sizes = self._places(j), self.stretch.sizes
            columns = len(self.stretch.legs) + np.arange(places.start, places.stop)
            width, now = node.tolerance / sizes, inputs[places]
            ranges[columns, 0] = np.maximum(-width, now - roam * width)
            ranges[columns, 1] = np.minimum(width, now + roam * width)
            shift = self._shift(j, inputs)
            far = float(np.linalg.norm(shift))
            if roam and far > _NO_WAY * node.tolerance:
                less.add(columns, (shift / far * sizes)[None, :], np.array([node.tolerance]))

    def _end(self, j: int, way: FloatArray, order: int, inputs: FloatArray) -> End:
        """Return the state of a node along a way, in units of its size."""
        stretch, node = self.stretch, self.stretch.nodes[j]
        size, own = float(np.abs(way) @ stretch.sizes), slice(*self._first[j : j + 2])
        shares = np.zeros((order, own.stop - own.start))
        along = way @ (node.ways * self._units(node)) / size
        for r in range(1, order):
            shares[r, (r - 1) * len(along) : r * len(along)] = along
        if node.tolerance:
            shares[0, -len(way) :] = way * stretch.sizes / size
        constant = np.zeros(order)
        constant[1] = way @ node.velocity / size * stretch.time
        columns = len(stretch.legs) + np.arange(own.start, own.stop)
        return End(columns, shares, constant, inputs[own])

    def _motions(self, last: Iterate) -> Iterator[tuple[LegMotion, float]]:
        """Yield the motions of all legs along their ways, and their sizes."""
        stretch, used = self.stretch, self._cells
        for leg, (ways, length) in enumerate(zip(stretch.legs, last.lengths.tolist(), strict=True)):
            between = stretch.nodes[leg + 1].place - stretch.nodes[leg].place
            for way, limits in zip(ways.way.T, ways.limits, strict=True):
                size = float(np.abs(way) @ stretch.sizes)
                ends = [self._end(j, way, limits.order, last.inputs) for j in (leg, leg + 1)]
                cells = np.arange(used, used + CELLS)
                distance = float(way @ between) / size
                yield LegMotion(leg, length, ends[0], ends[1], distance, cells, limits), size
                used += CELLS
