"""Pictures of measured loops: margins with error bars, a light mode, noise beside distortion."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from jounce.analysis import EstimatedFRF, MeasuredResponse, estimate_frf, loop_margins, multisine
from jounce.plant import (
    PID,
    Axis,
    Controller,
    FlexibleMode,
    Friction,
    LowPass,
    Ramp,
    SampledTorque,
    ServoLoop,
    zero_order_hold,
)
from jounce.plots import plot_measured_response
from jounce.plots.style import BLUE, GREEN, GREY, ORANGE, finish

__all__ = ["MEASURED", "measured_light_mode", "measured_loop", "measured_records"]

Real = NDArray[np.float64]

_DT = 1e-3
_DRIVE = Axis(0.02, viscous=0.3, modes=[FlexibleMode(61.0, 0.01, motor_shape=0.5, load_shape=0.5)])
_LAW = Controller(
    PID(62.0, 150.0, 1.2, derivative_filter=1e-3), filters=[LowPass(240.0)], sample_time=_DT
)
_PERIOD = 2000


def measured_loop() -> Figure:
    """Draw the margins of a measured drive with their error bars.

    The response of the plant is simulated with noise on 1 Hz lines, the controller is exact at
    every frequency. A light mode crosses 0 dB twice more: one crossover is reported for each, and
    the margins are taken where they are least. Bands and circles hold the truth with 95 %.
    """
    figure = Figure()
    return plot_measured_response(_drive(np.arange(1.0, 400.0)), controller=_LAW, figure=figure)


def measured_light_mode() -> Figure:
    """Draw what a light mode does between the lines of a measurement.

    Of a resonance narrower than their distance the lines show a flank at the best. Straight lines
    through them miss where the loop crosses 0 dB; rational functions fitted to ten lines around
    each gap find it, with the frequency and the damping that made them.
    """
    lines = np.arange(0.5, 30.0, 0.5)
    axis = Axis(1.0, modes=[FlexibleMode(11.28, 0.005, motor_shape=0.25, load_shape=0.25)])
    law = PID(150.0, 250.0, 26.0, derivative_filter=4e-3)
    exact = _loop(axis, law, fine := np.linspace(10.0, 12.5, 2001))
    values = _loop(axis, law, lines)
    measured = MeasuredResponse(lines, values, 1e-4 * abs(values), kind="loop")
    figure = Figure(figsize=(8.0, 4.8), layout="constrained")
    ax = figure.subplots()
    ax.plot(fine, _db(exact), color=GREY, linewidth=4.0, alpha=0.5, label="exact")
    ax.plot(fine, _db(measured.fits.at(fine).value), color=BLUE, label="rational fits")
    straight = np.interp(np.log(fine), np.log(lines), _db(values))
    ax.plot(fine, straight, "--", color=ORANGE, label="straight lines, log over log")
    near = (lines >= 10.0) & (lines <= 12.5)
    ax.plot(lines[near], _db(values[near]), "o", color=ORANGE, label="lines measured")
    crossed = np.array(loop_margins(measured).crossovers_hz)
    crossed = crossed[(crossed > 10.0) & (crossed < 12.5)]
    ax.plot(crossed, np.zeros_like(crossed), "s", color=GREEN, label="crossovers found")
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.set_ylim(-20.0, 12.0)
    ax.legend(loc="upper left", fontsize=9)
    finish(ax, "A mode narrower than the lines", "frequency [Hz]", "|L| [dB]")
    return figure


def measured_records() -> Figure:
    """Draw a response out of records in closed loop, with noise and distortion apart.

    Four realisations of a random-phase multisine, five periods each, of a simulated drive with
    dry friction. What differs from period to period is noise; what differs from one realisation
    to the next besides is distortion by friction, which longer averaging does not take away.
    """
    found = _estimated()
    lines = found.plant.frequency_hz
    assert found.noise is not None
    assert found.distortion is not None
    figure = Figure(figsize=(8.0, 4.8), layout="constrained")
    ax = figure.subplots()
    ax.semilogx(lines, _db(found.plant.response), color=BLUE, label="|G| estimated")
    exact = _sampled(_DRIVE, lines)
    ax.semilogx(lines, _db(exact), "--", color=GREY, linewidth=1.0, label="without friction")
    ax.semilogx(lines, _db(found.noise), ".", color=GREEN, markersize=3, label="noise")
    distortion = np.where(found.distortion > 0.0, found.distortion, np.nan)
    ax.semilogx(lines, _db(distortion), ".", color=ORANGE, markersize=3, label="distortion")
    ax.legend(loc="upper right", fontsize=9)
    finish(ax, "From records", "frequency [Hz]", "magnitude [dB]")
    return figure


MEASURED: dict[str, Callable[[], Figure]] = {
    "measured_loop": measured_loop,
    "measured_light_mode": measured_light_mode,
    "measured_records": measured_records,
}
"""What draws each picture, by its name."""


def _drive(lines: Real) -> MeasuredResponse:
    """Return the drive as a measurement would have it."""
    rng = np.random.default_rng(15)
    exact = _sampled(_DRIVE, lines)
    sigma = 2e-2 * abs(exact) + 3e-6
    off = rng.normal(size=lines.size) + 1j * rng.normal(size=lines.size)
    return MeasuredResponse(
        lines,
        exact + sigma * off / np.sqrt(2.0),
        sigma,
        kind="plant",
        dt=_DT,
        integrators=1,
        unstable_poles=0,
    )


@cache
def _estimated() -> EstimatedFRF:
    rng = np.random.default_rng(4)
    axis = Axis(0.02, viscous=0.3, modes=_DRIVE.modes, friction=Friction(0.05))
    waves = [
        multisine(_DT, _PERIOD, band_hz=(1.0, 400.0), torque=2.0, odd=True, seed=seed)
        for seed in range(4)
    ]
    sent, read = [], []
    for wave in waves:
        w = wave.repeated(6)
        noise = 2e-6 * rng.normal(size=w.size)
        found = ServoLoop(axis, _LAW).respond(
            Ramp(0.0),
            _DT,
            duration=w.size * _DT,
            disturbance=SampledTorque(_DT * np.arange(w.size), w),
            noise=noise,
        )
        sent.append(found.torque[: w.size] + w)
        read.append(found.position[: w.size] + noise)
    excitation = np.array([wave.values for wave in waves])
    return estimate_frf(excitation, np.array(sent), np.array(read), _DT, period=_PERIOD)


def _sampled(axis: Axis, lines: Real) -> NDArray[np.complex128]:
    return np.asarray(zero_order_hold(axis.transfer(), _DT)(np.exp(2j * np.pi * lines * _DT)))


def _loop(axis: Axis, law: PID, lines: Real) -> NDArray[np.complex128]:
    s = 2j * np.pi * lines
    controller = law.kp + law.ki / s + law.kr * s / (law.derivative_filter * s + 1.0)
    return np.asarray(axis.transfer()(s) * controller * np.exp(-2e-3 * s))


def _db(values: NDArray[np.complex128] | Real) -> Real:
    return np.asarray(20.0 * np.log10(abs(values)))
