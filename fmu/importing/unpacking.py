"""The zip archive or the folder of an FMU: checked before any of it is read, then unpacked."""

from __future__ import annotations

import errno
import hashlib
import re
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO

from ...shaping.checks import whole
from .description import FmuError

MAX_ENTRIES = 20_000
"""Entries that an FMU may have."""
MAX_BYTES = 2**31
"""Bytes that an FMU may unpack to."""
MAX_RATIO = 200
"""How many times its own size an archive may unpack to, if that is more than `FREE_BYTES`."""
FREE_BYTES = 2**28
"""Bytes that may be unpacked whatever the ratio."""

HEADS = ("modelDescription.xml", "SystemStructure.ssd")
_CHUNK = 2**20
_DRIVE = re.compile(r"[A-Za-z]:")
_ENCRYPTED = 0x1
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


@contextmanager
def open_fmu(
    path: Path, max_unpacked_bytes: int | None = None
) -> Iterator[tuple[zipfile.ZipFile, str]]:
    """Yield the archive of an FMU, all its entries checked, and its sha256.

    A folder is packed into a temporary archive first; its sha256 is that of the lines "digest,
    two blanks, path" of its files, sorted by path.

    Raises
    ------
    OSError
        Where the file is not there or cannot be read.
    FmuError
        For a file that is no zip archive, and for an entry that no honest FMU has: a path that
        leaves the archive, a link, a second one of the same name that differs, an encrypted one,
        one that unpacks to too much.
    """
    if max_unpacked_bytes is not None:
        max_unpacked_bytes = whole("max_unpacked_bytes", max_unpacked_bytes, 1, 2**63)
    with _opened(path, max_unpacked_bytes or MAX_BYTES) as (file, digest):
        try:
            archive = zipfile.ZipFile(file)
        except (zipfile.BadZipFile, NotImplementedError, ValueError, OverflowError) as error:
            raise FmuError(
                f"{path}: not an FMU, which is a zip archive ({error}); give the path of one"
            ) from None
        with archive:
            _check(archive.infolist(), path)
            packed = max(file.seek(0, 2), 1)
            _check_size(archive.infolist(), path, packed, max_unpacked_bytes)
            yield archive, digest


def entries_by_path(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """Return the entries of a checked archive by their plain paths, such as a/b for ./a//b."""
    return {str(PurePosixPath(entry.filename)): entry for entry in archive.infolist()}


def read_entry(archive: zipfile.ZipFile, name: str, limit: int) -> bytes:
    """Return one entry; FmuError where it is damaged or longer than `limit` bytes."""
    entry = entries_by_path(archive)[name]
    if entry.file_size > limit:
        raise FmuError(
            f"{name} of {entry.file_size} bytes: expected at most {limit}; export the FMU with "
            "fewer variables"
        )
    with _told_as_damage(name), archive.open(entry) as source:
        return source.read(limit + 1)


def unpack(archive: zipfile.ZipFile, folder: Path) -> None:
    """Unpack a checked archive into an empty folder, never over a file that is there."""
    for entry in entries_by_path(archive).values():
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


@contextmanager
def _opened(path: Path, most: int) -> Iterator[tuple[IO[bytes], str]]:
    if path.is_dir():
        with tempfile.TemporaryFile() as file:
            yield file, _pack(path, file, most)
    else:
        with path.open("rb") as file:
            yield file, _sha256(file)


def _pack(folder: Path, file: IO[bytes], most: int) -> str:
    """Pack the files of a folder, none of them a link, and return the digest of them all."""
    if not any((folder / name).is_file() for name in HEADS):
        told = f"a directory without a {' or '.join(HEADS)}, which an unpacked FMU or SSP has"
        raise IsADirectoryError(errno.EISDIR, told, str(folder))
    lines = []
    with zipfile.ZipFile(file, "w") as archive:
        for name, source in sorted(_files(folder, most).items()):
            with source.open("rb") as opened:
                lines.append(f"{_sha256(opened)}  {name}\n")
                with archive.open(zipfile.ZipInfo(name), "w", force_zip64=True) as copy:
                    shutil.copyfileobj(opened, copy, _CHUNK)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _files(folder: Path, most: int) -> dict[str, Path]:
    found: dict[str, Path] = {}
    size = 0
    for path in folder.rglob("*"):
        name, status = path.relative_to(folder).as_posix(), path.lstat()
        if stat.S_ISDIR(status.st_mode):
            continue
        if not stat.S_ISREG(status.st_mode):
            raise FmuError(
                f"{path} is a link or a device: expected files and folders only; put the file "
                "itself there"
            )
        found[name] = path
        size += status.st_size
        if len(found) > MAX_ENTRIES or size > most:
            raise FmuError(
                f"{folder}: expected at most {MAX_ENTRIES} files and {most} bytes: name the folder "
                "of the FMU alone, or give max_unpacked_bytes (on the command line --max-size)"
            )
    return found


def _check(entries: Sequence[zipfile.ZipInfo], path: Path) -> None:
    if len(entries) > MAX_ENTRIES:
        raise FmuError(f"{path}: {len(entries)} entries; expected at most {MAX_ENTRIES}")
    seen: dict[PurePosixPath, zipfile.ZipInfo] = {}
    for entry in entries:
        _check_entry(entry)
        name = PurePosixPath(entry.filename)
        other = seen.setdefault(name, entry)
        if _content(entry) != _content(other):
            raise FmuError(
                f"two entries '{name}' that differ: which of them counts is anybody's guess; "
                "export the FMU again"
            )


def _content(entry: zipfile.ZipInfo) -> tuple[int, int, bool]:
    """Return what tells contents apart; that the checksum is true, reading checks."""
    return entry.CRC, entry.file_size, entry.is_dir()


def _check_size(
    entries: Sequence[zipfile.ZipInfo], path: Path, packed: int, most: int | None
) -> None:
    """Refuse what unpacks to more than asked for, or than an FMU of this size should."""
    size = sum(entry.file_size for entry in entries)
    allowed = min(max(FREE_BYTES, MAX_RATIO * packed), MAX_BYTES) if most is None else most
    if size > allowed:
        raise FmuError(
            f"{path}: {packed} bytes that unpack to {size}, allowed are {allowed}: a zip bomb? If "
            f"you trust it, give max_unpacked_bytes={size} (on the command line --max-size {size})"
        )


def _check_entry(entry: zipfile.ZipInfo) -> None:
    name = entry.orig_filename
    kind = stat.S_IFMT(entry.external_attr >> 16)
    remedy = "expected plain relative paths with '/'; do not trust this file"
    if not name or "\0" in name or "\\" in name:
        raise FmuError(f"entry {name!r}: {remedy}")
    if name.startswith("/") or _DRIVE.match(name):
        raise FmuError(f"entry {name!r} is an absolute path: {remedy}")
    if ".." in PurePosixPath(name).parts or (not PurePosixPath(name).parts and name != "./"):
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
