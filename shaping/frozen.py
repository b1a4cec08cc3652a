"""Nouns that are read-only, and stay so when they are copied or sent to another process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from types import MappingProxyType
from typing import Any

import numpy as np


class Frozen:
    """A frozen dataclass whose arrays and mappings are read-only, as are those of its copies.

    Copies and pickles have its fields alone: what it has worked out and kept is worked out again.
    A class with a `__post_init__` of its own calls this one at the end.
    """

    def __post_init__(self) -> None:
        """Look at arrays and mappings of the fields through read-only views, without a copy."""
        self.__setstate__({name: vars(self)[name] for name in _names(self)})

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, mappings as plain ones, which can be pickled."""
        return {name: _plain(getattr(self, name)) for name in _names(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over fields, all read-only."""
        vars(self).update({name: read_only(value) for name, value in state.items()})


def _names(noun: Any) -> list[str]:
    return [field.name for field in fields(noun)]


def read_only(value: Any) -> Any:
    """Return read-only views of arrays, in tuples and mappings too, and anything else as it is."""
    if isinstance(value, np.ndarray):
        view = value.view()
        view.flags.writeable = False
        return view
    if isinstance(value, dict | MappingProxyType):
        return MappingProxyType(_each(read_only, value))
    return _each(read_only, value)


def _plain(value: Any) -> Any:
    return _each(_plain, value)


def _each(change: Callable[[Any], Any], value: Any) -> Any:
    """Return a tuple or a mapping with every part changed, anything else as it is."""
    if isinstance(value, dict | MappingProxyType):
        return {name: change(part) for name, part in value.items()}
    return tuple(map(change, value)) if type(value) is tuple else value
