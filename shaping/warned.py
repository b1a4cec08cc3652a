"""Warnings at the line outside this package from which it was called, that say what they are of.

What is put in front of them, and which of them are not told, is of a thread by itself.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_PACKAGE = __name__.partition(".")[0]
_NAMED: ContextVar[tuple[str, ...]] = ContextVar("named", default=())
_UNTOLD: ContextVar[tuple[type[Warning], ...]] = ContextVar("untold", default=())


def warn_caller(message: str, category: type[Warning] = RuntimeWarning) -> None:
    """Warn at the caller's own line, through however many functions of ours."""
    if issubclass(category, _UNTOLD.get()):
        return
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == _PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(": ".join((*_NAMED.get(), message)), category, stacklevel=level)


@contextmanager
def warned_of(what: str) -> Iterator[None]:
    """Name a file and its key, or a move, in front of all warnings that are given within."""
    before = _NAMED.set((*_NAMED.get(), what))
    try:
        yield
    finally:
        _NAMED.reset(before)


@contextmanager
def untold(category: type[Warning] = Warning) -> Iterator[None]:
    """Leave out the warnings of a kind that `warn_caller` would give within."""
    before = _UNTOLD.set((*_UNTOLD.get(), category))
    try:
        yield
    finally:
        _UNTOLD.reset(before)
