"""Motions through several points, which are passed without stopping."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import positive, whole
from ..limits import Limits, of_one
from ..optimal.whole.outcome import check_whole
from ..passage import Passage, Tour
from ..pieces import FloatArray
from ..real_numbers import real_number, shown
from ..trajectory import Trajectory, point
from ..trajectory_checks import finite_numbers
from ..transfers.infeasible import InfeasibleError
from ..transfers.synchronized import Synchronized
from .course import Course
from .fastest import fastest_over

_SAME = 1e-9  # relative difference of two velocities that is rounding


def through(
    points: ArrayLike,
    limits: Limits | Sequence[Limits],
    *,
    corner: float = 0.0,
    straight: bool | Sequence[bool] = False,
    scan: Mapping[int, float] | None = None,
) -> Synchronized | Tour:
    """Return a motion from rest to rest through points, the soonest that is found.

    Parameters
    ----------
    points : (m,) or (m, axes) array
        Of one axis, or a row for each point; at least two. Points that follow one another at the
        same place are one.
    limits : Limits or sequence of Limits
        Of order 2 to 10, for all axes or one per axis; positions bounded or not, bounds absent or
        zero on a side.
    corner : float, optional
        How far from a point, by Euclidean distance, the motion may pass. 0 is exactly through.
        The first and the last point are always met.
    straight : bool or sequence of bool, optional
        Whether the axes move on the straight lines between the points, for all of the m − 1 legs
        or for each. They stop where lines meet at an angle; with a `corner` they leave the line
        for a blend within that distance of the point (and along a third of a line at most).
        A point at which one line and another leg meet is met exactly.
    scan : mapping of int to float, optional
        Legs that are run on the straight line at constant speed (that along the line), by their
        number from 0 on: {1: 0.2}. Both of its points are met. Where the first leg is one, the
        motion begins with the run-up to it from rest; where the last is, it ends with the run-out.

    Returns
    -------
    Synchronized or Tour
        Of several axes a tuple of trajectories, as `synchronize` returns, in step at all points;
        of points (m,) one motion. `.times` tells when each point is passed.

    Raises
    ------
    InfeasibleError
        For points, or a way into or out of a scan, outside bounds on position; or where a bound
        that is zero on a side leaves no motion.
    ValueError
        For less than two points, numbers that are not finite, limits of another number or order,
        a negative corner, or legs of constant speed that are too fast or do not fit together.

    Notes
    -----
    All derivatives below the highest at the points, and how far off it they are passed, come from
    a sequence of linear programs over all axes, durations and states at once. Where all axes are
    of order 2 and 3, positions free and no bound zero on a side, every leg between them is then
    planned exactly, as `synchronize` does; states come from shorter legs where these are much
    longer than their ramps. From order 4 on the motion of order 3 (2 where jerk is free) is run
    through moving averages, its places moved so that the averages pass the points, which takes
    their widths longer, 2·jerk/snap and so on, once for all points between two stops. Where that
    is more than 0.3 %, and where averages break a bound on position or leave a line, the programs'
    own motions are tried, on meshes refined where inputs switch, those of axes with time to spare
    with the smallest share of the highest bound. All derivatives below the highest are
    continuous, end states exact.

    All bounds hold, and it is never slower than a stop at each point. What is found is a local
    optimum up to the mesh of the programs, without a proof: on random problems of order 3 a finer
    mesh was sooner by 0.06 % (median; 0.3 % at the worst), the best of twelve other starts by 0.1 %
    at the worst. One axis of order 2 or 3 is exact where its points are in order: the transfer from
    the first to the last. Ten points on three axes take 0.3 s at order 3, two seconds at order 4,
    five at order 5; less where snap is high. Legs that take more than about 25 times their ramps
    are passed with stops where averages do not do: at points next to bounds on position (0.4 to
    0.7 % longer in total), with a bound of zero on a side, and where a line meets another leg.

    Examples
    --------
    >>> limits = Limits(velocity=1.0, acceleration=2.0, jerk=10.0)
    >>> x, y = path = through([(0.0, 0.0), (1.0, 0.2), (1.0, 1.0)], limits, corner=0.05)
    >>> stops = through([(0.0, 0.0), (1.0, 0.2), (1.0, 1.0)], limits, straight=True)
    >>> bool(path.duration < 0.85 * stops.duration)
    True
    >>> wafer = through([0.0, 0.3], limits, scan={0: 0.2})
    >>> [round(time, 6) for time in wafer.times.tolist()]
    [0.282843, 1.782843]
    """
    rows = finite_numbers("points", points)
    if rows.ndim not in (1, 2) or len(rows) < 2 or not rows.size:
        raise ValueError(
            f"points of shape {rows.shape}: expected (m,) or (m, axes), two points at least"
        )
    single, rows = rows.ndim == 1, rows.reshape(len(rows), -1)
    each = _limits(limits, rows.shape[1])
    distance = real_number("corner", corner)
    if not 0.0 <= distance < np.inf:
        raise ValueError(f"corner = {corner!r}: expected a finite distance, 0 or more")
    lines = _straight(straight, len(rows) - 1)
    scans = _scans(scan, rows)
    _check_positions(rows, each)
    axes, times = _passing(rows, each, distance, lines, scans)
    passage = Passage(rows.copy(), times, distance)
    if single:
        return Tour(axes[0], passage)
    return Synchronized.of(axes, "both", each, passage=passage)


def _passing(
    points: FloatArray,
    limits: tuple[Limits, ...],
    corner: float,
    straight: list[bool],
    scan: dict[int, float],
) -> tuple[list[Trajectory], FloatArray]:
    """Return the motions of the axes, and when each point is passed."""
    moves = np.any(np.diff(points, axis=0) != 0.0, axis=1)
    if not moves.any():
        axes = [point(x, one.order) for x, one in zip(points[0].tolist(), limits, strict=True)]
        return axes, np.zeros(len(points))
    legs = np.flatnonzero(moves).tolist()
    course = Course(
        points[[0, *(leg + 1 for leg in legs)]],
        limits,
        tuple(straight[leg] and points.shape[1] > 1 for leg in legs),
        {number: scan[leg] for number, leg in enumerate(legs) if leg in scan},
    )
    _check_scans(course, legs)
    found = fastest_over(course, corner)
    return found.axes, found.times[np.concatenate([[0], np.cumsum(moves)])]


def _limits(given: Any, axes: int) -> tuple[Limits, ...]:
    """Return the limits of every axis."""
    if not isinstance(given, list | tuple):
        check_whole(of_one(given))
        return (given,) * axes
    listed = tuple(given)
    if len(listed) != axes:
        raise ValueError(
            f"limits = {shown(given)}: expected one for all axes, or {axes}, one per axis, not "
            f"{len(listed)}"
        )
    for one in listed:
        check_whole(of_one(one))
    return listed


def _check_positions(points: FloatArray, limits: tuple[Limits, ...]) -> None:
    """Refuse points outside the bounds on position."""
    for k, one in enumerate(limits):
        low, high = one.position
        outside = np.flatnonzero((points[:, k] < low) | (points[:, k] > high))
        for i in outside[:1].tolist():
            nearest = min(max(float(points[i, k]), low), high)
            raise InfeasibleError(
                f"points[{i}, {k}] = {float(points[i, k])!r} is outside the position bounds "
                f"({low:g}, {high:g}) of axis {k}: the nearest that can be is {nearest!r}",
                "position",
                nearest,
            )


def _straight(given: Any, legs: int) -> list[bool]:
    """Return of every leg whether it is a line."""
    listed = [given] * legs if isinstance(given, bool | np.bool_) else given
    if isinstance(listed, str | Mapping) or not isinstance(listed, Iterable):
        raise TypeError(f"straight = {shown(given)}: expected True, False, or one for each leg")
    listed = list(listed)
    if not all(isinstance(one, bool | np.bool_) for one in listed):
        raise TypeError(f"straight = {shown(given)}: expected True, False, or one for each leg")
    if len(listed) != legs:
        raise ValueError(
            f"straight = {shown(given)}: expected {legs} entries, one for each leg, not "
            f"{len(listed)}"
        )
    return [bool(one) for one in listed]


def _scans(given: Any, points: FloatArray) -> dict[int, float]:
    """Return the speeds of legs by their numbers."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(
            f"scan = {shown(given)}: expected speeds of legs by number, such as {{1: 0.2}}"
        )
    scans = {}
    for key, value in given.items():
        leg = whole("number of a leg in scan", key, 0, len(points) - 2)
        scans[leg] = positive(f"scan speed of leg {leg}", value)
        if not np.any(points[leg] != points[leg + 1]):
            raise ValueError(
                f"scan = {shown(given)}: leg {leg} has no length, as its points are the same"
            )
    return scans


def _check_scans(course: Course, names: list[int]) -> None:
    """Refuse scans beyond their bounds, and legs beside them that go another way or speed."""
    for leg, speed in course.scan.items():
        way = course.direction(leg)
        most = course.line(way).bounds(1)[1]
        if speed > most:
            raise ValueError(
                f"scan speed of leg {names[leg]} = {speed!r}: expected at most {most!r}, which the "
                "velocity bounds allow along it; scan more slowly, or raise them"
            )
        for other in (leg - 1, leg + 1):
            if not 0 <= other < len(names) or not (other in course.scan or course.straight[other]):
                continue
            same = course.direction(other) * course.scan.get(other, speed)
            if np.abs(same - speed * way).max() > _SAME * speed:
                raise ValueError(
                    f"legs {names[leg]} and {names[other]} meet at constant speed, but go another "
                    "way or speed: put a leg that is neither straight nor a scan between them"
                )
