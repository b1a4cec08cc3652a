"""A move planned from quantities with units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

from ..shaping import Limits, Trajectory, bound_for_rise_time, min_time_move
from ..shaping.derivatives import DERIVATIVE_NAMES, derivative_name
from ..shaping.pieces import MAX_MOVE_ORDER
from ..shaping.plain_moves import Method
from ..shaping.told import Told
from .units import (
    DURATION,
    Kind,
    Motion,
    UnitError,
    factor,
    motion_kind,
    parse_motion,
    parse_quantity,
    unit_of,
)

HIGHEST_DERIVATIVE = MAX_MOVE_ORDER
"""Highest derivative that a limit can be given for."""


@dataclass(frozen=True, repr=False)
class Plan(Told):
    """A planned move and the unit to show it in; the trajectory is in rad or m, and seconds.

    Attributes
    ----------
    trajectory : Trajectory
    limits : Limits
    unit : str
    remarks : tuple of str
        What is to be told of it besides its numbers.
    """

    trajectory: Trajectory
    limits: Limits
    unit: str
    remarks: tuple[str, ...] = ()

    @property
    def scale(self) -> float:
        """SI value of one `unit`."""
        return factor(self.unit)


@dataclass(frozen=True)
class Way:
    """Where a move starts and how far it goes, in rad or m, and the unit to show it in."""

    origin: float
    length: float
    motion: Motion
    unit: str


def plan_move(
    distance: str | None,
    bounds: Mapping[int, str],
    *,
    start: str | None = None,
    to: str | None = None,
    position: str | None = None,
    rise_time: str | None = None,
    order: int | None = None,
    method: Method = "optimal",
) -> Plan:
    """Plan the fastest move between rests.

    Parameters
    ----------
    distance : str, optional
        Such as "60 arcsec" or "-2 mm"; its unit is the one that results are shown in.
    bounds : mapping of int to str
        By derivative, 1 velocity, 2 acceleration, …: a quantity, or two separated by a comma
        for the two directions, "-0.1 deg/s^2, 0.2 deg/s^2", one of them zero or not.
    start : str, optional
        Position at the start. Default: zero.
    to : str, optional
        Position at the end, in place of a distance.
    position : str, optional
        Lowest and highest position, separated by a comma: "-4 mm, 4 mm".
    rise_time : str, optional
        Rise time of acceleration, in place of a bound on derivative `order`.
    order : int, optional
        Needed with `rise_time`, 3 or more.
    method : "optimal" or "closed-form", optional
        As in `min_time_move`.

    Raises
    ------
    UnitError
        For text that is not such a quantity; the message names the limit.
    ValueError
        For limits that do not fit together, or a move that cannot be planned.
    """
    route = way(distance, start, to)
    values: dict[int, float | tuple[float, float]] = {
        k: _bound(text, k, route.motion) for k, text in bounds.items()
    }
    if rise_time is not None or order is not None:
        n, bound = _from_rise_time(rise_time, order, values)
        values[n] = bound
    if not values:
        raise ValueError(
            "no limit is given: bound at least one derivative, "
            f"such as --acceleration {motion_kind(route.motion, 2).example!r}"
        )
    highest = max(values)
    limits = Limits.from_bounds(
        (values.get(k, inf) for k in range(1, highest + 1)),
        position=None if position is None else _stops(position, route.motion),
    )
    move = min_time_move(route.length, limits, start=route.origin, method=method)
    return Plan(move, limits, route.unit)


def way(distance: str | None, start: str | None, to: str | None) -> Way:
    """Read the way of a move from its distance, or from the position at its end."""
    if distance is not None and to is not None:
        raise ValueError(f"distance {distance!r} beside --to {to!r}: give one or the other")
    if distance is None and to is None:
        raise ValueError(
            "no distance is given: write one such as '60 arcsec', or where to go, --to '60 arcsec'"
        )
    name, text = ("to", to) if distance is None else ("distance", distance)
    try:
        place, motion = parse_motion(text, 0)
    except UnitError as error:
        raise UnitError(f"{name}: {error}") from None
    origin = 0.0 if start is None else quantity("start", start, motion_kind(motion, 0))
    length = place if distance is not None else place - origin
    return Way(origin, length, motion, unit_of(str(text)))


def derivative_key(text: str) -> int:
    """Return the number of a derivative given by number or name, 1 to HIGHEST_DERIVATIVE."""
    name = text.strip().lower()
    if name in DERIVATIVE_NAMES[1:]:
        return DERIVATIVE_NAMES.index(name)
    if name.isdecimal() and 1 <= int(name) <= HIGHEST_DERIVATIVE:
        return int(name)
    raise ValueError(
        f"unknown derivative {text!r}: expected a number from 1 to {HIGHEST_DERIVATIVE} or one "
        f"of {', '.join(DERIVATIVE_NAMES[1:])}"
    )


def _bound(text: str, k: int, motion: Motion) -> float | tuple[float, float]:
    name = f"{derivative_name(k)} limit"
    sides = text.split(",")
    if len(sides) == 1:
        return quantity(name, text, motion_kind(motion, k, positive=True))
    kind = motion_kind(motion, k)
    if len(sides) == 2:
        lower, upper = (quantity(name, side, kind) for side in sides)
        if lower <= 0.0 <= upper and lower < upper:
            return lower, upper
    raise UnitError(
        f"{name}: {text!r} is not a pair around zero; write one quantity such as "
        f"{kind.example!r}, or lower and upper bound as '-{kind.example}, {kind.example}'"
    )


def _stops(text: str, motion: Motion) -> tuple[float, float]:
    """Return the lowest and the highest position."""
    kind, sides = motion_kind(motion, 0), text.split(",")
    if len(sides) == 2:
        lower, upper = (quantity("position limit", side, kind) for side in sides)
        if lower < upper:
            return lower, upper
    raise UnitError(
        f"position limit: {text!r} is not a pair of positions; write the lowest and the highest "
        f"as '-{kind.example}, {kind.example}'"
    )


def _from_rise_time(
    rise_time: str | None, order: int | None, values: Mapping[int, float | tuple[float, float]]
) -> tuple[int, float]:
    """Return the derivative to be bounded and its bound, from acceleration and rise time."""
    acceleration = values.get(2)
    if rise_time is None or order is None or not isinstance(acceleration, float):
        raise ValueError(
            "a rise time needs the order of the derivative to be bounded and one acceleration "
            "limit: give acceleration, rise time and order together"
        )
    if order < 3:
        raise ValueError(
            f"order = {order}: a rise time of the acceleration bounds derivative 3 (jerk) or more"
        )
    if order in values:
        raise ValueError(
            f"the {derivative_name(order)} limit is given twice, directly and by the rise time: "
            "leave one out"
        )
    time = quantity("rise time", rise_time, DURATION)
    return order, bound_for_rise_time(acceleration, time, order)


def quantity(name: str, text: str, kind: Kind) -> float:
    """Read a quantity, errors headed by the name of what was read."""
    try:
        return parse_quantity(text, kind)
    except UnitError as error:
        raise UnitError(f"{name}: {error}") from None
