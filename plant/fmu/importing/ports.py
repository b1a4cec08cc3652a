"""Inputs and outputs of an FMU as one array of doubles each, moved by preallocated calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .description import FmuError, FmuVariable, Signal, candidates
from .library import WARNING
from .values import flat_values, item_value

Mover = Callable[[str, Sequence[int], Any], Callable[[], int]]


class Port:
    """Signals of an FMU that are read, or written, together; written ones are whole variables.

    Attributes
    ----------
    labels : tuple of str
        One per value.
    values : (n,) array
        What `move` writes, or reads. Where all variables are doubles, FMI's own buffer.
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
        self.values = np.zeros(len(self.labels))
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
            wanted = self.values[index]
            with np.errstate(invalid="ignore"):
                buffer[taken] = wanted
            if buffer.dtype.kind != "f" and (buffer[taken] != wanted).any():
                names = ", ".join(self.labels[i] for i in index)
                raise FmuError(
                    f"{names} = {wanted.tolist()}: expected whole numbers within the range of "
                    f"{buffer.dtype.name}"
                )
            status = max(status, call())
            if status > WARNING:
                break
        return status

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
            found = [(self.places(name), self._numbers(name, one)) for name, one in given.items()]
            for places, numbers in found:
                self.values[places] = numbers
            return
        array = np.asarray(given)
        if array.dtype.kind not in "biuf":
            flat = np.asarray(given, dtype=object).reshape(-1)
            if flat.shape == self.shape:
                pairs = zip(self._variables, self.labels, flat, strict=True)
                array = np.array([_number(*pair) for pair in pairs])
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
            return [float(one) for one in flat_values(variable, value)]
        return [_number(variable, name, value)]


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


def _number(variable: FmuVariable, name: str, value: Any) -> float:
    if variable.type == "Enumeration" and isinstance(value, str):
        return float(item_value(variable, value))
    if isinstance(value, str | bytes | None) or np.ndim(value):
        raise TypeError(f"input {name!r} = {value!r}: expected a number")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"input {name!r} = {value!r}: expected a number") from None
