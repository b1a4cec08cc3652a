"""How the core in C is compiled: with the host's compiler where it works, else with zig's."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from setuptools import Extension
from setuptools.command.build_ext import build_ext
from setuptools.errors import PlatformError

FREE_THREADED = bool(sysconfig.get_config_var("Py_GIL_DISABLED"))
"""Whether this Python has no lock, and so no stable interface: its wheel is its own."""

ZIG = [sys.executable, "-m", "ziglang", "cc"]
FLAGS = [
    *("-std=c99", "-O3", "-ffp-contract=off", "-fvisibility=hidden", "-Icore"),
    "-fno-tree-slp-vectorize",  # numbers that were stored one by one would be waited for in pairs
]
STABLE = [] if FREE_THREADED else [("Py_LIMITED_API", "0x030B0000")]


def host_compiler() -> list[str] | None:
    """Return the command of the first C compiler that makes an object of a file, if any does."""
    named = (os.environ.get("CC"), sysconfig.get_config_var("CC"), "cc", "gcc", "clang")
    commands = [shlex.split(name) for name in named if name]
    return next((command for command in commands if _compiles(command)), None)


def _compiles(command: list[str]) -> bool:
    with TemporaryDirectory() as folder:
        source = Path(folder) / "trial.c"
        source.write_text("#include <string.h>\nint trial(void) { return 0; }\n")
        call = [*command, "-std=c99", "-c", str(source), "-o", str(source.with_suffix(".o"))]
        try:
            return subprocess.run(call, capture_output=True, check=False).returncode == 0
        except OSError:
            return False


def core() -> Extension:
    """Return the extension module jounce.core.binding."""
    return Extension(
        "jounce.core.binding",
        sources=["core/binding.c", "core/binding_fmi2.c", "building/unit.c"],
        depends=sorted(str(path) for path in Path("core").glob("*.[ch]")),
        extra_compile_args=FLAGS,
        define_macros=STABLE,
        py_limited_api=not FREE_THREADED,
    )


class BuildCore(build_ext):
    """Compile with a compiler that is there; where something is missing, say what to install."""

    def build_extensions(self) -> None:
        """Compile the extensions."""
        header = Path(sysconfig.get_path("include")) / "Python.h"
        if not header.exists():
            raise PlatformError(
                f"{header} is missing: install Python's headers, on Debian and Ubuntu "
                "`apt-get install python3-dev`, or install jounce from a wheel, which needs none"
            )
        command = host_compiler()
        if command is None and not find_spec("ziglang"):
            raise PlatformError("no C compiler: install gcc or clang, or `pip install ziglang`")
        self._use(command or ZIG)
        super().build_extensions()

    def _use(self, command: list[str]) -> None:
        shared = ["-bundle", "-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []
        self.compiler.set_executables(
            compiler=command,
            compiler_so=[*command, "-fPIC"],
            linker_so=[*command, *(shared or ["-shared"])],
        )
