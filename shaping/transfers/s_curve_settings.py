"""What S-curves are planned with: rates and final velocity, checked, and remarks on them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from ..checks import finite, positive
from ..limits import Limits
from .problem import State, checked_state
from .s_curve_plan import ROUNDING
from .s_curve_rates import Moment, Rates

PercentKeeps = Literal["duration", "acceleration"]
"""What a jerk percent leaves as it is: the trapezoid's duration, or the acceleration."""


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
        return replace(self, rates=rates, final_velocity=checked_final(final, rates))


def rates_of(
    velocity: float,
    acceleration: float,
    *,
    deceleration: float | None,
    acceleration_jerk: float | None,
    deceleration_jerk: float | None,
    jerk_percent: float | None,
    percent_keeps: PercentKeeps,
) -> Rates:
    """Return rates, checked; what is left out for slowing down is as for speeding up."""
    acceleration = positive("acceleration", acceleration)
    deceleration = acceleration if deceleration is None else positive("deceleration", deceleration)
    if percent_keeps not in ("duration", "acceleration"):
        raise ValueError(
            f"percent_keeps = {percent_keeps!r}: expected 'duration' or 'acceleration'"
        )
    if jerk_percent is not None:
        _check_no_jerk(acceleration_jerk, deceleration_jerk, jerk_percent)
        share = finite("jerk_percent", jerk_percent)
        if not 0.0 <= share <= 1.0:
            raise ValueError(
                f"jerk_percent = {jerk_percent!r}: expected 0 to 1, such as 0.5 for 50 %"
            )
        keeps_peak = percent_keeps == "acceleration"
        return Rates(velocity, acceleration, deceleration, inf, inf, share, keeps_peak)
    if acceleration_jerk is None:
        raise ValueError("no jerk given: expected acceleration_jerk or jerk_percent")
    rise = positive("acceleration_jerk", acceleration_jerk)
    fall = rise if deceleration_jerk is None else positive("deceleration_jerk", deceleration_jerk)
    return Rates(velocity, acceleration, deceleration, rise, fall)


def start_of(start: State, rates: Rates) -> Moment:
    """Return position, velocity and acceleration at the start, checked."""
    begin = checked_state("start", start, Limits(jerk=1.0))
    if rates.jerk_percent is not None and begin[2] != 0.0:
        raise ValueError(
            f"start acceleration = {begin[2]!r} with a jerk percent, whose ramps begin at zero: "
            "leave it out, or give jerks"
        )
    return begin


def checked_delay(delay: float) -> float:
    """Return a time ≥ 0."""
    checked = finite("delay", delay)
    if checked < 0.0:
        raise ValueError(f"delay = {delay!r}: expected a time ≥ 0")
    return checked


def _check_no_jerk(
    acceleration_jerk: float | None, deceleration_jerk: float | None, percent: float
) -> None:
    if acceleration_jerk is not None or deceleration_jerk is not None:
        raise ValueError(f"jerk_percent = {percent!r} beside a jerk: give one or the other")


def checked_final(final_velocity: float, rates: Rates) -> float:
    """Return a final velocity within the bound."""
    final_velocity = finite("final_velocity", final_velocity)
    if abs(final_velocity) > rates.velocity:
        raise ValueError(
            f"final_velocity = {final_velocity!r}: expected at most the velocity, "
            f"{rates.velocity!r}, either way"
        )
    return final_velocity


def jerk_remarks(settings: SCurveSettings) -> Iterator[str]:
    """Yield what is to be said about jerks outside a²/v ≤ jerk ≤ a/dt."""
    rates = settings.rates
    if rates.jerk_percent is not None:
        return
    for name in ("acceleration", "deceleration"):
        a, jerk = getattr(rates, name), getattr(rates, f"{name}_jerk")
        least = a * (a / rates.velocity)
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
