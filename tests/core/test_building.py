"""Building the core: compilers and headers that are missing, and zig in their place."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


def python(code, folder, **variables):
    """Run code where the build backend is found, and return what it prints."""
    path = os.pathsep.join([str(ROOT / "building"), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def without_compiler(tmp_path):
    """Return variables of an environment in which no C compiler is found."""
    empty = tmp_path / "bin"
    empty.mkdir()
    return {"PATH": str(empty), "CC": ""}


def test_zig_is_asked_for_where_there_is_no_compiler(tmp_path):
    code = "import compiler, backend; print(compiler.host_compiler(), backend._and_a_compiler([]))"
    assert python(code, tmp_path, **without_compiler(tmp_path)) == "None ['ziglang']\n"


def test_a_compiler_that_does_not_work_is_passed_over(tmp_path):
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    code = "import compiler; print(compiler._compiles(['cc']))"
    assert python(code, tmp_path, PATH=str(tmp_path)) == "False\n"


def test_missing_headers_of_python_are_named(tmp_path):
    code = (
        "import sysconfig, compiler\n"
        "from setuptools import Distribution\n"
        "sysconfig.get_path = lambda name: 'nowhere'\n"
        "try: compiler.BuildCore(Distribution()).build_extensions()\n"
        "except compiler.PlatformError as error: print(error)"
    )
    said = python(code, tmp_path)
    assert said.startswith("nowhere/Python.h is missing: install Python's headers")
    assert "apt-get install python3-dev" in said


@pytest.mark.parametrize("free_threaded", [False, True])
def test_a_python_without_lock_gets_no_stable_interface(free_threaded, tmp_path):
    code = (
        "import sysconfig\n"
        f"sysconfig.get_config_var = {{'Py_GIL_DISABLED': {int(free_threaded)}}}.get\n"
        "import compiler; core = compiler.core()\n"
        "print(core.py_limited_api, [name for name, _ in core.define_macros])"
    )
    expected = "False []" if free_threaded else "True ['Py_LIMITED_API']"
    assert python(code, tmp_path) == f"{expected}\n"


@pytest.mark.slow
@pytest.mark.skipif(os.environ.get("JOUNCE_TIER") != "slow", reason="zig is downloaded: slow tier")
def test_the_source_is_installed_where_there_is_no_compiler(tmp_path):
    code = f"import backend; print(backend.build_sdist({str(tmp_path)!r}))"
    name = python(code, ROOT).splitlines()[-1]
    target, call = tmp_path / "target", [sys.executable, "-m", "pip", "install", "--quiet"]
    subprocess.run(
        [*call, "--no-deps", "--target", target, tmp_path / name],
        cwd=tmp_path,
        env={**os.environ, **without_compiler(tmp_path)},
        check=True,
    )
    core = target / "jounce" / "core"
    assert (core / "jounce.h").exists()
    code = (
        "from importlib.util import module_from_spec, spec_from_file_location as of\n"
        f"spec = of('binding', {str(next(core.glob('binding.*.so')))!r})\n"
        "module = module_from_spec(spec); spec.loader.exec_module(module)\n"
        "print(module.transfer((0.0,), (1.0,), (-1.0, 1.0, -1.0, 1.0)).duration)"
    )
    assert float(python(code, tmp_path)) == 2.0


def test_every_file_of_the_core_is_in_its_unit():
    unit = (ROOT / "building" / "unit.c").read_text(encoding="utf-8")
    for path in (ROOT / "core").glob("*.c"):
        assert (f'"../core/{path.name}"' in unit) != path.name.startswith("binding")
