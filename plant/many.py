"""Many runs of loops at once, on all processors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import chain, islice
from threading import Lock
from typing import Any, TypeVar

from ..shaping.checks import whole
from ..shaping.real_numbers import shown
from .loop_grid import responses_of
from .loop_response import LoopResponse
from .servo_loop import ServoLoop

_Figures = TypeVar("_Figures")

MOST_WORKERS = 256

_TOGETHER = 16  # loops that a thread prepares, and hands to the core, at a time


def respond_all(
    loops: Iterable[ServoLoop],
    command: Any,
    dt: float | None = None,
    *,
    figures: Callable[[LoopResponse], _Figures],
    workers: int | None = None,
    **others: Any,
) -> list[_Figures]:
    """Return what `figures` makes of the response of each loop to one command.

    The loops run side by side in threads, in groups: the core is at work on one without the
    interpreter's lock. Loops with the same axis and command are fastest. Only what `figures`
    returns is kept.

    Parameters
    ----------
    loops : iterable of ServoLoop
    command, dt
        As in `ServoLoop.respond`.
    figures : callable
        From a LoopResponse to what is wanted of it.
    workers : int, optional
        Number of threads. Default: one a processor.
    **others
        Further arguments of `ServoLoop.respond`.

    Returns
    -------
    list
        What `figures` returned, in the order of the loops.

    Raises
    ------
    ValueError, TypeError
        As `ServoLoop.respond` does, for the first loop that fails.

    Examples
    --------
    >>> from jounce.plant import PID, Controller, Inertia, Ramp
    >>> digital = [Controller(PID(kp, 0.0, 2.0), sample_time=0.01) for kp in (1.0, 2.0)]
    >>> loops = [ServoLoop(Inertia(1.0), controller) for controller in digital]
    >>> errors = respond_all(
    ...     loops, Ramp(0.0, 1.0), 0.1, duration=9.0, start=0.0, figures=lambda r: abs(r.error[-1])
    ... )
    >>> [round(float(error), 4) for error in errors]
    [0.0014, 0.0001]
    """
    if not callable(figures):
        raise TypeError(f"figures = {shown(figures)}: expected a function of a LoopResponse")
    count = whole("workers", (os.cpu_count() or 1) if workers is None else workers, 1, MOST_WORKERS)
    groups = _Groups(loops)
    work = partial(_work, groups, command, dt, others, figures)
    with ThreadPoolExecutor(count) as pool:
        found = dict(chain.from_iterable(pool.map(lambda _: work(), range(count))))
    return [each for number in sorted(found) for each in found[number]]


class _Groups:
    """Loops taken out of an iterable in groups, by one thread at a time."""

    def __init__(self, loops: Iterable[ServoLoop]) -> None:
        self.rest, self.lock, self.taken, self.failed = iter(loops), Lock(), 0, False

    def __iter__(self) -> Iterator[tuple[int, list[ServoLoop]]]:
        """Yield number and loops of each group; after a failure none any more."""
        while True:
            with self.lock:
                group = [] if self.failed else list(islice(self.rest, _TOGETHER))
                number = self.taken
                self.taken += 1
            if not group:
                return
            yield number, group


def _work(
    groups: _Groups,
    command: Any,
    dt: float | None,
    others: dict[str, Any],
    figures: Callable[[LoopResponse], _Figures],
) -> list[tuple[int, list[_Figures]]]:
    """Return the figures of all groups that one thread gets hold of, each with its number."""
    found = []
    try:
        for number, group in groups:
            responses = _responses(group, command, dt, others)
            found.append((number, [figures(response) for response in responses]))
    except BaseException:
        groups.failed = True
        raise
    return found


def _responses(
    loops: list[ServoLoop], command: Any, dt: float | None, others: dict[str, Any]
) -> list[LoopResponse]:
    scenes = [loop.scene(command, **others) for loop in loops]
    run = iter(responses_of([s for s in scenes if s is not None], dt, others.get("times")))
    return [
        loop.respond(command, dt, **others) if scene is None else next(run)
        for loop, scene in zip(loops, scenes, strict=True)
    ]
