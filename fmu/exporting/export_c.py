"""Export of a block as C99 for firmware: a folder that needs nothing but a compiler."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from .blocks import Block
from .c_header import header
from .c_source import core_files, source
from .c_texts import main_file, makefile, readme
from .dispatch import Unit, block_of
from .footprint import measure
from .sources import source_of

SUMS = "SHA256SUMS"
_BUILT = "build"
_TAKEN = ("main", "core", "numeric", "task", "evaluation")


@dataclass(frozen=True)
class CExport:
    """What `export_c` wrote.

    Attributes
    ----------
    folder : Path
    files : tuple of str
        Paths in it, sorted.
    """

    folder: Path
    files: tuple[str, ...]


def export_c(
    block: Any,
    folder: str | PathLike[str],
    *,
    name: str | None = None,
    unit: Unit = "1",
) -> CExport:
    """Write a block as C99 for firmware: header, sources, example, Makefile, README, licence.

    The functions are those that Python and FMUs run, without heap, libm and global variables, so
    that numbers are the same to the last bit. The README tells code size and stack, measured for
    an ARM Cortex-M4 where the package ziglang is installed, else for the host.

    Parameters
    ----------
    block : Trajectory, CommandFollower, JerkFilter, SampledShaper, Inertia, FlexibleInertia, \
Axis, SampledController, DigitalController, Controller, SampledLoop, StateSpace or TransferFunction
        As for `export_fmu`.
    folder : path-like
        To be made, in a folder that exists; or empty; or an earlier export that nobody has
        changed, which is replaced (its `build` goes, too).
    name : str, optional
        A C identifier before all names in C. Default: after the kind of block.
    unit : str or mapping, optional
        As for `export_fmu`.

    Returns
    -------
    CExport

    Raises
    ------
    ValueError, TypeError
        For a block, folder, name or unit that cannot be exported.
    OSError
        Where the folder is a file, holds anything else, or cannot be written; nothing has changed
        then.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> with TemporaryDirectory() as folder:
    ...     made = export_c(Inertia(2.0), f"{folder}/axis", name="axis", unit="rad")
    >>> made.files[:4]
    ('LICENSE.txt', 'Makefile', 'README.md', 'SHA256SUMS')
    """
    described = block_of(block, name=name, unit=unit)
    target = _target(folder)
    files = c_files(described)
    _write(target, files)
    return CExport(target, tuple(sorted(files)))


def c_files(block: Block) -> dict[str, bytes]:
    """Return the files of a block's firmware by their paths in its folder."""
    name = block.name
    if name.lower() in _TAKEN or name.lower().startswith("jounce"):
        raise ValueError(
            f"name = {name!r}: files or functions of the core are called so; use another name"
        )
    core = core_files(block)
    compiled = {f"{name}.h": header(block).encode(), f"{name}.c": source(block).encode()}
    compiled |= {f"core/{file}": core[file] for file in sorted(core)}
    entries = tuple(f"{name}_{verb}" for verb in ("init", "start", "step", "at"))
    files = compiled | {
        "main.c": main_file(block).encode(),
        "Makefile": makefile(block, sorted(core)).encode(),
        "README.md": readme(block, sorted(core), measure(compiled, entries)).encode(),
        "LICENSE.txt": source_of("LICENSE.txt"),
    }
    sums = "".join(f"{_sum(files[file])}  {file}\n" for file in sorted(files))
    return files | {SUMS: sums.encode()}


def _sum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _target(folder: str | PathLike[str]) -> Path:
    """Return the path of the folder to be written, checked."""
    if not isinstance(folder, str | PathLike):
        raise TypeError(f"folder = {folder!r}: expected the path of a folder, as text or a Path")
    given = f"folder = {str(folder)!r}"
    if not str(folder):
        raise ValueError(f"{given}: expected the path of a folder to be written; give its name")
    target = Path(folder).resolve()
    if target.exists() and not target.is_dir():
        raise NotADirectoryError(f"{given}: is a file; name a folder")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{given}: {target.parent} is not a folder; create it first")
    if target.is_dir():
        other = _not_ours(target)
        if other:
            raise FileExistsError(f"{given}: {other}; name a new or empty folder")
    return target


def _not_ours(folder: Path) -> str:
    """Return what of a folder no export wrote, as the middle of a message; nothing for none."""
    sums = {}
    if (folder / SUMS).is_file():
        lines = (folder / SUMS).read_text(encoding="utf-8", errors="replace").splitlines()
        sums = {line[66:]: line[:64] for line in lines}
    for path in sorted(folder.rglob("*")):
        own = path.relative_to(folder).as_posix()
        if path.is_dir() or (sums and (own == SUMS or own.startswith(f"{_BUILT}/"))):
            continue
        if own not in sums:
            return f"holds {own}, which no export wrote"
        if _sum(path.read_bytes()) != sums[own]:
            return f"{own} has been changed since it was exported"
    return ""


def _write(target: Path, files: Mapping[str, bytes]) -> None:
    """Write all files into a folder of another name, which then takes the place of the target."""
    made = _made_beside(target)
    old = made / "old"
    try:
        new = made / "new"
        for name, content in files.items():
            path = new / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        if target.exists():
            target.rename(old)
        new.rename(target)
    except BaseException:
        if old.exists() and not target.exists():
            old.rename(target)
        raise
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _made_beside(target: Path) -> Path:
    """Return a new folder in the same one; OSError where that cannot be written."""
    try:
        return Path(mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    except OSError as error:
        raise type(error)(
            f"folder = {str(target)!r}: {target.parent} cannot be written "
            f"({error.strerror}); name a folder elsewhere"
        ) from None
