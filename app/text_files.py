"""Text, TOML and JSON files read whole, with one clear line for what cannot be read."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from .standard_input import STANDARD_INPUT, standard_input

_UNREADABLE = "a number of thousands of digits or brackets nested too deeply"


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the content of a TOML file.

    Parameters
    ----------
    path : Path
        A file in UTF-8, with or without a byte order mark; `-` is standard input.
    what : str
        What the file is, for messages: ``"a scenario file (TOML)"``.

    Raises
    ------
    ValueError
        If the file cannot be read or is no TOML; the message names the path and the remedy.
    """
    text = text_of(path, what)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not TOML: {error}; correct that place") from None
    except (ValueError, RecursionError):
        raise ValueError(
            f"{path}: not readable TOML: {_UNREADABLE}; write values as in the examples"
        ) from None


def read_json(path: Path, what: str) -> Any:
    """Return the content of a JSON file, as `read_toml` does that of TOML."""
    text = text_of(path, what)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: not JSON: {error}; name {what}") from None
    except (ValueError, RecursionError):
        raise ValueError(f"{path}: not readable JSON: {_UNREADABLE}; name {what}") from None


def text_of(path: Path, what: str) -> str:
    """Return the text of a file in UTF-8; ValueError as of `read_toml` if it cannot be read."""
    given = standard_input(what) if path == STANDARD_INPUT else None
    try:
        content = path.read_bytes() if given is None else given
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8 text"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(f"{path}: {reason}; name {what}") from None
