"""Pictures of motions: time plots of trajectories and followers, and phase planes."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...shaping import FollowerResponse, Trajectory
from ...shaping.derivatives import derivative_name
from .style import BLUE, GREY, ORANGE, curve_times, unit_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_STYLES = ("-", "--", "-.", ":")


def plot_trajectory(
    trajectory: Trajectory, *, unit: str = "", time_unit: str = "s", scale: float = 1.0
) -> Figure:
    """Return a picture of a trajectory: position and every derivative, one panel each.

    Parameters
    ----------
    trajectory : Trajectory
    unit, time_unit : str, optional
        For the labels.
    scale : float, optional
        Trajectory units per `unit`.
    """
    rows = trajectory.order + 1
    figure = Figure(figsize=(8.0, 1.6 * rows + 0.6), layout="constrained")
    panels = figure.subplots(rows, 1, sharex=True)
    time = curve_times(trajectory)
    for k, ax in enumerate(panels):
        ax.plot(time, trajectory(time, k) / scale, color=BLUE)
        ax.set_ylabel(derivative_name(k) + unit_label(unit, time_unit, k))
        ax.grid(alpha=0.3)
        for switch in trajectory.switch_times:
            ax.axvline(switch, color=GREY, linewidth=0.5, linestyle=":")
    panels[-1].set_xlabel(f"time [{time_unit}]")
    figure.align_ylabels(panels)
    return figure


def plot_motions(
    motions: Mapping[str, Trajectory],
    derivative: int,
    *,
    ax: Axes,
    unit: str = "",
    time_unit: str = "s",
) -> Axes:
    """Draw one derivative of several motions, labelled by their names.

    Parameters
    ----------
    motions : mapping of str to Trajectory
    derivative : int
    ax : Axes
    unit, time_unit : str, optional
        For the labels.
    """
    for (name, motion), style in zip(motions.items(), cycle(_STYLES), strict=False):
        time = curve_times(motion)
        ax.plot(time, motion(time, derivative), style, label=name)
    ax.set_xlabel(f"time [{time_unit}]")
    ax.set_ylabel(derivative_name(derivative) + unit_label(unit, time_unit, derivative))
    ax.grid(alpha=0.3)
    return ax


def plot_following(
    response: FollowerResponse, *, ax: Axes, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw the commands as steps, and the position that follows them, against time."""
    edges = np.concatenate([[0.0], response.time])
    ax.stairs(response.commands, edges, color=GREY, baseline=None, label="command")
    ax.plot(response.time, response.states[0], color=BLUE, label="position")
    ax.set_xlabel(f"time [{time_unit}]")
    ax.set_ylabel("position" + unit_label(unit, time_unit, 0))
    ax.grid(alpha=0.3)
    return ax


def plot_phase_plane(
    response: FollowerResponse, *, ax: Axes, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw velocity against position, and where the command changed (Thompson, Figure 2c)."""
    position, velocity = response.states[:2]
    ax.plot(position, velocity, color=BLUE)
    changed = 1 + np.flatnonzero(np.diff(response.commands))
    before = changed - 1  # the state in which the new command was met
    ax.plot(position[before], velocity[before], "o", color=ORANGE, label="command changes")
    ax.set_xlabel("position" + unit_label(unit, time_unit, 0).replace("\n", " "))
    ax.set_ylabel("velocity" + unit_label(unit, time_unit, 1))
    ax.grid(alpha=0.3)
    return ax
