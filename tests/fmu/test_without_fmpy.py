"""Without fmpy everything works but what takes FMI's headers out of it."""

import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import jounce
from jounce.fmu import export_fmu
from jounce.plant import Inertia

BLOCKED = """
import sys
for name in ("fmpy", "pytest_regressions", "pandas", "pint", "h5py"):
    sys.modules[name] = None
from importlib import import_module
for name in {names!r}:
    import_module(name)
from jounce.analysis import loop_margins
from jounce.plant import PID, Inertia, ServoLoop
print(round(loop_margins(ServoLoop(Inertia(1.0), PID(28.0, 38.0, 5.4))).phase_margin_deg))
"""
NEEDS_ONE = {"jounce.app.gate.margins_regression", "jounce.pytest_plugin"}


def test_no_module_imports_fmpy():
    packages = ("core", "shaping", "plant", "fmu", "analysis", "plots", "app")
    folders = [Path(jounce.__file__).parents[1] / name for name in packages]
    files = [file for folder in folders for file in folder.rglob("*.py")]
    assert len(files) > 200
    for file in files:
        assert not re.search(r"^\s*(import|from) fmpy", file.read_text(encoding="utf-8"), re.M), (
            file
        )


@pytest.mark.slow
def test_every_module_works_without_it():
    names = {
        found.name
        for package in ("shaping", "plant", "fmu", "analysis", "plots", "app")
        for found in pkgutil.walk_packages(getattr(jounce, package).__path__, f"jounce.{package}.")
    }
    code = BLOCKED.format(names=sorted(names - NEEDS_ONE))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()) == (0, ["45"]), done.stderr


def test_an_export_says_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fmpy", None)
    with pytest.raises(ModuleNotFoundError, match="pip install fmpy"):
        export_fmu(Inertia(2.0), tmp_path / "plant.fmu")
