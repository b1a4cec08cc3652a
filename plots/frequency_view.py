"""Pictures of shapers as filters: responses, residual vibration, nulls, cascaded lags."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..shaping.checks import finite, positive
from .style import BLUE, GREY, ORANGE, finish, panels_figure, single_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.frequency_view import (
        CascadedLags,
        FrequencyResponse,
        NullBySize,
        ShaperSensitivity,
        VibrationMap,
    )
    from ..shaping.pieces import FloatArray

_SIZE = (8.0, 5.5)  # inches, of a new figure
_STYLES = ("-", "--", "-.", ":")
_DECADE = 10.0  # a range this wide is drawn on a logarithmic axis
_LARGEST_ERROR_DB = 20.0


def plot_frequency_responses(
    responses: Mapping[str, FrequencyResponse],
    *,
    ax: Axes | None = None,
    duration: float | None = None,
    lowest_db: float = -120.0,
    time_unit: str = "s",
) -> Axes:
    """Draw the gains of several shapers over frequency, labelled by their names.

    Parameters
    ----------
    responses : mapping of str to FrequencyResponse
        Drawn where their frequencies are positive.
    ax : Axes, optional
        Default: pyplot's current ones.
    duration : float, optional
        Count frequencies in cycles per this duration.
    lowest_db : float, optional
        Lower end of the axis: a null has no bottom.
    time_unit : str, optional
        For the label.

    Returns
    -------
    Axes
    """
    ax, cycles = single_axes(ax, _SIZE), 1.0 if duration is None else positive("duration", duration)
    lowest_db = finite("lowest_db", lowest_db)
    for (name, response), style in zip(responses.items(), cycle(_STYLES), strict=False):
        shown = response.omega > 0.0
        frequency = response.omega[shown] * cycles / (2.0 * np.pi)
        ax.semilogx(frequency, response.gain_db[shown], style, linewidth=1.2, label=name)
    ax.set_ylim(lowest_db, -0.04 * lowest_db)
    ax.legend(loc="lower left")
    label = _hz(time_unit) if duration is None else "cycles per duration"
    return finish(ax, "Shapers as filters", label, "|v(jω)| / R [dB]")


def plot_vibration_map(
    vibration: VibrationMap,
    *,
    ax: Axes | None = None,
    unit: str = "",
    time_unit: str = "s",
    lowest_db: float = -80.0,
) -> Axes:
    """Draw the residual vibration over distance and frequency; the nulls are the dark lines.

    Parameters
    ----------
    vibration : VibrationMap
    ax : Axes, optional
        Default: pyplot's current ones.
    unit, time_unit : str, optional
        For the labels.
    lowest_db : float, optional
        What is lower has the colour of this.

    Returns
    -------
    Axes
    """
    ax, lowest_db = single_axes(ax, _SIZE), finite("lowest_db", lowest_db)
    rows, columns = np.argsort(np.abs(vibration.distances)), np.argsort(vibration.frequencies_hz)
    with np.errstate(divide="ignore"):
        level = 20.0 * np.log10(vibration.relative[np.ix_(rows, columns)])
    distances, frequencies = np.abs(vibration.distances[rows]), vibration.frequencies_hz[columns]
    highest = max(0.0, float(level.max()))
    mesh = ax.pcolormesh(
        distances,
        frequencies,
        np.maximum(level, lowest_db).T,
        shading="nearest",
        cmap="magma",
        vmin=lowest_db,
        vmax=highest,
        rasterized=True,
    )
    _scale(ax, distances, frequencies)
    bar = ax.figure.colorbar(mesh, ax=ax, extend="min")
    bar.set_label("residual amplitude / distance [dB]")
    finish(
        ax, "Residual vibration" + _damping(vibration), _distance(unit), "mode: " + _hz(time_unit)
    )
    ax.grid(False)
    return ax


def plot_vibration_by_size(
    vibration: VibrationMap,
    *,
    ax: Axes | None = None,
    unit: str = "",
    time_unit: str = "s",
    lowest_percent: float = 1e-3,
) -> Axes:
    """Draw the residual vibration over the distance, one curve for each frequency.

    Parameters
    ----------
    vibration : VibrationMap
        With the few frequencies that are to be drawn.
    ax : Axes, optional
        Default: pyplot's current ones.
    unit, time_unit : str, optional
        For the labels.
    lowest_percent : float, optional
        Lower end of the axis: a null has no bottom.

    Returns
    -------
    Axes
    """
    lowest_percent = positive("lowest_percent", lowest_percent)
    ax, rows = single_axes(ax, _SIZE), np.argsort(np.abs(vibration.distances))
    distances, relative = np.abs(vibration.distances[rows]), vibration.relative[rows]
    name = "Hz" if time_unit == "s" else f"/{time_unit}"
    for frequency, column, style in zip(
        vibration.frequencies_hz, relative.T, cycle(_STYLES), strict=False
    ):
        shown = np.maximum(100.0 * column, 0.1 * lowest_percent)
        ax.semilogy(distances, shown, style, linewidth=1.2, label=f"{frequency:.4g} {name}")
    _scale(ax, distances, None)
    ax.set_ylim(lowest_percent, max(150.0, 150.0 * float(relative.max())))
    ax.legend(loc="lower left", title="mode")
    title = "Residual vibration" + _damping(vibration)
    return finish(ax, title, _distance(unit), "residual amplitude / distance [%]")


def plot_null_by_size(
    nulls: NullBySize, *, ax: Axes | None = None, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw the null nearest to a frequency over the distance, and whether it stays or moves.

    Parameters
    ----------
    nulls : NullBySize
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    unit, time_unit : str, optional
        Of positions and times, for the labels.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    distances = np.abs(nulls.distances)
    for chosen, color, marker, name in (
        (nulls.stays, BLUE, "o", "stays"),
        (~nulls.stays, ORANGE, "x", "moves with the distance"),
    ):
        ax.plot(distances[chosen], nulls.null_hz[chosen], marker, color=color, ms=4, label=name)
    ax.axhline(nulls.frequency_hz, color=GREY, linestyle="--", linewidth=0.8, label="asked for")
    _scale(ax, distances, nulls.null_hz[np.isfinite(nulls.null_hz)])
    ax.legend(loc="best")
    return finish(ax, "Null by move size", _distance(unit), "nearest null: " + _hz(time_unit))


def plot_shaper_sensitivity(
    result: ShaperSensitivity, *, ax: Axes | None = None, lowest_percent: float = 0.0
) -> Axes:
    """Draw what shapers and moves leave of a mode over the ratio of its frequency to that expected.

    Parameters
    ----------
    result : ShaperSensitivity
    ax : Axes, optional
        Default: pyplot's current ones.
    lowest_percent : float, optional
        Above 0 the axis is logarithmic down to this.
    """
    lowest_percent = finite("lowest_percent", lowest_percent)
    ax = single_axes(ax, _SIZE)
    rows = zip(result.names, result.durations, result.residual, cycle(_STYLES), strict=False)
    for name, duration, residual, style in rows:
        ax.plot(
            result.ratios, 100.0 * residual, style, linewidth=1.2, label=f"{name}, {duration:.4g}"
        )
    if lowest_percent > 0.0:
        ax.set_yscale("log")
    ax.set_ylim(bottom=lowest_percent)
    ax.axvline(1.0, color=GREY, linestyle=":", linewidth=0.8)
    ax.legend(loc="best", title="duration")
    title = f"Sensitivity at {result.frequency_hz:.4g}, damping {result.damping:.4g}"
    return finish(ax, title, "frequency / expected", "left of a step's vibration [%]")


def plot_cascaded_lags(
    result: CascadedLags, *, time_unit: str = "s", figure: Figure | None = None
) -> Figure:
    """Return a picture of a shaper's gain, that of the lags, and the error between them.

    Parameters
    ----------
    result : CascadedLags
    time_unit : str, optional
        For the label.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
    """
    figure = panels_figure(figure, (8.0, 6.0))
    gains, errors = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    shown = result.exact.omega > 0.0
    frequency = result.exact.omega[shown] / (2.0 * np.pi)
    exact, lags = result.exact.gain_db[shown], result.approximation.gain_db[shown]
    gains.semilogx(frequency, exact, color=BLUE, linewidth=1.2, label="exact")
    name = "1 lag" if len(result.lags) == 1 else f"{len(result.lags)} lags"
    gains.semilogx(frequency, lags, "--", color=ORANGE, label=name)
    lowest = float(lags.min()) - 2.0 * _LARGEST_ERROR_DB if shown.any() else -100.0
    gains.set_ylim(lowest, 5.0)
    errors.semilogx(frequency, result.error_db[shown], color=ORANGE, linewidth=1.2)
    lowest = float(result.error_db[shown].min(initial=0.0))
    errors.set_ylim(min(-_LARGEST_ERROR_DB, lowest - 2.0), _LARGEST_ERROR_DB)
    corner_hz = result.corner_omega / (2.0 * np.pi)
    for ax in (gains, errors):
        ax.axvline(corner_hz, color=GREY, linestyle=":", label="exact gain at −3 dB")
    gains.legend(loc="lower left")
    corners = "the move's delay" if result.match == "delay" else "Thompson's corners V/R, A/V, …"
    finish(gains, f"Lags in series, with {corners}", "", "|v(jω)| / R [dB]")
    title = f"error up to the corner: {result.error_to_corner_db:+.2f} dB".replace("-", "−")
    finish(errors, title, _hz(time_unit), "lags / exact [dB]")
    figure.align_ylabels([gains, errors])
    return figure


def _scale(ax: Axes, horizontal: FloatArray, vertical: FloatArray | None) -> None:
    """Make an axis logarithmic where its values span more than a decade."""
    for values, set_scale in ((horizontal, ax.set_xscale), (vertical, ax.set_yscale)):
        if values is not None and values.size and values.max() > _DECADE * values.min():
            set_scale("log")


def _hz(time_unit: str) -> str:
    return "frequency [Hz]" if time_unit == "s" else f"frequency [1/{time_unit}]"


def _distance(unit: str) -> str:
    return f"distance [{unit}]" if unit else "distance"


def _damping(vibration: VibrationMap) -> str:
    return f", damping {vibration.damping:.4g}" if vibration.damping else ""
