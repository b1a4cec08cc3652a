"""The library of an FMU: found, loaded, its log kept, everything undone at the end."""

from __future__ import annotations

import ctypes
import platform
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from .description import FmuDescription, FmuError
from .instance import Instance

if TYPE_CHECKING:
    from .isolation import Process, RemoteInstance
_FOLDERS_FMI2 = {
    ("Linux", "x86_64"): ["linux64", "x86_64-linux"],
    ("Linux", "aarch64"): ["aarch64-linux", "linux64"],
    ("Windows", "x86_64"): ["win64", "x86_64-windows"],
    ("Windows", "aarch64"): ["aarch64-windows"],
    ("Linux", "x86"): ["linux32"],
    ("Windows", "x86"): ["win32"],
    ("Darwin", "x86_64"): ["darwin64", "x86_64-darwin"],
    ("Darwin", "aarch64"): ["darwin64", "aarch64-darwin"],
}
_SUFFIX = {"Windows": ".dll", "Darwin": ".dylib"}
_MACHINES = {"AMD64": "x86_64", "amd64": "x86_64", "arm64": "aarch64", "ARM64": "aarch64"}


class Session:
    """An unpacked FMU, its library and its instance; `close` undoes all three, in any state.

    `process` is the one that has library and instance of an isolated FMU. The folder of a `twin`
    is another session's; it has a copy of the library in it, with global variables of its own.
    """

    def __init__(self, folder: Path, *, twin: bool = False) -> None:
        self.folder = folder
        self.twin = twin
        self.copy: Path | None = None
        self.library: ctypes.CDLL | None = None
        self.instance: Instance | RemoteInstance | None = None
        self.process: Process | None = None
        self.stepping = False
        self.fatal = False
        self.states: set[int] = set()

    def free_state(self, pointer: int) -> None:
        """Free a state of the instance, unless it has been freed already."""
        if pointer in self.states:
            self.states.discard(pointer)
            if self.instance is not None and not self.fatal:
                self.instance.free_state(pointer)

    def load(self, path: Path) -> ctypes.CDLL:
        """Return the library, loaded once."""
        if self.library is None:
            if self.twin:
                self.copy = path.with_name(f"{uuid4().hex}{path.suffix}")
                shutil.copyfile(path, self.copy)
            self.library = load_library(self.copy or path)
        return self.library

    def free_instance(self) -> None:
        """Free the instance with its states, and end the process that it has of its own."""
        try:
            if self.instance is not None and not self.fatal:
                for pointer in list(self.states):
                    self.free_state(pointer)
                if self.stepping:
                    self.instance.terminate()
                self.instance.free()
        finally:
            self.instance = None
            self.stepping = False
            self.states.clear()
            if self.process is not None:
                self.process.close()
            self.process = None

    def close(self) -> None:
        """Free the instance, unload the library, remove the folder. Twice does no harm."""
        try:
            self.free_instance()
        finally:
            if self.library is not None and not self.fatal:
                unload(self.library)
            self.library = None
            if not self.twin:
                shutil.rmtree(self.folder, ignore_errors=True)
            elif self.copy is not None:
                self.copy.unlink(missing_ok=True)


def find_library(folder: Path, description: FmuDescription) -> Path:
    """Return the library for this machine in an unpacked FMU; FmuError where it has none."""
    name = description.model_identifier + _SUFFIX.get(platform.system(), ".so")
    folders = _folders(description.fmi_version)
    for candidate in folders:
        path = folder / "binaries" / candidate / name
        if path.is_file():
            return path
    remedy = "ask its maker for one"
    if description.has_sources:
        remedy = "compile its sources (with FMPy: fmpy compile FILE), or ask its maker for one"
    has = f"only for {', '.join(description.platforms)}" if description.platforms else "none at all"
    raise FmuError(
        f"{description.model_name} has no binary for this machine ({folders[0]}), {has}: {remedy}"
    )


def load_library(path: Path) -> ctypes.CDLL:
    """Return a library, loaded; its initialisers run."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise FmuError(
            f"the library {path.name} cannot be loaded ({error}): it is damaged, for another "
            "machine, or needs a library that is not installed"
        ) from None


def _folders(version: str) -> list[str]:
    system = platform.system()
    machine = _MACHINES.get(platform.machine(), platform.machine())
    if sys.maxsize < 2**32:
        machine = "x86"
    if version.startswith("3"):
        return [f"{machine}-{system.lower()}"]
    return _FOLDERS_FMI2.get((system, machine), [f"{machine}-{system.lower()}"])


def unload(library: ctypes.CDLL) -> None:
    """Unload a library; its finalisers run."""
    import _ctypes

    if sys.platform == "win32":
        _ctypes.FreeLibrary(library._handle)
    else:
        _ctypes.dlclose(library._handle)
