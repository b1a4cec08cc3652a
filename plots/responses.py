"""Pictures of a loop's response: motion, error of the load, torque beside its limit."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import BLUE, GREEN, GREY, ORANGE, RED, finish, panels_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..plant import LoopResponse


def plot_response(
    response: LoopResponse,
    *,
    tolerance: float | None = None,
    unit: str = "rad",
    scale: float = 1.0,
    torque_unit: str = "N m",
    figure: Figure | None = None,
) -> Figure:
    """Return motion, load error and torque of a response, one panel below the other.

    Parameters
    ----------
    response : LoopResponse
    tolerance : float, optional
        In rad or m, drawn about the error.
    unit : str, optional
        The unit in which positions are shown, and `scale`, its value in rad or m.
    torque_unit : str, optional
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.
    """
    figure = panels_figure(figure, (9.0, 9.0))
    motion, error, torque = figure.subplots(3, 1, sharex=True)
    time = response.time
    motion.plot(time, response.command / scale, color=GREY, label="command")
    motion.plot(time, response.load / scale, color=BLUE, label="load")
    if np.any(response.twist):
        motion.plot(time, response.motor / scale, ":", color=GREEN, label="motor")
    motion.legend(loc="best")
    finish(motion, "Motion", "", f"position [{unit}]")
    draw_load_error(response, ax=error, tolerance=tolerance, unit=unit, scale=scale)
    error.set_xlabel("")
    draw_torque(response, ax=torque, unit=torque_unit)
    return figure


def draw_load_error(
    response: LoopResponse,
    *,
    ax: Axes,
    tolerance: float | None = None,
    unit: str = "rad",
    scale: float = 1.0,
) -> Axes:
    """Draw the load's error over time, and a tolerance about 0."""
    ax.plot(response.time, response.load_error / scale, color=BLUE, label="command − load")
    if tolerance is not None:
        label = f"tolerance ±{tolerance / scale:.4g} {unit}"
        ax.axhspan(-tolerance / scale, tolerance / scale, color=GREEN, alpha=0.25, label=label)
    ax.legend(loc="best")
    return finish(ax, "Error of the load", "time [s]", f"command − load [{unit}]")


def draw_torque(response: LoopResponse, *, ax: Axes, unit: str = "N m") -> Axes:
    """Draw the torque over time, and its limit where there is one."""
    name = "force" if unit == "N" else "torque"
    digital = response.scene is not None and response.scene.is_digital
    ax.plot(
        response.time,
        response.torque,
        color=ORANGE,
        drawstyle="steps-post" if digital else "default",
        label=f"{name} command",
    )
    limit = inf if response.scene is None else response.scene.axis.torque_limit
    if limit < inf:
        for side, label in ((limit, f"limit ±{limit:.4g} {unit}"), (-limit, None)):
            ax.axhline(side, color=RED, linestyle="--", linewidth=1.0, label=label)
    ax.legend(loc="best")
    return finish(ax, name.capitalize(), "time [s]", f"{name} [{unit}]")
