"""The namespace: a user's own folders of the same names do not get in the way."""

import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = ("shaping", "plant", "analysis")


def test_folders_of_the_users_own_are_not_imported(tmp_path):
    for name in PACKAGES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('the user’s own')")
    names = ", ".join(f"jounce.{name}" for name in PACKAGES)
    code = f"import {names}; print(jounce.analysis.loop_margins.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == "loop_margins", done.stderr


@pytest.mark.parametrize("name", PACKAGES)
def test_each_package_says_that_it_is_typed(name):
    assert (Path(__file__).parent.parent / name / "py.typed").exists()
