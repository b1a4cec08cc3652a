"""What counts as real numbers, everywhere: one conversion, and one line for anything else."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import ROUND_DOWN, Context, Decimal
from numbers import Real
from reprlib import Repr
from typing import Any

import numpy as np

from .pieces import FloatArray

_DOUBLES = frozenset({float, np.float64})
_PLAIN = _DOUBLES | {int}


class _Short(Repr):
    """Values cut short, numbers without their last rounding errors and without a negative zero."""

    def repr_float(self, number: float, _: int) -> str:
        """Return a number with 15 digits at most."""
        return repr(float(f"{number:.15g}") + 0.0)

    repr_float64 = repr_float


_SHORT = _Short()
_SHORT.maxstring = _SHORT.maxother = 80
_DOWN = Context(prec=4, rounding=ROUND_DOWN)
_MEASURED = ("units", "unit")  # attributes of a quantity that means nothing without them


def real_number(name: str, value: Any) -> float:
    """Return one real number as a float.

    Parameters
    ----------
    name : str
        What a caller knows the value by.
    value : float
        Or int, fraction, decimal, number of numpy, or array without dimensions.

    Raises
    ------
    TypeError
        For anything else, named.
    ValueError
        For a whole number or fraction beyond the range of a double.
    """
    if type(value) in _DOUBLES:
        return float(value)
    try:
        array = _doubles(value)
    except (OverflowError, FloatingPointError):
        raise ValueError(f"{name} is beyond the range of a double") from None
    except TypeError as reason:
        raise TypeError(f"{name} = {shown(value)}: expected a number{reason}") from None
    if array.ndim:
        raise TypeError(f"{name} = {shown(value)}: expected a number, not {_kind(value)}")
    return float(array)


def real_array(name: str, values: Any) -> FloatArray:
    """Return real numbers as an array of doubles, not copied if they are one already.

    Numbers of every kind that `real_number` takes, arrays, Series, and lists of them, however
    deep, mean the same. Infinities and NaN pass: what becomes of them is the caller's business.

    Raises
    ------
    TypeError
        For what is not plainly real numbers: text, complex numbers, truth values, times and
        dates, masked values, quantities with units, tables whose columns have names, mappings
        and sets, rows of different lengths, numbers beyond the range of a double.
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    try:
        return _doubles(values)
    except (TypeError, OverflowError, FloatingPointError) as error:
        reason = error if type(error) is TypeError else ""
        raise TypeError(
            f"{name} = {shown(values)}: expected a number or an array of numbers, real and within "
            f"the range of a double{reason}"
        ) from None


def shown(value: Any) -> str:
    """Return a value on one line, cut short."""
    return " ".join(_SHORT.repr(value).split())


def rounded_down(value: float) -> str:
    """Return a number with four digits, none of them rounded up: what may be given as a bound."""
    return f"{float(_DOWN.create_decimal(repr(float(value)))):g}"


def _doubles(values: Any) -> FloatArray:
    """Return real numbers as an array; TypeError with what to add to a message for others."""
    _check(values)
    with np.errstate(over="raise"):  # of numbers longer than doubles
        try:
            return np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            raise TypeError(", in rows of one length") from None


def _check(value: Any) -> None:
    """Refuse what is not plainly real numbers: TypeError with what to add to a message."""
    if type(value) in _PLAIN:
        return
    if isinstance(value, Sequence) and not isinstance(value, str | bytes | bytearray | memoryview):
        _check_each(value)
    elif not _is_real(value):
        raise TypeError(f", not {_kind(value)}{_remedy(value)}")


def _check_each(values: Iterable[Any]) -> None:
    if not isinstance(values, range) and not _PLAIN.issuperset(map(type, values)):
        for value in values:
            _check(value)


def _is_real(value: Any) -> bool:
    """Tell whether one thing is a number or an array of numbers."""
    if _is_measured(value) or _is_table(value) or _is_masked(value) or _is_named(value):
        return False
    if isinstance(value, Real | Decimal) and not isinstance(value, np.generic):
        return not isinstance(value, bool)  # np.generic: a timedelta64 says that it is real
    if isinstance(value, bytes | bytearray | memoryview):
        return False
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, RuntimeError):  # what an array's own conversion refuses
        return False
    if array.dtype.kind == "O" and (array.ndim or array is value):
        _check_each(array.ravel().tolist())
        return True
    return array.dtype.kind in "iuf"


def _is_measured(value: Any) -> bool:
    return any(hasattr(type(value), attribute) for attribute in _MEASURED)


def _is_table(value: Any) -> bool:
    return hasattr(type(value), "columns")


def _is_masked(value: Any) -> bool:
    return isinstance(value, np.ndarray) and bool(np.any(getattr(value, "mask", False)))


def _is_named(value: Any) -> bool:
    """Tell whether numbers are but the names of categories."""
    return hasattr(getattr(value, "dtype", None), "categories")


def _kind(value: Any) -> str:
    dtype = "" if isinstance(value, np.generic) else getattr(value, "dtype", "")
    return type(value).__name__ + (f" of {dtype}" if dtype else "")


def _remedy(value: Any) -> str:
    if _is_table(value):
        return "; give the columns meant, in order, such as table[['x', 'v']].to_numpy()"
    if _is_masked(value):
        return "; leave out or fill what is masked"
    if hasattr(value, "m_as") or hasattr(value, "to_value"):
        method = "m_as" if hasattr(value, "m_as") else "to_value"
        return f"; give its magnitude in a unit of your choice, by {method}(unit)"
    if hasattr(value, "total_seconds"):
        return "; give it in a unit of your choice, such as its total_seconds()"
    if getattr(getattr(value, "dtype", None), "kind", "") == "m":
        return "; divide it by a unit of your choice, such as np.timedelta64(1, 's')"
    return ""
