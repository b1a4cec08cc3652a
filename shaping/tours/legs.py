"""The legs of a route, planned exactly between states of motion at their ends."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..limits import Limits
from ..pieces import FloatArray
from ..scans import change_of_velocity
from ..trajectory import Motion, Trajectory, as_trajectory
from ..transfers.axes import planned_motion
from ..transfers.infeasible import InfeasibleError
from ..transfers.problem import Transfer
from ..transfers.synchronize import synchronize
from .route import Leg, Node, reach_along

_ROUNDING = 1e-12

States = list[FloatArray]
"""Of every node the position and its derivatives, (order, axes)."""


@dataclass(frozen=True)
class PlannedLegs:
    """Legs planned one after the other: of each the duration, and the motions of all axes."""

    durations: tuple[float, ...]
    motions: tuple[tuple[Motion, ...], ...]

    @property
    def duration(self) -> float:
        """Of all together."""
        return sum(self.durations)

    @classmethod
    def joined(cls, parts: Sequence[PlannedLegs]) -> PlannedLegs:
        """Return all legs in a row."""
        return cls(
            tuple(lasts for part in parts for lasts in part.durations),
            tuple(leg for part in parts for leg in part.motions),
        )


def at_rest(nodes: Sequence[Node], order: int) -> States:
    """Return the states of nodes at which nothing moves that is free to."""
    states = []
    for node in nodes:
        state = np.zeros((order, len(node.place)))
        state[0], state[1] = node.place, node.velocity
        states.append(state)
    return states


def planned(
    legs: Sequence[Leg], states: Sequence[FloatArray], limits: Sequence[Limits]
) -> PlannedLegs:
    """Return the fastest motions over legs with these states at their nodes.

    Raises
    ------
    ValueError
        For states between which a leg has no motion within its bounds.
    """
    with warnings.catch_warnings():  # of how near a leg is to its minimum: the whole has no proof
        warnings.filterwarnings("ignore", "this motion takes at most|nothing is proven")
        motions = tuple(_told(leg, states[i], states[i + 1], limits) for i, leg in enumerate(legs))
    return PlannedLegs(tuple(max(m.duration for m in leg) for leg in motions), motions)


def _told(
    leg: Leg, start: FloatArray, end: FloatArray, limits: Sequence[Limits]
) -> tuple[Motion, ...]:
    """Return the motions over a leg; errors tell where it leads."""
    try:
        return _leg(leg, start, end, limits)
    except InfeasibleError as error:
        way = f"from point {start[0].tolist()} to {end[0].tolist()}, "
        raise error.headed(way) from error


def _leg(
    leg: Leg, start: FloatArray, end: FloatArray, limits: Sequence[Limits]
) -> tuple[Motion, ...]:
    if leg.kind == "scan":
        return _scan(leg, start, end, limits)
    if leg.kind == "straight":
        return _line(leg, start, end, limits)
    given = [
        (start[: one.order, k].tolist(), end[: one.order, k].tolist(), one)
        for k, one in enumerate(limits)
    ]
    together = synchronize(given)
    for motion in together:
        _check_inside(motion)
    return tuple(together)


def _line(
    leg: Leg, start: FloatArray, end: FloatArray, each: Sequence[Limits]
) -> tuple[Motion, ...]:
    """Return one motion along the line, scaled to the axes."""
    way, [limits] = leg.way[:, 0], leg.limits
    begin, finish = way @ start.T, way @ end.T
    begin[0], finish[0] = 0.0, np.linalg.norm(end[0] - start[0])
    n = limits.order
    ends = begin[:n].tolist(), finish[:n].tolist()
    along = planned_motion("the line", *ends, limits)
    room = reach_along(way, start[0], each)
    if along.extremes(0)[0] < room[0] or along.extremes(0)[1] > room[1]:
        pairs = zip(limits.lower, limits.upper, strict=True)
        along = planned_motion("the line", *ends, Limits.from_bounds(pairs, position=room))
    _check_inside(along)
    return on_line(as_trajectory(along), way, start[0])


def _scan(
    leg: Leg, start: FloatArray, end: FloatArray, limits: Sequence[Limits]
) -> tuple[Motion, ...]:
    duration = float(np.linalg.norm(end[0] - start[0])) / leg.speed
    motions = []
    for k, one in enumerate(limits):
        rates = [start[1, k], *[0.0] * (one.order - 1)]
        after = [end[0, k], *rates]
        motions.append(Trajectory([0.0, duration], [[start[0, k], *rates]], end_state=after))
    return tuple(motions)


def run_up(leg: Leg, place: FloatArray, limits: Sequence[Limits]) -> tuple[Motion, ...]:
    """Return the motions from rest to the velocity of a scan, which end at its first place."""
    change = change_of_velocity(0.0, leg.speed, leg.limits[0])
    motions = on_line(change.shift(-float(change.end_state[0])), leg.way[:, 0], place)
    return _within_stops("run-up to", motions, place, limits)


def run_out(leg: Leg, place: FloatArray, limits: Sequence[Limits]) -> tuple[Motion, ...]:
    """Return the motions from the velocity of a scan to rest, which begin at its last place."""
    change = change_of_velocity(leg.speed, 0.0, leg.limits[0])
    motions = on_line(change, leg.way[:, 0], place)
    return _within_stops("run-out of", motions, place, limits)


def _within_stops(
    what: str, motions: tuple[Motion, ...], place: FloatArray, limits: Sequence[Limits]
) -> tuple[Motion, ...]:
    """Refuse the way into or out of a scan beyond the bounds on position."""
    for k, (motion, one) in enumerate(zip(motions, limits, strict=True)):
        low, high = one.position
        ends = motion.extremes(0)
        over = max(ends[1] - high, 0.0) + min(ends[0] - low, 0.0)
        if abs(over) > _ROUNDING * max(map(abs, ends)):
            nearest = float(place[k]) - over
            raise InfeasibleError(
                f"the {what} the scan takes axis {k} to {ends[over > 0.0]!r}, outside its position "
                f"bounds ({low:g}, {high:g}): scan more slowly, or not nearer to it than "
                f"{nearest!r}",
                "position",
                nearest,
            )
    return motions


def on_line(along: Trajectory, way: FloatArray, place: FloatArray) -> tuple[Motion, ...]:
    """Return the motions of the axes, of one along a line that starts at a place."""
    pairs = zip(way.tolist(), place.tolist(), strict=True)
    return tuple(along.scale(share).shift(x) for share, x in pairs)


def _check_inside(motion: Motion) -> None:
    """Refuse a motion that begins outside its bounds."""
    if isinstance(motion, Transfer) and motion.inside_after:
        raise ValueError(f"{motion!r} begins outside its bounds")
