"""The keys of a scenario file, and the words for a key or table that is not right."""

import difflib
import json
import re
import tomllib
from collections.abc import Sequence
from typing import Any

from .units import show

EXAMPLE = tomllib.loads("""
title = "Telescope axis"
position_unit = "arcsec"
plant.inertia = "1 kg m^2"
feedforward = {inertia = "1 kg m^2", error = "10 %"}
filter = {corner = "2 Hz", order = 6}
limits.axis.acceleration = "0.2 deg/s^2"
[controller]
specification = {crossover = "1 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
gains = {kp = "3 N m/rad", ki = "2 N m/(rad s)", kr = "5 N m s/rad"}
[[modes]]
name = "tower"
frequency = "12 Hz"
damping = "2 %"
[[moves]]
name = "60 arcsec step"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
""")
"""Every key once: what is known, and what to write where something is missing."""


def problem_line(error: Any) -> str:
    """Return one of pydantic's findings in our own words."""
    where, kind, value = error["loc"], error["type"], error["input"]
    section = tuple(part for part in where if isinstance(part, str))
    if kind == "value_error":
        problem = str(error["ctx"]["error"])
    elif kind == "missing":
        problem = f"is missing; write {what_to_write(*section)}"
    elif kind in ("extra_forbidden", "unexpected_keyword_argument"):
        problem = unknown_key(section[-1], value, tuple(_known(section[:-1])[1]))
    else:
        shown = "is empty" if value == {} else f"{show(value)} is not a table"
        problem = f"{shown}; write {what_to_write(*section)}"
    return f"{key_path(where)}: {problem}"


def unknown_key(
    key: str, value: object, known: Sequence[str], *, shown: Sequence[str] | None = None
) -> str:
    """Return what to say of a key that is not among the known ones."""
    near = difflib.get_close_matches(key, known, n=1)
    remedy = f"did you mean {near[0]}?" if near else "remove it"
    return f"unknown key (with {show(value)}); accepted: {', '.join(shown or known)}; {remedy}"


def key_path(where: Sequence[str | int]) -> str:
    """Return a key as TOML writes it: ``moves."60 arcsec step".duration_s``."""
    text = ""
    for part in where:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += "." + (part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else _quoted(part))
    return text.removeprefix(".")


def _quoted(key: str) -> str:
    return json.dumps(key, ensure_ascii=not key.isprintable())


def _known(where: Sequence[str]) -> tuple[str, Any]:
    """Return an example's path and value; any name of a set of limits leads to the example's."""
    path, value = [], EXAMPLE
    for key in where:
        path.append(key if key in value else next(iter(value)))
        value = value[path[-1]]
        value = value[0] if isinstance(value, list) else value
    return ".".join(path), value


def what_to_write(*where: str) -> str:
    """Return what to write for a key."""
    path, value = _known(where)
    if not isinstance(value, dict):
        return f"{where[-1]} = {json.dumps(value)}"
    key, first = next(iter(value.items()))
    if isinstance(first, dict):
        return what_to_write(*where, key)
    header = f"[[{path}]]" if isinstance(EXAMPLE.get(path), list) else f"[{path}]"
    return f"{header} with {', '.join(value)}"
