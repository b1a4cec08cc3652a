"""The edge grid: transfers between states at 0, half and full bounds, and what comes of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import product
from math import factorial, isinf

import numpy as np
from references import TRANSFER_BOUND, TRANSFER_END

from jounce.shaping import InfeasibleError, Limits, min_time_transfer

LIMITS = (
    Limits(1.0, 1.0, 1.0),
    Limits(0.01, 1.0, 100.0),
    Limits(10.0, 1.0, 0.5),
    Limits(1.0, 4.0, 1.0),
    Limits((-0.5, 2.0), (-3.0, 1.0), 4.0),
    Limits((-2.0, 0.3), (-1.0, 1.5), (-2.0, 7.0)),
    Limits(1.0, 0.1, (-9.0, 0.5)),
    Limits(acceleration=1.0, jerk=2.0),
    Limits(velocity=1.0, jerk=2.0),
    Limits(3e8, 9.8, 1e-3),
    Limits(2e-9, 3e-6, 0.7),
    Limits(1.0, 1.0),
    Limits((-0.5, 2.0), (-3.0, 1.0)),
    Limits(acceleration=(-1.0, 6.0)),
    Limits(3e8, 9.8),
)
DISTANCES = (0.0, 1e-12, -1e-12, 0.01, -0.01, 0.5, -0.5, 1.0, -20.0)
"""In units of the distance to full velocity and back, or to full acceleration and back."""

OUTCOMES = ("planned", "brought inside", "refused", "refused without reason", "violated", "crashed")

Problem = tuple[tuple[float, ...], tuple[float, ...], Limits]


def problems(every: int = 1, *, fine: bool = False) -> Iterator[Problem]:
    """Yield the problems of the grid, or one in `every`; the fine grid has ten times as many."""
    for number, problem in enumerate(p for limits in LIMITS for p in problems_of(limits, fine)):
        if number % every == 0:
            yield problem


def problems_of(limits: Limits, fine: bool) -> Iterator[Problem]:
    """Yield the problems under these limits."""
    levels = [_levels(limits, k, fine) for k in range(1, limits.order)]
    unit = _distance(limits)
    for begin, end in product(product(*levels), product(*levels)):
        for distance in DISTANCES:
            yield (0.0, *begin), (distance * unit, *end), limits


def _levels(limits: Limits, k: int, fine: bool = False) -> tuple[float, ...]:
    """Return the levels of derivative k: its bounds, half of them, and zero; or near by, too."""
    low, high = limits.bounds(k)
    if isinf(high):  # three times what the other bounds make of one time unit
        low, high = -3.0, 3.0
    shares = (1.0, 1.0 - 1e-9, 0.5, 1e-6) if fine else (1.0, 0.5)
    return *(share * low for share in shares), 0.0, *(share * high for share in shares)


def _distance(limits: Limits) -> float:
    """Return the distance that going to full velocity and acceleration takes."""
    v, a = _levels(limits, 1)[-1], _levels(limits, 2)[-1]
    return v * v / a + (v * a / limits.bounds(3)[1] if limits.order == 3 else 0.0)


def outcome(problem: Problem) -> str:
    """Return what comes of a problem, one of OUTCOMES."""
    start, end, limits = problem
    try:
        transfer = min_time_transfer(start, end, limits)
    except InfeasibleError:
        return "refused" if unreachable(start, end, limits) else "refused without reason"
    except Exception:
        return "crashed"
    return judged(transfer, start, end, limits)


def judged(transfer, start, end, limits: Limits) -> str:
    """Return how a transfer keeps its promises: end state, joints, and bounds once inside."""
    n, after = limits.order, transfer.inside_after
    states, t, last = transfer.states, transfer.durations, transfer.end_state
    if len(states) and not np.array_equal(transfer.start_state[:n], start):
        return "violated"
    within = _within(states, t)
    scale = np.abs(np.vstack([states, within, last])).max(axis=0)[:n]
    scale = np.maximum(scale, 1e-300)
    if any(transfer.start_state[1:n]) or any(end[1:]):
        scale[0] = max(scale[0], abs(_distance(limits)))
    slack = TRANSFER_END * scale
    if n == 3:  # rounding of what the velocity gains until the acceleration is gone
        slack[1] += 1e-15 * scale[2] ** 2 / min(map(abs, limits.bounds(3)))
    if (np.abs(last[:n] - np.array(end)) > slack).any():
        return "violated"
    following = np.vstack([states[1:], last])[: len(t)]
    if (np.abs(_run_on(states, t) - following)[:, :n] > slack).any():
        return "violated"
    inside = transfer.breaks[:-1] >= after * (1.0 - 1e-12)
    seen = np.vstack([states[inside], within[inside], last])
    for k in range(1, n + 1):
        lower, upper = np.array(limits.bounds(k)) * (1.0 + TRANSFER_BOUND)
        if not ((lower <= seen[:, k]) & (seen[:, k] <= upper)).all():
            return "violated"
    return "brought inside" if after else "planned"


def _run_on(states: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the states (m, n + 1) of pieces after times (m,)."""
    n = states.shape[1] - 1
    return np.stack(
        [
            sum(states[:, j] * t ** (j - k) / factorial(j - k) for j in range(k, n + 1))
            for k in range(n + 1)
        ],
        axis=1,
    )


def _within(states: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the states where the velocity turns in each piece, else half way."""
    a, jerk = states[:, 2], states[:, 3] if states.shape[1] > 3 else np.zeros(len(t))
    turn = np.divide(-a, jerk, out=np.zeros(len(t)), where=jerk != 0.0)
    return _run_on(states, np.where((turn > 0.0) & (turn < t), turn, 0.5 * t))


def unreachable(start, end, limits: Limits) -> bool:
    """Tell by quadrature, independently of the planner, that no motion leads to an end.

    Acceleration a1 > 0 at the end either grew from zero, at a velocity of at most
    v1 − a1²/(2·jerk): that is below its bound. Or it was positive from the start on; then
    y = a²/2 is a function of velocity with a slope within the bounds on jerk, and the distance
    ∫ v/a dv lies between those of the highest and the lowest y.
    """
    if any(not low <= end[k] <= high for k, (low, high) in _pairs(limits)):
        return True
    if limits.order == 2 or end[2] == 0.0:
        return False
    if end[2] < 0.0:
        mirrored = ([-value for value in state] for state in (start, end))
        return unreachable(*mirrored, limits.mirror())
    (_, v0, a0), (_, v1, a1) = start, end
    rise = limits.bounds(3)[1]
    if v1 - 0.5 * a1**2 / rise >= limits.bounds(1)[0]:
        return False
    if a0 <= 0.0 or v1 < v0:
        return True
    return not _can_cover(end[0] - start[0], (v0, 0.5 * a0**2), (v1, 0.5 * a1**2), limits)


def _pairs(limits: Limits) -> Iterator[tuple[int, tuple[float, float]]]:
    return ((k, limits.bounds(k)) for k in range(1, limits.order))


def _can_cover(distance, begin, end, limits: Limits) -> bool:
    """Tell whether a distance lies between those of the highest and the lowest y(v)."""
    (v0, y0), (v1, y1) = begin, end
    (low, rise), a_max = limits.bounds(3), limits.bounds(2)[1]
    fall = -low
    if v1 == v0:
        return y0 == y1 and distance == 0.0
    v = v0 + (v1 - v0) * (np.arange(4000) + 0.5) / 4000
    ahead, behind = v - v0, v1 - v
    top = np.minimum(np.minimum(y0 + rise * ahead, y1 + fall * behind), 0.5 * a_max**2)
    bottom = np.maximum(y0 - fall * ahead, y1 - rise * behind)
    if (bottom > top * (1.0 + 1e-9)).any():
        return False
    quick, slow = (v / np.sqrt(2.0 * y) * (v1 - v0) / 4000 for y in (top, bottom))
    least, most = np.minimum(quick, slow).sum(), np.maximum(quick, slow).sum()
    slack = 1e-6 * (np.abs(quick).sum() + np.abs(slow).sum())
    return bool(least - slack <= distance <= most + slack)


def count(some: Iterable[Problem]) -> tuple[Counter[str], list[str]]:
    """Return how many problems come to what, and the calls that went wrong."""
    found: Counter[str] = Counter()
    wrong = []
    for problem in some:
        result = outcome(problem)
        found[result] += 1
        if result in OUTCOMES[3:]:
            start, end, limits = problem
            wrong.append(f"{result}: min_time_transfer({start!r}, {end!r}, {limits!r})")
    return found, wrong
