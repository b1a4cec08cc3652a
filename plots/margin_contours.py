"""Pictures of margins of many loops: contours over a plane of loops."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MaxNLocator

from ..shaping.trajectory_checks import finite_array
from .style import BLUE, GREY, finish, single_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from ..analysis.margins.many_margins import ManyMargins
    from ..shaping.pieces import FloatArray

TITLES = {
    "crossover_hz": "Crossover [Hz]",
    "phase_margin_deg": "Phase margin [deg]",
    "lower_gain_margin_db": "Lower gain margin [dB]",
    "lower_gain_margin_hz": "Frequency of the lower gain margin [Hz]",
    "upper_gain_margin_db": "Upper gain margin [dB]",
    "upper_gain_margin_hz": "Frequency of the upper gain margin [Hz]",
    "delay_margin_s": "Delay margin [s]",
    "delay_margin_hz": "Frequency of the delay margin [Hz]",
    "modulus_margin": "Modulus margin, min |1 + L|",
    "modulus_margin_hz": "Frequency of the modulus margin [Hz]",
}
"""Margins that can be drawn, and what they are called."""

_UNSTABLE, _NO_LIMIT = "#e4e4e4", "#d9ead3"
_HATCH = "///"
_COLORS = "YlGnBu"
_INTERVALS = 9


def plot_margin_contours(
    margins: ManyMargins,
    x: ArrayLike,
    y: ArrayLike,
    *,
    margin: str = "phase_margin_deg",
    ax: Axes | None = None,
    levels: Sequence[float] | None = None,
    xlabel: str = "",
    ylabel: str = "",
) -> Axes:
    """Draw labelled contours of a margin over a plane of loops.

    Hatched is where a loop at a corner of the grid's cell is unstable, so that the border is
    drawn up to one cell early. Where nothing limits the margin the colour is a plain green.

    Parameters
    ----------
    margins : ManyMargins
        Of shape (M, N).
    x, y : (N,) and (M,) arrays
        What varies along the last and the first axis of the margins; ascending or descending.
    margin : str, optional
        Name of the margin.
    ax : Axes, optional
        With the scales that it is to have; default: pyplot's current ones.
    levels : sequence of float, optional
        Of the contours; default: chosen to fit.
    xlabel, ylabel : str, optional
        With units.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        For a name that is no margin's, margins not of two axes, or x and y that do not fit them
        or are not monotone.
    """
    if margin not in TITLES:
        raise ValueError(f"margin = {margin!r}: expected one of {', '.join(TITLES)}")
    if len(margins.shape) != 2:
        raise ValueError(
            f"margins of shape {margins.shape} are not a plane: pick one by indexing, such as "
            "margins[..., 0]"
        )
    across, up = _axis("x", x, margins.shape[1]), _axis("y", y, margins.shape[0])
    values = np.asarray(getattr(margins, margin), dtype=float)
    ax = single_axes(ax, (6.4, 4.8))
    whole = Rectangle((0.0, 0.0), 1.0, 1.0, transform=ax.transAxes, zorder=0.0)
    whole.set(facecolor=_UNSTABLE, edgecolor=GREY, hatch=_HATCH, linewidth=0.0)
    ax.add_patch(whole)
    _fill(ax, across, up, np.where(margins.stable, 1.0, np.nan), [0.0, 2.0], [_NO_LIMIT])
    _contours(ax, across, up, np.where(np.isfinite(values), values, np.nan), levels)
    ax.set_xlim(across.min(), across.max())
    ax.set_ylim(up.min(), up.max())
    patches = {
        "unstable": (
            Patch(facecolor=_UNSTABLE, edgecolor=GREY, hatch=_HATCH, linewidth=0.0),
            ~margins.stable,
        ),
        "no limit": (Patch(facecolor=_NO_LIMIT), margins.stable & ~np.isfinite(values)),
    }
    shown = {name: patch for name, (patch, where) in patches.items() if where.any()}
    if shown:
        ax.legend(list(shown.values()), list(shown), loc="upper right", framealpha=0.95)
    return finish(ax, TITLES[margin], xlabel, ylabel)


def _axis(name: str, given: ArrayLike, count: int) -> FloatArray:
    values = finite_array(name, given)
    if values.shape != (count,):
        raise ValueError(
            f"{name} of shape {values.shape} does not fit: expected ({count},), a value for each "
            f"{'column' if name == 'x' else 'row'} of the margins"
        )
    if count < 2 or not ((np.diff(values) > 0.0).all() or (np.diff(values) < 0.0).all()):
        raise ValueError(f"{name}: expected two values or more, ascending or descending")
    return values


def _contours(
    ax: Axes, x: FloatArray, y: FloatArray, values: FloatArray, levels: Sequence[float] | None
) -> None:
    """Fill between levels and draw those that lie within the values, with their labels."""
    known = values[np.isfinite(values)]
    if not known.size:
        return
    low, high = float(known.min()), float(known.max())
    if levels is None:
        levels = [float(level) for level in MaxNLocator(_INTERVALS).tick_values(low, high)]
    inside = sorted(
        {level for level in finite_array("levels", levels).ravel().tolist() if low < level < high}
    )
    room = max(high - low, abs(high), np.finfo(float).tiny)
    _fill(ax, x, y, values, [low - room, *inside, high + room], None)
    if inside:
        lines = ax.contour(x, y, np.ma.masked_invalid(values), inside, colors=BLUE, linewidths=0.9)
        ax.clabel(lines, fmt="%g", fontsize=9)


def _fill(
    ax: Axes,
    x: FloatArray,
    y: FloatArray,
    values: FloatArray,
    levels: list[float],
    colors: list[Any] | None,
) -> None:
    if not np.isfinite(values).any():
        return
    if colors is None:
        shades = np.linspace(0.05, 0.65, len(levels) - 1)
        colors = [colormaps[_COLORS](shade) for shade in shades]
    ax.contourf(x, y, np.ma.masked_invalid(values), levels, colors=colors)
