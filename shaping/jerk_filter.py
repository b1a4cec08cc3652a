"""The linear jerk filter: equal lags in series behind a shaper."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, log, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import of_kind, positive, whole
from .derivatives import derivative_number
from .frozen import Frozen
from .pieces import FloatArray
from .propagate import grid, inputs_on_grid, propagate
from .real_numbers import real_array, real_number
from .roots import root_between
from .told import Told
from .trajectory import Motion, Trajectory, as_trajectory

MAX_FILTER_ORDER = 50
"""Highest filter order accepted."""


@dataclass(frozen=True, eq=False, repr=False)
class FilterResponse(Told, Frozen):
    """Exact response of a filter on a uniform time grid.

    Attributes
    ----------
    time : (N,) array
    states : (order + 1, N) array
        Output position and its derivatives 1 … order of the filter, time last.
    """

    time: FloatArray
    states: FloatArray


@dataclass(frozen=True)
class JerkFilter:
    """Equal first-order lags in series, to be put behind any shaper.

        f(s) = (ω / (s + ω))^m,   ω = 2π·corner_hz

    The output is m − 1 times continuously differentiable whatever command comes in, and never
    overshoots a command that does not.

    Parameters
    ----------
    corner_hz : float
        Corner frequency of each lag, in cycles per time unit; positive.
    order : int
        Number of lags m, 1 to 50.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section V.

    Examples
    --------
    >>> round(JerkFilter(2.0, 6).settling_time(0.01), 4)
    1.0431
    """

    corner_hz: float
    order: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "corner_hz", positive("corner_hz", self.corner_hz))
        object.__setattr__(self, "order", whole("order", self.order, 1, MAX_FILTER_ORDER))

    @property
    def omega(self) -> float:
        """Corner frequency in radians per time unit."""
        return 2.0 * pi * self.corner_hz

    def settling_time(self, tolerance: float) -> float:
        """Return the time after a step from which the output stays within `tolerance` of it.

        The step response is the gamma distribution of shape m: Q(m, ωt) = tolerance.

        Parameters
        ----------
        tolerance : float
            Fraction of the step, between 0 and 1.
        """
        share = real_number("tolerance", tolerance)
        if not 0.0 < share < 1.0:
            raise ValueError(f"tolerance = {tolerance!r}: expected a fraction between 0 and 1")
        most = 1.0
        while _log_rest(self.order, most) > log(share):
            most *= 2.0
        left = root_between(lambda x: _log_rest(self.order, x) - log(share), 0.0, most)
        return left / self.omega

    def step_response(self, t: ArrayLike) -> FloatArray:
        """Return the response to a unit step at time 0: P(m, ωt), and 0 before."""
        from scipy.special import gammainc

        return np.asarray(gammainc(self.order, self.omega * np.maximum(real_array("t", t), 0.0)))

    def state_space(self) -> tuple[FloatArray, FloatArray]:
        """Return (A, b) of z' = A·z + b·r; z_j is the output of lag j, the last one f's."""
        a = self.omega * (np.eye(self.order, k=-1) - np.eye(self.order))
        b = np.zeros((self.order, 1))
        b[0, 0] = self.omega
        return a, b

    def steady_state(self, trajectory: Motion, derivative: int | str = 0) -> FloatArray:
        """Return z, shape (m,), after derivative k of a trajectory has coasted in for ever."""
        k = derivative_number(derivative)
        coasting = (*as_trajectory(trajectory).coasting_in(), 0.0)
        level, slope = coasting[k : k + 2] if k < 2 else (0.0, 0.0)
        return np.asarray(level - slope * np.arange(1, self.order + 1) / self.omega)

    def respond(
        self, trajectory: Motion, dt: float, *, duration: float | None = None
    ) -> FilterResponse:
        """Return the exact response to a trajectory that coasted for ever before its start.

        Parameters
        ----------
        trajectory : Trajectory
            Of any order; after its end it coasts.
        dt : float
            Spacing of the time grid; its choice does not change the values.
        duration : float, optional
            Length of the grid. Default: the trajectory's duration plus the filter's settling
            time to 1e-6 of a step.

        Returns
        -------
        FilterResponse
            `time` (N,), `states` (order + 1, N): position and derivatives up to the filter's
            order.

        Notes
        -----
        Derivative k of the output is the filter's response to derivative k of the trajectory,
        or follows from its response to a lower one by the lags, z_j' = ω·(z_{j−1} − z_j),
        whichever rounds less.

        Each row is within 1e-10 of its peak, but for up to 2e-9 in the highest rows of filters
        with ωT of 1e4 behind moves that start 100 T late, where the rounding of the break times
        shows.
        """
        dt, trajectory = positive("dt", dt), as_trajectory(trajectory)
        if duration is None:
            duration = trajectory.duration + self.settling_time(1e-6)
        time = grid(trajectory.start_time, positive("duration", duration), dt)
        start, drift = trajectory.coasting_in()
        trajectory = trajectory.relative_to_coasting()
        a, b = self.state_space()
        highest = min(self.order, trajectory.lowest_jump())
        inputs = inputs_on_grid(trajectory, time, dt, np.empty((highest + 1, time.size)))
        sources = self._sources(trajectory, highest)
        states = np.empty((self.order + 1, time.size))
        with np.errstate(over="ignore", invalid="ignore"):
            for d in sorted(set(sources)):
                lags = propagate(a, b, [d], trajectory, dt, time.size, np.zeros(self.order))
                chain = np.vstack([inputs[d], lags])
                for k in (k for k, source in enumerate(sources) if source == d):
                    states[k] = self.derivative_weights(k - d) @ chain
        # the steady response to the motion that coasted in
        states[0] += start + drift * (time - time[0] - self.order / self.omega)
        states[1] += drift
        if not np.isfinite(states).all():
            raise ValueError(
                "a derivative of the response leaves the range of a double: choose units nearer to "
                "the problem's own, or a filter of lower order"
            )
        return FilterResponse(time, states)

    def _sources(self, trajectory: Trajectory, highest: int) -> list[int]:
        """Return of which derivative of the trajectory each row is taken, to round least.

        From derivative d of the trajectory row k = d + q follows as q differences of its lags,
        which are of the size of its peak and cancel to (2ω)^q of their rounding.
        """
        peaks = [max(trajectory.peak(d), 1e-300) for d in range(highest + 1)]
        costs = [
            [log(peak) + (k - d) * log(2.0 * self.omega) for d, peak in enumerate(peaks[: k + 1])]
            for k in range(self.order + 1)
        ]
        return [cost.index(min(cost)) for cost in costs]

    def derivative_weights(self, k: int) -> FloatArray:
        """Return w (m + 1,): derivative k ≤ m of the output is w·[command, lag 1, …, lag m]."""
        k, weights = whole("k", k, 0, self.order), np.zeros(self.order + 1)
        weights[self.order - k :] = [(-1.0) ** i * comb(k, i) for i in range(k + 1)]
        return weights * np.float64(self.omega) ** k


def checked_filter(jerk_filter: Any) -> JerkFilter:
    """Return a jerk filter; TypeError for anything else."""
    return of_kind("jerk_filter", jerk_filter, JerkFilter, "a JerkFilter")


def _log_rest(order: int, x: float) -> float:
    """Return ln Q(m, x), Q = e^(−x)·Σ_{k<m} x^k/k!: what a step leaves after ωt = x."""
    term, total = 1.0, 1.0
    for k in range(1, order):
        term *= x / k
        total += term
    return log(total) - x
