"""Picture of a loop's response: positions, errors, torque beside its limit, when it sticks."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from ..plant import LoopResponse
from ..shaping.checks import positive
from .style import BLUE, GREEN, GREY, ORANGE, RED, panels_figure, unit_label

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
    tolerance: float | None = None,
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
    tolerance : float, optional
        Of the error, drawn about 0.
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
    if tolerance is not None:
        _draw_tolerance(middle, tolerance / scale, unit)
    below.plot(time, response.torque, color=BLUE, label="asked of the drive")
    if not np.array_equal(response.torque, response.motor_torque):
        below.plot(time, response.motor_torque, color=ORANGE, label="of the motor")
    _show_limits(response, below, torque_unit)
    for ax, label in (
        (above, "position" + unit_label(unit, time_unit, 0)),
        (middle, "error" + unit_label(unit, time_unit, 0)),
        (below, "torque" + unit_label(torque_unit, time_unit, 0)),
    ):
        ax.set_ylabel(label)
        ax.legend(loc="best", fontsize="small")
    below.set_xlabel(f"time [{time_unit}]")
    return drawn


def _show_limits(response: LoopResponse, ax: Axes, unit: str) -> None:
    """Draw the torque's limit, and when the motor sticks in all panels."""
    if response.scene is None:
        return
    _draw_limit(ax, response.scene.axis.torque_limit, unit)
    stuck = response.stick_intervals if response.scene.axis.friction else ()
    for k, (start, end) in enumerate(stuck):
        for panel in ax.figure.axes:
            label = "stuck" if panel is ax and not k else None
            panel.axvspan(start, end, color=GREY, alpha=0.15, linewidth=0.0, label=label)


def _draw_tolerance(ax: Axes, tolerance: float, unit: str) -> None:
    label = f"tolerance ±{tolerance:.4g} {unit}".strip()
    ax.axhspan(-tolerance, tolerance, color=GREEN, alpha=0.25, label=label)


def _draw_limit(ax: Axes, limit: float, unit: str) -> None:
    """Draw a torque limit, if there is one, in both directions."""
    if limit < inf:
        for side, label in ((limit, f"limit ±{limit:.4g} {unit}".strip()), (-limit, None)):
            ax.axhline(side, color=RED, linestyle="--", linewidth=1.0, label=label)
