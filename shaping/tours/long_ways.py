"""Legs much longer than the ramps at their ends, cut for the programs that time them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from .averages import widths
from .legs import States
from .route import Leg, Node

_LONG = 8.0  # times the ramps of a leg: what is left of it


def ramp_time(limits: Limits) -> float:
    """Return about the time from rest onto the velocity bound; infinite where there is none."""
    sides = [min(-low, high) for low, high in zip(limits.lower, limits.upper, strict=True)]
    span = max(-limits.lower[0], limits.upper[0])
    if not (np.isfinite(span) and min(sides[1:]) > 0.0):
        return np.inf
    return sum(widths(span, sides[1:]))


def cut(
    nodes: Sequence[Node], legs: Sequence[Leg], durations: Sequence[float]
) -> tuple[list[Node], list[float]]:
    """Return nodes with long legs between them shortened, and the durations that are left.

    States at nodes that are passed hardly depend on how long axes cruise between them.
    """
    lasts = np.array(durations)
    shares = np.minimum(_LONG * _ramps(legs) / lasts, 1.0)
    shares[[leg.kind == "scan" for leg in legs]] = 1.0
    places = np.array([node.place for node in nodes])
    ways = np.diff(places, axis=0) * shares[:, None]
    ends = np.vstack([places[:1], places[0] + np.cumsum(ways, axis=0)])
    moved = [replace(node, place=place) for node, place in zip(nodes, ends, strict=True)]
    return moved, (lasts * shares).tolist()


def longest(legs: Sequence[Leg], durations: Sequence[float]) -> float:
    """Return how many times its ramps the longest leg takes."""
    return float((np.array(durations) / _ramps(legs)).max())


def _ramps(legs: Sequence[Leg]) -> FloatArray:
    return np.array([max(ramp_time(one) for one in leg.limits) for leg in legs])


def put_back(states: States, cut_nodes: Sequence[Node], nodes: Sequence[Node]) -> States:
    """Return states at nodes that were moved where they were."""
    off: list[FloatArray] = [a.place - b.place for a, b in zip(nodes, cut_nodes, strict=True)]
    moved = [state.copy() for state in states]
    for state, way in zip(moved, off, strict=True):
        state[0] += way
    return moved
