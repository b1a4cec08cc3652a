"""Trajectory: an exact piecewise polynomial function of time, closed under differentiation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import core
from .checks import finite, in_range, of_kind, positive, whole
from .derivatives import derivative_name, derivative_number
from .drawing import draw
from .frozen import Frozen
from .limits import Limits, of_one
from .pieces import MAX_SAMPLES, FloatArray, advance, evaluate, extrema
from .real_numbers import real_array, real_number
from .trajectory_checks import check_shapes, check_times, finite_array

_ARRAYS = ("breaks", "states", "durations", "end_state")


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Trajectory(Frozen):
    """Position as a piecewise polynomial in Taylor form.

    On piece i, with τ = t − breaks[i],

        x^(k)(t) = Σ_{j ≥ k} states[i, j] · τ^(j−k) / (j−k)!,   k = 0 … n.

    Before the start and after the end it coasts: position and velocity continue, higher
    derivatives are zero (for n = 1 velocity is the piecewise-constant input and stops too).

    Parameters
    ----------
    breaks : (m + 1,) array
        Increasing times, in the caller's time unit. m = 0 is a point at rest.
    states : (m, n + 1) array
        Row i holds position and derivatives 1…n at the start of piece i; n ≤ 40.
    durations : (m,) array, optional
        Lengths of the pieces, where they are known better than differences of `breaks` give
        them: a ramp of 1e-9 of the whole move keeps its bounds to rounding only so.
        Evaluation never runs a piece past its duration.
    end_state : (n + 1,) array, optional
        Position and derivatives at the end. Default: the last piece run to its end, with the
        highest derivative set to zero. Required when m = 0.
    coasting : int, optional
        Highest derivative that continues outside [start, end]; −1 means that the value itself
        is zero there. Default: 1, or 0 when n = 1.

    Raises
    ------
    ValueError
        For shapes that do not fit, times that do not increase, or values that are not finite.

    Notes
    -----
    The arrays are copied and read-only. Continuity between pieces is the caller's business
    (derivative n jumps by design; lower ones may, too).
    """

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
        """Take over arrays known to be valid, without copy or check; for the shapers' use."""
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

    def __getstate__(self) -> dict[str, Any]:
        for name in _ARRAYS:
            getattr(self, name)
        return super().__getstate__()

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
        motion = self.__dict__.get("_motion")
        if motion is not None:
            return float(motion.duration)
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
        low, high = extrema(self.durations, self.states[:, k:].T)
        return float(low.min()), float(high.max())

    def peak(self, derivative: int | str) -> float:
        """Return the exact largest magnitude of a derivative, from the polynomials' extrema."""
        low, high = self.extremes(derivative)
        return max(0.0, high, -low)

    def violation(self, limits: Limits) -> float:
        """Return the largest relative excess over the limits, 0.0 where all are kept.

        Excess of derivative k is max|x^(k)| / bound − 1, the bound on the side in question; a
        derivative that jumps (beyond n, or where a lower one is discontinuous) is not seen.
        """
        excess = 0.0
        for k in range(1, of_one(limits).order + 1):
            low, high = self.extremes(k)
            lower, upper = limits.bounds(k)
            excess = max(excess, high / upper - 1.0, low / lower - 1.0)
        return excess

    def coasting_in(self) -> tuple[float, float]:
        """Return position and velocity of the motion that coasts in, at the start."""
        position = float(self.start_state[0]) if self.coasting >= 0 else 0.0
        return position, float(self.start_state[1]) if self.coasting >= 1 else 0.0

    def relative_to_coasting(self) -> Trajectory:
        """Return the same motion as seen from one that goes on as it coasted in."""
        position, velocity = self.coasting_in()
        states, end = self.states.copy(), self.end_state.copy()
        states[:, 0] -= position + velocity * (self.breaks[:-1] - self.start_time)
        end[0] -= position + velocity * self.duration
        states[:, 1] -= velocity
        end[1] -= velocity
        return Trajectory.from_arrays(self.breaks, states, self.durations, end, self.coasting)

    def lowest_jump(self) -> int:
        """Return the lowest derivative that jumps, at a break, the start or the end.

        Coasting before and after counts; a jump is more than 1e-9 of the derivative's peak.
        """
        outside = np.vstack([self.start_state, self.end_state])
        outside[:, self.coasting + 1 :] = 0.0
        ends = evaluate(self.states.T, self.durations, range(self.order + 1)).T
        jumps = np.abs(np.vstack([outside[:1], ends]) - np.vstack([self.states, outside[1:]]))
        for k in range(self.order):
            if jumps[:, k].max() > 1e-9 * self.peak(k):
                return k
        return self.order

    def derivative(self, k: int | str = 1) -> Trajectory:
        """Return derivative k, by number or name, as a trajectory of its own, 1 ≤ k < n.

        Outside [start, end] it stays the derivative of the coasting motion.
        """
        k = k if type(k) is int else derivative_number(k)
        if not 1 <= k < self.order:
            raise ValueError(
                f"derivative {k} of a trajectory of order {self.order}: expected 1 to n − 1 (the "
                "highest is piecewise constant, not a trajectory)"
            )
        return Trajectory(
            self.breaks,
            self.states[:, k:],
            self.durations,
            self.end_state[k:],
            max(self.coasting - k, -1),
        )

    def shift(self, distance: float) -> Trajectory:
        """Return the same motion `distance` further along."""
        offset = np.zeros(self.order + 1)
        offset[0] = finite("distance", distance)
        return self._with(self.breaks, self.states + offset, self.end_state + offset)

    def delay(self, time: float) -> Trajectory:
        """Return the same motion, `time` later."""
        return self._with(self.breaks + finite("time", time), self.states, self.end_state)

    def scale(self, factor: float) -> Trajectory:
        """Return the motion with position and all derivatives multiplied by `factor`."""
        factor = finite("factor", factor)
        with np.errstate(over="ignore"):  # which is refused below
            states, end_state = self.states * factor, self.end_state * factor
        return self._with(self.breaks, states, end_state)

    def mirror(self) -> Trajectory:
        """Return the motion reflected in position, x → −x."""
        return self.scale(-1.0)

    def stretch(self, factor: float) -> Trajectory:
        """Return the motion slowed down `factor` times: x(t) → x(t / factor), start kept."""
        factor = positive("factor", factor)
        with np.errstate(over="ignore", invalid="ignore"):  # which is refused below
            slower = factor ** -np.arange(self.order + 1.0)
            breaks = self.start_time + factor * (self.breaks - self.start_time)
            states, end_state = self.states * slower, self.end_state * slower
            durations = self.durations * factor
        return Trajectory(breaks, states, durations, end_state, self.coasting)

    def reverse(self) -> Trajectory:
        """Return the motion run backwards over the same time interval."""
        signs = (-1.0) ** np.arange(self.order + 1)
        every = range(self.order + 1)
        ends = evaluate(self.states.T, self.durations, every).T
        end = self.start_state * signs
        end[-1] = 0.0
        return Trajectory.from_arrays(
            self.start_time + self.end_time - self.breaks[::-1],
            (ends * signs)[::-1],
            self.durations[::-1],
            end,
            self.coasting,
        )

    def until(self, time: float) -> Trajectory:
        """Return the motion from its start up to a time, coasting on after its end.

        `end_state` keeps the derivatives below n that the motion has at that time.

        Raises
        ------
        ValueError
            For a time before the start.
        """
        time = finite("time", time)
        if time < self.start_time:
            raise ValueError(
                f"time = {time!r} is before the start: expected at least {self.start_time!r}"
            )
        if time >= self.end_time:
            return self._coasting_until(time)
        last = self.evaluate(time)
        last[-1] = 0.0
        begun = self.breaks[:-1] < time
        durations = self.durations[begun].copy()
        breaks = np.append(self.breaks[:-1][begun], time)
        if len(durations):
            durations[-1] = min(durations[-1], time - breaks[-2])
        return Trajectory(breaks, self.states[begun], durations, last, self.coasting)

    def _coasting_until(self, time: float) -> Trajectory:
        if time == self.end_time:
            return Trajectory(
                self.breaks, self.states, self.durations, self.end_state, self.coasting
            )
        state = self.end_state.copy()
        state[self.coasting + 1 :] = 0.0
        span = time - self.end_time
        return Trajectory(
            np.append(self.breaks, time),
            np.vstack([self.states, state]),
            np.append(self.durations, span),
            advance(state, span),
            self.coasting,
        )

    def then(self, following: Trajectory, *, dwell: float = 0.0) -> Trajectory:
        """Append another motion, moved in time and position to begin where this one ends.

        Parameters
        ----------
        following : Trajectory
            It must start at the velocity (and acceleration, …) at which this one ends.
        dwell : float, optional
            Time spent coasting in between.

        Raises
        ------
        ValueError
            Where a derivative would jump that does not jump in either part.
        """
        dwell = real_number("dwell", dwell)
        if not 0.0 <= dwell < np.inf:
            raise ValueError(f"dwell = {dwell!r}: expected a finite time ≥ 0")
        n = max(self.order, checked_trajectory(following, "following").order)
        if dwell > 0.0:
            waiting = np.zeros((1, n + 1))
            waiting[0, : self.coasting + 1] = self.end_state[: self.coasting + 1]
            return self.then(Trajectory([0.0, dwell], waiting)).then(following)
        _check_joint(self, following)
        first, second = _padded(self, n), _padded(following, n)
        second = second.shift(first.end_state[0] - second.start_state[0])
        second = second.delay(first.end_time - second.start_time)
        return Trajectory.from_arrays(
            np.append(first.breaks, second.breaks[1:]),
            np.vstack([first.states, second.states]),
            np.append(first.durations, second.durations),
            second.end_state.copy(),
            min(first.coasting, second.coasting),
        )

    def __add__(self, other: Trajectory) -> Trajectory:
        """Return the sum of two motions, as functions of time; each coasts outside its own."""
        from .sums import weighted_sum

        if not isinstance(other, Trajectory):
            return NotImplemented
        return weighted_sum((self, other), (1.0, 1.0))

    def plot(
        self,
        limits: Limits | None = None,
        *,
        unit: str = "",
        time_unit: str = "s",
        scale: float = 1.0,
    ) -> Any:
        """Draw a picture: position and every derivative, coloured where its limit is active.

        Parameters
        ----------
        limits : Limits, optional
            Drawn as dashed lines. A derivative's curve is thick and orange where it is within 1e-3
            of its bound, and bands show the pieces all along which it is. Without limits the bands
            show where a derivative stays at its own peak.
        unit, time_unit : str, optional
            For the labels.
        scale : float, optional
            Trajectory units per `unit`, positive.

        Returns
        -------
        Figure
            As `jounce.plots.plot_trajectory` draws it: pyplot's current one if it is
            empty, else a new one of pyplot's. A notebook shows pyplot's figures by itself: end
            the last line of a cell with a semicolon, or it shows this one twice.

        Raises
        ------
        TypeError
            For limits of another kind.
        ValueError
            For a scale that is not positive.
        """
        return draw(self, limits=limits, unit=unit, time_unit=time_unit, scale=scale)

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}(order={self.order}, pieces={len(self.states)}, "
            f"start={self.start_state[0]:.10g}, end={self.end_state[0]:.10g}, "
            f"duration={self.duration:.10g})"
        )

    def _with(self, breaks: FloatArray, states: FloatArray, end_state: FloatArray) -> Trajectory:
        for values in (breaks, states, end_state):
            if not np.isfinite(values).all():
                raise ValueError("the result leaves the range of a double")
        return Trajectory.from_arrays(breaks, states, self.durations, end_state, self.coasting)

    @cached_property
    def _pieces(self) -> core.Pieces:
        motion = self.__dict__.get("_motion")
        if motion is not None:
            return motion.pieces()  # type: ignore[no-any-return]
        breaks, states, durations, end = map(
            np.ascontiguousarray, (self.breaks, self.states, self.durations, self.end_state)
        )
        return core.Pieces(breaks, states, durations, end, self.coasting)


def _run_out(states: FloatArray, durations: FloatArray) -> FloatArray:
    """Return the state at the end of the last piece, highest derivative off."""
    if not len(states):
        raise ValueError("a trajectory without pieces needs its end_state")
    end = advance(states[-1], float(durations[-1]))
    end[-1] = 0.0
    return end


def _padded(trajectory: Trajectory, n: int) -> Trajectory:
    """Return the same motion with zero derivatives up to n."""
    extra = n - trajectory.order
    return Trajectory.from_arrays(
        trajectory.breaks,
        np.pad(trajectory.states, ((0, 0), (0, extra))),
        trajectory.durations,
        np.pad(trajectory.end_state, (0, extra)),
        trajectory.coasting,
    )


def _check_joint(first: Trajectory, second: Trajectory) -> None:
    """Refuse a joint at which velocity or a higher derivative below n jumps."""
    for k in range(1, min(first.order, second.order)):
        end, start = first.end_state[k], second.start_state[k]
        scale = max(first.peak(k), second.peak(k))
        if not abs(end - start) <= 1e-9 * scale:
            raise ValueError(
                f"{derivative_name(k)} would jump from {end:g} to {start:g} at the joint: let "
                f"the second motion start at {end:g}"
            )


def checked_trajectory(trajectory: Any, name: str = "trajectory") -> Trajectory:
    """Return a trajectory, known to the caller by a name; TypeError for anything else."""
    return of_kind(name, trajectory, Trajectory, "a Trajectory, as min_time_move gives")


def within_range(plan: Callable[[], Trajectory]) -> Trajectory:
    """Return plan(), refusing durations and states that leave the range of a double."""

    def checked() -> Trajectory:
        with np.errstate(all="ignore"):
            move = plan()
        if not (0.0 < move.duration < np.inf and np.isfinite(move.states).all()):
            raise OverflowError
        return move

    return in_range(checked)


def point(position: float, order: int) -> Trajectory:
    """Return the trajectory of zero duration that rests at `position`."""
    end = np.zeros(order + 1)
    end[0] = position
    empty: NDArray[np.float64] = np.empty((0, order + 1))
    return Trajectory(np.zeros(1), empty, end_state=end)
