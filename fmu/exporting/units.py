"""Unit names of variables, and what they are in SI base units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi

_FACTOR = re.compile(r"([A-Za-z]+)(-?[1-9][0-9]*)?")
_ANGLES = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": pi / 180.0,
    "arcmin": pi / 10800.0,
    "arcsec": pi / 648000.0,
    "mas": pi / 648000e3,
    "rev": 2.0 * pi,
}
_LENGTHS = {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
_OTHERS: dict[str, tuple[float, dict[str, int]]] = {
    "kg": (1.0, {"kg": 1}),
    "g": (1e-3, {"kg": 1}),
    "A": (1.0, {"A": 1}),
    "mA": (1e-3, {"A": 1}),
    "K": (1.0, {"K": 1}),
    "Hz": (1.0, {"s": -1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "kN": (1e3, {"kg": 1, "m": 1, "s": -2}),
    "mN": (1e-3, {"kg": 1, "m": 1, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "kPa": (1e3, {"kg": 1, "m": -1, "s": -2}),
    "MPa": (1e6, {"kg": 1, "m": -1, "s": -2}),
    "bar": (1e5, {"kg": 1, "m": -1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "kJ": (1e3, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "kW": (1e3, {"kg": 1, "m": 2, "s": -3}),
    "MW": (1e6, {"kg": 1, "m": 2, "s": -3}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "mV": (1e-3, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "kV": (1e3, {"kg": 1, "m": 2, "s": -3, "A": -1}),
}
_SYMBOLS = (
    {name: (factor, {"rad": 1}) for name, factor in _ANGLES.items()}
    | {name: (factor, {"m": 1}) for name, factor in _LENGTHS.items()}
    | {name: (factor, {"s": 1}) for name, factor in _TIMES.items()}
    | _OTHERS
)


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
    factor, exponents = 1.0, dict.fromkeys(("kg", "m", "s", "A", "K", "rad"), 0)
    for sign, text in re.findall(r"(^|[./])([^./]*)", name):
        if text == "1" and sign != ".":
            continue
        found = _FACTOR.fullmatch(text)
        if not found or found[1] not in _SYMBOLS:
            raise ValueError(
                f"unit {name!r}: {text!r} is not known; expected symbols such as "
                f"{', '.join(list(_SYMBOLS)[:4])}, m, mm, s, kg, N, A, V joined by '.' and '/'"
            )
        power = int(found[2] or 1) * (-1 if sign == "/" else 1)
        size, base = _SYMBOLS[found[1]]
        factor *= size**power
        for symbol, exponent in base.items():
            exponents[symbol] += power * exponent
    return UnitDefinition(name, factor, tuple((k, n) for k, n in exponents.items() if n))


def rate(unit: str, order: int) -> str:
    """Return the unit of derivative `order` of a quantity: rad/s2."""
    return unit if order == 0 else f"{unit}/s{order if order > 1 else ''}"


def effort(position: str) -> str:
    """Return the unit of what moves a position: torque, force, or 1/s2 where it has no unit."""
    if position == "1":
        return "1/s2"
    return "N" if position in _LENGTHS else "N.m"


def inertia(position: str) -> str:
    """Return the unit of the inertia between that effort and the acceleration."""
    named = {"1": "1", "rad": "kg.m2", "m": "kg"}
    return named.get(position) or f"{effort(position)}.s2/{position}"


def gain(position: str, time_power: int) -> str:
    """Return the unit of effort per position, times s to a power."""
    if position == "1":
        return rate("1", 2 - time_power)
    unit = effort(position)
    if time_power > 0:
        return f"{unit}.s/{position}"
    return f"{unit}/{position}" + ("/s" if time_power < 0 else "")


def position_unit(unit: str) -> str:
    """Return a unit of position, checked."""
    if unit not in ("1", *_ANGLES, *_LENGTHS):
        raise ValueError(
            f"unit = {unit!r}: expected a unit of position, one of "
            f"1, {', '.join((*_ANGLES, *_LENGTHS))}"
        )
    return unit
