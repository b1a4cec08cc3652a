"""S-curve moves as plain numbers that can be pasted and re-run, and what has to hold of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import copysign, inf, sqrt

import numpy as np
import pytest
from references import replay

from jounce.shaping import SCurveMove, Trajectory, s_curve_move
from jounce.shaping.transfers.s_curve_plan import plan_move
from jounce.shaping.transfers.s_curve_rates import Pieces, Rates


@dataclass(frozen=True, repr=False)
class SCurve:
    """A target, rates for speeding up and for slowing down, and both ends."""

    target: float
    velocity: float
    acceleration: float
    deceleration: float
    jerks: tuple[float, float] = (inf, inf)
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    final_velocity: float = 0.0
    percent: float | None = None

    def __repr__(self) -> str:
        told = ", ".join(f"{name}={value!r}" for name, value in self.settings().items())
        return f"s_curve_move({self.target!r}, {told})"

    def settings(self) -> dict:
        """Return the arguments besides the target."""
        names = ("velocity", "acceleration", "deceleration", "start", "final_velocity")
        given = {name: getattr(self, name) for name in names}
        if self.percent is not None:
            return {**given, "jerk_percent": self.percent}
        jerks = dict(zip(("acceleration_jerk", "deceleration_jerk"), self.jerks, strict=True))
        return {**given, **jerks}

    def solve(self, **more) -> SCurveMove:
        """Return the move."""
        return s_curve_move(self.target, **{**self.settings(), **more})

    def planned(self) -> Pieces:
        """Return the pieces of the plan, also where a transfer would do."""
        rates = (self.velocity, self.acceleration, self.deceleration, *self.jerks, self.percent)
        return plan_move(self.start, self.target, self.final_velocity, Rates(*rates))

    def trajectory(self) -> Trajectory:
        """Return the plan as a trajectory."""
        durations, states = zip(*[p for p in self.planned() if p[0] > 0.0], strict=True)
        end = (self.target, self.final_velocity, 0.0, 0.0)
        return Trajectory(np.cumsum([0.0, *durations]), states, durations, end)

    def mirrored(self) -> SCurve:
        """Return the problem in the opposite direction."""
        start = tuple(-x for x in self.start)
        final = -self.final_velocity
        return replace(self, target=-self.target, start=start, final_velocity=final)

    def in_units(self, distance: float, time: float) -> SCurve:
        """Return the problem with numbers in other units: one of each is `distance`, `time`."""
        factors = [distance / time**k for k in range(4)]
        return SCurve(
            self.target * distance,
            self.velocity * factors[1],
            *(rate * factors[2] for rate in (self.acceleration, self.deceleration)),
            tuple(jerk * factors[3] for jerk in self.jerks),
            tuple(x * factor for x, factor in zip(self.start, factors, strict=False)),
            self.final_velocity * factors[1],
            self.percent,
        )

    @property
    def settling(self) -> float:
        """Velocity at which the acceleration of the start has gone to zero as fast as it may."""
        _, v, a = self.start
        jerk = self.jerks[0] if a * v > 0.0 or v == 0.0 else self.jerks[1]
        return v + copysign(0.5 * a * a / jerk, a) if a else v


def random_s_curve(rng: np.random.Generator, *, round_numbers: bool = False) -> SCurve:
    """Return a problem of generic numbers, or of such as fall on borders between cases.

    It starts where it can keep its rates, at rest or moving, and ends at rest or moving.
    """
    if round_numbers:
        rates = rng.choice([0.25, 0.5, 1.0, 2.0, 4.0], 5)
        parts = rng.choice([0.0, 0.0, 1.0, -1.0, 0.5, -0.5], 3)
        x, target = 0.0, rng.choice([0.25, 0.5, 1.0, 2.0, 5.0]) * rng.choice([-1.0, 1.0])
    else:
        rates = 10.0 ** rng.uniform(-1.0, 1.0, 5)
        parts = rng.uniform(-1.0, 1.0, 3) * rng.choice([0.0, 1.0, 1.0], 3)
        x, target = rng.normal(), rng.normal() * 10.0 ** rng.uniform(-2.0, 1.0)
    velocity, acceleration, deceleration, *jerks = map(float, rates)
    v, a = velocity * parts[0], min(acceleration, deceleration) * parts[1]
    if a * v >= 0.0:
        most = sqrt(2.0 * jerks[0] * (velocity - abs(v)))
    else:  # so that it stops, or does not pass its velocity in the other direction
        most = sqrt(2.0 * (jerks[1] * abs(v) + jerks[0] * velocity))
    start = float(x), float(v), float(copysign(min(abs(a), most), a))
    final = float(velocity * parts[2])
    return SCurve(float(target), velocity, acceleration, deceleration, tuple(jerks), start, final)


def by_percent(problem: SCurve, percent: float) -> SCurve:
    """Return the problem with a jerk percent, starting without acceleration."""
    return replace(problem, percent=percent, jerks=(inf, inf), start=(*problem.start[:2], 0.0))


def assert_continuous(text: object, motion: Trajectory, *, derivatives: int = 3) -> None:
    """Assert that position and the first derivatives have no step, the end included."""
    again = replay(motion)
    for k in range(derivatives):
        low, high = again.extremes[k]
        scale = high - low if k == 0 else max(high, -low)
        slack = 1e-9 * scale + (1e-15 * abs(motion.states[:, 0]).max() if k == 0 else 0.0)
        assert again.gaps[k] <= slack, f"{text}: derivative {k} jumps by {again.gaps[k]!r}"


def assert_within_rates(problem: SCurve, motion: Trajectory, slack: float = 1e-9) -> None:
    """Assert the bounds for speeding up, for slowing down, and for the velocity.

    Speeding up is acceleration along the velocity; at a border between the two nothing is said.
    """
    rise = 1.0 - 0.5 * (problem.percent or 0.0)
    rates = {True: problem.acceleration / rise, False: problem.deceleration / rise}
    jerks = dict(zip((True, False), problem.jerks, strict=True))
    fastest = max(problem.velocity, abs(problem.start[1]))
    for speeds_up, velocity, acceleration, jerk in _runs(motion):
        text = f"{problem!r}: {'speeding up' if speeds_up else 'slowing down'}"
        assert velocity <= fastest * (1.0 + slack), f"{text} to {velocity!r}"
        assert acceleration <= rates[speeds_up] * (1.0 + slack), f"{text} at {acceleration!r}"
        if problem.percent is None:
            assert jerk <= jerks[speeds_up] * (1.0 + slack), f"{text} with jerk {jerk!r}"


def _runs(motion: Trajectory) -> Iterator[tuple[bool, float, float, float]]:
    """Yield whether it speeds up, and largest magnitudes, between zeros of its derivatives."""
    least = [1e-12 * motion.peak(k) for k in range(3)]
    for duration, (_, v, a, j) in zip(
        motion.durations.tolist(), motion.states.tolist(), strict=True
    ):
        zeros = [t for t in _zeros(v, a, j) if 0.0 < t < duration]
        for begin, end in pairwise(sorted([0.0, *zeros, duration])):
            speeds, powers = zip(
                *(
                    (v + (a + 0.5 * j * t) * t, a + j * t)
                    for t in (begin, 0.5 * (begin + end), end)
                ),
                strict=True,
            )
            if abs(speeds[1]) > least[1] and abs(powers[1]) > least[2]:
                highest = (max(map(abs, values)) for values in (speeds, powers))
                yield speeds[1] * powers[1] > 0.0, *highest, abs(j)


def _zeros(v: float, a: float, j: float) -> list[float]:
    """Return the times at which velocity or acceleration vanishes."""
    if not j:
        return [-v / a] if a else []
    square = a * a - 2.0 * j * v
    if square <= 0.0:
        return [-a / j]
    far = -(a + copysign(sqrt(square), a))
    return [-a / j, far / j, 2.0 * v / far if far else 0.0]


def ramp_time(velocity: float, acceleration: float, jerk: float) -> float:
    """Return the time from rest to a velocity (Thompson, Section III)."""
    if velocity >= acceleration**2 / jerk:
        return velocity / acceleration + acceleration / jerk
    return 2.0 * sqrt(velocity / jerk)


def assert_ends(problem: SCurve, motion: Trajectory) -> None:
    """Assert the states at both ends."""
    start = motion.start_state[:3].tolist()
    if problem.percent is None:
        assert start == pytest.approx(problem.start, rel=1e-14), problem
    else:
        assert start[:2] == pytest.approx(problem.start[:2], rel=1e-14), problem
    assert motion.end_state.tolist() == [problem.target, problem.final_velocity, 0.0, 0.0], problem
