"""A motion from a program's answer: equal inputs joined, the end state exact, bounds checked."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial, ldexp

import numpy as np

from ...pieces import FloatArray, RealArray, extrema
from ...trajectory import Trajectory
from .problem import WholeProblem
from .sampled import Sampled

SAME = 2e-6
"""Difference of inputs that are one, of the highest bound's range."""

_ROUGH = 1e-9  # the same where merging so spoils the end
_CORRECTIONS = 4
MISSED = 1e-14  # of each derivative's size: the end state is exact
EXCESS = 1e-13  # of a bound's size: rounding
ROUNDING = 1e-17  # of a derivative's size, in extended precision


@dataclass(frozen=True, eq=False)
class Repaired:
    """A motion that keeps every bound and ends where it should, in a problem's own units.

    Parameters
    ----------
    durations : (m,) array
        In extended precision, their sum the time.
    states : (n + 1, m + 1) array
        x^(k) at the pieces' starts and the end.
    time : float
    """

    durations: RealArray
    states: RealArray
    time: float

    def trajectory(self, original: WholeProblem, length: int, time: int) -> Trajectory:
        """Return the motion in the caller's units, those of `original`."""
        n = original.order
        powers = length - np.arange(n + 1) * time
        states = np.ldexp(self.states, powers[:, None])
        states[0] += original.start[0]
        rows = np.array(states[:, :-1].T, dtype=np.float64)
        rows[0, :n] = original.start
        durations = np.ldexp(self.durations, time)
        breaks = np.concatenate([[0.0], np.cumsum(durations)]).astype(float)
        breaks[-1] = ldexp(self.time, time)
        end = np.append(original.end, 0.0)
        return Trajectory(breaks, rows, durations.astype(float), end)


def repaired(problem: WholeProblem, motion: Sampled, *, same: float = SAME) -> Repaired | None:
    """Return a motion with an exact end; None where that, or a bound, cannot be kept.

    What the end misses goes into the inputs of all pieces by the least sum of squares. Inputs
    that differ by less than `same` of the highest bound's range are one piece.
    """
    found = (_repaired(problem, motion, each) for each in (same, _ROUGH))
    return next((one for one in found if one is not None), None)


def _repaired(problem: WholeProblem, motion: Sampled, same: float) -> Repaired | None:
    n, time = problem.order, motion.time
    span = float(problem.upper[-1] - problem.lower[-1])
    lengths, levels = joined(motion, span * time**n * same)
    durations: RealArray = lengths.astype(np.longdouble) * time
    inputs: RealArray = levels.astype(np.longdouble) / np.longdouble(time) ** n
    sizes = motion.sizes(problem)[:n] / time ** np.arange(n)
    of_inputs = effects(durations, n) / sizes[:, None].astype(np.longdouble)
    inverse = np.linalg.pinv(np.asarray(of_inputs, float))
    for _ in range(_CORRECTIONS):
        states = propagated(problem.start, durations, inputs)
        missed = (problem.end - states[:n, -1]) / sizes
        if np.abs(missed).max() <= MISSED:
            break
        inputs = inputs + inverse @ missed
    else:
        return None
    found = Repaired(durations, states, time)
    return found if excess(problem, found) <= EXCESS else None


def joined(motion: Sampled, same: float) -> tuple[FloatArray, FloatArray]:
    """Return lengths and inputs of the cells, those of equal input joined."""
    cells = np.diff(motion.nodes)
    apart = np.concatenate([[True], np.abs(np.diff(motion.inputs)) > same])
    first = np.flatnonzero(apart)
    lengths = np.add.reduceat(cells, first)
    return lengths, np.add.reduceat(cells * motion.inputs, first) / lengths


def propagated(
    start: FloatArray | RealArray,
    durations: RealArray,
    inputs: RealArray,
    *,
    still: int | None = None,
) -> RealArray:
    """Return x^(k) at every piece's start and at the end, k = 0 … n, shape (n + 1, m + 1).

    Of derivatives above `still` what is rounding is zero.
    """
    n = len(start)
    states: RealArray = np.zeros((n + 1, len(durations) + 1), dtype=np.longdouble)
    states[n, :-1] = inputs
    for k in range(n - 1, -1, -1):
        rise = sum(states[k + i, :-1] * durations**i / factorial(i) for i in range(1, n - k + 1))
        states[k] = start[k] + np.concatenate([[0.0], np.cumsum(rise)])
        if still is not None and k > still:
            states[k, np.abs(states[k]) <= ROUNDING * np.abs(states[k]).max()] = 0.0
    return states


def effects(durations: RealArray, n: int) -> RealArray:
    """Return what a unit input on each piece makes of the end state, (n, m)."""
    after = np.append(np.cumsum(durations[::-1])[::-1], 0.0)
    rows = [(after[:-1] ** m - after[1:] ** m) / factorial(m) for m in range(n, 0, -1)]
    return np.array(rows)


def excess(problem: WholeProblem, motion: Repaired) -> float:
    """Return the largest excess over a bound at any time, relative to the derivative's size."""
    n = problem.order
    durations = np.asarray(motion.durations, float)
    states = np.asarray(motion.states[:, :-1], float)
    worst = 0.0
    for k in range(n + 1):
        lower, upper = float(problem.lower[k]), float(problem.upper[k])
        if not (np.isfinite(lower) or np.isfinite(upper)):
            continue
        size = float(np.abs(motion.states[k]).max())
        low, high = _hull(states[k:], durations)
        doubt = (low < lower) | (high > upper)
        if doubt.any():
            low, high = extrema(durations[doubt], states[k:, doubt])
            over = max(float(lower - low.min()), float(high.max() - upper), 0.0)
            worst = max(worst, over / size if over else 0.0)
    return worst


def _hull(states: FloatArray, durations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the greatest Bernstein coefficient of each piece."""
    m = len(states) - 1
    basis = np.array([[comb(j, i) / comb(m, i) for i in range(m + 1)] for j in range(m + 1)])
    powers = np.array([durations**i / factorial(i) for i in range(m + 1)])
    coefficients = basis @ (states * powers)
    return coefficients.min(axis=0), coefficients.max(axis=0)
