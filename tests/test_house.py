"""The house: no name hides a file, and each algorithm has one file that is named once."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("core", "shaping", "plant", "fmu", "analysis", "plots", "app")
PACKAGES = sorted(
    path.parent.relative_to(ROOT)
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("__init__.py")
    if path.parent.name != "plugin"  # imported under another name
)


def importable(package):
    return f"jounce.{'.'.join(package.parts)}"


@pytest.mark.parametrize("package", PACKAGES, ids=str)
def test_no_name_that_a_package_exports_hides_one_of_its_files(package):
    """`jounce.plant.respond` is a function or a file, never one in front of the other."""
    inside = {path.stem for path in (ROOT / package).glob("*.py")}
    inside |= {path.parent.name for path in (ROOT / package).glob("*/__init__.py")}
    exported = getattr(importlib.import_module(importable(package)), "__all__", [])
    assert inside.isdisjoint(exported), inside.intersection(exported)


def test_the_check_sees_the_packages_and_their_names():
    assert Path("analysis/frequency_view") in PACKAGES
    analysis = importlib.import_module("jounce.analysis")
    assert {"survey", "conformance"} <= set(analysis.__all__)


def test_each_algorithm_has_one_file_and_each_file_one_row():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.+?) \| \[`(.+?)`\]\(\.\./(.+?)\) \|$", text, re.MULTILINE)
    algorithms, shown, linked = zip(*rows, strict=True)
    assert len(rows) > 40
    assert shown == linked
    assert len(set(algorithms)) == len(set(shown)) == len(rows)
    assert [name for name in shown if not (ROOT / name).is_file()] == []
