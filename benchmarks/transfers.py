"""State-to-state transfers, 1e5 problems at once and one by one, beside ruckig.

Run: python benchmarks/transfers.py   (needs the `benchmark` extra)
"""

from __future__ import annotations

from math import inf
from statistics import median

import numpy as np
import ruckig
from timing import ratio, side_by_side, table

from jounce.shaping import Limits, min_time_transfer, min_time_transfers, synchronize

PROBLEMS = 100_000
SINGLES = 500  # of them, planned one by one
BOUNDS = (2.0, 3.0, 8.0)


def random_states(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts and ends (N, order) from which and to which bounds can be kept."""
    rng = np.random.default_rng(order)
    starts, ends = rng.uniform(-0.6, 0.6, (2, PROBLEMS, order)) * [1.0, *BOUNDS[: order - 1]]
    ends[:, 0] = rng.normal(0.0, 3.0, PROBLEMS)
    return starts, ends


def ruckig_durations(starts: list[list[float]], ends: list[list[float]], order: int) -> list[float]:
    """Return the durations that ruckig finds, its objects made once."""
    problem, trajectory, planner = (
        ruckig.InputParameter(1),
        ruckig.Trajectory(1),
        ruckig.Ruckig(1),
    )
    problem.max_velocity, problem.max_acceleration = [BOUNDS[0]], [BOUNDS[1]]
    problem.max_jerk = [BOUNDS[2] if order == 3 else inf]
    durations = []
    for start, end in zip(starts, ends, strict=True):
        problem.current_position, problem.current_velocity = start[:1], start[1:2]
        problem.target_position, problem.target_velocity = end[:1], end[1:2]
        if order == 3:
            problem.current_acceleration, problem.target_acceleration = start[2:], end[2:]
        planner.calculate(problem, trajectory)
        durations.append(trajectory.duration)
    return durations


def seven_axes() -> None:
    """Plan seven axes to start and end together."""
    limits = Limits(*BOUNDS)
    synchronize([((0.0, 0.1 * k), 10.0 ** (k - 3), limits) for k in range(7)])


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: problems, our time for one, ruckig's, their ratio."""
    found = []
    for order in (2, 3):
        starts, ends = random_states(order)
        limits = Limits(*BOUNDS[:order])
        lists = starts.tolist(), ends.tolist()
        batch = min_time_transfers(starts, ends, limits).duration
        theirs = np.array(ruckig_durations(*lists, order))
        assert np.abs(batch / theirs - 1.0).max() < 1e-9
        together, peer = side_by_side(
            lambda: min_time_transfers(starts, ends, limits),
            lambda: ruckig_durations(*lists, order),
            repeats=7,
        )
        found.append(_row(f"order {order}, 1e5 at once", together, peer, PROBLEMS, PROBLEMS))
        some = [rows[:SINGLES] for rows in lists]
        single, peer = side_by_side(
            lambda: [min_time_transfer(a, b, limits) for a, b in zip(*some, strict=True)],
            lambda: ruckig_durations(*some, order),
        )
        found.append(_row(f"order {order}, one by one", single, peer, SINGLES, SINGLES))
    [axes] = side_by_side(seven_axes, repeats=50)
    found.append(("7 axes of order 3, together", f"{1e6 * median(axes):.0f} µs", "—", "—"))
    return found


def _row(name: str, ours: list[float], theirs: list[float], n: int, m: int) -> tuple[str, ...]:
    return (
        name,
        f"{1e6 * median(ours) / n:.2f} µs",
        f"{1e6 * median(theirs) / m:.2f} µs",
        f"{ratio(theirs, ours) * n / m:.2g}",
    )


HEADER = ("problems", "jounce, each", "ruckig, each", "ruckig / jounce")

if __name__ == "__main__":
    print(table(HEADER, rows()))
