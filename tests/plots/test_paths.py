"""Pictures of axes in step: the path with the points that it passes, and all axes over time."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jounce.plots import plot_synchronized, plot_tour
from jounce.shaping import Limits, synchronize, through

LIMITS = Limits(velocity=1.0, acceleration=2.0, jerk=8.0)
POINTS = np.array([[0.0, 0.0], [1.0, 0.2], [1.0, 1.0], [0.2, 1.0]])


def test_a_path_is_drawn_with_its_points_and_their_tolerance():
    path = through(POINTS, LIMITS, corner=0.1)
    figure = plot_synchronized(path, unit="mm", scale=1e-3, figure=Figure())
    FigureCanvasAgg(figure).draw()
    plane, *panels = figure.axes
    assert len(panels) == 4
    curve, crosses = plane.lines
    np.testing.assert_allclose(curve.get_xydata()[[0, -1]], POINTS[[0, -1]] * 1e3, atol=1e-9)
    np.testing.assert_array_equal(crosses.get_xydata(), POINTS * 1e3)
    assert [circle.radius for circle in plane.patches] == [100.0, 100.0]
    assert plane.get_xlabel() == "axis 0 [mm]"
    assert panels[1].get_ylabel() == "velocity\n[mm/s]"
    times = [line.get_xdata()[0] for line in panels[2].lines[2:]]
    np.testing.assert_array_equal(times, path.times)
    assert [text.get_text() for text in panels[0].get_legend().get_texts()] == ["axis 0", "axis 1"]


def test_axes_in_step_without_points_and_one_alone_are_drawn():
    pair = synchronize([(0.0, 1.0, LIMITS), (0.0, 2.0, LIMITS)])
    plane, *panels = pair.plot().axes
    assert len(plane.lines) == 1
    assert len(panels[0].lines) == 2
    alone = synchronize([(0.0, 1.0, LIMITS)]).plot()
    assert len(alone.axes) == 4


def test_a_tour_is_drawn_with_its_points():
    tour = through([0.0, 1.0, 0.5], LIMITS)
    figure = plot_tour(tour, unit="mm", scale=1e-3, figure=Figure())
    np.testing.assert_array_equal(figure.axes[0].lines[-1].get_ydata(), [0.0, 1e3, 5e2])
    assert len(tour.plot().axes) == 4


@pytest.mark.parametrize("scale", [0.0, -1.0])
def test_scales_are_positive(scale):
    with pytest.raises(ValueError, match="scale = "):
        plot_synchronized(through(POINTS, LIMITS), scale=scale, figure=Figure())
