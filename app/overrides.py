"""Keys of a scenario given in place of the file's: ``limits.axis.jerk=3 deg/s^3``."""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np

from .scenario_messages import EXAMPLE_2, Place, key_path
from .units import show

_QUOTED = r"\"(?:[^\"\\]|\\.)*\"|'[^']*'"
_PART = re.compile(rf"\[(\d+)\]|\.({_QUOTED}|[^.=\"'\[\]]+)")
_KEY_AND_VALUE = re.compile(rf"((?:{_QUOTED}|[^=\"'])+)=(.*)", re.DOTALL)
_NAMED: tuple[Place, ...] = (
    *(("limits",), ("modes",), ("moves",), ("tracking",)),
    *(("plant", "modes"), ("believed", "modes")),
)
"""Keys whose entries have names of the user's own."""


def read_overrides(texts: Sequence[str]) -> dict[str, Any]:
    """Return keys and values of texts ``KEY=VALUE``; a value that is no TOML is text.

    Raises
    ------
    ValueError
        For a text without a key or an equals sign, and for a key that is given twice.
    """
    overrides: dict[str, Any] = {}
    for text in texts:
        match = _KEY_AND_VALUE.fullmatch(text)
        if match is None:
            raise ValueError(
                f"--set {show(text)}: expected KEY=VALUE, such as "
                '--set limits.axis.jerk="3 deg/s^3" or --set filter.order=4'
            )
        key = match[1].strip()
        if key in overrides:
            raise ValueError(f"--set {key}: is given twice; give it once")
        overrides[key] = _value(match[2].strip())
    return overrides


def override(content: dict[str, Any], overrides: Mapping[str, Any]) -> dict[Place, str]:
    """Put values into the content of a scenario file.

    Parameters
    ----------
    content : dict
        The file's content, which is changed.
    overrides : mapping of str to object
        Values as TOML has them, by their keys: ``limits.axis.jerk``, ``moves[0].distance`` or
        ``moves."60 arcsec step".distance``. A key may be new, such as a limit that the file does
        not have; an entry of moves, modes or limits must be there. A number may be numpy's.

    Returns
    -------
    dict of tuple to str
        What was put where, as ``key = value``.

    Raises
    ------
    TypeError
        If `overrides` is no mapping.
    ValueError
        For a key that is malformed, leads nowhere or is given twice, naming the nearest.
    """
    if not isinstance(overrides, Mapping):
        raise TypeError(
            f"overrides = {show(overrides)}: expected a mapping of keys to values, such as "
            '{"filter.order": 4}'
        )
    placed: dict[Place, str] = {}
    for key, value in overrides.items():
        value = value.item() if isinstance(value, np.generic) else value
        table, place = _find(content, parts_of(key), key)
        if place in placed:
            raise ValueError(f"override {key}: is given twice; give it once")
        table[place[-1]] = deepcopy(value)
        placed[place] = f"{key} = {show(value)}"
    return placed


def _value(text: str) -> Any:
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return content["value"] if len(content) == 1 else text


def parts_of(key: object) -> list[str | int]:
    """Return the parts of a key: names, and numbers of entries."""
    parts: list[str | int] = []
    rest = f".{key.strip()}" if isinstance(key, str) else "."
    while match := _PART.match(rest):
        parts.append(int(match[1]) if match[1] else _name(match[2]))
        rest = rest[match.end() :]
    if rest:
        raise ValueError(
            f"override {show(key)}: is not a key; write one such as limits.axis.jerk or "
            'moves."60 arcsec step".settle_to'
        )
    return parts


def _name(text: str) -> str:
    if text[0] == "'":
        return text[1:-1]
    if text[0] != '"':
        return text.strip()
    try:
        return str(tomllib.loads(f"value = {text}")["value"])
    except tomllib.TOMLDecodeError:
        return text


def _find(content: dict[str, Any], parts: Sequence[str | int], key: str) -> tuple[Any, Place]:
    """Return the table or list that a key leads into, and its place there."""
    here: Any = content
    place: Place = ()
    for depth, part in enumerate(parts):
        last = depth == len(parts) - 1
        if isinstance(here, list):
            part = _entry(here, part, place, key)
        elif not isinstance(here, dict):
            raise ValueError(
                f"override {key}: {key_path(place)} is {show(here)}, which has no keys; "
                f"override {key_path(place)} itself"
            )
        elif isinstance(part, int) or (place in _NAMED and part not in here):
            raise ValueError(f"override {key}: {_no_entry(part, place, list(here))}")
        place = (*place, part)
        if not last:
            here = here.setdefault(part, _empty(part)) if isinstance(here, dict) else here[part]
    return here, place


def _empty(part: str | int) -> Any:
    """Return what an absent key is filled with: a list, where one is known to stand there."""
    return [] if isinstance(EXAMPLE_2.get(str(part)), list) else {}


def _entry(entries: list[Any], part: str | int, place: Place, key: str) -> int:
    """Return the number of a list's entry, given that number or the entry's name."""
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in entries]
    if part in names:
        return names.index(part)
    number = int(part) if isinstance(part, int) or part.isdecimal() else len(entries)
    if number < len(entries):
        return number
    raise ValueError(f"override {key}: {_no_entry(part, place, [n for n in names if n])}")


def _no_entry(part: str | int, place: Place, names: Sequence[Any]) -> str:
    """Return what to say of an entry that is not there."""
    shown = f"[{part}]" if isinstance(part, int) else show(part)
    there = ", ".join(json.dumps(str(name), ensure_ascii=False) for name in names)
    near = difflib.get_close_matches(str(part), [str(name) for name in names], n=1)
    if near:
        remedy = f"did you mean {key_path((*map(str, place), near[0]))}?"
    else:
        remedy = "name one of these" if there else "write it into the file"
    return f"{key_path(place)} has no entry {shown}, it has {there or 'none'}; {remedy}"
