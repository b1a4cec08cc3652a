"""S-curve plans whose bounds tell speeding up from slowing down.

A plan goes one way: to a peak velocity, on at it, to the final velocity. Where it must turn
round it stops first, because at zero velocity the bounds for slowing down give way to those for
speeding up. Ways are planned in the positive direction, and mirrored for the other.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, sqrt

from ... import core
from ..checks import range_error
from .s_curve_rates import Motion, Pieces, Rates, in_own_units

ROUNDING = 16.0 * 2.0**-52
"""Relative size below which a difference is taken for rounding."""

_GOLDEN = 0.5 * (sqrt(5.0) - 1.0)
_GOLDEN_CUTS = 70  # down to rounding


def plan_move(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    """Return the pieces of a motion from a state to a position, passed at a final velocity.

    With a jerk percent the acceleration at the beginning is taken for zero. It is planned in the
    problem's own units.
    """
    if rates.jerk_percent is not None:
        begin = begin[0], begin[1], 0.0
    units, rates = in_own_units(begin, target, final_velocity, rates)
    origin = begin[0] if begin[0] == target else 0.0  # which may be far off the range of the units
    state = units.motion((begin[0] - origin, *begin[1:]))
    goal = units.into(target - origin, 0), units.into(final_velocity, 1)
    return units.pieces(_plan_towards(state, *goal, rates), origin)


def _plan_towards(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    """Return the pieces of a plan in either direction."""
    course = begin[1] or begin[2] or target - begin[0]
    if course < 0.0:
        opposite = -begin[0], -begin[1], -begin[2]
        return mirrored(_plan_ahead(opposite, -target, -final_velocity, rates))
    return _plan_ahead(begin, target, final_velocity, rates)


def stopping_place(begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the nearest position that can be passed at a final velocity without turning round."""
    units, rates = in_own_units(begin, begin[0], final_velocity, rates)
    sign = 1.0 if (begin[1] or begin[2] or final_velocity) >= 0.0 else -1.0
    _, state = _ease(units.motion((0.0, sign * begin[1], sign * begin[2])), rates)
    velocity = max(sign * units.into(final_velocity, 1), 0.0)
    settling = _settling(state[1], state[2], rates)
    turn = _dip(state, velocity, rates) if velocity > settling > 0.0 else velocity
    way = state[0] + _distance_by_way_of(turn, state, velocity, rates)
    return begin[0] + sign * units.back(way, 0)


def _plan_ahead(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    """Return the plan from a velocity ≥ 0: straight on if that leads there, else after a stop."""
    if _settling(begin[1], begin[2], rates) < 0.0:
        first, state = _to_zero(begin, rates)
        return first + _plan_towards(state, target, final_velocity, rates)
    eased, begin = _ease(begin, rates)
    direct = _one_way(begin, target, final_velocity, rates)
    if direct is not None:
        return eased + direct
    stop = eased + _leg(begin, 0.0, rates)
    x = _later(stop[-1][1], stop[-1][0])[0] if stop else begin[0]
    runway = _distance(_leg((0.0, 0.0, 0.0), abs(final_velocity), rates))
    if final_velocity > 0.0 and target - x >= runway:
        return stop + _from_rest(x, target, final_velocity, rates)
    if final_velocity < 0.0 and x - target >= runway:
        return stop + mirrored(_from_rest(-x, -target, -final_velocity, rates))
    runway = runway if final_velocity > 0.0 else -runway
    if target - runway >= x:
        across = _from_rest(x, target - runway, 0.0, rates)
    else:
        across = mirrored(_from_rest(-x, runway - target, 0.0, rates))
    if final_velocity >= 0.0:
        return stop + across + _leg((target - runway, 0.0, 0.0), final_velocity, rates)
    last = _leg((runway - target, 0.0, 0.0), -final_velocity, rates)
    return stop + across + mirrored(last)


def _from_rest(x: float, target: float, final_velocity: float, rates: Rates) -> Pieces:
    pieces = _one_way((x, 0.0, 0.0), target, final_velocity, rates)
    assert pieces is not None  # from rest, with the runway, there always is a way
    return pieces


def _one_way(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces | None:
    """Return the plan that never goes back, None where there is none."""
    x, v, a = begin
    settling = _settling(v, a, rates)
    if final_velocity < 0.0:
        return None
    if settling > rates.velocity and rates.jerk_percent is None:
        return _slowed_down(begin, target, final_velocity, rates)
    distance, slack = target - x, ROUNDING * (abs(target - x) + abs(x) + abs(target))
    low, high = max(settling, final_velocity), rates.velocity

    def missing(turn: float) -> float:
        return distance - _distance_by_way_of(turn, begin, final_velocity, rates)

    turn, rest = high, missing(high)
    if rest < 0.0:
        if settling < final_velocity and missing(low) < -slack:
            low, high = _dip(begin, final_velocity, rates), settling
        if low > high or missing(low) < -slack:
            slows = a <= 0.0 and final_velocity <= v and rates.jerk_percent is None
            return _slowing(begin, target, final_velocity, rates, v) if slows else None
        turn = _largest(low, high, missing) if missing(low) > slack else low
        rest = missing(turn)  # what rounding of the peak leaves of a short way at speed
        rest = rest if rest > slack else 0.0
    return _by_way_of(
        turn, max(rest, 0.0) / turn if turn else 0.0, begin, target, final_velocity, rates
    )


def _slowed_down(
    begin: Motion, target: float, final_velocity: float, rates: Rates
) -> Pieces | None:
    """Return the plan from a velocity beyond its bound that never goes back, None for none.

    It levels off at the bound, or, where the target is too near for that, brakes harder.
    """
    levelled = _leg(begin, rates.velocity, rates)
    state = begin[0] + _distance(levelled), rates.velocity, 0.0
    onward = _one_way(state, target, final_velocity, rates)
    if onward is not None:
        return levelled + onward
    eased = _leg(begin, _settling(*begin[1:], rates), rates) if begin[2] > 0.0 else []
    if eased:
        begin = begin[0] + _distance(eased), _settling(*begin[1:], rates), 0.0
    braking = _slowing(begin, target, final_velocity, rates, rates.velocity)
    return None if braking is None else eased + braking


def _distance_by_way_of(turn: float, begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the distance of going to one velocity and then to the final one."""
    last = _leg((0.0, turn, 0.0), final_velocity, rates)
    return _distance(_leg(begin, turn, rates)) + _distance(last)


def _dip(begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the velocity to slow down to first that makes the way to the final one shortest.

    Slowing down turns the acceleration up at a lower velocity, where it costs less distance.
    Golden section: the distance falls and rises again.
    """
    low, high = 0.0, _settling(begin[1], begin[2], rates)
    span = high
    for _ in range(_GOLDEN_CUTS):
        span *= _GOLDEN
        left, right = high - span, low + span
        if _distance_by_way_of(left, begin, final_velocity, rates) < _distance_by_way_of(
            right, begin, final_velocity, rates
        ):
            high = right
        else:
            low = left
        span = high - low
    return low


def _largest(low: float, high: float, missing: Callable[[float], float]) -> float:
    """Return the largest peak velocity at which some of the distance is still missing."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if missing(middle) >= 0.0 else (low, middle)
    return low


def _by_way_of(
    peak: float, cruise: float, begin: Motion, target: float, final_velocity: float, rates: Rates
) -> Pieces:
    """Return the plan to a peak velocity, kept for a time, and to the final one at the target."""
    first = _leg(begin, peak, rates)
    last = _leg((0.0, peak, 0.0), final_velocity, rates)
    shift = target - _distance(last)
    x = begin[0] + _distance(first)
    return [
        *first,
        (cruise, (x, peak, 0.0, 0.0)),
        *((duration, (shift + row[0], *row[1:])) for duration, row in last),
    ]


def _slowing(
    begin: Motion, target: float, final_velocity: float, rates: Rates, fastest: float
) -> Pieces | None:
    """Return the fastest plan that slows down all the way, None where there is none."""
    rate, jerk = rates.deceleration, rates.deceleration_jerk
    bounds = (0.0, fastest, -rate, rate, -jerk, jerk)
    motion = core.transfer(begin, (target, final_velocity, 0.0), bounds) if fastest else 0
    if isinstance(motion, int) or (motion.inside_after > 0.0 and fastest == begin[1]):
        return None
    pieces = _pieces(motion)
    if max(max(row[2], row[2] + time * row[3]) for time, row in pieces) > ROUNDING * rate:
        return None
    return pieces


def _pieces(motion: core.Motion | int) -> Pieces:
    if isinstance(motion, int):
        raise range_error()
    _, states, durations, _ = motion.arrays()
    return list(zip(durations.tolist(), map(tuple, states.tolist()), strict=True))


def _later(row: tuple[float, ...], time: float) -> tuple[float, float, float]:
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


def _settling(v: float, a: float, rates: Rates) -> float:
    """Return the velocity at which acceleration has gone to zero as fast as it may."""
    jerk = rates.acceleration_jerk if a > 0.0 else -rates.deceleration_jerk
    return v + 0.5 * a * a / jerk if a else v


def _ease(begin: Motion, rates: Rates) -> tuple[Pieces, Motion]:
    """Return how an acceleration beyond its bounds is brought inside, and the state then."""
    x, v, a = begin
    kept = min(max(a, -rates.deceleration), rates.acceleration)
    if kept == a or rates.jerk_percent is not None:
        return [], begin
    jerk = -rates.acceleration_jerk if a > kept else rates.deceleration_jerk
    piece = (kept - a) / jerk, (x, v, a, jerk)
    later = _later(piece[1], piece[0])
    return [piece], (later[0], later[1], kept)


def _to_zero(begin: Motion, rates: Rates) -> tuple[Pieces, Motion]:
    """Return the way to zero velocity of a motion that slows down too hard not to pass it."""
    x, v, a = begin
    jerk = rates.deceleration_jerk
    duration = 2.0 * v / (sqrt(a * a - 2.0 * jerk * v) - a)
    piece = duration, (x, v, a, jerk)
    later = _later(piece[1], duration)
    return [piece], (later[0], 0.0, later[2])


def _leg(begin: Motion, velocity: float, rates: Rates) -> Pieces:
    """Return the fastest change to a velocity ≥ 0 kept from then on."""
    x, v, a = begin
    if rates.jerk_percent is not None:
        return _percent_leg(x, v, velocity, rates, rates.jerk_percent)
    settling = _settling(v, a, rates)
    speeding = velocity > settling
    eased: Pieces = []
    if a and (a > 0.0) != speeding:  # first the acceleration goes to zero
        jerk = -rates.acceleration_jerk if a > 0.0 else rates.deceleration_jerk
        eased = [(-a / jerk, (x, v, a, jerk))]
        x, v, a = _later(eased[0][1], eased[0][0])[0], settling, 0.0
    bound = rates.acceleration if speeding else rates.deceleration
    jerk = rates.acceleration_jerk if speeding else rates.deceleration_jerk
    bounds = (-inf, inf, -bound, bound, -jerk, jerk)
    change = _pieces(core.velocity_transfer((x, v, a), (x, velocity, 0.0), bounds))
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
    x, v = _later(first[1], curved)[:2]
    second = (straight, (x, v, peak, 0.0))
    x, v = _later(second[1], straight)[:2]
    return [first, second, (curved, (x, v, peak, -jerk))]


def _distance(pieces: Pieces) -> float:
    """Return the distance from the start of the pieces to their end."""
    if not pieces:
        return 0.0
    duration, row = pieces[-1]
    return _later(row, duration)[0] - pieces[0][1][0]
