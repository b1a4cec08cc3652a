"""The units that scenario files, FMUs and SSPs know: one table, in kg, m, s, A, K and rad."""

from dataclasses import dataclass, field
from decimal import Decimal

BASE = ("kg", "m", "s", "A", "K", "rad")
"""What every unit is made of; the angle is a dimension of its own."""

PREFIXES = {
    "M": ("mega", Decimal("1e6")),
    "k": ("kilo", Decimal("1e3")),
    "c": ("centi", Decimal("1e-2")),
    "m": ("milli", Decimal("1e-3")),
    "u": ("micro", Decimal("1e-6")),
    "n": ("nano", Decimal("1e-9")),
}
"""Symbols before a unit's symbol: their words, and what they multiply by."""


@dataclass(frozen=True)
class Unit:
    """One unit: value in base units = size·value + zero.

    Parameters
    ----------
    size : Decimal
        How many products of base units it is.
    powers : dict of str to int
        Exponents of the base units, those of 0 left out.
    words : tuple of str
        Names besides its symbol.
    zero : Decimal
        Where its own zero lies, in base units: 273.15 for degC.
    prefixed : bool
        Whether "k", "m", … may stand before its symbol.
    """

    size: Decimal
    powers: dict[str, int] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    zero: Decimal = Decimal(0)
    prefixed: bool = True


def _unit(words: str, size: Decimal | str, **powers: int) -> Unit:
    return Unit(Decimal(size), powers, tuple(words.split()))


def _alone(words: str, size: Decimal | str, zero: Decimal | str = "0", **powers: int) -> Unit:
    return Unit(Decimal(size), powers, tuple(words.split()), Decimal(zero), prefixed=False)


_TURN = 2 * Decimal("3.14159265358979323846264338327950288")
_RANKINE = Decimal(5) / 9

UNITS = {
    "rad": _unit("radian", "1", rad=1),
    "rev": _alone("turn revolution", _TURN, rad=1),
    "deg": _unit("degree", _TURN / 360, rad=1),
    "arcmin": _unit("arcminute", _TURN / 21600, rad=1),
    "arcsec": _unit("arcsecond", _TURN / 1296000, rad=1),
    "mas": _alone("", _TURN / 1296000000, rad=1),
    "m": _unit("meter metre", "1", m=1),
    "in": _alone("inch", "0.0254", m=1),
    "ft": _alone("foot", "0.3048", m=1),
    "mil": _alone("thou", "0.0000254", m=1),
    "kg": _alone("kilogram", "1", kg=1),
    "g": _unit("gram", "1e-3", kg=1),
    "t": _alone("tonne", "1e3", kg=1),
    "lb": _alone("pound", "0.45359237", kg=1),
    "s": _unit("second", "1", s=1),
    "min": _alone("minute", "60", s=1),
    "h": _alone("hour", "3600", s=1),
    "Hz": _unit("hertz", "1", s=-1),
    "rpm": _alone("", _TURN / 60, rad=1, s=-1),
    "N": _unit("newton", "1", kg=1, m=1, s=-2),
    "lbf": _alone("", "4.4482216152605", kg=1, m=1, s=-2),
    "Pa": _unit("pascal", "1", kg=1, m=-1, s=-2),
    "bar": _unit("", "1e5", kg=1, m=-1, s=-2),
    "J": _unit("joule", "1", kg=1, m=2, s=-2),
    "W": _unit("watt", "1", kg=1, m=2, s=-3),
    "A": _unit("ampere", "1", A=1),
    "V": _unit("volt", "1", kg=1, m=2, s=-3, A=-1),
    "K": _unit("kelvin", "1", K=1),
    "degC": _alone("°C Cel", "1", "273.15", K=1),
    "degF": _alone("°F", _RANKINE, Decimal("459.67") * _RANKINE, K=1),
    "percent": _alone("", "0.01"),
}
"""By symbol. A hertz is one per second; where angles count cycles, one turn per second."""

SPELLINGS = {"µ": "u", "μ": "u", "%": "percent", "′": "arcmin", "″": "arcsec"}
"""Signs that mean a symbol or a prefix."""


def unit(symbol: str) -> Unit:
    """Return the unit of a symbol, with a prefix or without.

    Raises
    ------
    KeyError
        If there is none.

    Examples
    --------
    >>> unit("kN").size, unit("kN").powers
    (Decimal('1E+3'), {'kg': 1, 'm': 1, 's': -2})
    """
    if symbol in UNITS:
        return UNITS[symbol]
    rest = UNITS[symbol[1:]]
    if not rest.prefixed:
        raise KeyError(symbol)
    return Unit(PREFIXES[symbol[:1]][1] * rest.size, rest.powers)
