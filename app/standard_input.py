"""Standard input in the place of one file: the path `-`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TextIO
from weakref import WeakKeyDictionary

STANDARD_INPUT = Path("-")

_read: WeakKeyDictionary[TextIO, tuple[str, bytes]] = WeakKeyDictionary()


def standard_input(what: str) -> bytes:
    """Return all of standard input, which stands for one file and may be asked for again.

    Parameters
    ----------
    what : str
        What the file is, for messages: ``"a scenario file (TOML)"``.

    Raises
    ------
    ValueError
        Where it was another file before.
    """
    stream = sys.stdin
    if stream is None:
        raise ValueError(f"-: there is no standard input; name {what}")
    taken, content = _read.setdefault(stream, (what, b""))
    if taken != what:
        raise ValueError(f"-: standard input is {taken} already; name {what}")
    if not content:
        content = stream.buffer.read()
        _read[stream] = what, content
    return content


@contextmanager
def file_of(path: Path, what: str) -> Iterator[Path]:
    """Yield a path, in the place of `-` that of a file for as long as it is needed."""
    if path != STANDARD_INPUT:
        yield path
        return
    content = standard_input(what)
    with TemporaryDirectory(prefix="jounce-") as folder:
        copy = Path(folder, f"standard-input{_suffix(content)}")
        copy.write_bytes(content)
        try:
            yield copy
        except ValueError as error:  # of the copy, whose path says nothing to who reads it
            told = (str(copy), str(STANDARD_INPUT))
            error.args = tuple(
                part.replace(*told) if isinstance(part, str) else part for part in error.args
            )
            raise


def _suffix(content: bytes) -> str:
    """Return the suffix by which a file's kind is told, from what it begins with."""
    if content.startswith(b"MATLAB "):
        return ".mat"
    if content.startswith(b"PK"):
        return ".ssp" if b"SystemStructure.ssd" in content else ".fmu"
    return ".uff" if content[:20].split()[:1] == [b"-1"] else ".csv"
