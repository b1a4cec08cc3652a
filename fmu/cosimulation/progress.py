"""A progress bar on the error output, for runs that last."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any

_PATIENCE_S = 1.0  # a run that is over sooner needs none


@contextmanager
def progress_bar(wanted: bool | None) -> Iterator[Any]:
    """Yield what shows the fraction of a run that is done."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if wanted is False or (wanted is None and not console.is_terminal):
        yield lambda fraction: None  # noqa: ARG005
        return
    bar = Progress(console=console, transient=console.is_terminal)
    task = bar.add_task("co-simulation", total=1.0)
    begun = monotonic()
    shown = False

    def advance(fraction: float) -> None:
        nonlocal shown
        if not shown and (wanted or monotonic() - begun > _PATIENCE_S):
            bar.start()
            shown = True
        bar.update(task, completed=fraction)

    try:
        yield advance
    finally:
        bar.stop()
