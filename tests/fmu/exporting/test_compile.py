"""Compilers: the host's, and zig for other platforms."""

import hashlib

import pytest
from every_block import BLOCKS
from fmus import SLOW, needs_compiler

from jounce.fmu import CompilerError
from jounce.fmu.exporting import compile
from jounce.fmu.exporting.compile import PLATFORMS, build, has_zig, host_compiler, host_platform
from jounce.fmu.exporting.dispatch import block_of
from jounce.fmu.exporting.sources import MAIN, sources_of

needs_zig = pytest.mark.skipif(not has_zig(), reason="the package ziglang is not installed")
MAGIC = {".so": b"\x7fELF", ".dll": b"MZ", ".dylib": b"\xcf\xfa\xed\xfe"}


@needs_compiler
def test_what_the_compiler_says_is_told():
    with pytest.raises(CompilerError, match=r"failed for .*\n(.*\n)*.*expected"):
        build({MAIN: b"int f( {"}, "wrong", host_platform())


def test_the_users_choice_of_compiler_comes_first(monkeypatch, tmp_path):
    chosen = tmp_path / "mycc"
    chosen.write_text("#!/bin/sh\n")
    chosen.chmod(0o755)
    monkeypatch.setenv("CC", f"{chosen} -m64")
    assert host_compiler() == [str(chosen), "-m64"]
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert host_compiler() is None


def test_without_a_compiler_nothing_is_built(monkeypatch):
    monkeypatch.setattr(compile, "host_compiler", lambda: None)
    monkeypatch.setattr(compile, "has_zig", lambda: False)
    assert compile.available_platforms() == []
    monkeypatch.setattr(compile, "has_zig", lambda: True)
    assert {"x86_64-linux", "x86_64-windows"} <= set(compile.available_platforms())


@pytest.mark.slow
@needs_zig
@pytest.mark.parametrize("version", ["2.0", "3.0"] if SLOW else ["3.0"])
@pytest.mark.parametrize("platform", PLATFORMS if SLOW else ["x86_64-windows"])
def test_zig_builds_every_platform(platform, version, monkeypatch):
    monkeypatch.setattr(compile, "host_compiler", lambda: None)
    sources = sources_of(block_of(BLOCKS["filtered_follower"]()), version, "{token}")
    first, again = (build(sources, "follower", platform) for _ in range(2))
    assert hashlib.sha256(first).digest() == hashlib.sha256(again).digest()
    assert first.startswith(MAGIC[PLATFORMS[platform].suffix])
    assert b"fmi" + version[:1].encode() + b"DoStep" in first
    assert b"jounce_fmu_" not in first
