"""The motions of a stretch by moving averages of those of order 3, from order 4 on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..limits import Limits
from ..optimal.smoothing import truncated
from ..pieces import FloatArray
from .averages import Pieces, widths
from .legs import PlannedLegs, States, planned
from .route import Leg

_CORRECTIONS = 20
_MISSED = 4e-15  # of the largest coordinate: a point that is passed
_EXCESS = 1e-10  # over a bound, relative: rounding


@dataclass(frozen=True, eq=False)
class Averaging:
    """How motions within some limits become motions within others of higher order.

    Attributes
    ----------
    limits : sequence of Limits
        One per axis, of order 2 or 3: those before.
    windows : tuple of float
        Widths of moving averages, the same for all axes, so that lines stay lines.
    """

    limits: Sequence[Limits]
    windows: tuple[float, ...]

    @classmethod
    def to(cls, limits: Sequence[Limits]) -> Averaging | None:
        """Return the averaging that leads to these limits; None where there is none.

        It takes acceleration or jerk bounded on both sides, and above no bound zero on a side.
        """
        before = [_before(one) for one in limits]
        pairs = [(low, one) for low, one in zip(before, limits, strict=True) if low is not None]
        if len(pairs) < len(before):
            return None
        each = [_windows(*pair) for pair in pairs]
        steps = range(max(map(len, each)))
        windows = tuple(max(one[i] for one in each if len(one) > i) for i in steps)
        return cls([low for low, _ in pairs], windows)

    @property
    def longer(self) -> float:
        """By how much it takes longer."""
        return sum(self.windows)

    def before(self, legs: Sequence[Leg]) -> list[Leg]:
        """Return legs with the limits before."""
        limits = [[_before(one) for one in leg.limits] for leg in legs]
        return [
            replace(leg, limits=tuple(one for one in own if one is not None))
            for leg, own in zip(legs, limits, strict=True)
        ]


def _before(limits: Limits) -> Limits | None:
    """Return the limits of order 3, or 2 where jerk is free."""
    both = [low < 0.0 < high for low, high in zip(limits.lower, limits.upper, strict=True)]
    for order in (3, 2):
        if all(both[order - 1 :]) and np.isfinite(limits.bounds(min(order, len(both)))).all():
            return truncated(limits, min(order, len(both)))
    return None


def _windows(before: Limits, limits: Limits) -> list[float]:
    low, high = before.bounds(before.order)
    above = map(limits.bounds, range(before.order + 1, limits.order + 1))
    return widths(high - low, [min(-side[0], side[1]) for side in above])


def smoothed(
    legs: Sequence[Leg],
    states: States,
    limits: Sequence[Limits],
    by: Averaging,
    blends: Mapping[int, tuple[FloatArray, float]],
) -> PlannedLegs | None:
    """Return legs whose motions are averages of those between about these states, or None.

    Places at which an average is elsewhere are moved until it passes where they were. Blends begin
    and end half of all windows beside their nodes: outside of them lines are kept.

    Parameters
    ----------
    legs : sequence of Leg
        Of a stretch, with the limits before averages.
    states : list of (order, axes) arrays
        At its nodes, before averages; the first and the last are those afterwards.
    limits : sequence of Limits
        That are kept in the end.
    by : Averaging
    blends : mapping of int to (place, corner)
        Of the legs around corners by their numbers, the corner and how far they may be from it.

    Returns
    -------
    PlannedLegs or None
        None where no plan is found, a bound is broken, or a blend begins too far from its corner.
    """
    beside = _beside(legs, blends)
    if beside is None:
        return None
    half = 0.5 * by.longer
    moved = [state.copy() for state in states]
    moved[0][0] += half * states[0][1]
    moved[-1][0] -= half * states[-1][1]
    exact = np.flatnonzero(beside == 0.0)
    every = np.array([state[0] for state in states])
    places, size = every[1:-1], float(np.abs(every).max())
    for _ in range(_CORRECTIONS):
        try:
            found = planned(legs, moved, by.limits)
        except ValueError:  # no way between them any more
            return None
        axes = [_averaged(found, k, by.windows) for k in range(len(limits))]
        times = np.cumsum(found.durations, dtype=np.longdouble)
        passed = np.array([one.places(times[:-1] + half) for one in axes]).T
        missed = (places - passed)[exact]
        if np.abs(missed).max(initial=0.0) <= _MISSED * size:
            break
        for number, way in zip(exact, missed, strict=True):
            moved[number + 1][0] += way
    else:
        return None
    ends = np.append(times[:-1] + half + beside * half, times[-1] + by.longer)
    return _kept(_legs(axes, ends, states), limits, blends)


def _beside(
    legs: Sequence[Leg], blends: Mapping[int, tuple[FloatArray, float]]
) -> FloatArray | None:
    """Return for each node inside whether a blend begins there, −1, ends there, 1, or neither, 0.

    None where a line meets another leg, as it would be left before.
    """
    beside = np.zeros(len(legs) - 1)
    for number, leg in enumerate(legs):
        if number in blends:
            beside[number - 1 : number + 1] = [-1.0, 1.0]
        elif leg.kind == "free":
            around = [k for k in (number - 1, number + 1) if 0 <= k < len(legs)]
            if any(legs[k].kind == "straight" for k in around):
                return None
    return beside


def _averaged(found: PlannedLegs, axis: int, windows: Sequence[float]) -> Pieces:
    pieces = Pieces.joined([leg[axis] for leg in found.motions])
    for width in windows:
        pieces = pieces.averaged(width)
    return pieces


def _legs(axes: Sequence[Pieces], ends: FloatArray, states: States) -> PlannedLegs | None:
    """Return the motions of axes in legs that end at these times; None where these do not grow."""
    durations = np.diff(ends, prepend=0.0)
    if durations.min() <= 0.0:
        return None
    parts = [
        one.between(states[0][:, k], states[-1][:, k]).cut(np.append(ends[:-1], one.edges[-1]))
        for k, one in enumerate(axes)
    ]
    return PlannedLegs(tuple(map(float, durations)), tuple(zip(*parts, strict=True)))


def _kept(
    legs: PlannedLegs | None,
    limits: Sequence[Limits],
    blends: Mapping[int, tuple[FloatArray, float]],
) -> PlannedLegs | None:
    """Return legs that keep all bounds, and begin and end blends near enough to the corner."""
    if legs is None:
        return None
    for motions in legs.motions:
        pairs = zip(motions, limits, strict=True)
        if any(motion.violation(one) > _EXCESS for motion, one in pairs):
            return None
    for number, (place, corner) in blends.items():
        for motions in legs.motions[number : number + 2]:
            start = [motion.start_state[0] for motion in motions]
            if np.linalg.norm(start - place) > corner:
                return None
    return legs
