"""Trajectory: a motion over time, closed under differentiation, and what has one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import core
from .checks import finite, in_range, of_kind, positive
from .derivatives import derivative_name, derivative_number
from .drawing import draw
from .frozen import Frozen
from .limits import Limits
from .pieces import FloatArray, advance, evaluate
from .piecewise_polynomial import PiecewisePolynomial
from .real_numbers import real_number
from .sums import weighted_sum
from .told import Rows, Told


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Trajectory(PiecewisePolynomial):
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

    def relative_to_coasting(self) -> Trajectory:
        """Return the same motion as seen from one that goes on as it coasted in."""
        position, velocity = self.coasting_in()
        states, end = self.states.copy(), self.end_state.copy()
        states[:, 0] -= position + velocity * (self.breaks[:-1] - self.start_time)
        end[0] -= position + velocity * self.duration
        states[:, 1] -= velocity
        end[1] -= velocity
        return Trajectory.from_arrays(self.breaks, states, self.durations, end, self.coasting)

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
        return self._with(self.states + offset, self.end_state + offset)

    def delay(self, time: float) -> Trajectory:
        """Return the same motion, `time` later."""
        breaks = _held(self.breaks + finite("time", time))
        return Trajectory.from_arrays(
            breaks, self.states, self.durations, self.end_state, self.coasting
        )

    def scale(self, factor: float) -> Trajectory:
        """Return the motion with position and all derivatives multiplied by `factor`."""
        factor = finite("factor", factor)
        with np.errstate(over="ignore"):  # which is refused below
            states, end_state = self.states * factor, self.end_state * factor
        return self._with(states, end_state)

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

    def then(self, following: Motion, *, dwell: float = 0.0) -> Trajectory:
        """Append another motion, moved in time and position to begin where this one ends.

        Parameters
        ----------
        following : Trajectory or Transfer
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
        following = as_trajectory(following, "following")
        n = max(self.order, following.order)
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

    def __add__(self, other: Motion) -> Trajectory:
        """Return the sum of two motions, as functions of time; each coasts outside its own."""
        if not isinstance(other, Motion):
            return NotImplemented
        return sum_of((self, as_trajectory(other)), (1.0, 1.0))

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

    def _with(self, states: FloatArray, end_state: FloatArray) -> Trajectory:
        states, end_state = _held(states), _held(end_state)
        return Trajectory.from_arrays(self.breaks, states, self.durations, end_state, self.coasting)


class Planned(Told, Frozen):
    """A motion that knows what it was planned with: it has a trajectory, and answers as that does.

    Whatever takes a trajectory takes it, too (`as_trajectory`). The trajectory of a motion of the
    core, `_motion`, is made when it is asked for.
    """

    trajectory: Trajectory

    def __call__(self, t: ArrayLike, derivative: int | str = 0) -> FloatArray:
        """Evaluate one derivative at times t, as `Trajectory` does."""
        return self.trajectory(t, derivative)

    @property
    def duration(self) -> float:
        """Time from the first break to the last."""
        motion: core.Motion | None = self.__dict__.get("_motion")
        return self.trajectory.duration if motion is None else motion.duration

    @property
    def start_time(self) -> float:
        """The first break; motions of the core begin at 0."""
        motion: core.Motion | None = self.__dict__.get("_motion")
        return self.trajectory.start_time if motion is None else 0.0

    @property
    def end_time(self) -> float:
        """The last break."""
        motion: core.Motion | None = self.__dict__.get("_motion")
        return self.trajectory.end_time if motion is None else motion.duration

    @property
    def end_state(self) -> FloatArray:
        """Position and derivatives 1…n at the end, shape (n + 1,)."""
        return self.trajectory.end_state

    def then(self, following: Motion, *, dwell: float = 0.0) -> Trajectory:
        """Append another motion, as `Trajectory.then` does."""
        return self.trajectory.then(following, dwell=dwell)

    def __add__(self, other: Motion) -> Trajectory:
        """Return the sum of two motions, as `Trajectory` does."""
        return self.trajectory + other

    def __getattr__(self, name: str) -> Any:
        motion = self.__dict__.get("_motion")
        if name == "trajectory" and motion is not None:
            self.__dict__[name] = Trajectory.of_motion(motion)
            return self.__dict__[name]
        if name.startswith("_") or name == "trajectory":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.trajectory, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *dir(self.trajectory)})

    def table_rows(self) -> Rows:
        """Return duration, ends and peaks, as the trajectory does."""
        return self.trajectory.table_rows()

    def picture(self) -> str:
        """Return the position over time."""
        return self.trajectory.picture()

    def __repr__(self) -> str:
        return type(self).__name__ + repr(self.trajectory).removeprefix("Trajectory")


Motion = Trajectory | Planned
"""What every function over a motion takes."""


def as_trajectory(motion: Motion, name: str = "trajectory") -> Trajectory:
    """Return the trajectory of a motion that the caller knows by a name.

    Raises
    ------
    TypeError
        For anything that is neither a trajectory nor has been planned as one.
    """
    if isinstance(motion, Planned):
        return motion.trajectory
    return of_kind(name, motion, Trajectory, "a Trajectory, as min_time_move gives")


def within_range(plan: Callable[[], Trajectory]) -> Trajectory:
    """Return plan(), refusing durations and states that leave the range of a double."""

    def checked() -> Trajectory:
        with np.errstate(all="ignore"):
            move = plan()
        if not (0.0 < move.duration < np.inf and np.isfinite(move.states).all()):
            raise OverflowError
        return move

    return in_range(checked)


def sum_of(parts: Sequence[Trajectory], weights: Sequence[float]) -> Trajectory:
    """Return Σ weights[i]·parts[i], as functions of time; each coasts outside its own."""
    breaks, states, end, coasting = weighted_sum(parts, weights)
    return Trajectory(breaks, states, end_state=end, coasting=coasting)


def point(position: float, order: int) -> Trajectory:
    """Return the trajectory of zero duration that rests at `position`."""
    end = np.zeros(order + 1)
    end[0] = position
    empty: NDArray[np.float64] = np.empty((0, order + 1))
    return Trajectory(np.zeros(1), empty, end_state=end)


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


def _held(values: FloatArray) -> FloatArray:
    """Return values; ValueError where one leaves the range of a double."""
    if not np.isfinite(values).all():
        raise ValueError("the result leaves the range of a double")
    return values
