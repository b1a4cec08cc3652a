"""What many commands take: a scenario, --set, --json, --quiet."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from . import cli
from .printing import be_quiet

SCENARIO = Annotated[
    Path, cli.Argument(help="Scenario file (TOML), see examples/; - is standard input.")
]

AS_JSON = Annotated[bool, cli.Option("--json", help="Print the numbers as JSON, no tables.")]

QUIET = Annotated[
    bool,
    cli.Option(
        "--quiet",
        "-q",
        help="Print errors and warnings alone, and JSON where that is asked for.",
        callback=be_quiet,
    ),
]

OVERRIDES = Annotated[
    list[str] | None,
    cli.Option(
        "--set",
        metavar="KEY=VALUE",
        help='In place of the file\'s, such as limits.axis.jerk="3 deg/s^3"; may be repeated.',
    ),
]
