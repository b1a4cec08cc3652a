"""Following a command sample by sample, beside ruckig's update loop.

Run: python benchmarks/following.py   (needs the `benchmark` extra)
"""

from __future__ import annotations

from math import inf
from statistics import median

import numpy as np
import ruckig
from timing import ratio, side_by_side, table

from jounce.shaping import CommandFollower, Limits

SAMPLES = 20_000
DT = 1e-3
BOUNDS = (2.0, 3.0, 8.0)


def commands() -> dict[str, np.ndarray]:
    """Return series of commands: few changes, and one at every sample."""
    time = DT * np.arange(SAMPLES)
    rng = np.random.default_rng(0)
    return {
        "a new target every second": np.repeat(rng.normal(0.0, 3.0, SAMPLES // 1000), 1000),
        "a sine": 3.0 * np.sin(0.5 * time),
        "a random target at every sample": rng.normal(0.0, 3.0, SAMPLES),
    }


def ruckig_loop(targets: list[float], order: int) -> float:
    """Return the last position of ruckig's update loop."""
    problem, output = ruckig.InputParameter(1), ruckig.OutputParameter(1)
    planner = ruckig.Ruckig(1, DT)
    problem.max_velocity, problem.max_acceleration = [BOUNDS[0]], [BOUNDS[1]]
    problem.max_jerk = [BOUNDS[2] if order == 3 else inf]
    for target in targets:
        problem.target_position = [target]
        planner.update(problem, output)
        output.pass_to_input(problem)
    return float(output.new_position[0])


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: commands, our time for a sample, ruckig's, their ratio."""
    found = []
    for order in (2, 3):
        follower = CommandFollower(Limits(*BOUNDS[:order]), dt=DT)
        for name, targets in commands().items():
            some = targets if order == 2 else targets[:2000]
            values = some.tolist()
            ours, theirs = side_by_side(
                lambda: follower.run(some), lambda: ruckig_loop(values, order), repeats=7
            )
            found.append(
                (
                    f"order {order}: {name}",
                    f"{1e6 * median(ours) / len(values):.2f} µs",
                    f"{1e6 * median(theirs) / len(values):.2f} µs",
                    f"{ratio(theirs, ours):.2g}",
                )
            )
    return found


HEADER = ("commands", "jounce, a sample", "ruckig, a sample", "ruckig / jounce")

if __name__ == "__main__":
    print(table(HEADER, rows()))
