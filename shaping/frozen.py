"""Nouns that stay read-only when they are copied, or sent to another process."""

from __future__ import annotations

from dataclasses import fields
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np


class Frozen:
    """A frozen dataclass whose copies and pickles are as read-only as itself.

    They have its fields alone: what it has worked out and kept is worked out again.
    """

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, what is read-only among them marked."""
        names = {field.name for field in fields(self)}  # type: ignore[arg-type]
        return {name: _marked(value) for name, value in vars(self).items() if name in names}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over fields, what is marked made read-only again."""
        vars(self).update({name: _restored(value) for name, value in state.items()})


class _ReadOnly(NamedTuple):
    """An array or a mapping that is to be read-only."""

    value: Any


def _marked(value: Any) -> Any:
    if isinstance(value, np.ndarray) and not value.flags.writeable:
        return _ReadOnly(value)
    if isinstance(value, MappingProxyType):
        return _ReadOnly({name: _marked(part) for name, part in value.items()})
    return tuple(map(_marked, value)) if type(value) is tuple else value


def _restored(value: Any) -> Any:
    if type(value) is not _ReadOnly:
        return tuple(map(_restored, value)) if type(value) is tuple else value
    if isinstance(value.value, dict):
        return MappingProxyType({name: _restored(part) for name, part in value.value.items()})
    value.value.flags.writeable = False
    return value.value
