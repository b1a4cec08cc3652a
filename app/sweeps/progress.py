"""How far a sweep is: rate and time left, in a terminal or a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any


@contextmanager
def shown_progress(total: int, done: int, asked: bool | None) -> Iterator[Callable[[int], None]]:
    """Yield what is called with each number of further points done."""
    if not (_is_watched() if asked is None else asked):
        yield lambda _: None
    elif _in_kernel():
        yield _in_notebook(total, done)
    else:
        with _in_terminal(total, done) as advance:
            yield advance


def _in_notebook(total: int, done: int) -> Callable[[int], None]:
    """Return what writes one line anew, which the notebook keeps; it needs no widgets."""
    from IPython.display import display

    begin, first = perf_counter(), done
    show: Any = display
    line = show({"text/plain": _line(done, total, 0.0)}, raw=True, display_id=True)

    def advance(more: int) -> None:
        nonlocal done
        done += more
        rate = (done - first) / max(perf_counter() - begin, 1e-9)
        line.update({"text/plain": _line(done, total, rate)}, raw=True)

    return advance


def _line(done: int, total: int, rate: float) -> str:
    told = f"{done} of {total} points"
    if not rate:
        return told
    left = f", {(total - done) / rate:.0f} s left" if done < total else ""
    return f"{told}, {rate:.3g} points/s{left}"


@contextmanager
def _in_terminal(total: int, done: int) -> Iterator[Callable[[int], None]]:
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
    return sys.stderr.isatty() or _in_kernel()


def _in_kernel() -> bool:
    """Tell whether a notebook's kernel runs this: ipykernel may be imported where none does."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")
