"""Exact response of a servo loop to a move, beside control.forced_response.

The move is of order 3 with its breaks on samples, so that its acceleration is linear between
samples and forced_response, driven by it, is exact as well.

Run: python benchmarks/response.py
"""

from __future__ import annotations

from statistics import median

import control
import numpy as np
from timing import ratio, repeated, side_by_side, table

from jounce.plant import Inertia, InertiaFeedforward, ServoLoop, design_pid
from jounce.shaping import Limits, min_time_move

DURATION = 8.0
CALLS = 10  # of ours per timed run: one is short beside what a context switch costs


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: samples, our time, ratio, largest difference over the peak."""
    gains = design_pid(1.0, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    loop = ServoLoop(Inertia(1.0), gains, InertiaFeedforward(0.9))
    move = min_time_move(1.0, Limits(velocity=1.0, acceleration=4.0, jerk=16.0))
    double_integrator = control.ss(
        [[0, 1], [0, 0]], [[0], [1]], [[1, 0], [0, 1], [0, 0]], [[0], [0], [1]]
    )
    driven = loop.system() * double_integrator
    found = []
    for samples in (10_240, 102_400):
        dt = DURATION / samples
        response = loop.respond(move, dt, duration=DURATION)
        acceleration = move(response.time, 2)
        reference = np.asarray(control.forced_response(driven, response.time, acceleration).outputs)
        difference = np.abs(reference - response.outputs).max(axis=1)
        ours, theirs = side_by_side(
            lambda dt=dt: repeated(CALLS, lambda: loop.respond(move, dt, duration=DURATION)),
            lambda t=response.time, a=acceleration: control.forced_response(driven, t, a),
            repeats=7,
        )
        found.append(
            (
                f"{samples:,}",
                f"{1e3 * median(ours) / CALLS:.1f} ms",
                f"{CALLS * ratio(theirs, ours):.0f}",
                f"{(difference / np.abs(reference).max(axis=1)).max():.0e}",
            )
        )
    return found


HEADER = ("samples", "jounce", "forced_response / jounce", "largest difference / peak")

if __name__ == "__main__":
    print(table(HEADER, rows()))
