"""The quantities of a scenario file of format 2, each for angular and for linear axes."""

from __future__ import annotations

import math

from .scenario_keys import Quantity
from .units import DURATION, FREQUENCY, Kind, Motion, motion_kind

_FORCE = {"angle": ("torque", "N m"), "length": ("force", "N")}
_PER = {"angle": "/rad", "length": "/m"}


def _kind(name: str, unit: str, example: str, *, least: float = -math.inf, above: float = -math.inf,
          below: float = math.inf) -> Kind:  # fmt: skip
    return Kind(name=name, unit=unit, example=f"{example} {unit}", least=least, above=above,
                below=below)  # fmt: skip


def _alike(kind: Kind, *others: Kind, words: tuple[str, ...] = (), scale: float = 1.0) -> Quantity:
    """Return a quantity that does not depend on the axis."""
    return Quantity((kind, *others), (kind, *others), words=words, scale=scale)


def torque(sign: str = "") -> Quantity:
    """Return a torque, or a force: "positive", "not below zero", or of any sign."""
    return Quantity(*((_force(motion, sign),) for motion in ("angle", "length")))  # type: ignore[arg-type]


def _force(motion: Motion, sign: str) -> Kind:
    noun, unit = _FORCE[motion]
    return _signed(noun, unit, "5", sign)


def _signed(noun: str, unit: str, example: str, sign: str) -> Kind:
    article = "an" if noun[0] in "aeiou" else "a"
    if sign == "positive":
        return _kind(f"a positive {noun}", unit, example, above=0.0)
    if sign:
        return _kind(f"{article} {noun} {sign}", unit, example, least=0.0)
    return _kind(f"{article} {noun}", unit, example)


def gain(derivative: int, noun: str, sign: str = "not below zero") -> Quantity:
    """Return a torque per derivative of position, or a force."""
    per_time = {0: "", 1: " s"}.get(derivative, f" s^{derivative}")
    angle, length = (
        _signed(noun, f"{_FORCE[motion][1]}{per_time}{_PER[motion]}", "2", sign)
        for motion in _FORCE
    )
    inertia = _signed("moment of inertia", "kg m^2", "2", sign)
    return Quantity((angle, inertia) if derivative == 2 else (angle,), (length,))


def moved(derivative: int = 0, *, sign: str = "") -> Quantity:
    """Return a position or one of its derivatives: "positive", "not below zero", or any."""
    angle, length = (
        motion_kind(motion, derivative, positive=sign == "positive")
        for motion in ("angle", "length")
    )
    return Quantity((_above(angle, sign),), (_above(length, sign),))


def _above(kind: Kind, sign: str) -> Kind:
    if sign != "not below zero":
        return kind
    return Kind(name=f"{kind.name} {sign}", unit=kind.unit, example=kind.example, least=0.0)


_SHARE = Kind(name="a share between 0 and 100 %", unit="%", example="50 %", above=0.0, below=100.0)
_DAMPING = Kind(
    name="a damping from 0 to below 100 %", unit="%", example="2 %", least=0.0, below=100.0
)
_WIDTH = Kind(name="a positive damping", unit="%", example="50 %", above=0.0)
_DEPTH = Kind(name="a damping not below zero", unit="%", example="5 %", least=0.0)
_TIME = Kind(name="a duration not below zero", unit="s", example="1.5 ms", least=0.0)
_MASS = Kind(name="a positive mass for linear moves", unit="kg", example="5 kg", above=0.0)
_INERTIA = Kind(
    name="a positive moment of inertia for angular moves", unit="kg m^2", example="1 kg m^2",
    above=0.0,
)  # fmt: skip
_PER_TIME = Kind(name="a positive gain", unit="s^-1", example="20 s^-1", above=0.0)
_CURRENT = Kind(name="a positive current", unit="A", example="10 A", above=0.0)
_SPEED = Kind(name="a positive wind speed", unit="m/s", example="8 m/s", above=0.0)
_LENGTH = Kind(name="a positive length", unit="m", example="80 m", above=0.0)

MASS = Quantity((), (_MASS,))
INERTIAS = Quantity((_INERTIA,), (_MASS,), several=True)
SPRINGS, DAMPERS = (
    Quantity(each.angle, each.length, several=True)
    for each in (gain(0, "stiffness", "positive"), gain(1, "damping"))
)
POSITIONS, TORQUES = (
    Quantity(each.angle, each.length, several=True) for each in (moved(), torque())
)
FREQUENCIES = Quantity((FREQUENCY,), (FREQUENCY,), several=True)


def density_kind(of: str, motion: Motion) -> Kind:
    """Return the kind of a power spectral density, "torque" or "position"."""
    units = {"torque": ("N^2 m^2/Hz", "N^2/Hz"), "position": ("rad^2/Hz", "m^2/Hz")}
    nouns = {"torque": ("torque", "force"), "position": ("angle", "length")}
    unit, noun = units[of][motion == "length"], nouns[of][motion == "length"]
    return _kind(f"a positive density of {noun} squared", unit, "2", above=0.0)


TORQUE_DENSITIES, POSITION_DENSITIES = (
    Quantity((density_kind(of, "angle"),), (density_kind(of, "length"),), several=True)
    for of in ("torque", "position")
)
SHARE = _alike(_SHARE, scale=0.01)
DAMPING = _alike(_DAMPING, scale=0.01)
ZERO_DAMPING = _alike(_DEPTH, scale=0.01)
POLE_DAMPING = _alike(_WIDTH, scale=0.01)
HERTZ = _alike(FREQUENCY)
SECONDS = _alike(DURATION)
TIME = _alike(_TIME)
LEAD = _alike(_TIME, words=("auto",))
PERIOD = _alike(DURATION)
CURRENT = _alike(_CURRENT)
SPEED = _alike(_SPEED)
LENGTH = _alike(_LENGTH)
POSITION_GAIN = _alike(_PER_TIME)
RATE = Quantity(moved(1).angle, moved(1).length, words=("sidereal",))
TORQUE_CONSTANT = Quantity(
    (_kind("a positive torque per current", "N m/A", "0.5", above=0.0),),
    (_kind("a positive force per current", "N/A", "50", above=0.0),),
)
SIDEREAL = math.radians(15.04106717866910 / 3600.0)
"""The Earth's rotation, in rad/s: a turn in 86164.0989 s."""

_FIGURES = {
    "time": TIME,
    "position": moved(sign="not below zero"),
    "torque": torque("not below zero"),
    "frequency": HERTZ,
    "angle": _alike(_kind("an angle", "deg", "45")),
    "decibel": _alike(_kind("a ratio in dB", "dB", "12")),
    "percent": _alike(_kind("a percentage", "%", "20", least=0.0)),
    "compliance": Quantity(
        (_kind("an angle per torque", "rad/(N m)", "1e-6", least=0.0),),
        (_kind("a length per force", "m/N", "1e-6", least=0.0),),
    ),
}


def figure_kinds(unit: str) -> Quantity | None:
    """Return what bounds a figure of a survey; None where that is a number without unit."""
    return _FIGURES.get(unit)
