"""Pictures of a log's conformance: derivatives with error bars and limits, panel by panel."""

from __future__ import annotations

from itertools import pairwise
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..shaping.derivatives import derivative_name
from .style import BLUE, RED, panels_figure, unit_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.log_conformance import Conformance
    from ..analysis.log_conformance.bands import Band
    from ..shaping.pieces import FloatArray

_ERROR_BAR = "error bar, 95 %"
_PIECES = 1500  # of a curve: each shows its least and its greatest, finer than a printed line


def plot_conformance(
    result: Conformance, *, unit: str = "", time_unit: str = "s", figure: Figure | None = None
) -> Figure:
    """Return a picture of a log's conformance: velocity, acceleration and jerk, one panel each.

    Parameters
    ----------
    result : Conformance
    unit, time_unit : str, optional
        For the labels.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
    """
    count = len(result.bands)
    figure = panels_figure(figure, (8.0, 2.3 * count + 1.0))
    panels = figure.subplots(count, 1, sharex=True)
    for k, ax in enumerate(panels, start=1):
        plot_band(result, k, ax=ax)
        ax.set_ylabel(derivative_name(k) + unit_label(unit, time_unit, k))
    panels[-1].set_xlabel(f"time [{time_unit}]")
    figure.align_ylabels(panels)
    handles = {
        label: handle
        for ax in panels
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=len(handles))
    return figure


def plot_band(result: Conformance, derivative: int, *, ax: Axes) -> Axes:
    """Draw one derivative of a log with its error bars and limits, verdicts in the title.

    Parameters
    ----------
    result : Conformance
    derivative : int
        1 velocity, 2 acceleration, 3 jerk.
    ax : Axes
    """
    band = result.band(derivative)
    for part in _parts(band):
        time, value, low, high = _thinned(band, part)
        ax.fill_between(time, low, high, color=BLUE, alpha=0.25, linewidth=0.0, label=_ERROR_BAR)
        ax.plot(time, value, color=BLUE, linewidth=1.2, label="fit")
    bounds = [side for side in result.limits.bounds(derivative) if isfinite(side)]
    for side in bounds:
        ax.axhline(side, color=RED, linestyle="--", linewidth=1.0, zorder=1.9, label="limit")
    ax.set_ylim(*_extent(band, bounds))
    ax.set_title(_title(result, derivative), loc="left", fontsize=10)
    ax.grid(alpha=0.3)
    return ax


def _title(result: Conformance, derivative: int) -> str:
    verdicts = [
        f"{peak.name}: {peak.verdict}"
        for peak in result.peaks
        if peak.derivative == derivative and isfinite(peak.limit)
    ]
    return ",  ".join(verdicts) or f"{derivative_name(derivative)}: no limit"


def _parts(band: Band) -> list[slice]:
    return [slice(*pair) for pair in pairwise([*band.starts, len(band.times)])]


def _thinned(band: Band, part: slice) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return times, values, lower and upper ends; of long curves the extremes piece by piece."""
    time, value, error = band.times[part], band.values[part], band.error[part]
    if len(time) <= 2 * _PIECES:
        return time, value, value - error, value + error
    starts = np.linspace(0, len(time), _PIECES, endpoint=False).astype(int)
    extremes = np.minimum.reduceat(value, starts), np.maximum.reduceat(value, starts)
    return (
        np.repeat(time[starts], 2),
        np.column_stack(extremes).ravel(),
        np.repeat(np.minimum.reduceat(value - error, starts), 2),
        np.repeat(np.maximum.reduceat(value + error, starts), 2),
    )


def _extent(band: Band, bounds: list[float]) -> tuple[float, float]:
    """Return the ends of the axis: values, limits, and error bars but for those of the ends."""
    seldom = (0.005, 0.995)
    ends = [np.quantile(band.values + sign * band.error, seldom) for sign in (-1.0, 1.0)]
    shown = np.concatenate([*ends, [band.values.min(), band.values.max()], bounds])
    room = 0.08 * float(np.ptp(shown)) or 1.0
    return float(shown.min()) - room, float(shown.max()) + room
