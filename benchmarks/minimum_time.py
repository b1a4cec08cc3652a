"""Minimum time on random problems of every kind: how many reached, CPU time; what peers have.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/minimum_time.py   (needs the `benchmark` extra)

Bounds of both directions are drawn apart, by up to 10 from rest to rest and 4 between states,
around the peaks of the perfect spline; a fifth of them is absent. Reached is a plan within the gap
that was asked for of its own proof; "none" counts the problems proven to have no motion. Where
there is none the time is that of the proof: the nearest state with one is found when asked for.
"""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass
from math import factorial, inf
from statistics import median
from time import process_time

import numpy as np
import ruckig
from timing import table

from jounce.shaping import (
    InfeasibleError,
    Limits,
    Transfer,
    certify,
    min_time_transfer,
    perfect_spline,
)
from jounce.shaping.recursive_s_curve import recursive_s_curve

KINDS = {  # kind, order, gap: problems
    ("rest to rest", 4, 1e-4): 40,
    ("rest to rest", 4, 1e-5): 40,
    ("between states", 4, 1e-4): 40,
    ("position bounds", 3, 1e-4): 40,
    ("position bounds", 4, 1e-4): 40,
    ("rest to rest", 5, 1e-4): 20,
    ("between states", 5, 1e-4): 20,
    ("rest to rest", 6, 1e-4): 12,
    ("between states", 6, 1e-4): 8,
    ("rest to rest", 7, 1e-4): 10,
    ("rest to rest", 8, 1e-4): 10,
    ("rest to rest", 9, 1e-4): 4,
    ("rest to rest", 10, 1e-4): 4,
}
DECADE = (-0.8, 0.2)  # of each bound around the perfect spline's peak, so that several are active
ABSENT = 0.2
SAME_AS_RUCKIG = 40  # problems of order 3

PUBLISHED = (  # between states, and the minimum time to the digits printed
    (3.999, -0.375, 1.0),
    (4.0, 0.0, 0.0),
    Limits(1.5, 1.0, 1.0, position=(-4.0, 4.0)),
    2.43183,
)

State = tuple[float, ...]


@dataclass(frozen=True)
class Outcome:
    """What came of a problem: the transfer, None where there is none; reached; CPU time."""

    transfer: Transfer | None
    reached: bool
    seconds: float


def random_problem(kind: str, order: int, seed: int) -> tuple[State, State, Limits]:
    """Return start, end and limits; states are inside the bounds, not all can be left."""
    rng = np.random.default_rng((seed, order, *kind.encode()))
    spline = perfect_spline(1.0, order, factorial(order - 1) * 4.0 ** (order - 1))
    peaks = np.array([spline.peak(k) for k in range(1, order + 1)])
    sizes = peaks * 10.0 ** rng.uniform(*DECADE, order)
    apart = (10.0 if kind == "rest to rest" else 4.0) ** rng.uniform(-0.5, 0.5, order)
    pairs = list(zip((-sizes * apart).tolist(), (sizes / apart).tolist(), strict=True))
    for k in range(order - 1):
        if rng.random() < ABSENT:
            pairs[k] = (-inf, inf)
    start, end = [0.0] * order, [1.0, *[0.0] * (order - 1)]
    if kind != "rest to rest":
        for state in (start, end):
            for k in range(1, order):
                low, high = pairs[k - 1] if pairs[k - 1][1] < inf else (-peaks[k - 1], peaks[k - 1])
                state[k] = float(rng.uniform(low, high)) * (0.6 if k < order - 1 else 0.3)
    stops = (-float(rng.uniform(0.0, 0.3)), 1.0 + float(rng.uniform(0.0, 0.3)))
    position = stops if kind == "position bounds" else None
    return tuple(start), tuple(end), Limits.from_bounds(pairs, position=position)


def outcome(problem: tuple[State, State, Limits], rtol: float) -> Outcome:
    """Plan a problem."""
    transfer, refused = None, None
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        begin = process_time()
        try:
            transfer = min_time_transfer(*problem, rtol=rtol)
        except InfeasibleError as error:
            refused = error
        seconds = process_time() - begin
    proven = refused is not None and refused.bound != ""
    assert transfer is None or transfer.violation(problem[2]) <= 1e-12, problem
    return Outcome(transfer, proven if transfer is None else not told, seconds)


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: problems, gap, reached, none, two times, pieces, beside it."""
    return [
        *(_row(kind, order, gap, count) for (kind, order, gap), count in KINDS.items()),
        _beside_ruckig(),
        _published(),
    ]


def _row(kind: str, order: int, gap: float, count: int) -> tuple[str, ...]:
    """Return the row of a kind of problems; the first is not counted, it fills caches."""
    problems = [random_problem(kind, order, seed) for seed in range(count + 1)]
    outcome(problems[0], gap)
    gc.disable()
    try:
        outcomes = [outcome(problem, gap) for problem in problems[1:]]
    finally:
        gc.enable()
    found = [one.transfer for one in outcomes if one.transfer is not None]
    beside = "—"
    if kind == "rest to rest":
        slower = [
            100.0 * (recursive_s_curve(1.0, limits).duration / one.transfer.duration - 1.0)
            for one, (*_, limits) in zip(outcomes, problems[1:], strict=True)
            if one.transfer is not None
        ]
        beside = f"recursion: {median(slower):.2g}, {max(slower):.2g} % above"
    pieces = [len(transfer.states) for transfer in found]
    return (
        f"{kind}, order {order}",
        f"{count}",
        f"{gap:g}",
        f"{sum(one.reached for one in outcomes)}",
        f"{sum(one.reached and one.transfer is None for one in outcomes)}",
        _milliseconds([one.seconds for one in outcomes]),
        f"{median(pieces):g}, {max(pieces)}",
        beside,
    )


def _milliseconds(seconds: list[float]) -> str:
    """Return median, 90th percentile and most."""
    shown = (*np.percentile(seconds, (50.0, 90.0)).tolist(), max(seconds))
    return ", ".join(f"{float(f'{1e3 * value:.2g}'):g}" for value in shown) + " ms"


def _beside_ruckig() -> tuple[str, ...]:
    """Return the row of order 3 without bounds on position, which the core knows, and ruckig."""
    problems = [random_problem("between states", 3, seed) for seed in range(SAME_AS_RUCKIG)]
    seconds, theirs, pieces, apart = [], [], [], []
    for start, end, drawn in problems:
        jerk = min(drawn.upper[2], -drawn.lower[2])  # ruckig's is the same in both directions
        pairs = [drawn.bounds(1), drawn.bounds(2), (-jerk, jerk)]
        problem = start, end, Limits.from_bounds(pairs)
        ours = outcome(problem, 1e-4)
        begin = process_time()
        duration = _ruckig_duration(*problem)
        theirs.append(process_time() - begin)
        seconds.append(ours.seconds)
        if ours.transfer is not None and duration < inf:
            pieces.append(len(ours.transfer.states))
            apart.append(abs(ours.transfer.duration / duration - 1.0))
    return (
        "between states, order 3",
        f"{len(problems)}",
        "exact",
        f"{len(pieces)}",
        f"{len(problems) - len(pieces)}",
        _milliseconds(seconds),
        f"{median(pieces):g}, {max(pieces)}",
        f"ruckig: {1e3 * median(theirs):.2g} ms, durations {max(apart):.0e} apart",
    )


def _ruckig_duration(start: State, end: State, limits: Limits) -> float:
    """Return what ruckig finds, infinite where it refuses the problem."""
    problem, trajectory = ruckig.InputParameter(1), ruckig.Trajectory(1)
    velocity, acceleration, jerk = (limits.bounds(k) for k in (1, 2, 3))
    problem.min_velocity, problem.max_velocity = [velocity[0]], [velocity[1]]
    problem.min_acceleration, problem.max_acceleration = [acceleration[0]], [acceleration[1]]
    problem.max_jerk = [jerk[1]]
    problem.current_position, problem.target_position = [start[0]], [end[0]]
    problem.current_velocity, problem.target_velocity = [start[1]], [end[1]]
    problem.current_acceleration, problem.target_acceleration = [start[2]], [end[2]]
    try:
        result = ruckig.Ruckig(1).calculate(problem, trajectory)
    except RuntimeError:
        return inf
    return trajectory.duration if result == ruckig.Result.Working else inf


def _published() -> tuple[str, ...]:
    """Return the row of the published motion next to a stop."""
    *problem, duration = PUBLISHED
    ours = outcome((problem[0], problem[1], problem[2]), 1e-5)
    assert ours.transfer is not None
    least = certify(ours.transfer, problem[2], rtol=1e-5).lower_bound
    return (
        "next to a stop, order 3",
        "1",
        "1e-05",
        f"{ours.reached:d}",
        "0",
        _milliseconds([ours.seconds]),
        f"{len(ours.transfer.states)}",
        f"published: {duration}; here {least:.6f} to {ours.transfer.duration:.6f}",
    )


HEADER = (
    "problems",
    "number",
    "gap",
    "reached",
    "none",
    "time: median, 90 %, most",
    "pieces: median, most",
    "beside it",
)

if __name__ == "__main__":
    print(table(HEADER, rows()))
