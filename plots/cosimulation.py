"""Picture of a co-simulation: its signals against time, one panel each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from .style import BLUE, GREY, ORANGE, panels_figure, plain

if TYPE_CHECKING:
    from ..fmu.cosimulation.cosimulation_result import CosimulationResult

_MAX_PANELS = 40


def plot_cosimulation(
    result: CosimulationResult,
    signals: Sequence[str | Sequence[str]] | None = None,
    *,
    time_unit: str = "s",
    figure: Figure | None = None,
) -> Figure:
    """Return a picture of a co-simulation: one panel per signal, or per group of signals.

    Inputs are drawn as steps, since they are held from one communication point to the next;
    outputs, which are known at the communication points only, as lines between them.

    Parameters
    ----------
    result : CosimulationResult
    signals : sequence of str, or of sequences of str, optional
        Names "block.signal"; those grouped share a panel. Default: every output.
    time_unit : str, optional
        For the label.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For names that the result does not have, or more than 40 panels.
    """
    chosen = result.outputs if signals is None else signals
    panels = [[name] if isinstance(name, str) else list(name) for name in chosen]
    if not 1 <= len(panels) <= _MAX_PANELS:
        raise ValueError(
            f"{len(panels)} panels: expected 1 to {_MAX_PANELS}; choose signals=…, as in "
            "[['plant.y', 'move.position'], 'controller.u']"
        )
    columns = [[result[name] for name in names] for names in panels]
    figure = panels_figure(figure, (8.0, 1.5 * len(panels) + 1.0))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, names, values in zip(axes, panels, columns, strict=True):
        for name, value, color in zip(names, values, _colors(len(names)), strict=True):
            held = "steps-post" if name not in result.outputs else "default"
            ax.plot(result.time, value, color=color, drawstyle=held, label=plain(name))
        ax.grid(alpha=0.3)
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8, frameon=False)
    axes[-1].set_xlabel(f"time [{time_unit}]")
    figure.suptitle(f"co-simulation, {_how(result)}", fontsize=11)
    return figure


def _colors(count: int) -> list[str]:
    own = [BLUE, ORANGE, GREY]
    return [own[i] if i < len(own) else f"C{i}" for i in range(count)]


def _how(result: CosimulationResult) -> str:
    if result.method == "jacobi":
        return "all blocks at once (Jacobi)"
    return plain(f"{', then '.join(result.order)} (Gauss–Seidel)")
