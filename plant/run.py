"""Runs of a servo loop, exact from event to event."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf
from typing import Any

import numpy as np

from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import shown
from .axis import Axis
from .commands import Command, breaks_of, derivatives_of, highest_order, on_breaks, sines_of
from .controller import Controller
from .disturbances import Disturbance
from .feedforward import Feedforward
from .hybrid import Hybrid
from .layout import Layout
from .signal_pieces import TERMS, Pieces

MOST_SAMPLES = 1e8
"""Of a digital controller in a response."""
_COUNTS = 1e-20  # of a term of the Taylor series: smaller ones are nothing
_AT_ONCE = 512  # pieces: their numbers stay in the cache, their product in one thread
_SAME = 1e-13  # times this near to one another, relative to the longest, are one


@dataclass(frozen=True, eq=False)
class Scene:
    """What is simulated: an axis under a controller, its command and what disturbs it.

    Attributes
    ----------
    axis : Axis
    controller : Controller
    feedforward : Feedforward
    command : Command
    start : float
        Measured position at the start, at rest.
    begin, duration : float
        Time of the command at the start of the run, and its length.
    disturbances : tuple
    noise : (samples,) array or None
        Added to what is measured, of a digital controller.
    """

    axis: Axis
    controller: Controller
    feedforward: Feedforward
    command: Command
    start: float
    begin: float
    duration: float
    disturbances: tuple[Disturbance, ...] = ()
    noise: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse more samples than can be taken, before anything is made of their size."""
        samples_within(self.duration, self.controller.sample_time or inf)

    @property
    def is_digital(self) -> bool:
        """Whether the controller runs once a sample."""
        return self.controller.sample_time is not None

    @property
    def sample_count(self) -> int:
        """Samples of a digital controller before the end."""
        dt = self.controller.sample_time
        return 0 if dt is None else samples_within(self.duration, dt)


def samples_within(duration: float, dt: float) -> int:
    """Return how many samples a digital controller takes before the end of a response."""
    if duration > MOST_SAMPLES * dt:
        raise ValueError(
            f"duration = {shown(duration)} makes {duration / dt:.3g} samples of {shown(dt)}: "
            f"expected at most {MOST_SAMPLES:.0e}; respond for a shorter time"
        )
    return max(ceil(duration / dt * (1.0 - 1e-12)), 1)


@dataclass(frozen=True, eq=False)
class Run:
    """The exact motion of a loop: on from each of `times`, z(t) = e^(rates[mode]·(t − time))·z.

    Attributes
    ----------
    scene : Scene
    hybrid : Hybrid
    layout : Layout
    times : (S,) array
        From 0; the last is the end.
    modes : (S,) array of int
    states : (S, n) array
    samples : (N, 3) array
        Error e, torque asked for w, and the torque u of each sample of a digital controller.
    held : float
        Torque of the controller's integral at the end, before the filters.
    memory : (4 + 2·m,) array
        State of a digital controller at the end, as `memory_at_rest` lists it.
    fastest : float
        A bound of the rates, balanced.
    """

    scene: Scene
    hybrid: Hybrid
    layout: Layout
    times: FloatArray
    modes: Any
    states: FloatArray
    samples: FloatArray
    held: float
    memory: FloatArray
    fastest: float

    @cached_property
    def terms(self) -> int:
        """How many terms of the Taylor series count from one of the times to the next."""
        command = self.scene.command
        rates = [self.fastest, *(sine.omega for sine in sines_of(command))]
        step = max(rates) * float(np.diff(self.times).max(initial=0.0))
        size, count = 1.0, highest_order(command) + 1
        for k in range(1, TERMS):
            size *= step / k
            count = max(count, k + 1 if size > _COUNTS else 1)
        return min(count, TERMS)

    def at(self, times: FloatArray) -> tuple[Any, FloatArray]:
        """Return the modes and states (N, n) at times from 0 on; at an event those after it."""
        slack = _SAME * self.times[-1]
        index = np.searchsorted(self.times, times + slack, side="right") - 1
        index = np.clip(index, 0, len(self.times) - 1)
        modes, states = self.modes[index], self.states[index].copy()
        ahead = times - self.times[index]
        self.advance(states, modes, np.where(ahead > slack, ahead, 0.0))
        return modes, states

    def advance(self, states: FloatArray, modes: Any, ahead: FloatArray) -> None:
        """Move states on in place, each by its time, which is at most a step."""
        moving = self.layout.moving
        for mode in np.unique(modes[ahead > 0.0]):
            some = np.flatnonzero((modes == mode) & (ahead > 0.0))
            term, total = states[some].T.copy(), states[some].T.copy()
            for k in range(1, self.terms + 4):
                after = (self.hybrid.rates[mode] @ term) * (ahead[some] / k)
                term[:moving], term[moving:] = after, 0.0
                total[:moving] += after
            states[some] = total.T

    @cached_property
    def load_row(self) -> FloatArray:
        """Row of the load's position."""
        return self.layout.row(self.scene.axis.dynamics.load)

    @cached_property
    def seen_row(self) -> FloatArray:
        """Row of the measured position."""
        d = self.scene.axis.dynamics
        return self.layout.row(d.motor if self.scene.axis.sensor == "motor" else d.load)

    @cached_property
    def torque_rows(self) -> FloatArray:
        """Rows of the motor's torque, one a mode."""
        d = self.scene.axis.dynamics
        return np.array(
            [self.layout.row(d.torque[:-1]) + d.torque[-1] * row for row in self.hybrid.torque]
        )

    def last_outside(
        self, row: FloatArray, command: float, target: float, tolerance: float
    ) -> float:
        """Return when |command·r(t) + row·z(t) − target| is beyond a tolerance for the last time.

        0 where it never is, infinite where it is so at the end. Only the pieces in which that may
        be are made.
        """
        times, _, states = self._known(command)
        count = len(times) - 1
        off = states[:count] @ row - target
        if command:
            off += command * self._commanded[0]
        outside = np.flatnonzero(np.abs(off) > tolerance)
        begin = max(int(outside[-1]) - 1, 0) if outside.size else 0
        end = count if command else self._calm_from(row, target, tolerance, begin)
        return self.pieces(row, command, target, part=(begin, end)).last_outside(tolerance)

    def _calm_from(self, row: FloatArray, target: float, tolerance: float, begin: int) -> int:
        """Return from which piece on, `begin` or later, row·z(t) − target is within a tolerance.

        A piece Σ c_k·τ^k, τ from 0 to 1, is beyond its ends by at most Σ k·(k − 1)/8·|c_k|, and
        |c_k| ≤ |row·A^k|·|z|·h^k/k!, with h the longest piece. One more is left for rounding.
        """
        states = self.states[begin:]
        longest, most = float(np.diff(self.times).max(initial=0.0)), np.zeros(len(row))
        for mode in np.flatnonzero(np.bincount(self.modes[begin:-1])):
            rates, term, size, total = self.hybrid.rates[mode], row, 1.0, np.zeros(len(row))
            for k in range(1, self.terms):
                term, size = term[: self.layout.moving] @ rates, size * longest / k
                total += k * (k - 1) / 8.0 * size * np.abs(term)
            most = np.maximum(most, total)
        off, beyond = np.abs(states @ row - target), np.abs(states[:-1]) @ most
        maybe = np.flatnonzero(np.maximum(off[:-1], off[1:]) + beyond > tolerance)
        last = int(maybe[-1]) if maybe.size else 0
        return min(begin + last + 2, len(self.times) - 1)

    def pieces(
        self,
        row: FloatArray,
        command: float,
        target: float = 0.0,
        *,
        part: tuple[int, int] | None = None,
    ) -> Pieces:
        """Return command·r(t) + row·z(t) − target as polynomials from one time to the next.

        With `part` only the pieces from the first of two numbers to before the second.
        """
        times, modes, states = self._known(command)
        begin, end = part or (0, len(times) - 1)
        times, modes, states = times[begin : end + 1], modes[begin:end], states[begin:end]
        rows = np.empty((self.terms, len(times) - 1))
        for mode in np.flatnonzero(np.bincount(modes)):
            terms = [row]
            for _ in range(self.terms - 1):
                terms.append(terms[-1][: self.layout.moving] @ self.hybrid.rates[mode])
            within, matrix = np.flatnonzero(modes == mode), np.array(terms)
            for some in np.split(within, range(_AT_ONCE, len(within), _AT_ONCE)):
                rows[:, some] = matrix @ states[some].T
        if command:
            rows[: len(self._commanded)] += command * self._commanded[:, begin:end]
        rows[0] -= target
        return Pieces(times[:-1], np.diff(times), rows)

    def _known(self, command: float) -> tuple[FloatArray, Any, FloatArray]:
        """Return times, modes and states; where a command counts, at its breaks too."""
        return self._split if command else (self.times, self.modes, self.states)

    @cached_property
    def _split(self) -> tuple[FloatArray, Any, FloatArray]:
        """Return times, those of the command's breaks among them, modes and states."""
        breaks = breaks_of(self.scene.command) - self.scene.begin
        inner = breaks[(breaks > 0.0) & (breaks < self.times[-1])]
        times = np.unique(np.concatenate([self.times, inner]))
        return times, *self.at(times[:-1])

    @cached_property
    def _commanded(self) -> FloatArray:
        """Return the command and its derivatives at those times, as many as it has."""
        command = self.scene.command
        at = on_breaks(command, self.scene.begin + self._split[0][:-1])
        last = self.terms - 1 if sines_of(command) else min(highest_order(command), self.terms - 1)
        return derivatives_of(command, at, last)
