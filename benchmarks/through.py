"""Ten points on three axes: with a stop at each, velocities by hand, and `through`.

Run: python benchmarks/through.py
"""

from __future__ import annotations

from itertools import pairwise
from time import process_time

import numpy as np
from timing import table

from jounce.shaping import Limits, synchronize, through

POINTS = np.random.default_rng(3).uniform(-1.0, 1.0, (10, 3))
BOUNDS = (1.0, 5.0, 50.0, 1e3, 5e4)
SHARES = np.linspace(0.1, 1.5, 15)  # of the mean of the velocities of both legs


def between(speeds: np.ndarray, limits: Limits) -> float:
    """Return the time of all legs with these velocities at the points, each by `synchronize`."""
    legs = zip(pairwise(POINTS), pairwise(speeds), strict=True)
    return sum(
        synchronize(
            [((a, u), (b, w), limits) for a, b, u, w in zip(*places, *rates, strict=True)]
        ).duration
        for places, rates in legs
    )


def by_hand(limits: Limits) -> float:
    """Return the time with velocities of central differences, where an axis does not turn."""
    still = np.zeros_like(POINTS)
    legs = np.array(
        [synchronize([(a, b, limits) for a, b in zip(*leg, strict=True)]).duration
         for leg in pairwise(POINTS)]
    )  # fmt: skip
    rates = np.diff(POINTS, axis=0) / legs[:, None]
    mean = np.where(rates[:-1] * rates[1:] > 0.0, 0.5 * (rates[:-1] + rates[1:]), 0.0)
    best = between(still, limits)
    for share in SHARES:
        speeds = still.copy()
        speeds[1:-1] = np.clip(share * mean, -BOUNDS[0], BOUNDS[0])
        best = min(best, between(speeds, limits))
    return best


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows."""
    found = []
    for name, order, corner, position in (
        ("order 2", 2, 0.0, None),
        ("order 3", 3, 0.0, None),
        ("order 3, within stops", 3, 0.0, (-1.0, 1.0)),
        ("order 3, corners within 0.05", 3, 0.05, None),
        ("order 4", 4, 0.0, None),
        ("order 4, within stops", 4, 0.0, (-1.0, 1.0)),
        ("order 4, corners within 0.05", 4, 0.05, None),
        ("order 5", 5, 0.0, None),
    ):
        limits = Limits.from_bounds(BOUNDS[:order], position=position)
        begin = process_time()
        path = through(POINTS, limits, corner=corner)
        taken = process_time() - begin
        assert max(axis.violation(limits) for axis in path) <= 1e-9
        stops = between(np.zeros_like(POINTS), limits)
        hand = f"{by_hand(limits):.3f} s" if order < 4 and position is None else "—"
        found.append(
            (name, f"{stops:.3f} s", hand, f"{path.duration:.3f} s",
             f"{path.duration / stops:.2f}", f"{taken:.1f} s")
        )  # fmt: skip
    return found


HEADER = ("points passed", "with stops", "by hand", "through", "of stops", "planning, CPU")

if __name__ == "__main__":
    print(table(HEADER, rows()))
