"""Picture of a search for limits: settling over the bound on jerk and over peak torque."""

from __future__ import annotations

from itertools import cycle
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import GREY, finish, panels_figure

if TYPE_CHECKING:
    from ..analysis import TunedLimits

_MARKERS = ("o", "s", "^", "v", "D", "x")


def plot_tuned_limits(
    result: TunedLimits, *, unit: str = "", time_unit: str = "s", figure: Figure | None = None
) -> Figure:
    """Return a picture of all trials that settled, and of the least settling over each bound.

    Parameters
    ----------
    result : TunedLimits
    unit, time_unit : str, optional
        Of distance and time, for the labels.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.
    """
    figure = panels_figure(figure, (10.0, 4.5))
    over_jerk, over_torque = figure.subplots(1, 2, sharey=True)
    for family, marker in zip(result.families, cycle(_MARKERS), strict=False):
        trials = [t for t in result.trials if t.family == family and t.settling_time < inf]
        if not trials:
            continue
        jerk = np.array([t.jerk for t in trials])
        settled = np.array([t.settling_time for t in trials])
        (dots,) = over_jerk.plot(jerk, settled, marker, ms=3, alpha=0.4)
        least = {j: settled[jerk == j].min() for j in np.unique(jerk)}
        over_jerk.plot(
            list(least), list(least.values()), color=dots.get_color(), lw=1.2, label=family
        )
        front = result.trade_off(family)
        over_torque.plot(
            [t.peak_torque for t in front],
            [t.settling_time for t in front],
            marker + "-",
            color=dots.get_color(),
            ms=3,
            lw=1.2,
        )
    over_jerk.set_xscale("log")
    for ax, place in ((over_jerk, result.best.jerk), (over_torque, result.best.peak_torque)):
        ax.plot([place], [result.settling_time], "*", color="black", ms=10)
        ax.axhline(result.settling_time, color=GREY, linestyle=":", linewidth=0.8)
    over_jerk.legend(loc="best")
    length = unit or "distance"
    finish(
        over_jerk,
        f"Settling to {result.settle_to:.4g} {unit}".rstrip(),
        f"bound on jerk [{length}/{time_unit}³]",
        f"load settled [{time_unit}]",
    )
    finish(over_torque, "Trade-off", "peak torque", "")
    return figure
