"""What the commands print: tables, plain text, and what to tell of an error."""

from __future__ import annotations

import re
import sys
from contextvars import ContextVar

_quiet = ContextVar("quiet", default=False)


def be_quiet(asked: bool) -> bool:
    """Take what --quiet says: whether `print_parts` prints nothing from now on."""
    _quiet.set(asked)
    return asked


def print_parts(*parts: object) -> None:
    """Print tables and plain text, text as it is: no markup, no emoji, no wrapping."""
    if _quiet.get() or not parts:
        return
    from ..analysis.tables import console_for, print_on

    print_on(console_for(sys.stdout), parts)


def print_text(text: str) -> None:
    """Print a text of many lines, which is for programs, as it is."""
    if not _quiet.get():
        print(text, end="")


def message_of(error: Exception) -> str:
    """Return what to tell of an error, with a remedy for one of the operating system's."""
    if isinstance(error, OSError) and error.strerror:
        if error.filename is None:
            return f"standard output: {error.strerror}; print to a place that can be written"
        return f"{error.filename}: {error.strerror}; give a path that can be written"
    return re.sub("^-: ", "standard input: ", str(error), flags=re.MULTILINE)
