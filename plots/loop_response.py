"""Picture of a loop's response: positions, errors, torque beside its limit, when it sticks."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from ..plant import LoopResponse
from ..shaping.checks import positive
from .style import BLUE, GREY, ORANGE, RED, panels_figure, unit_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE = (8.0, 6.5)  # inches


def plot_loop_response(
    response: LoopResponse,
    *,
    unit: str = "",
    torque_unit: str = "",
    time_unit: str = "s",
    scale: float = 1.0,
    figure: Figure | None = None,
) -> Figure:
    """Return a picture of a response: positions, errors and torque, one panel each.

    Grey bands show when the motor sticks, dashed lines the torque's limit; the load is drawn where
    it is not the motor.

    Parameters
    ----------
    response : LoopResponse
    unit, torque_unit, time_unit : str, optional
        For the labels.
    scale : float, optional
        Response's units of position per `unit`, positive.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure
    """
    scale = positive("scale", scale)
    drawn = panels_figure(figure, _SIZE)
    above, middle, below = drawn.subplots(3, 1, sharex=True)
    time, flexible = response.time, bool(np.any(response.twist))
    above.plot(time, response.command / scale, color=GREY, linestyle="--", label="command")
    above.plot(time, response.position / scale, color=BLUE, label="measured")
    middle.plot(time, response.error / scale, color=BLUE, label="measured")
    if flexible:
        above.plot(time, response.load / scale, color=ORANGE, label="load")
        middle.plot(time, response.load_error / scale, color=ORANGE, label="load")
    below.plot(time, response.torque, color=BLUE, label="asked of the drive")
    if not np.array_equal(response.torque, response.motor_torque):
        below.plot(time, response.motor_torque, color=ORANGE, label="of the motor")
    _show_limits(response, below)
    for ax, label in (
        (above, "position" + unit_label(unit, time_unit, 0)),
        (middle, "error" + unit_label(unit, time_unit, 0)),
        (below, "torque" + unit_label(torque_unit, time_unit, 0)),
    ):
        ax.set_ylabel(label)
        ax.legend(loc="best", fontsize="small")
    below.set_xlabel(f"time [{time_unit}]")
    return drawn


def _show_limits(response: LoopResponse, ax: Axes) -> None:
    """Draw the torque's limit, and when the motor sticks in all panels."""
    if response.scene is None:
        return
    limit = response.scene.axis.torque_limit
    if limit < inf:
        for side in (limit, -limit):
            ax.axhline(side, color=RED, linestyle="--", linewidth=0.8)
    for start, end in response.stick_intervals if response.scene.axis.friction else ():
        for panel in ax.figure.axes:
            panel.axvspan(start, end, color=GREY, alpha=0.15, linewidth=0.0)
