"""Pictures of describing functions: gain and phase, the lags that fit, a period of motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .style import BLUE, GREY, finish, panels_figure, single_axes, unit_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.frequency_view.describing_functions import DescribingFunction, PeriodicResponse
    from ..analysis.frequency_view.nearest_lag import FirstOrderLag
    from ..analysis.frequency_view.periodic import ComplexArray
    from ..shaping.pieces import FloatArray

    Row = tuple[FloatArray, FloatArray, str]

_SIZE = (8.0, 4.0)  # inches, of a new figure
_LABELS = 8  # of curves in a legend, about


def plot_describing_function(
    describing: DescribingFunction,
    *,
    lag: FirstOrderLag | None = None,
    time_unit: str = "s",
    figure: Figure | None = None,
) -> Axes:
    """Draw gain and phase in a figure, one above the other, and return the upper Axes.

    Parameters
    ----------
    describing : DescribingFunction
        Of shape (…, N): a curve for each row, over frequency, or over amplitude where the
        frequency is constant along the rows.
    lag : FirstOrderLag, optional
        Its lags are drawn dashed.
    time_unit : str, optional
        For the label.
    figure : Figure, optional
        To draw in, made as large as it needs. Default: pyplot's current one if it is empty, else
        a new one of pyplot's.

    Returns
    -------
    Axes
    """
    figure = panels_figure(figure, (8.0, 7.0))
    upper: Axes
    upper, lower = figure.subplots(2, 1, sharex=True)
    plot_describing_gain(describing, ax=upper, lag=lag, time_unit=time_unit)
    plot_describing_phase(describing, ax=lower, lag=lag, time_unit=time_unit)
    upper.set_xlabel("")
    return upper


def plot_describing_gain(
    describing: DescribingFunction,
    *,
    ax: Axes | None = None,
    lag: FirstOrderLag | None = None,
    time_unit: str = "s",
) -> Axes:
    """Draw the gain, |N| in dB, of a describing function over amplitude and frequency.

    Parameters
    ----------
    describing : DescribingFunction
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    lag, time_unit : optional
        As in `plot_describing_function`.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    _draw(describing.gain_db, describing, ax)
    _draw_lags(describing, lag, ax, lambda response: 20.0 * np.log10(np.abs(response)))
    ax.legend(loc="lower left")
    return finish(ax, "Describing function: gain", _xlabel(describing, time_unit), "|N| [dB]")


def plot_describing_phase(
    describing: DescribingFunction,
    *,
    ax: Axes | None = None,
    lag: FirstOrderLag | None = None,
    time_unit: str = "s",
) -> Axes:
    """Draw the phase, arg N in degrees, of a describing function over amplitude and frequency.

    Parameters
    ----------
    describing : DescribingFunction
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    lag, time_unit : optional
        As in `plot_describing_function`.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    _draw(describing.phase_deg, describing, ax)
    _draw_lags(describing, lag, ax, lambda response: np.degrees(np.angle(response)))
    ax.yaxis.set_major_locator(MaxNLocator(steps=[1.5, 3.0, 4.5, 9.0]))
    ax.legend(loc="lower left")
    return finish(ax, "Describing function: phase", _xlabel(describing, time_unit), "phase [deg]")


def plot_periodic_response(
    periodic: PeriodicResponse, *, ax: Axes | None = None, unit: str = "", time_unit: str = "s"
) -> Axes:
    """Draw command, A·sin ωt, and output over one period.

    Parameters
    ----------
    periodic : PeriodicResponse
    ax : Axes, optional
        To draw in. Default: pyplot's current ones.
    unit, time_unit : str, optional
        Of positions and times, for the labels.

    Returns
    -------
    Axes
    """
    ax = single_axes(ax, _SIZE)
    ax.plot(periodic.time, periodic.command, color=GREY, label="command")
    ax.plot(periodic.time, periodic.output, color=BLUE, label="output")
    ax.legend(loc="upper right")
    return finish(
        ax, "One period", f"time [{time_unit}]", "position" + unit_label(unit, time_unit, 0)
    )


def _draw(values: FloatArray, describing: DescribingFunction, ax: Axes) -> None:
    """Draw values over frequency or amplitude, a curve for each row."""
    for (x, y, label), color in zip(_rows(values, describing), _colors(describing), strict=True):
        ax.semilogx(x, y, color=color, label=label, marker="" if len(x) > 1 else "o")


def _draw_lags(
    describing: DescribingFunction,
    lag: FirstOrderLag | None,
    ax: Axes,
    part: Callable[[ComplexArray], FloatArray],
) -> None:
    if lag is None:
        return
    omega = describing.omega.reshape(-1, describing.omega.shape[-1])[0]
    curves = part(lag.response(omega)).reshape(-1, len(omega))
    for y, color in zip(curves, _colors(describing), strict=True):
        ax.semilogx(omega, y, "--", color=color, linewidth=1.0)
    ax.plot([], [], "--", color=GREY, linewidth=1.0, label="first-order lag")


def _over_frequency(describing: DescribingFunction) -> bool:
    """Tell whether frequency changes along the rows, or else amplitude."""
    changes = [
        bool((np.diff(np.atleast_1d(array), axis=-1) != 0.0).any())
        for array in (describing.amplitude, describing.omega)
    ]
    if all(changes):
        raise ValueError(
            "amplitude and frequency both change along the last axis: draw a describing function "
            "of amplitude[:, None] and omega"
        )
    return not changes[0]


def _rows(values: FloatArray, describing: DescribingFunction) -> Iterator[Row]:
    """Return abscissae, values and label of each curve; labels of some, if there are many."""
    over, other, name = describing.omega, describing.amplitude, "A"
    if not _over_frequency(describing):
        over, other, name = other, over, "ω"
    count = over.shape[-1] if over.ndim else 1
    x, y, kept = (array.reshape(-1, count) for array in (over, values, other))
    step = max(1, -(-len(y) // _LABELS))
    for i in range(len(y)):
        yield x[i], y[i], f"{name} = {kept[i, 0]:.4g}" if i % step == 0 else "_"


def _colors(describing: DescribingFunction) -> FloatArray:
    """Return a colour for each curve, in their order."""
    shape = describing.response.shape[:-1]
    return np.asarray(colormaps["viridis"](np.linspace(0.0, 0.85, int(np.prod(shape)))))


def _xlabel(describing: DescribingFunction, time_unit: str) -> str:
    return f"ω [rad/{time_unit}]" if _over_frequency(describing) else "amplitude A"
