"""Many rest-to-rest problems at once: random ones, and the same moves one by one."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial, inf

import numpy as np
from hypothesis import strategies as st
from references import move_text

from jounce.shaping import Limits, MotionBatch, Trajectory, min_time_move, min_time_moves


@dataclass(frozen=True, repr=False)
class MoveProblem:
    """A distance, a start, and pairs of bounds, infinite where there is none."""

    distance: float
    start: float
    bounds: tuple[tuple[float, float], ...]

    def __repr__(self) -> str:
        shown = [None if pair == (-inf, inf) else pair for pair in self.bounds]
        return f"{move_text(self.distance, shown)} from {self.start!r}"

    @property
    def limits(self) -> Limits:
        """The bounds as limits."""
        return Limits.from_bounds(self.bounds)

    def move(self) -> Trajectory:
        """Return the move alone."""
        return min_time_move(self.distance, self.limits, start=self.start, method="closed-form")


def random_moves(
    seed, order: int, count: int, *, decades: float = 3.0, even: bool = True
) -> list[MoveProblem]:
    """Return problems whose bounds are around those of a unit move, or that many decades off.

    A third of the bounds below the highest is missing; unless `even`, those of both directions
    differ.
    """
    rng = np.random.default_rng(seed)
    typical = [4.0**k * factorial(k) for k in range(order)]
    problems = []
    for _ in range(count):
        high = typical * 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, order)
        high[:-1][rng.random(order - 1) < 1 / 3] = inf
        low = -high if even else -high * 10.0 ** rng.uniform(-1.0, 1.0, order)
        distance, start = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-1.0, 1.0), rng.normal()
        pairs = tuple(zip(low.tolist(), high.tolist(), strict=True))
        problems.append(MoveProblem(float(distance), float(start), pairs))
    return problems


@st.composite
def move_lists(draw, decades: float = 12.0) -> list[MoveProblem]:
    """Draw up to five problems of one order 1 to 6, some distances zero, some bounds missing."""
    order = draw(st.integers(1, 6))
    exponents = st.floats(-0.5 * decades, 0.5 * decades)
    even = draw(st.booleans())
    problems = []
    for _ in range(draw(st.integers(1, 5))):
        pairs = []
        for k in range(1, order + 1):
            high = 4.0 ** (k - 1) * factorial(k - 1) * 10.0 ** draw(exponents)
            low = high if even else high * draw(st.floats(0.25, 4.0))
            missing = k < order and draw(st.integers(0, 2)) == 0
            pairs.append((-inf, inf) if missing else (-low, high))
        distance = draw(st.sampled_from([-1.0, 1.0, 0.0, -1e3, 1e-3]))
        problems.append(MoveProblem(distance, draw(st.sampled_from([0.0, 7.5])), tuple(pairs)))
    return problems


def many_limits(bounds) -> Limits:
    """Return the limits of problems (N, n) of magnitudes or (N, n, 2) of pairs."""
    return Limits.from_bounds(np.moveaxis(np.asarray(bounds), 1, 0))


def together(problems) -> MotionBatch:
    """Return the batch of all problems."""
    distances, starts, bounds = zip(
        *((p.distance, p.start, p.bounds) for p in problems), strict=True
    )
    return min_time_moves(distances, many_limits(np.array(bounds)), start=starts)


def as_trajectory(batch: MotionBatch, i: int) -> Trajectory:
    """Return a move as a trajectory of the batch's own pieces."""
    breaks, durations, states = (rows[i] for rows in batch.pieces())
    some = durations > 0.0
    steps = [*breaks[:-1][some], breaks[-1]]
    return Trajectory(steps, states[some], durations[some], batch.end_state[i])
