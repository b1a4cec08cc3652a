"""Public names of the packages, their docstrings and the examples in them."""

import ast
import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import compiled_once
import pytest

binaries_compiled_once = compiled_once.binaries_compiled_once
ROOT = Path(__file__).parent.parent
PACKAGES = ("shaping", "plant", "fmu", "analysis", "plots", "app")
# Listed by glob: pkgutil.walk_packages finds nothing in a mapped editable install.
SOURCES = sorted(path for folder in ("jounce", *PACKAGES) for path in (ROOT / folder).rglob("*.py"))


def module_name(path: Path) -> str:
    """Return the import name of a source file."""
    inside = path.relative_to(ROOT).with_suffix("").parts
    parts = inside[1:] if inside[0] == "jounce" else inside
    return ".".join(("jounce", *(part for part in parts if part != "__init__")))


def test_all_folders_were_found():
    assert {path.relative_to(ROOT).parts[0] for path in SOURCES} == {"jounce", *PACKAGES}
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
        if inspect.isfunction(value):
            for part in ("Parameters", "Returns"):
                assert f"{part}\n---" in text.replace(" ", ""), f"{package}.{name}: no {part}"


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_only_export(package):
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), f"{package} has no docstring"
    for node in tree.body[1:]:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            assert all(isinstance(inner, ast.ImportFrom) for inner in node.body)
            continue
        later = ast.unparse(node) == "__getattr__, __dir__ = later(__name__, _LATER, __all__)"
        listed = isinstance(node, ast.FunctionDef) and node.name == "__dir__"
        table = isinstance(node, ast.Assign) and ast.unparse(node.targets[0])
        exports = table in ("__all__", "_LATER") or later or listed
        assert exports or isinstance(node, ast.Import | ast.ImportFrom), ast.unparse(node)


def test_what_is_imported_later_is_the_same_and_not_there_before():
    code = (
        "import sys, jounce.shaping as s; "
        "assert not any(n.startswith(('jounce.shaping.transfers', 'jounce.shaping.followers')) "
        "for n in sys.modules); "
        "assert sorted(s._LATER) == sorted(n for n in s.__all__ if n not in vars(s)); "
        "from jounce.shaping.transfers.problem import Transfer; assert s.Transfer is Transfer"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = importlib.import_module("jounce.shaping").nothing


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
