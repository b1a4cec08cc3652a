"""Commands that never end: ramps, sines, and sums of commands."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ..shaping import Trajectory
from ..shaping.checks import finite, positive
from ..shaping.pieces import MAX_ORDER, FloatArray
from ..shaping.real_numbers import shown

_ON_BREAK = 1e-12  # a time this near to a break, relative to the longest, is on it


class _Endless:
    """A smooth command without breaks."""

    breaks = np.zeros(1)

    def __add__(self, other: Any) -> Sum:
        return Sum((self, other))

    def __radd__(self, other: Any) -> Sum:
        return Sum((other, self))


@dataclass(frozen=True)
class Ramp(_Endless):
    """A command of constant velocity, r(t) = offset + rate·t: sidereal tracking, a scan.

    Parameters
    ----------
    rate : float
        Velocity; 0 for a command that stands still.
    offset : float, optional
        Position at time 0.
    """

    rate: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("rate", "offset"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))

    def derivatives(self, t: FloatArray, highest: int) -> FloatArray:
        """Return the command and its derivatives up to `highest` at times, one row each."""
        rows = np.zeros((highest + 1, len(t)))
        rows[0] = self.offset + self.rate * t
        rows[1:2] = self.rate
        return rows


@dataclass(frozen=True)
class Sine(_Endless):
    """A sinusoidal command, r(t) = amplitude·sin(2π·frequency_hz·t).

    Parameters
    ----------
    amplitude : float
    frequency_hz : float
        Positive.
    """

    amplitude: float
    frequency_hz: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "amplitude", finite("amplitude", self.amplitude))
        object.__setattr__(self, "frequency_hz", positive("frequency_hz", self.frequency_hz))

    @property
    def omega(self) -> float:
        """Angular frequency."""
        return 2.0 * pi * self.frequency_hz

    def derivatives(self, t: FloatArray, highest: int) -> FloatArray:
        """Return the command and its derivatives up to `highest` at times, one row each."""
        turning = np.array([np.sin(self.omega * t), np.cos(self.omega * t)])
        signs = (1.0, 1.0, -1.0, -1.0)
        return np.array(
            [
                self.amplitude * self.omega**k * signs[k % 4] * turning[k % 2]
                for k in range(highest + 1)
            ]
        )


@dataclass(frozen=True)
class Sum(_Endless):
    """A sum of commands.

    Parameters
    ----------
    parts : tuple of Trajectory, Ramp, Sine or Sum
    """

    parts: tuple[Any, ...]

    def __post_init__(self) -> None:
        flat: list[Any] = []
        for part in map(as_command, self.parts):
            flat.extend(part.parts if isinstance(part, Sum) else [part])
        object.__setattr__(self, "parts", tuple(flat))

    def derivatives(self, t: FloatArray, highest: int) -> FloatArray:
        """Return the command and its derivatives up to `highest` at times, one row each."""
        total = np.zeros((highest + 1, len(t)))
        for part in self.parts:
            total += derivatives_of(part, t, highest)
        return total


Command = Trajectory | Ramp | Sine | Sum


def as_command(command: Any) -> Command:
    """Return a command: a Trajectory, a Transfer's or a move's trajectory, Ramp, Sine or a sum."""
    inner = getattr(command, "trajectory", command)
    if isinstance(inner, Trajectory | Ramp | Sine | Sum):
        return inner
    raise TypeError(
        f"command = {shown(command)}: expected a Trajectory, as min_time_move gives, Ramp, Sine, "
        "or a sum of them"
    )


def command_order(command: Any) -> int:
    """Return the highest derivative of a command that is finite; of endless ones, all are."""
    given = as_command(command)
    parts = given.parts if isinstance(given, Sum) else (given,)
    return min((part.order for part in parts if isinstance(part, Trajectory)), default=MAX_ORDER)


def highest_order(command: Command) -> int:
    """Return the highest derivative of a command's polynomials that is not 0 everywhere."""
    parts = command.parts if isinstance(command, Sum) else (command,)
    return max(part.order if isinstance(part, Trajectory) else 1 for part in parts)


def sines_of(command: Command) -> list[Sine]:
    """Return the sines that a command is made of."""
    parts = command.parts if isinstance(command, Sum) else (command,)
    return [part for part in parts if isinstance(part, Sine)]


def derivatives_of(command: Command, t: FloatArray, highest: int) -> FloatArray:
    """Return a command and its derivatives up to `highest` at times, one row each."""
    if not isinstance(command, Trajectory):
        return command.derivatives(t, highest)
    rows = np.zeros((highest + 1, len(t)))
    known = min(highest, command.order)
    rows[: known + 1] = command.evaluate(t, known)
    return rows


def breaks_of(command: Command) -> FloatArray:
    """Return the times at which a command changes its polynomial, in order."""
    parts = command.parts if isinstance(command, Sum) else (command,)
    return np.unique(np.concatenate([np.asarray(part.breaks) for part in parts]))


def on_breaks(command: Command, times: FloatArray) -> FloatArray:
    """Return increasing times, those that rounding has parted from a break on it."""
    breaks, found = breaks_of(command), times.copy()
    if times.size:
        slack = _ON_BREAK * max(abs(float(times[0])), abs(float(times[-1])), abs(float(breaks[-1])))
        low = np.searchsorted(times, breaks - slack, side="left")
        high = np.searchsorted(times, breaks + slack, side="right")
        for k in np.flatnonzero(high > low):
            found[low[k] : high[k]] = breaks[k]
    return found
