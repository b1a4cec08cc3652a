"""Check files: bounds and tolerances of a scenario's numbers, as TOML beside the scenario."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..scenario_messages import key_path
from ..text_files import read_toml
from ..units import show
from .numbers import Key, Number

_WHAT = "a check file (TOML)"
_KEYS = ("min", "max", "rtol", "atol", "sigmas")


class CheckError(ValueError):
    """A check file or a baseline cannot be used; its message has a line for each problem."""


@dataclass(frozen=True)
class Requirement:
    """What a check file asks of one number; what is None it does not say.

    `sigmas` is how many standard deviations a measured number has to be beyond a bound to fail,
    and within it to pass for sure.
    """

    least: float = -inf
    most: float = inf
    rtol: float | None = None
    atol: float | None = None
    sigmas: float | None = None

    def admits(self, value: float, sigma: float = 0.0) -> bool:
        """Whether a value may lie within the bounds; one that does not exist lies in none."""
        room = (self.sigmas or 0.0) * sigma
        unbounded = self.least == -inf and self.most == inf
        return unbounded or self.least - room <= value <= self.most + room

    def is_sure_of(self, value: float, sigma: float) -> bool:
        """Whether a value that is admitted lies within the bounds by as many deviations."""
        room = (self.sigmas or 0.0) * sigma
        return self.least + room <= value <= self.most - room or not room


@dataclass(frozen=True)
class Checks:
    """A check file: a relative tolerance for all numbers, and requirements of some.

    `rtol` is for numbers that have none of their own, here or in the baseline: it counts where a
    baseline is stored.
    """

    rtol: float | None = None
    requirements: Mapping[Key, Requirement] = field(default_factory=lambda: MappingProxyType({}))

    def of(self, key: Key) -> Requirement:
        """Return what is asked of a number."""
        return self.requirements.get(key, Requirement())


def with_bounds(checks: Checks, bounds: Mapping[Key, tuple[float, float]]) -> Checks:
    """Return checks that ask for bounds as well, such as those that the scenario requires."""
    asked = dict(checks.requirements)
    for key, (least, most) in bounds.items():
        own = checks.of(key)
        both = {"least": max(own.least, least), "most": min(own.most, most)}
        asked[key] = replace(own, **both)
    return Checks(checks.rtol, MappingProxyType(asked))


def load_checks(path: Path, numbers: Sequence[Number]) -> Checks:
    """Read a check file.

    Parameters
    ----------
    path : Path
        A TOML file laid out as ``examples/telescope.check.toml`` explains. At its top a number
        may be named by its last part alone, where only one number has that.
    numbers : sequence of Number
        Those that there are.

    Raises
    ------
    CheckError
        If the file cannot be read, or for what it says: a line for every problem, with the
        file, the key, the value, and what to write.
    """
    return checks_of(path, read_check_file(path), numbers)


def checks_of(path: Path, content: dict[str, Any], numbers: Sequence[Number]) -> Checks:
    """Return what a check file's content asks, as `load_checks` does; the content is changed."""
    if isinstance(content.get("baseline"), bool):
        del content["baseline"]
    problems: list[str] = []
    rtol = content.pop("rtol", None)
    if rtol is not None and (problem := _problem_of("rtol", rtol)):
        problems.append(f"rtol: {problem}")
    requirements: dict[Key, Requirement] = {}
    known = {number.key: number for number in numbers}
    bare = _bare(content, known, problems)
    for key, value in (*bare, *_leaves(content, (), known, problems)):
        found = _problems_of(known[key], value)
        if key in requirements:
            found.append("is given twice, by its whole and by its bare name; remove one")
        problems += [f"{key_path(key)}: {problem}" for problem in found]
        if not found:
            requirements[key] = _requirement(value)
    if problems:
        raise CheckError("\n".join(f"{path}: {problem}" for problem in problems))
    return Checks(None if rtol is None else float(rtol), MappingProxyType(requirements))


def read_check_file(path: Path) -> dict[str, Any]:
    """Return the content of a check file, unchecked.

    Raises
    ------
    CheckError
        If the file cannot be read or is no TOML.
    """
    try:
        return read_toml(path, _WHAT)
    except ValueError as error:
        raise CheckError(str(error)) from None


def wants_baseline(path: Path) -> bool:
    """Return whether a check file's scenario is to have a baseline: ``baseline = false`` has none.

    Raises
    ------
    CheckError
        If the file cannot be read, or says of `baseline` what is neither true nor false.
    """
    said = read_check_file(path).get("baseline", True)
    if isinstance(said, bool | dict):  # a table is what is asked of a number of that name
        return said is not False
    raise CheckError(
        f"{path}: baseline: {show(said)} is neither true nor false; write baseline = false where "
        "no numbers are stored, or leave it out"
    )


def _bare(
    content: dict[str, Any], known: Mapping[Key, Number], problems: list[str]
) -> list[tuple[Key, Any]]:
    """Take numbers named by their last part alone out of a content; note those of many numbers."""
    tables = {key[0] for key in known}
    found = []
    for name in [name for name in content if name not in tables]:
        named = [key for key in known if key[-1] == name]
        if len(named) == 1:
            found.append((named[0], content.pop(name)))
        elif named:
            paths = ", ".join(map(key_path, named))
            problems.append(f"{key_path([name])}: is ambiguous; write one of {paths}")
            del content[name]
    return found


def _leaves(
    table: Mapping[str, Any], where: Key, known: Mapping[Key, Number], problems: list[str]
) -> Iterator[tuple[Key, Any]]:
    """Yield what is said of each known number, problems noted for all else."""
    for name, value in table.items():
        key = (*where, name)
        if key in known:
            yield key, value
        elif not any(other[: len(key)] == key for other in known):
            problems.append(f"{key_path(key)}: {_unknown(key, known)}")
        elif isinstance(value, dict):
            yield from _leaves(value, key, known, problems)
        else:
            example = next(other for other in known if other[: len(key)] == key)
            problems.append(
                f"{key_path(key)}: {show(value)} is not a table; "
                f"write {key_path(example)} = {_example(known[example])}"
            )


def _unknown(key: Key, known: Mapping[Key, Number]) -> str:
    """Return what to say of a name that no number has."""
    depth = len(key)
    here = list(dict.fromkeys(k[depth - 1] for k in known if k[: depth - 1] == key[:-1]))
    bare = [k[-1] for k in known] if depth == 1 else []
    near = difflib.get_close_matches(key[-1], [*here, *bare], n=1)
    if near:
        guess = key_path((*key[:-1], near[0]))
    else:
        paths = [key_path(other) for other in known]
        guess = next(iter(difflib.get_close_matches(key_path(key), paths, n=1)), "")
    remedy = f"did you mean {guess}?" if guess else "remove it"
    return f"no number has this name; there are {', '.join(key_path([k]) for k in here)}; {remedy}"


def _problems_of(number: Number, value: object) -> list[str]:
    """Return what is wrong with what is said of a number."""
    if not isinstance(value, dict):
        return [f"{show(value)} is not a table; write {_example(number, value)}"]
    if not value:
        return [f"is empty; write {_example(number)}"]
    problems = []
    for name, entry in value.items():
        if name not in _KEYS:
            problems.append(f"{name} is not known; write some of {', '.join(_KEYS)}")
        elif problem := _problem_of(name, entry):
            problems.append(f"{name} = {problem}")
    if not problems and value.get("min", -inf) > value.get("max", inf):
        problems.append(
            f"min = {show(value['min'])} is above max = {show(value['max'])}; exchange them"
        )
    return problems


def _problem_of(name: str, value: object) -> str:
    """Return what is wrong with one number of a check file, or nothing."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{show(value)} is not a number; write it plain, in the unit of the number's name"
    try:
        finite = isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        return f"{show(value)} is not finite; write a finite number or leave {name} out"
    if name in ("rtol", "atol", "sigmas") and value < 0.0:
        return f"{show(value)} is below zero; write a tolerance such as 1e-6"
    return ""


def _requirement(value: Mapping[str, Any]) -> Requirement:
    numbers = {name: float(entry) for name, entry in value.items()}
    return Requirement(
        numbers.get("min", -inf),
        numbers.get("max", inf),
        numbers.get("rtol"),
        numbers.get("atol"),
        numbers.get("sigmas"),
    )


def _example(number: Number, said: object = None) -> str:
    """Return a bound to write: the number that was said, if any, or about what is measured."""
    bound = "min" if number.better == "higher" else "max"
    if not _problem_of(bound, said):
        return f"{{ {bound} = {said} }}"
    return f"{{ {bound} = {f'{number.value:.3g}' if isfinite(number.value) else '1'} }}"
