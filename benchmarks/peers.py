"""Packages that plan rest-to-rest moves, jounce among them, each in its own best way.

Imported by against_peers.py, nothing to run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from math import inf
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from jounce.shaping import Limits, min_time_move

Plan = Callable[[float, list[float]], "Move"]  # of a distance and bounds on derivatives 1…n


@dataclass(frozen=True)
class Move:
    """A planned move, and how the package samples it: position first, by derivative or by time.

    What `sample` gives is timed; `states` makes arrays of it that can be compared.
    """

    duration: float
    sample: Callable[[np.ndarray], Any]
    by_time: bool = False

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the derivatives delivered, (k + 1, N)."""
        found = np.asarray(self.sample(times), dtype=float)
        if self.by_time:
            found = found.reshape(len(times), -1).T
        return found.reshape(-1, len(times))


@dataclass(frozen=True)
class Planner:
    """A way to plan moves of some orders."""

    package: str
    way: str
    orders: tuple[int, ...]
    prepare: Callable[[int], Plan]
    """Given the order, returns the plan; what one would do once per process is done here."""

    @property
    def name(self) -> str:
        """Package, version if it is installed, way."""
        try:
            package = f"{self.package} {version(self.package)}"
        except PackageNotFoundError:
            package = self.package
        return f"{package}, {self.way}" if self.way else package


def jounce_with(method: Any) -> Callable[[int], Plan]:
    """Plan in one call, sample every derivative at all times in another."""

    def plan(distance: float, bounds: list[float]) -> Move:
        move = min_time_move(distance, Limits.from_bounds(bounds), method=method)
        return Move(move.duration, move.evaluate)

    return lambda _: plan


def ruckig(_: int) -> Plan:
    """Make objects once, jerk infinite for order 2; at_time takes one time, hands out no jerk."""
    import ruckig

    problem, planner = ruckig.InputParameter(1), ruckig.Ruckig(1)

    def plan(distance: float, bounds: list[float]) -> Move:
        problem.target_position = [distance]
        problem.max_velocity, problem.max_acceleration = bounds[:1], bounds[1:2]
        problem.max_jerk = bounds[2:] or [inf]
        trajectory = ruckig.Trajectory(1)
        result = planner.calculate(problem, trajectory)
        if result not in (ruckig.Result.Working, ruckig.Result.Finished):
            raise ValueError(result)
        at_time = trajectory.at_time
        return Move(trajectory.duration, lambda ts: [at_time(t) for t in ts.tolist()], by_time=True)

    return plan


def justblend(order: int) -> Plan:
    """Make the generator once; samples() takes an array and hands out no jerk."""
    import justblend

    kinds = {2: justblend.TrapezoidalTrajectoryGenerator, 3: justblend.SCurveTrajectoryGenerator}
    generator = kinds[order](1)

    def sampled(trajectory: justblend.Trajectory, times: np.ndarray) -> tuple[np.ndarray, ...]:
        samples = trajectory.samples(times)
        return samples.q, samples.qd, samples.qdd

    def plan(distance: float, bounds: list[float]) -> Move:
        generator.set_limits(justblend.Limits(*np.array(bounds)[:, None]))
        trajectory = generator.generate(np.array([[0.0], [distance]]))
        return Move(trajectory.duration(), lambda times: sampled(trajectory, times))

    return plan


def interpolatepy_profile(order: int) -> Plan:
    """Use the compiled backend; order 2 is a function of one time, order 3 takes an array."""
    import interpolatepy as ip

    def trapezoidal(distance: float, bounds: list[float]) -> Move:
        given = ip.TrapezoidalTrajectoryParams(q0=0.0, q1=distance, vmax=bounds[0], amax=bounds[1])
        at_time, duration = ip.TrapezoidalTrajectory.generate_trajectory(given)
        return Move(duration, lambda ts: [at_time(t) for t in ts.tolist()], by_time=True)

    def double_s(distance: float, bounds: list[float]) -> Move:
        state = ip.StateParams(q_0=0.0, q_1=distance, v_0=0.0, v_1=0.0)
        motion = ip.DoubleSTrajectory(state, ip.TrajectoryBounds(*bounds))
        return Move(motion.get_duration(), motion.evaluate_full)

    return trapezoidal if order == 2 else double_s


def interpolatepy_polynomial(order: int) -> Plan:
    """Give degree 2n − 1 the duration it needs: the shortest that keeps the bounds, from here."""
    import interpolatepy as ip

    kind = ip.PolynomialTrajectory
    make = {2: kind.order_3_trajectory, 3: kind.order_5_trajectory, 4: kind.order_7_trajectory}
    peaks = polynomial_peaks(order)

    def plan(distance: float, bounds: list[float]) -> Move:
        powers = enumerate(zip(peaks, bounds, strict=True), start=1)
        duration = max((peak * distance / bound) ** (1.0 / k) for k, (peak, bound) in powers)
        ends = ip.BoundaryCondition(0.0, 0.0), ip.BoundaryCondition(distance, 0.0)
        at_time = make[order](*ends, ip.TimeInterval(0.0, duration))
        return Move(duration, lambda ts: [at_time(t) for t in ts.tolist()], by_time=True)

    return plan


def polynomial_peaks(order: int) -> list[float]:
    """Return the peaks of derivatives 1…n of the polynomial 0 → 1 in unit time."""
    position = (Polynomial([0.0, 1.0, -1.0]) ** (order - 1)).integ()
    position /= position(1.0)
    turns = [position.deriv(k + 1).roots().real.clip(0.0, 1.0) for k in range(1, order + 1)]
    return [
        float(np.abs(position.deriv(k)(np.append(at, [0.0, 1.0]))).max())
        for k, at in enumerate(turns, start=1)
    ]


def two_point_interpolation(order: int) -> Plan:
    """Make an object per move; one time per call. Its readme calls the jerk version unfinished."""
    import two_point_interpolation as tp

    def plan(distance: float, bounds: list[float]) -> Move:
        if order == 2:
            motion = tp.TwoPointInterpolationAcc()
            motion.init(p0=0.0, pe=distance, vmax=bounds[0], acc_max=bounds[1])
        else:
            motion = tp.TwoPointInterpolationJerk()
            motion.init(p0=0.0, pe=distance, vmax=bounds[0], amax=bounds[1], jmax=bounds[2])
        at_time, duration = motion.get_point, motion.calc_trajectory()
        return Move(float(duration), lambda ts: [at_time(t) for t in ts.tolist()], by_time=True)

    return plan


PLANNERS = (
    Planner("jounce", "", (2, 3), jounce_with("optimal")),
    Planner("jounce", "closed form", (4, 5, 6), jounce_with("closed-form")),
    Planner("jounce", "optimal", (4, 5, 6), jounce_with("optimal")),
    Planner("ruckig", "", (2, 3), ruckig),
    Planner("justblend", "", (2, 3), justblend),
    Planner("interpolatepy", "profile", (2, 3), interpolatepy_profile),
    Planner("interpolatepy", "polynomial of given duration", (2, 3, 4), interpolatepy_polynomial),
    Planner("two-point-interpolation", "", (2, 3), two_point_interpolation),
)
