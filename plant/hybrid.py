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


class Mode(NamedTuple):
    """Friction sticks (0) or slips (±1); the torque is limited (±1); the integral held (±1).

    The ripple is on a straight line of its table, which it came onto from the other end (±1).
    """

    friction: int = 0
    limit: int = 0
    integral: int = 0
    cell: int = 0
    turned: int = 0


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
    onto, along : (modes, n) arrays
        On entering a mode z ← z + onto·(along·z).
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

    def start(self, axis: Axis, motor: float) -> int:
        """Return the mode in which a run starts, the motor at rest there."""
        cell = 0 if axis.ripple is None else axis.ripple.cell(motor)
        return self.modes.index(self.modes[0]._replace(cell=cell))


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
    for i, part in enumerate(parts):
        for j, (row, target) in enumerate(part.guards):
            rows[i, j], beyond[i, j] = row, number[target]
    onto, along = np.zeros((count, n)), np.zeros((count, n))
    for i, mode in enumerate(kinds):
        if axis.friction is not None and mode.friction == 0:
            onto[i], along[i] = builder.stopping()
        if mode.turned:
            onto[i], along[i] = builder.turning(mode.turned)
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


class _Part(NamedTuple):
    rates: FloatArray
    guards: list[tuple[FloatArray, Mode]]
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
        integrals: tuple[int, ...] = (0,)
        if self.loop is not None and isinstance(self.controller.anti_windup, Clamp):
            integrals = (0, 1, -1)
        kinds = [Mode(*kind) for kind in product(frictions, limits, integrals)]
        if limited and self.controller.anti_windup == "conditional":
            kinds += [Mode(f, s, 1) for f in frictions for s in (1, -1)]
        if self.axis.ripple is None:
            return tuple(kinds)
        last = self.axis.ripple.count - 1
        held = self.axis.friction is not None
        return tuple(
            [kind._replace(cell=cell) for cell in range(last + 1) for kind in kinds]
            + [
                kind._replace(cell=cell, turned=way)
                for cell, way in ((0, 1), (last, -1))
                for kind in kinds
                if kind.friction or not held
            ]
        )

    def mode(self, mode: Mode) -> _Part:
        """Return what a mode is made of."""
        layout, one = self.layout, self.layout.unit(self.layout.one)
        torque = self.asked
        if mode.limit:
            torque = mode.limit * self.axis.torque_limit * one
        rates = self.rates + np.outer(self.drive[: layout.moving], torque)
        cells: list[tuple[FloatArray, Mode]] = []
        if self.axis.ripple is not None:
            cells = self.ripple(mode, rates, one)
            mode = mode._replace(turned=0)
        guards = self.limit_guards(mode, one)
        guards += self.integral(mode, rates, torque, one)
        pushing = np.zeros(layout.size)
        if self.axis.friction is not None:
            pushing, more = self.friction(mode, rates, one)
            guards = more + guards
        return _Part(rates, guards + cells, torque, pushing)

    def limit_guards(self, mode: Mode, one: FloatArray) -> list[tuple[FloatArray, Mode]]:
        if self.loop is None or self.axis.torque_limit == inf:
            return []
        limit = self.axis.torque_limit * one
        inside = 0 if self.controller.anti_windup == "conditional" else mode.integral
        if mode.limit:
            back = mode._replace(limit=0, integral=inside)
            return [(mode.limit * self.asked - limit, back)]
        return [
            (limit - sign * self.asked, mode._replace(limit=sign, integral=inside))
            for sign in (1, -1)
        ]

    def integral(
        self, mode: Mode, rates: FloatArray, torque: FloatArray, one: FloatArray
    ) -> list[tuple[FloatArray, Mode]]:
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
        if mode.integral:
            rates[place] = 0.0
            return [(outward, mode._replace(integral=0))]
        return [(-outward, mode._replace(integral=1))]

    def clamped(
        self, mode: Mode, rates: FloatArray, most: FloatArray
    ) -> list[tuple[FloatArray, Mode]]:
        assert self.loop is not None
        ki = self.integral_gain
        share = ki * self.layout.unit(self.loop.integral)
        if mode.integral:
            rates[self.loop.integral] = 0.0
            return [(mode.integral * ki * self.integrated, mode._replace(integral=0))]
        return [(most - sign * share, mode._replace(integral=sign)) for sign in (1, -1)]

    @property
    def integral_gain(self) -> float:
        return self.controller.integral_gain

    def friction(
        self, mode: Mode, rates: FloatArray, one: FloatArray
    ) -> tuple[FloatArray, list[tuple[FloatArray, Mode]]]:
        """Change rates in place; return the torque to be held and the guards."""
        friction = self.axis.friction
        assert friction is not None
        moving = self.layout.moving
        mobility = float(self.velocity @ self.kick)
        pushing = (self.velocity[:moving] @ rates) / mobility
        kick = self.kick[:moving]
        if mode.friction:
            rates -= np.outer(kick, mode.friction * friction.coulomb * one)
            return pushing, [(mode.friction * self.velocity, mode._replace(friction=0))]
        rates -= np.outer(kick, pushing)
        rates[np.flatnonzero(self.velocity)] = 0.0
        holds = friction.holds * one
        return pushing, [(holds - sign * pushing, mode._replace(friction=sign)) for sign in (1, -1)]

    def ripple(
        self, mode: Mode, rates: FloatArray, one: FloatArray
    ) -> list[tuple[FloatArray, Mode]]:
        """Change rates in place; return the guards at both ends of the ripple's straight line."""
        ripple = self.axis.ripple
        assert ripple is not None
        place = self.layout.level("turns")
        assert place is not None
        position = self.layout.row(self.axis.dynamics.motor) - self.layout.unit(place)
        offset, slope = ripple.lines()[mode.cell]
        rates += np.outer(self.kick[: self.layout.moving], offset * one + slope * position)
        if self.axis.friction is not None and mode.friction == 0:
            return []
        low, high = ripple.edges[mode.cell : mode.cell + 2]
        last = ripple.count - 1
        ahead = mode._replace(cell=0, turned=1)
        behind = mode._replace(cell=last, turned=-1)
        if mode.cell < last:
            ahead = mode._replace(cell=mode.cell + 1, turned=0)
        if mode.cell > 0:
            behind = mode._replace(cell=mode.cell - 1, turned=0)
        return [(high * one - position, ahead), (position - low * one, behind)]

    def turning(self, way: int) -> tuple[FloatArray, FloatArray]:
        """Return what counts a period of the ripple, and its row."""
        assert self.axis.ripple is not None
        place = self.layout.level("turns")
        assert place is not None
        return self.layout.unit(place), way * self.axis.ripple.period * self.layout.unit(
            self.layout.one
        )

    def stopping(self) -> tuple[FloatArray, FloatArray]:
        """Return what takes the motor's velocity away, and its row."""
        return -self.kick / float(self.velocity @ self.kick), self.velocity
