"""Sweep files: which keys vary, how they are sampled and what is kept, as TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..text_files import read_toml
from ..units import show
from .parameters import LogUniform, Normal, Uniform

_RANGES = {"uniform": Uniform, "log-uniform": LogUniform, "normal": Normal}
_KEYS = ("parameters", "figures", "samples", "design", "seed", "hold_gains")
_EXAMPLE = 'parameters."plant.inertia" = ["0.9 kg m^2", "1.1 kg m^2"]'


def read_sweep_file(path: Path) -> dict[str, Any]:
    """Return what `sweep` takes besides the scenario, by its keywords.

    Raises
    ------
    ValueError
        For a file that cannot be read, a key that there is not, or a range that is none.
    """
    content = read_toml(path, "a sweep file (TOML)")
    unknown = [key for key in content if key not in _KEYS]
    if unknown:
        raise ValueError(f"{path}: {unknown[0]} is no key: expected {', '.join(_KEYS)}")
    given = content.pop("parameters", {})
    if not isinstance(given, Mapping):
        raise ValueError(f"{path}: parameters = {show(given)}: expected a table; write {_EXAMPLE}")
    if not given:
        raise ValueError(f"{path}: nothing varies, without parameters; write {_EXAMPLE}")
    try:
        parameters = {key: _parameter(key, value) for key, value in _flat(given)}
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return {"parameters": parameters, **content}


@contextmanager
def told_by(path: Path, *others: Path) -> Iterator[None]:
    """Name the sweep file in errors about what it asks for, not in those that name others."""
    try:
        yield
    except ValueError as error:
        if str(error).startswith(tuple(map(str, others))):
            raise
        raise ValueError(f"{path}: {error}") from None


def _flat(table: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """Return keys and values, keys written with dots or as tables alike."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        if isinstance(value, Mapping) and not _is_range(value):
            found += _flat(value, f"{before}{key}.")
        else:
            found.append((f"{before}{key}", value))
    return found


def _is_range(table: Mapping[str, Any]) -> bool:
    """Whether a table is a range, its kind perhaps misspelt, and not a part of a key."""
    return any(
        isinstance(ends, list) and get_close_matches(kind.replace("_", "-"), _RANGES, cutoff=0.75)
        for kind, ends in table.items()
    )


def _parameter(key: str, value: object) -> object:
    if not isinstance(value, Mapping):
        return value
    kinds = ", ".join(f"{name} = [first, second]" for name in _RANGES)
    name = next(iter(value))
    if len(value) != 1 or name not in _RANGES:
        raise ValueError(
            f"parameter {key} = {show(dict(value))}: expected a list, or one of {kinds}"
        )
    ends = value[name]
    if not isinstance(ends, list) or len(ends) != 2:
        raise ValueError(f"parameter {key}: {name} = {show(ends)}: expected a list of two values")
    try:
        return _RANGES[name](*ends)
    except ValueError as error:
        raise ValueError(f"parameter {key}: {error}") from None
