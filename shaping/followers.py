"""CommandFollower: a shaper that keeps its bounds whatever it is commanded, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import core
from .checks import finite, positive, range_error, state_numbers
from .frozen import Frozen
from .jerk_filter import JerkFilter
from .limits import Limits
from .pieces import FloatArray
from .trajectory import Trajectory
from .trajectory_checks import finite_array
from .transfers.problem import check_order
from .transfers.transfer import min_time_transfer

IntArray = NDArray[np.intp]

_ROUNDING = 1e-12  # of a sample: a piece as short is none


@dataclass(frozen=True, eq=False)
class FollowerResponse(Frozen):
    """What a follower makes of a series of commands.

    Attributes
    ----------
    time : (N,) array
        dt, 2·dt, …: the end of each sample.
    commands : (N,) array
        Command k is in force during sample k, from k·dt to time[k].
    states : (order + 1, N) array
        Position and its derivatives at the end of each sample, time last; behind the jerk filter,
        if there is one. The highest derivative may jump: it is the one in force just before.
    """

    time: FloatArray
    commands: FloatArray
    states: FloatArray

    def __repr__(self) -> str:
        return f"FollowerResponse(samples={len(self.time)}, order={len(self.states) - 1})"


@dataclass(frozen=True)
class CommandFollower(Frozen):
    """Follows any command in minimum time within limits, replanning at every sample.

    At each sample the output is the first dt of the minimum-time motion from the present state to
    the command: to rest there, or to the command's own velocity where that is given. The motion
    is exact inside the sample, however often it switches there, so that no bound is ever
    exceeded, a constant command is not overshot, and nothing chatters on the way to it. A
    ramp commanded by positions alone is a series of steps, each of which it starts and stops
    for: command the velocity, too.

    Parameters
    ----------
    limits : Limits
        Of order 2 or 3; bounds may differ between directions.
    dt : float
        Sampling interval.
    period : float, optional
        Distance after which positions repeat, such as 360.0 for degrees: commands are then
        followed the shortest way. Positions of the output go on continuously.
    jerk_filter : JerkFilter, optional
        Smooths the output further; its lags then are part of the state.

    Raises
    ------
    ValueError
        For limits of another order or with the highest bound in one direction only, or a dt or
        period that is not positive.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section II.

    Examples
    --------
    >>> follower = CommandFollower(Limits(velocity=2.0, acceleration=1.0), dt=0.5)
    >>> state = (0.0, 0.0)
    >>> for _ in range(4):
    ...     state = follower.step(state, 1.0)
    >>> state
    (1.0, 0.0, 0.0)
    """

    limits: Limits
    dt: float
    period: float | None = None
    jerk_filter: JerkFilter | None = None

    def __init__(
        self,
        limits: Limits,
        *,
        dt: float,
        period: float | None = None,
        jerk_filter: JerkFilter | None = None,
    ) -> None:
        check_order(limits)
        if jerk_filter is not None and not isinstance(jerk_filter, JerkFilter):
            raise TypeError(f"jerk_filter = {jerk_filter!r}: expected a JerkFilter or None")
        fields = self.__dict__  # the way around `frozen`
        fields["limits"], fields["dt"] = limits, positive("dt", dt)
        fields["period"] = None if period is None else positive("period", period)
        fields["jerk_filter"] = jerk_filter

    @cached_property
    def _core(self) -> core.Follower:
        n, lags = self.limits.order, self.jerk_filter
        bounds = [side for k in range(1, n + 1) for side in self.limits.bounds(k)]
        period = inf if self.period is None else self.period
        omega, count = (0.0, 0) if lags is None else (lags.omega, lags.order)
        return core.Follower(bounds, self.dt, period, omega, count)

    @property
    def order(self) -> int:
        """Order of the limits."""
        return self.limits.order

    def rest(self, position: float) -> tuple[float, ...]:
        """Return the state of rest at a position."""
        return self._checked_state((position,))

    def step(
        self, state: Sequence[float], command: float, command_velocity: float = 0.0
    ) -> tuple[float, ...]:
        """Return the state one sample later.

        Parameters
        ----------
        state : (position, velocity[, acceleration[, jerk]])
            What an earlier step returned, or any state of motion; numbers left out are zero, and
            the highest derivative is not used. Behind a jerk filter the lags follow, at rest at
            the position where they are left out.
        command : float
            Position to go to.
        command_velocity : float, optional
            Velocity at which the command goes on; the nearest within the limits is used. A ramp
            commanded with its velocity is followed without lag.

        Returns
        -------
        tuple of float
            Position and derivatives 1 … order, then the lags of the jerk filter. `output` tells
            what comes out behind them.

        Raises
        ------
        ValueError
            For numbers that are not finite, or too many of them.
        """
        try:
            following = self._core.step(state, command, command_velocity)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            following = self._core.step(
                self._checked_state(state),
                finite("command", command),
                finite("command_velocity", command_velocity),
            )
        if isinstance(following, int):
            raise range_error()
        return following

    def run(
        self,
        commands: ArrayLike,
        *,
        command_velocities: ArrayLike | None = None,
        initial: Sequence[float] | None = None,
    ) -> FollowerResponse:
        """Return the response to a series of commands: `step`, over an array.

        Parameters
        ----------
        commands : (N,) array
            Command k is in force from k·dt to (k + 1)·dt.
        command_velocities : float or (N,) array, optional
            Velocities at which the commands go on during their samples. Default: zero.
        initial : sequence of float, optional
            State at time 0, as in `step`. Default: at rest at position 0.

        Returns
        -------
        FollowerResponse
            With one column of states per command, the state at the end of its sample.

        Raises
        ------
        ValueError
            For commands, velocities or a state that are not finite, or of the wrong shape.

        Notes
        -----
        The same steps as those of `step`, to the last bit, without the interpreter's lock.
        """
        given = finite_array("commands", commands)
        if given.ndim != 1:
            raise ValueError(f"commands has shape {given.shape}: expected (N,)")
        speeds = finite_array(
            "command_velocities", 0.0 if command_velocities is None else command_velocities
        )
        if speeds.shape not in ((), given.shape):
            raise ValueError(
                f"command_velocities has shape {speeds.shape}: expected {given.shape}, as commands"
            )
        begin = self._checked_state((0.0,) if initial is None else initial)
        states = np.empty((self.order + 1, len(given)))
        speeds = np.ascontiguousarray(speeds).reshape(-1)
        run = self._core.run(begin, np.ascontiguousarray(given), speeds, states)
        if run != core.OK:
            raise range_error()
        time: FloatArray = self.dt * np.arange(1.0, len(given) + 1.0)
        return FollowerResponse(time, given, states)

    def follow(
        self,
        commands: ArrayLike,
        *,
        times: ArrayLike | None = None,
        command_velocities: ArrayLike | None = None,
        initial: Sequence[float] | None = None,
    ) -> Trajectory:
        """Return what it makes of a series of commands as one trajectory, exact inside samples.

        Parameters
        ----------
        commands : (N,) array
            Such as the positions of a file, which `analysis.read_log` reads.
        times : (N,) array, optional
            When each command begins, increasing: at each sample the last one that has begun is in
            force, the first before it, for a sample at least. Default: one a sample.
        command_velocities, initial
            As in `run`; with times, one velocity a command, too. Default: at rest at the first
            command.

        Returns
        -------
        Trajectory
            From the first time on, or 0. The last command stays in force until it is reached,
            where it has no velocity.

        Raises
        ------
        ValueError
            As `run`, for times that do not increase, and for a follower with a jerk filter, whose
            output is no polynomial.
        """
        if self.jerk_filter is not None:
            raise ValueError(
                "a follower with a jerk filter makes no polynomials: leave the filter out, and "
                "put it behind the trajectory"
            )
        given = np.atleast_1d(finite_array("commands", commands))
        speeds = finite_array(
            "command_velocities", 0.0 if command_velocities is None else command_velocities
        )
        begin = 0.0
        if times is not None:
            begin, index = self._in_force(given, times)
            given, speeds = given[index], speeds[index] if speeds.ndim else speeds
        if initial is None and given.size:
            initial = (float(given[0]),)
        ends = self.run(given, command_velocities=speeds, initial=initial).states
        first = self._checked_state(initial or (0.0,))[: self.order + 1]
        states = np.column_stack([first, ends])
        speeds = np.broadcast_to(speeds, given.shape)
        parts = [
            self.motion(state, command, speed)
            for state, command, speed in zip(
                states[:, :-1].T.tolist(), given.tolist(), speeds.tolist(), strict=True
            )
        ]
        moving = bool(speeds.size and speeds[-1])
        if parts and not moving:
            parts.append(self._arrival(states[:, -1], float(given[-1])))
        return _joined(parts, begin + self.dt * np.arange(float(len(parts))), first)

    def _arrival(self, state: FloatArray, command: float) -> Trajectory:
        """Return the rest of the way to a command that is not followed by another one."""
        x = float(state[0])
        if self.period is not None:
            half = 0.5 * self.period
            command = x + (command - x + half) % self.period - half
        start = state[: self.order].tolist()
        return min_time_transfer(start, command, self.limits).trajectory

    def _in_force(self, commands: FloatArray, times: ArrayLike) -> tuple[float, IntArray]:
        """Return the first time, and which command is in force at each sample from it on."""
        at = np.atleast_1d(finite_array("times", times))
        if at.shape != commands.shape or at.ndim != 1 or not (np.diff(at) > 0.0).all():
            raise ValueError(
                f"times of shape {at.shape} with commands of shape {commands.shape}: expected "
                "one increasing time for each command"
            )
        samples = round((at[-1] - at[0]) / self.dt) + 1
        when = at[0] + self.dt * np.arange(float(samples))
        slack = 1e-9 * self.dt
        return float(at[0]), np.searchsorted(at, when + slack, side="right") - 1

    def motion(
        self, state: Sequence[float], command: float, command_velocity: float = 0.0
    ) -> Trajectory:
        """Return the motion inside one sample, exact, before the jerk filter.

        Parameters
        ----------
        state, command, command_velocity
            As in `step`.

        Returns
        -------
        Trajectory
            From time 0 to dt.
        """
        pieces = self._core.pieces(
            self._checked_state(state),
            finite("command", command),
            finite("command_velocity", command_velocity),
        )
        if isinstance(pieces, int):
            raise range_error()
        durations = np.array([duration for duration, _ in pieces])
        states = np.array([row for _, row in pieces]).reshape(len(pieces), self.order + 1)
        return Trajectory(np.append(0.0, np.cumsum(durations)), states, durations)

    def output(self, state: Sequence[float]) -> tuple[float, ...]:
        """Return position and derivatives 1 … order that come out in a state.

        Those of the state itself, without a jerk filter.
        """
        return self._core.output(self._checked_state(state))

    def _checked_state(self, state: Sequence[float]) -> tuple[float, ...]:
        """Return the state as order + 1 numbers and the lags."""
        lags = 0 if self.jerk_filter is None else self.jerk_filter.order
        own = self.order + 1
        given = state_numbers("state", state)
        if not (1 <= len(given) <= own or len(given) == own + lags):
            raise ValueError(
                f"state of {len(given)} numbers: expected position and up to {self.order} "
                f"derivatives" + (f", or those and {lags} lags" if lags else "")
            )
        numbers = [finite(f"state[{k}]", value) for k, value in enumerate(given)]
        if len(numbers) <= own:
            numbers += [0.0] * (own - len(numbers)) + [numbers[0]] * lags
        return tuple(numbers)


def _joined(parts: list[Trajectory], begins: FloatArray, first: Sequence[float]) -> Trajectory:
    """Return motions one behind the other, at times given; at rest without any."""
    if not parts:
        return Trajectory([0.0], np.empty((0, len(first))), end_state=np.array(first))
    starts = np.concatenate([b + part.breaks[:-1] for b, part in zip(begins, parts, strict=True)])
    durations = np.concatenate([part.durations for part in parts])
    kept = durations > _ROUNDING * durations.max(initial=0.0)
    return Trajectory(
        np.append(starts[kept], begins[-1] + parts[-1].end_time),
        np.vstack([part.states for part in parts])[kept],
        durations[kept],
        parts[-1].end_state,
    )
