"""Motions next to a free flight: states so near that bounds hardly matter in between."""

from __future__ import annotations

from math import factorial

import numpy as np

from ...pieces import FloatArray
from .problem import WholeProblem
from .repair import Repaired, excess, propagated

_NEAR = 2e-3  # relative: how much longer than the least it may take; links end so far below
_STEPS = 3
_ROUNDING = 1e-15  # of the terms of a difference: it is zero
_EXCESS = 1e-13  # of a bound's size: rounding


def near_flight(problem: WholeProblem, least: float) -> Repaired | None:
    """Return a motion of about the least duration that is proven, along a free flight, or None.

    The flight a(t) = Σ a_q·t^q/q! reaches derivative k of the end at a root T of b_k − a^(k)(T).
    What it misses of the other derivatives then is made up for by inputs of least squares on 2n
    cells, in units of what the input can do in T: windows of durations that are much shorter
    than roundings of the programs are hit so.
    """
    for time in _arrivals(problem, least):
        found = _made_up(problem, time)
        if found is not None:
            return found
    return None


def _arrivals(problem: WholeProblem, least: float) -> list[float]:
    """Return the roots next to the least duration, shortest first."""
    n = problem.order
    times: set[float] = set()
    for k in range(n):
        rows = [-problem.start[q] / factorial(q - k) for q in range(k, n)]
        rows[0] += problem.end[k]
        scaled = np.array(rows) * least ** np.arange(n - k)
        if not scaled[1:].any():
            continue
        roots = np.polynomial.polynomial.polyroots(np.trim_zeros(scaled, "b"))
        real = roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots)]
        near = real[np.abs(real - 1.0) <= _NEAR]
        times.update(float(least * _polished(scaled, root)) for root in near.tolist())
    return sorted(times)


def _polished(coefficients: FloatArray, root: float) -> np.longdouble:
    """Return a root after steps of Newton's method in extended precision."""
    at = np.longdouble(root)
    values = coefficients.astype(np.longdouble)
    slopes = np.polynomial.polynomial.polyder(values)
    for _ in range(_STEPS):
        slope = np.polynomial.polynomial.polyval(at, slopes)
        at = at - np.polynomial.polynomial.polyval(at, values) / slope if slope else at
    return at


def _made_up(problem: WholeProblem, time: float) -> Repaired | None:
    """Return the motion of a duration; None where it breaks a bound."""
    n, cells = problem.order, 2 * problem.order
    powers = time ** np.arange(n)
    terms = [
        [
            problem.end[k],
            *(-problem.start[q] * time ** (q - k) / factorial(q - k) for q in range(k, n)),
        ]
        for k in range(n)
    ]
    missed = np.array([sum(map(np.longdouble, row)) for row in terms], dtype=float)
    sizes = np.array([np.abs(row).sum() for row in terms])
    missed[np.abs(missed) <= _ROUNDING * sizes] = 0.0
    inputs = np.linalg.pinv(_effects(n, cells)) @ (missed * powers) / time**n
    durations = np.full(cells if inputs.any() else 1, time / cells if inputs.any() else time)
    lengths = durations.astype(np.longdouble)
    states = propagated(problem.start, lengths, inputs[: len(lengths)].astype(np.longdouble))
    found = Repaired(lengths, states, time)
    return found if excess(problem, found) <= _EXCESS else None


def _effects(n: int, cells: int) -> FloatArray:
    """Return what a unit input on each cell makes of the end of a motion of unit duration."""
    left = np.linspace(1.0, 0.0, cells + 1)
    rows = [(left[:-1] ** m - left[1:] ** m) / factorial(m) for m in range(n, 0, -1)]
    return np.array(rows)
