"""Pictures of a survey: the loop and its first move on one page, panel by panel."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from .loop import plot_loop_gain, plot_loop_phase, plot_nichols, plot_sensitivities, plot_step
from .style import BLUE, GREEN, GREY, ORANGE, RED, finish, panels_figure, plain
from .survey_page import plot_survey_page

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.loop_survey import MoveSurvey, Survey
    from ..shaping.pieces import FloatArray


def plot_survey(survey: Survey, *, figure: Figure | None = None) -> Figure:
    """Return the survey of a loop on one page: loop, closed loop, step, first move, wrong Ĵ.

    Of a loop that is not ideal: what to look at first, as `plot_survey_page` draws it.

    Parameters
    ----------
    survey : Survey
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
    """
    if not (survey.is_ideal and survey.moves):
        return plot_survey_page(survey, figure=figure)
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


def _decibels(value: float) -> str:
    return f"{value:.4g} dB" if isfinite(value) else "any amount"
