"""S-curves to a velocity in a motion controller's words: a change, its modify and append."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from ..checks import finite, in_range, positive
from ..limits import Limits
from ..trajectory import Planned, Trajectory
from .problem import Problem, State
from .s_curve_ramps import distance_of, plan_velocity
from .s_curve_rates import Moment, in_own_units
from .s_curve_settings import (
    PercentKeeps,
    SCurveSettings,
    checked_delay,
    jerk_remarks,
    rates_of,
    start_of,
)
from .under_way import before, of_pieces, spliced


@dataclass(frozen=True, eq=False, repr=False)
class VelocityMove(Planned):
    """A change of velocity, of order 3, that can be modified under way and appended to.

    Attributes
    ----------
    trajectory : Trajectory
    settings : SCurveSettings
        What its last part was planned with, its velocity unbounded.
    remarks : tuple of str
        Jerks above a/dt, with which the acceleration is reached within one sample.
    """

    trajectory: Trajectory
    settings: SCurveSettings
    remarks: tuple[str, ...] = ()

    def modify(
        self,
        time: float,
        *,
        velocity: float | None = None,
        relative: bool = False,
        acceleration: float | None = None,
        deceleration: float | None = None,
        acceleration_jerk: float | None = None,
        deceleration_jerk: float | None = None,
    ) -> VelocityMove:
        """Return this motion up to a time, and from its state then on a new change of velocity.

        Parameters
        ----------
        time : float
            Before its start it waits, after its end it coasts.
        velocity : float, optional
            New final velocity: absolute, or from the old one where `relative`. What is left out
            stays as it was.
        relative : bool, optional
        acceleration, deceleration, acceleration_jerk, deceleration_jerk : float, optional
            As in `velocity_move`.

        Returns
        -------
        VelocityMove
            Planned from position, velocity and acceleration at that time, so that acceleration
            has no step. By jerk percent the new ramp begins with zero acceleration.

        Raises
        ------
        ValueError
            As `velocity_move`.
        """
        been = before(self, finite("time", time))
        if velocity is None:
            velocity, relative = 0.0, True
        settings = self._settings(
            velocity,
            relative,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
        )
        return _onward(been, settings)

    def append(
        self,
        velocity: float,
        *,
        relative: bool = False,
        delay: float = 0.0,
        acceleration: float | None = None,
        deceleration: float | None = None,
        acceleration_jerk: float | None = None,
        deceleration_jerk: float | None = None,
    ) -> VelocityMove:
        """Return this motion and another change of velocity behind it.

        Parameters
        ----------
        velocity : float
            Absolute, or from this motion's final velocity where `relative`.
        relative : bool, optional
        delay : float, optional
            Time in between, coasting at this motion's final velocity.
        acceleration, deceleration, acceleration_jerk, deceleration_jerk : float, optional
            As in `velocity_move`; what is left out stays as it was.
        """
        settings = self._settings(
            velocity,
            relative,
            acceleration=acceleration,
            deceleration=deceleration,
            acceleration_jerk=acceleration_jerk,
            deceleration_jerk=deceleration_jerk,
        )
        return _onward(self.until(self.end_time + checked_delay(delay)), settings)

    def _settings(self, velocity: float, relative: bool, **rates: float | None) -> SCurveSettings:
        """Return the settings of what follows."""
        final = _final(velocity, self.settings.final_velocity if relative else 0.0)
        return self.settings.changed(final_velocity=final, **rates)


def velocity_move(
    velocity: float,
    *,
    acceleration: float,
    deceleration: float | None = None,
    acceleration_jerk: float | None = None,
    deceleration_jerk: float | None = None,
    jerk_percent: float | None = None,
    percent_keeps: PercentKeeps = "duration",
    start: State = 0.0,
    relative: bool = False,
    delay: float = 0.0,
    dt: float | None = None,
) -> VelocityMove:
    """Return the fastest S-curve to a velocity, in the words of motion controllers.

    Between rest and velocity v, acceleration A and jerk J are used for

        T = v/A + A/J   where v ≥ A²/J,   2·√(v/J)   else.

    Parameters
    ----------
    velocity : float
        Velocity at the end, signed, kept from then on; from the start's where `relative`.
    acceleration : float
        Largest acceleration while speeding up, positive.
    deceleration : float, optional
        Largest acceleration while slowing down. Default: `acceleration`.
    acceleration_jerk, deceleration_jerk : float, optional
        Largest jerk while speeding up and while slowing down. The second defaults to the first.
    jerk_percent, percent_keeps : optional
        In place of jerks, as in `s_curve_move`.
    start : (position, velocity, acceleration), optional
        Numbers left out are zero.
    relative : bool, optional
    delay : float, optional
        Time before the change begins, coasting.
    dt : float, optional
        Sampling interval of the controller, for the remarks.

    Returns
    -------
    VelocityMove
        Wherever it ends.

    Raises
    ------
    ValueError
        For values that are not finite, rates that are not positive, a jerk percent outside 0…1
        or beside jerks, or neither of them.

    Notes
    -----
    With the same rates in both cases this is `velocity_transfer`. Where they differ and the motion
    must turn round, it stops first: which rate applies changes there.

    References
    ----------
    Moment Engineering Inc., "S-Curve Jerk Algorithm": velocity moves.

    Examples
    --------
    >>> spin = velocity_move(4.0, acceleration=8.0, deceleration=2.0, acceleration_jerk=40.0)
    >>> round(spin.duration, 3), spin(9.0, "velocity")
    (0.7, 4.0)
    >>> slower = spin.modify(2.0, velocity=-1.0, relative=True)
    >>> slower.end_state[1], round(slower.end_time, 3)
    (np.float64(3.0), 2.55)
    """
    rates = rates_of(
        inf,
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
    final = _final(velocity, begin[1] if relative else 0.0)
    settings = SCurveSettings(rates, final, dt=dt)
    plan = _planned(begin, settings)
    return _as_move(plan.delay(delay) if delay else plan, settings)


def stop_from(begin: Moment, settings: SCurveSettings) -> Trajectory:
    """Return the fastest way to rest, beginning at time 0."""
    return _planned(begin, replace(settings, final_velocity=0.0))


def _final(velocity: float, origin: float) -> float:
    return finite("velocity", finite("velocity", velocity) + origin)


def _onward(been: Trajectory, settings: SCurveSettings) -> VelocityMove:
    """Return a motion and a new change of velocity behind it."""
    x, v, a = been.end_state[:3].tolist()
    return _as_move(spliced(been, _planned((x, v, a), settings)), settings)


def _planned(begin: Moment, settings: SCurveSettings) -> Trajectory:
    """Return the change from a state, beginning at time 0."""
    rates, final = settings.rates, settings.final_velocity
    binding = in_own_units((0.0, *begin[1:]), 0.0, final, rates)[1]

    def planned() -> Trajectory:
        if binding.alike and rates.jerk_percent is None:
            limits = Limits(acceleration=rates.acceleration, jerk=rates.acceleration_jerk)
            return Problem(begin, (begin[0], final), limits).change_of_velocity().trajectory
        pieces = plan_velocity(begin, final, rates)
        return of_pieces(pieces, (begin[0] + distance_of(pieces), final))

    return in_range(planned)


def _as_move(motion: Trajectory, settings: SCurveSettings) -> VelocityMove:
    """Return a motion as a move."""
    return VelocityMove(motion, settings, tuple(jerk_remarks(settings)))
