"""Who works out the points of a sweep: this process, others, or a Dask cluster."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import Any

from .figures import Problem
from .sampling import Point

_BATCHES = (4, 64)  # points that a worker takes at once, and that a kill may cost, by their count

Row = tuple[tuple[float, ...], str]
"""The figures of a point, and why there are none."""


def batch_of(points: int) -> int:
    """Return how many points are worked out together: enough for speed, few enough to share."""
    least, most = _BATCHES
    return max(least, min(most, points // 16))


def batches_of(todo: Sequence[int], size: int) -> Iterator[range]:
    """Yield runs of consecutive points, none across the chunks that are written at once."""
    for _, run in groupby(enumerate(todo), lambda pair: (pair[1] - pair[0], pair[1] // size)):
        numbers = [number for _, number in run]
        yield range(numbers[0], numbers[-1] + 1)


def rows_of(
    problem: Problem,
    points: Sequence[Point],
    batches: Sequence[range],
    workers: int | None,
    client: Any,
) -> Generator[tuple[int, list[Row]]]:
    """Yield what was found in each batch, in the order in which they are done."""
    given = [(batch.start, [points[k] for k in batch]) for batch in batches]
    if client is not None:
        yield from _by_cluster(problem, given, client)
        return
    count = _workers(workers, len(given))
    if count == 1:
        yield from (_work(problem, *batch) for batch in given)
        return
    yield from _by_processes(problem, given, count)


def check_workers(workers: int | None) -> None:
    """Raise ValueError for what is no number of processes."""
    if workers is not None and (type(workers) is not int or workers < 1):
        raise ValueError(f"workers = {workers!r}: expected a whole number from 1 on")


def _workers(workers: int | None, batches: int) -> int:
    """Return how many processes are of use."""
    return max(1, min(workers or os.cpu_count() or 1, batches))


def _work(problem: Problem, first: int, points: Sequence[Point]) -> tuple[int, list[Row]]:
    together = problem.prepared(points)
    return first, [together.evaluate(point) for point in points]


def _by_processes(
    problem: Problem, given: Sequence[tuple[int, list[Point]]], count: int
) -> Iterator[tuple[int, list[Row]]]:
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_begin)
    try:
        with _interrupted_later():
            waiting = [pool.submit(_work_there, problem, *batch) for batch in given]
        for done in as_completed(waiting):
            yield done.result()
    except BrokenProcessPool:
        raise ChildProcessError(
            "a process of the sweep has died, as where memory runs out, or where a script calls "
            'sweep outside of if __name__ == "__main__"; the output keeps what is done: go on with '
            "the same call, and fewer workers"
        ) from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Leave Ctrl-C to the process that waits for this one, and end when that one has ended.

    Its pipes alone would not tell: the processes of a pool hold both ends of them.
    """
    from multiprocessing import parent_process
    from threading import Thread

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with, args=(parent_process(),), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)


@contextmanager
def _interrupted_later() -> Iterator[None]:
    """Hold Ctrl-C back until the end; from processes that are started meanwhile for ever.

    It is for the process that waits, and may come before another has begun to ignore it.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_SENT: dict[str, Problem] = {}


def _work_there(problem: Problem, first: int, points: Sequence[Point]) -> tuple[int, list[Row]]:
    """Work in another process, which keeps the gains that it has designed for all its batches.

    The problem goes with every batch, not once to each worker: a worker may die or come late.
    """
    known = json.dumps([problem.content, problem.keys, problem.figures, problem.hold_gains])
    if known not in _SENT:
        _SENT.clear()
        _SENT[known] = problem
    return _work(_SENT[known], first, points)


def _by_cluster(
    problem: Problem, given: Sequence[tuple[int, list[Point]]], client: Any
) -> Iterator[tuple[int, list[Row]]]:
    from dask.distributed import as_completed

    work: Callable[..., Any] = _work_there
    waiting = [client.submit(work, problem, *batch, pure=False, retries=2) for batch in given]
    try:
        for done in as_completed(waiting, loop=client.loop):  # type: ignore[no-untyped-call]
            yield done.result()
            done.release()
    finally:
        client.cancel(waiting)
