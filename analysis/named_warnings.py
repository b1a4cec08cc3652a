"""Warnings that say what they are of."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def warned_of(what: str) -> Iterator[None]:
    """Name a file and its key, or a move, in front of all warnings that are given within."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        yield
    for each in told:
        warnings.warn(f"{what}: {each.message}", each.category, stacklevel=4)
