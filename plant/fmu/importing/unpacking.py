"""The zip archive of an FMU: entries checked before any is read, unpacked without surprises."""

from __future__ import annotations

import hashlib
import re
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO

from .description import FmuError

MAX_ENTRIES = 20_000
"""Entries that an FMU may have."""
MAX_BYTES = 2**31
"""Bytes that an FMU may unpack to."""
MAX_RATIO = 200
"""How many times its own size an archive may unpack to, beyond the first `FREE_BYTES`."""
FREE_BYTES = 2**24
"""Bytes that may be unpacked whatever the ratio."""

_CHUNK = 2**20
_DRIVE = re.compile(r"[A-Za-z]:")
_ENCRYPTED = 0x1
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


@contextmanager
def open_fmu(path: Path) -> Iterator[tuple[zipfile.ZipFile, str]]:
    """Yield the archive of an FMU, all its entries checked, and the sha256 of the file.

    Raises
    ------
    OSError
        Where the file is not there or cannot be read.
    FmuError
        For a file that is no zip archive, and for an entry that no honest FMU has: a path that
        leaves the archive, a link, a duplicate, an encrypted one, one that unpacks to too much.
    """
    with path.open("rb") as file:
        digest = _sha256(file)
        try:
            archive = zipfile.ZipFile(file)
        except (zipfile.BadZipFile, NotImplementedError, ValueError, OverflowError) as error:
            raise FmuError(f"{path}: not an FMU, which is a zip archive ({error})") from None
        with archive:
            _check(archive, path)
            yield archive, digest


def read_entry(archive: zipfile.ZipFile, name: str, limit: int) -> bytes:
    """Return one entry; FmuError where it is damaged or longer than `limit` bytes."""
    entry = archive.getinfo(name)
    if entry.file_size > limit:
        raise FmuError(
            f"{name} of {entry.file_size} bytes: expected at most {limit}; export the FMU with "
            "fewer variables"
        )
    with _told_as_damage(name), archive.open(entry) as source:
        return source.read(limit + 1)


def unpack(archive: zipfile.ZipFile, folder: Path) -> None:
    """Unpack a checked archive into an empty folder, never over a file that is there."""
    for entry in archive.infolist():
        target = folder.joinpath(*PurePosixPath(entry.filename).parts)
        try:
            if entry.is_dir():
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            with (
                _told_as_damage(entry.filename),
                archive.open(entry) as source,
                target.open("xb") as copy,
            ):
                while chunk := source.read(_CHUNK):
                    copy.write(chunk)
        except (FileExistsError, NotADirectoryError):
            raise FmuError(
                f"{entry.filename!r} collides with another entry: export the FMU again"
            ) from None


@contextmanager
def _told_as_damage(name: str) -> Iterator[None]:
    try:
        yield
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise FmuError(f"{name}: damaged ({error}); copy or export the FMU again") from None


def _sha256(file: IO[bytes]) -> str:
    digest = hashlib.sha256()
    while chunk := file.read(_CHUNK):
        digest.update(chunk)
    file.seek(0)
    return digest.hexdigest()


def _check(archive: zipfile.ZipFile, path: Path) -> None:
    entries = archive.infolist()
    if len(entries) > MAX_ENTRIES:
        raise FmuError(f"{path}: {len(entries)} entries; expected at most {MAX_ENTRIES}")
    seen: set[str] = set()
    for entry in entries:
        _check_entry(entry)
        name = str(PurePosixPath(entry.filename))
        if name in seen:
            raise FmuError(
                f"two entries {name!r}: which of them counts is anybody's guess; export the FMU "
                "again"
            )
        seen.add(name)
    size = sum(entry.file_size for entry in entries)
    packed = max(path.stat().st_size, 1)
    if size > MAX_BYTES or size > FREE_BYTES + MAX_RATIO * packed:
        raise FmuError(
            f"{path}: {packed} bytes that unpack to {size}: a zip bomb? Expected at most "
            f"{MAX_BYTES} bytes and {MAX_RATIO} times the size of the file"
        )


def _check_entry(entry: zipfile.ZipInfo) -> None:
    name = entry.orig_filename
    kind = stat.S_IFMT(entry.external_attr >> 16)
    remedy = "expected plain relative paths with '/'; do not trust this file"
    if not name or "\0" in name or "\\" in name:
        raise FmuError(f"entry {name!r}: {remedy}")
    if name.startswith("/") or _DRIVE.match(name):
        raise FmuError(f"entry {name!r} is an absolute path: {remedy}")
    if ".." in PurePosixPath(name).parts or not PurePosixPath(name).parts:
        raise FmuError(f"entry {name!r} leaves the archive: {remedy}")
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise FmuError(
            f"entry {name!r} is a link or a device: expected files and folders only; do not trust "
            "this file"
        )
    if entry.header_offset < 0:
        raise FmuError(f"entry {name!r}: damaged (begins before the file); copy the FMU again")
    if entry.flag_bits & _ENCRYPTED:
        raise FmuError(f"entry {name!r} is encrypted: expected an archive without a password")
    if entry.compress_type not in _METHODS:
        raise FmuError(
            f"entry {name!r} is packed by method {entry.compress_type}: FMI allows stored and "
            "deflated entries only; pack the FMU again"
        )
