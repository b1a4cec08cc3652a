"""The first page of a real loop's survey: margins, load error, torque, S and T with bounds."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from .loop import loop_curve
from .style import BLUE, GREEN, GREY, ORANGE, RED, finish, panels_figure, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.loop_survey import MoveSurvey, Survey


def plot_survey_page(survey: Survey, *, figure: Figure | None = None) -> Figure:
    """Return what to look at first: Nichols chart, S and T, one move's load error and torque.

    Parameters
    ----------
    survey : Survey
        Its first move is drawn; without one the torque step, if there is any.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.
    """
    figure = panels_figure(figure, (13.0, 9.5), layout="none")
    axes = figure.subplots(2, 2)
    figure.subplots_adjust(0.07, 0.065, 0.98, 0.87, wspace=0.2, hspace=0.3)
    plot_open_loop(survey, ax=axes[0, 0])
    plot_bounded_sensitivities(survey, ax=axes[0, 1])
    if survey.moves:
        plot_load_error(survey, survey.moves[0], ax=axes[1, 0])
        plot_limited_torque(survey, survey.moves[0], ax=axes[1, 1])
    else:
        axes[1, 0].set_axis_off()
        axes[1, 1].set_axis_off()
    figure.suptitle(plain(survey.labels.title), fontsize=15, y=0.99)
    figure.text(0.5, 0.95, _summary(survey), ha="center", va="top", fontsize=11, color=GREY)
    return figure


def plot_open_loop(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the gain of the open loop over frequency, with crossovers and margins marked."""
    frequency, loop = loop_curve(survey)
    margins = survey.margins
    gain = _db(loop)
    ax.semilogx(frequency, gain, color=BLUE, label="|L|")
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    label = f"crossover {margins.crossover_hz:.4g} Hz, phase margin {margins.phase_margin_deg:.3g}°"
    ax.plot(margins.crossover_hz, 0.0, "o", color=ORANGE, label=label)
    for level, at, name, color in (
        (margins.lower_gain_margin_db, margins.lower_gain_margin_hz, "fall", GREEN),
        (-margins.upper_gain_margin_db, margins.upper_gain_margin_hz, "rise", RED),
    ):
        if isfinite(level) and isfinite(at):
            label = f"gain may {name} by {abs(level):.3g} dB"
            ax.plot([at, at], [0.0, level], "-o", color=color, markersize=4, label=label)
    ax.set_ylim(max(float(gain.min()), -80.0) - 5.0, min(float(gain.max()), 80.0) + 5.0)
    ax.legend(loc="lower left")
    return finish(ax, f"Open loop{_linear(survey)}", "frequency [Hz]", "|L| [dB]")


def plot_bounded_sensitivities(survey: Survey, *, ax: Axes) -> Axes:
    """Draw |S| and |T| with their peaks, and the bounds that are required of them."""
    frequency, loop = loop_curve(survey)
    margins = survey.margins
    bounds = {c.requirement.name: c.requirement.most for c in survey.requirements}
    for values, color, name, peak, at in (
        (1.0 / (1.0 + loop), GREEN, "S", margins.sensitivity_peak, margins.sensitivity_peak_hz),
        (
            loop / (1.0 + loop),
            BLUE,
            "T",
            margins.complementary_peak,
            margins.complementary_peak_hz,
        ),
    ):
        ax.loglog(frequency, np.abs(values), color=color, label=f"|{name}|, peak {peak:.3g}")
        if 0.0 < at < inf:
            ax.plot(at, peak, "o", color=color, markersize=4)
        key = "sensitivity_peak" if name == "S" else "complementary_peak"
        if (bound := bounds.get(key)) is not None:
            label = f"required |{name}| ≤ {bound:.3g}"
            ax.axhline(bound, color=color, linestyle="--", linewidth=1.0, label=label)
    ax.set_ylim(1e-4, 2.0 * max(margins.sensitivity_peak, margins.complementary_peak, 2.0))
    ax.legend(loc="lower center")
    title = f"Sensitivity S and closed loop T{_linear(survey)}"
    return finish(ax, title, "frequency [Hz]", "magnitude [1]")


def plot_load_error(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw the load's error in one move, its tolerance and when it settles.

    The scale is linear within the tolerance and logarithmic beyond.
    """
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    tolerance = move.move.settle_to / scale
    for name, color in (("without feedforward", GREY), ("with feedforward", BLUE)):
        response = move.responses[name].response
        shown = _shown(move, response.time)
        ax.plot(
            response.time[shown] - response.time[0],
            response.load_error[shown] / scale,
            color=color,
            linewidth=0.8 if color == GREY else 1.5,
            label=name,
        )
    label = f"tolerance ±{tolerance:.4g} {unit}"
    ax.axhspan(-tolerance, tolerance, color=GREEN, alpha=0.25, label=label)
    settled = move.configured.load_settling_time_s
    label = f"command ends, {move.duration_s:.4g} s"
    ax.axvline(move.duration_s, color=GREY, linestyle=":", label=label)
    if isfinite(settled):
        label = f"load settled about its goal, {settled:.4g} s"
        ax.axvline(settled, color=ORANGE, linestyle="--", label=label)
    _beyond_tolerance(ax, tolerance)
    title = "" if isfinite(settled) else f"not settled {_within(move)}"
    ax.legend(loc="upper right", title=title, fontsize=9)
    name = f"Error of the load: {move.name}"
    return finish(ax, name, "time [s]", f"command − load [{unit}], log beyond tolerance")


def _beyond_tolerance(ax: Axes, tolerance: float) -> None:
    """Make the y axis linear within a tolerance and logarithmic beyond, with room for a legend."""
    low, high = ax.dataLim.intervaly
    largest = max(-low, high, 10.0 * tolerance)
    ax.set_yscale("symlog", linthresh=tolerance)
    powers = 10.0 ** np.arange(np.ceil(np.log10(tolerance)), np.ceil(np.log10(largest)) + 1)
    powers = powers[powers > 1.5 * tolerance]
    powers = powers[:: -(-len(powers) // 6)]
    ax.set_yticks([*-powers[::-1], 0.0, *powers])
    ax.minorticks_off()
    decades = np.log10(largest / tolerance) + 1.0
    ax.set_ylim(-2.0 * largest, largest * 10.0**decades)


def plot_limited_torque(survey: Survey, move: MoveSurvey, *, ax: Axes) -> Axes:
    """Draw the torque of one move, and its limit."""
    unit, limit = survey.labels.torque_unit, survey.loop.axis.torque_limit
    for name, color in (("without feedforward", GREY), ("with feedforward", BLUE)):
        result = move.responses[name]
        shown = _shown(move, result.response.time)
        limited = f", {result.saturated_time_s:.3g} s at the limit" if limit < inf else ""
        ax.plot(
            result.response.time[shown] - result.response.time[0],
            result.response.torque[shown],
            color=color,
            linewidth=0.8 if color == GREY else 1.5,
            label=f"{name}, peak {result.peak_torque:.4g} {unit}{limited}",
        )
    if limit < inf:
        for side, label in ((limit, f"limit ±{limit:.4g} {unit}"), (-limit, None)):
            ax.axhline(side, color=RED, linestyle="--", linewidth=1.0, label=label)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.35 * (high - low))
    ax.legend(loc="upper right", fontsize=9)
    kind = survey.labels.torque_name
    return finish(ax, f"{kind.capitalize()}: {move.name}", "time [s]", f"{kind} [{unit}]")


def _shown(move: MoveSurvey, time: Any) -> slice:
    """Return the samples until a little after the load has settled; some time if it does not."""
    settled = move.configured.load_settling_time_s
    last = settled if isfinite(settled) else 4.0 * move.duration_s
    end = time[0] + max(1.4 * move.duration_s, 1.15 * last)
    return slice(0, int(np.searchsorted(time, end)) + 1)


def _summary(survey: Survey) -> str:
    """Return the page in two lines: settling, and requirements that are met or not."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    parts = []
    if survey.moves:
        move = survey.moves[0]
        found = move.configured
        settled = found.load_settling_time_s
        told = (
            f"settles in {settled:.4g} s"
            if isfinite(settled)
            else (f"does not settle {_within(move)}")
        )
        tolerance = move.move.settle_to / scale
        parts.append(
            f"{move.name}: load {told} to {tolerance:.4g} {unit}, "
            f"{found.left_over / scale:.3g} {unit} left at the end of the command"
        )
    if survey.requirements:
        missed = [check.requirement.name for check in survey.requirements if not check.met]
        count = f"{len(survey.requirements) - len(missed)} of {len(survey.requirements)}"
        tail = f", missed: {', '.join(missed)}" if missed else ""
        parts.append(f"requirements met: {count}{tail}")
    return plain("\n".join(parts))


def _within(move: MoveSurvey) -> str:
    time = move.configured.response.time
    return f"within {time[-1] - time[0]:.3g} s"


def _linear(survey: Survey) -> str:
    return ", linear part" if survey.loop.axis.is_nonlinear else ""


def _db(values: Any) -> Any:
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(np.abs(values))
