"""What the commands print: tables, plain text, and what to tell of an error."""

from __future__ import annotations

import sys


def print_parts(*parts: object) -> None:
    """Print tables and plain text, text as it is: no markup, no emoji, no wrapping."""
    from ..analysis.tables import console_for, print_on

    print_on(console_for(sys.stdout), parts)


def message_of(error: Exception) -> str:
    """Return what to tell of an error, with a remedy for one of the operating system's."""
    if isinstance(error, OSError) and error.strerror:
        if error.filename is None:
            return f"standard output: {error.strerror}; print to a place that can be written"
        return f"{error.filename}: {error.strerror}; give a path that can be written"
    return str(error)
