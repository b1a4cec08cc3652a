"""Products of units, such as N*m/(rad*s): their SI value and their dimension."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from decimal import Decimal
from functools import cache
from typing import NamedTuple

from ..units import PREFIXES, UNITS

Dimension = frozenset[tuple[str, int]]
"""Base units and their exponents, those of 0 left out."""

_LEVEL = {"dB": (Decimal(1), {"level": 1}), "decibel": (Decimal(1), {"level": 1})}
_SIZES = {"": Decimal(1)} | {
    name: size for symbol, (word, size) in PREFIXES.items() for name in (word, symbol)
}


class Product(NamedTuple):
    """A product of units: its value in base units, as a decimal, and its dimension."""

    size: Decimal
    dimension: Dimension


class UnknownUnitError(ValueError):
    """No unit has that name."""


def product_of(text: str) -> Product:
    """Return what a product is.

    Decimals keep 1 kHz at exactly 1000 Hz: every value is rounded once, by the caller.

    Parameters
    ----------
    text : str
        Names with whole exponents behind `**`, joined by `*` and `/`, in parentheses or not.

    Raises
    ------
    UnknownUnitError
        With the name that no unit has.
    DecimalException
        For a value out of the range of decimals.
    """
    size, powers = Decimal(1), Counter[str]()
    for name, exponent in _powers(text.replace("**", "^")):
        one, of_one = _unit_of(name)
        size *= one**exponent
        for base, n in of_one.items():
            powers[base] += n * exponent
    return Product(size, frozenset((base, n) for base, n in powers.items() if n))


def _powers(text: str) -> Iterator[tuple[str, int]]:
    """Yield names and exponents, those behind a solidus negative."""
    for sign, factor, outer in re.findall(r"([*/]?)(\([^)]*\)|[^*/()^]+)(?:\^(-?\d+))?", text):
        for power in factor.strip("()").split("*"):
            name, _, exponent = power.partition("^")
            yield name, int(exponent or 1) * int(outer or 1) * (-1 if sign == "/" else 1)


def _unit_of(name: str) -> tuple[Decimal, dict[str, int]]:
    """Return the unit of a name: as it is, with a prefix, or as a plural."""
    known = _units()
    if name in known:
        return known[name]
    for ending in ("", "s"):
        stem = name.removesuffix(ending)
        for prefix, size in _SIZES.items():
            rest = stem.removeprefix(prefix)
            plain = stem.startswith(prefix) and name.endswith(ending)
            if plain and rest in known and not (ending and len(rest) == 1):
                return size * known[rest][0], known[rest][1]
    raise UnknownUnitError(name)


@cache
def _units() -> dict[str, tuple[Decimal, dict[str, int]]]:
    """Return size and exponents by symbol and by word; a hertz is one turn per second."""
    found = dict(_LEVEL)
    for symbol, unit in UNITS.items():
        if not unit.zero:
            turn = symbol == "Hz"
            size = unit.size * (UNITS["rev"].size if turn else 1)
            powers = unit.powers | ({"rad": 1} if turn else {})
            found |= dict.fromkeys((symbol, *unit.words), (size, powers))
    return found
