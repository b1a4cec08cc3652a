"""Runs of a servo loop, exact from event to event, and what is read from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf
from typing import Any

import numpy as np

from .. import core
from ..shaping.checks import positive
from ..shaping.pieces import FloatArray, extrema
from ..shaping.propagate import grid
from ..shaping.real_numbers import real_array, shown
from .axis import Axis
from .commands import Command, breaks_of, derivatives_of
from .controller import Controller
from .core_numbers import TERMS, fastest, memory_at_rest, sampled_steps, tuning
from .disturbances import Disturbance
from .feedforward import Feedforward
from .hybrid import Hybrid, hybrid_of
from .layout import Layout, at_rest, layout_of
from .loop_response import LoopResponse
from .open_loop import open_loop

_ON_BREAK = 1e-12  # a sample this near to a break, relative to its time, has the value after it


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

    @property
    def is_digital(self) -> bool:
        """Whether the controller runs once a sample."""
        return self.controller.sample_time is not None

    @property
    def sample_count(self) -> int:
        """Samples of a digital controller before the end."""
        dt = self.controller.sample_time
        return 0 if dt is None else max(ceil(self.duration / dt * (1.0 - 1e-12)), 1)

    def run(self) -> Run:
        """Simulate it."""
        return simulate(self)


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
    """

    scene: Scene
    hybrid: Hybrid
    layout: Layout
    times: FloatArray
    modes: Any
    states: FloatArray
    samples: FloatArray

    def at(self, times: FloatArray) -> tuple[Any, FloatArray]:
        """Return the modes and states (N, n) at times from 0 on; at an event those after it."""
        index = np.searchsorted(self.times, times + _ON_BREAK, side="right") - 1
        index = np.clip(index, 0, len(self.times) - 1)
        modes, states = self.modes[index], self.states[index].copy()
        ahead = times - self.times[index]
        self._advance(states, modes, np.where(ahead > _ON_BREAK, ahead, 0.0))
        return modes, states

    def _advance(self, states: FloatArray, modes: Any, ahead: FloatArray) -> None:
        """Move states on in place, each by its time, which is at most a step."""
        moving = self.layout.moving
        for mode in np.unique(modes[ahead > 0.0]):
            some = np.flatnonzero((modes == mode) & (ahead > 0.0))
            term, total = states[some].T.copy(), states[some].T.copy()
            for k in range(1, TERMS + 4):
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

    def pieces(self, row: FloatArray, command: float, target: float = 0.0) -> Pieces:
        """Return command·r(t) + row·z(t) − target as polynomials from one time to the next."""
        breaks = breaks_of(self.scene.command) - self.scene.begin
        end = self.times[-1]
        inner = breaks[(breaks > 0.0) & (breaks < end)]
        times = np.unique(np.concatenate([self.times, inner])) if command else self.times
        modes, states = self.at(times[:-1])
        rows = np.empty((TERMS, len(times) - 1))
        for mode in np.unique(modes):
            some, terms = np.flatnonzero(modes == mode), [row]
            for _ in range(TERMS - 1):
                terms.append(terms[-1][: self.layout.moving] @ self.hybrid.rates[mode])
            rows[:, some] = np.array(terms) @ states[some].T
        if command:
            at = on_breaks(self.scene.command, self.scene.begin + times[:-1])
            rows += command * derivatives_of(self.scene.command, at, TERMS - 1)
        rows[0] -= target
        return Pieces(times[:-1], np.diff(times), rows)


@dataclass(frozen=True, eq=False)
class Pieces:
    """A signal in pieces, given by its derivatives at the start of each, (TERMS, m)."""

    times: FloatArray
    durations: FloatArray
    rows: FloatArray

    @cached_property
    def scaled(self) -> FloatArray:
        """Coefficients of powers of the part of a piece that has passed."""
        powers = np.cumprod(
            np.vstack(
                [np.ones_like(self.durations)] + [self.durations / k for k in range(1, TERMS)]
            ),
            axis=0,
        )
        return np.asarray(self.rows * powers)

    @cached_property
    def bounds(self) -> FloatArray:
        """What the magnitude does not exceed in each piece."""
        return np.asarray(np.abs(self.scaled).sum(axis=0))

    def peak(self) -> float:
        """Return the largest magnitude."""
        if not self.times.size:
            return 0.0
        ends = np.maximum(np.abs(self.rows[0]), np.abs(self.scaled.sum(axis=0)))
        known = float(ends.max())
        some = np.flatnonzero(self.bounds > known)
        if some.size:
            kept = self._terms(some)
            low, high = extrema(np.ones(some.size), kept)
            known = max(known, float(high.max()), -float(low.min()))
        return known

    def _terms(self, some: Any) -> FloatArray:
        """Return derivatives on pieces of length 1, as many as count."""
        scaled = self.scaled[:, some]
        sizes = np.abs(scaled).max(axis=1)
        count = int(np.flatnonzero(sizes > 1e-18 * sizes.max())[-1]) + 1 if sizes.max() else 1
        factorials = np.cumprod(np.append(1.0, np.arange(1.0, count)))
        return np.asarray(scaled[:count] * factorials[:, None])

    def last_outside(self, tolerance: float) -> float:
        """Return the last time at which the magnitude exceeds a tolerance.

        0 where it never does, infinite where it does so at the end.
        """
        for i in np.flatnonzero(self.bounds > tolerance)[::-1]:
            part = self._last_part_outside(self.scaled[:, i], tolerance)
            if part is not None:
                at_end = i == len(self.times) - 1 and part >= 1.0
                return inf if at_end else float(self.times[i] + part * self.durations[i])
        return 0.0

    @staticmethod
    def _last_part_outside(coefficients: FloatArray, tolerance: float) -> float | None:
        """Return the last part of a piece with a magnitude beyond the tolerance, 1 for its end."""
        if abs(coefficients.sum()) > tolerance:
            return 1.0
        roots: list[float] = []
        for level in (tolerance, -tolerance):
            shifted = coefficients.copy()
            shifted[0] -= level
            roots += _roots_between(shifted)
        for root in sorted(roots, reverse=True):
            before = root - 1e-9 * max(root, 1e-3)
            if abs(np.polyval(coefficients[::-1], before)) > tolerance:
                return root
        return 0.0 if abs(coefficients[0]) > tolerance else None


def _roots_between(coefficients: FloatArray) -> list[float]:
    """Return real roots in [0, 1], polished by Newton's iteration."""
    sizes = np.abs(coefficients)
    count = int(np.flatnonzero(sizes > 1e-19 * sizes.max())[-1]) + 1
    polynomial = coefficients[:count][::-1]
    slope = np.polyder(polynomial)
    found = []
    for root in np.roots(polynomial):
        x = float(root.real)
        if abs(root.imag) > 1e-6 or not -1e-6 <= x <= 1.0 + 1e-6:
            continue
        for _ in range(4):
            rate = float(np.polyval(slope, x))
            x -= float(np.polyval(polynomial, x)) / rate if rate else 0.0
        if 0.0 <= x <= 1.0:
            found.append(x)
    return found


def on_breaks(command: Command, times: FloatArray) -> FloatArray:
    """Return times, those that rounding has parted from a break of the command on it."""
    breaks = breaks_of(command)
    nearest = breaks[np.clip(np.searchsorted(breaks, times), 0, len(breaks) - 1)]
    before = breaks[np.clip(np.searchsorted(breaks, times) - 1, 0, len(breaks) - 1)]
    slack = _ON_BREAK * np.maximum(np.abs(times), 1e-3)
    times = np.where(np.abs(times - nearest) <= slack, nearest, times)
    return np.asarray(np.where(np.abs(times - before) <= slack, before, times))


def simulate(scene: Scene) -> Run:
    """Run a scene in the core."""
    axis, controller = scene.axis, scene.controller
    loop = None if scene.is_digital else open_loop(axis, controller, scene.feedforward)
    states = axis.dynamics.size if loop is None else len(loop.a)
    layout = layout_of(
        states,
        scene.disturbances,
        None if scene.is_digital else scene.command,
        signed=loop is not None and scene.feedforward.friction > 0.0,
    )
    hybrid = hybrid_of(axis, controller, layout, loop, scene.feedforward.friction)
    rest, holding = at_rest(axis, scene.start)
    initial = np.append(rest, np.zeros(states - len(rest)))
    if loop is not None and holding and controller.integral_gain:
        initial[loop.integral] = holding / controller.integral_gain
    z = layout.initial(initial)
    memory = np.zeros(4)
    if scene.is_digital:
        z[layout.held], memory = holding, memory_at_rest(controller, holding)
    times, values = layout.settings(scene.begin, scene.duration)
    commands, ahead = _sampled_command(scene)
    samples = np.zeros((len(commands), 3))
    numbers, tuned, sections = _numbers(scene, layout, hybrid, len(commands), len(times))
    d = axis.dynamics
    seen = d.motor if axis.sensor == "motor" else d.load
    moved = d.load if axis.sensor == "load" else d.motor
    highest = int(tuned[3])
    segments, mode, status = core.run_loop(
        numbers,
        tuned,
        *map(np.ascontiguousarray, (hybrid.rates, hybrid.rows, hybrid.next)),
        *(hybrid.onto, hybrid.along, z, layout.row(seen), layout.row(moved), sections),
        scene.feedforward.position_gains(highest),
        scene.feedforward.torque_gains(highest),
        *(commands, ahead, np.empty(0) if scene.noise is None else scene.noise),
        *(times, values, memory, samples),
    )
    if status == core.CHATTER:
        raise ValueError(
            f"the loop's modes change for ever at t = {segments[-1, 0]:.6g}: the anti-windup holds "
            "and releases the integral at the limit; use BackCalculation, or a sample time"
        )
    if status != core.OK or not np.isfinite(z).all():
        raise ValueError(
            f"the response leaves the range of a double within {scene.duration!r}: the loop is "
            "unstable; shorten the duration"
        )
    return Run(
        scene,
        hybrid,
        layout,
        np.append(segments[:, 0], scene.duration),
        np.append(segments[:, 1], mode).astype(int),
        np.vstack([segments[:, 2:], z]),
        samples,
    )


def _sampled_command(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the command and its derivatives at all samples, and the same a lead later."""
    dt, f = scene.controller.sample_time, scene.feedforward
    highest = max(f.order, 1)
    if dt is None:
        return np.empty((0, highest + 1)), np.empty((0, highest + 1))
    times = on_breaks(scene.command, scene.begin + dt * np.arange(float(scene.sample_count)))
    now = np.ascontiguousarray(derivatives_of(scene.command, times, highest).T)
    if not f.lead:
        return now, now
    later = on_breaks(scene.command, np.asarray(times + f.lead))
    return now, np.ascontiguousarray(derivatives_of(scene.command, later, highest).T)


def _numbers(
    scene: Scene, layout: Layout, hybrid: Hybrid, samples: int, settings: int
) -> tuple[list[float], list[float], FloatArray]:
    """Return the numbers of loop and controller, and the filters' sections, for the core."""
    c = scene.controller
    steps = _steps(scene, layout, hybrid)
    numbers = [layout.size, layout.moving, len(hybrid.modes), hybrid.rows.shape[1], *steps, 0]
    numbers += [scene.duration, c.delay, samples, layout.held]
    numbers += [settings, layout.chain, layout.held - layout.chain]
    tuned = tuning(c, scene.feedforward, scene.axis.torque_limit, scene.axis.encoder_step)
    sections = c.sections if scene.is_digital else np.empty((0, 5))
    return [float(x) for x in numbers], tuned, sections


def _steps(scene: Scene, layout: Layout, hybrid: Hybrid) -> tuple[float, float]:
    """Return two lengths of steps, the longer first, in which the Taylor series is exact."""
    norm = fastest(layout, hybrid)
    if scene.controller.sample_time is None:
        longest = min(2.0 / norm if norm else inf, scene.duration)
        return longest, longest
    return sampled_steps(norm, scene.controller.sample_time, scene.controller.delay)


def response_of(scene: Scene, dt: float | None, times: Any) -> LoopResponse:
    """Run a scene and return its response on a grid, or at times."""
    if times is not None:
        grid_times = real_array("times", times)
        rising = grid_times.ndim == 1 and bool((np.diff(grid_times) >= 0.0).all())
        if not rising or not grid_times.size or grid_times[0] < scene.begin:
            raise ValueError(
                f"times = {shown(times)}: expected increasing times, none before the start at "
                f"{scene.begin!r}"
            )
    elif dt is None:
        raise ValueError("dt is missing: give the spacing of the time grid, or times=…")
    else:
        grid_times = grid(scene.begin, scene.duration, positive("dt", dt))
    run = scene.run()
    modes, states = run.at(grid_times - scene.begin)
    inputs = derivatives_of(scene.command, on_breaks(scene.command, grid_times), 2)
    d = scene.axis.dynamics
    twist = run.layout.row(d.load - d.motor)
    position, load = states @ run.seen_row, states @ run.load_row
    torque, behind = run.hybrid.torque[modes], run.torque_rows[modes]
    outputs = [position, inputs[0] - position, (states * torque).sum(axis=1)]
    outputs += [load, states @ twist, (states * behind).sum(axis=1)]
    response = LoopResponse(grid_times, inputs, np.array(outputs), states.T, scene=scene)
    vars(response)["run"] = run  # what was simulated is kept
    return response
