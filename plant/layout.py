"""Where the states of a simulated loop are, and how signals are made of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ..shaping import Trajectory
from ..shaping.pieces import FloatArray
from ..shaping.roots import root_between
from .axis import Axis
from .commands import Command, Sine, Sum, breaks_of, derivatives_of, sines_of
from .disturbances import Disturbance, TorqueSine


@dataclass(frozen=True, eq=False)
class Layout:
    """States of loop, sines and command's chain; then held ones, the chain's end, levels, u and 1.

    Attributes
    ----------
    loop : int
        States of the axis, and of a continuous controller.
    disturbances : tuple
    sines : tuple of Sine
        Of the command, where a continuous controller takes it.
    polynomial : Sum or None
        The rest of the command.
    order : int
        Of its chain of derivatives; −1 without.
    set : tuple of str
        What else is set at times: "motor" and "load", the torques held on them; "sign", that of the
        command's rate; or by events, "ripple", how far its table is shifted.
    digital : bool
        Whether a controller's torque is held.
    """

    loop: int
    disturbances: tuple[Disturbance, ...]
    sines: tuple[Sine, ...] = ()
    polynomial: Sum | None = None
    order: int = -1
    set: tuple[str, ...] = ()
    digital: bool = False

    @cached_property
    def oscillators(self) -> list[TorqueSine | Sine]:
        """All sines, two states each."""
        return [d for d in self.disturbances if isinstance(d, TorqueSine)] + list(self.sines)

    @cached_property
    def chain(self) -> int:
        """Place of the command's polynomial part, its derivatives after it."""
        return self.loop + 2 * len(self.oscillators)

    @cached_property
    def moving(self) -> int:
        """How many states move."""
        return self.chain + max(self.order, 0)

    @cached_property
    def levels(self) -> int:
        """Place of the first signal that is held and set at times."""
        return self.chain + self.order + 1

    def level(self, signal: str) -> int | None:
        """Return the place of a held signal; None where it is always 0."""
        return self.levels + self.set.index(signal) if signal in self.set else None

    @cached_property
    def held(self) -> int:
        """Place of a digital controller's torque; then, or there, comes what is always 1."""
        return self.levels + len(self.set)

    @cached_property
    def one(self) -> int:
        """Place of the state that is always 1."""
        return self.held + self.digital

    @cached_property
    def size(self) -> int:
        """Number of states."""
        return self.one + 1

    def row(self, values: FloatArray | None = None) -> FloatArray:
        """Return a row of zeros, or of values of the loop's first states."""
        row = np.zeros(self.size)
        if values is not None:
            row[: len(values)] = values
        return row

    def unit(self, place: int) -> FloatArray:
        """Return the row of one state."""
        row = np.zeros(self.size)
        row[place] = 1.0
        return row

    def disturbing(self, on: str, constant: float) -> FloatArray:
        """Return the row of the torque that disturbs motor or load."""
        row, place = constant * self.unit(self.one), self.level(on)
        if place is not None:
            row[place] = 1.0
        for i, sine in enumerate(self.oscillators):
            if isinstance(sine, TorqueSine) and sine.on == on:
                row[self.loop + 2 * i] = sine.amplitude
        return row

    def commanded(self, k: int) -> FloatArray:
        """Return the row of derivative k of the command."""
        row = np.zeros(self.size)
        if k <= self.order:
            row[self.chain + k] = 1.0
        for i, sine in enumerate(self.oscillators):
            if isinstance(sine, Sine):
                sign = (1.0, 1.0, -1.0, -1.0)[k % 4]
                row[self.loop + 2 * i + k % 2] = sign * sine.amplitude * sine.omega**k
        return row

    def own_rates(self) -> FloatArray:
        """Return the rates of sines and chain, (moving, size), those of the loop 0."""
        rates = np.zeros((self.moving, self.size))
        for i, sine in enumerate(self.oscillators):
            at = self.loop + 2 * i
            rates[at, at + 1], rates[at + 1, at] = sine.omega, -sine.omega
        for k in range(max(self.order, 0)):
            rates[self.chain + k, self.chain + k + 1] = 1.0
        return rates

    def initial(self, loop: FloatArray) -> FloatArray:
        """Return the state at the start, but for what settings set at time 0."""
        z = self.row(loop)
        for i in range(len(self.oscillators)):
            z[self.loop + 2 * i + 1] = 1.0
        z[self.one] = 1.0
        return z

    def settings(self, start: float, duration: float) -> tuple[FloatArray, FloatArray]:
        """Return times and what is set then from the chain on, NaN for what stays."""
        width = self.held - self.chain
        rows: dict[float, FloatArray] = {}

        def at(time: float) -> FloatArray:
            return rows.setdefault(time, np.full(width, np.nan))

        if self.polynomial is not None:
            breaks = breaks_of(self.polynomial) - start
            times = np.unique(np.append(0.0, breaks[(breaks > 0.0) & (breaks < duration)]))
            values = derivatives_of(self.polynomial, start + times, self.order).T
            for time, value in zip(times, values, strict=True):
                at(float(time))[: self.order + 1] = value
        for signal in (name for name in self.set if name != "ripple"):
            place = (self.level(signal) or 0) - self.chain
            for time, value in self._changes(signal, start, duration):
                if time < duration:
                    at(max(time, 0.0))[place] = value
        times = np.array(sorted(rows))
        return times, np.array([rows[time] for time in times]).reshape(len(times), width)

    def _changes(self, signal: str, start: float, duration: float) -> list[tuple[float, float]]:
        if signal == "sign":
            return _signs(self.whole, start, duration)
        return _levels(self.disturbances, signal)

    @property
    def whole(self) -> Sum:
        """The command."""
        rest = () if self.polynomial is None else self.polynomial.parts
        return Sum((*rest, *self.sines))


def layout_of(
    states: int,
    disturbances: tuple[Disturbance, ...],
    command: Command | None,
    *,
    signed: bool,
    rippling: bool,
) -> Layout:
    """Return the layout of a loop; without a command a digital one's.

    `signed` for a continuous one that takes the sign of the command's rate, `rippling` for a
    motor with ripple, of which it is held how many periods the motor is beyond the table.
    """
    held = {d.on for d in disturbances if not isinstance(d, TorqueSine)}
    signals: tuple[str, ...] = tuple(on for on in ("motor", "load") if on in held)
    signals += ("ripple",) * rippling
    if command is None:
        return Layout(states, disturbances, set=signals, digital=True)
    signals += ("sign",) * signed
    parts = command.parts if isinstance(command, Sum) else (command,)
    sines = tuple(part for part in parts if isinstance(part, Sine))
    rest = tuple(part for part in parts if not isinstance(part, Sine))
    if not rest:
        return Layout(states, disturbances, sines, set=signals)
    order = max(part.order if isinstance(part, Trajectory) else 1 for part in rest)
    return Layout(states, disturbances, sines, Sum(rest), order, signals)


def _levels(disturbances: tuple[Disturbance, ...], on: str) -> list[tuple[float, float]]:
    """Return times and the sum of all held torques from each on."""
    parts = [d.levels() for d in disturbances if not isinstance(d, TorqueSine) and d.on == on]
    if not parts:
        return []
    times = np.unique(np.concatenate([at for at, _ in parts]))
    total = np.zeros_like(times)
    for at, levels in parts:
        index = np.searchsorted(at, times, side="right")
        total += np.append(0.0, levels)[index]
    return list(zip(times.tolist(), total.tolist(), strict=True))


def _signs(command: Any, start: float, duration: float) -> list[tuple[float, float]]:
    """Return times and the sign of the command's rate from each on."""
    edges = rate_zeros(command, start, duration)
    middles = 0.5 * (edges[1:] + edges[:-1])
    rates = derivatives_of(command, start + middles, 1)[1]
    return list(zip(edges[:-1].tolist(), np.sign(rates).tolist(), strict=True))


def rate_zeros(command: Command, start: float, duration: float) -> FloatArray:
    """Return times from 0 to `duration` between which the command's rate keeps its sign."""
    breaks = breaks_of(command) - start
    fastest = max((s.frequency_hz for s in sines_of(command)), default=0.0)
    fine = np.linspace(0.0, duration, int(8.0 * fastest * duration) + 2)
    edges = np.unique(np.concatenate([fine, breaks[(breaks > 0.0) & (breaks < duration)]]))
    found = [edges]
    for left, right in pairwise(edges.tolist()):
        inside = np.linspace(left, right, 18)[1:-1]  # of pieces of low order, or eighths of a turn
        rate = derivatives_of(command, start + inside, 1)[1]
        for i in np.flatnonzero(rate[1:] * rate[:-1] < 0.0):
            root = root_between(
                lambda t: float(derivatives_of(command, np.array([start + t]), 1)[1, 0]),
                *(inside[i], inside[i + 1]),
            )
            found.append(np.array([root]))
    return np.unique(np.concatenate(found))


def start_of(command: Command) -> tuple[float, float]:
    """Return the time at which a command begins, and where it is then."""
    time = command.start_time if isinstance(command, Trajectory) else 0.0
    return time, float(derivatives_of(command, np.array([time]), 0)[0, 0])


def at_rest(axis: Axis, position: float) -> tuple[FloatArray, float]:
    """Return the axis's states at rest with the measured position given, and the torque it takes.

    The constant load hangs on the springs already, and the drive holds it.
    """
    d = axis.dynamics
    seen = d.motor if axis.sensor == "motor" else d.load
    if position == 0.0 and axis.constant_load == 0.0 and axis.ripple is None:
        return np.zeros(d.size), 0.0
    matrix = np.vstack([np.column_stack([d.a, d.b[:, 0]]), np.append(seen, 0.0)])
    target = np.append(-axis.constant_load * d.b[:, 2], position)
    solved, *_ = np.linalg.lstsq(matrix, target, rcond=None)
    if axis.ripple is not None:
        target[:-1] -= float(axis.ripple(d.motor @ solved[:-1])) * d.b[:, 1]
        solved, *_ = np.linalg.lstsq(matrix, target, rcond=None)
    solved[np.abs(solved) < 1e-15 * np.abs(solved).max()] = 0.0
    return solved[:-1], float(solved[-1])
