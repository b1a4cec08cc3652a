"""Equations for the gains of a PID from crossover, phase margin and lower gain margin."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import cos, degrees, pi, sin

import numpy as np
from numpy.typing import NDArray

from ..shaping.real_numbers import shown
from ..shaping.roots import root_between

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Terms = Callable[[Real], Complex]
"""ω (N,) to what kp, ki and kr are multiplied by in L, (N, 3)."""

_LOWEST = 1e-5  # of the crossover: where the lower phase crossover is looked for
_PLACES = 2000


def gains_for(terms: Terms, crossover: float, phase: float, factor: float) -> Iterator[Real]:
    """Yield every (kp, ki, kr) ≥ 0 with L(jω_c) = −e^(jφ) and L(jω_p) = −g_m at an ω_p < ω_c.

    L = terms·gains is linear: four real equations for three gains and ω_p, solvable where the
    determinant of the equations beside their right-hand sides vanishes. On an inertia
    ω_p² = kp/(g_m·J), which is Thompson's design.

    Parameters
    ----------
    terms : callable
    crossover : float
        ω_c in rad/s.
    phase : float
        Phase margin φ in rad.
    factor : float
        Lower gain margin g_m as a factor, above 1.
    """
    target = -np.array([cos(phase), sin(phase)])
    sides = np.array([*target, -factor, 0.0])

    def equations(omega: Real) -> tuple[Real, Real]:
        """Return matrices (N, 4, 3) and right-hand sides (N, 4), each row pair in its own unit."""
        at = np.stack([np.broadcast_to(above, (len(omega), 3)), terms(omega)], axis=1)
        size = abs(at).max(axis=2)[..., None]
        rows = np.stack([at.real, at.imag], axis=2) / size[..., None]
        return rows.reshape(-1, 4, 3), (sides.reshape(2, 2) / size).reshape(-1, 4)

    def excess(logs: Real) -> Real:
        matrix, side = equations(np.exp(logs))
        matrix = matrix / abs(matrix).max(axis=1, keepdims=True)
        side = side / abs(side).max(axis=1, keepdims=True)
        return np.asarray(np.linalg.det(np.concatenate([matrix, side[..., None]], axis=2)))

    above = terms(np.array([crossover]))
    logs = np.log(crossover) + np.linspace(np.log(_LOWEST), -1e-6, _PLACES)
    values = excess(logs)
    for k in np.flatnonzero(values[:-1] * values[1:] < 0.0).tolist():
        log = root_between(lambda at: float(excess(np.array([at]))[0]), *logs[k : k + 2].tolist())
        matrix, side = (part[0] for part in equations(np.exp(np.array([log]))))
        scale = abs(matrix).max(axis=0)
        gains = np.linalg.lstsq(matrix / scale, side, rcond=None)[0] / scale
        if (gains >= 0.0).all():
            yield gains


def reachable_margins(terms: Terms, crossover: float, phase: float) -> Real:
    """Return lower gain margins (M,) > 1 that go with L(jω_c) = −e^(jφ) and gains ≥ 0.

    Of many ω_p < ω_c at which L is real: three equations for the gains, and g_m follows.
    """
    logs = np.linspace(np.log(_LOWEST), -1e-3, _PLACES)
    below = terms(crossover * np.exp(logs))
    above = terms(np.array([crossover]))[0]
    fixed = np.broadcast_to([above.real, above.imag], (len(below), 2, 3))
    matrix = np.concatenate([fixed, below.imag[:, None]], axis=1)
    size = abs(matrix).max(axis=2, keepdims=True)
    target = np.array([[-cos(phase)], [-sin(phase)], [0.0]]) / size
    solvable = abs(np.linalg.det(matrix / size)) > 1e-12
    gains = np.linalg.solve((matrix / size)[solvable], target[solvable])[..., 0]
    factors = -(below[solvable].real * gains).sum(axis=1)
    return np.asarray(factors[(gains >= 0.0).all(axis=1) & (factors > 1.0)])


def check_phase(terms: Terms, crossover: float, phase: float, asked_deg: float) -> None:
    """Refuse a phase margin for which k would have to turn by more than a PID does."""
    proportional = terms(np.array([crossover]))[0, 0]
    turn = np.angle(-np.exp(1j * phase) / proportional)
    if abs(turn) < 0.5 * pi:
        return
    best = degrees(phase) - degrees(turn) + 90.0
    raise ValueError(
        f"phase_margin_deg = {shown(asked_deg)} is out of reach: at the crossover the "
        "phase of plant, "
        f"filters and delay is {degrees(np.angle(proportional)):.1f} deg, and a PID adds less than "
        f"90 deg, which leaves less than {best:.1f} deg; lower the crossover or take delay away"
    )
