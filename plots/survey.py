"""Pictures of a survey: the loop and its first move on one page, panel by panel."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from .style import BLUE, CURVE_POINTS, GREEN, GREY, ORANGE, RED, finish, panels_figure, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.loop_survey import MoveSurvey, Survey
    from ..analysis.step_response import StepResponse
    from ..shaping.pieces import FloatArray


def plot_survey(survey: Survey, *, figure: Figure | None = None) -> Figure:
    """Return the survey of a loop on one page: loop, closed loop, step, first move, wrong Ĵ.

    Parameters
    ----------
    survey : Survey
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.
    """
    figure = panels_figure(figure, (15.0, 11.0), layout="none")
    axes = figure.subplots(3, 3)
    figure.subplots_adjust(0.055, 0.055, 0.985, 0.91, wspace=0.24, hspace=0.33)
    move = survey.moves[0]
    panels: tuple[tuple[Callable[..., Axes], Any], ...] = (
        (plot_loop_gain, survey),
        (plot_nichols, survey),
        (plot_move, (survey, move)),
        (plot_loop_phase, survey),
        (plot_step, survey.step),
        (plot_torque, (survey, move)),
        (plot_sensitivities, survey),
        (plot_wrong_inertia, (survey, move)),
        (plot_tracking_error, (survey, move)),
    )
    for ax, (draw, subject) in zip(axes.flat, panels, strict=True):
        draw(*(subject if isinstance(subject, tuple) else (subject,)), ax=ax)
    figure.suptitle(plain(survey.labels.title), fontsize=15, y=0.985)
    margins = survey.margins
    subtitle = (
        f"crossover {margins.crossover_hz:.4g} Hz,  phase margin {margins.phase_margin_deg:.4g}°,  "
        f"gain may fall by {_decibels(margins.lower_gain_margin_db)} "
        f"and rise by {_decibels(margins.upper_gain_margin_db)}"
    )
    figure.text(0.5, 0.945, subtitle, ha="center", fontsize=11, color=GREY)
    return figure


def plot_loop_gain(survey: Survey, *, ax: Axes) -> Axes:
    """Draw |L| against frequency, with crossover and gain margins marked."""
    frequency, loop = _loop_curve(survey)
    margins = survey.margins
    ax.semilogx(frequency, _db(loop), color=BLUE)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.plot(margins.crossover_hz, 0.0, "o", color=ORANGE)
    ax.annotate(
        f"crossover {margins.crossover_hz:.4g} Hz",
        (margins.crossover_hz, 0.0),
        xytext=(8, 6),
        textcoords="offset points",
        color=ORANGE,
    )
    for level, at, name in (
        (margins.lower_gain_margin_db, margins.lower_gain_margin_hz, "lower"),
        (-margins.upper_gain_margin_db, margins.upper_gain_margin_hz, "upper"),
    ):
        if isfinite(level):
            ax.plot([at, at], [0.0, level], "-o", color=RED, markersize=4)
            ax.annotate(
                f"{name} gain margin\n{abs(level):.4g} dB",
                (at, min(level, 0.0)),
                xytext=(18, -4),
                textcoords="offset points",
                ha="right",
                va="top",
                color=RED,
            )
    return finish(ax, "Open loop: gain", "frequency [Hz]", "|L| [dB]")


def plot_loop_phase(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the phase of L against frequency, with the phase margin marked."""
    frequency, loop = _loop_curve(survey)
    margins = survey.margins
    ax.semilogx(frequency, _phase_deg(loop), color=BLUE)
    ax.axhline(-180.0, color=GREY, linewidth=0.8)
    if isfinite(margins.crossover_hz):
        at = margins.crossover_hz
        phase = float(np.interp(np.log(at), np.log(frequency), _phase_deg(loop)))
        ax.plot([at, at], [-180.0, phase], "-o", color=ORANGE, markersize=4)
        ax.annotate(
            f"phase margin\n{margins.phase_margin_deg:.4g}°",
            (at, 0.5 * (phase - 180.0)),
            xytext=(8, -10),
            textcoords="offset points",
            color=ORANGE,
        )
    return finish(ax, "Open loop: phase", "frequency [Hz]", "phase of L [deg]")


def plot_nichols(survey: Survey, *, ax: Axes) -> Axes:
    """Draw gain against phase of L, with the critical point and the circle |S| = peak."""
    _, loop = _loop_curve(survey)
    ax.plot(_phase_deg(loop), _db(loop), color=BLUE, label="L")
    ax.plot(-180.0, 0.0, "+", color=RED, markersize=12, markeredgewidth=2, label="critical point")
    modulus = survey.margins.modulus_margin
    if modulus < 1.0:
        circle = -1.0 + modulus * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, CURVE_POINTS))
        phase = np.degrees(np.angle(-circle)) - 180.0
        label = f"|1 + L| = {modulus:.3f}"
        ax.plot(phase, _db(circle), "--", color=RED, linewidth=1.0, label=label)
    ax.set_ylim(-40.0, 40.0)
    ax.xaxis.set_major_locator(MultipleLocator(45.0))
    ax.legend(loc="lower left")
    return finish(ax, "Nichols", "phase of L [deg]", "|L| [dB]")


def plot_sensitivities(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the closed loop T = L/(1 + L) and the sensitivity S = 1/(1 + L)."""
    frequency, loop = _loop_curve(survey)
    margins = survey.margins
    for values, color, name, peak, at in (
        (
            loop / (1.0 + loop),
            BLUE,
            "T",
            margins.complementary_peak,
            margins.complementary_peak_hz,
        ),
        (1.0 / (1.0 + loop), GREEN, "S", margins.sensitivity_peak, margins.sensitivity_peak_hz),
    ):
        label = f"|{name}|, peak {20.0 * np.log10(peak):.2f} dB"
        ax.semilogx(frequency, _db(values), color=color, label=label)
        if 0.0 < at < inf:
            ax.plot(at, 20.0 * np.log10(peak), "o", color=color, markersize=4)
    if isfinite(margins.bandwidth_hz):
        label = f"bandwidth {margins.bandwidth_hz:.4g} Hz"
        ax.axvline(margins.bandwidth_hz, color=GREY, linestyle=":", label=label)
    ax.set_ylim(-60.0, 15.0)
    ax.legend(loc="lower left", bbox_to_anchor=(0.3, 0.0))
    return finish(ax, "Closed loop T and sensitivity S", "frequency [Hz]", "magnitude [dB]")


def plot_step(step: StepResponse, *, ax: Axes) -> Axes:
    """Draw the unit step response with its overshoot and settling time."""
    shown = step.time <= 1.6 * step.settling_time_s + step.peak_time_s
    ax.plot(step.time[shown], step.position[shown], color=BLUE)
    ax.axhline(1.0, color=GREY, linewidth=0.8)
    ax.axhspan(0.98, 1.02, color=GREY, alpha=0.2, label="±2 %")
    ax.plot(step.peak_time_s, 1.0 + step.overshoot_percent / 100.0, "o", color=ORANGE)
    ax.annotate(
        f"overshoot {step.overshoot_percent:.2f} %",
        (step.peak_time_s, 1.0 + step.overshoot_percent / 100.0),
        xytext=(10, -3),
        textcoords="offset points",
        color=ORANGE,
    )
    label = f"settled at {step.settling_time_s:.3g} s"
    ax.axvline(step.settling_time_s, color=GREY, linestyle=":", label=label)
    ax.legend(loc="lower right")
    return finish(ax, "Unit step without feedforward", "time [s]", "position / step")


def plot_move(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw shaped command, filtered command and the loop's responses to one move."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    plain, aided = move.responses["without feedforward"], move.configured
    time = aided.response.time
    shown = _until_settled(move, time)
    ax.plot(time[shown], move.trajectory(time[shown]) / scale, color=GREY, label="shaped command")
    if survey.jerk_filter is not None:
        ax.plot(
            time[shown], aided.response.command[shown] / scale, color=GREEN, label="jerk filter"
        )
    ax.plot(
        time[shown],
        plain.response.position[shown] / scale,
        color=ORANGE,
        label="loop without feedforward",
    )
    ax.plot(
        time[shown],
        aided.response.position[shown] / scale,
        "--",
        color=BLUE,
        linewidth=2.0,
        label="loop with feedforward",
    )
    ax.legend(loc="lower right")
    return finish(ax, f"Move: {move.name}", "time [s]", f"position [{unit}]")


def plot_torque(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw the torque of one move with and without feedforward."""
    unit = "N m" if survey.labels.motion == "angle" else "N"
    for name, color in (("without feedforward", ORANGE), ("with feedforward", BLUE)):
        response = move.responses[name].response
        shown = _until_settled(move, response.time)
        ax.plot(response.time[shown], response.torque[shown], color=color, label=name)
    ax.ticklabel_format(axis="y", scilimits=(-2, 4))
    ax.legend(loc="upper right")
    kind = "Torque" if unit == "N m" else "Force"
    return finish(ax, f"{kind}: {move.name}", "time [s]", f"{kind.lower()} [{unit}]")


def plot_tracking_error(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw the tracking error of one move with and without feedforward."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    for name, color in (("without feedforward", ORANGE), ("with feedforward", BLUE)):
        result = move.responses[name]
        shown = _until_settled(move, result.response.time)
        peak = result.peak_error if result.peak_error > 1e-9 * move.move.settle_to else 0.0
        label = f"{name}, peak {peak / scale:.3g} {unit}"
        ax.plot(
            result.response.time[shown],
            result.response.error[shown] / scale,
            color=color,
            label=label,
        )
    _make_room(ax, below=0.4)
    ax.legend(loc="lower right")
    return finish(ax, f"Tracking error: {move.name}", "time [s]", f"command − position [{unit}]")


def plot_wrong_inertia(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw what a wrong Ĵ costs: the tracking error of one move."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    varied = [result for name, result in move.responses.items() if name.startswith("Ĵ")]
    for result, color in zip(varied, (RED, GREEN), strict=True):
        shown = _until_settled(move, result.response.time)
        label = f"{result.name}, settles at {result.settling_time_s:.3g} s"
        ax.plot(
            result.response.time[shown],
            result.response.error[shown] / scale,
            color=color,
            label=label,
        )
    for side in (-1.0, 1.0):
        ax.axhline(side * move.move.settle_to / scale, color=GREY, linestyle=":", linewidth=1.0)
    _make_room(ax, above=0.55)
    ax.legend(
        loc="upper right", title=f"right Ĵ settles at {move.configured.settling_time_s:.3g} s"
    )
    title = f"Tracking error with a wrong Ĵ: {move.name}"
    return finish(ax, title, "time [s]", f"command − position [{unit}]")


def _make_room(ax: Axes, *, above: float = 0.05, below: float = 0.05) -> None:
    """Widen the y axis by parts of its span, so that a legend hides no curve."""
    low, high = ax.dataLim.intervaly
    span = (high - low) or 1.0
    ax.set_ylim(low - below * span, high + above * span)


def _until_settled(move: MoveSurvey, time: FloatArray) -> slice:
    """Return the samples up to a little after the slowest response has settled."""
    settled = [result.settling_time_s for result in move.responses.values()]
    end = 1.15 * max([value for value in settled if isfinite(value)], default=inf)
    return slice(0, int(np.searchsorted(time, end)) + 1)


def _loop_curve(survey: Survey) -> tuple[FloatArray, Any]:
    """Return frequencies around the crossover [Hz] and L there."""
    margins = survey.margins
    centre = margins.crossover_hz
    if not 0.0 < centre < inf:
        centre = float(np.abs(margins.closed_loop_poles).max()) / (2.0 * np.pi)
    frequency = centre * np.logspace(-2.0, 2.0, CURVE_POINTS)
    return frequency, survey.loop.loop_transfer()(2j * np.pi * frequency)


def _db(values: Any) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.abs(values)))


def _phase_deg(values: Any) -> FloatArray:
    """Return the unwrapped phase, its right end within (−360, 0]."""
    phase = np.degrees(np.unwrap(np.angle(values)))
    return np.asarray(phase - 360.0 * np.ceil(phase[-1] / 360.0))


def _decibels(value: float) -> str:
    return f"{value:.4g} dB" if isfinite(value) else "any amount"
