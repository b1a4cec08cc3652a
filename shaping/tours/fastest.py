"""The fastest motion over a route that is found, and the one over a course."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..endings import ended
from ..limits import Limits
from ..optimal.whole.warm_program import Effort
from ..pieces import FloatArray
from ..trajectory import Motion, Trajectory, as_trajectory
from .course import Course
from .legs import PlannedLegs, at_rest, planned, run_out, run_up
from .nearest import approaches
from .route import Route
from .stretches import Between

_REACHES = (1.0, 0.7, 0.4, 0.2)  # shares of the tolerance from which corners are cut
_ROUNDING = 1e-9


class Found(NamedTuple):
    """The motions of all axes from time 0 on; when nodes, and points of the course, are passed."""

    axes: list[Trajectory]
    node_times: FloatArray
    times: FloatArray


def fastest_over(course: Course, corner: float) -> Found:
    """Return the fastest motion over a course that is found, at the slowest with stops."""
    uncut, effort = course.route(corner, 0.0), Effort()
    best = _joined(course, uncut, _fastest(uncut, course.limits, corner, effort))
    for reach in _REACHES if corner else ():
        route = course.route(corner, corner * reach)
        if not route.blends:
            break
        legs = _fastest(route, course.limits, corner, effort)
        found = _joined(course, route, legs)
        if _near(found, route, corner):
            return min(best, found, key=lambda each: each.axes[0].end_time)
    return best


def _fastest(
    route: Route, limits: tuple[Limits, ...], corner: float, effort: Effort
) -> PlannedLegs:
    """Return the legs planned as fast as is found, each stretch between fixed nodes for itself."""
    states = at_rest(route.nodes, max(one.order for one in limits))
    parts: list[PlannedLegs] = []
    at = 0
    for first, last in [*route.stretches(), (len(route.legs), len(route.legs))]:
        parts.append(planned(route.legs[at:first], states[at : first + 1], limits))
        if first < last:
            nodes, ways = route.nodes[first : last + 1], route.legs[first:last]
            blends = {leg - first: (x, corner) for x, leg in route.blends if first <= leg < last}
            stretch = Between(nodes, ways, states[first], states[last], blends, effort)
            parts.append(stretch.fastest(limits))
        at = last
    return PlannedLegs.joined(parts)


def _joined(course: Course, route: Route, legs: PlannedLegs) -> Found:
    """Return the legs one after the other, with the ways into a first and out of a last scan."""
    durations, motions = list(legs.durations), list(legs.motions)
    begins = route.legs[0].kind == "scan"
    if begins:
        motions.insert(0, run_up(route.legs[0], route.nodes[0].place, course.limits))
        durations.insert(0, motions[0][0].duration)
    if route.legs[-1].kind == "scan":
        motions.append(run_out(route.legs[-1], route.nodes[-1].place, course.limits))
        durations.append(motions[-1][0].duration)
    times = np.concatenate([[0.0], np.cumsum(durations)])
    axes = [_in_a_row([leg[k] for leg in motions], times) for k in range(len(course.limits))]
    if route.legs[-1].kind != "scan":
        axes = [ended(one, (x,)) for one, x in zip(axes, route.nodes[-1].place, strict=True)]
    at_nodes = times[int(begins) :][: len(route.nodes)]
    return Found(axes, at_nodes, _passed(course, route, axes, at_nodes))


def _in_a_row(motions: Sequence[Motion], times: FloatArray) -> Trajectory:
    """Return the motions of one axis one after the other, which begin at these times."""
    parts = [as_trajectory(motion) for motion in motions]
    n = max(part.order for part in parts)
    breaks = [begin + part.breaks[:-1] for part, begin in zip(parts, times, strict=False)]
    states = [np.pad(part.states, ((0, 0), (0, n - part.order))) for part in parts]
    end = np.pad(parts[-1].end_state, (0, n - parts[-1].order))
    return Trajectory.from_arrays(
        np.concatenate([*breaks, times[-1:]]),
        np.vstack(states),
        np.concatenate([part.durations for part in parts]),
        end,
    )


def _passed(
    course: Course, route: Route, axes: Sequence[Trajectory], at_nodes: FloatArray
) -> FloatArray:
    """Return when each point of the course is passed: first, where it lies on a line."""
    times = np.empty(len(course.points))
    size = np.abs(np.diff(course.points, axis=0)).max()
    for i, (first, last) in enumerate(route.windows):
        times[i] = at_nodes[first]
        if last > first:
            when, far = approaches(axes, course.points[i], at_nodes[first], at_nodes[last])
            times[i] = when[np.argmax(far <= far.min() + _ROUNDING * size)]
    return times


def _near(found: Found, route: Route, corner: float) -> bool:
    """Tell whether the blends stay within the distance of their corners."""
    for place, leg in route.blends:
        _, far = approaches(found.axes, place, *found.node_times[leg : leg + 2])
        if far.max() > corner * (1.0 + _ROUNDING):
            return False
    return True
