"""Pictures of motions: time plots of trajectories and followers, and phase planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from ..shaping import FollowerResponse, Limits, Trajectory, binding_limits
from ..shaping.checks import positive
from ..shaping.derivatives import derivative_name
from ..shaping.limits import of_one
from ..shaping.optimal.binding import BINDING_RTOL
from ..shaping.trajectory import Motion, as_trajectory
from .style import (
    BLUE,
    CURVE_POINTS,
    GREY,
    ORANGE,
    RED,
    curve_times,
    panels_figure,
    single_axes,
    unit_label,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..shaping.pieces import FloatArray

_SIZE = (8.0, 4.5)  # inches, of a new figure
_STYLES = ("-", "--", "-.", ":")
_TOUCH_POINTS = 50  # a piece; a parabola from bound to bound is within 1e-3 for 2 % of its time


def plot_trajectory(
    trajectory: Motion,
    *,
    limits: Limits | None = None,
    unit: str = "",
    time_unit: str = "s",
    scale: float = 1.0,
    figure: Figure | None = None,
) -> Figure:
    """Return a picture of a trajectory: position and every derivative, one panel each.

    Parameters
    ----------
    trajectory : Trajectory
    limits : Limits, optional
        Drawn as dashed lines. A derivative's curve is thick and orange where it is within 1e-3 of
        its bound, be it a touch, and bands show the pieces all along which it is
        (`binding_limits`). Without limits the bands show where a derivative stays at its own peak.
    unit, time_unit : str, optional
        For the labels.
    scale : float, optional
        Trajectory units per `unit`, positive.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
        A trajectory of duration zero is a dot in each panel.

    Raises
    ------
    TypeError
        For limits of another kind.
    ValueError
        For a scale that is not positive.
    """
    if limits is not None:
        of_one(limits)
    trajectory, scale = as_trajectory(trajectory), positive("scale", scale)
    rows = trajectory.order + 1
    figure = panels_figure(figure, (8.0, 1.6 * rows + 0.6), "none")
    panels = figure.subplots(rows, 1, sharex=True, gridspec_kw=_margins(figure))
    time, marker = curve_times(trajectory), None if len(trajectory.states) else "o"
    for k, ax in enumerate(panels):
        ax.plot(time, trajectory(time, k) / scale, color=BLUE, marker=marker)
        ax.set_ylabel(derivative_name(k) + unit_label(unit, time_unit, k))
        ax.grid(alpha=0.3)
        for switch in trajectory.switch_times:
            ax.axvline(switch, color=GREY, linewidth=0.5, linestyle=":")
    if limits is not None:
        _draw_limits(trajectory, limits, panels, scale)
        _draw_reached(trajectory, limits, panels, scale)
    _colour(trajectory, _extremes(trajectory) if limits is None else limits, panels)
    panels[-1].set_xlabel(f"time [{time_unit}]")
    figure.align_ylabels(panels)
    return figure


def _margins(figure: Figure) -> dict[str, float]:
    """Return the place of panels below each other, for two lines of label beside numbers.

    Matplotlib's own search for it takes as long as the picture.
    """
    (width, height), line = figure.get_size_inches(), rcParams["font.size"] / 72.0
    return {
        "left": 8.8 * line / width,
        "right": 1.0 - line / width,
        "bottom": 4.0 * line / height,
        "top": 1.0 - 1.6 * line / height,
        "hspace": 0.15,
    }


def _draw_limits(
    trajectory: Trajectory, limits: Limits, panels: Sequence[Axes], scale: float
) -> None:
    """Draw the bounds on the sides in use."""
    for k, ax in enumerate(panels[1:], start=1):
        values = trajectory(curve_times(trajectory), k)
        for bound in limits.bounds(k):
            if isfinite(bound) and (values * bound).max() > 0.0:
                ax.axhline(bound / scale, color=RED, linewidth=0.8, linestyle="--", zorder=1)


def _draw_reached(
    trajectory: Trajectory, limits: Limits, panels: Sequence[Axes], scale: float
) -> None:
    """Draw the curves again, thick and orange, where they are at a bound, even for an instant."""
    time = _fine_times(trajectory)
    for k, ax in enumerate(panels[1:], start=1):
        values = trajectory(time, k)
        lower, upper = (bound * (1.0 - BINDING_RTOL) for bound in limits.bounds(k))
        for at in (values >= upper, values <= lower):
            if at.any():
                shown = np.where(at, values / scale, np.nan)
                [line] = ax.plot(time, shown, "o-", color=ORANGE, linewidth=3.0)
                line.set(markersize=3.0, markeredgewidth=0.0)
                line.set_markevery(np.flatnonzero(at & ~np.append(False, at[:-1])).tolist())


def _fine_times(trajectory: Trajectory) -> FloatArray:
    """Return times close enough together to meet a derivative that touches its bound."""
    starts, ends = trajectory.breaks[:-1, None], trajectory.breaks[1:, None]
    points = max(10 * CURVE_POINTS // max(len(starts), 1), _TOUCH_POINTS)
    inside = starts + (ends - starts) * np.linspace(0.0, 1.0, points)
    return np.minimum(inside, np.nextafter(ends, starts)).ravel()


def _extremes(trajectory: Trajectory) -> Limits | None:
    """Return the extremes of a motion as limits; None where nothing moves."""
    extremes = [trajectory.extremes(k) for k in range(1, trajectory.order + 1)]
    if not any(low < 0.0 or high > 0.0 for low, high in extremes):
        return None
    return Limits.from_bounds(
        (low if low < 0.0 else -inf, high if high > 0.0 else inf) for low, high in extremes
    )


def _colour(trajectory: Trajectory, limits: Limits | None, panels: Sequence[Axes]) -> None:
    """Colour the pieces in which a derivative is at its limit."""
    if limits is None:
        return
    ends = zip(trajectory.breaks[:-1], trajectory.breaks[1:], strict=True)
    for active, (start, end) in zip(binding_limits(trajectory, limits), ends, strict=True):
        for k in active:
            panels[k].axvspan(start, end, color=ORANGE, alpha=0.2, linewidth=0)


def plot_motions(
    motions: Mapping[str, Motion],
    derivative: int,
    *,
    ax: Axes | None = None,
    unit: str = "",
    time_unit: str = "s",
) -> Axes:
    """Draw one derivative of several motions, labelled by their names.

    Parameters
    ----------
    motions : mapping of str to Trajectory
    derivative : int
    ax : Axes, optional
        Default: pyplot's current ones.
    unit, time_unit : str, optional
        For the labels.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    for (name, motion), style in zip(motions.items(), cycle(_STYLES), strict=False):
        time = curve_times(as_trajectory(motion))
        ax.plot(time, motion(time, derivative), style, label=name)
    ax.set_xlabel(f"time [{time_unit}]")
    ax.set_ylabel(derivative_name(derivative) + unit_label(unit, time_unit, derivative))
    ax.grid(alpha=0.3)
    return ax


def plot_following(
    response: FollowerResponse, *, ax: Axes | None = None, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw the commands as steps, and the position that follows them, against time.

    Parameters
    ----------
    response : FollowerResponse
        Of a `CommandFollower`.
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    unit, time_unit : str, optional
        Of positions and times, for the labels.

    Returns
    -------
    Axes
    """
    ax, edges = single_axes(ax, _SIZE), np.concatenate([[0.0], response.time])
    ax.stairs(response.commands, edges, color=GREY, baseline=None, label="command")
    ax.plot(response.time, response.states[0], color=BLUE, label="position")
    ax.set_xlabel(f"time [{time_unit}]")
    ax.set_ylabel("position" + unit_label(unit, time_unit, 0))
    ax.grid(alpha=0.3)
    return ax


def plot_phase_plane(
    response: FollowerResponse, *, ax: Axes | None = None, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw velocity against position, and where the command changed (Thompson, Figure 2c).

    Parameters
    ----------
    response : FollowerResponse
        Of a `CommandFollower`.
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    unit, time_unit : str, optional
        Of positions and times, for the labels.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    position, velocity = response.states[:2]
    ax.plot(position, velocity, color=BLUE)
    changed = 1 + np.flatnonzero(np.diff(response.commands))
    before = changed - 1  # the state in which the new command was met
    ax.plot(position[before], velocity[before], "o", color=ORANGE, label="command changes")
    ax.set_xlabel("position" + unit_label(unit, time_unit, 0).replace("\n", " "))
    ax.set_ylabel("velocity" + unit_label(unit, time_unit, 1))
    ax.grid(alpha=0.3)
    return ax
