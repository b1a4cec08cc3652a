"""Quantities written with their units: "0.2 deg/s^2", "60 arcsec", "1 kg m^2".

Angle is a base dimension beside length, mass and time. Frequencies therefore never pass for
angular velocities unconverted: 1 Hz is one turn per second, 2π rad/s, whichever is written.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from functools import lru_cache
from typing import Literal

from ..shaping.derivatives import derivative_name
from ..units import SPELLINGS
from .unit_products import Dimension, Product, UnknownUnitError, product_of

Motion = Literal["angle", "length"]

_OUT_OF_RANGE = "is outside the range of floating-point numbers"
_LONGEST_TEXT = 100
_SPELLINGS = str.maketrans(
    {"·": "*", "⋅": "*", "^": "**", "−": "-", "²": "**2", "³": "**3"} | SPELLINGS | {"°": "deg"}
)
_POWER = r"[A-Za-z]+(?:\*\*-?[1-9][0-9]?)?"
_FACTOR = rf"(?:{_POWER}|\({_POWER}(?:\*{_POWER})*\)(?:\*\*[1-9][0-9]?)?)"
# A product behind a solidus is refused: a/b c is read as a/(b c) by people, as (a/b) c by rule.
_UNIT = re.compile(rf"{_FACTOR}(?:\*{_FACTOR})*(?:/{_FACTOR})*")
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_PARTS = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.DOTALL)
_NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity)\b", re.IGNORECASE)


class UnitError(ValueError):
    """A text is not the quantity that was asked for; the message says what to write."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """What a quantity must be.

    Parameters
    ----------
    name : str
        What is accepted, with its article: ``"a positive angular jerk"``.
    unit : str
        The unit in which values are returned; any unit of its dimension is accepted.
    example : str
        A quantity that is accepted.
    above, below : float
        Open bounds, in `unit`.
    least : float
        Closed lower bound, in `unit`.
    """

    name: str
    unit: str
    example: str
    above: float = -math.inf
    below: float = math.inf
    least: float = -math.inf

    def admits(self, value: float) -> bool:
        """Whether `value`, in `unit`, lies between the bounds."""
        return self.above < value < self.below and value >= self.least


DURATION = Kind(name="a positive duration", unit="s", example="2 ms", above=0.0)
FREQUENCY = Kind(name="a positive frequency", unit="Hz", example="2 Hz", above=0.0)


def motion_kind(motion: Motion, derivative: int, *, positive: bool = False) -> Kind:
    """Return the kind of a position's derivative.

    Parameters
    ----------
    motion : {"angle", "length"}
        What the position is.
    derivative : int
        Order of the derivative: 0 for the position itself, 1 for the velocity, …
    positive : bool
        Whether zero and negative values are refused.

    Returns
    -------
    Kind
        Its unit is rad/s^k or m/s^k.
    """
    name = motion if derivative == 0 else derivative_name(derivative)
    noun = f"angular {name}" if motion == "angle" and derivative > 0 else name
    article = "a positive" if positive else "an" if noun[0] in "aeiou" else "a"
    shown, si = ("deg", "rad") if motion == "angle" else ("mm", "m")
    per = "" if derivative == 0 else "/s" if derivative == 1 else f"/s^{derivative}"
    return Kind(
        name=f"{article} {noun}",
        unit=si + per,
        example=f"5 {shown}{per}",
        above=0.0 if positive else -math.inf,
    )


def parse_quantity(text: object, kind: Kind) -> float:
    """Read a number and its unit.

    Parameters
    ----------
    text : object
        The text, such as ``"0.2 deg/s^2"``, ``"1.5e-3 rad"``, ``"10 %"`` or
        ``"3 N m/(rad s)"``. Units are joined by spaces, ``*`` or ``·`` and divided by ``/``;
        exponents are ``^2``, ``**2`` or ``²``.
    kind : Kind
        What is accepted.

    Returns
    -------
    float
        The finite value in ``kind.unit``.

    Raises
    ------
    UnitError
        If `text` is anything else; the message names it, what is accepted, and an example.
    """
    return parse_any(text, (kind,))[0]


def parse_motion(text: object, derivative: int, *, positive: bool = False) -> tuple[float, Motion]:
    """Read a position or one of its derivatives, angular or linear.

    Parameters
    ----------
    text : object
        The text, as for `parse_quantity`.
    derivative : int
        Order of the derivative: 0 for the position itself, 1 for the velocity, …
    positive : bool
        Whether zero and negative values are refused.

    Returns
    -------
    tuple of float and {"angle", "length"}
        The value in rad/s^k or m/s^k, and which of the two it is.

    Raises
    ------
    UnitError
        If `text` is neither.
    """
    angle, length = (motion_kind(m, derivative, positive=positive) for m in ("angle", "length"))
    value, kind = parse_any(text, (angle, length))
    return value, "angle" if kind is angle else "length"


def parse_any(text: object, kinds: Sequence[Kind]) -> tuple[float, Kind]:
    """Read a number and its unit, as the first of several kinds that has its dimension.

    Parameters
    ----------
    text : object
        The text, as for `parse_quantity`.
    kinds : sequence of Kind
        What is accepted.

    Returns
    -------
    tuple of float and Kind
        The finite value in the unit of that kind, and the kind.

    Raises
    ------
    UnitError
        If `text` is none of them.
    """
    value, place = (_parsed if isinstance(text, str) else _parse)(text, tuple(kinds))
    return value, kinds[place]


def _parse(text: object, kinds: tuple[Kind, ...]) -> tuple[float, int]:
    remedy = "write " + " or ".join(f"{kind.name} such as {kind.example!r}" for kind in kinds)
    try:
        number, unit = _split(text)
        scale, dimension = _root(unit)
        kind = _matching(dimension, kinds)
        value = _scaled(number, scale / _root(kind.unit)[0])
    except UnitError as error:
        raise UnitError(f"{show(text)} {error}; {remedy}") from error
    if not kind.admits(value):
        raise UnitError(f"{show(text)} is out of range; {remedy}")
    return value, next(k for k, each in enumerate(kinds) if each is kind)


_parsed = lru_cache(maxsize=4096)(_parse)  # a sweep reads the same file again and again


def factor(unit: str) -> float:
    """Return the SI value (m, kg, s, rad) of one `unit`: 4.848e-6 for "arcsec".

    Parameters
    ----------
    unit : str
        A unit, as behind the number in `parse_quantity`. A hertz is 2π rad/s.

    Raises
    ------
    UnitError
        If `unit` is not one.
    """
    try:
        return _scaled("1", _root(unit)[0])
    except UnitError as error:
        raise UnitError(f"{show(unit)} {error}; write a unit such as 'arcsec'") from error


def convert(value: float, unit: str) -> float:
    """Return a value given in SI units (m, kg, s, rad) in `unit`.

    Parameters
    ----------
    value : float
        The value in SI units.
    unit : str
        A unit, as for `factor`.

    Raises
    ------
    UnitError
        If `unit` is not one.
    """
    return value / factor(unit)


def conversion(unit: str, to: str) -> float:
    """Return how many of one unit are in another: 1000 for "arcsec" to "mas".

    Parameters
    ----------
    unit, to : str
        Units, as for `factor`.

    Raises
    ------
    UnitError
        If either is not one, or they differ in dimension.
    """
    try:
        scale, dimension = _root(unit)
        other, wanted = _root(to)
        if dimension != wanted:
            raise UnitError(f"has not the dimension of {show(to)}")
        return _scaled("1", scale / other)
    except UnitError as error:
        raise UnitError(f"{show(unit)} {error}; write a unit such as 'arcsec'") from None


def parse_unit(text: object, kinds: Sequence[Kind]) -> str:
    """Read a unit without a number, such as "arcsec".

    Parameters
    ----------
    text : object
        The unit.
    kinds : sequence of Kind
        What a number with this unit must be.

    Returns
    -------
    str
        The unit in ASCII, without surrounding space.

    Raises
    ------
    UnitError
        If `text` is not a unit of one of these kinds.
    """
    remedy = "write the unit of " + " or ".join(
        f"{kind.name} such as {kind.example.split(maxsplit=1)[1]!r}" for kind in kinds
    )
    try:
        if not isinstance(text, str):
            raise UnitError("is not a unit in quotation marks")
        _matching(_root(text)[1], kinds)
    except UnitError as error:
        raise UnitError(f"{show(text)} {error}; {remedy}") from error
    return _spelled(text)


def parted(text: str) -> tuple[str, str] | None:
    """Return the number that a text begins with, and the unit behind it as it is written.

    The unit is not looked at, and may be empty; None where the text begins with no number. A minus
    sign (U+2212) becomes a hyphen.
    """
    match = _PARTS.fullmatch(text.replace("−", "-"))
    return None if match is None else (match[1], match[2])


def unit_of(text: str) -> str:
    """Return the unit of a quantity that `parse_quantity` accepts, in ASCII."""
    return _split(text)[1]


def show(value: object) -> str:
    """Return a value on one line of bounded length, for messages."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    try:
        text = repr(value) if isinstance(value, str) else str(value)
    except ValueError:  # Python writes out no integer of thousands of digits
        return "a huge number"
    return text if len(text) <= 60 else f"{text[:56]} …{text[-1]}"


def _split(text: object) -> tuple[str, str]:
    if isinstance(text, int | float) and not isinstance(text, bool):
        finite = isinstance(text, int) or math.isfinite(text)
        raise UnitError("has no unit" if finite else "is not finite")
    if not isinstance(text, str):
        raise UnitError("is not a quantity in quotation marks")
    spelled = _spelled(text)
    if not spelled:
        raise UnitError("is empty")
    parts = parted(spelled)
    if len(spelled) > _LONGEST_TEXT or parts is None:
        not_finite = _NOT_FINITE.match(spelled) is not None
        raise UnitError("is not finite" if not_finite else "is not a number followed by a unit")
    if not parts[1]:
        raise UnitError("has no unit")
    return parts


def _spelled(text: str) -> str:
    return text.translate(_SPELLINGS).strip()


def _scaled(number: str, scale: Decimal) -> float:
    try:
        exact = Decimal(number) * scale
    except (DecimalException, OverflowError) as error:
        raise UnitError(_OUT_OF_RANGE) from error
    value = float(exact)
    if math.isinf(value) or (value == 0.0 and exact != 0):
        raise UnitError(_OUT_OF_RANGE)
    return value


def _matching(dimension: Dimension, kinds: Sequence[Kind]) -> Kind:
    for kind in kinds:
        if _root(kind.unit)[1] == dimension:
            return kind
    raise UnitError("has the wrong dimension")


@lru_cache(maxsize=1024)
def _root(unit: str) -> Product:
    """Return a unit's SI value and its dimension."""
    joined = re.sub(r"\s*(\*\*|[*/()])\s*", r"\1", _spelled(unit))
    product = re.sub(r"\s+|(?<=\w)(?=\()|(?<=\))(?=\w)", "*", joined)
    if len(product) > _LONGEST_TEXT or _UNIT.fullmatch(product) is None:
        misread = re.search(r"\w/\w.*\*", product)
        hint = " (a product in a denominator needs parentheses)" if misread else ""
        raise UnitError(f"has no readable unit{hint}")
    try:
        return product_of(product)
    except UnknownUnitError as error:
        raise UnitError(f"has the unknown unit {str(error)!r}") from None
    except (DecimalException, OverflowError) as error:
        raise UnitError(_OUT_OF_RANGE) from error
