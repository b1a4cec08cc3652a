"""A route: the nodes at which its legs meet, and what is free there."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Literal

from ..limits import Limits
from ..pieces import FloatArray


@dataclass(frozen=True, eq=False)
class Node:
    """A place where two legs meet.

    Attributes
    ----------
    place, velocity : (axes,) arrays
        Where it is, and the velocity that is fixed.
    ways : (axes, r) array
        Directions in which the velocity and all higher derivatives are free; none at a stop.
    tolerance : float
        How far from its place it may be passed.
    """

    place: FloatArray
    velocity: FloatArray
    ways: FloatArray
    tolerance: float = 0.0


@dataclass(frozen=True, eq=False)
class Leg:
    """The way from a node to the next: on a line as one motion, otherwise every axis for itself.

    Attributes
    ----------
    kind : "free", "straight" or "scan"
    way : (axes, k) array
        A column for every motion: the line's direction, or those of the axes.
    limits : tuple of Limits
        Of every motion.
    speed : float
        Of a scan.
    """

    kind: Literal["free", "straight", "scan"]
    way: FloatArray
    limits: tuple[Limits, ...]
    speed: float = 0.0


@dataclass(frozen=True, eq=False)
class Route:
    """Nodes (J + 1), legs (J), and of every point the first and last node between which it lies.

    `blends` are the points that are cut, with the number of the leg that does so.
    """

    nodes: tuple[Node, ...]
    legs: tuple[Leg, ...]
    windows: tuple[tuple[int, int], ...]
    blends: tuple[tuple[FloatArray, int], ...] = ()

    def stretches(self) -> list[tuple[int, int]]:
        """Return the first and last node of each part with something free between them.

        Or where an end moves that is not one of a scan between them.
        """
        fixed = [i for i, node in enumerate(self.nodes) if not node.ways.size]
        return [
            (i, j)
            for i, j in itertools.pairwise(fixed)
            if j > i + 1 or (self.legs[i].kind == "free" and self._move(i, j))
        ]

    def _move(self, *nodes: int) -> bool:
        return any(self.nodes[i].velocity.any() for i in nodes)


def reach_along(
    way: FloatArray, place: FloatArray, limits: Sequence[Limits]
) -> tuple[float, float]:
    """Return how far back and ahead along a way from a place positions are free."""
    low, high = -inf, inf
    for share, x, one in zip(way.tolist(), place.tolist(), limits, strict=True):
        if share:
            back, ahead = sorted((side - x) / share for side in one.position)
            low, high = max(low, back), min(high, ahead)
    return low, high
