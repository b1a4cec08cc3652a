"""Regenerate the parts of the documentation that are measured or listed, not written.

Run: python docs/readme.py tree precision robustness picture benchmarks   (any; or `make readme`)
"""

from __future__ import annotations

import ast
import importlib
import platform
import re
import sys
import tomllib
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGES = {
    "tree": ROOT / "docs" / "tree.md",
    "precision": ROOT / "docs" / "precision.md",
    "robustness": ROOT / "docs" / "precision.md",
    "benchmarks": ROOT / "docs" / "benchmarks.md",
}
FOLDERS = [
    *("jounce", "core", "shaping", "plant", "fmu", "analysis", "plots", "app", "building"),
    *("examples", "notebooks", "benchmarks", "docs", "tests"),
]


def replace_part(name: str, text: str) -> None:
    """Replace what stands between the marks of a part on its page."""
    page = PAGES[name]
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    whole = page.read_text(encoding="utf-8")
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    replaced, count = pattern.subn(lambda _: f"{begin}\n{text}\n{end}", whole)
    if count != 1:
        raise ValueError(f"{page.name} has {count} parts named {name!r}: expected one")
    page.write_text(replaced, encoding="utf-8")


def tree() -> str:
    """Return the tree map: every source file with the first line of its docstring."""
    lines = []
    for folder in FOLDERS:
        lines.append((f"{folder}/", _about_folder(folder)))
        lines += _files(ROOT / folder, "  ")
        lines += _packages(ROOT / folder, "  ")
    width = max(len(name) for name, _ in lines) + 2
    return "\n".join(["```", *(f"{name:{width}s}{about}" for name, about in lines), "```"])


def _packages(folder: Path, indent: str) -> list[tuple[str, str]]:
    lines = []
    for inner in sorted(path.parent for path in folder.glob("*/__init__.py")):
        lines.append((f"{indent}{inner.name}/", _first_line(inner / "__init__.py")))
        lines += _files(inner, indent + "  ") + _packages(inner, indent + "  ")
    return lines


def _files(folder: Path, indent: str) -> list[tuple[str, str]]:
    files = sorted(p for p in folder.glob("*") if p.suffix in (".py", ".toml", ".c", ".h"))
    return [(f"{indent}{p.name}", about) for p in files if (about := _about_file(p))]


def _about_folder(folder: str) -> str:
    package = ROOT / folder / "__init__.py"
    if package.exists():
        return _first_line(package)
    return {
        "building": "how the core in C is compiled when jounce is installed",
        "examples": "scenario files",
        "notebooks": "percent scripts, each paired with an output-free .ipynb",
        "benchmarks": "side by side with peers in one run",
        "docs": "pages with their pictures and generated parts",
        "tests": "one test_<file>.py per source file, in folders of the same names",
    }[folder]


def _about_file(path: Path) -> str:
    if path.name == "__init__.py":
        return ""
    if path.suffix == ".toml":
        text = path.read_text(encoding="utf-8")
        return str(tomllib.loads(text).get("title") or text.partition("\n")[0].lstrip("# "))
    if path.suffix in (".c", ".h"):
        return path.read_text(encoding="utf-8").partition("\n")[0].strip("/* ")
    if path.parent.name == "notebooks":
        heading = re.search(r"^# # (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        return heading.group(1) if heading else ""
    return _first_line(path)


def _first_line(path: Path) -> str:
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.splitlines()[0] if text else ""


def precision() -> str:
    """Return the precision table, promised beside measured."""
    sys.path.insert(0, str(ROOT / "docs"))
    return str(importlib.import_module("precision").table())


def robustness() -> str:
    """Return the counts of the edge grid."""
    sys.path.insert(0, str(ROOT / "docs"))
    return str(importlib.import_module("robustness").table())


def benchmarks() -> str:
    """Return the tables of every benchmark, with date and machine."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    timing = importlib.import_module("timing")
    parts = [f"Measured {datetime.now(UTC):%Y-%m-%d} on {_machine()}; medians of one run."]
    for name in (
        "evaluation",
        "design",
        "minimum_time",
        "symmetric_moves",
        "against_peers",
        "moves",
        "transfers",
        "through",
        "following",
        "response",
        "loops",
        "sweeps",
        "margins",
        "explorer",
        "measured",
        "fmu",
        "startup",
    ):
        module = importlib.import_module(name)
        title, *notes = str(module.__doc__).strip().split("\n\n")
        parts.append(f"**{title}** (`benchmarks/{name}.py`)")
        parts += [note for note in notes if not note.startswith("Run:")]
        parts.append(timing.table(module.HEADER, module.rows()))
    return "\n\n".join(parts)


def _machine() -> str:
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        found = re.search(r"model name\s*:\s*(.*)", cpuinfo.read_text(encoding="utf-8"))
        model = found.group(1) if found else model
    return f"{model}, Python {platform.python_version()}"


def picture() -> None:
    """Draw the survey of the telescope for the README, in a palette to keep the file small."""
    from PIL import Image

    from jounce.app import survey_file

    path = ROOT / "docs" / "survey.png"
    survey_file(ROOT / "examples" / "telescope.toml").plot().savefig(path, dpi=80)
    Image.open(path).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(
        path, optimize=True
    )


def main(parts: list[str]) -> None:
    """Regenerate the parts named."""
    makers = {
        "tree": tree,
        "precision": precision,
        "robustness": robustness,
        "benchmarks": benchmarks,
    }
    unknown = set(parts) - {*makers, "picture"}
    if unknown or not parts:
        raise SystemExit(f"expected some of: {', '.join([*makers, 'picture'])}; got {parts}")
    for part in parts:
        if part == "picture":
            picture()
        else:
            replace_part(part, makers[part]())


if __name__ == "__main__":
    main(sys.argv[1:])
