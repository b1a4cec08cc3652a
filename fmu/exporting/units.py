"""Unit names of variables, and what they are in SI base units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal

from ...units import BASE, Unit, unit

_POWER = re.compile(r"([A-Za-z]+)(-?[1-9][0-9]?)?")
_ANGLE, _LENGTH = {"rad": 1}, {"m": 1}


@dataclass(frozen=True)
class UnitDefinition:
    """A unit in SI base units: `factor` times the product of base units to their exponents."""

    name: str
    factor: float
    exponents: tuple[tuple[str, int], ...]


def unit_definition(name: str) -> UnitDefinition:
    """Return what a unit is in base units.

    Parameters
    ----------
    name : str
        Symbols with whole exponents, joined by "." (times) and "/" (by the next symbol alone),
        such as "N.m.s/rad" or "1/s2"; "1" is dimensionless.

    Raises
    ------
    ValueError
        For a symbol that is not known.

    Examples
    --------
    >>> unit_definition("N/mm").factor
    1000.0
    """
    size, exponents = Decimal(1), dict.fromkeys(BASE, 0)
    for sign, text in re.findall(r"(^|[./])([^./]*)", name):
        if text == "1" and sign != ".":
            continue
        found, power = _power(name, text)
        power *= -1 if sign == "/" else 1
        size *= found.size**power
        for symbol, exponent in found.powers.items():
            exponents[symbol] += power * exponent
    return UnitDefinition(name, float(size), tuple((k, n) for k, n in exponents.items() if n))


def _power(name: str, text: str) -> tuple[Unit, int]:
    found = _POWER.fullmatch(text)
    try:
        if not found or (read := unit(found[1])).zero:
            raise KeyError(text)
    except KeyError:
        raise ValueError(
            f"unit {name!r}: {text!r} is not known; expected symbols such as "
            "rad, deg, arcsec, m, mm, s, kg, N, A, V joined by '.' and '/'"
        ) from None
    return read, int(found[2] or 1)


def rate(position: str, order: int) -> str:
    """Return the unit of derivative `order` of a quantity: rad/s2."""
    return position if order == 0 else f"{position}/s{order if order > 1 else ''}"


def effort(position: str) -> str:
    """Return the unit of what moves a position: torque, force, or 1/s2 where it has no unit."""
    if position == "1":
        return "1/s2"
    return "N" if unit(position).powers == _LENGTH else "N.m"


def inertia(position: str) -> str:
    """Return the unit of the inertia between that effort and the acceleration."""
    named = {"1": "1", "rad": "kg.m2", "m": "kg"}
    return named.get(position) or f"{effort(position)}.s2/{position}"


def gain(position: str, time_power: int) -> str:
    """Return the unit of effort per position, times s to a power."""
    if position == "1":
        return rate("1", 2 - time_power)
    moving = effort(position)
    if time_power > 0:
        return f"{moving}.s/{position}"
    return f"{moving}/{position}" + ("/s" if time_power < 0 else "")


def feed(position: str, order: int) -> str:
    """Return the unit of effort per derivative `order` of the position."""
    if order == 2:
        return inertia(position)
    if order < 2:
        return gain(position, order)
    if position == "1":
        return f"s{order - 2 if order > 3 else ''}"
    return f"{effort(position)}.s{order}/{position}"


def integral(position: str, order: int) -> str:
    """Return the unit of the integral over time of position (order 1), or of velocity (0)."""
    if order == 0:
        return position
    return "s" if position == "1" else f"{position}.s"


def position_unit(name: str) -> str:
    """Return a unit of position, checked."""
    try:
        known = name == "1" or unit(name).powers in (_ANGLE, _LENGTH)
    except KeyError:
        known = False
    if not known:
        raise ValueError(
            f"unit = {name!r}: expected a unit of position: 1, an angle such as rad, deg or "
            "arcsec, or a length such as m, mm or um"
        )
    return name
