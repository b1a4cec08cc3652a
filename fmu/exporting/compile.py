"""Shared libraries from C sources: by the host's compiler, and for other platforms by zig."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from .sources import MAIN

_NO_RUNTIME = "no_runtime"
"""Folder of a stdlib.h for builds without C run-time library: FMI's headers include one."""

_FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared"]


@dataclass(frozen=True)
class Platform:
    """A platform for which an FMU may carry a binary."""

    target: str
    """zig's name of it."""
    suffix: str
    fmi2_folder: str
    flags: tuple[str, ...] = ("-fPIC", "-s")
    libraries: tuple[str, ...] = ()

    def folder(self, name: str, fmi_version: str) -> str:
        """Return the folder of its binary below binaries/."""
        return self.fmi2_folder if fmi_version == "2.0" else name


PLATFORMS = {
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", ".so", "linux64"),
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", ".so", "aarch64-linux"),
    "x86_64-windows": Platform(
        "x86_64-windows-gnu",
        ".dll",
        "win64",
        ("-s", "-nostdlib", "-fno-builtin", "-DNO_C_RUNTIME", f"-I{_NO_RUNTIME}"),
        ("-lkernel32",),
    ),
    "x86_64-darwin": Platform("x86_64-macos.11.0", ".dylib", "darwin64"),
    "aarch64-darwin": Platform("aarch64-macos.11.0", ".dylib", "aarch64-darwin"),
}
"""By FMI 3.0's name of the platform."""

ON_ITS_OWN = ("x86_64-linux", "x86_64-windows")
"""Platforms that are built without being asked for where zig is installed."""


class CompilerError(RuntimeError):
    """No compiler for a platform, or one that refused the sources."""


def host_platform() -> str:
    """Return the name of the platform on which this runs."""
    machine = platform.machine().lower().replace("amd64", "x86_64").replace("arm64", "aarch64")
    system = {"win32": "windows"}.get(sys.platform, sys.platform)
    return f"{machine}-{system}"


def host_compiler() -> list[str] | None:
    """Return the command of the host's C compiler: $CC, else cc, gcc or clang; None for none."""
    given = shlex.split(os.environ.get("CC", ""))
    for command in ([given] if given else []) + [["cc"], ["gcc"], ["clang"]]:
        found = shutil.which(command[0])
        if found is not None:
            return [found, *command[1:]]
    return None


def has_zig() -> bool:
    """Tell whether the package ziglang is installed."""
    return find_spec("ziglang") is not None


def available_platforms() -> list[str]:
    """Return the platforms that are built where none is named; none without a compiler."""
    host, found = host_platform(), []
    if host in PLATFORMS and (host_compiler() is not None or has_zig()):
        found.append(host)
    if has_zig():
        found += [name for name in ON_ITS_OWN if name not in found]
    return found


def build(sources: Mapping[str, bytes], name: str, target: str) -> bytes:
    """Return the shared library that the sources make on a platform.

    Parameters
    ----------
    sources : mapping
        Files by name, `MAIN` among them.
    name : str
        The library's name, without suffix.
    target : str
        One of `PLATFORMS`.

    Raises
    ------
    CompilerError
        Where there is no compiler for the platform, or it refuses the sources.

    Notes
    -----
    It works in a temporary folder, of which nothing is seen in the result: the same sources and
    compiler give the same bytes.
    """
    chosen = PLATFORMS[target]
    library = name + chosen.suffix
    command = [*_compiler(target), *_FLAGS, *chosen.flags, *_naming(chosen, library)]
    with TemporaryDirectory(prefix="jounce_fmu_") as folder:
        for file, text in sources.items():
            Path(folder, file).write_bytes(text)
        stub = Path(folder, _NO_RUNTIME, "stdlib.h")
        stub.parent.mkdir()
        stub.write_text("#include <stddef.h>\n", encoding="ascii")
        done = subprocess.run(
            [*command, "-o", library, MAIN, *chosen.libraries],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        if done.returncode != 0:
            raise CompilerError(
                f"{shlex.join(command)} failed for {target}:\n{done.stderr.strip()[-2000:]}"
            )
        return Path(folder, library).read_bytes()


def _compiler(target: str) -> list[str]:
    """Return the command that compiles for a platform."""
    host = host_compiler()
    if target == host_platform() and host is not None:
        return host
    if has_zig():
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[target].target]
    raise CompilerError(
        f"no C compiler for {target}: install the package ziglang (pip install ziglang)"
        + (", or a C compiler as cc" if target == host_platform() else "")
    )


def _naming(chosen: Platform, library: str) -> list[str]:
    """Return what keeps paths and random numbers out of the library."""
    if chosen.suffix == ".dylib":
        return [f"-Wl,-install_name,@rpath/{library}"]
    return ["-Wl,--build-id=none"] if chosen.suffix == ".so" else []
