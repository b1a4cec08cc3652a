"""Native code beside ours: what it prints is no result, and a stop of the process is tidy."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


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


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Let a signal that asks for the end of the process leave by SystemExit, tidying up."""
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        names = []  # which alone can be told of signals
    before = {signal.Signals[n]: signal.signal(signal.Signals[n], _leave) for n in names}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _leave(number: int, _frame: object) -> NoReturn:
    raise SystemExit(128 + number)


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
