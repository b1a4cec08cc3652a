"""Durations of legs and states at nodes, by linear programs about the last ones found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..limits import Limits
from ..optimal.whole.warm_program import Effort
from ..pieces import FloatArray
from .legs import States
from .long_ways import ramp_time
from .mesh import finer, first_cells
from .route import Leg, Node, reach_along
from .sparse_rows import Columns, SparseRows
from .tangents import End, LegMotion

_EXACTLY = {"maxiter": 5000, "time_limit": 5.0, "primal_feasibility_tolerance": 1e-9}
_WAYS: tuple[dict[str, Any], ...] = (
    {"method": "highs-ds", "options": {**_EXACTLY, "presolve": False}},
    {"method": "highs-ipm", "options": _EXACTLY},
)
_SOLVED = (0, 2)  # found, or none there is
_ROOM = 1e-6  # of the highest bounds, for the repair of what motions of fixed durations miss
_MORE_ROOM = 0.5  # the same, as a share of what durations are longer than the least
_OVERHEAD = 20  # iterations that a program is worth before it begins
_NO_WAY = 1e-3  # of the tolerance: a shift that has no direction yet


class Stage(NamedTuple):
    """How far durations may change, what is kept of the highest bound, how far places may go."""

    trust: float
    margin: float
    roam: float


COARSE = (
    *[Stage(0.3, 0.06, 1.0)] * 4,
    Stage(0.1, 0.06, 0.5),
    Stage(0.05, 0.06, 0.2),
)
FINE = (
    Stage(0.02, 0.04, 0.0),
    Stage(0.01, 0.03, 0.0),
    Stage(0.005, 0.02, 0.0),
    Stage(0.002, 0.01, 0.0),
)


class Iterate(NamedTuple):
    """Durations of the legs, inputs of the nodes and the cells, in the units of a program."""

    lengths: FloatArray
    inputs: FloatArray
    levels: FloatArray


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
    effort : Effort
        What programs may take.
    """

    nodes: Sequence[Node]
    legs: Sequence[Leg]
    limits: Sequence[Limits]
    sizes: FloatArray
    time: float
    effort: Effort

    @property
    def order(self) -> int:
        """Of the highest limits."""
        return max(one.order for one in self.limits)


def stretched(
    nodes: Sequence[Node],
    legs: Sequence[Leg],
    limits: Sequence[Limits],
    durations: Sequence[float],
    *,
    effort: Effort,
) -> Stretch:
    """Return a stretch in units of its own size, from durations near the right ones."""
    places = np.array([node.place for node in nodes])
    sizes = np.abs(np.diff(places, axis=0)).max(axis=0)
    sizes = np.where(sizes > 0.0, sizes, sizes.max())
    return Stretch(nodes, legs, limits, sizes, float(np.mean(durations)), effort)


def approximations(stretch: Stretch, durations: Sequence[float]) -> Iterator[States]:
    """Yield states at the nodes with which the legs take less and less time.

    Every motion has the highest derivative constant on cells of its leg. Durations and states
    are found together, from a linear program about the last ones found: bounds, h^r·b in the
    time of the leg, are convex in its duration h, so that their tangents are on the safe side;
    the states at the nodes, h^r·s, are linearised. Only the stages that no longer move the
    places, and hardly the durations, are given.
    """
    program = Program(stretch, durations)
    last = program.first(durations)
    for stage in COARSE + FINE:
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

    Attributes
    ----------
    meshes : list of (N + 1,) array
        Edges of the cells of every motion, leg after leg.
    """

    def __init__(self, stretch: Stretch, durations: Sequence[float]) -> None:
        self.stretch = stretch
        n, axes = stretch.order, len(stretch.limits)
        self._first = [0]
        for node in stretch.nodes:
            count = (n - 1) * node.ways.shape[1] + (axes if node.tolerance else 0)
            self._first.append(self._first[-1] + count)
        self.inputs = self._first[-1]
        self._cells = len(stretch.legs) + self.inputs
        self.meshes = [
            first_cells(one.order, ramp_time(one) / lasts)
            for leg, lasts in zip(stretch.legs, durations, strict=True)
            for one in leg.limits
        ]

    def first(self, durations: Sequence[float]) -> Iterate:
        """Return what to begin with: durations, and a stop at every node."""
        lengths = np.array(durations) / self.stretch.time
        return Iterate(lengths, np.zeros(self.inputs), np.zeros(0))

    def solve(self, last: Iterate, stage: Stage) -> Iterate | None:
        """Return durations and inputs for which the tangents ask for the least time, or None."""
        return self._solved(last, stage)

    def settled(self, last: Iterate, longer: float) -> Iterate | None:
        """Return inputs of the smallest shares of the highest bounds, durations being fixed.

        They are the last ones, times a factor: then nothing is approximate.
        """
        still = last._replace(lengths=last.lengths * longer)
        room = max(_MORE_ROOM * (longer - 1.0), _ROOM)
        return self._solved(still, Stage(0.0, 0.0, 0.0), room)

    def refine(self, last: Iterate) -> None:
        """Cut cells where inputs that were found switch inside."""
        parts = np.split(last.levels, np.cumsum([len(edges) - 1 for edges in self.meshes])[:-1])
        self.meshes = [finer(*pair) for pair in zip(self.meshes, parts, strict=True)]

    def _solved(self, last: Iterate, stage: Stage, room: float = 0.0) -> Iterate | None:
        equal, less = SparseRows(), SparseRows()
        cells = self._cells + sum(len(edges) - 1 for edges in self.meshes)
        used = cells + (len(self.meshes) if room else 0)
        units = []
        for number, motion in enumerate(self._motions(last)):
            units.append(np.full(len(motion.cells), motion.unit))
            motion.add_end(equal)
            share = np.array([cells + number] if room else [], dtype=np.intp)
            motion.add_bounds(less, stage.margin, share, room)
        ranges = np.tile([-np.inf, np.inf], (used, 1))
        ranges[cells:] = [0.0, 1.0 - room]
        count = len(last.lengths)
        ranges[:count] = np.outer(last.lengths, [1.0 - stage.trust, 1.0 + stage.trust])
        ranges[self._turning()] = 0.0
        self._hold_places(last.inputs, stage.roam, ranges, less)
        costs = np.zeros(used)
        costs[slice(cells, None) if room else slice(count)] = 1.0
        result = self._least(costs, less, equal, ranges)
        if result is None:
            return None
        inputs = self._within(result[count : self._cells])
        levels = np.concatenate(units) * result[self._cells : cells]
        return Iterate(result[:count], inputs, levels)

    def _least(
        self, costs: FloatArray, less: SparseRows, equal: SparseRows, ranges: FloatArray
    ) -> FloatArray | None:
        """Return the columns of least cost, None where none are found."""
        from scipy.optimize import linprog

        matrices = [rows.matrix(len(costs)) for rows in (less, equal)]
        size = sum(one.nnz for one in matrices if one is not None)
        sides = {"b_ub": less.sides(), "b_eq": equal.sides()}
        for way in _WAYS:
            if self.stretch.effort.left <= 0.0:
                return None
            result = linprog(
                costs, A_ub=matrices[0], A_eq=matrices[1], **sides, bounds=ranges, **way
            )
            self.stretch.effort.left -= (result.nit + _OVERHEAD) * size
            if result.status in _SOLVED:
                break
        return np.asarray(result.x) if result.status == 0 else None

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

    def _turning(self) -> list[int]:
        """Return the columns of velocities at places on a bound."""
        stretch, count = self.stretch, len(self.stretch.legs)
        return [
            count + self._first[j] + k
            for j, node in enumerate(stretch.nodes)
            if node.ways.shape[1] == len(stretch.limits) and not node.tolerance
            for k, one in enumerate(stretch.limits)
            if node.place[k] in one.position
        ]

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

    def _motions(self, last: Iterate) -> Iterator[LegMotion]:
        """Yield the motions of all legs along their ways."""
        used, meshes = self._cells, iter(self.meshes)
        for leg, ways in enumerate(self.stretch.legs):
            for number in range(len(ways.limits)):
                edges = next(meshes)
                cells = np.arange(used, used + len(edges) - 1)
                used += len(cells)
                yield self._motion(leg, number, cells, edges, last)

    def _motion(
        self, leg: int, number: int, cells: Columns, edges: FloatArray, last: Iterate
    ) -> LegMotion:
        """Return the motion of a leg along one of its ways."""
        stretch, ways = self.stretch, self.stretch.legs[leg]
        way, limits = ways.way[:, number], ways.limits[number]
        size, begin = self.size(leg, number), stretch.nodes[leg].place
        ends = [self._end(j, way, limits.order, last.inputs) for j in (leg, leg + 1)]
        distance = float(way @ (stretch.nodes[leg + 1].place - begin)) / size
        units = stretch.time ** np.arange(limits.order + 1) / size
        room = reach_along(way, begin, stretch.limits)
        lower, upper = (
            np.array([side, *sides]) * units
            for side, sides in zip(room, (limits.lower, limits.upper), strict=True)
        )
        length = float(last.lengths[leg])
        return LegMotion(leg, length, ends[0], ends[1], distance, cells, edges, lower, upper)

    def size(self, leg: int, number: int) -> float:
        """Return the unit of distance along a way of a leg."""
        return float(np.abs(self.stretch.legs[leg].way[:, number]) @ self.stretch.sizes)
