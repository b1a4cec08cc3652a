"""Changes of velocity whose bounds tell speeding up from slowing down.

They are planned at velocities ≥ 0, and mirrored for the other direction. At zero velocity the
bounds for slowing down give way to those for speeding up.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import frexp, inf, ldexp, sqrt

from ... import core
from ..checks import range_error

Piece = tuple[float, tuple[float, ...]]
"""Duration, and position with derivatives at the start."""

Pieces = list[Piece]

Motion = tuple[float, float, float]
"""Position, velocity, acceleration."""


@dataclass(frozen=True)
class Rates:
    """How fast a motion may speed up and slow down.

    With a jerk percent p the jerks are not used: every ramp lasts as long as at constant
    acceleration A, and its jerk acts in p/2 of it at either end; so its peak acceleration is
    A/(1 − p/2); or, `percent_keeps_peak`, ramps last 1/(1 − p/2) times as long, and A is the peak.
    """

    velocity: float
    acceleration: float
    deceleration: float
    acceleration_jerk: float
    deceleration_jerk: float
    jerk_percent: float | None = None
    percent_keeps_peak: bool = False

    @property
    def alike(self) -> bool:
        """Whether speeding up and slowing down have the same bounds."""
        return (
            self.acceleration == self.deceleration
            and self.acceleration_jerk == self.deceleration_jerk
        )


@dataclass(frozen=True)
class Unit:
    """The unit of length 2^exponent in which the acceleration is near 1; to it and back exactly.

    Squares of numbers of any size so stay in the range of a double.
    """

    exponent: int

    @classmethod
    def of(cls, rates: Rates) -> Unit:
        """Return the unit for some rates."""
        return cls(frexp(rates.acceleration)[1])

    def to(self, *values: float) -> tuple[float, ...]:
        """Return values in this unit."""
        return tuple(ldexp(value, -self.exponent) for value in values)

    def motion(self, begin: Motion) -> Motion:
        """Return a state in this unit."""
        x, v, a = self.to(*begin)
        return x, v, a

    def rates(self, rates: Rates) -> Rates:
        """Return rates in this unit."""
        velocity, up, down = self.to(rates.velocity, rates.acceleration, rates.deceleration)
        rise, fall = self.to(rates.acceleration_jerk, rates.deceleration_jerk)
        return Rates(velocity, up, down, rise, fall, rates.jerk_percent, rates.percent_keeps_peak)

    def back(self, pieces: Pieces) -> Pieces:
        """Return the pieces of a motion planned in this unit."""
        return [
            (duration, tuple(ldexp(value, self.exponent) for value in row))
            for duration, row in pieces
        ]


def plan_velocity(begin: Motion, velocity: float, rates: Rates) -> Pieces:
    """Return the pieces of the fastest change to a velocity, which is then kept.

    With a jerk percent the acceleration at the beginning is taken for zero. Where rates differ
    and the motion must turn round, it stops first.
    """
    unit = Unit.of(rates)
    (final,) = unit.to(velocity)
    return unit.back(_change(unit.motion(begin), final, unit.rates(rates)))


def _change(begin: Motion, velocity: float, rates: Rates) -> Pieces:
    if rates.jerk_percent is not None:
        begin = begin[0], begin[1], 0.0
        if rates.alike:
            return leg(begin, velocity, rates)
    course = begin[1] or begin[2] or velocity
    if course < 0.0:
        opposite = -begin[0], -begin[1], -begin[2]
        return mirrored(_velocity_ahead(opposite, -velocity, rates))
    return _velocity_ahead(begin, velocity, rates)


def _velocity_ahead(begin: Motion, velocity: float, rates: Rates) -> Pieces:
    """Return the change from a velocity ≥ 0."""
    if settling_velocity(begin[1], begin[2], rates) < 0.0:
        first, state = to_zero(begin, rates)
        return first + _change(state, velocity, rates)
    eased, begin = ease(begin, rates)
    if velocity >= 0.0:
        return eased + leg(begin, velocity, rates)
    stop = leg(begin, 0.0, rates)
    x = begin[0] + distance_of(stop)
    return eased + stop + mirrored(leg((-x, 0.0, 0.0), -velocity, rates))


def pieces_of(motion: core.Motion | int) -> Pieces:
    """Return the pieces of a motion of the core."""
    if isinstance(motion, int):
        raise range_error()
    _, states, durations, _ = motion.arrays()
    return list(zip(durations.tolist(), map(tuple, states.tolist()), strict=True))


def state_after(row: tuple[float, ...], time: float) -> tuple[float, float, float]:
    """Return position, velocity and acceleration a time after a piece's start."""
    x, v, a, j = row
    return (
        x + time * (v + time * (a / 2.0 + time * j / 6.0)),
        v + time * (a + time * j / 2.0),
        a + time * j,
    )


def mirrored(pieces: Pieces) -> Pieces:
    """Return the pieces of the motion in the opposite direction."""
    return [(duration, tuple(-value for value in row)) for duration, row in pieces]


def settling_velocity(v: float, a: float, rates: Rates) -> float:
    """Return the velocity at which acceleration has gone to zero as fast as it may."""
    jerk = rates.acceleration_jerk if a > 0.0 else -rates.deceleration_jerk
    return v + 0.5 * a * a / jerk if a else v


def ease(begin: Motion, rates: Rates) -> tuple[Pieces, Motion]:
    """Return how an acceleration beyond its bounds is brought inside, and the state then."""
    x, v, a = begin
    kept = min(max(a, -rates.deceleration), rates.acceleration)
    if kept == a or rates.jerk_percent is not None:
        return [], begin
    jerk = -rates.acceleration_jerk if a > kept else rates.deceleration_jerk
    piece = (kept - a) / jerk, (x, v, a, jerk)
    later = state_after(piece[1], piece[0])
    return [piece], (later[0], later[1], kept)


def to_zero(begin: Motion, rates: Rates) -> tuple[Pieces, Motion]:
    """Return the way to zero velocity of a motion that slows down too hard not to pass it."""
    x, v, a = begin
    jerk = rates.deceleration_jerk
    duration = 2.0 * v / (sqrt(a * a - 2.0 * jerk * v) - a)
    piece = duration, (x, v, a, jerk)
    later = state_after(piece[1], duration)
    return [piece], (later[0], 0.0, later[2])


def leg(begin: Motion, velocity: float, rates: Rates) -> Pieces:
    """Return the fastest change to a velocity ≥ 0 kept from then on."""
    x, v, a = begin
    if rates.jerk_percent is not None:
        return _percent_leg(x, v, velocity, rates, rates.jerk_percent)
    settling = settling_velocity(v, a, rates)
    speeding = velocity > settling
    eased: Pieces = []
    if a and (a > 0.0) != speeding:  # first the acceleration goes to zero
        jerk = -rates.acceleration_jerk if a > 0.0 else rates.deceleration_jerk
        eased = [(-a / jerk, (x, v, a, jerk))]
        x, v, a = state_after(eased[0][1], eased[0][0])[0], settling, 0.0
    bound = rates.acceleration if speeding else rates.deceleration
    jerk = rates.acceleration_jerk if speeding else rates.deceleration_jerk
    bounds = (-inf, inf, -bound, bound, -jerk, jerk)
    change = pieces_of(core.velocity_transfer((x, v, a), (x, velocity, 0.0), bounds))
    return eased + change


def _percent_leg(x: float, v: float, velocity: float, rates: Rates, percent: float) -> Pieces:
    """Return a ramp that lasts as long as at constant acceleration."""
    change = velocity - v
    if change == 0.0:
        return []
    speeding = velocity > v
    duration = abs(change) / (rates.acceleration if speeding else rates.deceleration)
    if not duration:
        raise OverflowError
    if rates.percent_keeps_peak:
        duration /= 1.0 - 0.5 * percent
    curved, straight = 0.5 * percent * duration, (1.0 - percent) * duration
    peak = change / duration / (1.0 - 0.5 * percent)
    held = (x, v, peak, 0.0)
    if not curved:
        return [(duration, held)]
    jerk = peak / curved
    first = (curved, (x, v, 0.0, jerk))
    x, v = state_after(first[1], curved)[:2]
    second = (straight, (x, v, peak, 0.0))
    x, v = state_after(second[1], straight)[:2]
    return [first, second, (curved, (x, v, peak, -jerk))]


def distance_of(pieces: Pieces) -> float:
    """Return the distance from the start of the pieces to their end."""
    if not pieces:
        return 0.0
    duration, row = pieces[-1]
    return state_after(row, duration)[0] - pieces[0][1][0]
