"""Pictures of measured responses: gain and phase, and of a loop Nyquist, S and T with bands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle

from ..analysis.measured import (
    MeasuredResponse,
    as_measured,
    closed_responses,
    measured_margins,
    open_loop,
)
from ..analysis.measured.conversions import factored_loop
from ..analysis.measured.loop_grid import LoopGrid, loop_grid
from ..analysis.survey_of_data import MeasuredSurvey
from .style import BLUE, GREEN, GREY, ORANGE, RED, finish, panels_figure, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..analysis.measured import ClosedResponses, MeasuredMargins

_BAND = float(np.sqrt(-np.log(0.05)))  # radius of 95 %, in complex standard deviations
_SMALL = 1e-12


def plot_measured_response(
    measured: MeasuredResponse, *, controller: Any = None, figure: Figure | None = None
) -> Figure:
    """Draw a measured response with bands of 95 %.

    Of a plant alone gain and phase; of a loop, or a plant with its controller, L with its
    margins, Nyquist with circles, S and T.

    Parameters
    ----------
    measured : MeasuredResponse
    controller : Controller, PID, CascadedPI or python-control system, optional
    figure : Figure, optional
        To draw in. Default: pyplot's current one if it is empty, else a new one of pyplot's.

    Returns
    -------
    Figure
        Gains in dB and phases in degrees over Hz.

    Raises
    ------
    ValueError, TypeError
        As `open_loop` and `loop_margins` do.
    """
    measured = as_measured(measured, plant=controller is not None)
    if measured.kind in ("plant", "process-sensitivity") and controller is None:
        figure = panels_figure(figure, (7.0, 6.0), "constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        _gain(measured, above, f"Measured {measured.kind}")
        _phase(measured, below)
        return figure
    loop = open_loop(measured, controller)
    margins = measured_margins(measured, controller)
    between = loop_grid(factored_loop(measured, controller))
    figure = panels_figure(figure, (11.0, 7.5), "constrained")
    (gain, nyquist), (phase, closed) = figure.subplots(2, 2)
    _gain(loop, gain, "Open loop", between)
    gain.axhline(0.0, color=GREY, linewidth=0.8)
    _mark_margins(margins, gain, phase)
    _phase(loop, phase)
    phase.axhline(-180.0, color=GREY, linewidth=0.8)
    plot_measured_nyquist(measured, margins, ax=nyquist, controller=controller)
    _closed(closed_responses(measured, controller), closed)
    return figure


def plot_measured_survey(survey: MeasuredSurvey, *, figure: Figure | None = None) -> Figure:
    """Draw the survey of a measured loop: L with its margins, Nyquist, S and T, under its title."""
    drawn = plot_measured_response(survey.measured, controller=survey.controller, figure=figure)
    drawn.suptitle(plain(survey.labels.title), fontsize=15)
    return drawn


def plot_measured_nyquist(
    measured: MeasuredResponse, margins: MeasuredMargins, *, ax: Axes, controller: Any = None
) -> Axes:
    """Draw L around −1: its lines with circles of 95 %, and the rational fits between them.

    A dashed circle about −1 touches L: its radius is the modulus margin, min |1 + L|.

    Parameters
    ----------
    measured : MeasuredResponse
    margins : MeasuredMargins
        Of `loop_margins` of the same.
    ax : Axes
        To draw in.
    controller : optional
        As in `open_loop`.

    Returns
    -------
    Axes
    """
    loop, between = open_loop(measured, controller), loop_grid(factored_loop(measured, controller))
    values = loop.response
    near = abs(values + 1.0) < 3.0
    curve = _broken(between, between.value)
    ax.plot(curve.real, curve.imag, color=BLUE, linewidth=0.8, label="L")
    ax.plot(values.real, values.imag, ".", color=BLUE, markersize=3)
    if loop.sigma is not None:
        circles = [
            Circle((value.real, value.imag), _BAND * sigma)
            for value, sigma in zip(values[near], loop.sigma[near], strict=True)
        ]
        ax.add_collection(PatchCollection(circles, facecolor=BLUE, edgecolor="none", alpha=0.15))
    ax.plot(-1.0, 0.0, "+", color=RED, markersize=12, markeredgewidth=2, label="−1")
    if np.isfinite(margins.modulus_margin):
        disk = Circle(
            (-1.0, 0.0), margins.modulus_margin, fill=False, edgecolor=RED, linestyle="--"
        )
        disk.set_label(f"|1 + L| = {margins.modulus_margin:.3g}")
        ax.add_patch(disk)
    ax.set_xlim(-2.5, 1.5)
    ax.set_ylim(-2.0, 2.0)
    ax.set_aspect("equal")
    ax.legend(loc="lower right", fontsize=9)
    return finish(ax, "Nyquist", "Re L", "Im L")


def _broken(grid: LoopGrid, values: Any) -> Any:
    """Return values on a grid, with nan in the holes between lines."""
    return np.insert(values, np.flatnonzero(~grid.joined) + 1, np.nan)


def _gain(
    measured: MeasuredResponse, ax: Axes, title: str, between: LoopGrid | None = None
) -> None:
    lines, size = measured.frequency_hz, abs(measured.response)
    if measured.sigma is not None:
        reach = _BAND * measured.sigma
        ax.fill_between(
            lines,
            _db(np.maximum(size - reach, 0.05 * size)),
            _db(size + reach),
            color=BLUE,
            alpha=0.2,
            label="95 %",
            linewidth=0.0,
        )
        ax.legend(loc="lower left", fontsize=9)
    if between is not None:
        lines, size = (_broken(between, x) for x in (between.frequency_hz, abs(between.value)))
    ax.semilogx(lines, _db(size), color=BLUE, linewidth=1.0)
    finish(ax, f"{title}: gain", "frequency [Hz]", "gain [dB]")


def _phase(measured: MeasuredResponse, ax: Axes) -> None:
    phase = np.degrees(np.angle(measured.response))
    ax.semilogx(
        measured.frequency_hz, (phase + 360.0) % 360.0 - 360.0, ".", color=BLUE, markersize=2
    )
    ax.set_ylim(-365.0, 5.0)
    ax.set_yticks(np.arange(-360.0, 1.0, 90.0))
    finish(ax, "phase", "frequency [Hz]", "phase [deg]")


def _mark_margins(margins: MeasuredMargins, gain: Axes, phase: Axes) -> None:
    at = np.array(margins.crossovers_hz)
    gain.plot(at, np.zeros_like(at), "o", color=ORANGE, markersize=5)
    if np.isfinite(margins.phase_margin_deg):
        text = f"{margins.phase_margin_deg:.4g} ± {margins.phase_margin_deg_sigma:.2g}°"
        phase.axvline(margins.crossover_hz, color=ORANGE, linewidth=0.8)
        phase.annotate(
            f"phase margin\n{text}",
            (margins.crossover_hz, -180.0),
            xytext=(6, 8),
            textcoords="offset points",
            color=ORANGE,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        )
    for name in ("lower", "upper"):
        value = getattr(margins, f"{name}_gain_margin_db")
        place = getattr(margins, f"{name}_gain_margin_hz")
        if np.isfinite(value):
            level = value if name == "lower" else -value
            sigma = getattr(margins, f"{name}_gain_margin_db_sigma")
            gain.plot([place, place], [0.0, level], "-o", color=RED, markersize=4)
            gain.annotate(
                f"{value:.4g} ± {sigma:.2g} dB",
                (place, level),
                xytext=(6, 0),
                textcoords="offset points",
                color=RED,
            )


def _closed(both: ClosedResponses, ax: Axes) -> None:
    for name, color, letter in (("sensitivity", GREEN, "S"), ("complementary", BLUE, "T")):
        size = abs(getattr(both, name))
        low, high = both.band(name)
        ax.fill_between(
            both.frequency_hz,
            _db(np.maximum(low, 0.05 * size)),
            _db(high),
            color=color,
            alpha=0.2,
            linewidth=0.0,
        )
        ax.semilogx(both.frequency_hz, _db(size), color=color, linewidth=1.0, label=f"|{letter}|")
    ax.set_ylim(-60.0, 20.0)
    ax.legend(loc="lower right", fontsize=9)
    finish(ax, "S and T", "frequency [Hz]", "magnitude [dB]")


def _db(values: Any) -> Any:
    return 20.0 * np.log10(np.maximum(values, _SMALL))
