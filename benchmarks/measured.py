"""Margins of a measured loop with error bars, beside python-control; a response out of records.

python-control's stability_margins reads straight lines between the lines of the same data: without
error bars, with every crossing that noise makes.

Run: python benchmarks/measured.py
"""

from __future__ import annotations

from statistics import median

import control
import numpy as np
from timing import ratio, side_by_side, table

from jounce.analysis import MeasuredResponse, estimate_frf, loop_margins
from jounce.plant import PID, Axis, Controller, FlexibleMode, zero_order_hold

LINES = 1_400
SAMPLES = 1_000_000
DT = 2.5e-4
PERIOD = 4_000

AXIS = Axis(
    5.0,
    modes=[
        FlexibleMode(88.0, 0.008, motor_shape=0.3, load_shape=0.3),
        FlexibleMode(143.0, 0.006, motor_shape=0.2, load_shape=0.2),
    ],
)
LAW = Controller(PID(2000.0, 1e4, 127.0, derivative_filter=1e-3), sample_time=DT)


def measured_plant() -> MeasuredResponse:
    """Return a noisy response of 1 to 700 Hz."""
    rng = np.random.default_rng(0)
    lines = np.linspace(1.0, 700.0, LINES)
    exact = zero_order_hold(AXIS.transfer(), DT)(np.exp(2j * np.pi * lines * DT))
    sigma = 3e-3 * abs(exact)
    noise = rng.normal(size=LINES) + 1j * rng.normal(size=LINES)
    response = exact + sigma * noise / np.sqrt(2.0)
    declared = {"integrators": 2, "unstable_poles": 0}
    return MeasuredResponse(lines, response, sigma, kind="plant", dt=DT, **declared)


def fresh(measured: MeasuredResponse) -> MeasuredResponse:
    """Return it without what was fitted to it."""
    declared = {"integrators": measured.integrators, "unstable_poles": 0}
    return MeasuredResponse(
        measured.frequency_hz, measured.response, measured.sigma, kind="plant", dt=DT, **declared
    )


def records() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return excitation, input and output of a million samples, in open loop for speed."""
    rng = np.random.default_rng(1)
    w = np.tile(rng.normal(size=PERIOD), SAMPLES // PERIOD)
    y = np.convolve(w, np.exp(-np.arange(200) / 30.0) / 30.0)[:SAMPLES]
    return w, w, y + 1e-3 * rng.normal(size=SAMPLES)


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: what, time, crossings found, ratio."""
    plant = measured_plant()
    loop = control.frd(plant.response * _values(plant.frequency_hz), 2 * np.pi * plant.frequency_hz)
    again, anew, theirs = side_by_side(
        lambda: loop_margins(plant, controller=LAW),
        lambda: loop_margins(fresh(plant), controller=LAW),
        lambda: control.stability_margins(loop, returnall=True),
        repeats=7,
    )
    found = loop_margins(plant, controller=LAW)
    every = control.stability_margins(loop, returnall=True)
    exact = f"{len(found.crossovers_hz)} / {len(found.phase_crossovers_hz)}"
    listed = f"{len(every[4])} / {len(every[3])}"
    w, u, y = records()
    periodic, noisy = side_by_side(
        lambda: estimate_frf(w, u, y, DT, period=PERIOD),
        lambda: estimate_frf(w, u, y, DT, segment=PERIOD),
        repeats=3,
    )
    return [
        ("margins of another controller on the same data", _ms(again), exact, "1"),
        ("margins of new data", _ms(anew), exact, f"{ratio(anew, again):.2g}"),
        ("control.stability_margins", _ms(theirs), listed, f"{ratio(theirs, again):.2g}"),
        (f"estimate_frf of {SAMPLES:.0e} samples, periodic", _ms(periodic), "", ""),
        (f"estimate_frf of {SAMPLES:.0e} samples, Welch", _ms(noisy), "", ""),
    ]


def _values(lines: np.ndarray) -> np.ndarray:
    """Return the controller's response to an error."""
    both = LAW.sampled()
    b, d = (np.sum(part, axis=1, keepdims=True) for part in (both.B, both.D))
    return np.asarray(control.ss(both.A, b, both.C, d, both.dt)(np.exp(2j * np.pi * lines * DT)))


def _ms(seconds: list[float]) -> str:
    return f"{1e3 * median(seconds):.3g} ms"


HEADER = (f"{LINES} lines", "time", "gain / phase crossovers", "time / jounce")

if __name__ == "__main__":
    print(table(HEADER, rows()))
