"""What the pictures have in common: colours, density of curves, labels with units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..shaping import Trajectory
    from ..shaping.pieces import FloatArray

BLUE, ORANGE, GREEN, RED, GREY = "#0b5394", "#e07b00", "#2e7d32", "#b3261e", "#666666"
PURPLE = "#7b3fa0"
ORDER_COLORS = {2: RED, 3: PURPLE, 4: GREEN, 5: ORANGE, 6: BLUE}
"""Colours of shapers that are told apart by their order."""

CURVE_POINTS = 400
"""Points of a curve, at least: smooth at any size of paper."""


def panels_figure(
    figure: Figure | None,
    size: tuple[float, float],
    layout: Literal["constrained", "none"] = "constrained",
) -> Figure:
    """Return the figure that a picture of several panels is drawn in.

    One that is given gets the size that the picture needs. Default: pyplot's current figure if
    nothing is drawn in it yet, else a new one of pyplot's, so that nothing is drawn over.
    """
    if figure is None:
        from matplotlib import pyplot

        drawn = not pyplot.get_fignums() or pyplot.gcf().get_children()[1:]  # but its background
        figure = pyplot.figure(figsize=size) if drawn else pyplot.gcf()
    else:
        figure.set_size_inches(size)
    figure.set_layout_engine(layout)
    return figure


def single_axes(ax: Axes | None, size: tuple[float, float]) -> Axes:
    """Return the Axes given, else pyplot's current ones; those of a new figure of this size."""
    if ax is not None:
        return ax
    from matplotlib import pyplot

    if not pyplot.get_fignums():
        pyplot.figure(figsize=size, layout="constrained")
    return pyplot.gca()


def curve_times(trajectory: Trajectory) -> FloatArray:
    """Return times at which a trajectory is drawn: both sides of every jump."""
    if not len(trajectory.states):
        return trajectory.breaks
    inside = [
        np.linspace(left, np.nextafter(right, left), max(CURVE_POINTS // len(trajectory.states), 8))
        for left, right in zip(trajectory.breaks[:-1], trajectory.breaks[1:], strict=True)
    ]
    return np.concatenate([*inside, trajectory.breaks[-1:]])


def with_rest(trajectory: Trajectory) -> FloatArray:
    """Return `curve_times` with a twentieth of the duration before and after, at rest."""
    start, end, wait = trajectory.start_time, trajectory.end_time, 0.05 * trajectory.duration
    before, after = [start - wait, np.nextafter(start, -np.inf)], [end + wait]
    return np.concatenate([before, curve_times(trajectory), after])


def unit_label(unit: str, time_unit: str, k: int) -> str:
    """Return the unit of derivative k as a label's second line; nothing without a unit."""
    if not unit:
        return ""
    return f"\n[{unit}]" if k == 0 else f"\n[{unit}/{time_unit}{superscript(k)}]"


def superscript(k: int) -> str:
    """Return a power as superscript digits, nothing for 1."""
    return "" if k == 1 else str(k).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def plain(text: str) -> str:
    """Return text as it is to matplotlib, which takes what stands between $ for mathematics."""
    return text.replace("$", r"\$")


def finish(ax: Axes, title: str, xlabel: str, ylabel: str) -> Axes:
    """Give an Axes its title, labels and grid, and logarithmic axes their powers."""
    from .powers import label_powers  # matplotlib, which not every user of this module draws with

    label_powers(ax)
    ax.set_title(plain(title), fontsize=11)
    ax.set_xlabel(xlabel)
    ax.set_ylabel(ylabel)
    ax.grid(alpha=0.3)
    return ax
