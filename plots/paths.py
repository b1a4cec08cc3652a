"""Pictures of several axes in step: the path in the plane, and every derivative over time."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ..shaping import Passage, Synchronized, Tour
from ..shaping.checks import positive
from ..shaping.derivatives import derivative_name
from ..shaping.trajectory import as_trajectory
from .motions import plot_trajectory
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, curve_times, panels_figure, unit_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED)


def plot_synchronized(
    axes: Synchronized,
    *,
    unit: str = "",
    time_unit: str = "s",
    scale: float = 1.0,
    figure: Figure | None = None,
) -> Figure:
    """Return a picture of axes in step: the path of the first two, and all of them over time.

    Points that they pass (`through`) are drawn as crosses, with circles as large as the distance
    that was allowed, and as dotted lines over time.

    Parameters
    ----------
    axes : Synchronized
    unit, time_unit : str, optional
        For the labels.
    scale : float, optional
        Units of the trajectories per `unit`, positive.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For a scale that is not positive.
    """
    scale, rows = positive("scale", scale), max(one.order for one in axes) + 1
    planar = len(axes) > 1
    figure = panels_figure(figure, (12.0 if planar else 8.0, 1.6 * rows + 0.6))
    grid = figure.add_gridspec(rows, 2 if planar else 1)
    if planar:
        _draw_path(figure.add_subplot(grid[:, 1]), axes, unit, scale)
    shared = None
    for k in range(rows):
        ax = shared = figure.add_subplot(grid[k, 0], sharex=shared)
        _draw_over_time(ax, axes, k, scale)
        ax.set_ylabel(derivative_name(k) + unit_label(unit, time_unit, k))
        ax.tick_params(labelbottom=k == rows - 1)
    figure.axes[int(planar)].legend(loc="upper right", fontsize=8)
    figure.axes[-1].set_xlabel(f"time [{time_unit}]")
    return figure


def _draw_over_time(ax: Axes, axes: Synchronized, k: int, scale: float) -> None:
    for number, (one, colour) in enumerate(zip(axes, cycle(_COLOURS), strict=False)):
        time = curve_times(as_trajectory(one))
        ax.plot(time, one(time, k) / scale, color=colour, label=f"axis {number}")
    if axes.passage is not None:
        _draw_times(ax, axes.passage)
    ax.grid(alpha=0.3)


def _draw_times(ax: Axes, passage: Passage) -> None:
    for time in passage.times:
        ax.axvline(time, color=GREY, linewidth=0.6, linestyle=":")


def _draw_path(ax: Axes, axes: Synchronized, unit: str, scale: float) -> None:
    """Draw the path of the first two axes, and the points that it passes."""
    time = np.unique(np.concatenate([curve_times(as_trajectory(one)) for one in axes[:2]]))
    ax.plot(*(one(time) / scale for one in axes[:2]), color=BLUE)
    if axes.passage is not None:
        places, tolerance = axes.passage.points[:, :2] / scale, axes.passage.corner / scale
        ax.plot(*places.T, "+", color=RED)
        for place in places[1:-1] if tolerance else ():
            ax.add_patch(Circle(tuple(place), tolerance, fill=False, color=RED, linewidth=0.6))
    ax.set_aspect("equal", adjustable="datalim")
    for number, name in enumerate(("xlabel", "ylabel")):
        ax.set(**{name: f"axis {number}" + unit_label(unit, "", 0).replace("\n", " ")})
    ax.grid(alpha=0.3)


def plot_tour(
    tour: Tour,
    *,
    unit: str = "",
    time_unit: str = "s",
    scale: float = 1.0,
    figure: Figure | None = None,
) -> Figure:
    """Return the picture of one axis over time (`plot_trajectory`), with the points it passes.

    Parameters
    ----------
    tour : Tour
    unit, time_unit, scale, figure : optional
        As in `plot_trajectory`.

    Returns
    -------
    Figure
    """
    figure = plot_trajectory(tour, unit=unit, time_unit=time_unit, scale=scale, figure=figure)
    passage = tour.passage
    figure.axes[0].plot(passage.times, passage.points[:, 0] / scale, "+", color=RED)
    return figure
