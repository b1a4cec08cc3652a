"""Inputs and outputs of an FMU as one array of numbers each, moved by preallocated calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...shaping.pieces import FloatArray
from ...shaping.real_numbers import real_array, real_number
from .description import FmuError, Signal, candidates
from .log import WARNING
from .values import check_narrow, check_whole, flat_values, item_value, one_value

WIDE = {"Int64": np.int64, "UInt64": np.uint64}
"""Types of variables whose values a double does not always hold."""

_DOUBLE_BYTES = 8

Mover = Callable[[str, Sequence[int], Any], Callable[[], int]]


class Port:
    """Signals of an FMU that are read, or written, together; written ones are whole variables.

    Attributes
    ----------
    labels : tuple of str
        One per value.
    values : (n,) array
        What `move` writes, or reads. Where all variables are doubles, FMI's own buffer; where
        some are integers of 64 bits, objects, which hold these as int.
    move : callable
        Moves all the values; returns FMI's status.
    """

    def __init__(
        self,
        signals: Sequence[Signal],
        dtypes: Mapping[str, Any],
        mover: Mover,
        *,
        writes: bool,
    ) -> None:
        self.labels = tuple(signal.label for signal in signals)
        wide = any(is_wide(dtypes[signal.variable.type]) for signal in signals)
        self.values = np.zeros(len(self.labels), object if wide else float)
        self.shape = self.values.shape
        self._variables = [signal.variable for signal in signals]
        self._places = _places_by_name(signals) if writes else {}
        groups: list[tuple[Any, Any, Any, Callable[[], int]]] = []
        for kind in dict.fromkeys(variable.type for variable in self._variables):
            index = np.array([i for i, v in enumerate(self._variables) if v.type == kind])
            references, taken, size = _layout([signals[i] for i in index])
            alone = len(index) == len(signals) == size and np.dtype(dtypes[kind]) == np.float64
            alone = alone and bool((taken == index).all())
            buffer = self.values if alone else np.zeros(size, dtypes[kind])
            groups.append((index, taken, buffer, mover(kind, references, buffer)))
        self._groups = groups
        self.move = self._move(writes)

    def _move(self, writes: bool) -> Callable[[], int]:
        if not self._groups:
            return lambda: 0
        if self._groups[0][2] is self.values:
            return self._groups[0][3]
        return self._write if writes else self._read

    def _write(self) -> int:
        status = 0
        for index, taken, buffer, call in self._groups:
            self._fill(buffer, taken, index)
            status = max(status, call())
            if status > WARNING:
                break
        return status

    def _fill(self, buffer: Any, taken: Any, index: Any) -> None:
        wanted = self.values[index]
        if buffer.dtype.kind != "f":
            for place, value in zip(index, wanted.tolist(), strict=True):
                check_whole(self.labels[place], value, buffer.dtype)
        elif buffer.dtype.itemsize < _DOUBLE_BYTES:
            for place, value in zip(index, wanted.tolist(), strict=True):
                check_narrow(self.labels[place], value)
        try:
            buffer[taken] = wanted
        except OverflowError:
            raise FmuError(
                f"{', '.join(self.labels[i] for i in index)} = {wanted.tolist()}: expected numbers "
                "that a double can hold"
            ) from None

    def _read(self) -> int:
        status = 0
        for index, taken, buffer, call in self._groups:
            status = max(status, call())
            if status > WARNING:
                break
            self.values[index] = buffer[taken]
        return status

    def take(self, given: Mapping[str, float] | ArrayLike) -> None:
        """Put what a caller gives into `values`: a mapping by name, or all of them in order.

        A name is a label, that of an array, whose values are given in its shape, or an alias.
        """
        if isinstance(given, Mapping):
            named = [(self.places(name), self._numbers(name, one)) for name, one in given.items()]
            for places, numbers in named:
                self.values[places] = numbers
            return
        array = self._gathered(given)
        if array.dtype.kind not in "biuf":
            found = [self._number(i, one) for i, one in enumerate(array.reshape(-1))]
            array = np.array(found, self.values.dtype).reshape(array.shape)
        if array.ndim == 0 and self.shape == (1,):
            array = array[None]
        if array.shape != self.shape:
            raise FmuError(
                f"{array.size} values for {len(self.labels)} inputs "
                f"({', '.join(self.labels[:12]) or 'none'}): give one each, in this order, or a "
                "mapping by name"
            )
        self.values[:] = array

    def places(self, name: str) -> list[int]:
        """Return where a name's values stand; FmuError, naming the nearest ones, if none has it."""
        found = self._places.get(name)
        if found is None:
            raise FmuError(f"no input {name!r}{candidates(name, self.labels)}")
        return found

    def _numbers(self, name: str, value: Any) -> list[float]:
        variable = self._variables[self.places(name)[0]]
        if variable.shape and name in (variable.name, *variable.aliases):
            return flat_values(variable, value)
        if variable.items:
            return [one_value(variable, value)]
        return [self._number(self.places(name)[0], value, name)]

    def _gathered(self, given: Any) -> Any:
        """Return what is given as an array, names of items and integers as they are."""
        if np.ma.isMaskedArray(given):
            raise TypeError("inputs with a mask: expected numbers; fill the array first")
        if not isinstance(given, list | tuple | np.ndarray | np.generic):
            given = real_array("inputs", given)
        array = np.asarray(given)
        plain = array.dtype.kind in "biuf" and self.values.dtype != object
        return array if plain or isinstance(given, np.ndarray) else np.asarray(given, dtype=object)

    def _number(self, place: int, value: Any, name: str = "") -> float:
        """Return one number for a place; where it lies beyond them all, whatever it is."""
        known = place < len(self.labels)
        if known and self._variables[place].type == "Enumeration" and isinstance(value, str):
            return item_value(self._variables[place], value)
        label = name or (self.labels[place] if known else "inputs")
        return exact_number(f"input {label!r}", value, self.values.dtype)


def _places_by_name(signals: Sequence[Signal]) -> dict[str, list[int]]:
    """Return where the values stand of each label, array and alias of whole variables."""
    found: dict[str, list[int]] = {}
    for i, (label, variable, _) in enumerate(signals):
        element = label.removeprefix(variable.name)
        for name in (variable.name, *variable.aliases):
            found.setdefault(name, []).append(i)
            if element:
                found[name + element] = [i]
    return found


def _layout(signals: Sequence[Signal]) -> tuple[list[int], Any, int]:
    """Return the variables' references, each signal's place among all their values, how many."""
    begins: dict[int, int] = {}
    size = 0
    for _, variable, _ in signals:
        if variable.value_reference not in begins:
            begins[variable.value_reference] = size
            size += variable.size
    taken = [begins[variable.value_reference] + place for _, variable, place in signals]
    return list(begins), np.array(taken), size


def is_wide(dtype: Any) -> bool:
    """Return whether a double does not hold every value of a type: integers of 64 bits."""
    return np.dtype(dtype) in (np.int64, np.uint64)


def exact_number(told: str, value: Any, dtype: Any) -> float:
    """Return a number for an array of doubles, or, an integer as it is, of objects."""
    if isinstance(value, bool | np.bool_):
        return float(value)
    if np.dtype(dtype).hasobject and isinstance(value, int | np.integer):
        return int(value)
    try:
        return real_number(told, value)
    except ValueError:
        raise FmuError(f"{told} = {value!r}: expected a number that a double can hold") from None


def shown(values: Any) -> FloatArray:
    """Return a copy, as doubles where these hold every integer of it, else as it is."""
    exact = values.dtype != object or all(
        type(value) is float or float(value) == value for value in values.tolist()
    )
    found: FloatArray = np.array(values, dtype=float if exact else object)
    return found
