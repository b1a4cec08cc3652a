"""Write the pages of the reference: public names, the command line, the keys of scenario files."""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

PACKAGES = {
    "shaping": "commands with bounded derivatives",
    "plant": "axes, controllers and loops",
    "analysis": "margins, surveys, measurements",
    "fmu": "FMUs in and out",
    "plots": "pictures",
    "app": "scenario files",
}


def write_reference_pages(folder: Path) -> None:
    """Write into `folder` one page a package, one of all commands, one of the scenario's keys."""
    for package, about in PACKAGES.items():
        (folder / f"{package}.rst").write_text(_package_page(package, about), encoding="utf-8")
    (folder / "command-line.md").write_text(command_line_page(), encoding="utf-8")
    (folder / "scenario-schema.md").write_text(schema_page(), encoding="utf-8")


def _package_page(package: str, about: str) -> str:
    module = importlib.import_module(f"jounce.{package}")
    heading = f"jounce.{package}: {about}"
    names = "\n".join(f"   {name}" for name in sorted(module.__all__, key=str.lower))
    return f"""\
{heading}
{"=" * len(heading)}

{(module.__doc__ or "").strip()}

.. currentmodule:: jounce.{package}

.. autosummary::
   :toctree: generated
   :nosignatures:

{names}
"""


def command_line_page() -> str:
    """Return the page of every command with its arguments and options."""
    from jounce.app.cli import Command, all_commands
    from jounce.app.command_line import app

    commands = [each for each in all_commands(app) if isinstance(each, Command)]
    return "\n".join(
        [
            "# Command line",
            "",
            "Exit status: 0 done, 1 a check failed (a regression, an unstable loop), 2 bad input,",
            "told in one line a mistake. Quantities are text with a unit.",
            "",
            *map(_command, commands),
        ]
    )


def _command(command: Any) -> str:
    places = " ".join(each.metavar for each in command.parameters if not each.names)
    rows = [_row(each) for each in command.parameters]
    table = ["| | |", "| --- | --- |", *rows, ""] if rows else []
    called = f"    {command.path} {places}"
    return "\n".join([f"## {command.path}", "", _prose(command.help), "", called, "", *table])


def _row(parameter: Any) -> str:
    names = ", ".join(f"`{name}`" for name in (*parameter.names, *parameter.off))
    told = _prose(parameter.told.help).replace("|", "\\|")
    default = parameter.default
    shown = f" Default: `{default}`." if isinstance(default, (str, int, float)) and default else ""
    return f"| {names or f'`{parameter.metavar}`'} | {told}{shown} |"


def _prose(text: str | None) -> str:
    """Return help as a paragraph; what it marks for the terminal is left out."""
    told = " ".join((text or "").split()).replace("\b", "")
    return re.sub(r"([<$*_\[])", r"\\\1", told)


def schema_page() -> str:
    """Return the page of every key of a scenario file of format 2, from its schema."""
    from jounce import app

    path = Path(app.__file__).parent / "scenario_2.schema.json"
    schema = json.loads(path.read_text(encoding="utf-8"))
    lines = [
        "# Keys of a scenario file",
        "",
        "Generated from the JSON schema that `jounce schema` prints; what each part is for",
        "stands in [scenario files](../scenarios.md).",
        "",
    ]
    for name, part in [("The file", schema), *sorted(schema.get("$defs", {}).items())]:
        if "properties" in part:
            lines += [
                f"## {_plain(name)}",
                "",
                _prose(part.get("description")),
                "",
                *_keys(part),
                "",
            ]
    return "\n".join(lines)


def _plain(name: str) -> str:
    """Return the name of a part without what it is called by inside."""
    return re.sub(r"^_|(Section|Of2)$", "", name)


def _keys(part: dict[str, Any]) -> Iterator[str]:
    required = set(part.get("required", ()))
    yield "| key | value | |"
    yield "| --- | --- | --- |"
    for key, value in part["properties"].items():
        told = _prose(value.get("description")).replace("|", "\\|")
        needed = "required. " if key in required else ""
        yield f"| `{key}` | {_kind(value)} | {needed}{told} |"


def _kind(value: dict[str, Any]) -> str:
    if "$ref" in value:
        return _plain(value["$ref"].rsplit("/", 1)[1])
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return " or ".join(f"`{json.dumps(item)}`" for item in value["enum"])
    for several in ("anyOf", "oneOf", "allOf"):
        if several in value:
            return " or ".join(dict.fromkeys(_kind(one) for one in value[several]))
    if value.get("type") == "array":
        items = value.get("items", {})
        return f"list of {_kind(items)}" if items else "list"
    if value.get("type") == "object":
        items = value.get("additionalProperties")
        return f"table of {_kind(items)}" if isinstance(items, dict) and items else "table"
    return str(value.get("type", "any"))
