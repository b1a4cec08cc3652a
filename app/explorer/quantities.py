"""Quantities as an explorer shows and writes them: a number beside its unit, few digits."""

from __future__ import annotations

from typing import Any

from ..units import Motion, UnitError, parted, unit_of

DIGITS = 5
"""Of a number that a slider or a handle has set."""

_GAINS = {
    "angle": {"kp": "N m/rad", "ki": "N m/(rad s)", "kr": "N m s/rad"},
    "length": {"kp": "N/m", "ki": "N/(m s)", "kr": "N s/m"},
}


def gain_units(motion: Motion) -> dict[str, str]:
    """Return the units of a PID's gains in SI."""
    return _GAINS[motion]


def said(number: float, unit: str) -> str:
    """Return a quantity as a scenario file has it, to all digits."""
    return f"{float(number)!r} {unit}".replace(".0 ", " ", 1)


def number_and_unit(value: Any) -> tuple[float, str]:
    """Return number and unit of a quantity, or of a number; UnitError for what is neither.

    The unit is as it is written.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    unit_of(value)
    parts = parted(value)
    assert parts is not None  # as it has a unit
    return float(parts[0]), parts[1]


def is_quantity(value: Any) -> bool:
    """Whether a value of a scenario file is a number or has one with a unit."""
    try:
        number_and_unit(value)
    except UnitError:
        return False
    return True


def with_number(value: Any, number: float) -> Any:
    """Return a quantity, or a number, with another number, rounded to a few digits."""
    _, unit = number_and_unit(value)
    rounded = float(f"{number:.{DIGITS}g}")
    if unit:
        return said(rounded, unit)
    return round(rounded) if isinstance(value, int) else rounded


def scaled(value: Any, ratio: float) -> Any:
    """Return a quantity, or a number, times a ratio."""
    return with_number(value, number_and_unit(value)[0] * ratio)
