"""Pictures of a sweep: a figure's histogram, what moves it, and how."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from .style import BLUE, GREY, ORANGE, RED, finish, panels_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.sweep_result import SweepResult

_MOST_IN_A_MATRIX = 5
_DOTS = 4_000  # of a scatter; more are thinned


def plot_sweep(result: SweepResult, *, figure: Figure | None = None) -> Figure:
    """Return four pictures of a sweep's first figure.

    Its histogram with the limits required; a tornado of conditional means, over which range its
    mean moves with each parameter (`SweepResult.swings`); its values over the parameter that moves
    it most; and, of two parameters at least, its contours over the first two of them.

    Parameters
    ----------
    result : SweepResult
        `result.of(name)` has another figure first.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
    """
    figure = panels_figure(figure, (10.0, 7.0))
    panels = figure.subplots(2, 2)
    name = result.figures[0]
    order = [p for p in result.swings(name) if _is_number(result, p)]
    _histogram(panels[0, 0], result, name)
    _tornado(panels[0, 1], result, name)
    if order:
        _scatter(panels[1, 0], result, order[0], name)
    if len(order) > 1:
        _contours(panels[1, 1], result, order[0], order[1], name)
    for ax, shown in ((panels[1, 0], order), (panels[1, 1], order[1:])):
        if not shown:
            ax.set_axis_off()
    return figure


def plot_scatter_matrix(result: SweepResult, *, figure: Figure | None = None) -> Figure:
    """Return a picture of every figure over every parameter, the first five of each.

    Parameters
    ----------
    result : SweepResult
    figure : Figure, optional
        As in `plot_sweep`.

    Returns
    -------
    Figure
        Axes have the names of figures and parameters, with their units.
    """
    rows = result.figures[:_MOST_IN_A_MATRIX]
    columns = [p for p in result.parameters if _is_number(result, p)][:_MOST_IN_A_MATRIX]
    figure = panels_figure(figure, (1.0 + 2.6 * max(len(columns), 1), 1.0 + 2.2 * len(rows)))
    panels = figure.subplots(
        len(rows), max(len(columns), 1), sharex="col", sharey="row", squeeze=False
    )
    for i, name in enumerate(rows):
        for j, parameter in enumerate(columns):
            _scatter(panels[i, j], result, parameter, name)
    for ax in figure.axes:
        ax.label_outer()
    return figure


def _is_number(result: SweepResult, parameter: str) -> bool:
    return bool(result.dataset[parameter].dtype.kind == "f")


def _label(result: SweepResult, name: str) -> str:
    """Return a figure in words, or a parameter's key, with the unit."""
    unit = result.dataset[name].attrs.get("units", "")
    told = name.replace("_", " ") if name in result.figures else name
    return f"{told} [{unit}]" if unit else told


def _histogram(ax: Axes, result: SweepResult, name: str) -> None:
    values = result.values(name)
    known = values[np.isfinite(values)]
    ax.hist(known, bins="auto", color=BLUE, alpha=0.8)
    for bound in result.requirements.get(name, ()):
        if isfinite(bound):
            ax.axvline(bound, color=RED, linestyle="--", label=f"required {bound:.4g}")
    missing = values.size - known.size
    title = f"{known.size} points" + (f", {missing} without a finite value" if missing else "")
    finish(ax, title, _label(result, name), "points")
    if ax.get_legend_handles_labels()[0]:
        ax.legend()


def _tornado(ax: Axes, result: SweepResult, name: str) -> None:
    swings = list(result.swings(name).items())[::-1]
    for row, (_, (low, high)) in enumerate(swings):
        ax.plot([low, high], [row, row], color=ORANGE, linewidth=14, solid_capstyle="butt")
    values = result.values(name)
    if np.isfinite(values).any():
        ax.axvline(float(np.nanmean(values)), color=GREY, linestyle=":", label="mean")
        ax.legend()
    ax.margins(x=0.05)
    ax.set_yticks(range(len(swings)), [parameter for parameter, _ in swings])
    title = "conditional means over each parameter"
    finish(ax, title, f"mean {_label(result, name)}, all else varying", "")


def _scatter(ax: Axes, result: SweepResult, parameter: str, name: str) -> None:
    x, y = result.dataset[parameter].values, result.values(name)
    if x.size > _DOTS:  # by chance: every second point of a grid has every second value alone
        some = np.random.default_rng(0).choice(x.size, _DOTS, replace=False)
        x, y = x[some], y[some]
    ax.plot(x, y, ".", color=BLUE, ms=3, alpha=0.5)
    for bound in result.requirements.get(name, ()):
        if isfinite(bound):
            ax.axhline(bound, color=RED, linestyle="--", linewidth=0.8)
    finish(ax, "", _label(result, parameter), _label(result, name))


def _contours(ax: Axes, result: SweepResult, first: str, second: str, name: str) -> None:
    x, y = result.dataset[first].values, result.dataset[second].values
    values = result.values(name)
    known = np.isfinite(values)
    places, at = np.unique(np.stack([x[known], y[known]]), axis=1, return_inverse=True)
    if places.shape[1] < 4 or (np.ptp(places, axis=1) == 0.0).any():
        ax.set_axis_off()
        return
    means = np.bincount(at, values[known]) / np.bincount(at)  # of a grid, over all else
    (u, v), scales = places, np.ptp(places, axis=1)  # triangles of the picture's own shape
    mesh = Triangulation(u, v, Triangulation(u / scales[0], v / scales[1]).triangles)
    drawn = ax.tricontourf(mesh, means, levels=12, cmap="viridis")
    bar = ax.get_figure().colorbar(drawn, ax=ax)  # type: ignore[union-attr]
    bar.set_label(_label(result, name) if at.size == means.size else f"mean {_label(result, name)}")
    finish(ax, "", _label(result, first), _label(result, second))
