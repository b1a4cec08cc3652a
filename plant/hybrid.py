"""A loop as a piecewise linear system: friction, torque limit and integral make its modes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from ..shaping.pieces import FloatArray
from .anti_windup import BackCalculation, Clamp
from .axis import Axis
from .controller import Controller
from .layout import Layout
from .open_loop import OpenLoop

_ON_LIMIT = 1e-9  # of the limit: a torque further away has jumped


class Mode(NamedTuple):
    """Friction sticks (0) or slips (±1); the torque is limited (±1); the integral held (±1).

    Ripple counts the straight lines of its table. Integral 2: it goes on just so fast that the
    torque asked for stays on the limit, where integrating would drive it beyond and holding the
    integral back inside.
    """

    friction: int = 0
    limit: int = 0
    integral: int = 0
    ripple: int = 0


@dataclass(frozen=True, eq=False)
class Hybrid:
    """ż = rates[m]·z in mode m while all rows[m]·z are positive; next[m] is beyond each.

    Attributes
    ----------
    modes : tuple of Mode
    rates : (modes, moving, n) array
    rows : (modes, guards, n) array
    next : (modes, guards) array
        −1 where there is no guard.
    onto, along : (modes, guards, n) arrays
        On the way to the next mode z ← z + onto·(along·z).
    torque : (modes, n) array
        Rows of the command u.
    pushing : (n,) array
        Row of the torque that friction has to hold while it sticks, in each mode of the limit.
    """

    modes: tuple[Mode, ...]
    rates: FloatArray
    rows: FloatArray
    next: FloatArray
    onto: FloatArray
    along: FloatArray
    torque: FloatArray
    pushing: FloatArray


def hybrid_of(
    axis: Axis, controller: Controller, layout: Layout, loop: OpenLoop | None, friction_ahead: float
) -> Hybrid:
    """Return the piecewise linear system of a loop, of a digital one without `loop`."""
    builder = _Builder(axis, controller, layout, loop, friction_ahead)
    kinds = builder.kinds()
    number = {mode: i for i, mode in enumerate(kinds)}
    parts = [builder.mode(mode) for mode in kinds]
    most = max(len(part.guards) for part in parts)
    n, count = layout.size, len(kinds)
    rows, beyond = np.zeros((count, most, n)), np.full((count, most), -1.0)
    onto, along = np.zeros((count, most, n)), np.zeros((count, most, n))
    for i, part in enumerate(parts):
        for j, guard in enumerate(part.guards):
            rows[i, j], beyond[i, j] = guard.row, number[guard.target]
            onto[i, j], along[i, j] = guard.onto, guard.along
    return Hybrid(
        kinds,
        np.array([part.rates for part in parts]),
        rows,
        beyond,
        onto,
        along,
        np.array([part.torque for part in parts]),
        np.array([part.pushing for part in parts]),
    )


class _Guard(NamedTuple):
    """A row that stays positive, the mode beyond, and what changes at once on the way there."""

    row: FloatArray
    target: Mode
    onto: FloatArray | float = 0.0
    along: FloatArray | float = 0.0


class _Part(NamedTuple):
    rates: FloatArray
    guards: list[_Guard]
    torque: FloatArray
    pushing: FloatArray


class _Builder:
    """Rows and rates of each mode."""

    def __init__(
        self,
        axis: Axis,
        controller: Controller,
        layout: Layout,
        loop: OpenLoop | None,
        friction_ahead: float,
    ) -> None:
        self.axis, self.controller, self.layout, self.loop = axis, controller, layout, loop
        d = axis.dynamics
        self.velocity = layout.row(d.motor_rate)
        self.kick = layout.row(d.b[:, 1])  # of a torque on the motor
        load = layout.disturbing("load", axis.constant_load)
        pushes = (layout.disturbing("motor", 0.0), load)
        self.rates = layout.own_rates()
        if loop is None:
            self.rates[: d.size, : d.size] = d.a
            self.drive = layout.row(d.b[:, 0])
            disturbed = d.b[:, 1:]
            self.asked = layout.unit(layout.held)
        else:
            n = len(loop.a)
            self.rates[:n, :n] = loop.a
            self.drive = layout.row(loop.drive)
            disturbed = loop.disturbed
            for k in range(loop.fed.shape[1]):
                self.rates[:n] += np.outer(loop.fed[:, k], layout.commanded(k))
            self.asked = self.over_states(loop.asked)
            sign = layout.level("sign")
            if sign is not None:
                self.asked[sign] += friction_ahead
            self.integrated = self.over_states(loop.integrated)
        for k, push in enumerate(pushes):
            self.rates[: len(disturbed)] += np.outer(disturbed[:, k], push)

    def over_states(self, row: FloatArray) -> FloatArray:
        """Return a row over (x, p) as one over z."""
        n = 0 if self.loop is None else len(self.loop.a)
        whole = self.layout.row(row[:n])
        for k, gain in enumerate(row[n:]):
            whole += gain * self.layout.commanded(k)
        return whole

    def kinds(self) -> tuple[Mode, ...]:
        """Return all modes; the first is that at the start."""
        frictions = (0,) if self.axis.friction is None else (0, 1, -1)
        limited = self.loop is not None and self.axis.torque_limit < inf
        limits = (0, 1, -1) if limited else (0,)
        pieces = range(self.axis.ripple.count if self.axis.ripple else 1)
        integrals: tuple[int, ...] = (0,)
        if self.loop is not None and isinstance(self.controller.anti_windup, Clamp):
            integrals = (0, 1, -1)
        kinds = [Mode(*kind) for kind in product(frictions, limits, integrals, pieces)]
        if limited and self.controller.anti_windup == "conditional":
            kinds += [Mode(*kind) for kind in product(frictions, (1, -1), (1, 2), pieces)]
        return tuple(kinds)

    def mode(self, mode: Mode) -> _Part:
        """Return what a mode is made of."""
        layout, one = self.layout, self.layout.unit(self.layout.one)
        torque = self.asked
        if mode.limit:
            torque = mode.limit * self.axis.torque_limit * one
        rates = self.rates + np.outer(self.drive[: layout.moving], torque)
        guards = self.limit_guards(mode, one) + self.rippling(mode, rates, one)
        guards += self.integral(mode, rates, torque, one)
        pushing = np.zeros(layout.size)
        if self.axis.friction is not None:
            pushing, more = self.friction(mode, rates, one)
            guards = more + guards
        return _Part(rates, guards, torque, pushing)

    def rippling(self, mode: Mode, rates: FloatArray, one: FloatArray) -> list[_Guard]:
        """Add a straight line of the ripple to the rates; return guards at both its ends."""
        ripple, place = self.axis.ripple, self.layout.level("ripple")
        if ripple is None or place is None:
            return []
        turns, line = self.layout.unit(place), mode.ripple
        position = self.layout.row(self.axis.dynamics.motor) - turns
        offset, slope = ripple.lines()[line]
        rates += np.outer(self.kick[: self.layout.moving], offset * one + slope * position)
        if self.axis.friction is not None and mode.friction == 0:
            return []
        low, high = ripple.edges[line : line + 2]
        after, before = (line + 1) % ripple.count, (line - 1) % ripple.count
        period = ripple.period * turns
        return [
            _Guard(high * one - position, mode._replace(ripple=after), period * (after == 0), one),
            _Guard(position - low * one, mode._replace(ripple=before), -period * (line == 0), one),
        ]

    def limit_guards(self, mode: Mode, one: FloatArray) -> list[_Guard]:
        if self.loop is None or self.axis.torque_limit == inf:
            return []
        limit = self.axis.torque_limit * one
        inside = 0 if self.controller.anti_windup == "conditional" else mode.integral
        if mode.limit and mode.integral != 2:
            back = mode._replace(limit=0, integral=inside)
            if mode.integral == 1 and self.controller.anti_windup == "conditional":
                return [self.onto_the_limit(mode, one)]
            return [_Guard(mode.limit * self.asked - limit, back)]
        if mode.limit:
            return []
        return [
            _Guard(limit - sign * self.asked, mode._replace(limit=sign, integral=inside))
            for sign in (1, -1)
        ]

    def integral(
        self, mode: Mode, rates: FloatArray, torque: FloatArray, one: FloatArray
    ) -> list[_Guard]:
        """Change the integral's rate in place; return guards of what keeps it from winding up."""
        if self.loop is None:
            return []
        place, way, ki = self.loop.integral, self.controller.anti_windup, self.integral_gain
        if isinstance(way, BackCalculation) and mode.limit and ki:
            rates[place] += (torque - self.asked) / (way.tracking_time * ki)
        if isinstance(way, Clamp) and ki:
            return self.clamped(mode, rates, way.integral_limit * one)
        if way != "conditional" or not mode.limit:
            return []
        outward = mode.limit * np.sign(ki or 1.0) * self.integrated
        if not mode.integral:
            return [_Guard(-outward, mode._replace(integral=1))]
        rates[place] = 0.0
        if mode.integral == 1:
            return [_Guard(outward, mode._replace(integral=0))]
        return self.along_the_limit(mode, rates, one)

    def along_the_limit(self, mode: Mode, rates: FloatArray, one: FloatArray) -> list[_Guard]:
        """Let the integral keep the torque on the limit; return guards of when that is over."""
        assert self.loop is not None
        ki, moving = self.integral_gain, self.layout.moving
        drift = self.asked[:moving] @ rates
        rates[self.loop.integral] = -drift / ki
        beyond = mode.limit * self.asked - self.axis.torque_limit * one
        slack = _ON_LIMIT * self.axis.torque_limit * one
        inside, held = mode._replace(limit=0, integral=0), mode._replace(integral=1)
        return [
            _Guard(mode.limit * (drift + ki * self.integrated), inside),
            _Guard(-mode.limit * drift, held),
            _Guard(slack + beyond, inside),
            _Guard(slack - beyond, held),
        ]

    def onto_the_limit(self, mode: Mode, one: FloatArray) -> _Guard:
        """Return the guard beyond which the integral brings the torque exactly to its limit."""
        assert self.loop is not None
        off = mode.limit * self.axis.torque_limit * one - self.asked
        share = self.layout.unit(self.loop.integral) / self.integral_gain
        return _Guard(-mode.limit * off, mode._replace(integral=2), share, off)

    def clamped(self, mode: Mode, rates: FloatArray, most: FloatArray) -> list[_Guard]:
        assert self.loop is not None
        ki = self.integral_gain
        share = ki * self.layout.unit(self.loop.integral)
        if mode.integral:
            rates[self.loop.integral] = 0.0
            return [_Guard(mode.integral * ki * self.integrated, mode._replace(integral=0))]
        return [_Guard(most - sign * share, mode._replace(integral=sign)) for sign in (1, -1)]

    @property
    def integral_gain(self) -> float:
        return self.controller.integral_gain

    def friction(
        self, mode: Mode, rates: FloatArray, one: FloatArray
    ) -> tuple[FloatArray, list[_Guard]]:
        """Change rates in place; return the torque to be held and the guards."""
        friction = self.axis.friction
        assert friction is not None
        moving = self.layout.moving
        mobility = float(self.velocity @ self.kick)
        pushing = (self.velocity[:moving] @ rates) / mobility
        kick = self.kick[:moving]
        if mode.friction:
            rates -= np.outer(kick, mode.friction * friction.coulomb * one)
            stop = -self.kick / mobility  # takes the motor's velocity away
            stuck = mode._replace(friction=0)
            return pushing, [_Guard(mode.friction * self.velocity, stuck, stop, self.velocity)]
        rates -= np.outer(kick, pushing)
        rates[np.flatnonzero(self.velocity)] = 0.0
        holds = friction.holds * one
        return pushing, [
            _Guard(holds - sign * pushing, mode._replace(friction=sign)) for sign in (1, -1)
        ]
