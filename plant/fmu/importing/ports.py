"""Inputs and outputs of an FMU as one array of numbers each, moved by preallocated calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....shaping.pieces import FloatArray
from .description import FmuError, FmuVariable, candidates
from .library import WARNING

WIDE = {"Int64": np.int64, "UInt64": np.uint64}
"""Types of variables whose values a double does not always hold."""

Mover = Callable[[str, Sequence[int], Any], Callable[[], int]]


class Port:
    """Variables of an FMU that are read, or written, together.

    Attributes
    ----------
    labels : tuple of str
        One per value: the variables' names in the order of the file, arrays spread out.
    values : (n,) array
        What `move` writes, or reads. Where all variables are doubles, FMI's own buffer; where
        some are integers of 64 bits, objects, which hold these as int.
    move : callable
        Moves all the values; returns FMI's status.
    """

    def __init__(
        self,
        variables: Sequence[FmuVariable],
        dtypes: Mapping[str, Any],
        mover: Mover,
        *,
        writes: bool,
    ) -> None:
        self.labels = tuple(label for variable in variables for label in variable.labels)
        wide = any(is_wide(dtypes[variable.type]) for variable in variables)
        self.values = np.zeros(len(self.labels), object if wide else float)
        self.shape = self.values.shape
        self._index = {label: i for i, label in enumerate(self.labels)}
        places = np.cumsum([0] + [variable.size for variable in variables])
        kinds = dict.fromkeys(variable.type for variable in variables if variable.size)
        groups: list[tuple[Any, Any, Callable[[], int]]] = []
        for kind in kinds:
            chosen = [i for i, variable in enumerate(variables) if variable.type == kind]
            index = np.concatenate([np.arange(places[i], places[i + 1]) for i in chosen])
            alone = len(kinds) == 1 and np.dtype(dtypes[kind]) == np.float64
            buffer = self.values if alone else np.zeros(index.size, dtypes[kind])
            references = [variables[i].value_reference for i in chosen]
            groups.append((index, buffer, mover(kind, references, buffer)))
        self._groups = groups
        self.move = self._move(writes)

    def _move(self, writes: bool) -> Callable[[], int]:
        if not self._groups:
            return lambda: 0
        if self._groups[0][1] is self.values:
            return self._groups[0][2]
        return self._write if writes else self._read

    def _write(self) -> int:
        status = 0
        for index, buffer, call in self._groups:
            self._fill(buffer, index)
            status = max(status, call())
            if status > WARNING:
                break
        return status

    def _fill(self, buffer: Any, index: Any) -> None:
        wanted = self.values[index]
        if buffer.dtype.kind != "f":
            for place, value in zip(index, wanted.tolist(), strict=True):
                _check_whole(self.labels[place], value, buffer.dtype)
        try:
            buffer[:] = wanted
        except OverflowError:
            raise FmuError(
                f"{', '.join(self.labels[i] for i in index)} = {wanted.tolist()}: expected numbers "
                "that a double can hold"
            ) from None

    def _read(self) -> int:
        status = 0
        for index, buffer, call in self._groups:
            status = max(status, call())
            if status > WARNING:
                break
            self.values[index] = buffer
        return status

    def take(self, given: Mapping[str, float] | ArrayLike) -> None:
        """Put what a caller gives into `values`: a mapping by name, or all of them in order."""
        if isinstance(given, Mapping):
            numbers = {self.position(n): self._number(n, v) for n, v in given.items()}
            for place, number in numbers.items():
                self.values[place] = number
            return
        array = self._gathered(given)
        if array.dtype.kind not in "biuf":
            flat = np.asarray(given, dtype=object).reshape(-1)
            names = self.labels if len(self.labels) == flat.size else ["inputs"] * flat.size
            found = [self._number(*pair) for pair in zip(names, flat, strict=True)]
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

    def position(self, name: str) -> int:
        """Return the place of a value; FmuError, naming the nearest ones, if none has it."""
        found = self._index.get(name)
        if found is None:
            raise FmuError(f"no input {name!r}{candidates(name, self.labels)}")
        return found

    def _gathered(self, given: Any) -> Any:
        """Return what is given as an array, its integers as they are."""
        if isinstance(given, np.ndarray) or self.values.dtype != object:
            return np.asarray(given)
        return np.asarray(given, dtype=object)

    def _number(self, name: str, value: Any) -> float:
        return exact_number(f"input {name!r}", value, self.values.dtype)


def is_wide(dtype: Any) -> bool:
    """Return whether a double does not hold every value of a type: integers of 64 bits."""
    return np.dtype(dtype) in (np.int64, np.uint64)


def exact_number(told: str, value: Any, dtype: Any) -> float:
    """Return a number for an array of doubles, or, an integer as it is, of objects."""
    if isinstance(value, str | bytes | None) or np.ndim(value):
        raise TypeError(f"{told} = {value!r}: expected a number")
    if np.dtype(dtype).hasobject and isinstance(value, int | np.integer):
        return int(value)
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{told} = {value!r}: expected a number") from None
    except OverflowError:
        raise FmuError(f"{told} = {value!r}: expected a number that a double can hold") from None


def shown(values: Any) -> FloatArray:
    """Return a copy, as doubles where these hold every integer of it, else as it is."""
    exact = values.dtype != object or all(
        type(value) is float or float(value) == value for value in values.tolist()
    )
    found: FloatArray = np.array(values, dtype=float if exact else object)
    return found


def _check_whole(name: str, value: float, dtype: Any) -> None:
    low, high = (0, 1) if dtype.kind == "b" else (np.iinfo(dtype).min, np.iinfo(dtype).max)
    if not (low <= value <= high and value == int(value)):
        raise FmuError(
            f"{name} = {value!r}: expected whole numbers within the range of {dtype.name}, {low} "
            f"to {high}"
        )
