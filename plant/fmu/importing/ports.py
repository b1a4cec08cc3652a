"""Inputs and outputs of an FMU as one array of doubles each, moved by preallocated calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....shaping.real_numbers import real_array, real_number
from .description import FmuError, FmuVariable, candidates
from .library import WARNING

Mover = Callable[[str, Sequence[int], Any], Callable[[], int]]


class Port:
    """Variables of an FMU that are read, or written, together.

    Attributes
    ----------
    labels : tuple of str
        One per value: the variables' names in the order of the file, arrays spread out.
    values : (n,) array
        What `move` writes, or reads. Where all variables are doubles, FMI's own buffer.
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
        self.values = np.zeros(len(self.labels))
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
            wanted = self.values[index]
            with np.errstate(invalid="ignore"):
                buffer[:] = wanted
            if buffer.dtype.kind != "f" and (buffer != wanted).any():
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
        for index, buffer, call in self._groups:
            status = max(status, call())
            if status > WARNING:
                break
            self.values[index] = buffer
        return status

    def take(self, given: Mapping[str, float] | ArrayLike) -> None:
        """Put what a caller gives into `values`: a mapping by name, or all of them in order."""
        if isinstance(given, Mapping):
            found = {self.position(name): _number(name, value) for name, value in given.items()}
            for place, value in found.items():
                self.values[place] = value
            return
        if isinstance(given, list | tuple) and len(given) == len(self.labels):
            array = np.array([_number(*pair) for pair in zip(self.labels, given, strict=True)])
        elif isinstance(given, np.ndarray | np.bool_) and given.dtype == bool:
            array = given.astype(float)
        else:
            array = real_array("inputs", given)
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


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool | np.bool_):
        return float(value)
    return real_number(f"input {name!r}", value)
