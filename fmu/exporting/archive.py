"""Zip files that are the same bytes for the same content, written whole or not at all."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from tempfile import NamedTemporaryFile

_LONG_AGO = (1980, 1, 1, 0, 0, 0)


def archive(entries: Mapping[str, bytes]) -> bytes:
    """Return a zip file: entries sorted by name, all of one time, with one mode."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name in sorted(entries):
            info = zipfile.ZipInfo(name, _LONG_AGO)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = 0o644 << 16
            file.writestr(info, entries[name])
    return buffer.getvalue()


def target_file(path: str | PathLike[str]) -> Path:
    """Return the path of a file to be written, in a folder that exists.

    Raises
    ------
    TypeError
        For what is no path.
    ValueError
        For an empty path.
    OSError
        Where the path is a folder, or its folder is missing.
    """
    if not isinstance(path, str | PathLike):
        raise TypeError(f"path = {path!r}: expected the path of a file, as text or a Path")
    given = f"path = {str(path)!r}"
    if not str(path):
        raise ValueError(f"{given}: expected the path of a file to be written; give its name")
    target = Path(path)
    if target.is_dir():
        raise IsADirectoryError(f"{given}: is a folder; name a file in it")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{given}: {target.parent} is not a folder; create it first")
    return target


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that others see the old one or the new one, never a part of it.

    Raises
    ------
    OSError
        Where it cannot be written; nothing is left behind then.
    """
    try:
        _write(path, content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None


def _write(path: Path, content: bytes) -> None:
    with NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as temporary:
        try:
            temporary.write(content)
            temporary.close()
            Path(temporary.name).chmod(0o666 & ~_mask())
            Path(temporary.name).replace(path)
        except BaseException:
            temporary.close()
            Path(temporary.name).unlink(missing_ok=True)
            raise


def _mask() -> int:
    """Return the permissions that new files do not get."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
