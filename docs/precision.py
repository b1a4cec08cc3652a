"""Measure what the README promises, on seeded random problems."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from itertools import islice
from math import pi
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))

import references  # noqa: E402  (the tests' own constants)

from jounce.analysis import loop_margins  # noqa: E402
from jounce.plant import Inertia, InertiaFeedforward, ServoLoop, design_pid  # noqa: E402
from jounce.shaping import (  # noqa: E402
    InfeasibleError,
    JerkFilter,
    Limits,
    Trajectory,
    Transfer,
    min_time_move,
    min_time_transfer,
)
from jounce.shaping.moves import Method  # noqa: E402
from jounce.shaping.pieces import advance  # noqa: E402

PROBLEMS = 60  # random moves per order


def random_moves() -> Iterator[tuple[float, Limits, Trajectory]]:
    """Yield moves of order 1 to 10, random bounds, distances and units (12 decades).

    Closed forms, and of orders 4 to 6 the optimal moves, too.
    """
    rng = np.random.default_rng(20260)
    for order in range(1, 11):
        for _ in range(PROBLEMS):
            time, distance = 10.0 ** rng.uniform(-6.0, 6.0, 2)
            bounds = [
                distance / time**k * 10.0 ** rng.uniform(0.0, k)
                if k == order or rng.random() < 0.7
                else None
                for k in range(1, order + 1)
            ]
            limits = Limits.from_bounds(bounds)
            yield distance, limits, min_time_move(distance, limits, method="closed-form")
            if 4 <= order <= 6:
                yield distance, limits, min_time_move(distance, limits)


def random_transfers() -> Iterator[tuple[tuple[float, ...], Limits, Transfer]]:
    """Yield ends, limits and transfers of order 2 and 3, random states, bounds and units."""
    rng = np.random.default_rng(20261)
    while True:
        time, distance = 10.0 ** rng.uniform(-6.0, 6.0, 2)
        order = int(rng.integers(2, 4))
        units = distance / time ** np.arange(order + 1)
        bounds = 10.0 ** rng.uniform(-1.0, 1.0, (order, 2)) * [-1.0, 1.0]
        states = rng.normal(size=(2, order))
        states[:, 1:] = rng.uniform(*bounds[: order - 1].T, (2, order - 1))
        start, end = (tuple((state * units[:order]).tolist()) for state in states)
        limits = Limits.from_bounds([tuple(pair) for pair in (bounds.T * units[1:]).T.tolist()])
        try:
            yield end, limits, min_time_transfer(start, end, limits)
        except InfeasibleError:
            continue


def end_error(end: tuple[float, ...], transfer: Transfer) -> float:
    """Return the largest error of the end state, relative to the peaks on the way."""
    last = advance(transfer.states[-1], float(transfer.durations[-1]))
    return max(abs(last[k] - end[k]) / transfer.peak(k) for k in range(transfer.order))


def jump(move: Trajectory) -> float:
    """Return the largest jump of a derivative below n at a break, relative to its peak."""
    worst = 0.0
    following = [*move.states[1:], move.end_state]
    for state, duration, after in zip(move.states, move.durations, following, strict=True):
        end = advance(state, float(duration))
        for k in range(move.order):
            worst = max(worst, abs(end[k] - after[k]) / max(move.peak(k), 1e-300))
    return worst


def design_error() -> float:
    """Return the largest relative error of the three margins over random specifications."""
    rng = np.random.default_rng(1)
    worst = 0.0
    for _ in range(50):
        asked = rng.uniform(0.1, 100.0), rng.uniform(5.0, 85.0), rng.uniform(1.0, 40.0)
        hz, phase, gain = asked
        pid = design_pid(
            10.0 ** rng.uniform(-6.0, 6.0),
            crossover_hz=hz,
            phase_margin_deg=phase,
            lower_gain_margin_db=gain,
        )
        inertia = pid.kp / ((2 * pi * hz) ** 2 * np.cos(np.radians(phase)))
        found = loop_margins(ServoLoop(Inertia(inertia), pid).loop_transfer())
        got = found.crossover_hz, found.phase_margin_deg, found.lower_gain_margin_db
        worst = max(worst, *(abs(g / a - 1.0) for g, a in zip(got, asked, strict=True)))
    return worst


def feedforward_error() -> float:
    """Return the tracking error with Ĵ = J over the distance, behind a jerk filter."""
    pid = design_pid(1.0, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    loop = ServoLoop(Inertia(1.0), pid, InertiaFeedforward(1.0))
    move = min_time_move(60.0, Limits(acceleration=720.0))
    response = loop.respond(move, 1e-3, duration=10.0, jerk_filter=JerkFilter(2.0, 6))
    return float(np.abs(response.error).max() / 60.0)


def filter_error() -> float:
    """Return the difference between two time grids of a filter's response, over its peak."""
    move = min_time_move(1.0, Limits(acceleration=1.0))
    jerk_filter = JerkFilter(2.0, 6)
    fine = jerk_filter.respond(move, 1e-4, duration=5.0).states[:, ::1000]
    coarse = jerk_filter.respond(move, 1e-1, duration=5.0).states
    peak = np.abs(coarse).max(axis=1)
    return float((np.abs(fine - coarse).max(axis=1) / peak).max())


def gaps(method: Method) -> str:
    """Return the largest excesses over the proven minimum time, by order, as text."""
    text = (ROOT / "tests" / "data" / "minimum_time.json").read_text(encoding="utf-8")
    worst: dict[int, float] = {}
    for problem in json.loads(text)["problems"]:
        order = problem["order"]
        bounds = [problem["bounds"].get(str(k)) for k in range(1, order + 1)]
        duration = min_time_move(
            problem["distance"], Limits.from_bounds(bounds), method=method
        ).duration
        gap = duration / problem["duration_lower"] - 1.0
        worst[order] = max(worst.get(order, 0.0), gap)
    return ", ".join(f"n = {n}: {100 * gap:.2g} %" for n, gap in sorted(worst.items()))


def table() -> str:
    """Return the precision table in Markdown."""
    moves = list(random_moves())
    transfers = list(islice(random_transfers(), 2000))
    rows: list[tuple[str, float, Callable[[], float]]] = [
        (
            "end position of a move, over its distance (orders 1 to 10, 12 decades of units)",
            references.END_POSITION,
            lambda: max(abs(m.end_state[0] / d - 1.0) for d, _, m in moves),
        ),
        (
            "excess over a bound, relative",
            references.BOUND,
            lambda: max(m.violation(limits) for _, limits, m in moves),
        ),
        (
            "jump of a derivative below n at a break, over its peak",
            references.CONTINUITY,
            lambda: max(jump(m) for _, _, m in moves),
        ),
        (
            "end state of a transfer, over the peaks on the way (orders 2 and 3, 12 decades)",
            references.TRANSFER_END,
            lambda: max(end_error(end, t) for end, _, t in transfers),
        ),
        (
            "excess of a transfer over a bound, relative",
            references.TRANSFER_BOUND,
            lambda: max(t.violation(limits) for _, limits, t in transfers if not t.inside_after),
        ),
        ("response on two time grids, 1000 to 1, over its peak", references.RESPONSE, filter_error),
        ("tracking error with Ĵ = J, over the distance", references.RESPONSE, feedforward_error),
        ("margins of a designed PID, relative", references.MARGINS, design_error),
    ]
    lines = ["| quantity | promised | measured |", "| --- | ---: | ---: |"]
    lines += [f"| {name} | {promised:.0e} | {f():.0e} |" for name, promised, f in rows]
    lines += [
        "",
        "Largest excess of a move over the proven minimum time, on the problems of "
        f"`tests/data/minimum_time.json`: {gaps('optimal')}. "
        f"Of the closed forms: {gaps('closed-form')}.",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
