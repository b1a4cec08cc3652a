"""How far a sweep is: rate and time left, in a terminal or a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def shown_progress(total: int, done: int, asked: bool | None) -> Iterator[Callable[[int], None]]:
    """Yield what is called with each number of further points done."""
    if not (_is_watched() if asked is None else asked):
        yield lambda _: None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    rate = TextColumn("{task.fields[rate]}")
    columns = (BarColumn(), MofNCompleteColumn(), rate, TimeRemainingColumn(compact=True))
    with Progress(*columns, transient=True) as bar:
        task = bar.add_task("", total=total, completed=done, rate="")

        def advance(more: int) -> None:
            speed = bar.tasks[task].speed
            told = "" if speed is None else f"{speed:.3g} points/s"
            bar.update(task, advance=more, rate=told)

        yield advance


def _is_watched() -> bool:
    return sys.stderr.isatty() or "ipykernel" in sys.modules
