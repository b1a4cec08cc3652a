"""Margins of 1e5 loops at once, beside one by one and python-control's stability_margins.

python-control takes the delay as a Padé approximation of order 4; it returns fewer margins.

Run: python benchmarks/margins.py
"""

from __future__ import annotations

import tracemalloc
from statistics import median

import control
import numpy as np
from timing import ratio, side_by_side, table

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.many_margins import many_loop_margins
from jounce.plant import design_pid

LOOPS = 100_000
SINGLES = 10  # of them, one by one
PADE = 4

Batch = tuple[np.ndarray, np.ndarray, np.ndarray]


def pid_grid(longest_delay: float) -> Batch:
    """Return a PID's loops over 50 gains × 40 inertias × 50 delays."""
    gains = design_pid(1.0, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    gain, inertia, delay = np.meshgrid(
        np.geomspace(0.5, 2.0, 50), np.geomspace(0.5, 2.0, 40), np.linspace(0.0, longest_delay, 50)
    )
    num = gain.reshape(-1, 1) * [gains.kr, gains.kp, gains.ki]
    return num, inertia.reshape(-1, 1) * [1.0, 0.0, 0.0, 0.0], delay.ravel()


def random_batch(order: int) -> Batch:
    """Return loops with random poles, half of them in light pairs, and half as many zeros."""
    rng = np.random.default_rng(order)
    num, den = (_polynomials(rng, pairs) for pairs in (order // 4, order // 2))
    gain = 10.0 ** rng.uniform(-2.0, 0.0, (LOOPS, 1))
    return gain * num * den[:, -1:] / num[:, -1:], den, np.zeros(LOOPS)


def _polynomials(rng: np.random.Generator, pairs: int) -> np.ndarray:
    rows = np.ones((LOOPS, 1))
    for _ in range(pairs):
        size, damping = 10.0 ** rng.uniform((-1.0, -2.0), (1.0, 0.5), (LOOPS, 2)).T
        factor = np.stack([np.ones(LOOPS), 2.0 * damping * size, size**2], axis=1)
        product = np.zeros((LOOPS, rows.shape[1] + 2))
        for i, row in enumerate(rows.T):
            product[:, i : i + 3] += row[:, None] * factor
        rows = product
    return rows


def one_by_one(batch: Batch) -> list[float]:
    """Return the phase margins of some loops, each alone."""
    return [
        loop_margins(control.tf(num, den), delay=float(delay)).phase_margin_deg
        for num, den, delay in zip(*batch, strict=True)
    ]


def by_control(batch: Batch) -> None:
    """Take the margins of some loops from python-control."""
    for num, den, delay in zip(*batch, strict=True):
        behind = control.tf(*control.pade(delay, PADE)) if delay else 1.0
        control.stability_margins(control.tf(num, den) * behind)


def peak_megabytes(batch: Batch) -> float:
    """Return the most memory taken at once, result included."""
    tracemalloc.start()
    many_loop_margins(*batch[:2], delay=batch[2])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: loops, our time for one, the others', ratios, memory."""
    batches = {
        "PID on an inertia": pid_grid(0.0),
        "the same × delay": pid_grid(0.1),
        "random, order 8": random_batch(8),
    }
    return [_row(name, batch) for name, batch in batches.items()]


def _row(name: str, batch: Batch) -> tuple[str, ...]:
    margins = many_loop_margins(*batch[:2], delay=batch[2])
    stable = np.flatnonzero(margins.stable)
    some = stable[:: len(stable) // SINGLES][:SINGLES]
    few = (batch[0][some], batch[1][some], batch[2][some])
    assert np.allclose(one_by_one(few), margins.phase_margin_deg[some], rtol=1e-9)
    together, singly, theirs = side_by_side(
        lambda: many_loop_margins(*batch[:2], delay=batch[2]),
        lambda: one_by_one(few),
        lambda: by_control(few),
        repeats=3,
    )
    return (
        name,
        f"{1e6 * median(together) / LOOPS:.0f} µs",
        f"{1e3 * median(singly) / SINGLES:.1f} ms",
        f"{1e3 * median(theirs) / SINGLES:.1f} ms",
        f"{ratio(singly, together) * LOOPS / SINGLES:.2g}",
        f"{ratio(theirs, together) * LOOPS / SINGLES:.2g}",
        f"{peak_megabytes(batch):.0f} MB",
    )


HEADER = (
    "loops",
    "jounce, 1e5 at once, each",
    "loop_margins, each",
    "control, each",
    "loop_margins / jounce",
    "control / jounce",
    "memory",
)

if __name__ == "__main__":
    print(table(HEADER, rows()))
