"""S-curve plans whose bounds tell speeding up from slowing down.

A plan goes one way: to a peak velocity, on at it, to the final velocity. Where it must turn
round it stops first, because at zero velocity the bounds for slowing down give way to those for
speeding up. Ways are planned in the positive direction, and mirrored for the other.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ldexp, sqrt

from ... import core
from .s_curve_ramps import (
    Motion,
    Pieces,
    Rates,
    Unit,
    distance_of,
    ease,
    leg,
    mirrored,
    pieces_of,
    settling_velocity,
    state_after,
    to_zero,
)

ROUNDING = 16.0 * 2.0**-52
"""Relative size below which a difference is taken for rounding."""

_GOLDEN = 0.5 * (sqrt(5.0) - 1.0)


def plan_move(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    """Return the pieces of a motion from a state to a position, passed at a final velocity.

    With a jerk percent the acceleration at the beginning is taken for zero.
    """
    unit = Unit.of(rates)
    goal, final = unit.to(target, final_velocity)
    return unit.back(_plan(unit.motion(begin), goal, final, unit.rates(rates)))


def _plan(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    if rates.jerk_percent is not None:
        begin = begin[0], begin[1], 0.0
    course = begin[1] or begin[2] or target - begin[0]
    if course < 0.0:
        opposite = -begin[0], -begin[1], -begin[2]
        return mirrored(plan_ahead(opposite, -target, -final_velocity, rates))
    return plan_ahead(begin, target, final_velocity, rates)


def stopping_place(begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the nearest position that can be passed at a final velocity without turning round."""
    unit = Unit.of(rates)
    begin, rates = unit.motion(begin), unit.rates(rates)
    (final_velocity,) = unit.to(final_velocity)
    sign = 1.0 if (begin[1] or begin[2] or final_velocity) >= 0.0 else -1.0
    _, state = ease((sign * begin[0], sign * begin[1], sign * begin[2]), rates)
    velocity = max(sign * final_velocity, 0.0)
    settling = settling_velocity(state[1], state[2], rates)
    turn = _dip(state, velocity, rates) if velocity > settling > 0.0 else velocity
    place = state[0] + _distance_by_way_of(turn, state, velocity, rates)
    return sign * ldexp(place, unit.exponent)


def plan_ahead(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces:
    """Return the plan from a velocity ≥ 0: straight on if that leads there, else after a stop."""
    if settling_velocity(begin[1], begin[2], rates) < 0.0:
        first, state = to_zero(begin, rates)
        return first + _plan(state, target, final_velocity, rates)
    eased, begin = ease(begin, rates)
    direct = _one_way(begin, target, final_velocity, rates)
    if direct is not None:
        return eased + direct
    stop = eased + leg(begin, 0.0, rates)
    x = state_after(stop[-1][1], stop[-1][0])[0] if stop else begin[0]
    runway = distance_of(leg((0.0, 0.0, 0.0), abs(final_velocity), rates))
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
        return stop + across + leg((target - runway, 0.0, 0.0), final_velocity, rates)
    last = leg((runway - target, 0.0, 0.0), -final_velocity, rates)
    return stop + across + mirrored(last)


def _from_rest(x: float, target: float, final_velocity: float, rates: Rates) -> Pieces:
    pieces = _one_way((x, 0.0, 0.0), target, final_velocity, rates)
    assert pieces is not None  # from rest, with the runway, there always is a way
    return pieces


def _one_way(begin: Motion, target: float, final_velocity: float, rates: Rates) -> Pieces | None:
    """Return the plan that never goes back, None where there is none."""
    x, v, a = begin
    settling = settling_velocity(v, a, rates)
    if final_velocity < 0.0:
        return None
    if max(v, settling) > rates.velocity:
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
    return _by_way_of(
        turn, max(rest, 0.0) / turn if turn else 0.0, begin, target, final_velocity, rates
    )


def _slowed_down(
    begin: Motion, target: float, final_velocity: float, rates: Rates
) -> Pieces | None:
    """Return the plan from a velocity beyond its bound that never goes back, None for none.

    The core's policy (`core/inside.c`): it levels off at the bound; where the target is too near
    for that, it brakes as hard as it may down to the bound; where that would turn it round, it
    levels off at a lower velocity.
    """
    eased: Pieces = []
    if begin[2] > 0.0:
        eased = leg(begin, settling_velocity(*begin[1:], rates), rates)
        begin = begin[0] + distance_of(eased), settling_velocity(*begin[1:], rates), 0.0
    top = min(rates.velocity, settling_velocity(*begin[1:], rates))
    levelled = leg(begin, top, rates)
    ways = (levelled, (begin[0] + distance_of(levelled), top, 0.0)), _hard_braking(begin, rates)
    for first, state in ways:
        turns = settling_velocity(*state[1:], rates) < 0.0
        onward = None if turns else _one_way(state, target, final_velocity, rates)
        if onward is not None:
            return eased + first + onward
    lower = _level_below(begin, target, top, final_velocity, rates)
    return None if lower is None else eased + lower


def _hard_braking(begin: Motion, rates: Rates) -> tuple[Pieces, Motion]:
    """Return the hardest way down to the bound of the velocity, and the state there."""
    x, v, a = begin
    bound, jerk = rates.velocity, rates.deceleration_jerk
    if rates.jerk_percent is not None:
        ramp = leg(begin, bound, rates)
        return ramp, (x + distance_of(ramp), bound, 0.0)
    arrival = -min(rates.deceleration, sqrt(a * a + 2.0 * jerk * (v - bound)))
    falling = (a - arrival) / jerk, (x, v, a, -jerk)
    x, v, _ = state_after(falling[1], falling[0])
    holding = max(v - bound, 0.0) / -arrival, (x, v, arrival, 0.0)
    return [falling, holding], (state_after(holding[1], holding[0])[0], bound, arrival)


def _level_below(
    begin: Motion, target: float, top: float, final_velocity: float, rates: Rates
) -> Pieces | None:
    """Return the way by the highest velocity, at most `top`, that leads no further than the end."""
    distance = target - begin[0]
    slack = ROUNDING * (abs(distance) + abs(begin[0]) + abs(target))

    def missing(turn: float) -> float:
        return distance - _distance_by_way_of(turn, begin, final_velocity, rates)

    low = final_velocity if final_velocity <= top else _dip(begin, final_velocity, rates)
    if missing(low) < -slack:
        return None
    turn = _largest(low, top, missing) if missing(low) > slack else low
    return _by_way_of(turn, 0.0, begin, target, final_velocity, rates)


def _distance_by_way_of(turn: float, begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the distance of going to one velocity and then to the final one."""
    last = leg((0.0, turn, 0.0), final_velocity, rates)
    return distance_of(leg(begin, turn, rates)) + distance_of(last)


def _dip(begin: Motion, final_velocity: float, rates: Rates) -> float:
    """Return the velocity to slow down to first that makes the way to the final one shortest.

    Slowing down turns the acceleration up at a lower velocity, where it costs less distance.
    Golden section: the distance falls and rises again.
    """
    low, high = 0.0, settling_velocity(begin[1], begin[2], rates)
    span = high
    while span > ROUNDING * high:
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
    first = leg(begin, peak, rates)
    last = leg((0.0, peak, 0.0), final_velocity, rates)
    shift = target - distance_of(last)
    x = begin[0] + distance_of(first)
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
    pieces = pieces_of(motion)
    if max(max(row[2], row[2] + time * row[3]) for time, row in pieces) > ROUNDING * rate:
        return None
    return pieces
