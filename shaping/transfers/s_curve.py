"""S-curve moves in a motion controller's words: acceleration and deceleration, modify, append."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import accumulate
from math import inf
from typing import Literal

import numpy as np

from ..checks import finite, in_range, positive
from ..limits import Limits
from ..trajectory import Trajectory
from .infeasible import InfeasibleError
from .problem import Problem, State, checked_state
from .s_curve_plan import ROUNDING, plan_move, stopping_place
from .s_curve_rates import Motion, Piece, Rates, in_own_units

_TURNS = 1e-9  # of the velocity: less than this backwards is rounding


@dataclass(frozen=True)
class SCurveSettings:
    """What an S-curve move is planned with, as `s_curve_move` takes it."""

    rates: Rates
    final_velocity: float = 0.0
    no_reversal: bool = False
    dt: float | None = None

    def changed(self, *, final_velocity: float | None, **given: float | None) -> SCurveSettings:
        """Return the settings with the rates and the final velocity that are given."""
        jerks = given["acceleration_jerk"], given["deceleration_jerk"]
        if self.rates.jerk_percent is not None:
            _check_no_jerk(*jerks, self.rates.jerk_percent)
        new = {name: positive(name, value) for name, value in given.items() if value is not None}
        rates = replace(self.rates, **new)  # type: ignore[arg-type]
        final = self.final_velocity if final_velocity is None else final_velocity
        return replace(self, rates=rates, final_velocity=_final(final, rates))


@dataclass(frozen=True, init=False, eq=False, repr=False)
class SCurveMove(Trajectory):
    """A trajectory of order 3 that can be modified under way and appended to.

    Attributes
    ----------
    settings : SCurveSettings, optional
        What its last part was planned with; None where it was made from arrays.
    remarks : tuple of str
        Jerks outside the range of sense, a²/v ≤ jerk ≤ a/dt, and what comes of it; a velocity
        beyond its bound that the last plan had to bring down.
    """

    settings: SCurveSettings | None = None
    remarks: tuple[str, ...] = ()

    def modify(
        self,
        time: float,
        *,
        target: float | None = None,
        relative: bool = False,
        velocity: float | None = None,
        acceleration: float | None = None,
        deceleration: float | None = None,
        acceleration_jerk: float | None = None,
        deceleration_jerk: float | None = None,
        final_velocity: float | None = None,
    ) -> SCurveMove:
        """Return this move up to a time, and from its state then on a new plan.

        Parameters
        ----------
        time : float
            Before its start it waits, after its end it coasts.
        target : float, optional
            New position: absolute, or from the old target where `relative`. What is left out stays
            as it was.
        relative : bool, optional
        velocity, acceleration, deceleration, acceleration_jerk, deceleration_jerk : float, optional
        final_velocity : float, optional
            As in `s_curve_move`.

        Returns
        -------
        SCurveMove
            Planned from position, velocity and acceleration at that time, so that acceleration
            has no step. By jerk percent the new plan begins with zero acceleration, as
            controllers of old do.

        Raises
        ------
        ValueError
            As `s_curve_move`.
        """
        settings, time = self._known(), finite("time", time)
        before = _waiting(self, time) if time < self.start_time else self.until(time)
        settings = settings.changed(
            velocity=velocity,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
            final_velocity=final_velocity,
        )
        return self._onward(before, 0.0 if target is None else target, settings,
                            relative or target is None)  # fmt: skip

    def append(
        self,
        target: float,
        *,
        relative: bool = False,
        delay: float = 0.0,
        velocity: float | None = None,
        acceleration: float | None = None,
        deceleration: float | None = None,
        acceleration_jerk: float | None = None,
        deceleration_jerk: float | None = None,
        final_velocity: float | None = None,
    ) -> SCurveMove:
        """Return this move and another one behind it.

        Parameters
        ----------
        target : float
            Absolute, or from the end of this move where `relative`.
        relative : bool, optional
        delay : float, optional
            Time in between, coasting at this move's final velocity.
        velocity, acceleration, deceleration, acceleration_jerk, deceleration_jerk : float, optional
        final_velocity : float, optional
            As in `s_curve_move`; what is left out stays as it was.
        """
        settings = self._known().changed(
            velocity=velocity,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
            final_velocity=final_velocity,
        )
        before = self.until(self.end_time + _delay(delay))
        return self._onward(before, target, settings, relative)

    def _onward(
        self, before: Trajectory, target: float, settings: SCurveSettings, relative: bool
    ) -> SCurveMove:
        """Return a motion and a new plan behind it."""
        goal = finite("target", target) + (float(self.end_state[0]) if relative else 0.0)
        x, v, a = before.end_state[:3].tolist()
        plan = _planned((x, v, a), goal, settings)
        return _as_move(_spliced(before, plan), plan, settings)

    def _known(self) -> SCurveSettings:
        if self.settings is None:
            raise ValueError(f"{self!r} was made from arrays: plan it by s_curve_move to go on")
        return self.settings


def s_curve_move(
    target: float,
    *,
    velocity: float,
    acceleration: float,
    deceleration: float | None = None,
    acceleration_jerk: float | None = None,
    deceleration_jerk: float | None = None,
    jerk_percent: float | None = None,
    percent_keeps: Literal["duration", "acceleration"] = "duration",
    start: State = 0.0,
    final_velocity: float = 0.0,
    relative: bool = False,
    delay: float = 0.0,
    no_reversal: bool = False,
    dt: float | None = None,
) -> SCurveMove:
    """Return the fastest S-curve to a target, in the words of motion controllers.

    Parameters
    ----------
    target : float
        Position at the end; from the start where `relative`.
    velocity, acceleration : float
        Largest speed, and acceleration while speeding up; positive.
    deceleration : float, optional
        Largest acceleration while slowing down. Default: `acceleration`.
    acceleration_jerk, deceleration_jerk : float, optional
        Largest jerk while speeding up and while slowing down. The second defaults to the first.
    jerk_percent : float, optional
        In place of jerks: p from 0 to 1 (0.5 is 50 %). The duration is the trapezoid's; the
        jerk acts in p/2 of each ramp at either end, and the peak acceleration rises to
        A/(1 − p/2).
    percent_keeps : "duration" or "acceleration", optional
        What a jerk percent leaves as it is: the trapezoid's duration (default), or the
        acceleration, which then is a maximum never exceeded: each ramp takes 1/(1 − p/2) times as
        long, so that moves are the quicker the smaller the percentage.
    start : (position, velocity, acceleration), optional
        Numbers left out are zero.
    final_velocity : float, optional
        Velocity, signed, with which the target is passed.
    relative : bool, optional
    delay : float, optional
        Time before the motion begins.
    no_reversal : bool, optional
        Refuse a plan whose velocity changes sign.
    dt : float, optional
        Sampling interval of the controller, for the remarks.

    Returns
    -------
    SCurveMove

    Raises
    ------
    InfeasibleError
        With `no_reversal`, where the target cannot be reached without turning round; `nearest` is
        the nearest target that can.
    ValueError
        For values that are not finite, rates that are not positive, a final velocity beyond the
        velocity, a jerk percent outside 0…1 or beside jerks, or neither of them.

    Notes
    -----
    With the same rates in both cases this is `min_time_transfer`. Where they differ and the motion
    must turn round, it stops first: which rate applies changes there.

    Speeding up to acceleration a and velocity v makes sense with a jerk of at least a²/v, below
    which the acceleration is not reached, and at most a/dt, with which it is reached in one
    sample; the move's `remarks` say where a jerk is outside.

    References
    ----------
    Motion Engineering Inc., "S-Curve Jerk Algorithm".

    Examples
    --------
    >>> move = s_curve_move(10.0, velocity=4.0, acceleration=8.0, acceleration_jerk=40.0)
    >>> round(move.duration, 3)
    3.2
    """
    rates = _rates(
        velocity, acceleration, deceleration, acceleration_jerk, deceleration_jerk, jerk_percent
    )
    if percent_keeps not in ("duration", "acceleration"):
        raise ValueError(
            f"percent_keeps = {percent_keeps!r}: expected 'duration' or 'acceleration'"
        )
    rates = replace(rates, percent_keeps_peak=percent_keeps == "acceleration")
    if dt is not None:
        dt = positive("dt", dt)
    delay = _delay(delay)
    begin = checked_state("start", start, Limits(jerk=1.0))
    goal = finite("target", target) + (begin[0] if relative else 0.0)
    if jerk_percent is not None and begin[2] != 0.0:
        raise ValueError(
            f"start acceleration = {begin[2]!r} with a jerk percent, whose ramps begin at zero: "
            "leave it out, or give jerks"
        )
    settings = SCurveSettings(rates, _final(final_velocity, rates), no_reversal, dt)
    plan = _planned(begin, goal, settings)
    return _as_move(plan.delay(delay) if delay else plan, plan, settings)


def _rates(
    velocity: float,
    acceleration: float,
    deceleration: float | None,
    acceleration_jerk: float | None,
    deceleration_jerk: float | None,
    jerk_percent: float | None,
) -> Rates:
    velocity, acceleration = positive("velocity", velocity), positive("acceleration", acceleration)
    if deceleration is None:
        deceleration = acceleration
    deceleration = positive("deceleration", deceleration)
    if jerk_percent is not None:
        _check_no_jerk(acceleration_jerk, deceleration_jerk, jerk_percent)
        share = finite("jerk_percent", jerk_percent)
        if not 0.0 <= share <= 1.0:
            raise ValueError(
                f"jerk_percent = {jerk_percent!r}: expected 0 to 1, such as 0.5 for 50 %"
            )
        return Rates(velocity, acceleration, deceleration, inf, inf, share)
    if acceleration_jerk is None:
        raise ValueError("no jerk given: expected acceleration_jerk or jerk_percent")
    if deceleration_jerk is None:
        deceleration_jerk = acceleration_jerk
    return Rates(
        velocity,
        acceleration,
        deceleration,
        positive("acceleration_jerk", acceleration_jerk),
        positive("deceleration_jerk", deceleration_jerk),
    )


def _delay(delay: float) -> float:
    checked = finite("delay", delay)
    if checked < 0.0:
        raise ValueError(f"delay = {delay!r}: expected a time ≥ 0")
    return checked


def _check_no_jerk(
    acceleration_jerk: float | None, deceleration_jerk: float | None, percent: float
) -> None:
    if acceleration_jerk is not None or deceleration_jerk is not None:
        raise ValueError(f"jerk_percent = {percent!r} beside a jerk: give one or the other")


def _final(final_velocity: float, rates: Rates) -> float:
    final_velocity = finite("final_velocity", final_velocity)
    if abs(final_velocity) > rates.velocity:
        raise ValueError(
            f"final_velocity = {final_velocity!r}: expected at most the velocity, "
            f"{rates.velocity!r}, either way"
        )
    return final_velocity


def _planned(begin: Motion, target: float, settings: SCurveSettings) -> Trajectory:
    """Return the motion from a state to a target, beginning at time 0."""
    rates = settings.rates
    binding = in_own_units(begin, target, settings.final_velocity, rates)[1]
    alike = (
        binding.acceleration == binding.deceleration
        and binding.acceleration_jerk == binding.deceleration_jerk
    )

    def planned() -> Trajectory:
        if alike and rates.jerk_percent is None:
            limits = Limits(rates.velocity, rates.acceleration, rates.acceleration_jerk)
            return Problem(begin, (target, settings.final_velocity), limits).fastest().trajectory
        return _trajectory(
            plan_move(begin, target, settings.final_velocity, rates),
            target,
            settings.final_velocity,
        )

    motion = in_range(planned)
    if settings.no_reversal:
        _check_no_reversal(motion, begin, target, settings)
    return motion


def _trajectory(pieces: list[Piece], target: float, final_velocity: float) -> Trajectory:
    pieces = [piece for piece in pieces if piece[0] > 0.0]
    durations = np.array([duration for duration, _ in pieces])
    breaks = np.array([0.0, *accumulate(durations.tolist())])
    states = np.array([row for _, row in pieces]).reshape(len(pieces), 4)
    if not (np.isfinite(breaks).all() and np.isfinite(states).all()):
        raise OverflowError
    end = np.array([target, final_velocity, 0.0, 0.0])
    return Trajectory.from_arrays(breaks, states, durations, end)


def _check_no_reversal(
    motion: Trajectory, begin: Motion, target: float, settings: SCurveSettings
) -> None:
    low, high = motion.extremes("velocity")
    slight = _TURNS * settings.rates.velocity
    if low >= -slight or high <= slight:
        return
    nearest = stopping_place(begin, settings.final_velocity, settings.rates)
    raise InfeasibleError(
        f"target = {target!r} takes a reversal, which no_reversal forbids: the nearest target "
        f"without one is {nearest!r}",
        "position",
        nearest,
    )


def _waiting(move: Trajectory, time: float) -> Trajectory:
    """Return a point at the state in which a move waits for its start."""
    x, v = move.coasting_in()
    end = [x + v * (time - move.start_time), v, 0.0, 0.0]
    return Trajectory([time], np.empty((0, 4)), end_state=end)


def _spliced(before: Trajectory, after: Trajectory) -> Trajectory:
    """Return the motion that goes over from one to another, whose acceleration may step."""
    breaks = before.end_time + after.breaks
    return Trajectory.from_arrays(
        np.append(before.breaks, breaks[1:]),
        np.vstack([before.states, after.states]),
        np.append(before.durations, after.durations),
        after.end_state.copy(),
    )


def _as_move(motion: Trajectory, plan: Trajectory, settings: SCurveSettings) -> SCurveMove:
    """Return a motion, its last part the plan, as a move."""
    move = SCurveMove.from_arrays(motion.breaks, motion.states, motion.durations, motion.end_state)
    fields = move.__dict__  # the way around `frozen`
    fields["settings"], fields["remarks"] = (
        settings,
        (*_remarks(settings), *_excess(plan, settings)),
    )
    return move


def _excess(motion: Trajectory, settings: SCurveSettings) -> Iterator[str]:
    """Yield what is to be said about a velocity that a plan has to bring down."""
    fastest = motion.peak("velocity")
    if fastest > settings.rates.velocity * (1.0 + _TURNS):
        yield (
            f"velocity reaches {fastest:g}, beyond {settings.rates.velocity:g}: it was there, or "
            "on its way there, when the plan was made, and is brought down at once"
        )


def _remarks(settings: SCurveSettings) -> Iterator[str]:
    """Yield what is to be said about jerks outside a²/v ≤ jerk ≤ a/dt."""
    rates = settings.rates
    if rates.jerk_percent is not None:
        return
    for name in ("acceleration", "deceleration"):
        a, jerk = getattr(rates, name), getattr(rates, f"{name}_jerk")
        least = a * a / rates.velocity
        if jerk < least * (1.0 - ROUNDING):
            yield (
                f"{name}_jerk = {jerk:g} is below {name}²/velocity = {least:g}: between rest and "
                f"a velocity of {rates.velocity:g} the {name} of {a:g} is not reached"
            )
        if settings.dt is not None and jerk > a / settings.dt:
            yield (
                f"{name}_jerk = {jerk:g} is above {name}/dt = {a / settings.dt:g}: the {name} of "
                f"{a:g} is reached within one sample"
            )
