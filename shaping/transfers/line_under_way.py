"""The straight line that several axes are on, and new ends for them under way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from ..limits import Limits, check_plain, of_one
from ..real_numbers import shown
from ..trajectory import Motion, Trajectory
from .axes import Pair, Planned
from .problem import Problem
from .s_curve import SCurveMove, s_curve_from
from .s_curve_rates import Moment, Rates
from .s_curve_settings import SCurveSettings
from .straight_line import ALIKE, tightest
from .transfer import min_time_transfer
from .under_way import before, spliced
from .velocity_move import stop_from

RATES = (
    "velocity",
    "acceleration",
    "deceleration",
    "acceleration_jerk",
    "deceleration_jerk",
)
Places = Sequence[float]
Ends = Sequence[tuple[float, ...]]


@dataclass(frozen=True)
class Leg:
    """A straight line x = origin + direction·s from a time on; the direction is of length 1."""

    since: float
    origin: tuple[float, ...]
    direction: tuple[float, ...]

    def shares(self, motion: Trajectory, places: Places) -> list[Trajectory]:
        """Return what each axis does of a motion along the line that begins at given places."""
        from_zero = motion.shift(-float(motion.start_state[0]))
        return [
            from_zero.scale(share).shift(place)
            for share, place in zip(self.direction, places, strict=True)
        ]

    def along(self, states: Ends) -> list[float] | None:
        """Return position, velocity and acceleration along the line, None for a state off it."""
        rows = [[s[k] if k < len(s) else 0.0 for s in states] for k in range(3)]
        rows[0] = [x - o for x, o in zip(rows[0], self.origin, strict=True)]
        found = []
        for values in rows:
            share = sum(u * value for u, value in zip(self.direction, values, strict=True))
            off = hypot(*(v - share * u for u, v in zip(self.direction, values, strict=True)))
            if off > ALIKE * hypot(*values):
                return None
            found.append(share)
        return found


@dataclass(frozen=True)
class Line:
    """The straight lines that axes go along, one after the other, and the motion s(t) along them.

    Attributes
    ----------
    legs : tuple of Leg
        The axes are at rest where one follows another. None before they first move.
    path : Trajectory
    planned : Limits or SCurveSettings, optional
        What the resultant was planned with, where it has bounds of its own.
    """

    legs: tuple[Leg, ...]
    path: Trajectory
    planned: Planned = None

    @classmethod
    def of(
        cls,
        motions: Sequence[Motion],
        path: Trajectory | None,
        resultant: Limits | Motion | None,
    ) -> Line:
        """Return the line that motions go along, from the start of their path at 0, if any."""
        starts = [float(axis.start_state[0]) for axis in motions]
        ends = [float(axis.end_state[0]) for axis in motions]
        own: Planned = resultant if isinstance(resultant, Limits) else None
        if isinstance(resultant, SCurveMove):
            own = resultant.settings
        if path is None:
            return cls.at_rest(motions[0].start_time, own)
        leg = Leg(path.start_time, tuple(starts), _towards(starts, ends))
        return cls((leg,), path, own)

    @classmethod
    def at_rest(cls, time: float, planned: Planned) -> Line:
        """Return no leg yet, and what the resultant is to be planned with."""
        return cls((), Trajectory([time], np.empty((0, 2)), end_state=[0.0, 0.0]), planned)

    def until(self, time: float) -> Line:
        """Return the line up to a time."""
        begun = [leg for leg in self.legs if leg.since <= time]
        return replace(self, legs=tuple(begun or self.legs[:1]), path=before(self.path, time))

    def then(self, plan: Trajectory) -> Line:
        """Return the line with a motion along its last leg behind its path."""
        return replace(self, path=spliced(self.path, plan))


def line_from(
    been: Sequence[Motion],
    line: Line | None,
    ends: Ends,
    planned: Sequence[Planned],
    resultant: Limits | Mapping[str, float] | None,
    *,
    stays: bool,
) -> tuple[list[Motion], Line | None]:
    """Return the motions of axes that go on along their line, or stop and take another.

    Parameters
    ----------
    been : sequence of Trajectory
        The motions up to now.
    line : Line, optional
    ends : sequence of states
    planned : sequence of Limits, SCurveSettings or None
        What each axis is planned with.
    resultant : Limits or rates, optional
        New bounds or rates of the motion along the line.
    stays : bool
        Whether the ends are the old ones.
    """
    for one in planned:
        if isinstance(one, Limits):
            check_plain(one)
    own = _resultant(line, resultant)
    time, places = been[0].end_time, [float(axis.end_state[0]) for axis in been]
    past = None if line is None else replace(line.until(time), planned=own)
    if past is None or line is None or not past.path.end_state[1:-1].any():
        if any(axis.end_state[1:-1].any() for axis in been):
            raise ValueError(
                "the axes move and are on no straight line: use mode='both', or wait for rest"
            )
        return _anew(been, past, ends, planned, own)
    state = (*past.path.end_state[:3].tolist(), 0.0)[:3]
    leg = past.legs[-1]
    goal = leg.along(ends)
    if stays and len(past.legs) == len(line.legs):
        goal = line.path.end_state[:3].tolist()
    if goal is not None:
        plan = _onward(state, goal, leg, planned, own)
        return _joined(been, leg.shares(plan, places)), past.then(plan)
    stop = _stop(state, leg, planned, own)
    stopped = _joined(been, leg.shares(stop, places))
    return _anew(stopped, past.then(stop), ends, planned, own)


def _anew(
    been: Sequence[Motion],
    line: Line | None,
    ends: Ends,
    planned: Sequence[Planned],
    own: Planned,
) -> tuple[list[Motion], Line | None]:
    """Return the motions of axes at rest along a line of their own."""
    time, places = been[0].end_time, [float(axis.end_state[0]) for axis in been]
    direction = _towards(places, [end[0] for end in ends])
    line = line or Line.at_rest(time, own)
    if not any(direction):
        return list(been), line
    s = float(line.path.end_state[0])
    leg = Leg(time, tuple(x - u * s for x, u in zip(places, direction, strict=True)), direction)
    goal = leg.along(ends)
    if goal is None:
        raise ValueError(
            f"targets = {shown([list(end) for end in ends])}: a velocity or acceleration leads off "
            "the straight line to them; use mode='both', or end at rest"
        )
    plan = _onward((s, 0.0, 0.0), goal, leg, planned, own)
    line = replace(line, legs=(*line.legs, leg))
    return _joined(been, leg.shares(plan, places)), line.then(plan)


def _onward(
    state: Moment, goal: Places, leg: Leg, planned: Sequence[Planned], own: Planned
) -> Trajectory:
    """Return the fastest motion along the line within the bounds of the axes and its own."""
    limits = _limits(leg, planned, own)
    if isinstance(own, SCurveSettings):
        settings = _tightened(own, limits)
        return s_curve_from(state, goal[0], replace(settings, final_velocity=goal[1])).trajectory
    assert limits is not None
    n = limits.order
    return min_time_transfer(state[:n], goal[:n], limits).trajectory


def _stop(state: Moment, leg: Leg, planned: Sequence[Planned], own: Planned) -> Trajectory:
    """Return the fastest way to rest along the line."""
    limits = _limits(leg, planned, own)
    if isinstance(own, SCurveSettings):
        return stop_from(state, _tightened(own, limits))
    assert limits is not None
    return Problem(state[: limits.order], (state[0],), limits).change_of_velocity().trajectory


def _limits(leg: Leg, planned: Sequence[Planned], own: Planned) -> Limits | None:
    """Return the tightest bounds along the line, None where S-curve rates alone bound it."""
    shares: list[tuple[float, list[Pair]]] = []
    for number, (share, each) in enumerate(zip(leg.direction, planned, strict=True)):
        if share and (each is not None or own is None):
            shares.append((share, _bounds(number, each)))
    if isinstance(own, Limits):
        shares.append((1.0, _bounds(len(planned), own)))
    orders = {len(pairs) for _, pairs in shares}
    if not orders:
        return None
    if len(orders) > 1:
        raise ValueError(
            f"limits of orders {sorted(orders)} along one line: expected one order under way, 2 or "
            "3; give limits= or resultant= of that order"
        )
    bounds = tightest(((share, iter(pairs)) for share, pairs in shares), orders.pop())
    return Limits.from_bounds(bounds)


def _bounds(number: int, planned: Planned) -> list[Pair]:
    """Return bounds of derivatives 1, 2, … that keep what an axis was planned with, both ways."""
    if isinstance(planned, Limits) and planned.order in (2, 3):
        return [planned.bounds(k) for k in range(1, planned.order + 1)]
    if isinstance(planned, SCurveSettings) and planned.rates.jerk_percent is None:
        rates = planned.rates
        least = (
            rates.velocity,
            min(rates.acceleration, rates.deceleration),
            min(rates.acceleration_jerk, rates.deceleration_jerk),
        )
        return [(-bound, bound) for bound in least]
    raise unknown_limits(number, planned)


def unknown_limits(number: int, planned: Planned) -> ValueError:
    """Return the error for an axis that cannot be planned anew under way."""
    found = "limits that are not known" if planned is None else shown(planned)
    return ValueError(
        f"axis {number} was planned with {found}: expected limits of order 2 or 3 for new motions "
        "under way; give it some by limits="
    )


def _tightened(settings: SCurveSettings, limits: Limits | None) -> SCurveSettings:
    """Return S-curve rates that keep limits along the line, too."""
    if limits is None:
        return settings
    rates = settings.rates
    most = [min(high, -low) for low, high in map(limits.bounds, range(1, 4))]
    rise = 1.0 if rates.percent_keeps_peak else 1.0 - 0.5 * (rates.jerk_percent or 0.0)
    if rates.jerk_percent is not None and limits.order == 3:
        raise ValueError(
            f"jerk_percent = {rates.jerk_percent!r} beside an axis whose jerk is bounded: give the "
            "resultant jerks, or the axis limits of order 2"
        )
    kept = Rates(
        min(rates.velocity, most[0]),
        min(rates.acceleration, most[1] * rise),
        min(rates.deceleration, most[1] * rise),
        min(rates.acceleration_jerk, most[2]),
        min(rates.deceleration_jerk, most[2]),
        rates.jerk_percent,
        rates.percent_keeps_peak,
    )
    return replace(settings, rates=kept)


def _resultant(line: Line | None, given: Limits | Mapping[str, float] | None) -> Planned:
    """Return what the resultant is planned with from now on."""
    old = None if line is None else line.planned
    return old if given is None else changed("the resultant", old, given)


def changed(name: str, old: Planned, given: object) -> Planned:
    """Return new limits, or S-curve rates some of which are new."""
    if isinstance(given, Limits):
        return of_one(given)
    if not isinstance(given, Mapping):
        raise TypeError(
            f"limits of {name} = {shown(given)}: expected Limits or rates of an S-curve"
        )
    if not isinstance(old, SCurveSettings):
        raise ValueError(
            f"rates of {name} = {shown(given)}: it was planned with no S-curve, expected Limits"
        )
    unknown = next((rate for rate in given if rate not in RATES), None)
    if unknown is not None:
        raise ValueError(f"rate {shown(unknown)} of {name}: expected one of {', '.join(RATES)}")
    named = {rate: given.get(rate) for rate in RATES}
    return old.changed(final_velocity=None, **named)


def _joined(been: Sequence[Motion], after: Sequence[Trajectory]) -> list[Motion]:
    return [spliced(first, second) for first, second in zip(been, after, strict=True)]


def _towards(places: Places, ends: Places) -> tuple[float, ...]:
    """Return the direction from some places to others, all zero where they are the same."""
    spans = [end - place for place, end in zip(places, ends, strict=True)]
    length = hypot(*spans)
    return tuple(span / length if length else 0.0 for span in spans)
