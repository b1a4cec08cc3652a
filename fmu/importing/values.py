"""Values of one variable, in its own type and shape: as a caller gives them, to and from an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from math import isinf, isnan
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

import numpy as np

from ...shaping.real_numbers import real_number
from .description import FmuError, FmuVariable, candidates
from .instance import Instance

if TYPE_CHECKING:
    from .isolation import RemoteInstance

_DOUBLES = ("Real", "Float64", "Float32")
_TEXTS = {"String": str, "Binary": bytes}
_KINDS = "biufOU"  # kinds of numpy's types
_LONGEST = 80
_LARGEST_NARROW = float(np.finfo(np.float32).max)


def start_values(variable: FmuVariable) -> list[Any]:
    """Return the start values row by row; zeros, or what is empty, where none are given."""
    empty = {"String": "", "Binary": b""}.get(variable.type, 0)
    start = empty if variable.start is None else variable.start
    values = list(start) if isinstance(start, tuple) else [start]
    values = values * variable.size if len(values) == 1 else values
    if len(values) != variable.size:
        raise FmuError(
            f"{variable.name!r} has {len(values)} start values for {variable.size}: export the FMU "
            "again"
        )
    return values


def flat_values(variable: FmuVariable, value: Any) -> list[Any]:
    """Return the values that a caller gives to a variable, row by row, each as its type needs it.

    An array is given in its own shape, or all its values in one row.

    Raises
    ------
    TypeError
        For what is of another type.
    FmuError
        For another shape, and for a number that the type cannot have.
    """
    if variable.type in _TEXTS and not variable.shape:
        return [one_value(variable, value)]
    if np.ma.isMaskedArray(value) or getattr(value, "dtype", np.dtype(float)).kind not in _KINDS:
        raise _refusal(variable, value)
    given = np.array(value, dtype=object)
    if given.shape != variable.shape and (not variable.shape or given.shape != (variable.size,)):
        if not variable.shape:
            raise _refusal(variable, value)
        raise FmuError(
            f"{variable.name} of shape {given.shape}: expected {variable.shape}, or all its "
            f"{variable.size} values in one row"
        )
    return [one_value(variable, one) for one in given.reshape(-1)]


def one_value(variable: FmuVariable, value: Any) -> Any:
    """Return one value as the variable's type needs it; an enumeration also by its item's name."""
    kind = _TEXTS.get(variable.type)
    if kind is str and isinstance(value, str) and "\0" not in value:
        return value
    if kind is bytes and isinstance(value, bytes | bytearray | memoryview):
        return bytes(value)
    if variable.type == "Enumeration" and isinstance(value, str):
        return item_value(variable, value)
    if kind is not None or not is_number(value):
        raise _refusal(variable, value)
    return _double(variable, value) if variable.type in _DOUBLES else _whole(variable, value)


def is_number(value: Any) -> bool:
    """Return whether something is a real number or a truth value; a timedelta is none."""
    return isinstance(value, Real | np.bool_) and not isinstance(value, np.timedelta64)


def item_value(variable: FmuVariable, name: str) -> int:
    """Return the value of an enumeration's item; FmuError, naming the nearest, if it has none."""
    items = dict(variable.items)
    if name not in items:
        raise FmuError(f"{variable.name} has no item {name!r}{candidates(name, items)}")
    return items[name]


def check_whole(name: str, value: float, dtype: Any) -> None:
    """Refuse a number that an integer type cannot have, or a truth value."""
    low, high = (0, 1) if dtype.kind == "b" else (np.iinfo(dtype).min, np.iinfo(dtype).max)
    if not (low <= value <= high and value == int(value)):
        raise FmuError(
            f"{name} = {value!r}: expected whole numbers within the range of {dtype.name}, {low} "
            f"to {high}"
        )


def check_narrow(name: str, value: float) -> None:
    """Refuse a finite number that Float32 would make infinite."""
    if not isinf(value) and abs(value) > _LARGEST_NARROW:
        raise FmuError(f"{name} = {value!r}: expected a number of type Float32")


def own_shape(variable: FmuVariable, values: list[Any], dtypes: Mapping[str, Any]) -> object:
    """Return values as a caller gets them: a plain value, or an array of the variable's shape."""
    if variable.type == "Boolean":
        values = [bool(value) for value in values]
    if not variable.shape:
        return values[0]
    kind = {"Boolean": bool}.get(variable.type, dtypes.get(variable.type, object))
    found = np.empty(variable.size, kind)
    found[:] = values
    return found.reshape(variable.shape)


def read(
    instance: Instance | RemoteInstance, variable: FmuVariable, dtypes: Mapping[str, Any]
) -> tuple[int, list[Any]]:
    """Return FMI's status and the variable's values, row by row."""
    if not variable.size:
        return 0, []
    reference = variable.value_reference
    if variable.type == "String":
        return instance.get_text(reference, variable.size)
    if variable.type == "Binary":
        return instance.get_binary(reference, variable.size)
    values = np.zeros(variable.size, dtypes[variable.type])
    status = instance.getter(variable.type, [reference], values)()
    return status, values.tolist()


def write(
    instance: Instance | RemoteInstance,
    variable: FmuVariable,
    values: list[Any],
    dtypes: Mapping[str, Any],
) -> int:
    """Set a variable to `flat_values`, and return FMI's status."""
    if not variable.size:
        return 0
    reference = variable.value_reference
    if variable.type == "String":
        return instance.set_text(reference, values)
    if variable.type == "Binary":
        return instance.set_binary(reference, values)
    dtype = np.dtype(dtypes[variable.type])
    if dtype.kind in "iu":
        for value in values:
            check_whole(variable.name, value, dtype)
    return instance.setter(variable.type, [reference], np.array(values, dtype))()


def _refusal(variable: FmuVariable, value: Any) -> TypeError:
    told = " ".join(repr(value).split())
    told = told if len(told) <= _LONGEST else f"{told[:_LONGEST]} …"
    return TypeError(f"{variable.name} = {told}: expected {_wanted(variable)}")


def _double(variable: FmuVariable, value: Any) -> float:
    truth = isinstance(value, bool | np.bool_)
    number = float(value) if truth else real_number(variable.name, value)
    if variable.type == "Float32":
        check_narrow(variable.name, number)
    if isnan(number):
        raise FmuError(f"{variable.name} = {value!r}: expected a number of type {variable.type}")
    return number


def _whole(variable: FmuVariable, value: Any) -> int:
    if isinstance(value, Integral | np.bool_) and not isinstance(value, np.timedelta64):
        number = int(value)
    elif real_number(variable.name, value).is_integer():
        number = int(real_number(variable.name, value))
    else:
        raise FmuError(f"{variable.name} = {value!r}: expected {_wanted(variable)}")
    allowed = {0, 1} if variable.type == "Boolean" else {value for _, value in variable.items}
    if allowed and number not in allowed:
        raise FmuError(f"{variable.name} = {value!r}: expected {_wanted(variable)}")
    return number


def _wanted(variable: FmuVariable) -> str:
    if variable.type == "Enumeration" and variable.items:
        return "one of " + ", ".join(f"{name!r} ({value})" for name, value in variable.items)
    words = {"Boolean": "true or false", "String": "a string", "Binary": "bytes"}
    number = "a number" if variable.type in _DOUBLES else "a whole number"
    one = words.get(variable.type, number)
    return f"an array of shape {variable.shape}, each {one}" if variable.shape else one
