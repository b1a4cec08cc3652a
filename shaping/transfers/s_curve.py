"""S-curve moves in a motion controller's words: acceleration and deceleration, modify, append."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf

from ..checks import finite, in_range, positive
from ..limits import Limits
from ..trajectory import Motion, Planned, Trajectory
from .infeasible import InfeasibleError
from .problem import Problem, State
from .s_curve_plan import plan_move, stopping_place
from .s_curve_rates import Moment, in_own_units
from .s_curve_settings import (
    PercentKeeps,
    SCurveSettings,
    checked_delay,
    checked_final,
    jerk_remarks,
    rates_of,
    start_of,
)
from .under_way import before, of_pieces, spliced

_TURNS = 1e-9  # of the velocity: less than this backwards is rounding
_SLOWEST = 2.0**-40  # of the velocity: no slower way is looked for


@dataclass(frozen=True, eq=False, repr=False)
class SCurveMove(Planned):
    """A motion of order 3 that can be modified under way and appended to.

    Attributes
    ----------
    trajectory : Trajectory
    settings : SCurveSettings
        What its last part was planned with.
    remarks : tuple of str
        Jerks outside the range of sense, a²/v ≤ jerk ≤ a/dt, and what comes of it; a velocity
        beyond its bound that the last plan had to bring down.
    """

    trajectory: Trajectory
    settings: SCurveSettings
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
        settings = self.settings.changed(
            velocity=velocity,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
            final_velocity=final_velocity,
        )
        been = before(self, finite("time", time))
        if target is None:
            target, relative = 0.0, True
        return self._onward(been, target, settings, relative)

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
        settings = self.settings.changed(
            velocity=velocity,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
            final_velocity=final_velocity,
        )
        been = self.until(self.end_time + checked_delay(delay))
        return self._onward(been, target, settings, relative)

    def _onward(
        self, been: Trajectory, target: float, settings: SCurveSettings, relative: bool
    ) -> SCurveMove:
        """Return a motion and a new plan behind it."""
        goal = finite("target", target) + (float(self.end_state[0]) if relative else 0.0)
        x, v, a = been.end_state[:3].tolist()
        plan = _planned((x, v, a), goal, settings)
        return _as_move(spliced(been, plan), plan, settings)


def s_curve_move(
    target: float,
    *,
    velocity: float,
    acceleration: float,
    deceleration: float | None = None,
    acceleration_jerk: float | None = None,
    deceleration_jerk: float | None = None,
    jerk_percent: float | None = None,
    percent_keeps: PercentKeeps = "duration",
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
    Moment Engineering Inc., "S-Curve Jerk Algorithm".

    Examples
    --------
    >>> move = s_curve_move(10.0, velocity=4.0, acceleration=8.0, acceleration_jerk=40.0)
    >>> round(move.duration, 3)
    3.2
    """
    rates = rates_of(
        positive("velocity", velocity),
        acceleration,
        deceleration=deceleration,
        acceleration_jerk=acceleration_jerk,
        deceleration_jerk=deceleration_jerk,
        jerk_percent=jerk_percent,
        percent_keeps=percent_keeps,
    )
    if dt is not None:
        dt = positive("dt", dt)
    delay, begin = checked_delay(delay), start_of(start, rates)
    goal = finite("target", target) + (begin[0] if relative else 0.0)
    settings = SCurveSettings(rates, checked_final(final_velocity, rates), no_reversal, dt)
    plan = _planned(begin, goal, settings)
    return _as_move(plan.delay(delay) if delay else plan, plan, settings)


def s_curve_from(begin: Moment, target: float, settings: SCurveSettings) -> SCurveMove:
    """Return the plan from a state on, beginning at time 0."""
    plan = _planned(begin, target, settings)
    return _as_move(plan, plan, settings)


def longest(move: Motion) -> float:
    """Return the duration up to which a lower velocity makes a plan longer."""
    settings = _settings_of(move)
    least = abs(settings.final_velocity)
    return inf if not least else _slower(move, settings, least).duration


def lasting(move: Motion, duration: float) -> SCurveMove | None:
    """Return the plan of a move with the velocity that makes it last so long; None for none."""
    settings = _settings_of(move)
    low = high = settings.rates.velocity
    least = max(abs(settings.final_velocity), high * _SLOWEST)
    while _slower(move, settings, low).duration < duration:
        if low <= least:
            return None
        low, high = max(0.5 * low, least), low
    while low < (middle := 0.5 * (low + high)) < high:
        if _slower(move, settings, middle).duration >= duration:
            low = middle
        else:
            high = middle
    slower = _slower(move, settings, low)
    return slower if slower.duration <= duration * (1.0 + _TURNS) else None


def _settings_of(move: Motion) -> SCurveSettings:
    assert isinstance(move, SCurveMove)
    return move.settings


def _slower(move: Motion, settings: SCurveSettings, velocity: float) -> SCurveMove:
    """Return the same plan with a lower velocity."""
    slower = replace(settings, rates=replace(settings.rates, velocity=velocity))
    x, v, a = move.start_state[:3].tolist()
    return s_curve_from((x, v, a), float(move.end_state[0]), slower)


def _planned(begin: Moment, target: float, settings: SCurveSettings) -> Trajectory:
    """Return the motion from a state to a target, beginning at time 0."""
    rates, final_velocity = settings.rates, settings.final_velocity
    binding = in_own_units(begin, target, final_velocity, rates)[1]

    def planned() -> Trajectory:
        if binding.alike and rates.jerk_percent is None:
            limits = Limits(rates.velocity, rates.acceleration, rates.acceleration_jerk)
            return Problem(begin, (target, final_velocity), limits).fastest().trajectory
        pieces = plan_move(begin, target, final_velocity, rates)
        return of_pieces(pieces, (target, final_velocity))

    motion = in_range(planned)
    if settings.no_reversal:
        _check_no_reversal(motion, begin, target, settings)
    return motion


def _check_no_reversal(
    motion: Trajectory, begin: Moment, target: float, settings: SCurveSettings
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


def _as_move(motion: Trajectory, plan: Trajectory, settings: SCurveSettings) -> SCurveMove:
    """Return a motion, its last part the plan, as a move."""
    remarks = *jerk_remarks(settings), *_excess(plan, settings)
    return SCurveMove(motion, settings, remarks)


def _excess(motion: Trajectory, settings: SCurveSettings) -> Iterator[str]:
    """Yield what is to be said about a velocity that a plan has to bring down."""
    fastest = motion.peak("velocity")
    if fastest > settings.rates.velocity * (1.0 + _TURNS):
        yield (
            f"velocity reaches {fastest:g}, beyond {settings.rates.velocity:g}: it was there, or "
            "on its way there, when the plan was made, and is brought down at once"
        )
