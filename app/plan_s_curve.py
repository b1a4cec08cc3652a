"""An S-curve from quantities with units, in a motion controller's words."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from math import inf
from typing import TYPE_CHECKING

from ..shaping import Limits
from .plan import Plan, quantity, way
from .units import Kind, Motion, UnitError, factor, motion_kind, show

if TYPE_CHECKING:
    from ..shaping import SCurveMove

PERCENTAGE = Kind(name="a percentage from 0 to 100 %", unit="%", example="50 %", least=0.0)
_BARE = re.compile(r"[0-9]+\.?[0-9]*|\.[0-9]+")
_DERIVATIVES = {"velocity": 1, "acceleration": 2, "deceleration": 2, "jerk": 3,
                "deceleration_jerk": 3}  # fmt: skip


@dataclass(frozen=True)
class SCurveText:
    """The rates of an S-curve as text; those left out are None.

    `percent_keeps` is "duration" or "acceleration", as in `s_curve_move`.
    """

    velocity: str | None = None
    acceleration: str | None = None
    deceleration: str | None = None
    jerk: str | None = None
    deceleration_jerk: str | None = None
    jerk_percent: str | None = None
    percent_keeps: str | None = None


def plan_s_curve(
    distance: str | None, rates: SCurveText, *, start: str | None = None, to: str | None = None
) -> Plan:
    """Plan the fastest S-curve between rests.

    Parameters
    ----------
    distance, start, to : str, optional
        As in `plan_move`.
    rates : SCurveText
        Velocity, acceleration, and a jerk or a jerk percent at the least.

    Returns
    -------
    Plan
        Its limits are those of the direction in which it goes. By jerk percent acceleration has
        the bound to which its peak rises, jerk none.

    Raises
    ------
    UnitError
        For text that is not such a quantity; the message names it.
    ValueError
        For rates that do not fit together, or are missing.
    """
    from ..shaping import s_curve_move

    route = way(distance, start, to)
    scale = factor(route.unit)
    numbers = {name: value / scale for name, value in _numbers(rates, route.motion).items()}
    for name in ("velocity", "acceleration"):
        if name not in numbers:
            example = motion_kind(route.motion, _DERIVATIVES[name]).example
            raise ValueError(f"an S-curve needs --{name}, such as --{name} {example!r}")
    percent = None if rates.jerk_percent is None else _percent(rates.jerk_percent)
    if percent is None and "jerk" not in numbers:
        raise ValueError("an S-curve needs --jerk or --jerk-percent, such as --jerk-percent '50 %'")
    if percent is not None and {"jerk", "deceleration_jerk"} & set(numbers):
        raise ValueError("--jerk-percent stands in place of a jerk: leave one of them out")
    if percent is None and rates.percent_keeps is not None:
        raise ValueError("--percent-keeps says what a jerk percent keeps: give --jerk-percent, too")
    move = s_curve_move(
        route.length / scale,
        velocity=numbers["velocity"],
        acceleration=numbers["acceleration"],
        deceleration=numbers.get("deceleration"),
        acceleration_jerk=numbers.get("jerk"),
        deceleration_jerk=numbers.get("deceleration_jerk"),
        jerk_percent=percent,
        percent_keeps=rates.percent_keeps or "duration",  # type: ignore[arg-type]  # checked there
    )
    told = (*_told(move, route.unit), *move.remarks)
    trajectory = move.scale(scale).shift(route.origin)
    return Plan(trajectory, _limits(move, scale, backwards=route.length < 0.0), route.unit, told)


def _numbers(rates: SCurveText, motion: Motion) -> dict[str, float]:
    """Return the rates that are given, in SI units."""
    given = {field.name: getattr(rates, field.name) for field in fields(rates)}
    for name in _DERIVATIVES:
        if "," in (given[name] or ""):
            raise UnitError(
                f"--{name.replace('_', '-')} {show(given[name])}: an S-curve takes one positive "
                "number for each rate; write the one of slowing down behind --deceleration or "
                "--deceleration-jerk"
            )
    return {
        name: quantity(name.replace("_", " "), given[name], motion_kind(motion, k, positive=True))
        for name, k in _DERIVATIVES.items()
        if given[name] is not None
    }


def _percent(text: str) -> float:
    """Return a jerk percent as a share from 0 to 1; a number above 1 needs no sign."""
    bare = _BARE.fullmatch(text.strip()) is not None
    if bare and 0.0 < float(text) <= 1.0:
        raise UnitError(
            f"jerk percent: {show(text)} may be a share or a percentage; write it with its sign, "
            f"such as {PERCENTAGE.example!r}"
        )
    value = quantity("jerk percent", f"{text} %" if bare else text, PERCENTAGE)
    if value > 100.0:
        raise UnitError(
            f"jerk percent: {show(text)} is out of range; write {PERCENTAGE.name} such as "
            f"{PERCENTAGE.example!r}"
        )
    return value / 100.0


def _limits(move: SCurveMove, scale: float, *, backwards: bool) -> Limits:
    """Return what a move from rest to rest keeps to, in SI units."""
    assert move.settings is not None
    rates = move.settings.rates
    rise = 1.0 if rates.percent_keeps_peak else 1.0 - 0.5 * (rates.jerk_percent or 0.0)
    accelerations = -rates.deceleration / rise, rates.acceleration / rise
    if backwards:
        accelerations = -accelerations[1], -accelerations[0]
    jerk = max(rates.acceleration_jerk, rates.deceleration_jerk)
    return Limits(
        rates.velocity * scale,
        (accelerations[0] * scale, accelerations[1] * scale),
        None if jerk == inf else jerk * scale,
    )


def _told(move: SCurveMove, unit: str) -> list[str]:
    """Return what speeding up and slowing down are planned with."""
    assert move.settings is not None
    rates = move.settings.rates
    told = []
    for name, phase in (("acceleration", "Speeding up"), ("deceleration", "Slowing down")):
        jerk = f"jerk {getattr(rates, f'{name}_jerk'):.9g} {unit}/s^3"
        if rates.jerk_percent is not None:
            kept = "acceleration" if rates.percent_keeps_peak else "duration"
            jerk = f"jerk percent {100.0 * rates.jerk_percent:.9g} %, which keeps the {kept}"
        told.append(f"{phase}: {getattr(rates, name):.9g} {unit}/s^2, {jerk}")
    return told
