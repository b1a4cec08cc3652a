"""Minimum time of symmetric random moves: above proven lower bounds, CPU time; median, worst.

Run: python benchmarks/symmetric_moves.py

Bounds on every derivative, drawn within a decade around the peaks of the perfect spline. A limit is
active if the duration hangs on it. What `optimal` is above the proven bound may be the bound's
fault as well as the move's.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from math import factorial
from statistics import median
from time import process_time, thread_time
from typing import TypeVar

import numpy as np
from timing import table

from jounce.shaping import Limits, certify, min_time_move, perfect_spline
from jounce.shaping.recursive_s_curve import recursive_s_curve

MOVES = {3: 4, 4: 16, 5: 14, 6: 12, 7: 8, 8: 8, 9: 6, 10: 6}  # by order
DECADE = (-0.8, 0.2)  # of each bound around the perfect spline's peak, so that several are active
PROOF = 1e-5  # the gap that certify is asked for
FELT = 1e-4  # relative change of the duration with a limit that makes it an active one

Result = TypeVar("Result")


def random_moves(order: int, count: int) -> list[tuple[float, list[float]]]:
    """Return distances, and bounds around those of the perfect spline in unit time."""
    rng = np.random.default_rng((order, 0))
    found = []
    for distance in 10.0 ** rng.uniform(-1.0, 1.0, count):
        spline = perfect_spline(distance, order, distance * factorial(order - 1) * 4 ** (order - 1))
        peaks = np.array([spline.peak(k) for k in range(1, order + 1)])
        found.append((float(distance), (peaks * 10.0 ** rng.uniform(*DECADE, order)).tolist()))
    return found


def measured(moves: list[tuple[float, list[float]]]) -> tuple[list[int], np.ndarray, np.ndarray]:
    """Return per move how many limits are active, durations over the lower bound, CPU times."""
    problems = [(distance, Limits.from_bounds(bounds)) for distance, bounds in moves]
    # One kind after the other: threads of a proof run out while the next move is planned.
    closed = [
        timed(lambda p=p: min_time_move(*p, method="closed-form"), clock=thread_time)
        for p in problems
    ]
    optimal = [timed(lambda p=p: min_time_move(*p)) for p in problems]
    proofs = [
        timed(lambda m=move, p=p: certify(m, p[1], rtol=PROOF))
        for (move, _), p in zip(optimal, problems, strict=True)
    ]
    active, ratios, seconds = [], [], []
    for problem, (slow, *t1), (move, *t2), (proof, *t3) in zip(
        problems, closed, optimal, proofs, strict=True
    ):
        assert move.violation(problem[1]) <= 1e-12, problem
        assert proof.lower_bound <= move.duration <= slow.duration, problem
        durations = (recursive_s_curve(*problem).duration, slow.duration, move.duration)
        active.append(sum(s < -FELT for s in proof.sensitivities))
        ratios.append([duration / proof.lower_bound for duration in durations])
        seconds.append(t1 + t2 + t3)
    return active, np.array(ratios), np.array(seconds)


def timed(
    call: Callable[[], Result], clock: Callable[[], float] = process_time
) -> tuple[Result, float]:
    """Return what a call returns, and the seconds of CPU time that it took."""
    begin = clock()
    result = call()
    return result, clock() - begin


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: order, moves, active limits, three excesses, three CPU times."""
    found = []
    for order, count in MOVES.items():
        moves = random_moves(order, count)
        measured(moves[:1])  # fills what is computed once per order and process
        gc.disable()
        try:
            active, ratios, seconds = measured(moves)
        finally:
            gc.enable()
        excesses = [f"{pair} %" for pair in _pairs(100.0 * (ratios - 1.0))]
        times = [f"{pair} ms" for pair in _pairs(1e3 * seconds)]
        found.append((f"{order}", f"{count}", f"{median(active):g}", *excesses, *times))
    return found


def _pairs(values: np.ndarray) -> list[str]:
    """Return median and worst of each column, to two digits."""
    both = zip(np.median(values, axis=0), values.max(axis=0), strict=True)
    return [", ".join(f"{float(f'{value:.2g}'):g}" for value in pair) for pair in both]


HEADER = (
    "order",
    "moves",
    "active limits",
    "recursive S-curve, above",
    "closed form, above",
    "optimal, above",
    "closed form",
    "optimal",
    f"certify to {PROOF:g}",
)

if __name__ == "__main__":
    print(table(HEADER, rows()))
