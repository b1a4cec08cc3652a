"""Which scenario files are meant by names and glob patterns on a command line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from glob import glob
from pathlib import Path

_SUFFIXES = {".check.toml": "a check file", ".baseline.json": "a baseline"}


def scenario_files(arguments: Sequence[str]) -> list[Path]:
    """Return the scenario files of names and patterns, each once, patterns in sorted order.

    A pattern (``*``, ``?``, ``[ab]``, ``**`` for any depth) takes the TOML files that it matches,
    a name is taken as it is. Check files and baselines beside a scenario that is there are left
    out: a shell expands patterns to them, too.

    Raises
    ------
    ValueError
        For a pattern that matches no scenario file, and for a check file or a baseline whose
        scenario is not among the files.
    """
    found = list(dict.fromkeys(path for argument in arguments for path in _paths(argument)))
    scenarios = [path for path in found if not _suffix(path)]
    for path in found:
        suffix = _suffix(path)
        scenario = path.with_name(f"{path.name.removesuffix(suffix)}.toml")
        if suffix and scenario not in scenarios:
            raise ValueError(f"{path}: is {_SUFFIXES[suffix]}; name its scenario, {scenario}")
    return list({path.resolve(): path for path in reversed(scenarios)}.values())[::-1]


def _suffix(path: Path) -> str:
    """Return the end of a name by which a file is no scenario, or nothing."""
    return next((suffix for suffix in _SUFFIXES if path.name.endswith(suffix)), "")


def _paths(argument: str) -> Iterator[Path]:
    if Path(argument).exists() or not re.search(r"[*?\[]", argument):
        yield Path(argument)
        return
    paths = [Path(name) for name in sorted(glob(argument, recursive=True))]  # noqa: PTH207
    files = [path for path in paths if path.suffix == ".toml" and path.is_file()]
    if all(map(_suffix, files)):
        raise ValueError(
            f"{argument}: matches no scenario file (.toml); give a pattern that does, "
            "in quotation marks so that the shell leaves it alone"
        )
    yield from files
