"""Hypothesis strategies: limits, and problems as plain numbers that can be pasted and re-run."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import factorial, inf, sqrt

import numpy as np
from hypothesis import strategies as st

from jounce.shaping import CommandFollower, Limits, Trajectory, Transfer, min_time_transfer
from jounce.shaping.transfers.problem import Problem

MAGNITUDES = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)
UNIT_FACTORS = st.sampled_from([1e-6, 1e-3, 1.0, 1e3, 1e6])


@st.composite
def bound_lists(draw, min_order: int = 1, max_order: int = 6) -> list[float | None]:
    """Draw bounds for a unit distance, velocity first: any subset, the last one present.

    They lie around those of the perfect spline in unit time, so that all of them matter.
    """
    order = draw(st.integers(min_order, max_order))
    bounds: list[float | None] = []
    for k in range(1, order + 1):
        if k < order and draw(st.booleans()):
            bounds.append(None)
        else:
            typical = 4.0 ** (k - 1) * factorial(k - 1)
            bounds.append(typical * 10.0 ** draw(st.floats(-1.0, 1.5)))
    return bounds


@st.composite
def bound_pairs(draw, min_order: int = 1, max_order: int = 3) -> list[tuple[float, float] | None]:
    """Draw bounds that differ between the directions by up to a factor of 16."""
    symmetric = draw(bound_lists(min_order, max_order))
    skews = st.floats(0.25, 4.0)
    return [b and (-b * draw(skews), b * draw(skews)) for b in symmetric]


@st.composite
def any_limits(draw) -> Limits:
    """Draw limits of order 1 to 9 with numbers, pairs, one-sided pairs and gaps."""
    sides = st.floats(1e-300, 1e300)
    one_sided = sides.map(lambda side: (-np.inf, side)) | sides.map(lambda side: (-side, np.inf))
    pairs = st.tuples(sides.map(lambda side: -side), sides)
    bound = st.none() | sides | pairs | one_sided
    highest = sides | pairs | one_sided
    return Limits.from_bounds([*draw(st.lists(bound, max_size=8)), draw(highest)])


def any_trajectory(seed: int, order: int, pieces: int = 5, start: float = -0.7) -> Trajectory:
    """Return random pieces that jump in every derivative, position included."""
    rng = np.random.default_rng(seed)
    breaks = start + np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.5, pieces))])
    return Trajectory(breaks, rng.normal(size=(pieces, order + 1)))


def smooth_trajectory(seed: int, order: int, pieces: int = 5, start: float = -0.7) -> Trajectory:
    """Return random pieces continuous in every derivative below the highest, moving at both ends.

    Integrated here with numpy's polynomials.
    """
    rng = np.random.default_rng(seed)
    durations = rng.uniform(0.2, 1.5, pieces)
    state, states = rng.normal(size=order + 1), []
    for duration in durations:
        state[-1] = rng.normal()
        states.append(state.copy())
        piece = np.polynomial.Polynomial([x / factorial(j) for j, x in enumerate(state)])
        state = np.array([piece.deriv(k)(duration) if k else piece(duration)
                          for k in range(order + 1)])  # fmt: skip
    breaks = start + np.concatenate([[0.0], np.cumsum(durations)])
    return Trajectory(breaks, states)


@dataclass(frozen=True, repr=False)
class TransferProblem:
    """Two states (position, velocity, and acceleration at order 3) and pairs of bounds."""

    start: tuple[float, ...]
    end: tuple[float, ...]
    bounds: tuple[tuple[float, float] | None, ...]

    def __repr__(self) -> str:
        return (
            f"min_time_transfer({self.start!r}, {self.end!r}, "
            f"Limits.from_bounds({list(self.bounds)!r}))"
        )

    def problem(self) -> Problem:
        """Return what plans other motions of it than the fastest."""
        return Problem(self.start, self.end, self.limits)

    def solve(self) -> Transfer:
        """Return the transfer."""
        return min_time_transfer(self.start, self.end, self.limits)

    @property
    def limits(self) -> Limits:
        """The bounds as limits."""
        return Limits.from_bounds(self.bounds)

    def mirrored(self) -> TransferProblem:
        """Return the problem in the opposite direction."""
        return TransferProblem(
            tuple(-x for x in self.start),
            tuple(-x for x in self.end),
            tuple(pair and (-pair[1], -pair[0]) for pair in self.bounds),
        )

    def backwards(self) -> TransferProblem:
        """Return the problem run backwards in time: odd derivatives change their sign."""
        start, end = (tuple(x * (-1.0) ** k for k, x in enumerate(s))
                      for s in (self.end, self.start))  # fmt: skip
        turned = self.mirrored().bounds
        bounds = [turned[k] if k % 2 == 0 else pair for k, pair in enumerate(self.bounds)]
        return TransferProblem(start, end, tuple(bounds))

    def in_units(self, distance: float, time: float) -> TransferProblem:
        """Return the problem with numbers in other units: one of each is `distance`, `time`."""
        factors = [distance / time**k for k in range(4)]
        start, end = (tuple(x * f for x, f in zip(s, factors, strict=False))
                      for s in (self.start, self.end))  # fmt: skip
        bounds = (pair and (pair[0] * f, pair[1] * f)
                  for pair, f in zip(self.bounds, factors[1:], strict=False))  # fmt: skip
        return TransferProblem(start, end, tuple(bounds))

    def keeping(self, share: float = 1.0) -> TransferProblem:
        """Return the problem with accelerations at most `share` of what keeps velocity bounds."""
        if len(self.bounds) == 2:
            return self
        (v_min, v_max), (fall, rise) = self.bounds[0] or (-inf, inf), self.bounds[2]
        _, v0, a0 = self.start
        _, v1, a1 = self.end
        up, down = sqrt(2.0 * -fall * (v_max - v0)), sqrt(2.0 * rise * (v0 - v_min))
        a0 = min(max(a0, -share * down), share * up)
        up, down = sqrt(2.0 * rise * (v1 - v_min)), sqrt(2.0 * -fall * (v_max - v1))
        a1 = min(max(a1, -share * down), share * up)
        return TransferProblem((*self.start[:2], a0), (*self.end[:2], a1), self.bounds)


@st.composite
def transfer_problems(draw, orders=(2, 3)) -> TransferProblem:
    """Draw a problem that can be done without leaving its bounds.

    Bounds differ between the directions or not, and may be missing below the highest; velocity
    and acceleration at both ends are zero, half or full bounds, or anything between.
    """
    order = draw(st.sampled_from(orders))
    bounds: list[tuple[float, float] | None] = []
    for k in range(1, order + 1):
        low, high = (10.0 ** draw(st.floats(-1.0, 1.0)) for _ in range(2))
        missing = k < order and draw(st.integers(0, 3)) == 0
        bounds.append(None if missing else (-high if draw(st.booleans()) else -low, high))
    parts = st.integers(-64, 64).map(lambda part: part / 64.0) | st.floats(-1.0, 1.0, width=16)
    states = [[0.0], [draw(parts) * 10.0 ** draw(st.floats(-2.0, 1.0))]]
    for state in states:
        for pair in bounds[:-1]:
            low, high = pair or (-3.0, 3.0)
            part = draw(parts)
            state.append(part * high if part >= 0.0 else -part * low)
    return TransferProblem(*map(tuple, states), tuple(bounds)).keeping()


def random_transfer(rng: np.random.Generator, order: int = 3, even_jerk: bool = False):
    """Return a problem of generic numbers: nothing on a border between two cases."""
    pairs = [(-high if rng.random() < 0.3 else -low, high)
             for low, high in 10.0 ** rng.uniform(-1.0, 1.0, (order, 2))]  # fmt: skip
    if even_jerk:
        pairs[-1] = (-pairs[-1][1], pairs[-1][1])
    bounds = tuple((float(low), float(high)) for low, high in pairs)
    start, end = (
        (float(x), *(float(rng.uniform(*pair)) for pair in bounds[:-1]))
        for x in (rng.normal(), rng.normal() * 10.0 ** rng.uniform(-1.0, 1.0))
    )
    return TransferProblem(start, end, bounds).keeping(0.95)


@dataclass(frozen=True, repr=False)
class Following:
    """A start, pairs of bounds, and what a follower is commanded, sample by sample."""

    start: tuple[float, ...]
    bounds: tuple[tuple[float, float] | None, ...]
    dt: float
    commands: tuple[float, ...]
    velocities: tuple[float, ...] | None = None
    period: float | None = None

    def __repr__(self) -> str:
        speeds = self.velocities and list(self.velocities)
        return (
            f"CommandFollower(Limits.from_bounds({list(self.bounds)!r}), dt={self.dt!r}, "
            f"period={self.period!r}).run({list(self.commands)!r}, command_velocities={speeds!r}, "
            f"initial={self.start!r})"
        )

    @property
    def order(self) -> int:
        """Order of the limits."""
        return len(self.bounds)

    @property
    def limits(self) -> Limits:
        """The bounds as limits."""
        return Limits.from_bounds(self.bounds)

    def follower(self, jerk_filter=None) -> CommandFollower:
        """Return the follower."""
        return CommandFollower(self.limits, dt=self.dt, period=self.period, jerk_filter=jerk_filter)

    def states(self) -> np.ndarray:
        """Return the states from the start on, one more column than commands."""
        given = {"command_velocities": self.velocities, "initial": self.start}
        response = self.follower().run(self.commands, **given)
        begin = [*self.start, *[0.0] * (self.order + 1 - len(self.start))]
        return np.column_stack([begin, response.states])

    def steps(self, jerk_filter=None) -> list[tuple[float, ...]]:
        """Return what `step` returns, in a loop."""
        follower, state, found = self.follower(jerk_filter), self.start, []
        for command, velocity in zip(self.commands, self.speeds, strict=True):
            state = follower.step(state, command, velocity)
            found.append(state)
        return found

    @property
    def speeds(self) -> tuple[float, ...]:
        """The velocities, zeros where there are none."""
        return self.velocities or (0.0,) * len(self.commands)

    def in_units(self, distance: float, time: float) -> Following:
        """Return the same with numbers in other units: one of each is `distance`, `time`."""
        problem = TransferProblem(self.start, self.start, self.bounds).in_units(distance, time)
        return Following(
            problem.start,
            problem.bounds,
            self.dt * time,
            tuple(r * distance for r in self.commands),
            self.velocities and tuple(u * (distance / time) for u in self.velocities),
            self.period and self.period * distance,
        )

    def motion(self, states: np.ndarray) -> Trajectory:
        """Return the motion inside the samples: the transfer that begins in each state.

        Towards rest at the command, as seen from the command, whose velocity its bounds are
        shifted by. `states` are those from the start on.
        """
        rows, lengths, n = [], [], self.order
        for state, command, velocity in zip(
            states.T.tolist(), self.commands, self.speeds, strict=False
        ):
            if self.period is not None:
                command += self.period * round((state[0] - command) / self.period)
            seen = [pair and (pair[0] - velocity, pair[1] - velocity) for pair in self.bounds[:1]]
            start = (state[0] - command, state[1] - velocity, *state[2:n])
            limits = Limits.from_bounds([*seen, *self.bounds[1:]])
            transfer = min_time_transfer(start, 0.0, limits)
            edges = [0.0, *(t for t in transfer.breaks.tolist() if 0.0 < t < self.dt), self.dt]
            for t, later in pairwise(edges):
                row = transfer.evaluate(t)
                row[:2] += command + velocity * t, velocity
                rows.append(row)
                lengths.append(later - t)
        breaks = np.concatenate([[0.0], np.cumsum(lengths)])
        return Trajectory(breaks, rows, lengths, [*states[:n, -1], 0.0])

    def mirrored(self) -> Following:
        """Return the same in the opposite direction."""
        problem = TransferProblem(self.start, self.start, self.bounds).mirrored()
        return Following(
            problem.start,
            problem.bounds,
            self.dt,
            tuple(-r for r in self.commands),
            self.velocities and tuple(-u for u in self.velocities),
            self.period,
        )


COMMANDS = ("noise", "steps", "sine", "ramp", "alternating")


def random_commands(rng: np.random.Generator, kind: str, count: int) -> tuple[float, ...]:
    """Return commands of one of the kinds above, or "huge" ones."""
    k, size = np.arange(count), 10.0 ** rng.uniform(-1.5, 1.0)
    values = {
        "noise": size * rng.normal(size=count),
        "steps": size * rng.normal(size=count)[k // 12],
        "sine": size * np.sin(k * 10.0 ** rng.uniform(-2.0, 0.5)),
        "ramp": size * (k * rng.uniform(-1.0, 1.0) + rng.normal()),
        "alternating": size * (-1.0) ** k,
        "huge": np.where(rng.random(count) < 0.3, rng.choice([-1e300, 1e300], count), size),
    }
    return tuple(values[kind].tolist())


def random_following(
    rng: np.random.Generator, order: int, kind: str = "noise", *, moving: bool = False
) -> Following:
    """Return a follower that starts within its bounds; `moving` commands have velocities."""
    problem = random_transfer(rng, order)
    low, high = problem.bounds[0]
    count = 48
    speeds = rng.uniform(0.9 * low, 0.9 * high, count) * (rng.random(count) < 0.6)
    return Following(
        problem.start,
        problem.bounds,
        float(10.0 ** rng.uniform(-2.0, 0.5)),
        random_commands(rng, kind, count),
        tuple(speeds[np.arange(count) // 6].tolist()) if moving else None,
    )
