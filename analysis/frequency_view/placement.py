"""Placing a null of a move on a mode by lowering one limit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import copysign, exp, inf, pi, sqrt

import numpy as np

from ...shaping import Limits, Trajectory, min_time_move
from ...shaping.checks import finite, positive
from ...shaping.derivatives import derivative_name, derivative_number
from ...shaping.pieces import MAX_MOVE_ORDER
from ...shaping.real_numbers import shown
from .nulls import DOUBLE, SYMMETRIC
from .spectrum import spectrum_bound, velocity_spectrum
from .vibration import checked_damping, residual_vibration

_TURN = 0.3  # radians by which the phase of a break may change from step to step
_LONGEST_STEP = 0.1  # of the bound
_MOST_STEPS = 5000
_NARROW = 100.0  # the ramp of a bound that is not given, in parts of the mode's period
_MOST_TURNS = 1e6  # radians
_SOLVED = 1e-6  # of its neighbours: a change of sign with more than that left is a jump
_NEXT = 1.0  # radians by which a minimum may be away from the null
_PRECISION = 1e-15


@dataclass(frozen=True)
class _Candidate:
    """A move with one bound set, seen at a mode's frequency."""

    bound: float
    limits: Limits
    move: Trajectory
    omega: float

    @cached_property
    def response(self) -> float:
        """H(jω)·e^(jωT/2), real where the move is symmetric in time."""
        distance = float(self.move.end_state[0] - self.move.start_state[0])
        spectrum = complex(velocity_spectrum(self.move, 1j * self.omega)) / distance
        turned = spectrum * np.exp(0.5j * self.omega * self.move.duration)
        if abs(turned.imag) > SYMMETRIC:
            raise ValueError(
                "limits that differ between directions make a move that is not symmetric in time: "
                "it has minima, but no nulls; give the same bound in both directions"
            )
        return float(turned.real)

    @cached_property
    def vanishes(self) -> bool:
        """Whether the response is a null, but for rounding."""
        distance = float(self.move.end_state[0] - self.move.start_state[0])
        scale = float(spectrum_bound(self.move, self.omega)) / abs(distance)
        return abs(self.response) <= DOUBLE * scale

    def turned_from(self, other: _Candidate) -> float:
        """Return by how many radians the phase of a break differs from another move's."""
        mine, others = self.move.breaks, other.move.breaks
        if len(mine) != len(others):
            return inf
        centred = mine - others - 0.5 * (mine[-1] - others[-1])
        return float(self.omega * np.abs(centred).max())


@dataclass(frozen=True)
class _Plan:
    """The moves over a distance as one bound is lowered."""

    distance: float
    limits: Limits
    derivative: int
    omega: float

    def first(self) -> _Candidate:
        """Return the move as it is, with the highest bound that would make a difference to it."""
        move = _move(self.distance, self.limits)
        highest = min(self.derivative, move.order)
        rate = _NARROW * self.omega / (2.0 * pi)
        bound = move.peak(highest) * rate ** (self.derivative - highest)
        return _Candidate(bound, self.limits, move, self.omega)

    def at(self, bound: float) -> _Candidate:
        """Return the move with a bound."""
        limits = lowered(self.limits, self.derivative, bound)
        return _Candidate(bound, limits, _move(self.distance, limits), self.omega)

    def walk(self) -> Iterator[_Candidate]:
        """Yield moves with lower and lower bounds, near enough to miss no null between them."""
        first = self.first()
        yield first
        last, step = self.at(first.bound), _LONGEST_STEP
        yield last
        for _ in range(_MOST_STEPS):
            least = 0.1 * _TURN / max(1.0, self.omega * last.move.duration)
            following = self.at(last.bound * exp(-step))
            while step > least and following.turned_from(last) > _TURN:
                step *= 0.5
                following = self.at(last.bound * exp(-step))
            yield following
            last, step = following, min(2.0 * step, _LONGEST_STEP)


def place_null(
    distance: float,
    limits: Limits,
    frequency_hz: float,
    *,
    by: int | str = "jerk",
    damping: float = 0.0,
) -> Limits:
    """Return limits, one of them lowered, under which a move has a null at a frequency.

    The highest bound, and so the fastest move, with which
    `min_time_move(distance, limits, method="closed-form")` does not ring a mode of that frequency:
    H(jω) = 0 without damping. With damping no real bound makes it zero; then the bound is the one
    with the least residual vibration next to that null (`shaping.input_shaper` nulls a damped mode
    exactly). From order 4 on the null is that of the
    closed form only: the optimal move has other switches.

    Parameters
    ----------
    distance : float
        Signed, other than zero.
    limits : Limits
        Bounds that must not be exceeded.
    frequency_hz : float
        Of the mode without damping, in cycles per time unit; positive.
    by : int or str, optional
        The derivative whose bound is lowered, by number or name; it may be one that has no bound
        so far.
    damping : float, optional
        Of the mode, 0 ≤ ζ < 1.

    Returns
    -------
    Limits
        The same where the move has that null already, whichever of its ramps makes it.

    Raises
    ------
    ValueError
        For a distance of zero, a frequency that is not positive or turns the phase by more than
        1e6 radians in the move, bounds that make the move asymmetric in time, or where no null or
        minimum is found.

    Notes
    -----
    Without damping |H| at the frequency is below 1e-12, for orders to 6 and ωT below 1e4. The null
    holds for this distance. `null_by_size` tells whether it stays for others; a null of the ramp,
    by `null_rise_time`, stays for all that are long enough.

    Examples
    --------
    The highest jerk that rings no mode of 4 Hz makes ramps of 0.25 s.

    >>> limits = place_null(5.1, Limits(velocity=1.0, acceleration=1.9, jerk=40.0), 4.0)
    >>> round(limits.bounds("jerk")[1], 9)
    7.6
    """
    distance = finite("distance", distance)
    if not distance:
        raise ValueError("distance = 0: nothing moves, and nothing rings")
    derivative, omega = derivative_number(by), 2.0 * pi * positive("frequency_hz", frequency_hz)
    if not 1 <= derivative <= MAX_MOVE_ORDER:
        raise ValueError(
            f"by = {shown(by)}: expected velocity or a higher derivative, up to {MAX_MOVE_ORDER}"
        )
    ratio = float(checked_damping(finite("damping", damping)))
    plan = _Plan(distance, limits, derivative, omega * sqrt((1.0 - ratio) * (1.0 + ratio)))
    found = _highest_null(plan)
    if ratio == 0.0 or found.limits == limits:
        return found.limits
    return _least_residual(plan, found, omega, ratio)


def _move(distance: float, limits: Limits) -> Trajectory:
    """Return the closed form, which changes continuously with the bounds, most of the time."""
    return min_time_move(distance, limits, method="closed-form")


def lowered(limits: Limits, derivative: int, bound: float) -> Limits:
    """Return limits with one bound lowered, in both directions, where it is above."""
    count = max(limits.order, derivative)
    pairs = [limits.bounds(k) for k in range(1, count + 1)]
    low, high = pairs[derivative - 1]
    pairs[derivative - 1] = (max(low, -bound), min(high, bound))
    return Limits.from_bounds(pairs)


def _highest_null(plan: _Plan) -> _Candidate:
    """Return the first null on the way down."""
    walk = plan.walk()
    before, here = None, next(walk)
    turns = plan.omega * here.move.duration
    if not turns < _MOST_TURNS:
        raise ValueError(
            f"the mode swings {turns / (2.0 * pi):.3g} times in the move: expected "
            f"at most {_MOST_TURNS / (2.0 * pi):.2g}, beyond which rounding hides a null"
        )
    if here.vanishes:
        return here
    for after in walk:
        found = None
        if here.response * after.response < 0.0:
            found = _crossing(plan, here, after)
        elif before is not None and _is_dip(before, here, after):
            found = _dip(plan, before, after)
        if found is not None:
            return found
        before, here = here, after
    name = derivative_name(plan.derivative)
    raise ValueError(
        f"no {name} limit from {plan.first().bound:.6g} down to {here.bound:.3g} places a null at "
        f"{plan.omega / (2.0 * pi):.6g} Hz on a move over {plan.distance:.6g}: lower another limit"
    )


def _is_dip(before: _Candidate, here: _Candidate, after: _Candidate) -> bool:
    """Tell whether responses of one sign are least in the middle."""
    sign = copysign(1.0, here.response)
    height = sign * here.response
    return height < sign * before.response and height <= sign * after.response


def _crossing(plan: _Plan, high: _Candidate, low: _Candidate) -> _Candidate | None:
    """Return the null between two bounds with responses of opposite sign, None at a jump."""
    from scipy.optimize import brentq

    if high.bound == low.bound:  # the move without a bound, and with the highest
        return None
    bound = brentq(
        lambda b: plan.at(b).response, low.bound, high.bound, xtol=_PRECISION * low.bound
    )
    found = plan.at(bound)
    left = _SOLVED * max(abs(high.response), abs(low.response))
    return found if abs(found.response) <= left else None


def _dip(plan: _Plan, high: _Candidate, low: _Candidate) -> _Candidate | None:
    """Return the higher of two nulls, or the double one, between bounds; None where it is none."""
    from scipy.optimize import minimize_scalar

    sign = copysign(1.0, high.response)
    ends, precision = (low.bound, high.bound), 1e-10 * low.bound
    lowest = minimize_scalar(
        lambda b: sign * plan.at(b).response,
        bounds=ends,
        method="bounded",
        options={"xatol": precision},
    )
    found = plan.at(float(lowest.x))
    if found.vanishes:
        return found
    return _crossing(plan, high, found) if sign * found.response < 0.0 else None


def _least_residual(plan: _Plan, null: _Candidate, omega: float, damping: float) -> Limits:
    """Return the limits with the least residual vibration next to a null without damping."""
    from scipy.optimize import minimize_scalar

    width, least = 0.5, 0.1 * _NEXT / max(1.0, omega * null.move.duration)
    while width > least and any(
        plan.at(null.bound * exp(way * width)).turned_from(null) > _NEXT for way in (-1.0, 1.0)
    ):
        width *= 0.5
    highest = plan.first().bound
    ends = (null.bound * exp(-width), min(null.bound * exp(width), highest))

    def residual(bound: float) -> float:
        return float(residual_vibration(plan.at(bound).move, omega / (2.0 * pi), damping))

    options = {"xatol": 1e-9 * null.bound}
    bound = float(minimize_scalar(residual, bounds=ends, method="bounded", options=options).x)
    edge = 1e-3 * (ends[1] - ends[0])
    if bound < ends[0] + edge or ends[1] - edge < bound < highest - edge:
        raise ValueError(
            f"damping = {damping!r} leaves no minimum of the residual vibration next to the null; "
            "place the null without damping"
        )
    return plan.at(bound).limits
