"""Standard output is for results: what native code prints there goes to standard error."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def printed_as_errors() -> Iterator[None]:
    """Send to standard error what is written to the process's own standard output meanwhile."""
    sys.stdout.flush()
    _flush_c()
    kept = os.dup(1)
    try:
        _put(2, 1)
        yield
    finally:
        sys.stdout.flush()
        _flush_c()
        os.dup2(kept, 1)
        os.close(kept)


def _put(source: int, target: int) -> None:
    try:
        os.dup2(source, target)
    except OSError:  # there is no standard error
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, target)
        os.close(nothing)


def _flush_c() -> None:
    """Write out what C's own buffers hold."""
    ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
