"""The second page of a real loop's survey: commands over the modes, PS and CS, disturbances."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, floor, isfinite, log10
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..analysis.disturbed import total_of
from ..analysis.frequency_view import residual_vibration
from .loop import loop_frequencies, plot_step
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, finish, panels_figure, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.loop_survey import Survey

_COLORS = (BLUE, ORANGE, GREEN, PURPLE, RED)
_MOST = 5
_COLUMNS = 3
_LEAST = 1e-9  # of the distance: less is rounding
_FEWEST_BARS = 4  # for which there is room: fewer are as thin


def plot_survey_details(survey: Survey, *, figure: Figure | None = None) -> Figure:
    """Return the details of a survey: commands' spectra, PS and CS, disturbances, budget, step.

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
    panels: list[Callable[..., Axes]] = []
    if survey.moves:
        panels.append(plot_command_spectra)
    if isfinite(survey.compliance.value):
        panels += [plot_compliance, plot_noise_gain]
    if survey.disturbance is not None:
        panels.append(plot_disturbance)
    if survey.budget:
        panels.append(plot_budget)
    if survey.tracking:
        panels.append(plot_tracking)
    rows = -(-(len(panels) + 1) // _COLUMNS)
    figure = panels_figure(figure, (17.0, 4.3 * rows + 0.6))
    axes = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for ax, draw in zip(axes, panels, strict=False):
        draw(survey, ax=ax)
    step = plot_step(survey.step, ax=axes[len(panels)])
    if survey.loop.axis.is_nonlinear:
        step.set_title(f"{step.get_title()}, linear part", fontsize=11)
    for ax in axes[len(panels) + 1 :]:
        ax.set_axis_off()
    figure.suptitle(plain(f"{survey.labels.title}: details".removeprefix(": ")), fontsize=14)
    return figure


def plot_command_spectra(survey: Survey, *, ax: Axes) -> Axes:
    """Draw what each command would leave ringing in an undamped mode, over its frequency.

    Axis modes, free-free and with the motor held, are marked.
    """
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    marks = _mode_marks(survey)
    slowest = max(move.duration_s for move in survey.moves[:_MOST])
    low = min([0.2 / slowest, *(0.4 * hz for _, hz in marks)])
    high = max([30.0 / slowest, *(3.0 * hz for _, hz in marks)])
    frequency = np.geomspace(low, high, 1500)
    for move, color in zip(survey.moves[:_MOST], _COLORS, strict=False):
        left = residual_vibration(move.trajectory, frequency, jerk_filter=survey.jerk_filter)
        floor = _LEAST * abs(move.move.distance)
        ax.loglog(frequency, np.maximum(left, floor) / scale, color=color, label=move.name)
        tolerance = move.move.settle_to / scale
        ax.axhline(tolerance, color=color, linestyle=":", linewidth=1.0)
    for name, hz in marks:
        ax.axvline(hz, color=GREY, linestyle="--", linewidth=1.0)
        ax.annotate(
            plain(f"{name} {hz:.4g} Hz"),
            (hz, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="bottom",
            color=GREY,
            fontsize=8,
            bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.5},
        )
    ax.legend(loc="upper right", title="dotted: tolerance", fontsize=9)
    title = "What commands alone excite (open loop, undamped)"
    return finish(ax, title, "frequency of a mode [Hz]", f"left ringing [{unit}]")


def _mode_marks(survey: Survey) -> list[tuple[str, float]]:
    """Return names and frequencies of the axis's modes and of the modes to be spared."""
    free = np.abs(np.linalg.eigvals(survey.loop.axis.dynamics.a).astype(complex))
    poles = np.linalg.eigvals(survey.loop.axis.dynamics.a).astype(complex)
    swinging = free[(poles.imag > 0.0) & (np.abs(poles.real) < 0.5 * free)] / (2.0 * np.pi)
    marks = [("axis, free", float(hz)) for hz in np.sort(swinging)]
    held = [mode for mode in survey.loop.axis.modes if mode.held]
    marks += [("axis, motor held", mode.frequency_hz) for mode in held]
    return marks + [(mode.name, mode.frequency_hz) for mode in survey.modes]


def plot_compliance(survey: Survey, *, ax: Axes) -> Axes:
    """Draw |PS|, the measured position per disturbing torque on the motor."""
    unit, scale = survey.labels.unit_of("compliance")
    bounds = [c.requirement for c in survey.requirements]
    bound = next((r.most for r in bounds if r.name == "compliance_peak"), None)
    _gain(survey, survey.loop.sensitivity_models().PS, survey.compliance, unit, scale, ax)
    if bound is not None:
        label = f"required ≤ {bound / scale:.3g} {unit}"
        ax.axhline(bound / scale, color=RED, linestyle="--", linewidth=1.0, label=label)
    ax.legend(loc="best")
    return finish(ax, "Compliance PS", "frequency [Hz]", f"|PS| [{unit}]")


def plot_noise_gain(survey: Survey, *, ax: Axes) -> Axes:
    """Draw |CS|, the torque command per error of the measured position."""
    labels = survey.labels
    unit, scale = f"{labels.torque_unit}/{labels.position_unit}", 1.0 / labels.position_scale
    if isfinite(survey.noise_gain.value):
        _gain(survey, survey.loop.sensitivity_models().CS, survey.noise_gain, unit, scale, ax)
        ax.legend(loc="best")
    else:
        ax.text(0.5, 0.5, "grows for ever: a pure derivative", ha="center", transform=ax.transAxes)
        ax.set(xticks=[], yticks=[])
    return finish(ax, "Gain of measurement noise CS", "frequency [Hz]", f"|CS| [{unit}]")


def _gain(survey: Survey, system: Any, peak: Any, unit: str, scale: float, ax: Axes) -> None:
    frequency, points = loop_frequencies(survey)
    values = np.abs(np.atleast_1d(system(points))) / scale
    label = f"peak {peak.value / scale:.3g} {unit} at {peak.frequency_hz:.4g} Hz"
    ax.loglog(frequency, values, color=BLUE)
    ax.plot(peak.frequency_hz, peak.value / scale, "o", color=ORANGE, markersize=5, label=label)


def plot_disturbance(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the load's deviation under the torque step, until it has recovered."""
    step, labels = survey.disturbance, survey.labels
    assert step is not None
    recovered = isfinite(step.recovery_time_s)
    end = 2.0 * step.recovery_time_s if recovered and step.recovery_time_s else np.inf
    shown = step.response.time <= end
    scale, unit = labels.position_scale, labels.position_unit
    load = step.deviation[shown] / scale
    ax.plot(step.response.time[shown], load, color=BLUE, label="load")
    tenth = 0.1 * step.peak / scale
    ax.axhspan(-tenth, tenth, color=GREEN, alpha=0.2, label="a tenth of the peak")
    told = (
        f"back within it at {step.recovery_time_s:.3g} s"
        if recovered
        else f"stays at {step.final / scale:.3g} {unit}"
    )
    ax.legend(loc="upper right", title=f"peak {step.peak / scale:.3g} {unit}\n{told}")
    title = f"{step.torque:.4g} {labels.torque_unit} on the {step.on}, command still"
    return finish(ax, title, "time [s]", f"load [{unit}]")


def plot_budget(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the sources of error as bars: random ones rms, and together; deterministic ones peak."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    random = [source for source in survey.budget if source.kind == "random"]
    bars = [(f"{s.name}\n(rms)", s.load, BLUE) for s in random]
    if len(random) > 1:
        bars.append(("random ones\ntogether (rms)", total_of(random)[0], GREY))
    others = [source for source in survey.budget if source.kind == "deterministic"]
    bars += [(f"{s.name}\n(peak)", s.load, ORANGE) for s in others]
    drawn = ax.barh([name for name, _, _ in bars], [load / scale for _, load, _ in bars])
    for bar, (_, load, color) in zip(drawn, bars, strict=True):
        bar.set_color(color)
        ax.annotate(
            f" {load / scale:.3g}",
            (load / scale, bar.get_y() + 0.5 * bar.get_height()),
            va="center",
        )
    largest = max([load / scale for _, load, _ in bars], default=1.0) or 1.0
    least = min([load / scale for _, load, _ in bars if load > 0.0], default=largest)
    if any(load > 0.0 for _, load, _ in bars):
        ax.set_xscale("log")
        ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlim(10.0 ** floor(log10(0.5 * least)), 10.0 ** ceil(log10(3.0 * largest)))
    ax.set_ylim(max(len(bars), _FEWEST_BARS) - 0.5, -0.5)
    return finish(ax, "Errors of the load by source", f"error [{unit}]", "")


def plot_tracking(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the load's error while it tracks, from when it counts."""
    scale, unit = survey.labels.position_scale, survey.labels.position_unit
    for each, color in zip(survey.tracking[:_MOST], _COLORS, strict=False):
        time = each.response.time - each.response.time[0]
        counted = time >= each.tracking.after
        label = f"{each.name}: rms {each.rms_error / scale:.3g}, peak {each.peak_error / scale:.3g}"
        error = each.response.load_error[counted] / scale
        ax.plot(time[counted], error, color=color, linewidth=0.9, label=label)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.3 * (high - low))
    ax.legend(loc="upper right")
    return finish(ax, "Tracking", "time [s]", f"command − load [{unit}]")
