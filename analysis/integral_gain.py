"""The largest integral gain under bounds on |S| and |T| at given frequencies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

_STEP = 0.5  # no gain changes by more than this part of itself in one program
_MOST = 200
_CONVERGED = 1e-8


class Circle(NamedTuple):
    """What L keeps out of: |center + L| ≥ radius."""

    center: float
    radius: float


class Maximum(NamedTuple):
    """Gains (kp, ki, kr) with the largest ki, the programs solved, and whether they came to rest.

    Gains that are still growing after as many programs as are tried are bounded by nothing.
    """

    gains: Real
    programs: int
    at_rest: bool


def circles(most_s: float, most_t: float) -> tuple[Circle, ...]:
    """Return the circles of |1/(1 + L)| ≤ most_s and of |L/(1 + L)| ≤ most_t, both above 1."""
    beyond = (most_t - 1.0) * (most_t + 1.0)
    return Circle(1.0, 1.0 / most_s), Circle(most_t * most_t / beyond, most_t / beyond)


def clearance(loop: Complex, around: tuple[Circle, ...]) -> float:
    """Return the least distance from the circles, less 1, over their radii; negative within."""
    return min(float((abs(center + loop) / radius).min()) - 1.0 for center, radius in around)


def largest_integral_gain(terms: Complex, start: Real, around: tuple[Circle, ...]) -> Maximum:
    """Return the gains of the largest ki that are reached from `start`.

    With L = terms·gains, |c + L| ≥ r is what is asked for at every frequency. At the present
    L_0, with v = c + L_0, it follows from

        Re(v̄·(c + L))/|v| ≥ r,

    which is linear in the gains: each program keeps inside what is allowed, and so does every
    point between one solution and the next, so that a stable closed loop stays stable.

    Parameters
    ----------
    terms : (N, 3) complex array
        What kp, ki and kr are multiplied by in L, at N frequencies.
    start : (3,) array
        Positive gains that keep out of the circles.
    around : tuple of Circle

    References
    ----------
    Hast, Åström, Bernhardsson and Boyd, "PID design by convex-concave optimization", European
    Control Conference 2013.
    """
    gains = start
    for count in range(1, _MOST + 1):
        new = _next(terms, gains, around)
        change = new[1] / gains[1] - 1.0
        gains = new
        if change < _CONVERGED:
            return Maximum(gains, count, True)
    return Maximum(gains, _MOST, False)


def _next(terms: Complex, gains: Real, around: tuple[Circle, ...]) -> Real:
    """Return the solution of one program, in units of the present gains; else the gains."""
    from scipy.optimize import linprog

    loop = terms @ gains
    scale = np.maximum(gains, 1e-12 * gains.max())
    rows, least = [], []
    for center, radius in around:
        toward = (center + loop).conj() / abs(center + loop)
        rows.append((toward[:, None] * terms).real * scale)
        least.append(radius - center * toward.real)
    matrix, bound = np.concatenate(rows), np.concatenate(least)
    # What no step within the trust region can reach is no constraint.
    reach = matrix @ (gains / scale) - (_STEP * abs(matrix)).sum(axis=1)
    near = reach < bound
    found = linprog(
        [0.0, -1.0, 0.0],
        A_ub=-matrix[near],
        b_ub=-bound[near],
        bounds=[(max(0.0, g - _STEP), g + _STEP) for g in gains / scale],
    )
    return gains if found.x is None else np.asarray(found.x * scale)
