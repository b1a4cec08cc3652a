"""Planning one rest-to-rest move, limits and objects included, beside ruckig.

Run: python benchmarks/design.py   (needs the `benchmark` extra)
"""

from __future__ import annotations

from statistics import median

import ruckig
from timing import ratio, repeated, side_by_side, table

from jounce.shaping import Limits, min_time_move

CALLS = 500  # per timed run: one call is too short for the clock


def design_ruckig() -> float:
    """Return the duration of the move, planned by ruckig from fresh objects."""
    problem = ruckig.InputParameter(1)
    problem.current_position, problem.target_position = [0.0], [3.0]
    problem.max_velocity, problem.max_acceleration, problem.max_jerk = [1.0], [2.0], [3.0]
    trajectory = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(problem, trajectory)
    return float(trajectory.duration)


def design_jounce() -> float:
    """Return the duration of the same move, planned by jounce from fresh limits."""
    return min_time_move(3.0, Limits(velocity=1.0, acceleration=2.0, jerk=3.0)).duration


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: move, our time, ruckig's time, ratio."""
    assert abs(design_jounce() / design_ruckig() - 1.0) < 1e-12
    ours, theirs = side_by_side(
        lambda: repeated(CALLS, design_jounce),
        lambda: repeated(CALLS, design_ruckig),
    )
    found = [
        (
            "order 3, velocity, acceleration, jerk",
            f"{1e6 * median(ours) / CALLS:.0f} µs",
            f"{1e6 * median(theirs) / CALLS:.1f} µs",
            f"{ratio(ours, theirs):.1f}",
        )
    ]
    for order in (4, 6, 10):
        limits = Limits.from_bounds([10.0**k for k in range(1, order + 1)])
        [taken] = side_by_side(
            lambda bounds=limits: min_time_move(3.0, bounds, method="closed-form"), repeats=50
        )
        name = f"order {order}, all bounded, closed form"
        found.append((name, f"{1e6 * median(taken):.0f} µs", "—", "—"))
    return found


HEADER = ("move", "jounce", "ruckig", "jounce / ruckig")

if __name__ == "__main__":
    print(table(HEADER, rows()))
