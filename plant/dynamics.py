"""Equations of motion of an axis in state space, the current loop's lag included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..shaping.pieces import FloatArray
from .mechanics import Mechanics

if TYPE_CHECKING:
    import control

_NOTHING = 1e-12  # of the sum of magnitudes: below it a sum is rounding


@dataclass(frozen=True, eq=False)
class Dynamics:
    """ẋ = A·x + B·(u, d_motor, d_load) with rows for what an axis shows.

    Attributes
    ----------
    a : (n, n) array
    b : (n, 3) array
        The torque command u, or the torque itself without a lag, and the disturbances.
    motor, motor_rate, load, load_rate : (n,) arrays
        Rows of positions and velocities.
    torque : (n + 1,) array
        Row of the motor's torque over (x, u).
    names : tuple of str
        Of the states.
    """

    a: FloatArray
    b: FloatArray
    motor: FloatArray
    motor_rate: FloatArray
    load: FloatArray
    load_rate: FloatArray
    torque: FloatArray
    names: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.a)

    def lagging(self, lag: float) -> Dynamics:
        """Return it behind a current loop, lag·torque′ = u − torque; one state more."""
        if lag == 0.0:
            return self
        n = self.size
        a, b = np.zeros((n + 1, n + 1)), np.zeros((n + 1, 3))
        a[:n, :n], a[:n, n], a[n, n] = self.a, self.b[:, 0], -1.0 / lag
        b[:n, 1:], b[n, 0] = self.b[:, 1:], 1.0 / lag
        motor, motor_rate = np.append(self.motor, 0.0), np.append(self.motor_rate, 0.0)
        load, load_rate = np.append(self.load, 0.0), np.append(self.load_rate, 0.0)
        torque = np.append(np.eye(n + 1)[n], 0.0)
        names = (*self.names, "torque")
        return Dynamics(a, b, motor, motor_rate, load, load_rate, torque, names)


def mechanical_dynamics(mechanics: Mechanics) -> Dynamics:
    """Return the dynamics of matrices of mass, damping and stiffness."""
    a, b = mechanics.matrices()
    n = len(mechanics.mass)
    one, none = np.eye(n)[0], np.zeros(n)
    names = ["y", *(f"twist_{i}" for i in range(1, n))]
    return Dynamics(
        a,
        b[:, [0, 0, 1]],
        np.append(one, none),
        np.append(none, one),
        np.append(mechanics.load, none),
        np.append(none, mechanics.load),
        np.append(np.zeros(2 * n), 1.0),
        (*names, *(f"{name}_rate" for name in names)),
    )


def linear_dynamics(system: control.StateSpace) -> Dynamics:
    """Return the dynamics of any system from torque to position; motor and load are one.

    Position and velocity become the first two states, so that a motor that sticks is exactly
    still.

    Raises
    ------
    ValueError
        Where the torque acts on the velocity or the position at once.
    """
    a, b, c = np.asarray(system.A), np.asarray(system.B)[:, 0], np.asarray(system.C)[0]
    rate = c @ a
    direct = abs(system.D).max() > 0.0
    if direct or abs(c @ b) > _NOTHING * (abs(c) @ abs(b)):
        raise ValueError(
            "system: expected two poles more than zeros, from torque to position; a torque that "
            "moves the position at once has no mass behind it"
        )
    basis = np.vstack([c, rate])
    scale = np.linalg.norm(basis, axis=1, keepdims=True)
    others = np.linalg.svd(basis / scale)[2][2:]
    change = np.vstack([basis, others])
    back = np.linalg.inv(change)
    moved, drive = change @ a @ back, change @ b
    moved[0], drive[0] = np.eye(len(a))[1], 0.0
    position, velocity = np.eye(len(a))[:2]
    names = ("y", "y_rate", *(f"x_{i}" for i in range(1, len(a) - 1)))
    torque = np.append(np.zeros(len(a)), 1.0)
    rows = (position, velocity, position, velocity)
    return Dynamics(moved, np.column_stack([drive] * 3), *rows, torque, names)
