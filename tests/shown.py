"""What a table looks like on a terminal."""

import io

from rich.console import Console


def shown(tables, width: int = 160) -> str:
    console = Console(file=io.StringIO(), width=width)
    for table in tables:
        console.print(table)
    return console.file.getvalue()
