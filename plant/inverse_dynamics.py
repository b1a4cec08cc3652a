"""What an exact inverse remembers: a stable filter of the command, exact over its pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..shaping import Trajectory
from ..shaping.checks import whole
from ..shaping.frozen import Frozen
from ..shaping.pieces import MAX_ORDER, FloatArray, evaluate
from ..shaping.real_numbers import real_array, shown
from .commands import Command, Sine, Sum, derivatives_of


@dataclass(frozen=True)
class InverseDynamics(Frozen):
    """The part of an inverse that is no sum of derivatives: what it remembers, z = 0 at the start.

        N(d/dt)·z = r^(derivative),   N(s) = Σ denominator[k]·s^k,   N(0) = 1,
        u_feedforward += Σ torque[k]·z^(k),   r_motor += Σ position[k]·z^(k).

    Parameters
    ----------
    derivative : int
        Of the command, 2 or more.
    denominator : (m + 1,) sequence of float
        Lowest power first; all zeros of N lie left of the imaginary axis.
    torque : sequence of at most m + 1 floats
    position : sequence of at most m floats
    """

    derivative: int
    denominator: tuple[float, ...]
    torque: tuple[float, ...]
    position: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "derivative", whole("derivative", self.derivative, 2, MAX_ORDER))
        for name in ("denominator", "torque", "position"):
            values = np.atleast_1d(real_array(name, getattr(self, name)))
            object.__setattr__(self, name, tuple(values.tolist()))
        m = len(self.denominator) - 1
        fits = m >= 1 and len(self.torque) <= m + 1 and len(self.position) <= m
        if not fits or self.denominator[0] != 1.0 or self.denominator[-1] == 0.0:
            raise ValueError(
                f"denominator = {shown(self.denominator)}: expected m + 1 numbers, the first 1, "
                "the last not 0, for at most m + 1 gains of the torque and m of the position"
            )
        if np.roots(self.denominator[::-1]).real.max() >= 0.0:
            raise ValueError(
                f"denominator = {shown(self.denominator)}: its dynamics are unstable; use "
                "low_frequency_feedforward(axis)"
            )

    @property
    def size(self) -> int:
        """Number m of its states."""
        return len(self.denominator) - 1

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D from r^(derivative) to what is added to torque and position.

        The states are z and its derivatives in units of the poles' mean frequency.
        """
        m, n = self.size, np.array(self.denominator)
        unit = abs(n[-1]) ** (-1.0 / m)
        scale = unit ** np.arange(m + 1.0)
        a, b = np.zeros((m, m)), np.zeros(m)
        a[:-1, 1:] = unit * np.eye(m - 1)
        a[-1] = -unit * n[:-1] * scale[:-1] / (n[-1] * scale[-1])
        b[-1] = unit / (n[-1] * scale[-1])
        c, d = np.zeros((2, m)), np.zeros(2)
        for row, gains in zip(c, (self.torque, self.position), strict=True):
            row[: len(gains[:m])] = np.array(gains[:m]) * scale[: len(gains[:m])]
        if len(self.torque) > m:
            d[0] = self.torque[m] / n[-1]
            c[0] -= d[0] * n[:-1] * scale[:-1]
        return a, b, c, d

    def added(self, command: Command, begin: float, times: FloatArray) -> FloatArray:
        """Return what is added to torque and position at times from `begin` on, (2, N).

        Between two breaks of the command z is a polynomial of the time and decaying exponentials.
        """
        parts = command.parts if isinstance(command, Sum) else (command,)
        total = np.zeros((2, len(times)))
        for part in parts:
            if isinstance(part, Trajectory):
                total += self._behind_pieces(part, times)
            elif isinstance(part, Sine):
                total += self._behind_sine(part, begin, times)
        return total

    def behind(self, command: Trajectory) -> tuple[FloatArray, FloatArray]:
        """Return what makes the states of `matrices` behind a piecewise polynomial.

            x(t) = settled·(r^(derivative), …, r^(order))(t) + e^(A·(t − breaks[i]))·decaying[i]

        from break i on; before the first x is 0.
        """
        a, b, _, _ = self.matrices()
        count = command.order - self.derivative + 1
        columns = [-np.linalg.solve(a, b)]
        for _ in range(count - 1):
            columns.append(np.linalg.solve(a, columns[-1]))
        settled = np.array(columns).T
        starts = np.vstack([command.states[:, self.derivative :], np.zeros(count)])
        every = range(self.derivative, command.order + 1)
        ends = evaluate(command.states.T, command.durations, every).T
        moved = _exponentials(a, command.durations)
        decaying, state = np.zeros((len(starts), self.size)), np.zeros(self.size)
        for i, change in enumerate(moved):
            decaying[i] = state - settled @ starts[i]
            state = settled @ ends[i] + change @ decaying[i]
        decaying[-1] = state
        return settled, decaying

    def _behind_pieces(self, command: Trajectory, times: FloatArray) -> FloatArray:
        a, _, c, d = self.matrices()
        settled, decaying = self.behind(command)
        piece = np.searchsorted(command.breaks, times, side="right") - 1
        fed = derivatives_of(command, times, command.order)[self.derivative :]
        after = _exponentials(a, np.maximum(times - command.breaks[piece], 0.0))
        x = settled @ fed + np.einsum("nij,nj->in", after, decaying[piece])
        x[:, piece < 0] = 0.0
        return np.asarray(c @ x + np.outer(d, fed[0]))

    def _behind_sine(self, command: Sine, begin: float, times: FloatArray) -> FloatArray:
        a, b, c, d = self.matrices()
        turn = 1j * command.omega
        size = command.amplitude * turn**self.derivative
        swinging = np.linalg.solve(turn * np.eye(self.size) - a, size * b)
        gone = (swinging * np.exp(turn * begin)).imag
        x = (swinging[:, None] * np.exp(turn * times)).imag
        x -= np.einsum("nij,j->in", _exponentials(a, times - begin), gone)
        return np.asarray(c @ x + np.outer(d, (size * np.exp(turn * times)).imag))


def _exponentials(a: FloatArray, times: FloatArray) -> FloatArray:
    """Return e^(A·t) at times, (N, m, m)."""
    from scipy.linalg import expm

    return np.asarray(expm(a * times[:, None, None]))
