"""Public names of the three packages, their docstrings and the examples in them."""

import ast
import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("shaping", "plant", "analysis")
# Listed by glob: pkgutil.walk_packages finds nothing in a mapped editable install.
SOURCES = sorted(path for folder in PACKAGES for path in (ROOT / folder).rglob("*.py"))


def module_name(path: Path) -> str:
    """Return the import name of a source file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(("jounce", *(part for part in parts if part != "__init__")))


def test_all_three_folders_were_found():
    assert {path.relative_to(ROOT).parts[0] for path in SOURCES} == set(PACKAGES)
    assert len(SOURCES) > len(PACKAGES)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_is_there_and_documented(package):
    module = importlib.import_module(f"jounce.{package}")
    assert module.__all__, f"{package} exports nothing"
    assert sorted(set(module.__all__)) == sorted(module.__all__), "a name is listed twice"
    for name in module.__all__:
        value = getattr(module, name)
        if inspect.ismodule(value) or callable(value):
            text = (value.__doc__ or "").strip()
            assert text, f"{package}.{name} has no docstring"
            assert not text.startswith(f"{name}("), f"{package}.{name} has a generated docstring"


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_only_export(package):
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), f"{package} has no docstring"
    for node in tree.body[1:]:
        exports = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
        assert exports or isinstance(node, ast.Import | ast.ImportFrom), ast.unparse(node)


def test_examples_in_docstrings_run():
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    results = {}
    for path in SOURCES:
        module = importlib.import_module(module_name(path))
        results[module.__name__] = doctest.testmod(module, optionflags=flags)
    failed = [name for name, result in results.items() if result.failed]
    assert not failed, f"run `python -m doctest` on {failed}"
    assert sum(result.attempted for result in results.values()) > 0


def test_importing_shaping_costs_no_more_than_numpy():
    code = (
        "import sys, jounce.shaping; "
        "print(*{name.split('.')[0] for name in sys.modules} & {'control', 'scipy', 'matplotlib'})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
