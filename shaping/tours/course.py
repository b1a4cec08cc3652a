"""A course: the points asked for, and the route that it makes of them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from ..transfers.straight_line import tightest
from .route import Leg, Node, Route

_PARALLEL = 1e-9  # difference of two directions that is rounding
_MOST_OF_A_LINE = 1.0 / 3.0  # what a blend takes at either end


@dataclass(frozen=True, eq=False)
class Course:
    """What is asked for.

    Attributes
    ----------
    points : (m, axes) array
        No two in a row the same.
    limits : tuple of Limits
        One per axis.
    straight : tuple of bool
        Of every leg, whether it is a line.
    scan : mapping of int to float
        Speeds of legs by their number.
    """

    points: FloatArray
    limits: tuple[Limits, ...]
    straight: tuple[bool, ...]
    scan: Mapping[int, float]

    def route(self, corner: float, reach: float) -> Route:
        """Return the route, each corner of two lines cut from `reach` before it to behind it."""
        kept = [i for i in range(len(self.points)) if not self._on_the_way(i)]
        legs = [self._leg(*pair) for pair in itertools.pairwise(kept)]
        nodes: list[Node] = []
        ways: list[Leg] = []
        blends: list[tuple[FloatArray, int]] = []
        at: dict[int, tuple[int, int]] = {}
        for number, i in enumerate(kept):
            here = self._cut(kept, number, reach) or [self._node(i, corner)]
            at[i] = (len(nodes), len(nodes) + len(here) - 1)
            nodes.extend(here)
            if len(here) > 1:
                blends.append((self.points[i], len(ways)))
                ways.append(_free(self.limits))
            ways.extend(legs[number : number + 1])
        windows = [
            at[i]
            if i in at
            else (at[max(k for k in kept if k < i)][1], at[min(k for k in kept if k > i)][0])
            for i in range(len(self.points))
        ]
        return Route(tuple(nodes), tuple(ways), tuple(windows), tuple(blends))

    def direction(self, i: int, j: int | None = None) -> FloatArray:
        """Return the unit vector from point i to point j, or the next."""
        way = self.points[i + 1 if j is None else j] - self.points[i]
        size = np.abs(way).max()
        return np.asarray(way / size / np.linalg.norm(way / size))

    def line(self, way: FloatArray) -> Limits:
        """Return the bounds on the motion along a line: the tightest of all axes."""
        order = max(one.order for one, share in zip(self.limits, way, strict=True) if share)
        pairs = zip(way.tolist(), self.limits, strict=True)
        shares = (
            (share, (one.bounds(k) for k in range(1, one.order + 1)))
            for share, one in pairs
            if share
        )
        return Limits.from_bounds(tightest(shares, order))

    def _kind(self, leg: int) -> str:
        """Return what a leg is."""
        return "scan" if leg in self.scan else "straight" if self.straight[leg] else "free"

    def _on_the_way(self, i: int) -> bool:
        """Tell whether a motion between the points around passes a point by itself."""
        if not 0 < i < len(self.points) - 1 or self._kind(i - 1) != self._kind(i):
            return False
        if self._kind(i) == "scan" or (self._kind(i) == "free" and len(self.limits) > 1):
            return False
        return self._goes_on(i)

    def _goes_on(self, i: int) -> bool:
        return bool(np.abs(self.direction(i - 1) - self.direction(i)).max() <= _PARALLEL)

    def _leg(self, i: int, j: int) -> Leg:
        way = self.direction(i, j)
        if i in self.scan:
            return Leg("scan", way[:, None], (self.line(way),), self.scan[i])
        if self.straight[i]:
            return Leg("straight", way[:, None], (self.line(way),))
        return _free(self.limits)

    def _node(self, i: int, corner: float) -> Node:
        """Return the node at a point that is not cut."""
        place, axes = self.points[i], len(self.limits)
        scanned = [leg for leg in (i - 1, i) if leg in self.scan]
        stop = np.zeros((axes, 0))
        if scanned:
            return Node(place, self.scan[scanned[0]] * self.direction(scanned[0]), stop)
        lines = [leg for leg in (i - 1, i) if 0 <= leg < len(self.straight) and self.straight[leg]]
        if not 0 < i < len(self.points) - 1 or len(lines) > 1:
            return Node(place, np.zeros(axes), stop)
        if lines:
            return Node(place, np.zeros(axes), self.direction(lines[0])[:, None])
        return Node(place, np.zeros(axes), np.eye(axes), corner)

    def _cut(self, kept: list[int], number: int, reach: float) -> list[Node]:
        """Return the nodes at which the blend around a corner of two lines begins and ends."""
        i = kept[number]
        if not reach or not 0 < number < len(kept) - 1:
            return []
        if self._kind(i - 1) != "straight" or self._kind(i) != "straight":
            return []
        into, out = self.direction(i - 1), self.direction(i)
        if np.abs(into + out).max() <= _PARALLEL:  # straight back: it stops there
            return []
        nodes = []
        for way, other, side in ((into, kept[number - 1], -1.0), (out, kept[number + 1], 1.0)):
            length = float(np.linalg.norm(self.points[other] - self.points[i]))
            off = min(reach, _MOST_OF_A_LINE * length)
            place = self.points[i] + side * off * way
            nodes.append(Node(place, np.zeros(len(way)), way[:, None]))
        return nodes


def _free(limits: tuple[Limits, ...]) -> Leg:
    return Leg("free", np.eye(len(limits)), limits)
