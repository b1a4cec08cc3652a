"""Piecewise polynomials in Taylor form: what a trajectory is made of, and what it tells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from .. import core
from .checks import positive, whole
from .derivatives import derivative_name, derivative_number
from .frozen import Frozen
from .limits import Limits, of_one
from .pieces import MAX_SAMPLES, FloatArray, advance, evaluate, extremes
from .real_numbers import real_array
from .told import Rows, Told, curve
from .trajectory_checks import check_shapes, check_times, finite_array

_ARRAYS = ("breaks", "states", "durations", "end_state")


_SHOWN = 120  # points of a small picture


@dataclass(frozen=True, init=False, eq=False, repr=False)
class PiecewisePolynomial(Told, Frozen):
    """The arrays of a trajectory and what is read from them; `Trajectory` says what they mean."""

    breaks: FloatArray
    states: FloatArray
    durations: FloatArray
    end_state: FloatArray
    coasting: int

    def __init__(
        self,
        breaks: ArrayLike,
        states: ArrayLike,
        durations: ArrayLike | None = None,
        end_state: ArrayLike | None = None,
        coasting: int | None = None,
    ) -> None:
        times, rows = finite_array("breaks", breaks), finite_array("states", states)
        check_shapes(times, rows)
        given = durations is not None
        lengths = finite_array("durations", durations) if given else times[1:] - times[:-1]
        check_times(times, lengths, exact=not given)
        end = _run_out(rows, lengths) if end_state is None else finite_array("end_state", end_state)
        if end.shape != rows.shape[1:]:
            raise ValueError(
                f"end_state has shape {end.shape}: expected {rows.shape[1:]}, "
                "position and one value per derivative"
            )
        if coasting is not None:
            coasting = whole("coasting", coasting, -1, rows.shape[1] - 2)
        self._fill(times, rows, lengths, end, coasting)

    @classmethod
    def from_arrays(
        cls,
        breaks: FloatArray,
        states: FloatArray,
        durations: FloatArray,
        end_state: FloatArray,
        coasting: int | None = None,
    ) -> Self:
        """Take over arrays known to be valid, without copy or check."""
        trajectory = object.__new__(cls)
        trajectory._fill(breaks, states, durations, end_state, coasting)
        return trajectory

    @classmethod
    def of_motion(cls, motion: core.Motion) -> Self:
        """Return a motion of the core; its arrays are made when they are asked for."""
        trajectory = object.__new__(cls)
        fields = trajectory.__dict__  # the way around `frozen`
        fields["_motion"], fields["coasting"] = motion, 1 if motion.order > 1 else 0
        return trajectory

    def __getattr__(self, name: str) -> Any:
        motion = self.__dict__.get("_motion")
        if motion is None or name not in _ARRAYS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        self.__dict__.update(zip(_ARRAYS, motion.arrays(), strict=True))
        return self.__dict__[name]

    def _fill(
        self,
        breaks: FloatArray,
        states: FloatArray,
        durations: FloatArray,
        end_state: FloatArray,
        coasting: int | None,
    ) -> None:
        fields = self.__dict__  # the way around `frozen`
        fields["breaks"], fields["states"] = breaks, states
        fields["durations"], fields["end_state"] = durations, end_state
        fields["coasting"] = min(1, states.shape[1] - 2) if coasting is None else coasting
        for array in (breaks, states, durations, end_state):
            array.flags.writeable = False

    @property
    def order(self) -> int:
        """Highest derivative n, constant on each piece."""
        return int(self.states.shape[1]) - 1

    @property
    def start_time(self) -> float:
        """Time of the first break."""
        return float(self.breaks[0])

    @property
    def end_time(self) -> float:
        """Time of the last break."""
        return float(self.breaks[-1])

    @property
    def duration(self) -> float:
        """Time from the first break to the last."""
        motion: core.Motion | None = self.__dict__.get("_motion")
        if motion is not None:
            return motion.duration
        return float(self.breaks[-1] - self.breaks[0])

    @property
    def start_state(self) -> FloatArray:
        """Position and derivatives 1…n at the start, shape (n + 1,)."""
        return np.asarray(self.states[0] if len(self.states) else self.end_state)

    @property
    def switch_times(self) -> FloatArray:
        """Times at which derivative n changes, start and end of the motion included."""
        highest = np.concatenate([[0.0], self.states[:, -1], [0.0]])
        return np.asarray(self.breaks[highest[1:] != highest[:-1]])

    def __call__(self, t: ArrayLike, derivative: int | str = 0) -> FloatArray:
        """Evaluate one derivative at times t.

        Parameters
        ----------
        t : float or array of any shape
            Times, finite; in increasing order is fastest.
        derivative : int or str, optional
            0 position (default), 1 velocity, … or a name such as "jerk". Beyond n it is zero.

        Returns
        -------
        float or array of the shape of t
            At a break the value just after it.
        """
        if type(t) is not float:
            t = real_array("t", t)
        return self._pieces.at(t, derivative_number(derivative))

    def evaluate(
        self, t: ArrayLike, highest: int | str | None = None, out: FloatArray | None = None
    ) -> FloatArray:
        """Evaluate position and its derivatives 1…highest at times t.

        Parameters
        ----------
        t : float or array of any shape
            As in calling the trajectory.
        highest : int or str, optional
            At most n. Default: n.
        out : (highest + 1, *t.shape) array, optional
            Where to put the result; contiguous along time.

        Returns
        -------
        (highest + 1, *t.shape) array
        """
        k = self.order if highest is None else derivative_number(highest)
        if k > self.order:
            raise ValueError(f"highest = {highest!r}: expected at most {self.order}")
        return self._pieces.up_to(real_array("t", t), k, out)

    def sample(self, dt: float) -> tuple[FloatArray, FloatArray]:
        """Sample position and all derivatives at a fixed interval, both ends included.

        Parameters
        ----------
        dt : float
            Sampling interval, positive.

        Returns
        -------
        times : (N,) array
            start, start + dt, …, and the end point as the last sample (the last interval is
            shorter where the duration is no multiple of dt).
        states : (n + 1, N) array
            Time last, as in python-control.
        """
        dt = positive("dt", dt)
        if self.duration > MAX_SAMPLES * dt:
            raise ValueError(
                f"dt = {dt!r} makes {self.duration / dt:.3g} samples: expected at most "
                f"{MAX_SAMPLES:.0e}; use a larger dt"
            )
        whole = int(np.ceil(self.duration / dt * (1.0 - 1e-12)))
        times = np.append(self.start_time + dt * np.arange(whole), self.end_time)
        states = self.evaluate(times)
        states[:, -1] = self.end_state
        return times, states

    def extremes(self, derivative: int | str) -> tuple[float, float]:
        """Return the exact (minimum, maximum) of a derivative from start to end."""
        k = derivative_number(derivative)
        if k > self.order:
            return 0.0, 0.0
        if not len(self.states):
            return float(self.end_state[k]), float(self.end_state[k])
        return extremes(self.durations, self.states[:, k:].T)

    def peak(self, derivative: int | str) -> float:
        """Return the exact largest magnitude of a derivative, from the polynomials' extremes."""
        low, high = self.extremes(derivative)
        return max(0.0, high, -low)

    def violation(self, limits: Limits) -> float:
        """Return the largest relative excess over the limits, 0.0 where all are kept.

        Excess of derivative k is max|x^(k)| / bound − 1, the bound on the side in question; of
        one that is zero it is in units of the other side, or of the peak where that is infinite,
        and of position in units of its range, or of that of the motion. A derivative that jumps
        (beyond n, or where a lower one is discontinuous) is not seen.
        """
        excess = 0.0
        for k in range(0 if of_one(limits).bounds_position else 1, limits.order + 1):
            low, high = self.extremes(k)
            lower, upper = limits.bounds(k)
            if lower < 0.0 < upper and k:
                excess = max(excess, high / upper - 1.0, low / lower - 1.0)
            elif low < lower or high > upper:
                excess = max(excess, _beyond(low, high, lower, upper))
        return excess

    def coasting_in(self) -> tuple[float, float]:
        """Return position and velocity of the motion that coasts in, at the start."""
        position = float(self.start_state[0]) if self.coasting >= 0 else 0.0
        return position, float(self.start_state[1]) if self.coasting >= 1 else 0.0

    def lowest_jump(self) -> int:
        """Return the lowest derivative that jumps, at a break, the start or the end.

        Coasting before and after counts; a jump is more than 1e-9 of the derivative's peak.
        """
        outside = np.vstack([self.start_state, self.end_state])
        outside[:, self.coasting + 1 :] = 0.0
        ends = evaluate(self.states.T, self.durations, range(self.order + 1)).T
        jumps = np.abs(np.vstack([outside[:1], ends]) - np.vstack([self.states, outside[1:]]))
        # The peak is no less than the value at any break, which mostly tells without it.
        seen = np.abs(np.vstack([self.states, ends])).max(axis=0, initial=0.0)
        for k in np.flatnonzero((jumps.max(axis=0) > 1e-9 * seen)[:-1]).tolist():
            if jumps[:, k].max() > 1e-9 * self.peak(k):
                return int(k)
        return self.order

    def table_rows(self) -> Rows:
        """Return order, pieces, duration, ends, and the peak of every derivative."""
        yield from (("order", self.order), ("pieces", len(self.states)))
        yield "duration", self.duration
        yield "from … to", f"{self.start_state[0]:.7g} … {self.end_state[0]:.7g}"
        for k in range(1, self.order + 1):
            yield f"peak {derivative_name(k)}", self.peak(k)

    def picture(self) -> str:
        """Return the position over time."""
        times = np.linspace(self.start_time, self.end_time, _SHOWN)
        return curve(self.evaluate(times, 0)[0].tolist(), "position over time")

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}(order={self.order}, pieces={len(self.states)}, "
            f"start={self.start_state[0]:.10g}, end={self.end_state[0]:.10g}, "
            f"duration={self.duration:.10g})"
        )

    @cached_property
    def _pieces(self) -> core.Pieces:
        motion = self.__dict__.get("_motion")
        if motion is not None:
            return motion.pieces()  # type: ignore[no-any-return]
        breaks, states, durations, end = map(
            np.ascontiguousarray, (self.breaks, self.states, self.durations, self.end_state)
        )
        return core.Pieces(breaks, states, durations, end, self.coasting)


def _beyond(low: float, high: float, lower: float, upper: float) -> float:
    """Return the excess over bounds in units of their range, or where it is none of the values'."""
    units = upper - lower if np.isfinite(upper - lower) else max(high - low, abs(low), abs(high))
    return max(high - upper, lower - low) / units


def _run_out(states: FloatArray, durations: FloatArray) -> FloatArray:
    """Return the state at the end of the last piece, highest derivative off."""
    if not len(states):
        raise ValueError("a trajectory without pieces needs its end_state")
    end = advance(states[-1], float(durations[-1]))
    end[-1] = 0.0
    return end
