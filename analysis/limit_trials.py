"""Trials of a move in a loop: how soon the load settles, and what torque that takes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, nan, pi
from typing import Any

import numpy as np

from ..plant import ServoLoop
from ..plant.response_figures import peak_torque
from ..shaping import Limits, Trajectory, input_shaper, min_time_move

_POINTS = 3000  # of the grid on which a trial is seen
_MOST_POINTS = 20_000
_LONGER = 3.0  # the time over which the best are looked at again


@dataclass(frozen=True)
class LimitTrial:
    """One move that was simulated.

    Attributes
    ----------
    order : int
        Of its limits, 3 or 4.
    shaper : str
        Kind of the input shaper behind the move; empty without one.
    jerk, snap : float
        Its bounds; snap is infinite at order 3.
    duration : float
        Of the move, shaper included.
    settling_time : float
        Of the load, from the start; infinite where it does not settle while it is watched.
    peak_torque : float
        Largest magnitude of the commanded torque.
    saturates : bool
        Whether the torque is at its limit anywhere.
    """

    order: int
    shaper: str
    jerk: float
    snap: float
    duration: float
    settling_time: float
    peak_torque: float
    saturates: bool

    @property
    def family(self) -> str:
        """What it is one of, in words."""
        name = "jerk bounded" if self.order == 3 else "jerk and snap bounded"
        return f"{name}, {self.shaper}" if self.shaper else name


@dataclass(frozen=True)
class Family:
    """An order and a shaper, of which bounds are tried."""

    order: int
    shaper: str = ""


@dataclass(frozen=True, eq=False)
class Bench:
    """What moves are tried on.

    Attributes
    ----------
    loop : ServoLoop
    distance, tolerance : float
    velocity, acceleration : float
        Bounds.
    modes : tuple of (frequency_hz, damping)
        That shapers null.
    horizon : float
        Time over which a trial is watched.
    """

    loop: ServoLoop
    distance: float
    tolerance: float
    velocity: float
    acceleration: float
    modes: tuple[tuple[float, float], ...]
    horizon: float

    @cached_property
    def _grid(self) -> float:
        fastest = max((frequency for frequency, _ in self._all_modes), default=0.0)
        return float(max(min(self.horizon / _POINTS, 0.05 / fastest if fastest else inf),
                         self.horizon / _MOST_POINTS))  # fmt: skip

    @property
    def _all_modes(self) -> list[tuple[float, float]]:
        rates = np.linalg.eigvals(self.loop.axis.dynamics.a)
        return [(abs(p) / (2 * pi), 0.0) for p in rates if abs(p.imag) > 0.1 * abs(p)]

    def limits(self, family: Family, ramp: float, share: float) -> Limits:
        """Return limits by the times in which acceleration and jerk rise to their bounds."""
        jerk = self.acceleration / ramp
        snap = None if family.order == 3 else jerk / (share * ramp)
        return Limits(self.velocity if self.velocity < inf else None, self.acceleration, jerk, snap)

    def move(self, family: Family, limits: Limits) -> Trajectory:
        """Return the command."""
        move = min_time_move(self.distance, limits, method="closed-form")
        if not family.shaper:
            return move
        frequencies, dampings = zip(*self.modes, strict=True)
        return input_shaper(family.shaper, frequencies, dampings).shape(move)  # type: ignore[arg-type]

    def loop_for(self, order: int) -> ServoLoop:
        """Return the loop without feedforward of derivatives that the command has not."""
        f = self.loop.feedforward_noun
        return self.loop if f.order <= order else replace(self.loop, feedforward=f.within(order))

    def trial(self, family: Family, limits: Limits) -> LimitTrial:
        """Simulate a move and look at its load on a grid; between its points it is straight."""
        move = self.move(family, limits)
        watched = max(self.horizon, 1.5 * move.duration)
        times = np.linspace(0.0, watched, int(np.ceil(watched / self._grid)) + 1)
        response = self._response(family, move, times)
        off = np.abs(response.load - move.end_state[0]) - self.tolerance
        torque = float(np.abs(response.torque).max())
        settled, saturates = _last_outside(times, off), response.saturated_time > 0.0
        return self._told(family, limits, move, settled, torque, saturates)

    def exact(self, trial: LimitTrial) -> LimitTrial:
        """Return a trial again, its settling exact in continuous time and watched for longer."""
        family = Family(trial.order, trial.shaper)
        limits = Limits(
            self.velocity if self.velocity < inf else None,
            *(self.acceleration, trial.jerk, None if trial.order == 3 else trial.snap),
        )
        move = self.move(family, limits)
        end = _LONGER * max(self.horizon, move.duration)
        response = self._response(family, move, np.array([0.0, end]))
        settled = response.settling_time(float(move.end_state[0]), self.tolerance, of="load")
        return replace(trial, settling_time=settled, peak_torque=peak_torque(response))

    def _response(self, family: Family, move: Trajectory, times: Any) -> Any:
        loop = self.loop_for(min(family.order, move.order))
        return loop.respond(move, duration=float(times[-1]), times=times)

    def _told(
        self,
        family: Family,
        limits: Limits,
        move: Trajectory,
        settled: float,
        torque: float,
        saturates: bool,
    ) -> LimitTrial:
        bounds = (*limits.upper, inf)
        return LimitTrial(
            family.order,
            family.shaper,
            bounds[2],
            bounds[3],
            move.duration,
            settled,
            torque,
            saturates,
        )


def _last_outside(times: Any, excess: Any) -> float:
    """Return the last time at which an excess is positive; infinite if that is the end."""
    outside = np.flatnonzero(excess > 0.0)
    if not outside.size:
        return 0.0
    k = int(outside[-1])
    if k + 1 == len(times):
        return inf
    part = excess[k] / (excess[k] - excess[k + 1]) if np.isfinite(excess[k]) else nan
    return float(times[k] + part * (times[k + 1] - times[k]))
