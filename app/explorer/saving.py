"""Changes of a scenario file: what differs, and the file's text with it, comments kept."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..scenario import ScenarioError, scenario_of
from ..standard_input import STANDARD_INPUT
from ..text_files import text_of
from .state import State
from .toml_edits import edited

_WHAT = "a scenario file (TOML)"


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return what of a content is other than before, in nested tables; None where it is no more.

    Lists are told whole.
    """
    told: dict[str, Any] = {key: None for key in before if key not in after}
    for key, value in after.items():
        was = before.get(key)
        if isinstance(value, Mapping) and isinstance(was, Mapping):
            inner = differences(was, value)
            if inner:
                told[key] = inner
        elif value != was:
            told[key] = value
    return told


def merged(before: Mapping[str, Any], told: Mapping[str, Any]) -> dict[str, Any]:
    """Return a content with differences put in: `differences` undone."""
    after = dict(before)
    for key, value in told.items():
        was = after.get(key)
        if value is None:
            after.pop(key, None)
        elif isinstance(value, Mapping) and isinstance(was, Mapping):
            after[key] = merged(was, value)
        else:
            after[key] = value
    return after


def text_with(text: str, opened: State, state: State) -> str:
    """Return a scenario file's text as a state has it; comments and order stay.

    Parameters
    ----------
    text : str
        Of the file that was opened.
    opened : State
        What it was read as: a rule for the gains has become numbers there.
    state : State

    Notes
    -----
    Where the file has a rule, gains = "design" or the like, it stays as long as nothing of the
    controller was changed; else the gains are written out, so that the file has the loop that was
    looked at.
    """
    told = differences(opened.content, state.content)
    rule = tomllib.loads(text)["controller"].get("gains", "design")
    if "controller" in told and isinstance(rule, str):
        told["controller"]["gains"] = state.content["controller"]["gains"]
    written = edited(text, told)
    return written if _is_read(opened.path, written) else _with_format(written)


def saved(text: str, opened: State, state: State, path: Path) -> str:
    """Write a state to a file and return its text, as `text_with` has it.

    Raises
    ------
    ValueError
        Where the file that was opened has changed meanwhile, which would be lost.
    """
    if path == STANDARD_INPUT:
        raise ValueError("-: standard input cannot be written; save under another name")
    if path == opened.path and path.exists() and text_of(path, _WHAT) != text:
        raise ValueError(
            f"{path}: was changed by others since it was opened; save under another name, or open "
            "it anew"
        )
    written = text_with(text, opened, state)
    path.write_bytes(written.encode("utf-8"))
    return written


def _is_read(path: Path, text: str) -> bool:
    """Return whether a text is a scenario as it stands, of whichever format it says."""
    try:
        scenario_of(path, tomllib.loads(text))
    except ScenarioError:
        return False
    return True


def _with_format(text: str) -> str:
    """Return a text of format 1 that says format 2, before its first key."""
    lines = text.splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if line.strip() and not line.startswith("#"))
    return "".join([*lines[:at], "format = 2\n", *lines[at:]])
