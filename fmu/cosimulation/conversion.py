"""Numbers from one unit to another: by the base units that an FMU declares, else by its name."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite

from ...units import SPELLINGS, UNITS
from ..exporting.units import unit_definition
from ..importing.description import FmuUnit

NO_UNIT = ("", "1", "-")
"""Names with which files say that there is no unit."""

_SPELLINGS = str.maketrans({"*": ".", "·": ".", "⋅": ".", " ": ".", "^": None} | SPELLINGS)
_NAMES = {"r/min": "rpm", "°": "deg"}
_OFFSETS = {
    name: FmuUnit(name, tuple(unit.powers.items()), float(unit.size), float(unit.zero))
    for symbol, unit in UNITS.items()
    for name in (symbol, *unit.words)
    if unit.zero
}


def unit_of(name: str, declared: Iterable[FmuUnit] = ()) -> FmuUnit:
    """Return a unit: as declared, as its name says where that is silent, or of unknown base.

    Parameters
    ----------
    name : str
        Empty, "1" or "-" for no unit.
    declared : iterable of FmuUnit, optional
        Definitions of the file that uses the name.

    Examples
    --------
    >>> unit_of("N/mm").factor, unit_of("widgets").base
    (1000.0, ())
    """
    for unit in declared:
        if unit.name == name and _known(unit):
            return unit
    if name in _OFFSETS:
        return _OFFSETS[name]
    try:
        found = unit_definition(_NAMES.get(name, name.translate(_SPELLINGS)))
    except ValueError:
        return FmuUnit(name)
    return FmuUnit(name, found.exponents, found.factor)


def conversion(given: FmuUnit, taken: FmuUnit) -> tuple[float, float] | None:
    """Return gain and offset from numbers in one unit to numbers in another, None if there is none.

    With value in base units = factor·value + offset, it is

        taken = (factor_given/factor_taken)·given + (offset_given − offset_taken)/factor_taken.

    Nothing is converted where one of the two has no unit, or both the same name.

    Examples
    --------
    >>> conversion(unit_of("mm"), unit_of("m"))
    (0.001, 0.0)
    >>> conversion(unit_of("mm"), unit_of("kg")) is None
    True
    """
    if given.name == taken.name or not {given.name, taken.name}.isdisjoint(NO_UNIT):
        return 1.0, 0.0
    if not (_known(given) and _known(taken) and dict(given.base) == dict(taken.base)):
        return None
    gain = given.factor / taken.factor
    offset = (given.offset - taken.offset) / taken.factor
    return (gain, offset) if isfinite(gain) and isfinite(offset) and gain else None


def _known(unit: FmuUnit) -> bool:
    """Whether it says what the unit is made of; a part of 1, such as %, has a factor alone."""
    return unit.factor != 0.0 and (bool(unit.base) or unit.factor != 1.0)
