"""Pictures of a sweep show all values of a grid, and means where all else varies."""

import itertools

import numpy as np
import xarray
from matplotlib.figure import Figure

from jounce.analysis.sweep_result import SweepResult
from jounce.plots.sweep import plot_scatter_matrix, plot_sweep


def grid() -> SweepResult:
    """Return x + 10·y·z of 20·2·200 points, z = ±1."""
    points = np.array(list(itertools.product(range(20), (-1.0, 1.0), range(200))), dtype=float)
    x, z, y = points.T
    data = xarray.Dataset(
        {"peak": ("point", x + 10.0 * y * z), "done": ("point", x > -1.0)},
        coords={"x": ("point", x), "z": ("point", z), "y": ("point", y)},
        attrs={"figures": ["peak"], "parameters": ["x", "y", "z"], "design": "grid"},
    )
    return SweepResult(data)


def test_no_value_of_a_grid_is_thinned_away():
    figure = plot_scatter_matrix(grid(), figure=Figure())
    for ax, count in zip(figure.axes, (20, 200, 2), strict=True):
        assert len(np.unique(ax.lines[0].get_xdata())) == count


def test_contours_are_of_means_over_all_else():
    figure = plot_sweep(grid(), figure=Figure())
    *_, bar = figure.axes
    assert bar.get_ylabel() == "mean peak"
    assert "conditional means" in figure.axes[1].get_title()
