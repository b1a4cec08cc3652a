"""Requirements as a table: what is asked, what is achieved, the verdict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.table import Table
from rich.text import Text

from .requirement_checks import RequirementCheck
from .specification import Labels
from .tables import plain_table


def requirements_table(checks: Sequence[RequirementCheck], labels: Labels) -> Iterator[Table]:
    """Yield the table, if there is anything in it."""
    if not checks:
        return
    table = plain_table("Requirements", "", "asked", "achieved", "")
    for check in checks:
        asked, achieved, verdict = check.shown(labels)
        colour = "green" if check.met else "red"
        table.add_row(Text(check.requirement.name), asked, achieved, Text(verdict, colour))
    yield table
