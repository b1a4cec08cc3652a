"""What else to read about a public name: names near to it, and pages that use it."""

from __future__ import annotations

import functools
import importlib
import inspect
import itertools
import re
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from reference_pages import PACKAGES

PAGES = ("tutorials", "how-to", "explanation")
MOST = 6  # names, and pages


def see_also(path: str) -> list[str]:
    """Return the lines that lead on from the public name at `path`, as `jounce.plant.PID`."""
    package, name = path.rsplit(".", 1)
    if public_names().get(name) != package:
        return []
    names = [f":py:obj:`~{public_names()[near]}.{near}`" for near in _nearest(name, neighbours())]
    pages = [f":doc:`/{page}`" for page in _nearest(name, users())]
    found = [", ".join(each) for each in (names, pages) if each]
    return ["", ".. seealso::", "", *(f"   {each}" + "\n" for each in found)] if found else []


def _nearest(name: str, related: Mapping[str, set[str]]) -> list[str]:
    """Return a few of those related to `name`; who is related to fewer others is nearer."""
    others = Counter(itertools.chain.from_iterable(related.values()))
    return sorted(related[name], key=lambda one: (others[one], one))[:MOST]


@functools.cache
def public_names() -> dict[str, str]:
    """Return the package of each public name."""
    modules = [importlib.import_module(f"jounce.{package}") for package in PACKAGES]
    return {name: module.__name__ for module in modules for name in module.__all__}


@functools.cache
def neighbours() -> dict[str, set[str]]:
    """Return for each public name those that it takes, returns or tells of, and the reverse."""
    found: dict[str, set[str]] = {name: set() for name in public_names()}
    things = {name: getattr(sys.modules[of], name) for name, of in public_names().items()}
    for name in found:
        for other in _told(things[name]) & found.keys() - {name}:
            found[name].add(other)
            found[other].add(name)
    for name in [each for each in found if not found[each]]:  # what stands in the same file
        of = things[name].__module__
        found[name] = {near for near in found if getattr(things[near], "__module__", "") == of}
        found[name].discard(name)
    return found


def _told(thing: object) -> set[str]:
    """Return the words of a thing's signature, and those of its docstring that are code."""
    try:
        signature = str(inspect.signature(thing))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        signature = ""
    return set(re.findall(r"\w+", signature)) | _words(inspect.getdoc(thing) or "")


@functools.cache
def users() -> dict[str, set[str]]:
    """Return for each public name the pages on which it stands."""
    folder = Path(__file__).parent
    pages = {
        f"{part}/{page.stem}": _words(page.read_text(encoding="utf-8"))
        for part in PAGES
        for page in (folder / part).glob("*.md")
    }
    return {name: {page for page in pages if name in pages[page]} for name in public_names()}


def _words(text: str) -> set[str]:
    """Return the words that are code: with _ or two capitals, in a call, between backticks."""
    code = r"\b[A-Za-z]+_\w+|\b[A-Z]\w*[A-Z]\w*|\b\w+(?=\()|(?<=`)\w+(?=`)"
    return set(re.findall(code, text))
