"""Baselines: every number of a scenario with its tolerance and conditions, stored as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ...shaping.frozen import Frozen
from ..scenario_messages import key_path
from ..text_files import read_json
from ..units import UnitError, conversion, show
from .check_file import CheckError
from .conditions import Conditions
from .numbers import Key, is_position

FORMAT = 1
"""Number of the layout, kept in the file under "jounce_baseline"."""

_WHAT = "a baseline (JSON)"
_UPDATE = "--update"


@dataclass(frozen=True)
class Stored:
    """A number of a baseline: its value, None where it does not exist, and its tolerance.

    `sigma` is the standard deviation of one that was measured.
    """

    value: float | None
    rtol: float
    atol: float
    sigma: float = 0.0


@dataclass(frozen=True)
class Baseline(Frozen):
    """The numbers of a scenario, or of a loop alone, whose `scenario` and unit are None.

    `conditions` are what the numbers depend on; None in the file of a version that stored none.
    """

    scenario: str | None
    position_unit: str | None
    numbers: Mapping[Key, Stored]
    conditions: Conditions | None = None

    def text(self) -> str:
        """Return the file's text: keys sorted, a line for each number, floats in full precision."""
        content = {
            "jounce_baseline": FORMAT,
            "scenario": self.scenario,
            "position_unit": self.position_unit,
            "numbers": _tree(self.numbers),
        }
        if self.conditions is not None:
            content["conditions"] = _tree(self.conditions)
        return _json(content) + "\n"

    def write(self, path: Path) -> None:
        """Write the file's text, with line feeds on every platform."""
        path.write_bytes(self.text().encode("utf-8"))


def load_baseline(path: Path, *, anew: str = _UPDATE) -> Baseline:
    """Read a baseline.

    Parameters
    ----------
    path : Path
        The file.
    anew : str, optional
        What stores a baseline, for messages.

    Raises
    ------
    CheckError
        If the file cannot be read or is no baseline: a line for every problem.
    """
    remedy = _remedy(anew)
    try:
        content = read_json(path, _WHAT)
    except ValueError as error:
        other = remedy if path.is_file() else f"store one with {anew}"
        raise CheckError(f"{error}, or {other}") from None
    _refuse_other_files(path, content, remedy)
    problems: list[str] = []
    names = [content.get(key) for key in ("scenario", "position_unit")]
    for key, name in zip(("scenario", "position_unit"), names, strict=True):
        if name is not None and not isinstance(name, str):
            problems.append(f"{key}: {show(name)} is not text")
    numbers: dict[Key, Stored] = {}
    for where, entry in _entries(content.get("numbers"), ("numbers",), problems):
        problem = _problem_of(entry)
        if problem:
            problems.append(f"{key_path(where)}: {problem}")
        else:
            value = None if entry["value"] is None else float(entry["value"])
            sizes = (float(entry.get(name, 0.0)) for name in ("rtol", "atol", "sigma"))
            numbers[where[1:]] = Stored(value, *sizes)
    if not problems and not numbers:
        problems.append("numbers: holds none")
    conditions = None
    if "conditions" in content:
        texts = _texts(content["conditions"], ("conditions",), problems)
        conditions = MappingProxyType({where[1:]: text for where, text in texts})
    if problems:
        raise CheckError("\n".join(f"{path}: {problem}; {remedy}" for problem in problems))
    return Baseline(names[0], names[1], MappingProxyType(numbers), conditions)


def in_unit(stored: Baseline, unit: str | None) -> Baseline:
    """Return a baseline with positions in a unit; as it is, where it has another kind of unit."""
    if unit is None or stored.position_unit in (None, unit):
        return stored
    try:
        ratio = conversion(str(stored.position_unit), unit)
    except UnitError:
        return stored
    numbers = {
        key: _times(entry, ratio if is_position(key) else 1.0)
        for key, entry in stored.numbers.items()
    }
    return replace(stored, position_unit=unit, numbers=MappingProxyType(numbers))


def _times(stored: Stored, ratio: float) -> Stored:
    value = None if stored.value is None else stored.value * ratio
    return Stored(value, stored.rtol, stored.atol * ratio, stored.sigma * ratio)


def check_origin(stored: Baseline, path: Path, scenario: str, unit: str) -> None:
    """Refuse a baseline of another scenario, or one in another unit."""
    if stored.scenario != scenario:
        whose = "a loop alone" if stored.scenario is None else show(stored.scenario)
        raise CheckError(
            f"{path}: is the baseline of {whose}, not of {show(scenario)}; name another file, "
            f"or {_remedy(_UPDATE)}"
        )
    if stored.position_unit != unit:
        raise CheckError(
            f"{path}: is in {show(stored.position_unit)}, the scenario in {show(unit)}; "
            f"{_remedy(_UPDATE)}"
        )


def stored_conditions(stored: Baseline, path: Path) -> Conditions:
    """Return a baseline's conditions; CheckError for one that was stored without them."""
    if stored.conditions is None:
        raise CheckError(
            f"{path}: was stored without the conditions of its numbers, so that none can be "
            f"compared; see that the scenario asks what it should, and store it anew with {_UPDATE}"
        )
    return stored.conditions


def _tree(values: Mapping[Key, object]) -> dict[str, Any]:
    """Return values by key as tables within tables."""
    tree: dict[str, Any] = {}
    for key, value in values.items():
        branch = tree
        for part in key[:-1]:
            branch = branch.setdefault(part, {})
        branch[key[-1]] = value
    return tree


def _texts(value: object, where: Key, problems: list[str]) -> Iterator[tuple[Key, str]]:
    """Yield the conditions: texts in tables within tables."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _texts(inner, (*where, name), problems)
    elif isinstance(value, str) and len(where) > 1:
        yield where, value
    else:
        accepted = "text" if len(where) > 1 else "a table"
        problems.append(f"{key_path(where)}: {show(value)} is not {accepted}")


def _remedy(anew: str) -> str:
    return f"delete the file and store anew with {anew}"


def _json(value: object, indent: str = "\n") -> str:
    """Return sorted JSON, a stored number on a line of its own."""
    if isinstance(value, Stored):
        measured = {"sigma": value.sigma} if value.sigma else {}
        value = {"atol": value.atol, "rtol": value.rtol, "value": value.value} | measured
    elif isinstance(value, dict) and value:
        inner = indent + "  "
        entries = [f"{_json(name)}: {_json(value[name], inner)}" for name in sorted(value)]
        return f"{{{inner}{f',{inner}'.join(entries)}{indent}}}"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _refuse_other_files(path: Path, content: object, remedy: str) -> None:
    if not isinstance(content, dict) or "jounce_baseline" not in content:
        raise CheckError(f"{path}: is no baseline; name {_WHAT}, or {remedy}")
    layout = content["jounce_baseline"]
    if layout is True or layout != FORMAT:
        raise CheckError(
            f"{path}: jounce_baseline: {show(layout)} is a layout that this version does not "
            f"know, it reads {FORMAT}; use the version that wrote it, or {remedy}"
        )


def _entries(
    table: object, where: Key, problems: list[str]
) -> Iterator[tuple[Key, dict[str, Any]]]:
    """Yield what stands for each number: a table without tables."""
    if not isinstance(table, dict):
        problems.append(f"{key_path(where)}: {show(table)} is not a table")
        return
    for name, value in table.items():
        if isinstance(value, dict) and any(isinstance(entry, dict) for entry in value.values()):
            yield from _entries(value, (*where, name), problems)
        elif isinstance(value, dict):
            yield (*where, name), value
        else:
            problems.append(f"{key_path((*where, name))}: {show(value)} is not a table")


def _problem_of(entry: Mapping[str, Any]) -> str:
    """Return what is wrong with what stands for a number, or nothing."""
    for name in ("value", "rtol", "atol"):
        if name not in entry:
            return f"{name} is missing"
        value = entry[name]
        if value is None and name == "value":
            continue
        if not _is_finite(value) or (name != "value" and value < 0.0):
            accepted = "a finite number" if name == "value" else "a number not below zero"
            return f"{name} = {show(value)} is not {accepted}"
    sigma = entry.get("sigma", 0.0)
    if not _is_finite(sigma) or sigma < 0.0:
        return f"sigma = {show(sigma)} is not a number not below zero"
    unknown = sorted(set(entry) - {"value", "rtol", "atol", "sigma"})
    return f"{show(unknown[0])} is not known" if unknown else ""


def _is_finite(value: object) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, int | float) and isfinite(value)
    except OverflowError:
        return False
