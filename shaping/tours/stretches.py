"""The fastest legs that are found between two nodes at which all is fixed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

from ..limits import Limits
from ..optimal.whole.warm_program import Effort
from ..pieces import FloatArray
from .legs import PlannedLegs, States, at_rest, planned
from .long_ways import cut, longest, put_back
from .program import approximations, stretched
from .route import Leg, Node
from .settled import settled
from .smoothed import Averaging, smoothed

_FAR = 25.0  # times its ramps: a leg too long for programs over all of it
_LONG = 8.0  # the same of a single leg, which a search over all of it may not find
_HARDLY = 3e-3  # of the duration: what programs may gain that are not tried


@dataclass(frozen=True, eq=False)
class Between:
    """A stretch of a route.

    Attributes
    ----------
    nodes, legs : sequence of Node, Leg
    start, end : (order, axes) arrays
        States at its ends.
    blends : mapping of int to (place, corner)
        Of the legs around corners by their numbers, the corner and how far they may be from it.
    effort : Effort
        What programs may take.
    """

    nodes: Sequence[Node]
    legs: Sequence[Leg]
    start: FloatArray
    end: FloatArray
    blends: Mapping[int, tuple[FloatArray, float]]
    effort: Effort

    def fastest(self, limits: Sequence[Limits]) -> PlannedLegs:
        """Return the fastest legs found, at the slowest those with stops."""
        if all(one.order <= 3 and one.plain for one in limits):
            return self._exactly(limits).best
        by = Averaging.to(limits)
        if by is None:
            return self._by_stops(limits, [])
        before = replace(self, legs=by.before(self.legs))
        exact = before._exactly(by.limits)
        smooth = None
        if all(one.plain for one in by.limits):  # others are not exact: averages are not led back
            smooth = smoothed(before.legs, exact.states, limits, by, self.blends)
        long = longest(before.legs, exact.best.durations) > _LONG
        near = smooth is not None and smooth.duration <= exact.enough
        if smooth is not None and near and (long or len(self.legs) > 1):
            return smooth
        share = 1.0 + by.longer / exact.best.duration
        about = [lasts * share for lasts in exact.best.durations]
        found = [each for each in (smooth, self._settled(limits, about)) if each is not None]
        best = min(found, key=_duration, default=None)
        if best is not None and best.duration <= exact.stopping and len(self.legs) > 1:
            return best
        return self._by_stops(limits, found)

    def _by_stops(self, limits: Sequence[Limits], found: list[PlannedLegs]) -> PlannedLegs:
        """Return the fastest legs of those found, those with stops, and what starts from these."""
        try:
            stops = planned(self.legs, self._stops, limits)
        except ValueError:  # not found, between moving states
            if not found:
                raise
            return min(found, key=_duration)
        best = min([stops, *found], key=_duration)
        further = self._settled(limits, stops.durations) if best is stops else None
        return min(best, further or best, key=_duration)

    def _settled(self, limits: Sequence[Limits], durations: Sequence[float]) -> PlannedLegs | None:
        """Return the legs of the programs alone, from durations near the right ones, or None."""
        if len(self.legs) == 1 or longest(self.legs, durations) > _FAR:
            return None
        stretch = stretched(self.nodes, self.legs, limits, durations, effort=self.effort)
        return settled(stretch, durations, self.start, self.end)

    def _exactly(self, limits: Sequence[Limits]) -> _Exact:
        """Return the fastest legs planned exactly at orders 2 and 3, and the states between."""
        states = self._stops
        best = stops = planned(self.legs, states, limits)
        nodes, durations = cut(self.nodes, self.legs, best.durations)
        stretch = stretched(nodes, self.legs, limits, durations, effort=self.effort)
        for found in approximations(stretch, durations):
            found = self._with_ends(put_back(found, nodes, self.nodes))
            try:
                legs = planned(self.legs, found, limits)
            except ValueError:  # rounding has left the bounds, or no common duration
                continue
            if legs.duration < best.duration:
                best, states = legs, found
        return _Exact(best, states, stops.duration if len(self.legs) > 1 else inf)

    def _with_ends(self, states: States) -> States:
        return [self.start, *states[1:-1], self.end]

    @property
    def _stops(self) -> States:
        """States at the nodes with nothing in motion that is free to."""
        return [self.start, *at_rest(self.nodes[1:-1], len(self.start)), self.end]


@dataclass(frozen=True, eq=False)
class _Exact:
    """The fastest legs, the states at their nodes, and how long they take with stops, if any."""

    best: PlannedLegs
    states: States
    stopping: float

    @property
    def enough(self) -> float:
        """Duration at a higher order: below any with stops, with next to nothing to gain."""
        return min(self.best.duration * (1.0 + _HARDLY), self.stopping)


def _duration(legs: PlannedLegs) -> float:
    return legs.duration
