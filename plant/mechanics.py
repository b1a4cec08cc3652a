"""Matrices of mass, damping and stiffness of an axis, seen from its motor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..shaping.pieces import FloatArray
from .flexible_mode import FlexibleMode


@dataclass(frozen=True, eq=False)
class Mechanics:
    """M·q̈ + C·q̇ + K·q = e_0·(u + d_motor) + l·d_load, y_motor = q_0, y_load = lᵀ·q.

    The first coordinate is the motor's position, the others are relative to it, so that an offset
    of position shifts it alone.

    Attributes
    ----------
    mass, damping, stiffness : (n, n) arrays
    load : (n,) array
        l.
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    load: FloatArray

    def loaded(self, viscous: float, load_viscous: float, spring: float) -> Mechanics:
        """Return it with viscous friction on motor and load, the motor on a spring, too."""
        damping, stiffness = self.damping.copy(), self.stiffness.copy()
        damping[0, 0] += viscous
        damping += load_viscous * np.outer(self.load, self.load)
        stiffness[0, 0] += spring
        return Mechanics(self.mass, damping, stiffness, self.load)

    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Return A and B of ẋ = A·x + B·(u + d_motor, d_load), x = (q, q̇)."""
        n = len(self.mass)
        forces = np.column_stack([np.eye(n)[0], self.load])
        solved = np.linalg.solve(self.mass, np.hstack([-self.stiffness, -self.damping, forces]))
        a = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), solved[:, : 2 * n]])
        return a, np.vstack([np.zeros((n, 2)), solved[:, 2 * n :]])


def modal_mechanics(J: float, modes: Sequence[FlexibleMode]) -> Mechanics:
    """Return the mechanics of a rigid body J with free-free modes.

    With q_0 = y_motor − Σ a_i·q_i the kinetic energy is J/2·((ẏ_motor − aᵀq̇)² + q̇ᵀq̇).
    """
    shapes = np.array([mode.shapes for mode in modes]).reshape(-1, 2)
    a, b = shapes.T
    omega = np.array([mode.omega for mode in modes])
    zeta = np.array([mode.damping for mode in modes])
    n = len(modes) + 1
    mass = np.eye(n)
    mass[0, 1:] = mass[1:, 0] = -a
    mass[1:, 1:] += np.outer(a, a)
    damping = np.diag(np.append(0.0, 2.0 * zeta * omega))
    stiffness = np.diag(np.append(0.0, omega**2))
    return Mechanics(J * mass, J * damping, J * stiffness, np.append(1.0, b - a))


def held_mechanics(J: float, modes: Sequence[FlexibleMode]) -> Mechanics:
    """Return the mechanics of a motor with appendages; the load is that of the first mode."""
    share = np.array([mode.load_fraction for mode in modes], dtype=float)
    omega = np.array([mode.omega for mode in modes])
    zeta = np.array([mode.damping for mode in modes])
    mass = np.diag(np.append(1.0, share))
    mass[0, 1:] = mass[1:, 0] = share
    damping = np.diag(np.append(0.0, 2.0 * zeta * omega * share))
    stiffness = np.diag(np.append(0.0, omega**2 * share))
    load = np.zeros(len(modes) + 1)
    load[:2] = 1.0
    return Mechanics(J * mass, J * damping, J * stiffness, load)


def chain_mechanics(
    masses: Sequence[float], springs: Sequence[float], dampers: Sequence[float]
) -> Mechanics:
    """Return the mechanics of masses in a row; the motor is the first, the load the last."""
    n = len(masses)
    from_motor = np.eye(n)
    from_motor[1:, 0] = 1.0
    between = np.diff(np.eye(n), axis=0) @ from_motor
    between[:, 0] = 0.0  # exactly: a common offset stretches nothing
    return Mechanics(
        from_motor.T @ np.diag(masses) @ from_motor,
        between.T @ np.diag(dampers) @ between,
        between.T @ np.diag(springs) @ between,
        from_motor[-1].copy(),
    )
