"""Rest-to-rest moves, 1e5 at once, beside ruckig planning them one by one.

Run: python benchmarks/moves.py   (needs the `benchmark` extra)
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from math import inf
from statistics import median

import numpy as np
import ruckig
from timing import ratio, side_by_side, table

from jounce.shaping import Limits, min_time_moves

PROBLEMS = 100_000
SAMPLED = 2_000  # of them, on a common grid of POINTS times
POINTS = 1_000
MANY = 1_000_000  # whose memory is measured
BOUNDS = (2.0, 3.0, 8.0, 60.0, 600.0, 9000.0)


def random_distances(count: int) -> np.ndarray:
    """Return distances over four decades, so that every bound is reached by some and not by all."""
    rng = np.random.default_rng(0)
    return rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-2.0, 2.0, count)


def ruckig_durations(distances: list[float], order: int) -> list[float]:
    """Return the durations that ruckig finds, its objects made once."""
    problem, trajectory, planner = (
        ruckig.InputParameter(1),
        ruckig.Trajectory(1),
        ruckig.Ruckig(1),
    )
    problem.max_velocity, problem.max_acceleration = [BOUNDS[0]], [BOUNDS[1]]
    problem.max_jerk = [BOUNDS[2] if order == 3 else inf]
    problem.current_position = [0.0]
    durations = []
    for distance in distances:
        problem.target_position = [distance]
        planner.calculate(problem, trajectory)
        durations.append(trajectory.duration)
    return durations


def ruckig_samples(distances: list[float], times: list[float]) -> None:
    """Evaluate ruckig's moves of order 3 at given times, planning not included."""
    problem, planner = ruckig.InputParameter(1), ruckig.Ruckig(1)
    problem.max_velocity, problem.max_acceleration, problem.max_jerk = ([b] for b in BOUNDS[:3])
    for distance in distances:
        problem.target_position = [distance]
        trajectory = ruckig.Trajectory(1)
        planner.calculate(problem, trajectory)
        for t in times:
            trajectory.at_time(t)


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: moves, our time for one, ruckig's, their ratio, our memory."""
    return [*planning_rows(), *sampling_rows(), sweep_row()]


def planning_rows() -> list[tuple[str, ...]]:
    """Return the rows of orders 2 to 6; beyond order 3 ruckig has no answer."""
    distances, found = random_distances(PROBLEMS), []
    given = distances.tolist()
    for order in (2, 3):
        limits = Limits(*BOUNDS[:order])
        theirs = np.array(ruckig_durations(given, order))
        error = np.abs(min_time_moves(distances, limits).duration / theirs - 1.0).max()
        assert error < 1e-12, error
        plan = lambda: min_time_moves(distances, limits)  # noqa: E731
        pieces = lambda: min_time_moves(distances, limits).pieces()  # noqa: E731
        planned, with_pieces, peer = side_by_side(
            plan, pieces, lambda: ruckig_durations(given, order), repeats=7
        )
        found.append(_row(f"order {order}", planned, peer, plan))
        found.append(_row(f"order {order}, with all pieces", with_pieces, peer, pieces))
    velocity, acceleration, jerk = np.random.default_rng(1).uniform(1.0, 3.0, (3, PROBLEMS))
    uneven = Limits(2.0, (-4.0, 3.0), (-6.0, 8.0))
    for name, limits in (
        ("order 3, a velocity bound each", Limits(velocity, 3.0, 8.0)),
        ("order 3, three bounds each", Limits(velocity, acceleration, jerk)),
        ("order 3, other bounds backwards", uneven),
        ("order 4", Limits(*BOUNDS[:4])),
        ("order 6", Limits(*BOUNDS)),
    ):
        plan = lambda: min_time_moves(distances, limits)  # noqa: E731
        [taken] = side_by_side(plan, repeats=5)
        found.append(_row(name, taken, peer if "3" in name else None, plan))
    return found


def sampling_rows() -> list[tuple[str, ...]]:
    """Return rows for values on a common grid: everything for one value."""
    distances = random_distances(SAMPLED)
    limits, times = Limits(*BOUNDS[:3]), np.linspace(0.0, 5.0, POINTS)
    batch, few = min_time_moves(distances, limits), distances[:20].tolist()
    alone = [batch[i](times) for i in range(20)]
    assert np.abs(batch[:20](times) - alone).max() < 1e-11
    position, states, peer = side_by_side(
        lambda: batch(times),
        lambda: batch.evaluate(times),
        lambda: ruckig_samples(few, times.tolist()),
        repeats=7,
    )
    ours, theirs = SAMPLED * POINTS, len(few) * POINTS
    return [
        _row("order 3, position at a time", position, peer, None, ours, theirs),
        _row("order 3, four derivatives at a time", states, peer, None, ours, theirs),
    ]


def sweep_row() -> tuple[str, ...]:
    """Return the row of a sweep over a million moves of order 3."""
    distances, limits = random_distances(MANY), Limits(*BOUNDS[:3])
    plan = lambda: min_time_moves(distances, limits)  # noqa: E731
    [taken] = side_by_side(plan, repeats=3)
    return _row("order 3, 1e6 at once", taken, None, plan, MANY)


def _row(
    name: str,
    ours: list[float],
    theirs: list[float] | None,
    call: Callable[[], object] | None,
    count: int = PROBLEMS,
    peers: int = PROBLEMS,
) -> tuple[str, ...]:
    peer, quotient = "—", "—"
    if theirs is not None:
        peer = f"{1e9 * median(theirs) / peers:.0f} ns"
        quotient = f"{ratio(theirs, ours) * count / peers:.3g}"
    memory = _memory(call, count) if call else "8 B a value"
    return name, f"{1e9 * median(ours) / count:.1f} ns", peer, quotient, memory


def _memory(call: Callable[[], object], count: int) -> str:
    """Return bytes that a result keeps per move, and those in use beside while it is made."""
    tracemalloc.start()
    try:
        result = call()
        kept, most = tracemalloc.get_traced_memory()
        del result
    finally:
        tracemalloc.stop()
    return f"{kept / count:.0f} B + {1e-6 * (most - kept):.1f} MB"


HEADER = ("moves", "jounce, each", "ruckig, each", "ruckig / jounce", "memory, each + beside")

if __name__ == "__main__":
    print(table(HEADER, rows()))
