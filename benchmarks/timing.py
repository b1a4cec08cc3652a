"""Timing side by side: medians of alternating runs in one process, so that ratios hold."""

from __future__ import annotations

import gc
from collections.abc import Callable
from statistics import median
from time import perf_counter


def side_by_side(*calls: Callable[[], object], repeats: int = 15) -> list[list[float]]:
    """Return the seconds of each call, run in turn `repeats` times after one warm-up each."""
    for call in calls:
        call()
    seconds: list[list[float]] = [[] for _ in calls]
    gc.disable()
    try:
        for _ in range(repeats):
            for call, taken in zip(calls, seconds, strict=True):
                begin = perf_counter()
                call()
                taken.append(perf_counter() - begin)
    finally:
        gc.enable()
    return seconds


def repeated(times: int, call: Callable[[], object]) -> None:
    """Run a call several times, its results dropped."""
    for _ in range(times):
        call()


def ratio(numerator: list[float], denominator: list[float]) -> float:
    """Return the ratio of the medians."""
    return median(numerator) / median(denominator)


def table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [header, tuple("---" if i == 0 else "---:" for i in range(len(header))), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
