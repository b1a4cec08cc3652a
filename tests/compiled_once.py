"""Binaries of FMUs that tests export: compiled strictly, once for all workers, soon in short."""

import hashlib
import os
from pathlib import Path

import pytest
from tiers import SLOW

from jounce.fmu.exporting import compile, export
from jounce.fmu.exporting.c_texts import WARNINGS

STRICT = [*WARNINGS.split(), "-Werror"]


def strictly(flags):
    """Return flags that take warnings as errors; not to optimise takes a fifth of the time."""
    return [*(flag if SLOW else flag.replace("-O2", "-O0") for flag in flags), *STRICT]


def builder(shared: Path):
    """Return compile.build that keeps what the host's compiler has made in a folder."""

    def build(sources, name, target):
        if target != compile.host_platform() or compile.host_compiler() is None:
            return compile.build(sources, name, target)
        flags = strictly(compile._FLAGS)
        made_of = compile.host_compiler(), flags, name, sorted(sources.items())
        kept = shared / hashlib.sha256(repr(made_of).encode()).hexdigest()
        if not kept.exists():
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(compile, "_FLAGS", flags)
                binary = compile.build(sources, name, target)
            own = kept.with_suffix(f".{os.getpid()}")
            own.write_bytes(binary)
            own.replace(kept)
        return kept.read_bytes()

    return build


@pytest.fixture(scope="session", autouse=True)
def binaries_compiled_once(tmp_path_factory):
    """Export with the builder, whose folder is that of all workers of this run."""
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "compiled_once"
    shared.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(export, "build", builder(shared))
        yield
