"""What a figure shows, read back from its curves."""

import numpy as np
from matplotlib.axes import Axes


def curves(ax: Axes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return what is drawn, without straight lines and marks."""
    return [line.get_data() for line in ax.lines if len(line.get_xdata()) > 20]


def peak_of(ax: Axes) -> float:
    """Return the largest magnitude of the only curve."""
    [(_, values)] = curves(ax)
    return float(np.abs(values).max())


def motion(time: np.ndarray, rate: np.ndarray) -> tuple[float, float]:
    """Return the times at which a drawn derivative leaves zero and returns to it."""
    moving = np.flatnonzero(np.abs(rate) > 1e-12 * np.abs(rate).max())
    return float(time[moving[0] - 1]), float(time[moving[-1] + 1])


def switches(ax: Axes) -> list[float]:
    """Return the times at which dotted lines stand."""
    return [float(line.get_xdata()[0]) for line in ax.lines if line.get_linestyle() == ":"]


def words(ax: Axes) -> list[str]:
    """Return the entries of the legend."""
    return [text.get_text() for text in ax.get_legend().get_texts()]
