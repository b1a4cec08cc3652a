"""Precision that the README promises, and slow references that share no code with the package."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from math import factorial, inf, isfinite, sqrt
from pathlib import Path

import mpmath
import numpy as np
import pytest
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

TRANSFER_END = 1e-10
"""Error of a transfer's end state, relative to the motion's largest position, velocity, …"""

TRANSFER_BOUND = 1e-10
"""Largest relative excess of a transfer over a bound, once it is inside."""


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


@lru_cache(maxsize=1)
def published_transfers() -> dict[int, tuple[float, list[tuple]]]:
    """Return the problems of data/ruckig_known.json by case: duration, and (start, end, bounds).

    Start, end and bounds of each axis; at order 3 with jerk, bounds as pairs.
    """
    text = (Path(__file__).parent / "data" / "ruckig_known.json").read_text(encoding="utf-8")
    entries = json.loads(text)["problems"]
    return {entry["case"]: (entry["published"], _axes(entry)) for entry in entries}


def _axes(entry: dict) -> list[tuple]:
    kinds = ("position", "velocity", "acceleration")
    start, end = (zip(*(entry[f"{side}_{kind}"] for kind in kinds), strict=True)
                  for side in ("current", "target"))  # fmt: skip
    bounds = []
    for kind in (*kinds[1:], "jerk"):
        high = entry[f"max_{kind}"]
        low = entry.get(f"min_{kind}") or [-x for x in high]
        bounds.append(zip(low, high, strict=True))
    return list(zip(start, end, zip(*bounds, strict=True), strict=True))


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


def reachable_distances(
    problem, duration: float, *, cells: int = 60, switches=()
) -> tuple[float, float] | None:
    """Return how far down and up a motion between two states gets in a time, by linear programs.

    None where nothing leads from velocity and acceleration at the start to those at the end. The
    highest derivative is constant on each of `cells` equal cells, broken at `switches` besides;
    bounds hold at the ends and middles of cells. `problem` has start, end and pairs of `bounds`.
    """
    nodes = np.unique([*np.linspace(0.0, 1.0, cells + 1), *(np.asarray(switches) / duration)])
    nodes = nodes[np.concatenate([[True], np.diff(nodes) > 1e-9]) & (nodes <= 1.0)]
    n = len(problem.bounds)
    maps = _state_maps(np.repeat(np.diff(nodes) / 2.0, 2), n)
    maps = maps[:, :, 0::2] + maps[:, :, 1::2]
    times = np.concatenate([[0.0], np.cumsum(np.repeat(np.diff(nodes) / 2.0, 2))])
    begin, end = ([x * duration**k for k, x in enumerate(s)] for s in (problem.start, problem.end))
    free = [sum(begin[j] * times ** (j - k) / factorial(j - k) for j in range(k, n))
            for k in range(n)]  # fmt: skip
    unit = max(abs(end[0] - begin[0]), *map(abs, begin[1:]), *map(abs, end[1:]), 1e-300)
    scaled = [tuple(side * duration**k / unit for side in pair or (-inf, inf))
              for k, pair in enumerate(problem.bounds, start=1)]  # fmt: skip
    rows, sides = [np.zeros((0, maps.shape[2]))], [np.zeros(0)]
    for k in range(1, n):
        for sign, side in zip((-1.0, 1.0), scaled[k - 1], strict=True):
            if isfinite(side):
                rows.append(sign * maps[1:-1, k])
                sides.append(sign * (side - free[k][1:-1] / unit))
    options = {
        "A_ub": np.vstack(rows),
        "b_ub": np.concatenate(sides),
        "A_eq": maps[-1, 1:n],
        "b_eq": [(end[k] - free[k][-1]) / unit for k in range(1, n)],
        "bounds": [scaled[-1]] * maps.shape[2],
        "method": "highs",
    }
    results = [linprog(sign * maps[-1, 0], **options) for sign in (1.0, -1.0)]
    if any(result.status == 2 for result in results):
        return None
    assert all(result.status == 0 for result in results), [r.message for r in results]
    offset = free[0][-1] - begin[0]
    return results[0].fun * unit + offset, -results[1].fun * unit + offset


def can_take(problem, duration: float, **options) -> bool:
    """Tell whether a problem can be done in a duration, by linear programs."""
    reached = reachable_distances(problem, duration, **options)
    distance = problem.end[0] - problem.start[0]
    return reached is not None and bool(reached[0] <= distance <= reached[1])


def least_duration(problem, longest: float, **options) -> float:
    """Return the least duration that the linear programs find, from a scan up to `longest`.

    A scan first, as the durations that a problem can take need not be an interval.
    """
    step = longest / 25.0
    low = next((k * step for k in range(25) if can_take(problem, (k + 1) * step, **options)), None)
    if low is None:
        return inf
    high = low + step
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if can_take(problem, middle, **options) else (middle, high)
    return high


@dataclass(frozen=True)
class Replay:
    """A motion whose pieces were integrated from what is stored at their starts."""

    gaps: tuple[float, ...]
    """By derivative below n: largest distance from the end of a piece to the next state."""
    extremes: tuple[tuple[float, float], ...]
    """Of position and derivatives 1…n."""


def replay(trajectory, after: float = 0.0) -> Replay:
    """Integrate a trajectory of order 2 or 3 anew; extremes from the piece at `after` on."""
    n = trajectory.order
    rows = [*trajectory.states.tolist(), trajectory.end_state.tolist()]
    seen: list[list[float]] = [[] for _ in range(n + 1)]
    gaps = [0.0] * n
    for i, time in enumerate(trajectory.durations.tolist()):
        if trajectory.breaks[i] >= after * (1.0 - 1e-12):
            turns = [min(max(t, 0.0), time) for t in (0.0, time, *_turns(*rows[i][1:]))]
            for k in range(n + 1):
                seen[k] += [_taylor(rows[i], t, k) for t in turns]
        gaps = [max(gap, abs(_taylor(rows[i], time, k) - rows[i + 1][k]))
                for k, gap in enumerate(gaps)]  # fmt: skip
    extremes = tuple((min(values, default=0.0), max(values, default=0.0)) for values in seen)
    return Replay(tuple(gaps), extremes)


def _turns(velocity: float, acceleration: float, jerk: float = 0.0) -> list[float]:
    """Return the times at which velocity or acceleration vanishes."""
    if not jerk:
        return [-velocity / acceleration] if acceleration else []
    root = sqrt(max(acceleration**2 - 2.0 * jerk * velocity, 0.0))
    return [-acceleration / jerk, (root - acceleration) / jerk, (-root - acceleration) / jerk]


def _taylor(row: list[float], t: float, k: int) -> float:
    return sum(row[j] * t ** (j - k) / factorial(j - k) for j in range(k, len(row)))


def assert_sound_transfer(problem, transfer, inside_after: float = 0.0) -> None:
    """Assert both states, continuity, and the bounds from `inside_after` on.

    Errors are relative to the motion's extent, and to its largest velocity and acceleration;
    positions also to their own rounding, and that of the distance it takes to stop.
    """
    again = replay(transfer, inside_after)
    n = len(problem.start)
    assert transfer.order == n, problem
    assert transfer.start_time == 0.0, problem
    assert transfer.start_state[:n].tolist() == pytest.approx(problem.start, rel=1e-14), problem
    assert transfer.end_state[:n].tolist() == list(problem.end), problem
    assert transfer.end_state[n] == 0.0, problem
    whole = replay(transfer).extremes
    scales = [whole[0][1] - whole[0][0], *(max(high, -low) for low, high in whole[1:])]
    rounding = [_position_rounding(problem), *[0.0] * (n - 1)]
    for k in range(n):
        slack = TRANSFER_END * scales[k] + rounding[k]
        assert again.gaps[k] <= slack, f"{problem}: derivative {k} errs by {again.gaps[k]!r}"
    for k, pair in enumerate(problem.bounds, start=1):
        low, high = pair or (-inf, inf)
        excess = max(again.extremes[k][0] / low, again.extremes[k][1] / high) - 1.0
        assert excess <= TRANSFER_BOUND, f"{problem}: derivative {k} exceeds by {excess!r}"


def _position_rounding(problem) -> float:
    """Return the rounding of the positions given, and of the distance that a stop takes."""
    speed = max(abs(problem.start[1]), abs(problem.end[1]))
    highest = min(map(abs, problem.bounds[-1]))
    if len(problem.bounds) == 2:
        time = speed / highest
    else:
        power = min(map(abs, problem.bounds[1] or (inf,)))
        turn = max(abs(problem.start[2]), abs(problem.end[2])) / highest
        time = speed / power + sqrt(speed / highest) + turn
    return 1e-15 * (abs(problem.start[0]) + abs(problem.end[0]) + 8.0 * speed * time)
