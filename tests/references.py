"""Precision that the README promises, and slow references that share no code with the package."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from math import factorial, inf, isfinite, sqrt
from pathlib import Path

import mpmath
import numpy as np
from scipy.interpolate import PPoly
from scipy.optimize import linprog

END_POSITION = 1e-12
"""Error of a move's end position, relative to its distance, for orders to 10."""

BOUND = 1e-12
"""Largest relative excess over a bound, for orders to 10."""

CONTINUITY = 1e-12
"""Jump of a derivative below n at a break, relative to that derivative's peak."""

RESPONSE = 1e-10
"""Error of a linear system's exact response, relative to its peak."""

MARGINS = 1e-10
"""Error of the three margins that a PID was designed for, relative."""

UNITS = 1e-13
"""Error of a duration under a change of units, relative."""


@dataclass(frozen=True)
class Problem:
    """A rest-to-rest problem with published durations; see data/README.md."""

    name: str
    order: int
    distance: float
    bounds: tuple[float, ...]
    lower: float
    upper: float
    recursion: float


@lru_cache(maxsize=1)
def reference_problems() -> tuple[Problem, ...]:
    """Return the problems of data/minimum_time.json."""
    text = (Path(__file__).parent / "data" / "minimum_time.json").read_text(encoding="utf-8")
    return tuple(_problem(entry) for entry in json.loads(text)["problems"])


def _problem(entry: dict) -> Problem:
    order = entry["order"]
    bounds = tuple(entry["bounds"].get(str(k), inf) for k in range(1, order + 1))
    durations = (entry[f"duration_{kind}"] for kind in ("lower", "upper", "recursion"))
    return Problem(entry["name"], order, entry["distance"], bounds, *durations)


def move_text(distance: float, bounds) -> str:
    """Return the call that makes a move, to be pasted from a failed test."""
    shown = [None if bound == inf else bound for bound in bounds]
    return f"min_time_move({distance!r}, Limits.from_bounds({shown!r}))"


def piece_value(state, tau: float, derivative: int) -> mpmath.mpf:
    """Evaluate a Taylor state with 50 digits, from the doubles it is made of."""
    with mpmath.workdps(50):
        return mpmath.fsum(
            mpmath.mpf(float(value)) * mpmath.mpf(float(tau)) ** j / mpmath.factorial(j)
            for j, value in enumerate(state[derivative:])
        )


def joint_gaps(trajectory) -> list[float]:
    """Return the largest jump at any break of derivatives 0…n−1, relative to their peaks.

    The last joint is the end of the last piece against the end state.
    """
    ends = np.vstack([trajectory.states[1:], trajectory.end_state])
    gaps = []
    for k in range(trajectory.order):
        worst = max(
            abs(float(piece_value(state, tau, k) - mpmath.mpf(float(end[k]))))
            for state, tau, end in zip(trajectory.states, trajectory.durations, ends, strict=True)
        )
        gaps.append(worst / trajectory.peak(k))
    return gaps


def as_ppoly(trajectory) -> PPoly:
    """Return the pieces as scipy's piecewise polynomial."""
    n = trajectory.order
    coefficients = [trajectory.states[:, j] / factorial(j) for j in range(n, -1, -1)]
    return PPoly(np.array(coefficients), trajectory.breaks)


def magnitude(trajectory, derivative: int) -> float:
    """Return a bound on the terms summed to evaluate a derivative: the unit of its rounding."""
    k = derivative
    terms = [
        np.abs(trajectory.states[:, j]) * trajectory.durations ** (j - k) / factorial(j - k)
        for j in range(k, trajectory.order + 1)
    ]
    return float(np.sum(terms, axis=0).max())


def polynomial_extremes(state, duration: float, derivative: int) -> tuple[float, float]:
    """Return minimum and maximum of a piece from the complex roots of its slope."""
    coefficients = [value / factorial(j) for j, value in enumerate(state[derivative:])]
    shape = np.polynomial.Polynomial(coefficients)
    roots = shape.deriv().roots() if len(coefficients) > 2 else np.empty(0)
    near_real = roots.real[np.abs(roots.imag) <= 1e-6 * duration]
    points = np.concatenate([[0.0, duration], np.clip(near_real, 0.0, duration)])
    values = shape(points)
    return float(values.min()), float(values.max())


def spline_states(order: int, digits: int = 60) -> tuple[list, list]:
    """Return switch times and states of the perfect spline 0 → 1 in unit time, with mpmath.

    u alternates between ±(n−1)!·4^(n−1) at sin²(kπ/(2n)); everything else is integrated.
    """
    with mpmath.workdps(digits):
        times = [mpmath.sin(k * mpmath.pi / (2 * order)) ** 2 for k in range(order + 1)]
        bound = mpmath.factorial(order - 1) * mpmath.mpf(4) ** (order - 1)
        state = [mpmath.mpf(0)] * (order + 1)
        states = []
        for i in range(order):
            state[order] = bound if i % 2 == 0 else -bound
            states.append(list(state))
            tau = times[i + 1] - times[i]
            state = [
                mpmath.fsum(state[j] * tau ** (j - k) / mpmath.factorial(j - k)
                            for j in range(k, order + 1))
                for k in range(order + 1)
            ]  # fmt: skip
        states.append(state)
        return times, states


@dataclass(frozen=True)
class Published:
    """A minimum-time move as printed: duration, switch times, peaks of derivatives 1…n."""

    case: str
    duration: float
    switches: tuple[float, ...]
    peaks: tuple[float, ...]


def thompson_order_2(distance: float, velocity: float, acceleration: float) -> Published:
    """Return the order-2 move of Thompson, Section II."""
    ramp = velocity / acceleration
    if distance < velocity**2 / acceleration:
        total = 2.0 * sqrt(distance / acceleration)
        peaks = (sqrt(distance * acceleration), acceleration)
        return Published("no cruise", total, (0.0, total / 2, total), peaks)
    total = ramp + distance / velocity
    switches = (0.0, ramp, total - ramp, total)
    return Published("cruise", total, switches, (velocity, acceleration))


def thompson_order_3(
    distance: float, velocity: float, acceleration: float, jerk: float
) -> Published:
    """Return the order-3 move of Thompson, Section III: the one of his four cases that holds."""
    quarter = (32.0 * distance / jerk) ** (1 / 3) / 4.0
    if jerk * quarter <= acceleration and jerk * quarter**2 <= velocity:
        switches = (0.0, quarter, 3 * quarter, 4 * quarter)
        return Published("1", 4 * quarter, switches, (jerk * quarter**2, jerk * quarter, jerk))
    ramp = acceleration / jerk
    total = ramp + sqrt(ramp**2 + 4.0 * distance / acceleration)
    peak = acceleration * (total / 2 - ramp)
    if total / 2 >= 2 * ramp and peak <= velocity:
        middle = (total / 2 - ramp, total / 2 + ramp)
        switches = (0.0, ramp, *middle, total - ramp, total)
        return Published("2", total, switches, (peak, acceleration, jerk))
    rise = 2.0 * sqrt(velocity / jerk)
    if sqrt(velocity * jerk) <= acceleration:
        total = distance / velocity + rise
        switches = (0.0, rise / 2, rise, total - rise, total - rise / 2, total)
        return Published("3", total, switches, (velocity, sqrt(velocity * jerk), jerk))
    rise = ramp + velocity / acceleration
    total = distance / velocity + rise
    up = (0.0, ramp, rise - ramp, rise)
    switches = (*up, *(total - t for t in reversed(up)))
    return Published("4", total, switches, (velocity, acceleration, jerk))


def farthest_distance(duration: float, limits, nodes, unit: float) -> float:
    """Return how far a rest-to-rest motion gets in a time, by linear programming.

    The highest derivative is constant on each cell between `nodes`; the others are bounded at
    the nodes only, so the answer is high by O(cell²). `unit` is a distance of the answer's size,
    to scale the program by.
    """
    n = limits.order
    scaled = [
        tuple(side * duration**k / unit for side in limits.bounds(k)) for k in range(1, n + 1)
    ]
    cells = np.diff(np.asarray(nodes) / duration)
    maps = _state_maps(cells, n)
    rows, sides = [], []
    for k in range(1, n):
        low, high = scaled[k - 1]
        for sign, side in ((1.0, high), (-1.0, -low)):
            if isfinite(side):
                rows.append(sign * maps[1:-1, k])
                sides.append(np.full(len(cells) - 1, side))
    result = linprog(
        -maps[-1, 0],
        A_ub=np.vstack(rows) if rows else None,
        b_ub=np.concatenate(sides) if sides else None,
        A_eq=maps[-1, 1:n],
        b_eq=np.zeros(n - 1),
        bounds=[scaled[-1]] * len(cells),
        method="highs",
    )
    assert result.status == 0, result.message
    return -result.fun * unit


def _state_maps(cells: np.ndarray, n: int) -> np.ndarray:
    """Return the linear maps (node, derivative, cell) from inputs to the states at the nodes."""
    maps = np.zeros((len(cells) + 1, n, len(cells)))
    for i, h in enumerate(cells):
        for k in range(n):
            for j in range(k, n):
                maps[i + 1, k] += maps[i, j] * h ** (j - k) / factorial(j - k)
            maps[i + 1, k, i] += h ** (n - k) / factorial(n - k)
    return maps
