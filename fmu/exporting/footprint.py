"""What a block's firmware takes of a processor: code and stack, measured on compiled objects."""

from __future__ import annotations

import re
import shlex
import struct
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from .compile import has_zig, host_compiler, host_platform

FLAGS = ["-std=c99", "-ffp-contract=off", "-Os", "-ffunction-sections", "-Icore", "-c"]
_CORTEX_M4 = ["-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m4", "-fstack-size-section"]
_EXECUTED, _KEPT = 4, 2  # flags of sections
_SYMBOLS, _RELA, _REL = 2, 4, 9  # kinds of sections


@dataclass(frozen=True)
class Footprint:
    """What the compiled objects take, in bytes; functions of the compiler's own not counted."""

    processor: str
    code: int
    constants: int
    stack: int


def measure(files: Mapping[str, bytes], entries: tuple[str, ...]) -> Footprint | None:
    """Return what C files take, for a Cortex-M4 where zig is installed, else for this machine.

    Parameters
    ----------
    files : mapping
        Sources and headers by path in the export's folder.
    entries : tuple of str
        Functions that are called from outside.

    Returns
    -------
    Footprint or None
        None where there is no compiler whose objects can be read. The stack is the deepest chain
        of calls.
    """
    command, processor = _compiler()
    if command is None:
        return None
    with TemporaryDirectory(prefix="jounce_c_") as folder:
        for name, text in files.items():
            path = Path(folder, name)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(text)
        objects = [_compiled(command, Path(folder), name) for name in files if name.endswith(".c")]
        if any(one is None for one in objects):
            return None
        return _summed([one for one in objects if one is not None], entries, processor)


def _compiler() -> tuple[list[str] | None, str]:
    if has_zig():
        zig = [sys.executable, "-m", "ziglang", "cc", *_CORTEX_M4]
        return zig, "ARM Cortex-M4, doubles by software, clang -Os"
    host = host_compiler()
    if host is None or not host_platform().endswith("linux"):
        return None, ""
    return [*host, "-fstack-usage"], f"{host_platform()}, {Path(shlex.join(host)).name} -Os"


@dataclass(frozen=True)
class _Object:
    code: int
    constants: int
    frames: dict[str, int]
    calls: dict[str, set[str]]


def _compiled(command: list[str], folder: Path, name: str) -> _Object | None:
    target = Path(name).with_suffix(".o").name
    done = subprocess.run(
        [*command, *FLAGS, name, "-o", target],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    path = folder / target
    if done.returncode != 0 or path.read_bytes()[:4] != b"\x7fELF":
        return None
    made = _read(path.read_bytes())
    told = path.with_suffix(".su")
    if told.exists():
        rows = (line.split("\t") for line in told.read_text(encoding="utf-8").splitlines())
        made.frames.update({_plain(row[0].split(":")[-1]): int(row[1]) for row in rows})
    return made


@dataclass(frozen=True)
class _Section:
    name: str
    kind: int
    flags: int
    data: bytes
    link: int
    info: int


def _read(elf: bytes) -> _Object:
    """Return sizes, frames and calls of an object of little-endian ELF, one section a function."""
    wide = elf[4] == 2
    sections = list(_sections(elf, wide))
    symbols = _symbols(sections, wide)
    calls: dict[str, set[str]] = {}
    frames: dict[str, int] = {}
    for section in sections:
        about = _function(sections[section.info].name) if section.kind in (_REL, _RELA) else ""
        if about:
            size = (24 if wide else 12) if section.kind == _RELA else (16 if wide else 8)
            places = range(0, len(section.data), size)
            infos = [
                struct.unpack_from("<QQ" if wide else "<II", section.data, k)[1] for k in places
            ]
            called = {symbols[info >> 32 if wide else info >> 8] for info in infos}
            calls.setdefault(about, set()).update(called - {""})
        if section.name.startswith(".stack_sizes"):
            frames[_function(sections[section.link].name)] = _uleb(section.data[8 if wide else 4 :])
    kept = [section for section in sections if section.flags & _KEPT and section.kind == 1]
    return _Object(
        sum(len(one.data) for one in kept if one.flags & _EXECUTED),
        sum(len(one.data) for one in kept if one.name.startswith(".rodata")),
        frames,
        calls,
    )


def _sections(elf: bytes, wide: bool) -> Iterator[_Section]:
    start = struct.unpack_from("<Q" if wide else "<I", elf, 40 if wide else 32)[0]
    size, count, names = struct.unpack_from("<HHH", elf, 58 if wide else 46)
    form = "<IIQQQQIIQQ" if wide else "<IIIIIIIIII"
    heads = [struct.unpack_from(form, elf, start + k * size) for k in range(count)]
    text = elf[heads[names][4] :]
    for name, kind, flags, _, offset, length, link, info, _, _ in heads:
        data = b"" if kind == 8 else elf[offset : offset + length]  # 8: takes no room in the file
        yield _Section(_text(text, name), kind, flags, data, link, info)


def _symbols(sections: list[_Section], wide: bool) -> list[str]:
    """Return the function that each symbol names; a section's is that in it."""
    table = next(section for section in sections if section.kind == _SYMBOLS)
    text, found = sections[table.link].data, []
    for k in range(0, len(table.data), 24 if wide else 16):
        if wide:
            name, info, _, place = struct.unpack_from("<IBBH", table.data, k)
        else:
            name, _, _, info, _, place = struct.unpack_from("<IIIBBH", table.data, k)
        of_section = info & 15 == 3 and place < len(sections)
        found.append(_function(sections[place].name) if of_section else _plain(_text(text, name)))
    return found


def _text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode()


def _function(section: str) -> str:
    found = re.fullmatch(r"\.text\.(?:unlikely\.|hot\.)?(.+)", section)
    return _plain(found[1].removesuffix(".cold")) if found else ""


def _plain(name: str) -> str:
    """Return a function's name without the number of a copy that the compiler made of it."""
    return re.sub(r"\.\d+$", "", name)


def _uleb(data: bytes) -> int:
    value = 0
    for k, byte in enumerate(data):
        value |= (byte & 127) << 7 * k
        if byte < 128:
            break
    return value


def _summed(objects: list[_Object], entries: tuple[str, ...], processor: str) -> Footprint | None:
    """Return the footprint of all objects; None where a function may call itself."""

    @cache
    def depth(index: int, name: str) -> int:
        one = objects[index]
        if name not in one.frames:  # another file's, or the compiler's own
            index = next((k for k, other in enumerate(objects) if name in other.frames), index)
            one = objects[index]
        called = one.calls.get(name, ())
        return one.frames.get(name, 0) + max((depth(index, other) for other in called), default=0)

    try:
        stack = max(depth(0, name) for name in entries)
    except RecursionError:
        return None
    code, constants = sum(one.code for one in objects), sum(one.constants for one in objects)
    return Footprint(processor, code, constants, stack)
