"""Many runs of loops at once, on all processors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

from ..shaping.checks import whole
from .loop_response import LoopResponse
from .servo_loop import ServoLoop

_Figures = TypeVar("_Figures")

MOST_WORKERS = 256


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

    The loops run side by side in threads: the core is at work without the interpreter's lock. Only
    what `figures` returns is kept.

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
    [0.0011, 0.0]
    """
    count = whole("workers", workers or os.cpu_count() or 1, 1, MOST_WORKERS)
    run = partial(_figures_of, command=command, dt=dt, figures=figures, others=others)
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(run, loops))


def _figures_of(
    loop: ServoLoop,
    *,
    command: Any,
    dt: float | None,
    figures: Callable[[LoopResponse], _Figures],
    others: dict[str, Any],
) -> _Figures:
    return figures(loop.respond(command, dt, **others))
