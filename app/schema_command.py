"""The command `jounce schema`: the JSON schema of scenario files."""

from __future__ import annotations

from typing import Annotated

from . import cli
from .common_options import AS_JSON, QUIET
from .printing import print_text


def schema_command(
    number: Annotated[
        str,
        cli.Option("--format", metavar="INTEGER", help="Format of the scenario files: 2, or 1."),
    ] = "2",
    _: AS_JSON = False,
    __: QUIET = False,
) -> None:
    """Print the JSON schema of scenario files, by which editors complete and check keys."""
    from .scenario_schema import shipped_schema

    if not number.isdecimal():
        raise ValueError(f"--format {number!r}: expected 1 or 2, such as --format 2")
    print_text(shipped_schema(int(number)))
