"""Build backend: setuptools, and zig's C compiler as a requirement where the host has none."""

from __future__ import annotations

from typing import Any

from compiler import host_compiler
from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403  (the hooks that stay as they are)

Settings = dict[str, Any] | None


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """Return what building a wheel needs."""
    return _and_a_compiler(build_meta.get_requires_for_build_wheel(config_settings))


def get_requires_for_build_editable(config_settings: Settings = None) -> list[str]:
    """Return what an editable installation needs."""
    return _and_a_compiler(build_meta.get_requires_for_build_editable(config_settings))


def _and_a_compiler(requirements: list[str]) -> list[str]:
    return requirements if host_compiler() else [*requirements, "ziglang"]
