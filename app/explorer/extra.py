"""The packages that come with the extra `jounce[explore]`."""

from __future__ import annotations

from importlib import import_module
from typing import Any

INSTALL = "python -m pip install 'jounce[explore]'"


def needed(name: str) -> Any:
    """Return a package; ValueError that names the command to install it where it is not there."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != name.partition(".")[0]:
            raise
        raise ValueError(
            f"the explorer needs {name.partition('.')[0]}, which is not installed; run {INSTALL}"
        ) from None
