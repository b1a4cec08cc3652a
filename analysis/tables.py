"""Tables for the terminal: how they look, and how numbers stand in them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import StringIO
from typing import Literal, TextIO

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text

_UNSEEN = 160  # characters of a line that no terminal shows


def console_for(file: TextIO) -> Console:
    """Return a console that prints text as it is, as wide as the terminal, if there is one."""
    width = None if sys.stdout.isatty() else _UNSEEN
    return Console(file=file, width=width, highlight=False, markup=False, emoji=False)


def print_on(console: Console, parts: Iterable[object]) -> None:
    """Print tables and plain text, the latter without wrapping."""
    for part in parts:
        console.print(part, soft_wrap=isinstance(part, str))


def as_text(parts: Iterable[object]) -> str:
    """Return tables and plain text as a terminal shows them."""
    file = StringIO()
    print_on(console_for(file), parts)
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines())


def plain_table(title: str, *columns: str) -> Table:
    """Return an empty table; the columns behind the first stand to the right."""
    table = Table(
        title=Text(title),
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        min_width=cell_len(title),  # lest the title break above a narrow table
    )
    for i, column in enumerate(columns):
        # Text, lest rich take a unit in brackets for its markup; folded, lest it cut digits off
        justify: Literal["left", "right"] = "left" if i == 0 else "right"
        table.add_column(Text(column), justify=justify, overflow="fold")
    return table


@dataclass(frozen=True)
class WideTable:
    """A table that a narrow console shows as several, each with the first column.

    Numbers are so never broken across lines.
    """

    title: str
    columns: list[list[str]]

    def __rich_console__(self, _: Console, options: ConsoleOptions) -> Iterator[Table]:
        """Return the fewest tables that fit."""
        title, columns, room = self.title, self.columns, options.max_width
        if _width(columns) > room:
            columns = [[column[0].replace(" [", "\n["), *column[1:]] for column in columns]
        first, *left = columns
        while left:
            count = len(left)
            while count > 1 and _width([first, *left[:count]]) > room:
                count -= 1
            header, *rows = zip(first, *left[:count], strict=True)
            table = plain_table(title, *header)
            for row in rows:
                table.add_row(*row)
            yield table
            title, left = f"{self.title}, continued", left[count:]


def _width(columns: list[list[str]]) -> int:
    """Return how wide a table is in which no line is broken."""
    lines = ([line for cell in column for line in cell.split("\n")] for column in columns)
    return 1 + sum(3 + max(map(cell_len, column)) for column in lines)


def without_rounding(value: float, peak: float) -> str:
    """Return a number for reading, rounding errors beside its peak left out."""
    return f"{value:.6g}" if abs(value) > 1e-12 * peak else "0"
