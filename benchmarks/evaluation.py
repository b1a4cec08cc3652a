"""Evaluation of all derivatives of an 11-piece order-6 trajectory, beside numpy and scipy.

Run: python benchmarks/evaluation.py
"""

from __future__ import annotations

from math import factorial
from statistics import median

import numpy as np
from scipy.interpolate import PPoly
from timing import ratio, side_by_side, table

from jounce.shaping import Trajectory

PIECES, ORDER = 11, 6


def example() -> Trajectory:
    """Return a random trajectory (seeded); smoothness does not matter to the cost."""
    rng = np.random.default_rng(11)
    breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, PIECES))])
    return Trajectory(breaks, rng.normal(size=(PIECES, ORDER + 1)))


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: points, our time, and times of the others over ours."""
    trajectory = example()
    coefficients = trajectory.states / [factorial(k) for k in range(ORDER + 1)]
    position = PPoly(coefficients.T[::-1], trajectory.breaks)
    derivatives = [position.derivative(k) if k else position for k in range(ORDER + 1)]
    found = []
    for points in (100, 10_000, 1_000_000):
        times = np.linspace(0.0, trajectory.end_time, points, endpoint=False)
        output = trajectory.evaluate(times)
        ours, copy, scipy_times = side_by_side(
            lambda t=times: trajectory.evaluate(t),
            lambda out=output: out.copy(),
            lambda t=times: np.array([d(t) for d in derivatives]),
        )
        found.append(
            (
                f"{points:.0e}".replace("e+0", "e"),
                f"{1e6 * median(ours):.0f} µs",
                f"{ratio(ours, copy):.1f}",
                f"{ratio(scipy_times, copy):.1f}",
                f"{ratio(scipy_times, ours):.1f}",
            )
        )
    return found


HEADER = ("points", "jounce", "jounce / numpy copy", "PPoly / numpy copy", "PPoly / jounce")

if __name__ == "__main__":
    print(table(HEADER, rows()))
