"""Rest-to-rest moves by other packages, on the same random problems: duration, defects, time.

Run: python benchmarks/against_peers.py   (needs the `peers` extra; says what is not installed)

Durations (median, worst) are over the least there is: the closed form's at orders 2 and 3, from
order 4 a proven lower bound. Defects are the worst of all moves, read off what each package
samples; "planned" counts the moves without an exception. The moves take about one unit of time and
are 0.1 to 10 long, as some packages round or stop at fixed amounts.
"""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np
from peers import PLANNERS, Move, Plan
from symmetric_moves import PROOF, random_moves
from timing import side_by_side, table

from jounce.shaping import Limits, certify, min_time_move

MOVES = {2: 50, 3: 50, 4: 8, 5: 8, 6: 6}  # by order
POINTS = 2_001  # of each move, for its defects
SUSPECTS = 24  # cells searched for jumps: more than the peers' moves have pieces
HALVINGS = 36
RESOLVED = 1e-11  # relative: what is below may be rounding
TIMED = {100: 15, 10_000: 5, 100_000: 3}  # points sampled, and how often

Problem = tuple[float, list[float]]  # distance, and bounds on derivatives 1…n


@dataclass(frozen=True)
class Defects:
    """Of a move, relative to bounds and distance; and the highest derivative delivered."""

    excess: float
    jump: float
    end: float
    delivered: int


def least_duration(distance: float, bounds: list[float]) -> float:
    """Return the minimum time, or from order 4 a lower bound on it."""
    limits = Limits.from_bounds(bounds)
    move = min_time_move(distance, limits)
    return move.duration if limits.order <= 3 else certify(move, limits, rtol=PROOF).lower_bound


def defects(move: Move, distance: float, bounds: list[float]) -> Defects:
    """Read a move's defects off its samples."""
    times = np.linspace(0.0, move.duration, POINTS)
    states = move.states(times)[: len(bounds) + 1]
    peaks = np.abs(states).max(axis=1).tolist()
    if len(peaks) == len(bounds):  # the highest is not delivered: its means over the cells
        peaks.append(np.abs(np.diff(states[-1]) / np.diff(times)).max())
    excess = max(peak / bound - 1.0 for peak, bound in zip(peaks[1:], bounds, strict=True))
    end = move.states(np.array([move.duration * (1.0 - 1e-12)]))[0, 0]  # not what is set after it
    scales, rest = [distance, *bounds], [distance, *[0.0] * len(bounds)]
    jumps = [
        max(inner_jump(move, k, times, states), abs(states[k, 0]), abs(states[k, -1] - rest[k]))
        / scales[k]
        for k in range(min(len(states), len(bounds)))
    ]
    return Defects(max(excess, 0.0), max(jumps), abs(end / distance - 1.0), len(states) - 1)


def inner_jump(move: Move, k: int, times: np.ndarray, states: np.ndarray) -> float:
    """Return the largest jump of derivative k within a move.

    The cells, of two samples each, that have the most unexplained change are halved until nothing
    but a jump is left of it.
    """
    three = [slice(i, len(times) - 2 + i, 2) for i in range(3)]
    nodes, values = (np.stack([x[..., part] for part in three], axis=-2) for x in (times, states))
    cells = np.argsort(unexplained(nodes, values, k))[-SUSPECTS:]
    low, high = nodes[0, cells], nodes[2, cells]
    for _ in range(HALVINGS):
        nodes = np.linspace(low, high, 5)
        values = move.states(nodes.ravel()).reshape(-1, *nodes.shape)
        left, right = (unexplained(nodes[i : i + 3], values[:, i : i + 3], k) for i in (0, 2))
        low, high = np.where(left >= right, nodes[[0, 2]], nodes[[2, 4]])
    return float(np.abs(move.states(high)[k] - move.states(low)[k]).max())


def unexplained(times: np.ndarray, states: np.ndarray, k: int) -> np.ndarray:
    """Return by cell what no smooth derivative k would have, from its ends and middle.

    That is its change less Simpson's integral of the next derivative, or where that is not
    delivered its second difference. `times` (3, cells) and `states` (derivatives, 3, cells).
    """
    first, middle, last = states[k]
    if k + 1 == len(states):
        return np.abs(first - 2.0 * middle + last)
    mean = (states[k + 1] * np.array([[1.0], [4.0], [1.0]])).sum(axis=0) / 6.0
    return np.abs(last - first - (times[2] - times[0]) * mean)


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: order, package, moves planned, their quality, times."""
    with redirect_stdout(io.StringIO()):  # some packages print
        return [row for order, count in MOVES.items() for row in rows_of_order(order, count)]


def rows_of_order(order: int, count: int) -> list[tuple[str, ...]]:
    """Plan the problems of an order with every package that can."""
    problems = random_moves(order, count)
    least = [least_duration(*problem) for problem in problems]
    plans, absent = {}, []
    for planner in PLANNERS:
        if order in planner.orders:
            try:
                plans[planner.name] = planner.prepare(order)
            except ImportError:
                absent.append((f"{order}", planner.name, "not installed", *["—"] * 7))
    moves = {name: [planned(plan, problem) for problem in problems] for name, plan in plans.items()}
    design, sampling = design_times(plans, moves, problems), sampling_times(moves)
    found = [
        (f"{order}", name, *qualities(some, problems, least), design[name], sampling[name])
        for name, some in moves.items()
    ]
    return found + absent


def planned(plan: Plan, problem: Problem) -> Move | None:
    """Return the move, or None where the package refuses or fails."""
    try:
        move = plan(*problem)
    except Exception:  # whatever a package raises, it has no answer
        return None
    return move if 0.0 < move.duration < np.inf else None


def qualities(
    moves: list[Move | None], problems: list[Problem], least: list[float]
) -> tuple[str, ...]:
    """Return how many were planned, durations (median, worst), three defects, derivatives."""
    done = [i for i, move in enumerate(moves) if move is not None]
    count = f"{len(done)} of {len(moves)}"
    if not done:
        return count, *["—"] * 5
    ratios = [moves[i].duration / least[i] for i in done]
    found = [defects(moves[i], *problems[i]) for i in done]
    worst = (max(getattr(d, kind) for d in found) for kind in ("excess", "jump", "end"))
    return (
        count,
        f"{median(ratios):.4f}, {max(ratios):.4f}",
        *("0" if w < RESOLVED else f"{w:.2g}" for w in worst),
        f"{found[0].delivered} of {len(problems[0][1])}",
    )


def design_times(
    plans: dict[str, Plan], moves: dict[str, list[Move | None]], problems: list[Problem]
) -> dict[str, str]:
    """Return the median time of planning a move."""
    found = {}
    for name, plan in plans.items():
        able = [problem for problem, move in zip(problems, moves[name], strict=True) if move]
        calls = [partial(plan, *problem) for problem in able]
        found[name] = _time([taken for [taken] in side_by_side(*calls, repeats=1)])
    return found


def sampling_times(moves: dict[str, list[Move | None]]) -> dict[str, str]:
    """Return times of sampling each package's first move at ever more points."""
    first = {name: next(filter(None, some), None) for name, some in moves.items()}
    able = {name: move for name, move in first.items() if move is not None}
    found: dict[str, list[str]] = {name: [] for name in moves}
    for points, repeats in TIMED.items():
        calls = [
            partial(move.sample, np.linspace(0.0, move.duration, points)) for move in able.values()
        ]
        for name, taken in zip(able, side_by_side(*calls, repeats=repeats), strict=True):
            found[name].append(_time(taken))
    return {name: ", ".join(times) or "—" for name, times in found.items()}


def _time(seconds: list[float]) -> str:
    if not seconds:
        return "—"
    unit, factor = ("ms", 1e3) if median(seconds) >= 1e-3 else ("µs", 1e6)
    return f"{float(f'{factor * median(seconds):.2g}'):g} {unit}"


HEADER = (
    "order",
    "package",
    "planned",
    "duration / least: median, worst",
    "worst over a bound",
    "worst jump",
    "worst end error",
    "derivatives sampled",
    "design",
    "sampling 1e2, 1e4, 1e5 points",
)

if __name__ == "__main__":
    print(table(HEADER, rows()))
