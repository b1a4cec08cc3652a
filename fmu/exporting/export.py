"""Export of a block as an FMU of FMI 2.0 or 3.0."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Iterable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .archive import archive, target_file, write_atomically
from .blocks import Block
from .compile import PLATFORMS, available_platforms, build, host_platform
from .dispatch import Unit, block_of
from .documentation import documentation
from .sources import MAIN, licences, sources_of
from .xml_fmi2 import model_description_fmi2
from .xml_fmi3 import build_description, model_description_fmi3

_NO_COMPILER = (
    "no C compiler was found, so the FMU holds sources only and runs in no tool before it is "
    "compiled: install a C compiler (cc) or the package ziglang and export again, or run "
    "`fmpy compile` on it where there is one"
)


@dataclass(frozen=True)
class FmuExport:
    """What `export_fmu` wrote.

    Attributes
    ----------
    path : Path
    fmi_version : str
    platforms : tuple of str
        Platforms for which it holds a binary; none if it holds sources only.
    notes : tuple of str
        What the user should know, such as that there was no compiler.
    """

    path: Path
    fmi_version: str
    platforms: tuple[str, ...]
    notes: tuple[str, ...]


def export_fmu(
    block: Any,
    path: str | PathLike[str],
    *,
    fmi_version: str = "2.0",
    platforms: Iterable[str] | None = None,
    name: str | None = None,
    unit: Unit = "1",
) -> FmuExport:
    """Write a block as an FMU for co-simulation that needs nothing but itself.

    It holds C99 sources, binaries compiled from them, and a description with units, limits and
    dependencies. The same arguments and compiler give the same bytes.

    Parameters
    ----------
    block : Trajectory, CommandFollower, JerkFilter, SampledShaper, Inertia, FlexibleInertia, \
Axis, SampledController, DigitalController, Controller, SampledLoop, StateSpace or TransferFunction
        A python-control system of continuous time, or discrete
        with a sampling time, and at most 200 states.
    path : path-like
        Of the file; its folder must exist. An existing file is replaced.
    fmi_version : "2.0" or "3.0", optional
    platforms : iterable of str, optional
        Of "x86_64-linux", "x86_64-windows", "aarch64-linux", "x86_64-darwin" and
        "aarch64-darwin"; empty for sources only. Default: the host's, and with the package
        ziglang installed the first two.
    name : str, optional
        A C identifier: the FMU's modelIdentifier. Default: after the kind of block.
    unit : str or mapping, optional
        Unit of position ("rad", "deg", "m", "mm", …) from which the others follow; of a
        python-control system a mapping from names of signals and states to units such as
        "N.m/rad". Time is in seconds. Default: none, "1".

    Returns
    -------
    FmuExport

    Raises
    ------
    ValueError, TypeError
        For a block, path, name, unit, version or platform that cannot be exported.
    OSError
        Where the path is a folder, its folder is missing, or it cannot be written.
    CompilerError
        Where there is no compiler for a platform that was asked for.
    ModuleNotFoundError
        Without the package fmpy, which brings the headers of FMI.

    Notes
    -----
    Blocks that are sampled (the follower, the controller, discrete systems) run sample k in the
    communication step that starts at t_k, and put its result out at that step's end.

    How the sources are compiled stands in sources/buildDescription.xml in FMI 3.0; FMI 2.0 has no
    such file, and lists them in modelDescription.xml.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> with TemporaryDirectory() as folder:
    ...     made = export_fmu(Inertia(2.0), f"{folder}/axis.fmu", unit="rad", platforms=[])
    >>> made.path.name, made.platforms
    ('axis.fmu', ())
    """
    if fmi_version not in ("2.0", "3.0"):
        raise ValueError(f"fmi_version = {fmi_version!r}: expected '2.0' or '3.0'")
    chosen = _chosen(platforms)
    described = block_of(block, name=name, unit=unit)
    target = target_file(path)
    entries = fmu_entries(described, fmi_version, chosen)
    write_atomically(target, archive(entries))
    notes = (_NO_COMPILER,) if platforms is None and not chosen else ()
    return FmuExport(target, fmi_version, tuple(chosen), notes)


def _chosen(platforms: Iterable[str] | None) -> list[str]:
    """Return the platforms to build, each once."""
    if platforms is None:
        return available_platforms()
    if isinstance(platforms, str):
        raise TypeError(f"platforms = {platforms!r}: expected a list, such as [{platforms!r}]")
    chosen = [host_platform() if name == "host" else name for name in dict.fromkeys(platforms)]
    for name in chosen:
        if name not in PLATFORMS:
            raise ValueError(f"platform {name!r}: expected host, {', '.join(PLATFORMS)}")
    return list(dict.fromkeys(chosen))


def fmu_entries(block: Block, fmi_version: str, platforms: Iterable[str]) -> dict[str, bytes]:
    """Return the files of an FMU by their paths inside it."""
    token = _token(block, fmi_version)
    sources = sources_of(block, fmi_version, token)
    entries = {f"sources/{name}": text for name, text in sources.items()}
    if fmi_version == "2.0":
        entries["modelDescription.xml"] = model_description_fmi2(block, token, [MAIN])
    else:
        entries["modelDescription.xml"] = model_description_fmi3(block, token)
        entries["sources/buildDescription.xml"] = build_description(block, [MAIN])
    entries["documentation/index.html"] = documentation(block)
    for name, text in licences(fmi_version).items():
        entries[f"documentation/licenses/{name}"] = text.encode()
    for name in platforms:
        folder = PLATFORMS[name].folder(name, fmi_version)
        library = f"binaries/{folder}/{block.name}{PLATFORMS[name].suffix}"
        entries[library] = build(sources, block.name, name)
    return entries


def _token(block: Block, fmi_version: str) -> str:
    """Return an identifier of all that the description and the binary have in common."""
    content = hashlib.sha256(model_description_fmi3(block, ""))
    for name, text in sorted(sources_of(block, fmi_version, "").items()):
        content.update(name.encode() + b"\0" + text)
    return f"{{{uuid.UUID(bytes=content.digest()[:16], version=5)}}}"
